//! Poses of objects, and random rotations.
//!
//! Nothing here calls a trigonometric function: those of the system differ in their last bits from machine to machine.

use glam::{DQuat, DVec3};
use parry3d_f64::math::{Pose3, Rot3, Vector};
use photosite_core::math::philox::Philox;
use rand::RngExt;

/// Position of an object's origin in the world, in metres, and rotation about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation object → world.
    pub rotation: DQuat,
    /// Position of the object's origin in the world, m.
    pub position: DVec3,
}

/// Random rotation of an object before it is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Rotation of the object's file.
    None,
    /// Uniform rotation about the vertical.
    Vertical,
    /// Uniform rotation in three dimensions.
    Any,
}

impl Pose {
    /// Pose that leaves an object as in its file.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, position: DVec3::ZERO };

    /// Position in the world of a point of the object, which is already scaled.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.position
    }

    pub(crate) fn to_parry(self) -> Pose3 {
        Pose3 { rotation: Rot3::from_array(self.rotation.to_array()), translation: vector(self.position) }
    }

    pub(crate) fn from_parry(pose: &Pose3) -> Self {
        let rotation = DQuat::from_array(pose.rotation.to_array()).normalize();
        Self { rotation, position: point(pose.translation) }
    }
}

/// A vector in the type of the engine's version of glam.
pub(crate) fn vector(v: DVec3) -> Vector {
    Vector::from_array(v.to_array())
}

/// A vector of the engine in the type of this crate.
pub(crate) fn point(v: Vector) -> DVec3 {
    DVec3::from_array(v.to_array())
}

impl Turn {
    /// Draws a rotation.
    pub(crate) fn draw(self, random: &mut Philox) -> DQuat {
        match self {
            Self::None => DQuat::IDENTITY,
            // A point of the unit circle is cosine and sine of an even half angle.
            Self::Vertical => {
                let [w, y] = on_unit_sphere(random);
                DQuat::from_xyzw(0.0, y, 0.0, w)
            }
            // Unit quaternions drawn evenly are rotations drawn evenly.
            Self::Any => DQuat::from_array(on_unit_sphere(random)),
        }
    }
}

/// A number drawn uniformly between two.
pub(crate) fn between(low: f64, high: f64, random: &mut Philox) -> f64 {
    low + (high - low) * random.random::<f64>()
}

/// A point drawn uniformly on the unit sphere of N dimensions, by rejection from the cube around it.
fn on_unit_sphere<const N: usize>(random: &mut Philox) -> [f64; N] {
    loop {
        let p: [f64; N] = std::array::from_fn(|_| between(-1.0, 1.0, random));
        let squared: f64 = p.iter().map(|x| x * x).sum();
        if (1e-6..=1.0).contains(&squared) {
            let length = squared.sqrt();
            return p.map(|x| x / length);
        }
    }
}
