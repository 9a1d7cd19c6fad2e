//! Fit of a sensor to the images of a camera: flats and darks become the parameters of a sensor file, each with its
//! standard error.
//!
//! | step | module |
//! |---|---|
//! | images with what they were taken of | `frame_group.rs` |
//! | analysis of variance of the images of one light: temporal noise of pixels, rows, columns | `frame_stack.rs` |
//! | dark signal and noise over time | `dark_model.rs` |
//! | photon transfer: gain, responsivity, saturation | `photon_transfer.rs` |
//! | response that bends | `linearity.rs` |
//! | patterns of averaged images, without shading | `decomposition.rs`, `pattern.rs`, `patterns.rs` |
//! | the patterns themselves, for a twin of this very camera | `pattern_maps.rs` |
//! | pixels that are no part of them | `defects.rs` |
//! | unequal pixels and heavy tails of the read noise | `read_noise_shape.rs` |
//! | statistics of all groups, checked for being of one camera | `survey.rs` |
//! | all of it, in order | `fit.rs` |
//! | parameters, assumptions, what is left out | `parameters.rs`, `sheet.rs` |
//! | noise of the read-out at several gains | `gain_steps.rs` |
//! | the sensor file | `sensor_file.rs` |
//!
//! Figures that are not told apart from 0 (three standard errors) are left out by name, with the bound below which they
//! lie. Nothing that the images do not tell is filled in silently: keys that a sensor file needs are marked as assumed.

mod dark_model;
mod decomposition;
mod defects;
mod fit;
mod frame_group;
mod frame_stack;
mod gain_steps;
mod linearity;
mod lines;
mod measured;
mod parameters;
mod pattern;
mod pattern_maps;
mod patterns;
mod photon_transfer;
mod read_noise_shape;
mod sensor_file;
mod sheet;
mod survey;

pub use dark_model::{DarkAt, DarkFrames, DarkModel};
pub use defects::{Defect, DefectKind};
pub use fit::{CameraFit, fit_camera};
pub use frame_group::{CameraFrames, FrameGroup, FrameLight};
pub use frame_stack::{Parts, StackStatistics};
pub use linearity::Bend;
pub use lines::MeasuredLine;
pub use measured::Measured;
pub use parameters::{Assumption, FittedGainStep, KnownFacts, Parameter};
pub use pattern_maps::{PatternMap, PatternMaps};
pub use photon_transfer::{BrightFrames, PhotonTransfer, Saturation, TransferPoint};
pub use sensor_file::{MapNames, Mosaic};
