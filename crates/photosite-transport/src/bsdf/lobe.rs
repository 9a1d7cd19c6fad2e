//! What light transport asks of a model.

use glam::Vec3;

use super::sample::{BsdfEval, BsdfSample};
use photosite_core::spectrum::SampledSpectrum;

/// What light transport asks of a model before it traces a path.
pub trait SceneTraits {
    /// Whether it may leave a path with one wavelength.
    fn disperses(&self) -> bool {
        false
    }

    /// Whether some light may go straight on through it ([`Bsdf::straight`](super::Bsdf::straight)).
    fn may_pass_straight(&self) -> bool {
        false
    }

    /// Whether it may cast caustics somewhere ([`Traits::casts_caustics`]).
    fn may_cast_caustics(&self) -> bool {
        false
    }
}

/// What light transport asks of a model at a shading point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Traits {
    /// Whether sampling chooses among lobes, so that its first number matters.
    pub has_lobes: bool,
    /// Whether light passes through.
    pub transmits: bool,
    /// Whether every lobe is a single direction.
    pub is_delta: bool,
    /// See [`Bsdf::casts_caustics`](super::Bsdf::casts_caustics).
    pub casts_caustics: bool,
    /// See [`Bsdf::needs_single_wavelength`](super::Bsdf::needs_single_wavelength).
    pub needs_single_wavelength: bool,
}

/// A model at a shading point. The functions are those of [`Bsdf`](super::Bsdf).
pub(super) trait Lobe {
    /// Whether both sides are of different media, so that the frame stays on its side, whichever is seen.
    const REFRACTS: bool = false;

    /// Value and density of scattering between `wo` and `wi`.
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval;

    /// Draws `wi`.
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample>;

    /// What is known of its lobes.
    fn traits(&self) -> Traits;

    /// The part of the light from `wo` that goes straight on.
    fn straight(&self, _wo: Vec3) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }
}
