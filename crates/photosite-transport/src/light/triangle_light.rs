//! Area lights, triangle by triangle.

use super::emission::SurfaceEmission;
use super::emissive_triangle::EmissiveTriangle;
use super::sample::{LiContext, LiSample};
use photosite_core::math::{Pdf, warp};
use photosite_core::spectrum::SampledSpectrum;

/// A triangle that emits.
#[derive(Clone, Copy, Debug)]
pub struct TriangleLight {
    /// Handle of the triangle.
    pub triangle: u32,
    /// Its emission.
    pub emission: SurfaceEmission,
}

impl TriangleLight {
    /// A point spread evenly over the triangle, which stands where it is at the time. `emitted_at(light, barycentric)`
    /// is the radiance of a point.
    #[inline]
    pub(super) fn sample_li(
        &self,
        triangle: &EmissiveTriangle,
        u: [f32; 2],
        li: &LiContext<'_>,
        emitted_at: impl FnOnce(&Self, [f32; 2]) -> SampledSpectrum,
    ) -> Option<LiSample> {
        let barycentric = warp::uniform_triangle(u);
        let point = triangle.seen_from(barycentric, li.point.into());
        if !(point.cos > 0.0 || self.emission.two_sided && point.cos < 0.0) {
            return None;
        }
        Some(LiSample {
            radiance: emitted_at(self, barycentric),
            wi: point.wi.into(),
            position: Some((point.position.into(), triangle.normal())),
            pdf: Pdf::new(point.density),
            is_delta: false,
        })
    }
}
