//! How surfaces scatter light.
//!
//! Everything here happens in the local shading frame: +Z is the shading normal, `wo` is known, `wi` is sampled, both
//! are unit vectors that point away from the surface. A BSDF value `f` (sr⁻¹) has no cosine in it and is for radiance:
//! refraction into a medium of another index carries 1/η² ([Pbrt4](photosite_core::references#pbrt4) §9.5.2). Values are spectral,
//! one per wavelength of the path; directions and densities are common to all of them, decided by the mean over the lanes
//! or, in dielectrics, by the hero.
//!
//! | model | file | lobes |
//! |---|---|---|
//! | [`Diffuse`] | `diffuse` | Lambert |
//! | [`Conductor`] | `conductor` | mirror or GGX reflection, exact Fresnel |
//! | [`Dielectric`] | `dielectric` | mirror or GGX reflection and refraction, exact Fresnel |
//! | [`OrenNayar`] | `oren_nayar` | diffuse with relief |
//! | [`Phong`] | `phong` | Lambert and a power of the cosine to the mirror direction |
//! | [`Translucent`] | `translucent` | Lambert on both sides |
//! | [`ThinDielectric`] | `thin_dielectric` | mirror and straight on, as a pane |
//! | [`Layered`] | [`layered`] | glTF: coat, sheen, microfacets, and a metallic, coloured or clear base |
//!
//! [`model`] has the list of them. [`fresnel`] says how much an interface reflects, [`microfacet`] what roughness does to it.
//!
//! What refracts is seen from both sides; all else is black from behind, though it may transmit light from there. The
//! integrator turns the frame round where a surface has two equal sides, and guards against light that leaks through
//! shading normals.

pub mod fresnel;
pub mod layered;
pub mod microfacet;
pub mod model;

mod albedo;
mod conductor;
mod dielectric;
mod diffuse;
mod oren_nayar;
mod phong;
mod thin_dielectric;
mod translucent;

use glam::Vec3;

pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use layered::{Coat, Film, Layered, Sheen, Volume};
pub use microfacet::Ggx;
pub use model::{Form, Map, MapAll, Mix, Model, RelativeIndex, Sampled, SceneTraits, TableForm, Traits};
pub use oren_nayar::OrenNayar;
pub use phong::Phong;
use photosite_core::math::{Pdf, SolidAngle};
use photosite_core::spectrum::SampledSpectrum;
pub use thin_dielectric::ThinDielectric;
pub use translucent::Translucent;

/// Directions with a smaller cosine count as lying in the surface, where nothing is scattered: on which side they are is
/// no longer known, a unit vector being rounded to 6e-8.
pub(crate) const GRAZING: f32 = 1e-7;

/// Cosine below which a shading normal may have been bent towards who sees it (`scene::shading`), which does so below half of it.
const EDGE_ON: f32 = 2e-3;

/// How the surface scatters at one shading point: the model with its parameters looked up.
pub type Bsdf = Model<Sampled>;

/// Value and density for a pair of directions. Zero for lobes that are a single direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfEval {
    /// sr⁻¹, without cosine.
    pub f: SampledSpectrum,
    /// Density with which [`Bsdf::sample`] finds `wi`.
    pub pdf: Pdf<SolidAngle>,
}

impl BsdfEval {
    /// No scattering.
    pub const ZERO: Self = Self { f: SampledSpectrum::ZERO, pdf: Pdf::new(0.0) };
}

/// A direction drawn by [`Bsdf::sample`]. The path's throughput is to be multiplied by f·|cos θᵢ|/pdf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// sr⁻¹, without cosine. Where `is_delta`, the reflected or transmitted part over |cos θᵢ|.
    pub f: SampledSpectrum,
    /// The direction drawn.
    pub wi: Vec3,
    /// Its density. Where `is_delta`, the probability of having chosen it.
    pub pdf: Pdf<SolidAngle>,
    /// Whether the direction is the only one of its lobe, so that no light can be sampled towards it.
    pub is_delta: bool,
    /// Whether `wi` is on the other side than `wo`.
    pub is_transmission: bool,
    /// Whether the path is right for the hero wavelength alone from here on; the other lanes of `f` are then zero.
    pub terminates_secondary: bool,
    /// Index on the side of `wi` over that on the side of `wo`; 1 where reflected.
    pub eta: f32,
}

impl BsdfSample {
    /// A reflected direction of a lobe of some width.
    #[inline]
    fn reflected(f: SampledSpectrum, wi: Vec3, pdf: Pdf<SolidAngle>) -> Self {
        Self { f, wi, pdf, is_delta: false, is_transmission: false, terminates_secondary: false, eta: 1.0 }
    }

    /// The one direction of a mirror, of which a part `reflectance` comes back, chosen with `probability`.
    #[inline]
    fn mirrored(reflectance: SampledSpectrum, wi: Vec3, probability: f32) -> Self {
        Self { is_delta: true, ..Self::reflected(reflectance / wi.z.abs(), wi, Pdf::new(probability)) }
    }

    /// What the path's throughput is multiplied by: f·|cos θᵢ|/pdf.
    #[inline]
    pub fn throughput(&self) -> SampledSpectrum {
        self.f * (self.wi.z.abs() / self.pdf.0)
    }
}

impl Bsdf {
    /// Density with which [`Self::sample`] finds `wo` for light that goes the other way round. What is black from behind
    /// counts as seen from its other side there.
    #[inline]
    pub fn reverse_pdf(&self, wo: Vec3, wi: Vec3) -> Pdf<SolidAngle> {
        let [wo, wi] = if wi.z < 0.0 && !self.refracts() { [wo, wi].map(dielectric::mirrored) } else { [wo, wi] };
        self.eval(wi, wo).pdf
    }

    /// Whether [`Self::sample`] chooses among lobes, so that its first number matters.
    #[inline]
    pub fn has_lobes(&self) -> bool {
        self.traits().has_lobes
    }

    /// Whether light passes through.
    #[inline]
    pub fn transmits(&self) -> bool {
        self.traits().transmits
    }

    /// Whether every lobe is a single direction: sampling lights is then in vain.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.traits().is_delta
    }

    /// Whether it throws light on in bundles, or lets it through where no path from elsewhere to the light goes straight:
    /// mirrors, glass, and microfacets of α < 0.3, whether or not other lobes go with them.
    #[inline]
    pub fn casts_caustics(&self) -> bool {
        self.traits().casts_caustics
    }

    /// Whether `wo` sees the surface so much edge-on that its frame may be one for this direction alone.
    #[inline]
    pub fn is_edge_on(&self, wo: Vec3) -> bool {
        !self.refracts() && wo.z < EDGE_ON
    }

    /// Whether [`Self::eval`] and [`Self::sample`] are right for the hero wavelength alone, so that the path must drop the
    /// others before it calls them: rough dielectrics whose index depends on wavelength.
    #[inline]
    pub fn needs_single_wavelength(&self) -> bool {
        self.traits().needs_single_wavelength
    }
}

#[inline]
fn is_grazing(w: Vec3) -> bool {
    w.z.abs() <= GRAZING
}

#[inline]
fn is_above(w: Vec3) -> bool {
    w.z > GRAZING
}
