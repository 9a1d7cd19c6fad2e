//! Lenses as optical engineers specify them: a [`Prescription`] of surfaces and glasses, traced ray by ray.
//!
//! Lengths are mm, the unit of prescriptions. The axis is z, z = 0 is the vertex of the first surface that light from
//! the scene meets, and +z points to the sensor. Wavelengths are nm in air, the medium of glass catalogues, whose index
//! counts as 1. [`files`] reads prescriptions of seven programs' formats from bytes; this crate touches no file on
//! disk.

#![forbid(unsafe_code)]

pub mod checks;
pub mod chief;
pub mod chief_map;
pub mod coating;
pub mod entrance_table;
pub mod files;
mod films;
pub mod focus;
mod full_beam;
pub mod glass;
pub mod illumination;
mod lane_surface;
pub mod lanes;
pub mod lens;
mod outline;
pub mod paraxial;
pub mod point_spread;
pub mod positions;
pub mod prescription;
pub mod profile;
pub mod pupil_table;
pub mod region;
pub mod spots;
pub mod spread_table;
mod stop_map;
mod support_polygon;
pub mod trace;
pub mod wave;
pub mod wavefront;

pub use lens::Lens;
pub use prescription::Prescription;
pub use trace::{LensAt, Ray};
