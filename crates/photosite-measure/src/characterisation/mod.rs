//! Characterisation of sensors: the image sets and the evaluation of EMVA Standard 1288
//! ([Emva1288](photosite_core::references#emva1288), release 4.0 linear), and estimates of the noise of any image.
//!
//! | step | in | out | module |
//! |---|---|---|---|
//! | plan | a sensor, an [`OperatingPoint`] | exposure times and photons of every image: a [`Plan`] | `plan.rs` |
//! | flats | photons per pixel, exact | planes of digital numbers of one channel: [`FlatField`] | `flat_field.rs` |
//! | files | names of images with what they were taken of | a [`Descriptor`] | `descriptor.rs` |
//! | statistics | images | [`PairStatistics`], [`SpatialStack`] | `pair.rs`, `spatial.rs` |
//! | evaluation | statistics | [`Figures`] with the curves that they came from: [`Evaluation`] | `evaluation.rs` |
//! | truth | the sensor's model | the [`Figures`] that an exact measurement would find | `expected.rs`, `efficiency.rs` |
//!
//! The light is no renderer's: every pixel receives the same number of photons, so that what spreads in an image is the
//! sensor's. Photons are counted on the whole area of a pixel, as the standard does. Symbols are the standard's: μ and
//! σ² are mean and temporal variance, s² is spatial variance, y is in DN, e in electrons, p in photons.
//!
//! [`camera_fit`] finds the parameters of a sensor file in images; [`sensitivities`] finds spectral sensitivities in images of
//! a chart; [`report`] makes a page of an evaluation; [`noise`] estimates the noise of any image. Files are left to
//! `photosite`.

pub mod camera_fit;
mod descriptor;
mod efficiency;
mod evaluation;
mod expected;
mod figures;
mod fit;
mod flat_field;
mod histogram;
pub mod noise;
mod pair;
mod plan;
#[cfg(feature = "report")]
pub mod report;
pub mod sensitivities;
mod spatial;
mod spectrogram;
mod standard_errors;

pub use descriptor::{Descriptor, Light, Series};
pub use efficiency::quantum_efficiency;
pub use evaluation::{
    DarkCurrentFit, DarkPoint, Evaluation, Linearity, NotMeasured, TemporalPoint, doubling_temperature, evaluate,
    responsivity,
};
pub use expected::{effects_left_out, expected_figures};
pub use figures::{Decibel, Figures, Row, SpatialFigures, bound_at_95_percent};
pub use fit::{Line, line, slope_error, through_origin};
pub use flat_field::FlatField;
pub use histogram::Histogram;
pub use pair::PairStatistics;
pub use plan::{OperatingPoint, Plan, Shot};
pub use spatial::{SpatialStack, SpatialVariances};
pub use spectrogram::{Direction, Spectrogram};
pub use standard_errors::RelativeErrors;
