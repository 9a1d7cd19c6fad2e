//! Points of the curves over wavelength and over temperature.

use serde::Serialize;

/// Quantum efficiency at a wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpectralPoint {
    /// nm.
    pub wavelength_nm: f64,
    /// η, 0–1.
    pub expected: f64,
    /// η, 0–1; `None` where the channel is blind.
    pub measured: Option<f64>,
}

/// Dark current at a temperature, e⁻/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ThermalPoint {
    /// °C.
    pub temperature_c: f64,
    /// Dark current of the sensor's model.
    pub expected: f64,
    /// Dark current from the mean of the dark signal; `None` where it is not told apart from 0.
    pub from_mean: Option<f64>,
    /// Dark current from the variance of the dark signal; `None` where it is not told apart from 0.
    pub from_variance: Option<f64>,
}
