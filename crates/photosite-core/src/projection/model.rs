//! The interface of lens models.

use glam::{DVec2, DVec3};

use super::{CalibrationModel, Reach};

/// A direction, and the solid angle per image area there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Unit direction.
    pub direction: DVec3,
    /// Vector from the centre of the lens to the point in focus, in units of the focus distance: to a plane across the
    /// axis where the projection [is flat](super::Projection::is_flat), to a sphere elsewhere.
    pub chief: DVec3,
    /// Solid angle over area in normalised coordinates dΩ/dA, sr: cos³θ for a rectilinear lens.
    pub solid_angle: f64,
}

impl Seen {
    /// A direction seen by a lens that is focused on a sphere.
    #[inline]
    pub(super) fn all_round(direction: DVec3, solid_angle: f64) -> Self {
        Self { direction, chief: direction, solid_angle }
    }
}

/// Methods of a lens model, documented in [`Projection`](super::Projection).
pub(super) trait Model {
    /// Whether the lens is focused on a plane.
    const IS_FLAT: bool;

    fn name(&self) -> &'static str;
    fn coefficients(&self) -> Vec<f64>;
    /// Mirror parameter ξ of models that have one.
    fn xi(&self) -> Option<f64> {
        None
    }
    fn calibration_model(&self) -> Option<CalibrationModel>;
    /// Range of angles from the axis in which the model is one to one.
    fn reach(&self) -> Reach;
    /// Place in the image of a direction of any length within the reach.
    fn project(&self, direction: DVec3, reach: &Reach) -> Option<DVec2>;
    /// Direction and solid angle seen by a place. The caller checks the reach's angle, the model its radius where
    /// needed.
    fn unproject(&self, place: DVec2, reach: &Reach) -> Option<Seen>;
}
