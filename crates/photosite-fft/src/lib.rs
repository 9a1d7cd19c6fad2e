//! Fast Fourier transforms, compiled once: the algorithms of `rustfft` are generic, and each crate that plans one compiles
//! all of them, 12 % of all code of the crate of sensors.

use std::sync::Arc;

use rustfft::FftPlanner;

pub use rustfft::Fft;
pub use rustfft::num_complex::{Complex, Complex32, Complex64};

/// A transform of n numbers from places to frequencies.
pub fn forward_f32(length: usize) -> Arc<dyn Fft<f32>> {
    FftPlanner::new().plan_fft_forward(length)
}

/// A transform of n numbers from frequencies to places, without a factor.
pub fn inverse_f32(length: usize) -> Arc<dyn Fft<f32>> {
    FftPlanner::new().plan_fft_inverse(length)
}

/// A transform of n numbers from places to frequencies.
pub fn forward_f64(length: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_forward(length)
}
