//! Scattering models of surfaces.
//!
//! Everything here happens in the local shading frame: +Z is the shading normal, `wo` is known, `wi` is sampled, both
//! are unit vectors that point away from the surface. A BSDF value `f` (sr⁻¹) has no cosine in it and is for radiance:
//! refraction into a medium of another index carries 1/η² ([Pbrt4](photosite_core::references#pbrt4) §9.5.2). Values
//! are spectral, one per wavelength of the path; directions and densities are common to all of them, decided by the
//! mean over the lanes or, in dielectrics, by the hero.
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
//! | [`Retroreflective`] | `retroreflective` | GGX reflection back to where light comes from, and Lambert |
//! | [`Layered`] | [`layered`] | glTF: coat, sheen, microfacets, and a metallic, coloured or clear base |
//!
//! [`fresnel`] says how much an interface reflects, [`microfacet`] what roughness does to it.
//!
//! What refracts is seen from both sides; all else is black from behind, though it may transmit light from there. The
//! integrator turns the frame round where a surface has two equal sides, and guards against light that leaks through
//! shading normals.

pub mod fresnel;
pub mod layered;
pub mod microfacet;
#[macro_use]
mod model;

mod albedo;
mod compensation;
mod conductor;
mod dielectric;
mod diffuse;
mod directions;
mod form;
mod lobe;
mod oren_nayar;
mod phong;
mod refraction;
mod retroreflective;
mod sample;
mod sheen;
mod thin_dielectric;
mod translucent;

use glam::Vec3;

use directions::mirrored;
use lobe::Lobe as _;
use photosite_core::math::{Pdf, SolidAngle};
use photosite_core::spectrum::SampledSpectrum;

pub use albedo::packed as albedo_tables;
pub(crate) use directions::{EDGE_ON_COSINE, GRAZING, MIN_SHADING_COSINE};
pub use form::{Form, Map, MapAll, RelativeIndex, Sampled, TableForm};
pub use layered::{Coat, Layered, Sheen, ThinFilm, Volume};
pub use lobe::{SceneTraits, Traits};
pub use microfacet::Ggx;
pub use models::*;
pub use sample::{BsdfEval, BsdfSample};

/// The types of the models.
pub mod models {
    pub use super::conductor::Conductor;
    pub use super::dielectric::Dielectric;
    pub use super::diffuse::Diffuse;
    pub use super::oren_nayar::OrenNayar;
    pub use super::phong::Phong;
    pub use super::retroreflective::{CubeCorners, Retroreflective};
    pub use super::thin_dielectric::ThinDielectric;
    pub use super::translucent::Translucent;
}

models! {
    /// Lambert's law.
    Diffuse,
    /// A metal.
    Conductor,
    /// A clear medium on the side that the normal points away from.
    Dielectric,
    /// A diffuse surface with relief.
    OrenNayar,
    /// Phong's model.
    Phong,
    /// A thin diffuse sheet.
    Translucent,
    /// A polished pane.
    ThinDielectric,
    /// Retroreflective sheeting.
    Retroreflective,
}

/// Mix of two models side by side.
#[derive(Clone, Debug)]
pub struct Mix<F: Form> {
    /// Pair of models that are mixed.
    pub models: [Model<F>; 2],
    /// Weight of the second model, 0–1.
    pub weight: f32,
}

/// BSDF at one shading point: the scattering model with its parameters looked up.
pub type Bsdf = Model<Sampled>;

impl Bsdf {
    /// Density with which [`Self::sample`] finds `wo` for light that goes the other way round. A surface that is black
    /// from behind counts as seen from its front there.
    #[inline]
    pub fn reverse_pdf(&self, wo: Vec3, wi: Vec3) -> Pdf<SolidAngle> {
        let [wo, wi] = if wi.z < 0.0 && !self.refracts() { [wo, wi].map(mirrored) } else { [wo, wi] };
        self.eval(wi, wo).pdf
    }

    /// Whether [`Self::sample`] chooses among lobes, so that its first random number matters.
    #[inline]
    pub fn has_lobes(&self) -> bool {
        self.traits().has_lobes
    }

    /// Whether the surface transmits light.
    #[inline]
    pub fn transmits(&self) -> bool {
        self.traits().transmits
    }

    /// Whether every lobe is a single direction: sampling lights is then in vain.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.traits().is_delta
    }

    /// Whether the surface focuses light into caustics, or lets light through where no path from elsewhere to the light
    /// goes straight: mirrors, glass, and microfacets of α < 0.3, whether or not other lobes go with them.
    #[inline]
    pub fn casts_caustics(&self) -> bool {
        self.traits().casts_caustics
    }

    /// Whether `wo` sees the surface so much edge-on that its frame may be one for this direction alone.
    #[inline]
    pub fn is_edge_on(&self, wo: Vec3) -> bool {
        !self.refracts() && wo.z < EDGE_ON_COSINE
    }

    /// Whether [`Self::eval`] and [`Self::sample`] are right for the hero wavelength alone, so that the path must drop
    /// the others before it calls them: rough dielectrics whose index depends on wavelength.
    #[inline]
    pub fn needs_single_wavelength(&self) -> bool {
        self.traits().needs_single_wavelength
    }
}
