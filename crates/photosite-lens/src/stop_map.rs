//! Clipping of the pupil by the blades of a stop, as seen from a sensor point.
//!
//! A round stop is symmetrical about every line of sight; one with blades is not, and its visible part depends on the
//! azimuth of the sensor point. The rays of the round outline are therefore traced to the stop once, at some radii in
//! each of 128 directions, and cut there by the polygon as it lies to each azimuth.

use std::f64::consts::TAU;

use glam::DVec2;

use crate::lens::Lens;
use crate::outline::{MARGIN, Outline};
use crate::profile::Travel;
use crate::trace::{Apertures, LensAt, Step};

/// Number of radii at which rays are traced to the stop.
const RADII: usize = 8;

/// Points at which the rays of a sensor point (0, h) meet the stop, mm from the axis.
pub(crate) struct StopMap {
    /// Points by wavelength and direction, as far as there are such rays: from the centre outwards.
    places: Vec<Vec<DVec2>>,
    outline: Outline,
}

impl StopMap {
    /// Traces the rays of the outline of a round stop, seen at an image height in mm, to the stop.
    pub(crate) fn new(at: &[LensAt<'_>], height_mm: f64, outline: &Outline) -> Self {
        let point = DVec2::new(0.0, height_mm);
        let along = |at: &LensAt<'_>, direction: usize| {
            let (angle, radius) = outline.boundary(direction);
            let to = DVec2::from_angle(angle) * radius;
            let cosines = |i: usize| DVec2::new(0.0, outline.centre) + to * (i as f64 / RADII as f64);
            (0..=RADII).map_while(|i| at.stop_place(point, cosines(i))).collect()
        };
        let places = at.iter().flat_map(|at| (0..Outline::DIRECTIONS).map(|direction| along(at, direction))).collect();
        Self { places, outline: outline.clone() }
    }

    /// Outline of the rays that pass the blades of a lens at any wavelength, for a sensor point that is turned by an
    /// angle in rad from the y axis.
    pub(crate) fn cut(&self, lens: &Lens, turned_rad: f64) -> Outline {
        let Some((normals, apothem)) = lens.stop_edges() else { return self.outline.clone() };
        let back = DVec2::from_angle(-turned_rad);
        let normals: Vec<DVec2> = normals.iter().map(|normal| back.rotate(*normal)).collect();
        // How far a place is beyond the nearest blade
        let beyond =
            |place: &DVec2| normals.iter().map(|normal| normal.dot(*place) - apothem).fold(f64::NEG_INFINITY, f64::max);
        let mut radii = vec![0.0_f64; Outline::DIRECTIONS];
        for (i, places) in self.places.iter().enumerate() {
            let direction = i % Outline::DIRECTIONS;
            let (_, radius) = self.outline.boundary(direction);
            let beyond: Vec<f64> = places.iter().map(beyond).collect();
            let Some(last) = beyond.iter().rposition(|beyond| *beyond <= 0.0) else { continue };
            let part = match beyond.get(last + 1) {
                Some(next) => beyond[last] / (beyond[last] - next),
                // The last ray before those that miss a surface
                None => f64::from(u8::from(last < RADII)),
            };
            radii[direction] = radii[direction].max(radius * (last as f64 + part) / RADII as f64);
        }
        // Corners of the polygon reach farther than their neighbours, seen from the middle between two directions, of few
        // blades by more than the margin.
        let corner = (0.5 * TAU / Outline::DIRECTIONS as f64).sin() * (0.5 * TAU / normals.len() as f64).tan();
        self.outline.within(&radii, ((1.0 + corner) / MARGIN).max(1.0))
    }
}

impl LensAt<'_> {
    /// Point at which the ray from a sensor point with some direction cosines meets the stop, mm from the axis,
    /// regardless of apertures.
    fn stop_place(&self, point: DVec2, cosines: DVec2) -> Option<DVec2> {
        if cosines.length_squared() >= 1.0 {
            return None;
        }
        let steps = (self.lens.stop()..self.lens.surfaces().len()).rev().map(Step::refract);
        let mut place = None;
        // A ray that the stop's own surface reflects totally has come there.
        let _ = self.trace(self.ray_from_sensor(point, cosines), Travel::ToScene, steps, Apertures::Ignore, |hit| {
            if hit.surface == self.lens.stop() {
                place = Some(hit.point.truncate());
            }
        });
        place
    }
}
