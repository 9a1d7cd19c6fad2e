//! What image sets show, for programs.

use serde::Serialize;

use crate::characterisation::report::{ChannelReport, SpectralPoint, ThermalPoint};
use crate::characterisation::{Figures, NotMeasured};

/// The object that `photosite emva1288-report --json` prints for each channel.
#[derive(Serialize)]
pub struct MeasuredChannel<'a> {
    /// Its title in the report.
    pub channel: &'a str,
    /// Its figures, with the standard errors of dark currents; `not_measured` names those that are not told apart from 0.
    pub measured: Figures,
    /// What the images do not tell, and why.
    pub not_measured: Vec<NotMeasured>,
    /// The figures that it is expected to show.
    pub expected: Option<Figures>,
    /// Quantum efficiencies at other wavelengths.
    pub wavelengths: &'a [SpectralPoint],
    /// Dark currents at several temperatures; null where they are not told apart from 0.
    pub temperatures: &'a [ThermalPoint],
    /// Expected and measured.
    pub doubling_temperature_k: Option<[f64; 2]>,
}

impl<'a> MeasuredChannel<'a> {
    /// Of what was evaluated.
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
