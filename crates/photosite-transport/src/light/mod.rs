//! Where light comes from, and how a surface point chooses where to look for it.
//!
//! In: tables of lights in SI units. Out: for a point, a direction with the radiance that arrives from there if nothing
//! is in the way, and the density with which it was chosen. Visibility is left to the integrator.

mod bounds;
mod emission;
mod emitters;
mod environment;
mod facet;
mod lights;
mod profile;
mod projector;
mod receiver;
mod selection;
mod sky;
mod sun_position;
mod tree;
#[cfg(test)]
mod tree_tests;

pub use emission::{SurfaceEmission, Tint};
pub use emitters::Emission;
pub use environment::{Environment, EnvironmentPicture};
pub(crate) use facet::Facets;
pub use lights::{Lamps, Light, LightSample, Lights, TriangleLight};
pub use profile::Profile;
pub use projector::Projector;
pub use receiver::{Facing, Receiver};
pub(crate) use selection::Choice;
pub use sky::{Sky, SkyConditions};
pub use sun_position::SunPosition;
