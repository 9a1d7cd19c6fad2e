//! Memory needs of steps, known before they are begun.
//!
//! Figures are bytes of a pixel times pixels, and of a triangle times triangles. Those of planes follow from what steps
//! hold at the same time; those of scenes and of files under way are measured. For images of 1 and 4 megapixels, 15
//! settings each, they were between 0.89 and 1.07 times the peak that the system told of.

use std::sync::Arc;

use crate::camera::capture_camera::pixels;
use crate::expose::chain::SensorSettings;
use photosite_calibration::truth::TruthLayer;
use photosite_capture::{Capture, CaptureSource};
use photosite_core::Result;
use photosite_core::memory::{self, Left};
use photosite_develop as develop;
use photosite_files::light_rows::LightRows;
use photosite_sensor::NoiseMap;
use photosite_transport::integrator::bytes_of_landings;
use photosite_transport::optics::LensKind;
use photosite_transport::scene::description::{MeshDescription, SceneDescription};

/// Bytes of a number in a plane.
const FLOAT: u64 = 4;
/// Bytes of a digital number.
const NUMBER: u64 = 2;
/// Bytes of a pixel of a noise map: recorded, cut out, and written.
const NOISE_MAP: u64 = 3 * FLOAT;
/// Bytes of a triangle while its scene is built, and of one that emits light.
const TRIANGLE: u64 = 95;
const SHINING_TRIANGLE: u64 = 300;

/// Memory needs of the images of a capture, bytes.
pub(crate) struct Needs<'a> {
    settings: SensorSettings<'a>,
    pixels: u64,
    /// Bytes beside those of images while light is traced: numbers of samples that pixels are to have, and light on its
    /// way to the rows that it lands in, behind a lens that parts wavelengths.
    under_way: u64,
}

impl<'a> Needs<'a> {
    pub(crate) fn new(settings: SensorSettings<'a>) -> Self {
        let [width, height] = settings.sensor.resolution.map(|n| n as u64);
        Self { settings, pixels: width.saturating_mul(height), under_way: 0 }
    }

    pub(crate) fn of(capture: &'a Capture) -> Self {
        let needs = Self::new(capture.into());
        let wanted = capture.render().noise_target.map_or(0, |_| needs.pixels.saturating_mul(FLOAT));
        Self { under_way: landings(capture).saturating_add(wanted), ..needs }
    }

    fn channels(&self) -> u64 {
        self.settings.sensor.cfa.channels().len() as u64
    }

    /// Number of digital numbers of a pixel.
    fn samples(&self) -> u64 {
        self.settings.sensor.cfa.samples_per_pixel() as u64
    }

    /// Bytes of the finished rows of a film with this many channels, where they are kept in memory.
    pub(crate) fn rows(&self, channels: usize) -> u64 {
        self.pixels.saturating_mul(LightRows::bytes_per_pixel(channels, self.channels() as usize) as u64)
    }

    /// Bytes that tracing takes beside film and rows: images of the state so far, and what is under way.
    pub(crate) fn beside_film(&self) -> u64 {
        if self.settings.output.preview_interval.is_none() {
            return self.under_way;
        }
        let shown = self.channels() * FLOAT;
        let raw = self.samples() * NUMBER + self.developing();
        let preview = shown + (shown + self.reading_out()).max(raw);
        self.pixels.saturating_mul(preview).saturating_add(self.resized()).saturating_add(self.under_way)
    }

    /// Bytes of a pixel for charge and digital numbers while the sensor is read out.
    fn reading_out(&self) -> u64 {
        self.samples() * (FLOAT + NUMBER)
    }

    fn developing(&self) -> u64 {
        develop::bytes_per_pixel(&self.settings.sensor.cfa, self.settings.develop)
    }

    /// Bytes of the pixels that a developed image is resized to.
    fn resized(&self) -> u64 {
        develop::bytes_of_resized(&self.settings.sensor.cfa, self.settings.develop)
    }

    /// Bytes of exposing to light with its variances, of the files written, and of developing.
    pub(crate) fn exposing(&self) -> u64 {
        let light = 2 * self.channels() * FLOAT;
        let output = self.settings.output;
        let maps = (output.noise.maps.len() as u64).min(NoiseMap::ALL.len() as u64) * self.samples() * NOISE_MAP;
        // The sensor is exposed once more, with two maps.
        let clean = if output.noise.maps.contains(&NoiseMap::RawClean) {
            self.reading_out() + 2 * self.samples() * NOISE_MAP
        } else {
            0
        };
        let more_images =
            self.settings.exposure.bracket.as_ref().map_or(0, |bracket| bracket.len() as u64).saturating_sub(1);
        let kept = more_images * self.samples() * NUMBER;
        let other_time = if more_images > 0 { self.channels() * FLOAT } else { 0 };
        let exposing = light + self.reading_out() + maps + clean + other_time + kept;
        let layer = |layer: &TruthLayer| layer.channels().len() as u64 * FLOAT;
        let truth: u64 = output.truth.layers.iter().map(layer).sum();
        let ideal = if output.ideal { 4 * FLOAT } else { 0 };
        let bands = if output.irradiance.is_some() { 3 * FLOAT } else { 0 };
        let writing = light + self.samples() * NUMBER + kept + truth.max(ideal).max(bands);
        let developing = self.samples() * NUMBER + kept + self.developing();
        self.pixels.saturating_mul(exposing.max(writing).max(developing)).saturating_add(self.resized())
    }

    /// Refuses an image that takes more memory than there is.
    pub(crate) fn check(&self, left: Left, bytes: u64) -> Result<()> {
        let [width, height] = self.settings.sensor.resolution;
        let what = format!("an image of {width} × {height} pixels");
        let instead = "lower sensor.resolution_px, or ask for less in [output]";
        left.check(bytes, &what, instead)
            .map_err(|invalid| self.settings.source.error(invalid.within("sensor.resolution_px")))
    }
}

/// Bytes of light that lands in other rows than its path came from.
fn landings(capture: &Capture) -> u64 {
    let (lens, sensor, render) = (capture.lens(), capture.sensor(), capture.render());
    let lands = lens.kind == LensKind::Prescription && !sensor.shutter.scans();
    // Where there is no end to the samples, as many as fit together are traced at once.
    let is_open = render.noise_target.is_some() || render.time_limit_s.is_some();
    let samples = if is_open { u32::MAX } else { render.samples_per_pixel };
    if lands { bytes_of_landings(pixels(capture).map(|n| n as usize), samples) } else { 0 }
}

/// Bytes that building a scene takes.
pub(crate) fn of_scene(scene: &SceneDescription) -> u64 {
    let mut uses = vec![0u64; scene.meshes.len()];
    scene.instances.iter().flat_map(|instance| instance.meshes.clone()).for_each(|mesh| uses[mesh] += 1);
    let of_mesh = |(mesh, uses): (&Arc<MeshDescription>, u64)| {
        let triangles = mesh.triangles.len() as u64;
        let shines = scene.materials.get(mesh.material).is_some_and(|material| material.emission.is_some());
        let shapes = 1 + mesh.later_shapes.len() as u64;
        // What shines or deforms is in the world once an instance, other meshes once for all.
        let copies = if shines || shapes > 1 { uses * shapes } else { uses.min(1) };
        triangles.saturating_mul(copies * if shines { SHINING_TRIANGLE } else { TRIANGLE })
    };
    scene.meshes.iter().zip(uses).map(of_mesh).fold(0, u64::saturating_add)
}

/// Refuses a scene that takes more than there is.
pub(crate) fn check_scene(scene: &SceneDescription, source: &CaptureSource) -> Result<()> {
    let triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    memory::check(of_scene(scene), &format!("a scene of {triangles} triangles"), "simplify it")
        .map_err(|invalid| source.error(invalid.within("scene")))
}
