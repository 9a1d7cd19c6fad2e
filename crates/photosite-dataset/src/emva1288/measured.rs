//! Measured figures of image sets, for programs.

use serde::Serialize;

use photosite_measure::characterisation::report::{ChannelReport, SpectralPoint, ThermalPoint};
use photosite_measure::characterisation::{Figures, NotMeasured};

/// Object that `photosite emva1288-report --json` prints for each channel.
#[derive(Serialize)]
pub struct MeasuredChannel<'a> {
    /// Title of the channel in the report.
    pub channel: &'a str,
    /// Measured figures, with the standard errors of dark currents; `not_measured` names those that cannot be told
    /// apart from 0.
    pub measured: Figures,
    /// Figures that the images do not determine, and why.
    pub not_measured: Vec<NotMeasured>,
    /// Expected figures.
    pub expected: Option<Figures>,
    /// Quantum efficiencies at other wavelengths.
    pub wavelengths: &'a [SpectralPoint],
    /// Dark currents at several temperatures; null where they cannot be told apart from 0.
    pub temperatures: &'a [ThermalPoint],
    /// Expected and measured doubling temperature of the dark current, K.
    pub doubling_temperature_k: Option<[f64; 2]>,
}

impl<'a> MeasuredChannel<'a> {
    /// Measured figures of an evaluated channel.
    pub fn new(channel: &'a ChannelReport) -> Self {
        Self {
            channel: &channel.title,
            measured: channel.evaluation.figures,
            not_measured: channel.evaluation.not_measured(),
            expected: channel.expected,
            wavelengths: &channel.spectral,
            temperatures: &channel.thermal,
            doubling_temperature_k: channel.doubling_temperature_k,
        }
    }
}
