//! Interface of the kinds of lights without a surface. Rays cannot meet such lights: they are pbrt's delta lights.

use glam::{DAffine3, DQuat, DVec3, Quat, Vec3};

use super::sample::{LiContext, LiSample};
use photosite_core::math::Cone;
use photosite_core::spectrum::SpectrumId;

/// Kind of a light without a surface, which shines along −z of its own space.
pub(super) trait DeltaModel {
    /// Extent of the light and of the directions in which it shines; `None` for a light infinitely far.
    fn extent(&self, pose: &LightPose) -> Option<DeltaExtent>;

    /// Factor from the light's spectrum, in the unit of its level, to its spectral power, W·nm⁻¹. `disk_m2` is the area
    /// across which a light infinitely far lights the scene.
    fn power_factor(&self, disk_m2: f64) -> f64;

    /// A direction to the light, by two random numbers. `level` is its spectrum. `None` where no light arrives.
    fn sample_li(&self, pose: &LightPose, level: SpectrumId, u: [f32; 2], li: &LiContext<'_>) -> Option<LiSample>;
}

/// Extent of a light and of the directions in which it shines, in the space of its pose.
pub(super) struct DeltaExtent {
    /// Radius of a ball about its position that holds all points that light leaves from, m.
    pub(super) radius: f32,
    /// Directions in which it shines.
    pub(super) directions: Cone,
}

/// Pose of a light: in the world, or in a space that moves with it.
#[derive(Clone, Copy, Debug)]
pub struct LightPose {
    /// Position of the light, m.
    pub position: Vec3,
    /// Unit vector along which the light shines.
    pub axis: Vec3,
    /// Rotation from the world to the space of the light, which shines along −z.
    pub world_to_light: Quat,
}

impl LightPose {
    /// Takes the pose from the rotation and the translation of a transform to the world.
    pub fn new(to_world: &DAffine3) -> Self {
        Self {
            position: to_world.translation.as_vec3(),
            axis: to_world.matrix3.mul_vec3(DVec3::NEG_Z).normalize_or(DVec3::NEG_Z).as_vec3(),
            world_to_light: DQuat::from_mat3(&to_world.matrix3).inverse().normalize().as_quat(),
        }
    }
}
