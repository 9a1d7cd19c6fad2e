//! Illumination of the image: its loss of light towards the corners.

use glam::DVec2;

use super::Camera;
use super::ray::towards;
use crate::optics::Seen;
use crate::optics::prescribed::PrescribedLens;

/// Image that is larger than the image circle of its lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeyondImageCircle {
    /// Part of the pixels that could see light but get none, 0 to 1.
    pub dark_part: f64,
    /// Largest distance from the axis at which light comes to the sensor, m.
    pub lit_m: f64,
    /// Distance of the corners of the image from the axis, m.
    pub corner_m: f64,
}

impl Camera {
    /// Whether light comes to the pixel of a position: within the image circle of the sensor, and of a lens from a
    /// prescription. Stops before or behind the lens are not asked; [`is_lit`](Self::is_lit) asks them.
    pub fn sees_light(&self, pixel: DVec2) -> bool {
        let reaches = |lens: &PrescribedLens| self.sensor_mm(pixel).length() <= lens.lit_mm();
        self.cells.sees_light(pixel) && self.prescribed.as_deref().is_none_or(reaches)
    }

    /// Whether light comes to a pixel position, with all that may keep it away: the image circle of the sensor, the
    /// reach and the rims of the lens, or stops.
    pub fn is_lit(&self, pixel: DVec2) -> bool {
        let passes_stops = || self.relative_illumination(pixel).is_some_and(|part| part > 0.0);
        self.sees_light(pixel) && (self.stops.is_empty() || passes_stops())
    }

    /// Part of the image that lies beyond the image circle of a prescription. `None` where nothing does, and for other
    /// lenses, which have none.
    pub fn beyond_image_circle(&self) -> Option<BeyondImageCircle> {
        let lit_mm = self.prescribed.as_ref()?.lit_mm();
        let corner_mm = self.sensor_mm(DVec2::ZERO).length();
        if lit_mm >= corner_mm {
            return None;
        }
        let [columns, rows] = self.resolution;
        let (mut dark, mut all) = (0_u64, 0_u64);
        for cell in (0..rows).flat_map(|row| (0..columns).map(move |column| [column as usize, row as usize])) {
            let centre = self.cells.centre(cell);
            let sees_light = self.cells.sees_light(centre);
            all += u64::from(sees_light);
            dark += u64::from(sees_light && self.sensor_mm(centre).length() > lit_mm);
        }
        let dark_part = dark as f64 / all as f64;
        (dark > 0).then_some(BeyondImageCircle { dark_part, lit_m: lit_mm * 1e-3, corner_m: corner_mm * 1e-3 })
    }

    /// Irradiance at a pixel position over that on the axis, under even light. `None` where the position sees nothing.
    pub fn relative_illumination(&self, pixel: DVec2) -> Option<f64> {
        if let Some(lens) = &self.prescribed {
            let middle = lens.illumination_sr(0.0);
            return Some(lens.illumination_sr(self.sensor_mm(pixel).length()) / middle);
        }
        if !self.makes_image() {
            return Some(1.0);
        }
        // The integrand is smooth: 16 × 16 cells leave an error below 1e-4 even at f/1. The edge of a stop crosses some
        // 4·128 of 128² cells, each right to a half of itself at random: 1e-3.
        let cells: u16 = if self.stops.is_empty() { 16 } else { 128 };
        let mean = |seen: &Seen| -> f64 {
            let centre = |i: u16| (f32::from(i) + 0.5) / f32::from(cells);
            let through = |i: u16| {
                let opening = self.opening([centre(i % cells), centre(i / cells)]);
                let towards = towards(seen.chief, self.in_pupil(opening, seen), self.focus_distance_m);
                if self.passes(seen.chief, opening, towards) { self.falloff_at(seen, opening) } else { 0.0 }
            };
            (0..cells * cells).map(through).sum()
        };
        Some(mean(&self.seen(pixel)?) / mean(&self.seen_at(DVec2::ZERO)?))
    }
}
