//! A light without a surface in a scene.

use super::delta_model::{DeltaExtent, LightPose};
use super::kind::LightKind;
use super::sample::{LiContext, LiSample};
use photosite_core::spectrum::SpectrumId;

/// A light without a surface in a scene.
#[derive(Clone, Debug)]
pub struct DeltaLight {
    kind: LightKind,
    pose: LightPose,
    /// Spectrum of the light in the unit of the kind's level.
    level: SpectrumId,
}

impl DeltaLight {
    /// A light of that kind and pose. `level` is its spectrum in the unit of the kind's level: W·sr⁻¹·nm⁻¹ of an
    /// intensity, W·m⁻²·nm⁻¹ of an irradiance, W·nm⁻¹ of a flux.
    pub fn new(kind: LightKind, pose: LightPose, level: SpectrumId) -> Self {
        Self { kind, pose, level }
    }

    /// Extent of the light and of the directions in which it shines; `None` for a light infinitely far.
    pub(super) fn extent(&self) -> Option<DeltaExtent> {
        self.kind.extent(&self.pose)
    }

    /// Spectrum of the light in the unit of the kind's level.
    pub(super) fn level(&self) -> SpectrumId {
        self.level
    }

    /// Kind of the light, with its parameters.
    pub(super) fn kind(&self) -> &LightKind {
        &self.kind
    }

    /// Pose of the light.
    pub(super) fn pose(&self) -> &LightPose {
        &self.pose
    }

    /// A direction to the light. `None` where no light arrives.
    #[inline]
    pub(super) fn sample_li(&self, u: [f32; 2], li: &LiContext<'_>) -> Option<LiSample> {
        self.kind.sample_li(&self.pose, self.level, u, li)
    }
}
