//! Rectilinear lenses: (x, y) = (X, Y)/Z, without distortion and with that of [`BrownConrady`].

use glam::{DVec2, DVec3};

use super::model::{Model, Seen};
use super::reach::{FLAT_ANGLE, Reach, ReachEnd};
use super::{BrownConrady, CalibrationModel};

/// The model without distortion.
pub(super) struct Perspective;

impl Model for Perspective {
    const IS_FLAT: bool = true;

    fn name(&self) -> &'static str {
        "perspective"
    }

    fn coefficients(&self) -> Vec<f64> {
        vec![0.0; 5]
    }

    fn calibration_model(&self) -> Option<CalibrationModel> {
        Some(CalibrationModel::Pinhole)
    }

    fn reach(&self) -> Reach {
        flat_reach(FLAT_ANGLE.tan(), ReachEnd::Flat)
    }

    #[inline]
    fn project(&self, direction: DVec3, _: &Reach) -> Option<DVec2> {
        Some(on_plane(direction))
    }

    #[inline]
    fn unproject(&self, place: DVec2, _: &Reach) -> Option<Seen> {
        Some(through_plane(place, 1.0))
    }
}

impl Model for BrownConrady {
    const IS_FLAT: bool = true;

    fn name(&self) -> &'static str {
        "brown-conrady"
    }

    fn coefficients(&self) -> Vec<f64> {
        let Self { k: [k1, k2, k3, k4, k5, k6], p: [p1, p2], s } = *self;
        let all = [&[k1, k2, p1, p2, k3, k4, k5, k6], s.as_slice()].concat();
        let last = all.iter().rposition(|c| *c != 0.0).map_or(0, |i| i + 1);
        let count = if last > 8 {
            12
        } else if last > 5 {
            8
        } else {
            5
        };
        all[..count].to_vec()
    }

    fn calibration_model(&self) -> Option<CalibrationModel> {
        Some(CalibrationModel::BrownConrady(*self))
    }

    fn reach(&self) -> Reach {
        match self.fold() {
            Some(radius) => flat_reach(radius, ReachEnd::Folds),
            None => flat_reach(FLAT_ANGLE.tan(), ReachEnd::Flat),
        }
    }

    #[inline]
    fn project(&self, direction: DVec3, _: &Reach) -> Option<DVec2> {
        Some(self.distort(on_plane(direction)))
    }

    #[inline]
    fn unproject(&self, place: DVec2, reach: &Reach) -> Option<Seen> {
        let (ideal, growth) = self.undistort(place, reach.radius)?;
        Some(through_plane(ideal, 1.0 / growth))
    }
}

/// Intersection of a direction with the plane z = 1.
#[inline]
pub(super) fn on_plane(direction: DVec3) -> DVec2 {
    DVec2::new(direction.x, direction.y) / direction.z
}

/// A reach that ends at a radius of the ideal image.
pub(super) fn flat_reach(radius: f64, end: ReachEnd) -> Reach {
    Reach::new(radius.atan(), end, radius)
}

/// Direction and solid angle seen through the point `ideal` of the plane z = 1 by a lens that is focused on a plane,
/// where the ideal image has `growth` times the area of the sensor: dΩ = cos³θ·dA.
#[inline(always)]
pub fn through_plane(ideal: DVec2, growth: f64) -> Seen {
    let cos = 1.0 / (1.0 + ideal.length_squared()).sqrt();
    let chief = ideal.extend(1.0);
    Seen { direction: chief * cos, chief, solid_angle: cos * cos * cos * growth }
}
