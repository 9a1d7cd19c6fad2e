//! `emva1288.json`: the image sets in a folder, and the figures that they are expected to show.

use std::path::Path;

use serde::{Deserialize, Serialize};

use photosite_core::input;
use photosite_core::{Error, Result};
use photosite_measure::characterisation::Figures;

/// Name of the file.
pub const CONTENTS: &str = "emva1288.json";

/// Image sets of a sensor.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ImageSets {
    /// Version of the program that took the images.
    pub photosite_version: String,
    /// Name of the sensor.
    pub sensor: String,
    /// Description of the sensor.
    pub description: String,
    /// Changes to the sensor, `key=value`.
    pub overrides: Vec<String>,
    /// Seed of the noise.
    pub seed: u64,
    /// Columns and rows of every image.
    pub size_px: [usize; 2],
    /// Gain of all exposures, dB.
    pub gain_db: f64,
    /// Image sets of each channel.
    pub channels: Vec<ChannelSets>,
}

/// Image sets of one channel.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ChannelSets {
    /// Name of the channel.
    pub channel: String,
    /// Path of the descriptor of the linear model's set, below the folder.
    pub descriptor: String,
    /// Wavelength of the light of the linear model's set, nm.
    pub wavelength_nm: f64,
    /// Temperature of the sensor, °C.
    pub temperature_c: f64,
    /// Figures that the sets are expected to show.
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
    /// Expected quantum efficiency η, 0–1.
    pub quantum_efficiency: f64,
}

/// A set for the dark current at one temperature.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ThermalSet {
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Path of the descriptor.
    pub descriptor: String,
    /// Expected dark current, e⁻/s.
    pub dark_current_e_per_s: f64,
}

impl ImageSets {
    /// Reads the contents file of a folder of image sets.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(CONTENTS);
        let text = input::read_text(&path, input::TREE_BYTES).map_err(|reason| Error::io(&path, "read", reason))?;
        serde_json::from_str(&text)
            .map_err(|error| Error::in_file(&path, "", format!("is not what photosite emva1288 writes: {error}")))
    }
}
