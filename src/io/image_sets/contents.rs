//! `emva1288.json`: which image sets a folder holds, and what they are expected to show.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::characterisation::Figures;
use crate::{Error, Result};
use photosite_core::input;

/// Name of the file.
pub const CONTENTS: &str = "emva1288.json";

/// The image sets of a sensor.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ImageSets {
    /// Version of the program that took them.
    pub photosite_version: String,
    /// Name of the sensor.
    pub sensor: String,
    /// What it is.
    pub description: String,
    /// Keys that were changed.
    pub overrides: Vec<String>,
    /// Seed of the noise.
    pub seed: u64,
    /// Columns and rows of every image.
    pub size_px: [usize; 2],
    /// Gain of all exposures, dB.
    pub gain_db: f64,
    /// The sets of each channel.
    pub channels: Vec<ChannelSets>,
}

/// The image sets of one channel.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ChannelSets {
    /// Name of the channel.
    pub channel: String,
    /// Path of the descriptor of the linear model's set, below the folder.
    pub descriptor: String,
    /// Wavelength of its light, nm.
    pub wavelength_nm: f64,
    /// Temperature of the sensor, °C.
    pub temperature_c: f64,
    /// Figures that it is expected to show.
    pub expected: Figures,
    /// Sets for the quantum efficiency at other wavelengths.
    pub wavelengths: Vec<SpectralSet>,
    /// Sets for the dark current at several temperatures.
    pub temperatures: Vec<ThermalSet>,
    /// Rise of temperature that doubles the dark current, K, as fitted to the expected dark currents; `None` for fewer
    /// than two temperatures.
    pub doubling_temperature_k: Option<f64>,
}

/// A set for the quantum efficiency at one wavelength.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SpectralSet {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Path of the descriptor; `None` where the channel is blind.
    pub descriptor: Option<String>,
    /// η that it is expected to show, 0–1.
    pub quantum_efficiency: f64,
}

/// A set for the dark current at one temperature.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ThermalSet {
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Path of the descriptor.
    pub descriptor: String,
    /// Dark current that it is expected to show, e⁻/s.
    pub dark_current_e_per_s: f64,
}

impl ImageSets {
    /// Reads the file of a folder of image sets.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(CONTENTS);
        let text = input::read_text(&path, input::TREE_BYTES).map_err(|reason| Error::io(&path, "read", reason))?;
        serde_json::from_str(&text)
            .map_err(|error| Error::in_file(&path, "", format!("is not what photosite emva1288 writes: {error}")))
    }
}
