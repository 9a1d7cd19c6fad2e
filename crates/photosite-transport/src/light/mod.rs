//! Light sources, and how a surface point samples them.
//!
//! In: tables of lights in SI units. Out: for a point, a direction with the radiance that arrives from there if nothing
//! is in the way, and the density with which it was chosen. Visibility is left to the integrator.

mod above_mean;
mod area_light;
mod bounds;
mod choice;
mod delta_light;
mod delta_model;
mod directional_light;
mod emission;
mod emissive_triangle;
mod emitter;
mod emitter_shape;
mod emitters;
mod environment;
mod gaussian_beam;
mod kind;
mod light_rays;
mod light_sample_context;
mod lights;
pub mod packed;
mod point_light;
mod profile;
mod projector;
mod sample;
mod selection;
mod sky;
mod spot_light;
mod sun_position;
mod tree;
#[cfg(test)]
mod tree_tests;

pub use area_light::AreaLight;
pub(crate) use choice::Choice;
pub use delta_light::DeltaLight;
pub use delta_model::LightPose;
pub use directional_light::DirectionalLight;
pub use emission::{SurfaceEmission, Tint};
pub(crate) use emissive_triangle::EmissiveTriangles;
pub(crate) use emitter::{Emitter, EmitterShape};
pub use environment::{Environment, EnvironmentImage};
pub use gaussian_beam::GaussianBeam;
pub use kind::LightKind;
pub use light_rays::LightRay;
pub use light_sample_context::{Facing, LightSampleContext};
pub use lights::{Light, Lights};
pub use point_light::PointLight;
pub use profile::Profile;
pub use projector::Projector;
pub(crate) use sample::LiContext;
pub use sample::LightSample;
pub use sky::{Sky, SkyConditions, SkyLight};
pub use spot_light::SpotLight;
pub use sun_position::SunPosition;
