//! Measures of images: sharpness from a slanted edge, colours of a chart, structural similarity, histograms.
//!
//! In: planes of numbers. Out: figures. Differences of two images number by number, with their statistics, are the
//! business of [`validation`](crate::validation); what the figures of a sensor are is left to its characterisation.

mod checker;
mod histogram;
mod mtf;
mod slanted_edges;
mod ssim;
#[cfg(test)]
mod test_images;

pub use checker::{CheckerReport, PatchReport, checker};
pub use histogram::{Histogram, histogram};
pub use mtf::{EdgeResponse, slanted_edge};
pub use slanted_edges::{FoundEdge, slanted_edges};
pub use ssim::ssim;
