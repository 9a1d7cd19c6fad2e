//! Prediction of the noise of digital numbers, in closed form.

mod light_noise;
mod noise_by_gain;
mod noise_model;
mod shares;
mod warnings;

pub use light_noise::{LightNoise, Neighbours, samples_needed, sensor_noise, smoothed_mean};
pub use noise_by_gain::{GainLine, NoiseAtGain};
#[cfg(test)]
mod tests;
