//! What a model of a lens has to say.

use glam::{DVec2, DVec3};

use super::{CalibrationModel, Reach};

/// A direction and how much of space a piece of the picture sees there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Unit direction.
    pub direction: DVec3,
    /// From the centre of the lens to what is in focus, in units of the focus distance: to a plane across the axis
    /// where the projection [is flat](super::Projection::is_flat), to a sphere elsewhere.
    pub chief: DVec3,
    /// Solid angle over area in normalised coordinates dΩ/dA, sr: cos³θ for a rectilinear lens.
    pub solid_angle: f64,
}

impl Seen {
    /// By a lens that is focused on a sphere.
    #[inline]
    pub(super) fn all_round(direction: DVec3, solid_angle: f64) -> Self {
        Self { direction, chief: direction, solid_angle }
    }
}

/// What a model of a lens says of itself. [`Projection`](super::Projection) has the same methods, documented there.
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
    /// How far the model is one to one.
    fn reach(&self) -> Reach;
    /// Where a direction of any length within the reach appears.
    fn project(&self, direction: DVec3, reach: &Reach) -> Option<DVec2>;
    /// What a place sees. The reach's angle is checked by the caller, its radius by the model where it needs one.
    fn unproject(&self, place: DVec2, reach: &Reach) -> Option<Seen>;
}
