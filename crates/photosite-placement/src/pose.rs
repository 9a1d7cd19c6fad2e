//! Where an object is and how it is turned, and turns drawn at random.
//!
//! Nothing here calls a trigonometric function: those of the system differ in their last bits from machine to machine.

use glam::{DQuat, DVec3};
use parry3d_f64::math::{Pose3, Rot3, Vector};
use photosite_core::math::philox::Philox;
use rand::RngExt;

/// Where the origin of an object is in the world, in metres, and how the object is turned about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Object → world, without scale.
    pub rotation: DQuat,
    /// The object's origin in the world, m.
    pub position: DVec3,
}

/// How objects are turned before they are put somewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// As their file has them.
    None,
    /// About the vertical, evenly.
    Vertical,
    /// Any way round, evenly over all rotations.
    Any,
}

impl Pose {
    /// The pose that leaves an object where its file has it.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, position: DVec3::ZERO };

    /// Where a point of the object, already scaled, is in the world.
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

/// A vector as the engine's version of the same library has it.
pub(crate) fn vector(v: DVec3) -> Vector {
    Vector::from_array(v.to_array())
}

/// And back.
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

/// A number drawn evenly between two.
pub(crate) fn between(low: f64, high: f64, random: &mut Philox) -> f64 {
    low + (high - low) * random.random::<f64>()
}

/// A point drawn evenly on the unit sphere of N dimensions, from those of the cube around it that are in the ball.
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
