//! Area lights, primitive by primitive.

use super::emission::SurfaceEmission;
use super::emitter::{Emitter, EmitterShape, SeenPoint};
use super::sample::{LiContext, LiSample};
use crate::geometry::Primitive;
use photosite_core::spectrum::SampledSpectrum;

/// A primitive that emits.
#[derive(Clone, Copy, Debug)]
pub struct AreaLight {
    /// Primitive that emits.
    pub primitive: Primitive,
    /// Radiance that the primitive emits.
    pub emission: SurfaceEmission,
}

impl AreaLight {
    /// A point of its shape, which stands where it is at the time. `emitted_at(light, parameters)` is the radiance of a
    /// point.
    #[inline]
    pub(super) fn sample_li(
        &self,
        shape: &Emitter,
        u: [f32; 2],
        li: &LiContext<'_>,
        emitted_at: impl FnOnce(&Self, [f32; 2]) -> SampledSpectrum,
    ) -> Option<LiSample> {
        let SeenPoint { point, wi, cos, pdf } = shape.sample(li.point, u)?;
        if !(cos > 0.0 || self.emission.two_sided && cos < 0.0) {
            return None;
        }
        Some(LiSample {
            radiance: emitted_at(self, point.parameters),
            wi,
            position: Some((point.position, point.normal)),
            pdf,
            is_delta: false,
        })
    }
}
