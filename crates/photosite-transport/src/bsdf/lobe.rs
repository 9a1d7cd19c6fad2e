//! Traits of scattering models that light transport relies on.

use glam::Vec3;

use super::sample::{BsdfEval, BsdfSample};
use photosite_core::spectrum::SampledSpectrum;

/// Traits of a scattering model that light transport asks for before it traces a path.
pub trait SceneTraits {
    /// Whether the model may leave a path with one wavelength.
    fn disperses(&self) -> bool {
        false
    }

    /// Whether some light may go straight on through the surface ([`Bsdf::straight`](super::Bsdf::straight)).
    fn may_pass_straight(&self) -> bool {
        false
    }

    /// Whether the model may cast caustics somewhere ([`Traits::casts_caustics`]).
    fn may_cast_caustics(&self) -> bool {
        false
    }
}

/// Traits of a scattering model at a shading point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Traits {
    /// Whether sampling chooses among lobes, so that its first random number matters.
    pub has_lobes: bool,
    /// Whether the surface transmits light.
    pub transmits: bool,
    /// Whether every lobe is a single direction.
    pub is_delta: bool,
    /// Whether the model casts caustics, see [`Bsdf::casts_caustics`](super::Bsdf::casts_caustics).
    pub casts_caustics: bool,
    /// Whether the model serves the hero wavelength alone, see
    /// [`Bsdf::needs_single_wavelength`](super::Bsdf::needs_single_wavelength).
    pub needs_single_wavelength: bool,
}

/// A model at a shading point. The functions are those of [`Bsdf`](super::Bsdf).
pub(super) trait Lobe {
    /// Whether the surface separates two media, so that the frame keeps its side, whichever side is seen.
    const REFRACTS: bool = false;

    /// Value and density of scattering between `wo` and `wi`.
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval;

    /// Draws `wi`.
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample>;

    /// Returns the traits of the lobes.
    fn traits(&self) -> Traits;

    /// The part of the light from `wo` that goes straight on.
    fn straight(&self, _wo: Vec3) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }
}
