//! The noise that numbers will have, in closed form.

mod light_noise;
mod noise_model;
mod warnings;

pub use light_noise::{Neighbours, noise_ratio, samples_needed, smoothed_mean};
