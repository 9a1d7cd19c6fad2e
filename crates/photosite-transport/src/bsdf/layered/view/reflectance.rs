//! Reflectance of the facets and interfaces of the layers, for one direction and on average.

use glam::Vec4;

use super::state::{MEAN_WEIGHT, ONE, View, ZERO};
use crate::bsdf::albedo::{COAT_F0, FILM_NODES, FilmWeights};
use crate::bsdf::fresnel::{self, schlick_weight};
use crate::bsdf::layered::layers::Volume;
use crate::bsdf::microfacet::ReflectionKernel;
use photosite_core::spectrum::SampledSpectrum;

impl View<'_> {
    /// The facets' reflectance at the cosine `cos`, with Schlick's weight and the film if there is one.
    #[inline]
    pub(super) fn reflectance(&self, f0: SampledSpectrum, cos: f32) -> SampledSpectrum {
        let white = schlick_weight(cos);
        let bare = f0 * (1.0 - white) + SampledSpectrum::splat(white);
        self.with_film(bare, f0, cos)
    }

    #[inline]
    pub(super) fn with_film(&self, bare: SampledSpectrum, f0: SampledSpectrum, cos: f32) -> SampledSpectrum {
        match self.layers.film {
            Some(film) => bare * (1.0 - film.weight) + film.reflectance(cos, f0) * film.weight,
            None => bare,
        }
    }

    /// ∫2μ·R(μ) dμ; `base` is 0 for the dielectric, 1 for the metal.
    #[inline]
    pub(super) fn mean_reflectance(&self, base: usize, f0: SampledSpectrum) -> SampledSpectrum {
        let bare = f0 * (1.0 - MEAN_WEIGHT) + SampledSpectrum::splat(MEAN_WEIGHT);
        match (self.layers.film, &self.film) {
            (Some(film), Some(nodes)) => {
                let weights = FilmWeights::cosine_mean();
                bare * (1.0 - film.weight) + at_nodes(&nodes[base], &weights) * film.weight
            }
            (_, _) => bare,
        }
    }

    /// The reflectance of a refracting facet whose index (that of the far side over the near one) is `eta` and whose
    /// exact reflectance is `exact`: Schlick's form with the exact weight. `cos_outside` is for the film.
    #[inline]
    pub(super) fn refracting_reflectance(
        &self,
        exact: SampledSpectrum,
        eta: SampledSpectrum,
        cos_outside: f32,
    ) -> SampledSpectrum {
        let root = (eta - ONE) / (eta + ONE);
        let normal = root * root;
        let weight = SampledSpectrum(((exact - normal) / (ONE - normal)).0.clamp(Vec4::ZERO, Vec4::ONE));
        let f0 = self.layers.f0;
        let partial = self.with_film(f0 * (ONE - weight) + weight, f0, cos_outside) * self.layers.specular;
        // Nothing is let through where reflection is total.
        SampledSpectrum(Vec4::select(exact.0.cmpge(Vec4::ONE), Vec4::ONE, partial.0))
    }

    /// Reflectance of the clear base for light that meets a facet at `cos` on the side of `wo`.
    #[inline]
    pub(super) fn clear_reflectance(&self, volume: Volume, cos: f32) -> SampledSpectrum {
        let exact = |eta| fresnel::dielectric(cos, eta).reflectance;
        let exact =
            if volume.dispersive { volume.eta.map(exact) } else { SampledSpectrum::splat(exact(volume.eta[0])) };
        self.refracting_reflectance(exact, volume.eta, self.cos_outside(cos, volume.eta[0]))
    }

    /// The cosine outside of light that meets a facet at `cos` on the side of `wo`.
    #[inline]
    pub(super) fn cos_outside(&self, cos: f32, eta: f32) -> f32 {
        if self.is_inside { fresnel::dielectric(cos, eta).cos_transmitted } else { cos }
    }
}

/// Σ R(cⱼ)·Wⱼ.
#[inline]
pub(super) fn at_nodes(reflectances: &[SampledSpectrum; FILM_NODES], weights: &FilmWeights) -> SampledSpectrum {
    let mut sum = ZERO;
    for (j, &reflectance) in reflectances.iter().enumerate() {
        sum += reflectance * weights.at(j);
    }
    sum
}

#[inline]
pub(super) fn coat_fresnel(cos: f32) -> f32 {
    let white = schlick_weight(cos);
    COAT_F0 + (1.0 - COAT_F0) * white
}

#[inline]
pub(super) fn coat_reflectance(weight: f32, kernel: &ReflectionKernel) -> f32 {
    weight * coat_fresnel(kernel.cos_facet) * kernel.value
}
