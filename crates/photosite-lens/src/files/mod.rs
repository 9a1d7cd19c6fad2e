//! Lens files: photosite's own form and those of seven optical programs are read into the neutral
//! [`Prescription`](crate::Prescription), with a report of what was read, assumed and ignored.
//!
//! Nothing here touches a disk: readers get bytes, and the path only for messages and for what its ending says of the
//! format.

mod beam;
mod deeplens;
mod draft;
mod finish;
mod format;
mod json_value;
mod neutral;
mod optical_bench;
mod optiland;
mod patent;
mod pbrt;
mod rayoptics;
mod read;
mod report;
mod rims;
mod sanity;
mod seq;
mod shipped;
mod text;
mod write;
mod zmx;
mod zoom;

pub use self::format::{Format, endings, formats};
pub use self::read::{read, read_with};
pub use self::report::{GlassOf, Reading, Report};
pub use self::seq::FirstNumber;
pub use self::shipped::{names, shipped};
pub use self::write::to_toml;
