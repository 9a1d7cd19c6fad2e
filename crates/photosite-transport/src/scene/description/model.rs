//! Scattering models with their parameters as files state them, and what can be done with each parameter.

use super::layered::LayeredDescription;
use super::texture::{TextureDescription, TexturedColour};
use crate::bsdf::{Conductor, Dielectric, Form, Ggx, Map, MapAll, Mix, Model, RelativeIndex, Sampled};
use photosite_core::spectrum::{Dispersion, SampledSpectrum, Spectrum};

/// Wavelength to which the eye is most sensitive, nm.
const BRIGHTEST_NM: f32 = 555.0;

/// A scattering model as files describe it.
pub type MaterialModel = Model<Described>;

/// Parameters as files state them.
#[derive(Clone, Copy, Debug)]
pub struct Described;

impl Form for Described {
    type Colour = TexturedColour;
    type Spectrum = Spectrum;
    type Index = Dispersion;
    type Distribution = Roughness;
    type Layered = Box<LayeredDescription>;
    type Mix = Box<Mix<Described>>;
}

/// Roughness of GGX microfacets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// Perceptual roughness 0–1; α = value² (glTF's convention). Smooth where it is 0.
    pub value: f32,
    /// Anisotropy, −1–1: α along the tangent grows, across it shrinks. 0 is isotropic.
    pub anisotropy: f32,
}

impl Roughness {
    /// Roughness of a polished surface.
    pub const SMOOTH: Self = Self::isotropic(0.0);

    /// Makes a roughness that is the same in all directions.
    pub const fn isotropic(value: f32) -> Self {
        Self { value, anisotropy: 0.0 }
    }

    /// Distribution of the microfacets.
    pub fn distribution(self) -> Ggx {
        Ggx::from_roughness(self.value, self.anisotropy)
    }
}

/// Visitor of each parameter of a model and of the models that it is made of. By default it does nothing.
pub trait Visit {
    /// A reflectance.
    fn colour(&mut self, _colour: &TexturedColour) {}
    /// A spectrum.
    fn spectrum(&mut self, _spectrum: &Spectrum) {}
    /// A roughness.
    fn roughness(&mut self, _roughness: &Roughness) {}
    /// glTF's material.
    fn layered(&mut self, _layers: &LayeredDescription) {}
}

impl MaterialModel {
    /// Part of the light from all directions that the model's microfacets lose, since it bounces more than once between
    /// them; for a metal and for glass, at the wavelength that eyes see best.
    pub fn lost_light(&self) -> f32 {
        match self {
            Self::Conductor(metal) if !metal.energy_compensation => {
                let [eta, k] = [&metal.eta, &metal.k].map(|part| SampledSpectrum::splat(part.eval(BRIGHTEST_NM)));
                let distribution = metal.distribution.distribution();
                Conductor::<Sampled> { eta, k, distribution, energy_compensation: false }.multiple_scattering()[0]
            }
            Self::Dielectric(glass) if !glass.energy_compensation => {
                let index = RelativeIndex::constant(glass.index.index(f64::from(BRIGHTEST_NM)) as f32);
                let distribution = glass.distribution.distribution();
                Dielectric::<Sampled> { index, distribution, energy_compensation: false }.multiple_scattering()
            }
            Self::Mix(mix) => {
                let [first, second] = mix.models.each_ref().map(Self::lost_light);
                first + (second - first) * mix.weight
            }
            Self::Conductor(_)
            | Self::Dielectric(_)
            | Self::Diffuse(_)
            | Self::OrenNayar(_)
            | Self::Phong(_)
            | Self::Translucent(_)
            | Self::ThinDielectric(_)
            | Self::Retroreflective(_)
            | Self::Layered(_) => 0.0,
        }
    }

    /// Visits all parameters of the model.
    pub fn visit(&self, visitor: &mut impl Visit) {
        self.map(&mut Visited(visitor));
    }
}

/// The form in which nothing is left of a model but its name.
#[derive(Clone, Copy, Debug)]
struct Nothing;

impl Form for Nothing {
    type Colour = ();
    type Spectrum = ();
    type Index = ();
    type Distribution = ();
    type Layered = ();
    type Mix = ();
}

/// A visitor as a map.
struct Visited<'a, V>(&'a mut V);

impl<V: Visit> Map<Described, Nothing> for Visited<'_, V> {
    fn colour(&mut self, colour: &TexturedColour) {
        self.0.colour(colour);
    }

    fn spectrum(&mut self, spectrum: &Spectrum) {
        self.0.spectrum(spectrum);
    }

    // No visitor asks for it so far.
    fn index(&mut self, _index: &Dispersion) {}

    fn distribution(&mut self, roughness: &Roughness) {
        self.0.roughness(roughness);
    }
}

impl<V: Visit> MapAll<Described, Nothing> for Visited<'_, V> {
    fn layered(&mut self, layers: &Box<LayeredDescription>) {
        self.0.layered(layers);
    }

    fn mix(&mut self, mix: &Box<Mix<Described>>) {
        mix.models.iter().for_each(|model| model.visit(self.0));
    }
}

/// The textures of a model.
#[derive(Default)]
pub(super) struct Textures(pub(super) Vec<TextureDescription>);

impl Visit for Textures {
    fn colour(&mut self, colour: &TexturedColour) {
        self.0.extend(colour.texture.clone());
    }

    fn layered(&mut self, layers: &LayeredDescription) {
        self.0.extend(layers.textures().into_iter().flatten().cloned());
    }
}

/// Leaves a model as it is but for its textures.
pub(super) struct ChangedTextures<'a>(pub(super) &'a mut dyn FnMut(&mut TextureDescription));

impl Map<Described, Described> for ChangedTextures<'_> {
    fn colour(&mut self, colour: &TexturedColour) -> TexturedColour {
        let mut colour = colour.clone();
        colour.texture.iter_mut().for_each(&mut *self.0);
        colour
    }

    fn spectrum(&mut self, spectrum: &Spectrum) -> Spectrum {
        spectrum.clone()
    }

    fn index(&mut self, index: &Dispersion) -> Dispersion {
        index.clone()
    }

    fn distribution(&mut self, roughness: &Roughness) -> Roughness {
        *roughness
    }
}

impl MapAll<Described, Described> for ChangedTextures<'_> {
    fn layered(&mut self, layers: &Box<LayeredDescription>) -> Box<LayeredDescription> {
        let mut layers = layers.clone();
        layers.textures_mut().into_iter().flatten().for_each(&mut *self.0);
        layers
    }

    fn mix(&mut self, mix: &Box<Mix<Described>>) -> Box<Mix<Described>> {
        Box::new(Mix { models: mix.models.each_ref().map(|model| model.map(self)), weight: mix.weight })
    }
}
