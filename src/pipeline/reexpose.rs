//! New exposures, sensors and noise from stored light.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use super::exposed_render::ExposedRender;
use super::monitor::Monitor;
use super::output_folder::OutputFolder;
use super::stored::{PictureScale, Stored};
use super::stored_light::StoredLight;
use crate::capture::ExposureSettings;
use crate::develop::DevelopSettings;
use crate::image::Planes;
use crate::io::linear_picture::{PictureLight, read_picture_light};
use crate::report::{LightReport, Report};
use crate::sensor::{SensorModel, without_negative};
use crate::spectrum::Spectrum;
use crate::{Error, Invalid, Result};
use photosite_core::Sandbox;

/// Light that was traced before, with what is known of it, to be exposed again.
#[derive(Clone)]
pub struct StoredRender {
    input: PathBuf,
    overrides: Vec<String>,
    stored: Stored,
    light: Arc<StoredLight>,
    load_s: f64,
}

impl StoredRender {
    /// Reads a folder that a render has filled, or an EXR file from there: electrons serve any exposure with the sensor
    /// that they were counted for; irradiance serves any sensor. `overrides` change keys of its capture, `key=value`.
    /// Files that either names must lie in the sandbox.
    pub fn read(sandbox: &Sandbox, input: &Path, overrides: &[String]) -> Result<Self> {
        let start = Instant::now();
        let (stored, light) = Stored::read(sandbox, input, overrides)?;
        let load_s = start.elapsed().as_secs_f64();
        Ok(Self { input: input.to_owned(), overrides: overrides.to_vec(), stored, light: Arc::new(light), load_s })
    }

    /// Reads a picture of another program, whose numbers are light on the sensor as `scale` says. `overrides` change keys
    /// of a capture of defaults.
    pub fn of_picture(sandbox: &Sandbox, input: &Path, scale: &PictureScale, overrides: &[String]) -> Result<Self> {
        let start = Instant::now();
        if StoredLight::read(input).is_ok() {
            let invalid = Invalid::new("", "is stored light, which states itself what it contains");
            return Err(invalid.help("expose it without a unit").in_file(input));
        }
        let PictureLight { planes, assumed, notes } = read_picture_light(input, scale.is_linear)?;
        let (mut stored, light) = Stored::of_planes(sandbox, input, &planes, scale, Some(&assumed), overrides)?;
        stored.capture.warnings.extend(notes);
        let load_s = start.elapsed().as_secs_f64();
        Ok(Self { input: input.to_owned(), overrides: overrides.to_vec(), stored, light: Arc::new(light), load_s })
    }

    /// Takes planes of numbers that are light on the sensor as `scale` says, as [`of_picture`](Self::of_picture) takes
    /// those of a file. `illuminant` and `name` are as of [irradiance](Self::of_irradiance).
    pub fn of_planes(
        name: &Path,
        planes: &Planes,
        scale: &PictureScale,
        illuminant: Option<&Spectrum>,
        overrides: &[String],
    ) -> Result<Self> {
        let (mut stored, light) = Stored::of_planes(&Sandbox::default(), name, planes, scale, None, overrides)?;
        if let Some(illuminant) = illuminant {
            stored.traced.scene_light = Some(LightReport::new(illuminant));
        }
        Ok(Self { input: name.to_owned(), overrides: overrides.to_vec(), stored, light: Arc::new(light), load_s: 0.0 })
    }

    /// Takes irradiance on the sensor, W·m⁻²·nm⁻¹, in planes that are named by the central wavelengths of their bands in
    /// nm and sorted by them. `illuminant` is the light that the white balance makes neutral, D65 unless one is given;
    /// `name` stands for the file of the light in messages.
    pub fn of_irradiance(
        name: &Path,
        bands: Planes,
        illuminant: Option<&Spectrum>,
        overrides: &[String],
    ) -> Result<Self> {
        let mut warnings = Vec::new();
        let bands = without_negative(&bands, &mut warnings).map_err(|invalid| invalid.in_file(name))?;
        let light = StoredLight::Irradiance { path: name.to_owned(), bands: Arc::new(bands) };
        let mut stored = Stored::of_light(&Sandbox::default(), name, &light, overrides)?;
        stored.capture.warnings.extend(warnings);
        stored.traced.scene_light = illuminant.map(LightReport::new);
        Ok(Self { input: name.to_owned(), overrides: overrides.to_vec(), stored, light: Arc::new(light), load_s: 0.0 })
    }

    /// The same light with more changes to keys of its capture, `key=value`. A sensor that sees light in another way
    /// needs the irradiance, which is read where the folder holds it.
    ///
    /// # Errors
    ///
    /// A key that light transport has used, a value that cannot be used, a sensor or a time that this light does not
    /// serve.
    pub fn with(&self, changes: &[String]) -> Result<Self> {
        let overrides = [&self.overrides[..], changes].concat();
        match self.stored.with(&self.light, changes)? {
            Some(stored) => Ok(Self { stored, overrides, ..self.clone() }),
            None => Self::read(self.stored.capture.source.sandbox(), &self.input, &overrides),
        }
    }

    /// Whether its light tells what a sensor sees: as the one that it was traced for, or by irradiance that is stored, too.
    pub fn tells_of(&self, sensor: &SensorModel) -> bool {
        let own = &self.stored.capture.sensor;
        let has_irradiance =
            || self.input.is_dir() && light_names("irradiance").iter().any(|n| self.input.join(n).exists());
        match *self.light {
            StoredLight::Irradiance { .. } => true,
            StoredLight::Electrons { .. } => {
                own.cfa.channels() == sensor.cfa.channels() && own.responses() == sensor.responses() || has_irradiance()
            }
        }
    }

    /// The sensor that its light falls on, as it is now.
    pub fn sensor(&self) -> &SensorModel {
        &self.stored.capture.sensor
    }

    /// How it is exposed.
    pub fn exposure(&self) -> &ExposureSettings {
        &self.stored.capture.exposure
    }

    /// Seed of the sensor's noise.
    pub fn seed(&self) -> u64 {
        self.stored.capture.seed
    }

    /// How it is developed.
    pub fn develop_settings(&self) -> &DevelopSettings {
        &self.stored.capture.develop
    }

    /// A problem with a key of its capture.
    pub fn error(&self, invalid: Invalid) -> Error {
        self.stored.capture.source.error(invalid)
    }

    /// The changes to keys that it was read with, `key=value`.
    pub fn overrides(&self) -> &[String] {
        &self.overrides
    }

    /// The tables of its capture, as [`Capture::to_table`](crate::capture::Capture::to_table) has them.
    ///
    /// # Errors
    ///
    /// As there.
    pub fn to_table(&self) -> Result<toml::Table> {
        self.stored.capture.to_table()
    }

    /// Exposes the sensor to it once, so that it can be read out as often as one likes.
    ///
    /// # Errors
    ///
    /// An exposure that the sensor cannot make, or for which there is too little light; that it takes more memory than
    /// there is.
    pub fn expose(self) -> Result<ExposedRender> {
        let Self { input, overrides, stored, light, load_s } = self;
        ExposedRender::new(stored, Arc::unwrap_or_clone(light), (input, overrides), load_s)
    }

    /// Exposes and develops it into a folder, the report last, which is returned.
    pub fn expose_into(self, folder: &mut OutputFolder, monitor: &dyn Monitor) -> Result<Report> {
        self.expose()?.write_into(folder, monitor)
    }
}

/// Names of a file of light: alone, and of the first picture of a series.
fn light_names(kind: &str) -> [String; 2] {
    [format!("{kind}.exr"), format!("{kind}-0000.exr")]
}
