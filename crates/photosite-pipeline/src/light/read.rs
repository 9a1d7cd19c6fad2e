//! Light that is read: what a render has stored, and what other programs have computed.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use super::light_file::LightFile;
use super::stored_facts::{ImageScale, StoredFacts};
use super::stored_light::StoredLight;
use super::{Light, Origin};
use photosite_capture::report::LightReport;
use photosite_core::Sandbox;
use photosite_core::image::Planes;
use photosite_core::spectrum::Spectrum;
use photosite_core::{Invalid, Result};
use photosite_files::linear_image::{ImageLight, read_image_light};
use photosite_sensor::without_negative;

impl Light {
    /// Reads a folder that a render has filled, or an EXR file from there: electrons serve any exposure with the sensor
    /// that they were counted for; irradiance serves any sensor. `overrides` change keys of its capture, `key=value`.
    /// Files that either names must lie in the sandbox.
    pub fn read(sandbox: &Sandbox, input: &Path, overrides: &[String]) -> Result<Self> {
        let start = Instant::now();
        let (facts, file) = StoredFacts::read(sandbox, input, overrides)?;
        Self::stored(facts, file, start)
    }

    /// Reads an image of another program, whose pixel values are light on the sensor as `scale` says. `overrides`
    /// change keys of a capture of defaults.
    pub fn of_image(sandbox: &Sandbox, input: &Path, scale: &ImageScale, overrides: &[String]) -> Result<Self> {
        let start = Instant::now();
        if LightFile::read(input).is_ok() {
            let invalid = Invalid::new("", "is stored light, which states itself what it contains");
            return Err(invalid.help("expose it without a unit").in_file(input));
        }
        let ImageLight { planes, assumed, notes } = read_image_light(input, scale.is_linear)?;
        let (mut facts, file) = StoredFacts::of_planes(sandbox, input, &planes, scale, Some(&assumed), overrides)?;
        facts.capture.warnings.extend(notes);
        Self::stored(facts, file, start)
    }

    /// Takes planes of pixel values that are light on the sensor as `scale` says, as [`of_image`](Self::of_image)
    /// takes those of a file. `illuminant` and `name` are as of [irradiance](Self::of_irradiance).
    pub fn of_planes(
        name: &Path,
        planes: &Planes,
        scale: &ImageScale,
        illuminant: Option<&Spectrum>,
        overrides: &[String],
    ) -> Result<Self> {
        let start = Instant::now();
        let (mut facts, file) = StoredFacts::of_planes(&Sandbox::default(), name, planes, scale, None, overrides)?;
        if let Some(illuminant) = illuminant {
            facts.traced.scene_light = Some(LightReport::new(illuminant));
        }
        Self::stored(facts, file, start)
    }

    /// Takes irradiance on the sensor, W·m⁻²·nm⁻¹, in planes that are named by the central wavelengths of their bands
    /// in nm and sorted by them. `illuminant` is the light that the white balance makes neutral, D65 unless one is
    /// given; `name` stands for the file of the light in messages.
    pub fn of_irradiance(
        name: &Path,
        bands: Planes,
        illuminant: Option<&Spectrum>,
        overrides: &[String],
    ) -> Result<Self> {
        let (start, mut warnings) = (Instant::now(), Vec::new());
        let bands = without_negative(&bands, &mut warnings).map_err(|invalid| invalid.in_file(name))?;
        let file = LightFile::Irradiance { path: name.to_owned(), bands: Arc::new(bands) };
        let mut facts = StoredFacts::of_light(&Sandbox::default(), name, &file, overrides)?;
        facts.capture.warnings.extend(warnings);
        facts.traced.scene_light = illuminant.map(LightReport::new);
        Self::stored(facts, file, start)
    }

    fn stored(mut facts: StoredFacts, file: LightFile, start: Instant) -> Result<Self> {
        facts.load_s = start.elapsed().as_secs_f64();
        Ok(Self::new(Origin::Stored(Arc::new(StoredLight::new(facts, None)?), file)))
    }
}
