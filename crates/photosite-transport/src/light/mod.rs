//! Where light comes from, and how a surface point chooses where to look for it.
//!
//! In: tables of lights in SI units. Out: for a point, a direction with the radiance that arrives from there if nothing
//! is in the way, and the density with which it was chosen. Visibility is left to the integrator.

mod bounds;
mod directional_light;
mod emission;
mod emissive_triangle;
mod environment;
mod light_rays;
mod light_sample_context;
mod lights;
mod point_light;
mod profile;
mod projector;
mod selection;
mod sky;
mod spot_light;
mod sun_position;
mod tree;
#[cfg(test)]
mod tree_tests;
mod triangle_light;

pub use directional_light::DirectionalLight;
pub use emission::{SurfaceEmission, Tint};
pub(crate) use emissive_triangle::EmissiveTriangles;
pub use environment::{Environment, EnvironmentPicture};
pub use light_rays::LightRay;
pub use light_sample_context::{Facing, LightSampleContext};
pub(crate) use lights::LiContext;
pub use lights::{Light, LightSample, LightTables, Lights};
pub use point_light::PointLight;
pub use profile::{Profile, ProfileLight};
pub use projector::{Projector, ProjectorLight};
pub(crate) use selection::Choice;
pub use sky::{Sky, SkyConditions};
pub use spot_light::SpotLight;
pub use sun_position::SunPosition;
pub use triangle_light::TriangleLight;
