//! The enumeration of all models, made from their list in `bsdf/mod.rs`.

/// Makes the enumeration of models from their list. Dispatch is by enumeration: all of it that is hot is inlined.
macro_rules! models {
    ($($(#[$doc:meta])* $model:ident,)*) => {
        /// A scattering model with its parameters in the form `F`.
        pub enum Model<F: Form> {
            $($(#[$doc])* $model($model<F>),)*
            /// glTF 2.0's material with its extensions.
            Layered(F::Layered),
            /// Mix of two models side by side, finer than the eye resolves.
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

        impl<F: Form> std::fmt::Debug for Model<F> {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                match self {
                    $(Self::$model(model) => model.fmt(f),)*
                    Self::Layered(layered) => layered.fmt(f),
                    Self::Mix(mix) => mix.fmt(f),
                }
            }
        }

        impl<F: Form> Model<F> {
            /// Returns the model with its parameters in another form.
            pub fn map<T: Form>(&self, map: &mut impl MapAll<F, T>) -> Model<T> {
                match self {
                    $(Self::$model(model) => Model::$model(model.map(map)),)*
                    Self::Layered(layered) => Model::Layered(map.layered(layered)),
                    Self::Mix(mix) => Model::Mix(map.mix(mix)),
                }
            }

            /// Returns what `finish` makes of the BSDF, and of whether it refracts; None for models that are made of
            /// others. Each arm makes the whole, so that none copies a BSDF, which is large.
            #[inline]
            pub(crate) fn look_up<R>(
                &self,
                map: &mut impl Map<F, Sampled>,
                finish: impl Fn(bool, Model<Sampled>) -> R,
            ) -> Option<R> {
                match self {
                    $(Self::$model(model) => {
                        Some(finish(<$model as lobe::Lobe>::REFRACTS, Model::$model(model.map(map))))
                    })*
                    Self::Layered(_) | Self::Mix(_) => None,
                }
            }
        }

        impl<F: TableForm> Model<F> {
            /// Returns the traits that are known before paths are traced; `None` for models that are made of others.
            pub(crate) fn scene_traits(&self) -> Option<&dyn SceneTraits> {
                match self {
                    $(Self::$model(model) => Some(model),)*
                    Self::Layered(_) | Self::Mix(_) => None,
                }
            }
        }

        impl Model<Sampled> {
            /// Value and density of scattering between `wo` and `wi`. Both are zero where the model does not scatter
            /// that way, for mirrors and polished interfaces, and for directions in the surface.
            #[inline]
            pub fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
                match self {
                    $(Self::$model(model) => model.eval(wo, wi),)*
                    Self::Layered(layered) => layered.eval(wo, wi),
                    Self::Mix(never) => match *never {},
                }
            }

            /// Draws `wi` from three numbers in [0, 1): one to choose a lobe, two for the direction in it. None where
            /// the direction drawn leads nowhere; the light of such a draw counts as lost.
            #[inline]
            pub fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
                match self {
                    $(Self::$model(model) => model.sample(wo, u_lobe, u),)*
                    Self::Layered(layered) => layered.sample(wo, u_lobe, u),
                    Self::Mix(never) => match *never {},
                }
            }

            /// Returns the traits of the lobes. Always inlined: who asks for one trait pays for no other.
            #[inline(always)]
            pub fn traits(&self) -> Traits {
                match self {
                    $(Self::$model(model) => model.traits(),)*
                    Self::Layered(layered) => layered.traits(),
                    Self::Mix(never) => match *never {},
                }
            }

            /// The part of the light from `wo` that goes straight on through a pane, to −`wo`: that of the lobe of this
            /// single direction.
            #[inline]
            pub fn straight(&self, wo: Vec3) -> SampledSpectrum {
                match self {
                    $(Self::$model(model) => model.straight(wo),)*
                    Self::Layered(layered) => layered.straight(wo),
                    Self::Mix(never) => match *never {},
                }
            }

            /// Whether the surface separates two media, so that the frame keeps its side, whichever side is seen.
            #[inline]
            pub fn refracts(&self) -> bool {
                match self {
                    $(Self::$model(_) => <$model as lobe::Lobe>::REFRACTS,)*
                    Self::Layered(layered) => !layered.is_two_sided(),
                    Self::Mix(never) => match *never {},
                }
            }
        }
    };
}
