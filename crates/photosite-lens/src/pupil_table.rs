//! Sampling of directions from sensor points into the lens so that most of them pass.
//!
//! In direction cosines (p, q) the weight of a uniformly drawn direction is the area of the region that it is drawn
//! from, and nothing else (see [`illumination`](crate::illumination)). The table holds a polygon for each of many image
//! heights that contains the region S of all directions that pass, for all wavelengths, and little more; for a stop
//! with blades, also for each of many azimuths.

use std::f64::consts::TAU;

use glam::DVec2;

use crate::lens::Lens;
use crate::outline::{Outline, Polygon};
use crate::stop_map::StopMap;
use crate::trace::LensAt;

/// Number of image heights, from the axis to the corner, at which S is determined.
const ROWS: usize = 65;
/// Number of directions of the first, coarse boundary of a region.
const FIRST_DIRECTIONS: usize = 16;
/// Number of bins of the image height, each with a polygon.
const BINS: usize = 512;
/// Number of bins of the image height, and of the azimuth over a whole turn, for a stop with blades.
const BINS_OF_BLADES: usize = 256;
const AZIMUTHS: u32 = 128;
/// Number of bisections between an image height that light reaches and one that it does not.
const HALVINGS: u32 = 6;

/// Pupil as seen by the sensor, by image height.
#[derive(Clone, Debug)]
pub struct PupilTable {
    /// Polygons by height and azimuth.
    bins: Vec<Polygon>,
    bins_per_mm: f64,
    /// Number of blades of the stop, 0 for a round one, and number of azimuths from one blade to the next.
    blades: u32,
    azimuths: usize,
    lit_mm: f64,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Direction cosines p, q; the ray goes out into the scene, towards −z.
    pub cosines: DVec2,
    /// Area of the region that the direction was drawn from, sr: the weight of a ray that passes.
    pub area: f64,
}

impl PupilTable {
    /// Table of a lens for image heights up to one in mm and wavelengths in nm, of which the middle one determines the
    /// centres.
    pub fn new(with_blades: &Lens, highest_mm: f64, wavelengths_nm: &[f64]) -> Self {
        let lens = with_blades.with_round_stop();
        let height = |row: f64| highest_mm * row / (ROWS - 1) as f64;
        let row = |i: f64| outline(&lens, height(i), wavelengths_nm);
        let mut rows: Vec<Option<Outline>> = (0..ROWS).map(|i| row(i as f64)).collect();
        let lit_mm = image_circle(&lens, &rows, height, wavelengths_nm);
        // At heights that no light reaches, as at the last one that some does: in between the region shrinks.
        let mut last = None;
        for row in &mut rows {
            match row {
                Some(row) => last = Some(row.clone()),
                None => *row = last.take(),
            }
        }
        for i in 0..ROWS - 1 {
            let middle = row(i as f64 + 0.5);
            let [low, high] = &mut rows[i..=i + 1] else { continue };
            if let (Some(low), Some(high), Some(middle)) = (low, high, middle) {
                Outline::widen_to(&mut [low, high], &middle);
            }
        }
        let blades = with_blades.stop_edges().map_or(0, |(normals, _)| normals.len() as u32);
        let (count, azimuths) =
            if blades == 0 { (BINS, 1) } else { (BINS_OF_BLADES, AZIMUTHS.div_ceil(blades) as usize) };
        let of_blades = |rows: &[Option<Outline>]| cut_by_blades(with_blades, rows, height, wavelengths_nm, azimuths);
        let of_azimuths = if blades == 0 { vec![rows] } else { of_blades(&rows) };
        let polygon = |number: usize| {
            let rows = &of_azimuths[number % azimuths];
            let at = |height: f64| {
                let row = height * (ROWS - 1) as f64;
                let i = (row as usize).min(ROWS - 2);
                Some(Outline::between(rows[i].as_ref()?, rows[i + 1].as_ref()?, row - i as f64))
            };
            let bin = number / azimuths;
            let [low, high] = [bin, bin + 1].map(|i| at(i as f64 / count as f64));
            Polygon::new(&low?, &high?)
        };
        let bins = (0..count * azimuths).map(|number| polygon(number).unwrap_or_else(Polygon::empty)).collect();
        Self { bins, bins_per_mm: count as f64 / highest_mm, blades, azimuths, lit_mm }
    }

    /// Largest image height that light reaches, mm, to a thousandth of the table's largest; the latter where light
    /// reaches all of it.
    pub fn lit_mm(&self) -> f64 {
        self.lit_mm
    }

    /// Draws a direction for a sensor point, mm from the axis; `None` where no light reaches.
    pub fn sample(&self, point: DVec2, u: [f64; 2]) -> Option<Direction> {
        let polygon = self.polygon(point);
        let area = polygon.area();
        (area > 0.0).then(|| Direction { cosines: rotation(point).rotate(polygon.sample(u)), area })
    }

    /// Area of the region that directions are drawn from at a sensor point, sr; 0 where no light reaches it.
    pub fn area(&self, point: DVec2) -> f64 {
        self.polygon(point).area()
    }

    /// Whether a direction may be drawn at a sensor point.
    pub fn contains(&self, point: DVec2, cosines: DVec2) -> bool {
        let DVec2 { x, y } = rotation(point);
        self.polygon(point).contains(DVec2::new(x, -y).rotate(cosines))
    }

    fn polygon(&self, point: DVec2) -> &Polygon {
        let last = self.bins.len() / self.azimuths - 1;
        let height = ((point.length() * self.bins_per_mm) as usize).min(last);
        &self.bins[height * self.azimuths + self.azimuth(point)]
    }

    /// Bin of the azimuth of a point, from the y axis.
    fn azimuth(&self, point: DVec2) -> usize {
        if self.blades == 0 {
            return 0;
        }
        let DVec2 { x, y } = rotation(point);
        let blades = f64::from(self.blades) * (y.atan2(x) / TAU + 1.0);
        ((blades.fract() * self.azimuths as f64) as usize).min(self.azimuths - 1)
    }
}

/// Outlines of a round stop cut by the blades, by azimuth from one blade to the next.
fn cut_by_blades(
    lens: &Lens,
    rows: &[Option<Outline>],
    height: impl Fn(f64) -> f64,
    wavelengths_nm: &[f64],
    azimuths: usize,
) -> Vec<Vec<Option<Outline>>> {
    let at: Vec<LensAt<'_>> = wavelengths_nm.iter().map(|nm| lens.at(*nm)).collect();
    let blade_rad = TAU / lens.stop_edges().map_or(1, |(normals, _)| normals.len()) as f64;
    let mut of_azimuths = vec![Vec::with_capacity(rows.len()); azimuths];
    for (i, row) in rows.iter().enumerate() {
        let map = row.as_ref().map(|row| StopMap::new(&at, height(i as f64), row));
        for (azimuth, rows) in of_azimuths.iter_mut().enumerate() {
            // At both of its ends and in the middle
            let cut = |map: &StopMap| {
                let turned = |part: f64| blade_rad * (azimuth as f64 + part) / azimuths as f64;
                Outline::union(&[0.0, 0.5, 1.0].map(|part| map.cut(lens, turned(part))))
            };
            rows.push(map.as_ref().and_then(cut));
        }
    }
    of_azimuths
}

/// Radius of the image circle, mm: by bisection between the last row that light reaches and the next one.
fn image_circle(lens: &Lens, rows: &[Option<Outline>], height: impl Fn(f64) -> f64, wavelengths_nm: &[f64]) -> f64 {
    let Some(last) = rows.iter().rposition(Option::is_some) else { return 0.0 };
    if last + 1 == rows.len() {
        return height(last as f64);
    }
    let middle = lens.at(wavelengths_nm[wavelengths_nm.len() / 2]);
    let (mut lit, mut dark) = (last as f64, last as f64 + 1.0);
    for _ in 0..HALVINGS {
        let half = 0.5 * (lit + dark);
        if middle.pupil_region(height(half), FIRST_DIRECTIONS).is_some() { lit = half } else { dark = half }
    }
    height(lit)
}

/// Rotation, as a complex number, that turns the y axis to a point.
pub(crate) fn rotation(point: DVec2) -> DVec2 {
    let height = point.length();
    if height > 0.0 { DVec2::new(point.y, -point.x) / height } else { DVec2::X }
}

/// Outline of the directions that pass at an image height, at any of the wavelengths; `None` where none does.
fn outline(lens: &Lens, height_mm: f64, wavelengths_nm: &[f64]) -> Option<Outline> {
    let at: Vec<LensAt<'_>> = wavelengths_nm.iter().map(|nm| lens.at(*nm)).collect();
    let region = at[at.len() / 2].pupil_region(height_mm, FIRST_DIRECTIONS)?;
    let centre = DVec2::new(0.0, region.centre.y);
    let farthest = region.farthest();
    // What lies farther out between those directions, and at other wavelengths, is little.
    let circle = (centre, 1.5 * (farthest + region.centre.x.abs()));
    let point = DVec2::new(0.0, height_mm);
    Some(Outline::of(|wavelength, cosines| at[wavelength].passes(point, cosines), at.len(), centre.y, circle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_turn_with_the_point() {
        let turned = rotation(DVec2::new(-2.0, 0.0)).rotate(DVec2::Y);
        assert!(turned.distance(DVec2::NEG_X) < 1e-15, "{turned}");
        assert_eq!(rotation(DVec2::new(0.0, 3.0)).rotate(DVec2::Y), DVec2::Y);
    }
}
