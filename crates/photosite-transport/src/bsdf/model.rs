//! The list of scattering models, and what each of them has to say.
//!
//! A model is one type with its parameters in one of three [`Form`]s: as a file states them, as handles into the tables of
//! a scene, and as values at a shading point. [`Model::map`] takes them from one form to the next; what the steps are for a
//! colour, a spectrum, an index or a roughness is a [`Map`], the same for all models. At a shading point, where the form is
//! [`Sampled`], the model is a [`Bsdf`](super::Bsdf) and every type is a `Lobe`.
//!
//! To add a model: a file with its parameters, `map`, [`SceneTraits`] and `Lobe`; its row in the list at the end of this
//! file; its table and its row in those of capture files; its element for Mitsuba; its cases in `tests/physics`.

use std::convert::Infallible;
use std::fmt::Debug;

use glam::Vec3;

use super::layered::Layered;
use super::microfacet::Ggx;
use super::{BsdfEval, BsdfSample, Conductor, Dielectric, Diffuse, OrenNayar, Phong, ThinDielectric, Translucent};
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
    /// Two models side by side.
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
    /// One of two was chosen.
    type Mix = Infallible;
}

/// A form whose spectra are handles into the tables of a scene.
pub trait TableForm: Form<Spectrum = SpectrumId, Index = RelativeIndex<SpectrumId>, Distribution = Ggx> {}

/// A refractive index relative to the medium outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeIndex<T = SampledSpectrum> {
    /// n_inside/n_outside. Equal at all wavelengths unless dispersive.
    pub eta: T,
    /// Whether it depends on wavelength.
    pub dispersive: bool,
}

impl RelativeIndex {
    /// The same index at all wavelengths.
    pub fn constant(eta: f32) -> Self {
        Self { eta: SampledSpectrum::splat(eta), dispersive: false }
    }
}

/// Two models side by side.
#[derive(Clone, Debug)]
pub struct Mix<F: Form> {
    /// Both.
    pub models: [Model<F>; 2],
    /// The part of the second, 0–1.
    pub weight: f32,
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

/// What light transport asks of a model before it traces a path.
pub trait SceneTraits {
    /// Whether it may leave a path with one wavelength.
    fn disperses(&self) -> bool {
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
}

/// Makes the enumeration of models from their list. Dispatch is by enumeration: all of it that is hot is inlined.
macro_rules! models {
    ($($(#[$doc:meta])* $model:ident,)*) => {
        /// A scattering model with its parameters in the form `F`.
        pub enum Model<F: Form> {
            $($(#[$doc])* $model($model<F>),)*
            /// glTF 2.0's material with its extensions.
            Layered(F::Layered),
            /// Two models side by side, finer than the eye sees.
            Mix(F::Mix),
        }

        impl<F: Form> Clone for Model<F> {
            #[inline]
            fn clone(&self) -> Self {
                match self {
                    $(Self::$model(model) => Self::$model(model.clone()),)*
                    Self::Layered(layered) => Self::Layered(layered.clone()),
                    Self::Mix(mix) => Self::Mix(mix.clone()),
                }
            }
        }

        impl<F: Form> Debug for Model<F> {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                match self {
                    $(Self::$model(model) => model.fmt(f),)*
                    Self::Layered(layered) => layered.fmt(f),
                    Self::Mix(mix) => mix.fmt(f),
                }
            }
        }

        impl<F: Form> Model<F> {
            /// The same model with its parameters in another form.
            pub fn map<T: Form>(&self, map: &mut impl MapAll<F, T>) -> Model<T> {
                match self {
                    $(Self::$model(model) => Model::$model(model.map(map)),)*
                    Self::Layered(layered) => Model::Layered(map.layered(layered)),
                    Self::Mix(mix) => Model::Mix(map.mix(mix)),
                }
            }

            /// What `finish` makes of the BSDF, and of whether it refracts; None for models that are made of others. Each arm
            /// makes the whole, so that none copies a BSDF, which is large.
            #[inline]
            pub(crate) fn look_up<R>(
                &self,
                map: &mut impl Map<F, Sampled>,
                finish: impl Fn(bool, Model<Sampled>) -> R,
            ) -> Option<R> {
                match self {
                    $(Self::$model(model) => {
                        Some(finish(<$model as Lobe>::REFRACTS, Model::$model(model.map(map))))
                    })*
                    Self::Layered(_) | Self::Mix(_) => None,
                }
            }
        }

        impl<F: TableForm> Model<F> {
            /// What the model says of itself; None for those that are made of others.
            pub(crate) fn scene_traits(&self) -> Option<&dyn SceneTraits> {
                match self {
                    $(Self::$model(model) => Some(model),)*
                    Self::Layered(_) | Self::Mix(_) => None,
                }
            }
        }

        impl Model<Sampled> {
            /// Value and density of scattering between `wo` and `wi`. Both are zero where the model does not scatter that way,
            /// for mirrors and polished interfaces, and for directions in the surface.
            #[inline]
            pub fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
                match self {
                    $(Self::$model(model) => model.eval(wo, wi),)*
                    Self::Layered(layered) => layered.eval(wo, wi),
                    Self::Mix(never) => match *never {},
                }
            }

            /// Draws `wi` from three numbers in [0, 1): one to choose a lobe, two for the direction in it. None where the
            /// direction drawn leads nowhere; the light of such a draw counts as lost.
            #[inline]
            pub fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
                match self {
                    $(Self::$model(model) => model.sample(wo, u_lobe, u),)*
                    Self::Layered(layered) => layered.sample(wo, u_lobe, u),
                    Self::Mix(never) => match *never {},
                }
            }

            /// What is known of its lobes.
            #[inline]
            pub fn traits(&self) -> Traits {
                match self {
                    $(Self::$model(model) => model.traits(),)*
                    Self::Layered(layered) => layered.traits(),
                    Self::Mix(never) => match *never {},
                }
            }

            /// Whether both sides are of different media, so that the frame stays on its side, whichever is seen.
            #[inline]
            pub fn refracts(&self) -> bool {
                match self {
                    $(Self::$model(_) => <$model as Lobe>::REFRACTS,)*
                    Self::Layered(layered) => !layered.is_two_sided(),
                    Self::Mix(never) => match *never {},
                }
            }
        }
    };
}

impl<F: Form> Copy for Model<F>
where
    F::Colour: Copy,
    F::Spectrum: Copy,
    F::Index: Copy,
    F::Distribution: Copy,
    F::Layered: Copy,
    F::Mix: Copy,
{
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
}
