//! Options for frequently changed keys of a capture.

use std::path::{Path, PathBuf};

use clap::Args;

use super::arguments::sides;
use photosite_capture::relative_path;
use photosite_core::{Error, Result};

/// Illuminance of an uncalibrated environment map, lux: an overcast day.
const ILLUMINANCE_LUX: f64 = 10_000.0;

/// The first two are what people change most, and come first in the help.
#[derive(Args)]
pub(super) struct Shorthands {
    /// Samples per pixel: render.samples_per_pixel.
    #[arg(long, value_name = "N", display_order = 0, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Pixels of the image, of the same view: sensor.scaled_to_px. Fewer pixels are larger ones, which have less noise;
    /// for part of the sensor with its own pixels, set sensor.resolution_px.
    #[arg(long, value_name = "WxH", display_order = 0, value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// An image of the surroundings (Radiance HDR, OpenEXR) that lights the scene, with 10 000 lux on the ground unless
    /// --set scene.environment.illuminance_lux says otherwise: scene.environment.
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,
}

impl Shorthands {
    /// Changes to the keys of the capture `input`, around those by `--set`: that of the environment before them, as
    /// they may refine it, the others after.
    ///
    /// # Errors
    ///
    /// There is no such environment.
    pub(super) fn around(&self, changes: Vec<String>, input: &Path) -> Result<Vec<String>> {
        if let Some(file) = &self.env {
            file.metadata().map_err(|reason| Error::io(file, "read", reason))?;
        }
        let folder = input.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let env = self.env.as_ref().map(|file| {
            let file = toml::Value::from(relative_path(file, folder));
            format!("scene.environment={{ image = {file}, illuminance_lux = {ILLUMINANCE_LUX:?} }}")
        });
        let spp = self.spp.map(|samples| format!("render.samples_per_pixel={samples}"));
        let size = self.size.map(|[width, height]| format!("sensor.scaled_to_px=[{width}, {height}]"));
        Ok(env.into_iter().chain(changes).chain(spp).chain(size).collect())
    }
}

/// Parses a size as people write it, `800x600`.
fn parse_size(text: &str) -> Result<[u32; 2], String> {
    sides(text).ok_or_else(|| "write columns and rows, for example 800x600".to_owned())
}
