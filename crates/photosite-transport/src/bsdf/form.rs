//! The forms in which a model has its parameters.
//!
//! A model is one type with its parameters in one of three [`Form`]s: as a file states them, as handles into the tables
//! of a scene, and as values at a shading point. [`Model::map`](super::Model::map) takes them from one form to the
//! next; what the steps are for a colour, a spectrum, an index or a roughness is a [`Map`], the same for all models. At
//! a shading point, where the form is [`Sampled`], the model is a [`Bsdf`](super::Bsdf) and every type is a `Lobe`.

use std::convert::Infallible;
use std::fmt::Debug;

use super::layered::Layered;
use super::microfacet::Ggx;
use photosite_core::spectrum::{SampledSpectrum, SpectrumId};

/// The form in which the parameters of a model are.
pub trait Form: Copy + Debug {
    /// A reflectance that may vary over the surface.
    type Colour: Clone + Debug;
    /// A spectrum that is the same all over the surface.
    type Spectrum: Clone + Debug;
    /// The refractive index of the side that the normal points away from, relative to the other.
    type Index: Clone + Debug;
    /// The roughness of microfacets.
    type Distribution: Clone + Debug;
    /// glTF's material, whose forms have little in common.
    type Layered: Clone + Debug;
    /// Parameters of a mix of two models.
    type Mix: Clone + Debug;
}

/// Parameters at one shading point, of the wavelengths of one path.
#[derive(Clone, Copy, Debug)]
pub struct Sampled;

impl Form for Sampled {
    type Colour = SampledSpectrum;
    type Spectrum = SampledSpectrum;
    type Index = RelativeIndex<SampledSpectrum>;
    type Distribution = Ggx;
    type Layered = Layered;
    /// Absence of mixes: at a shading point one of the two models has been chosen.
    type Mix = Infallible;
}

/// A form whose spectra are handles into the tables of a scene.
pub trait TableForm: Form<Spectrum = SpectrumId, Index = RelativeIndex<SpectrumId>, Distribution = Ggx> {}

/// A refractive index relative to the medium outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeIndex<T = SampledSpectrum> {
    /// Ratio n_inside/n_outside. Equal at all wavelengths unless dispersive.
    pub eta: T,
    /// Whether the index depends on wavelength.
    pub dispersive: bool,
    /// Whether the index is 1 at all wavelengths, so that light goes straight on.
    pub is_one: bool,
}

impl RelativeIndex {
    /// Returns an index that is the same at all wavelengths.
    pub fn constant(eta: f32) -> Self {
        Self { eta: SampledSpectrum::splat(eta), dispersive: false, is_one: eta == 1.0 }
    }
}

/// A step from one form to another, parameter by parameter.
pub trait Map<From: Form, To: Form> {
    /// Maps a reflectance.
    fn colour(&mut self, colour: &From::Colour) -> To::Colour;
    /// Maps a spectrum.
    fn spectrum(&mut self, spectrum: &From::Spectrum) -> To::Spectrum;
    /// Maps a refractive index.
    fn index(&mut self, index: &From::Index) -> To::Index;
    /// Maps a roughness.
    fn distribution(&mut self, distribution: &From::Distribution) -> To::Distribution;
}

/// A [`Map`] that knows the models too which are made of others.
pub trait MapAll<From: Form, To: Form>: Map<From, To> {
    /// Maps glTF's material.
    fn layered(&mut self, layered: &From::Layered) -> To::Layered;
    /// Maps two models side by side.
    fn mix(&mut self, mix: &From::Mix) -> To::Mix;
}
