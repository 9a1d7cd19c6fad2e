//! Validation: whether two images show the same thing, how far they lie apart, and whether noise explains it.
//!
//! In: two [`ComparedImage`]s of one size, the second of which counts as the reference; where they are Monte Carlo estimates,
//! with the variance of every pixel (of both: a difference has none without). Out: a [`Comparison`] of numbers per
//! channel with z-scores ([`ZScores`]) and a [`Verdict`], what of it is past the [`Limits`] that a user sets, and a
//! [`FalseColour`] image of the differences.
//!
//! Files are left to `photosite::io`.

mod compare;
mod compared_image;
mod false_colour;
mod limits;
mod pair;
mod variance;
mod z_scores;

pub use compare::{ChannelDifference, Comparison, ComparisonSettings, PixelDifference, Verdict, compare};
pub use compared_image::{ComparedImage, MOSAIC};
pub use false_colour::{FalseColour, Shown, false_colour};
pub use limits::{Limits, failures};
pub use pair::VarianceOf;
pub use variance::NonUniformity;
pub use z_scores::{Tail, ZScores};
