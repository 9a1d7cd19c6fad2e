//! The kinds of lights without a surface.

use super::delta_model::{DeltaExtent, DeltaModel, LightPose};
use super::directional_light::DirectionalLight;
use super::gaussian_beam::GaussianBeam;
use super::point_light::PointLight;
use super::profile::Profile;
use super::projector::Projector;
use super::sample::{LiContext, LiSample};
use super::spot_light::SpotLight;
use photosite_core::spectrum::SpectrumId;

/// Declares the enumeration of all kinds, which does what the one that it holds does.
macro_rules! light_kinds {
    ($($(#[$doc:meta])* $kind:ident($model:ty) = $name:literal,)*) => {
        /// A kind of light without a surface, with its parameters in its own space, where it shines along −z.
        #[derive(Clone, Debug)]
        pub enum LightKind {
            $($(#[$doc])* $kind($model),)*
        }

        impl LightKind {
            /// Name of the kind, the value of `type` in `[[lights]]` of capture files.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$kind(_) => $name,)*
                }
            }

            /// Factor from the light's spectrum, in the unit of its level, to its spectral power, W·nm⁻¹. `disk_m2` is
            /// the area across which a light infinitely far lights the scene.
            pub fn power_factor(&self, disk_m2: f64) -> f64 {
                match self {
                    $(Self::$kind(model) => model.power_factor(disk_m2),)*
                }
            }

            pub(super) fn extent(&self, pose: &LightPose) -> Option<DeltaExtent> {
                match self {
                    $(Self::$kind(model) => model.extent(pose),)*
                }
            }

            #[inline]
            pub(super) fn sample_li(
                &self,
                pose: &LightPose,
                level: SpectrumId,
                u: [f32; 2],
                li: &LiContext<'_>,
            ) -> Option<LiSample> {
                match self {
                    $(Self::$kind(model) => model.sample_li(pose, level, u, li),)*
                }
            }
        }
    };
}

light_kinds! {
    /// Intensity (cd) equal in all directions.
    Point(PointLight) = "point",
    /// Intensity (cd) within a cone, falling off smoothly between two angles.
    Spot(SpotLight) = "spot",
    /// Illuminance (lux) on a plane across the direction, from infinitely far.
    Directional(DirectionalLight) = "directional",
    /// Intensity by a measured profile; the level is by what its candela are multiplied.
    Profile(Profile) = "profile",
    /// Flux (lm) of a white slide that a lens throws.
    Projector(Projector) = "projector",
    /// Flux (lm) of a laser beam, or of one spread to a line.
    GaussianBeam(GaussianBeam) = "gaussian-beam",
}
