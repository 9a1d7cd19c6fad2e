//! How directions become places in the picture, at ray level: a position on the sensor is taken back to its direction
//! before a ray is made, so that nothing is resampled and the corners are filled.
//!
//! Directions are in OpenCV's camera space: x right, y down, z forward. Places are normalised image coordinates, which
//! the pinhole matrix turns into pixels: x = (column − cx − skew·y)/fx, y = (row − cy)/fy.
//!
//! | model | maps | exact where | module |
//! |---|---|---|---|
//! | perspective | (X, Y)/Z | Z > 0 | here |
//! | Brown–Conrady, rational, thin prism | ideal → distorted | up to its first fold | `brown_conrady.rs` |
//! | polynomial | distorted → ideal | up to its first fold | `polynomial.rs` |
//! | division | distorted → ideal | up to its first fold, or Z > 0 | `division.rs` |
//! | Kannala–Brandt | angle → radius | up to its first fold, or everywhere | `kannala_brandt.rs` |
//! | equirectangular | longitude, latitude | everywhere | `equirectangular.rs` |
//! | omnidirectional | a sphere, then a pinhole | what its mirror shows | `omnidirectional.rs` |
//!
//! A model is used within its [`Reach`] only, in which it is one to one; both directions agree there to the precision of
//! f64.

mod brown_conrady;
mod division;
mod equirectangular;
mod intrinsics;
mod kannala_brandt;
mod omnidirectional;
mod polynomial;
mod rising;

#[cfg(test)]
mod tests;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

pub use brown_conrady::BrownConrady;
pub use intrinsics::Intrinsics;

/// The largest angle from the axis that a flat picture is followed to, rad: 89.99°, where it is 5730 focal lengths wide.
const FLAT_ANGLE: f64 = FRAC_PI_2 * (1.0 - 0.01 / 90.0);

/// A model of how a lens maps directions to its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A rectilinear lens: (x, y) = (X, Y)/Z.
    Perspective,
    /// A rectilinear lens with the distortion of OpenCV's standard model.
    BrownConrady(BrownConrady),
    /// A rectilinear lens whose distortion is given from the distorted to the ideal picture:
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
    /// Longitude and latitude in radians.
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

/// A direction and how much of space a piece of the picture sees there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Unit direction.
    pub direction: DVec3,
    /// From the centre of the lens to what is in focus, in units of the focus distance: to a plane across the axis where the
    /// projection [is flat](Projection::is_flat), to a sphere elsewhere.
    pub chief: DVec3,
    /// Solid angle over area in normalised coordinates dΩ/dA, sr: cos³θ for a rectilinear lens.
    pub solid_angle: f64,
}

impl Seen {
    /// By a lens that is focused on a sphere.
    #[inline]
    fn all_round(direction: DVec3, solid_angle: f64) -> Self {
        Self { direction, chief: direction, solid_angle }
    }
}

/// How far from the axis a projection is one to one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Angle from the axis, rad.
    pub angle: f64,
    /// What is beyond.
    pub end: ReachEnd,
    /// The same in what the model is a function of: a radius or an angle, see there.
    radius: f64,
    /// Directions whose cosine from the axis is above this are seen, whatever rounding does.
    sure_cos: f64,
}

impl Reach {
    fn new(angle: f64, end: ReachEnd, radius: f64) -> Self {
        Self { angle, end, radius, sure_cos: angle.cos() + 1e-9 }
    }

    /// Whether a unit direction is seen. The angle itself is asked for close to the end only, as it costs much.
    #[inline]
    fn sees(&self, d: DVec3) -> bool {
        d.z > self.sure_cos || d.x.hypot(d.y).atan2(d.z) <= self.angle
    }
}

/// Why a projection ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReachEnd {
    /// The lens was said to see no more, or sees all directions that its model has.
    Sees,
    /// Farther out, the model folds back over its own picture.
    Folds,
    /// A flat picture ends at 90° from the axis.
    Flat,
}

impl Projection {
    /// What a capture file calls it: its distortion's model, or the projection without one.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Perspective => "perspective",
            Self::BrownConrady(_) => "brown-conrady",
            Self::Polynomial { .. } => "polynomial",
            Self::Division { .. } => "division",
            Self::KannalaBrandt { .. } => "kannala-brandt",
            Self::Equirectangular => "equirectangular",
            Self::Omnidirectional { .. } => "omnidirectional",
        }
    }

    /// The coefficients in OpenCV's order, as few as say all: k₁ k₂ p₁ p₂ k₃, then k₄ k₅ k₆, then s₁ … s₄; k₁ … k₄ of a
    /// fisheye; k₁ k₂ p₁ p₂ of an omnidirectional lens. Those of models that OpenCV lacks are in their own order.
    pub fn coefficients(&self) -> Vec<f64> {
        match self {
            Self::Perspective => vec![0.0; 5],
            Self::BrownConrady(BrownConrady { k: [k1, k2, k3, k4, k5, k6], p: [p1, p2], s }) => {
                let all = [&[*k1, *k2, *p1, *p2, *k3, *k4, *k5, *k6], s.as_slice()].concat();
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
            Self::Polynomial { k } => k.to_vec(),
            Self::Division { lambda } => vec![*lambda],
            Self::KannalaBrandt { k } => k.to_vec(),
            Self::Equirectangular => Vec::new(),
            Self::Omnidirectional { distortion: BrownConrady { k: [k1, k2, ..], p: [p1, p2], .. }, .. } => {
                vec![*k1, *k2, *p1, *p2]
            }
        }
    }

    /// The model of that [`name`](Self::name) with those [`coefficients`](Self::coefficients); `xi` is the mirror parameter of an
    /// omnidirectional lens. `None` where there is no such model.
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
            _ => None,
        }
    }

    /// How large the middle of the picture is, as a part of what a pinhole of the same matrix would show there: 1 but for an
    /// omnidirectional lens, whose ξ moves the pinhole away.
    pub fn magnification(&self) -> f64 {
        match self {
            Self::Perspective
            | Self::BrownConrady(_)
            | Self::Polynomial { .. }
            | Self::Division { .. }
            | Self::KannalaBrandt { .. }
            | Self::Equirectangular => 1.0,
            Self::Omnidirectional { xi, .. } => 1.0 / (1.0 + xi),
        }
    }

    /// Whether the lens is focused on a plane and its pupil stands across the axis, as for the thin lens. What sees more
    /// than a half-space is focused on a sphere, and its pupil faces each direction.
    pub fn is_flat(&self) -> bool {
        match self {
            Self::Perspective | Self::BrownConrady(_) | Self::Polynomial { .. } | Self::Division { .. } => true,
            Self::KannalaBrandt { .. } | Self::Equirectangular | Self::Omnidirectional { .. } => false,
        }
    }

    /// How far from the axis the model is one to one, and no farther than `largest_angle`, rad.
    pub fn reach(&self, largest_angle: Option<f64>) -> Reach {
        let flat = |radius: f64, end| Reach::new(radius.atan(), end, radius);
        let model = match self {
            Self::Perspective => flat(FLAT_ANGLE.tan(), ReachEnd::Flat),
            Self::BrownConrady(distortion) => match distortion.fold() {
                Some(radius) => flat(radius, ReachEnd::Folds),
                None => flat(FLAT_ANGLE.tan(), ReachEnd::Flat),
            },
            Self::Polynomial { k } => polynomial::reach(*k),
            Self::Division { lambda } => division::reach(*lambda),
            Self::KannalaBrandt { k } => kannala_brandt::reach(*k),
            Self::Equirectangular => Reach::new(PI, ReachEnd::Sees, PI),
            Self::Omnidirectional { xi, distortion } => omnidirectional::reach(*xi, distortion),
        };
        match largest_angle {
            Some(angle) if angle <= model.angle => Reach::new(angle, ReachEnd::Sees, model.radius),
            Some(_) | None => model,
        }
    }

    /// Where a direction of any length appears in the picture; `None` out of reach.
    #[inline]
    pub fn project(&self, direction: DVec3, reach: &Reach) -> Option<DVec2> {
        let across = DVec2::new(direction.x, direction.y);
        if across.length().atan2(direction.z) > reach.angle {
            return None;
        }
        match self {
            Self::Perspective => Some(across / direction.z),
            Self::BrownConrady(distortion) => Some(distortion.distort(across / direction.z)),
            Self::Polynomial { k } => polynomial::distort(*k, across / direction.z, reach.radius),
            Self::Division { lambda } => Some(division::distort(*lambda, across / direction.z)),
            Self::KannalaBrandt { k } => Some(kannala_brandt::project(*k, direction)),
            Self::Equirectangular => Some(equirectangular::project(direction)),
            Self::Omnidirectional { xi, distortion } => {
                Some(distortion.distort(omnidirectional::project(*xi, direction)))
            }
        }
    }

    /// What a place in the picture sees; `None` out of reach.
    #[inline]
    pub fn unproject(&self, place: DVec2, reach: &Reach) -> Option<Seen> {
        let seen = match self {
            Self::Perspective => through_plane(place, 1.0),
            Self::BrownConrady(distortion) => {
                let (ideal, growth) = distortion.undistort(place, reach.radius)?;
                through_plane(ideal, 1.0 / growth)
            }
            Self::Polynomial { k } => {
                let (ideal, growth) = polynomial::undistort(*k, place, reach.radius)?;
                through_plane(ideal, growth)
            }
            Self::Division { lambda } => {
                let (ideal, growth) = division::undistort(*lambda, place, reach.radius)?;
                through_plane(ideal, growth)
            }
            Self::KannalaBrandt { k } => kannala_brandt::unproject(*k, place, reach.radius)?,
            Self::Equirectangular => equirectangular::unproject(place)?,
            Self::Omnidirectional { xi, distortion } => {
                let (ideal, growth) = distortion.undistort(place, reach.radius)?;
                let seen = omnidirectional::unproject(*xi, ideal)?;
                Seen { solid_angle: seen.solid_angle / growth, ..seen }
            }
        };
        reach.sees(seen.direction).then_some(seen)
    }
}

/// What the point of the plane z = 1 sees by a lens that is focused on a plane, where the picture there is `growth` times as
/// large in area as on the sensor: dΩ = cos³θ·dA.
#[inline(always)]
pub fn through_plane(ideal: DVec2, growth: f64) -> Seen {
    let cos = 1.0 / (1.0 + ideal.length_squared()).sqrt();
    let chief = ideal.extend(1.0);
    Seen { direction: chief * cos, chief, solid_angle: cos * cos * cos * growth }
}
