//! Mathematics that knows nothing of light: frames, cones of directions, warps of the unit square, discrete
//! distributions, hashing, counter-based random numbers, linear equations, minima, floating-point error bounds,
//! probability densities with a measure, the normal and the χ² distribution, statistics, sums of 106 bits, formulas for
//! one number and for eight at a time.

pub mod chi_squared;
pub mod cone;
pub mod distribution;
pub mod double_double;
pub mod float;
pub mod frame;
pub mod hash;
pub mod linear;
pub mod minimise;
pub mod monotone_cubic;
pub mod normal;
pub mod pdf;
pub mod philox;
pub mod statistics;
pub mod warp;

pub use cone::Cone;
pub use frame::Frame;
pub use pdf::{Area, Pdf, SolidAngle};
pub use photosite_simd::{Real, Vector};
