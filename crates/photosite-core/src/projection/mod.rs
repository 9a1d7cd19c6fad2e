//! Projections: directions to places in the image, and back. A sensor position is taken to its direction before a ray
//! is made, so nothing is resampled and the corners are filled.
//!
//! Directions are in OpenCV's camera space: x right, y down, z forward. Places are normalised image coordinates, which
//! the pinhole matrix turns into pixels: x = (column − cx − skew·y)/fx, y = (row − cy)/fy.
//!
//! | model | maps | exact where | module |
//! |---|---|---|---|
//! | perspective | (X, Y)/Z | Z > 0 | `perspective.rs` |
//! | Brown–Conrady, rational, thin prism | ideal → distorted | up to its first fold | `brown_conrady.rs` |
//! | polynomial | distorted → ideal | up to its first fold | `polynomial.rs` |
//! | division | distorted → ideal | up to its first fold, or Z > 0 | `division.rs` |
//! | Kannala–Brandt | angle → radius | up to its first fold, or everywhere | `kannala_brandt.rs` |
//! | equisolid, stereographic, orthographic | angle → radius | everywhere, orthographic Z ≥ 0 | `classical_fisheye.rs` |
//! | equirectangular | longitude, latitude | everywhere | `equirectangular.rs` |
//! | omnidirectional | a sphere, then a pinhole | what its mirror shows | `omnidirectional.rs` |
//!
//! A model is used within its [`Reach`] only, in which it is one to one; both directions agree there to the precision
//! of f64.

mod brown_conrady;
mod calibration_model;
mod classical_fisheye;
mod division;
mod equirectangular;
mod intrinsics;
mod kannala_brandt;
mod model;
mod omnidirectional;
mod perspective;
mod polynomial;
mod reach;
mod rising;

#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use division::Division;
use equirectangular::Equirectangular;
use kannala_brandt::KannalaBrandt;
use model::Model;
use omnidirectional::Omnidirectional;
use perspective::Perspective;
use polynomial::Polynomial;

pub use brown_conrady::BrownConrady;
pub use calibration_model::CalibrationModel;
pub use classical_fisheye::FisheyeProjection;
pub use intrinsics::Intrinsics;
pub use model::Seen;
pub use perspective::through_plane;
pub use reach::{Reach, ReachEnd};

/// A lens model: the map from directions to places in the image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Projection {
    /// A rectilinear lens: (x, y) = (X, Y)/Z.
    Perspective,
    /// A rectilinear lens with the distortion of OpenCV's standard model.
    BrownConrady(BrownConrady),
    /// A rectilinear lens whose distortion is given from the distorted to the ideal image:
    /// u = u_d·(1 + k₁r² + k₂r⁴) with r = |u_d|.
    Polynomial {
        /// k₁, k₂.
        k: [f64; 2],
    },
    /// The division model ([Fitzgibbon01](crate::references#fitzgibbon01)): u = u_d/(1 + λr²) with r = |u_d|.
    Division {
        /// λ; below 0 for a barrel.
        lambda: f64,
    },
    /// A fisheye, OpenCV's `fisheye` ([KannalaBrandt06](crate::references#kannalabrandt06)): the radius is
    /// θ + k₁θ³ + k₂θ⁵ + k₃θ⁷ + k₄θ⁹ for an angle θ from the axis.
    KannalaBrandt {
        /// k₁ … k₄.
        k: [f64; 4],
    },
    /// A fisheye with a classical projection other than r = θ, which is Kannala and Brandt's without coefficients.
    ClassicalFisheye(FisheyeProjection),
    /// An equirectangular panorama: longitude and latitude in radians.
    Equirectangular,
    /// The unified model of mirrors and fisheyes, OpenCV's `omnidir` ([MeiRives07](crate::references#meirives07)):
    /// (X, Y)/(Z + ξ) of the unit direction, then Brown and Conrady's distortion.
    Omnidirectional {
        /// ξ ≥ 0: 0 for a pinhole, 1 for a parabolic mirror.
        xi: f64,
        /// The distortion, of which OpenCV has k₁, k₂, p₁ and p₂.
        distortion: BrownConrady,
    },
}

/// The value of an expression in which `$model` is the `Model` of a projection: the only place that tells models apart.
macro_rules! each_model {
    ($projection:expr, $model:ident => $value:expr) => {
        match $projection {
            Projection::Perspective => each_model!(@ Perspective, $model => $value),
            Projection::BrownConrady(distortion) => each_model!(@ *distortion, $model => $value),
            Projection::Polynomial { k } => each_model!(@ Polynomial(*k), $model => $value),
            Projection::Division { lambda } => each_model!(@ Division(*lambda), $model => $value),
            Projection::KannalaBrandt { k } => each_model!(@ KannalaBrandt(*k), $model => $value),
            Projection::ClassicalFisheye(law) => each_model!(@ *law, $model => $value),
            Projection::Equirectangular => each_model!(@ Equirectangular, $model => $value),
            Projection::Omnidirectional { xi, distortion } => {
                each_model!(@ Omnidirectional { xi: *xi, distortion }, $model => $value)
            }
        }
    };
    (@ $made:expr, $model:ident => $value:expr) => {{
        let $model = &$made;
        $value
    }};
}

/// Whether a model's lens is focused on a plane.
#[inline]
fn is_flat<M: Model>(_: &M) -> bool {
    M::IS_FLAT
}

impl Projection {
    /// Name in capture files: that of the distortion model, or of the projection where there is no distortion.
    pub fn name(&self) -> &'static str {
        each_model!(self, model => model.name())
    }

    /// The coefficients in OpenCV's order, without trailing zeros that the model may omit: k₁ k₂ p₁ p₂ k₃, then k₄ k₅
    /// k₆, then s₁ … s₄; k₁ … k₄ of a fisheye; k₁ k₂ p₁ p₂ of an omnidirectional lens. Models that OpenCV lacks have an
    /// order of their own.
    pub fn coefficients(&self) -> Vec<f64> {
        each_model!(self, model => model.coefficients())
    }

    /// Mirror parameter ξ of an omnidirectional lens; `None` of others.
    pub fn xi(&self) -> Option<f64> {
        each_model!(self, model => model.xi())
    }

    /// The model of that [`name`](Self::name) with those [`coefficients`](Self::coefficients); `xi` is the mirror
    /// parameter of an omnidirectional lens. `None` where there is no such model.
    pub fn named(name: &str, coefficients: &[f64], xi: Option<f64>) -> Option<Self> {
        let c = |i: usize| coefficients.get(i).copied().unwrap_or(0.0);
        let k = std::array::from_fn(|i| c([0, 1, 4, 5, 6, 7][i]));
        let distortion = BrownConrady { k, p: [c(2), c(3)], s: std::array::from_fn(|i| c(8 + i)) };
        match (name, xi) {
            ("perspective", None) => Some(Self::Perspective),
            ("brown-conrady", None) => Some(Self::BrownConrady(distortion)),
            ("polynomial", None) => Some(Self::Polynomial { k: std::array::from_fn(c) }),
            ("division", None) => Some(Self::Division { lambda: c(0) }),
            ("kannala-brandt", None) => Some(Self::KannalaBrandt { k: std::array::from_fn(c) }),
            ("equirectangular", None) => Some(Self::Equirectangular),
            ("omnidirectional", Some(xi)) => Some(Self::Omnidirectional { xi, distortion }),
            (law, None) => FisheyeProjection::named(law).map(Self::ClassicalFisheye),
            (_, Some(_)) => None,
        }
    }

    /// Equivalent model of calibration tools; `None` where they have none.
    pub fn calibration_model(&self) -> Option<CalibrationModel> {
        each_model!(self, model => model.calibration_model())
    }

    /// Magnification in the middle of the image relative to a pinhole of the same camera matrix: 1 except for an
    /// omnidirectional lens, whose ξ moves the pinhole away.
    pub fn magnification(&self) -> f64 {
        self.xi().map_or(1.0, |xi| 1.0 / (1.0 + xi))
    }

    /// Whether the lens is focused on a plane and its pupil stands across the axis, as for the thin lens. A lens that
    /// sees more than a half-space is focused on a sphere, and its pupil faces each direction.
    #[inline]
    pub fn is_flat(&self) -> bool {
        each_model!(self, model => is_flat(model))
    }

    /// Range of angles from the axis in which the model is one to one, no larger than `largest_angle`, rad.
    pub fn reach(&self, largest_angle: Option<f64>) -> Reach {
        let model = each_model!(self, model => model.reach());
        match largest_angle {
            Some(angle) if angle <= model.angle => Reach::new(angle, ReachEnd::Sees, model.radius),
            Some(_) | None => model,
        }
    }

    /// Place in the image of a direction of any length; `None` out of reach.
    #[inline]
    pub fn project(&self, direction: DVec3, reach: &Reach) -> Option<DVec2> {
        let across = DVec2::new(direction.x, direction.y);
        if across.length().atan2(direction.z) > reach.angle {
            return None;
        }
        each_model!(self, model => model.project(direction, reach))
    }

    /// Direction and solid angle seen by a place in the image; `None` out of reach.
    #[inline]
    pub fn unproject(&self, place: DVec2, reach: &Reach) -> Option<Seen> {
        let seen = each_model!(self, model => model.unproject(place, reach))?;
        reach.sees(seen.direction).then_some(seen)
    }
}
