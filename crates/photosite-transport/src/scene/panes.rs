//! Shadow rays through panes to lights without a surface.

use super::Scene;
use super::shading::Shading;
use crate::geometry::Ray;
use photosite_core::spectrum::{SampledSpectrum, SpectrumId, Wavelengths};

impl Scene {
    /// The part of the light that arrives against a shadow ray from a light without a surface: panes and the boundaries
    /// of volumes of index 1 let some of it straight through, and nothing else in the way lets any. Volumes absorb on
    /// the way; the ray sets out in `medium`.
    ///
    /// No ray that a surface scatters could come to such a light behind a pane, so that nothing is counted twice. Other
    /// lights are found behind panes by the rays that go straight on, and stay hidden from shadow rays.
    #[inline(never)]
    pub(crate) fn through_panes(
        &self,
        ray: &Ray,
        mut medium: Option<SpectrumId>,
        wavelengths: &Wavelengths,
    ) -> SampledSpectrum {
        let end = ray.t_max.is_finite().then(|| ray.at(ray.t_max));
        let (mut ray, mut passed) = (*ray, SampledSpectrum::ONE);
        let towards = ray.direction.normalize();
        let absorbed = |medium: Option<SpectrumId>, distance| {
            medium.map_or(SampledSpectrum::ONE, |medium| self.transmittance(medium, distance, wavelengths))
        };
        while let Some(hit) = self.closest(&ray) {
            let point = self.point(&hit, ray.time);
            medium = self.absorption_behind(&point, -towards).or(medium);
            passed *= absorbed(medium, point.position.distance(ray.origin));
            let Shading { frame, bsdf } = self.shading(&point, -towards, wavelengths);
            passed *= bsdf.straight(frame.to_local(-towards));
            if passed.is_black() {
                return passed;
            }
            medium = self.medium_across(&point, towards, medium);
            Ray { origin: ray.origin, from: ray.from, .. } = point.spawn_ray(towards);
            if let Some(end) = end {
                (ray.direction, ray.t_max) = (end - ray.origin, 1.0);
            }
            // A pane at the light itself.
            if ray.direction.dot(towards) <= 0.0 {
                return passed;
            }
        }
        passed * end.map_or(SampledSpectrum::ONE, |end| absorbed(medium, end.distance(ray.origin)))
    }
}
