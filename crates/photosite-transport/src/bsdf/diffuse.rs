//! Lambert's law: light leaves in all directions with the same radiance.
//!
//! f = ρ/π for wo and wi above the surface. The reflectance ρ is between 0 and 1; it is at the same time the albedo for
//! every direction.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::directions::is_above;
use super::form::{Form, Map, Sampled, TableForm};
use super::lobe::{Lobe, SceneTraits, Traits};
use super::sample::{BsdfEval, BsdfSample};
use photosite_core::math::{Pdf, warp};

/// Lambert's law.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse<F: Form = Sampled> {
    /// Reflectance ρ, 0–1.
    pub reflectance: F::Colour,
}

impl<F: Form> Diffuse<F> {
    #[inline]
    pub(super) fn map<T: Form>(&self, map: &mut impl Map<F, T>) -> Diffuse<T> {
        Diffuse { reflectance: map.colour(&self.reflectance) }
    }
}

impl<F: TableForm> SceneTraits for Diffuse<F> {}

impl Lobe for Diffuse {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        if !(is_above(wo) && is_above(wi)) {
            return BsdfEval::ZERO;
        }
        BsdfEval { f: self.reflectance * FRAC_1_PI, pdf: Pdf::new(wi.z * FRAC_1_PI) }
    }

    #[inline]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = Vec3::from(warp::cosine_hemisphere(u));
        (is_above(wo) && is_above(wi))
            .then(|| BsdfSample::reflected(self.reflectance * FRAC_1_PI, wi, Pdf::new(wi.z * FRAC_1_PI)))
    }

    #[inline]
    fn traits(&self) -> Traits {
        Traits::default()
    }
}
