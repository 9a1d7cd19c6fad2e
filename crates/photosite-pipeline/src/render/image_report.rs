//! Reports of images: facts about light, sensor and exposure.

use std::collections::BTreeMap;
use std::path::Path;

use super::image_series::Reached;
use crate::camera::capture_camera::pixels;
use crate::expose::chain::Chain;
use crate::expose::shot::Shot;
use crate::prepare::prepared::Prepared;
use crate::trace::traced_light::TracedLight;
use photosite_calibration::targets::PlacedTarget;
use photosite_calibration::truth::{NotFound, View};
use photosite_capture::Capture;
use photosite_capture::report::{
    CameraReport, LensReport, LightReport, RenderReport, Report, SCHEMA_VERSION, TargetReport, TracedReport,
};
use photosite_core::Result;
use photosite_core::units::Decibels;
use photosite_raw::RawImage;
use photosite_sensor::Exposure;
use photosite_transport::scene::Scene;
use serde_json::Value;

/// Image of a report: the last exposure and the first raw image of a series.
pub(crate) struct Taken<'a> {
    pub(crate) exposure: &'a Exposure,
    pub(crate) raw: &'a RawImage,
    /// Gains that gain control has found.
    pub(crate) gains: &'a [Decibels],
    /// Number of the frame of a single image, or of the first.
    pub(crate) frame: u32,
}

impl<'a> Taken<'a> {
    pub(crate) fn of(shot: &'a Shot) -> Self {
        Self { exposure: &shot.exposure, raw: &shot.raw, gains: &[], frame: shot.frame }
    }
}

/// Report of an image of that light, but for its files, warnings and times.
pub(crate) fn report_of(
    chain: &Chain<'_>,
    traced: TracedReport,
    taken: &Taken<'_>,
    sensor_warnings: &[String],
    capture: Value,
) -> Report {
    let mut exposure = chain.exposure_report(taken.exposure, taken.gains);
    exposure.frame = (taken.frame > 0).then_some(taken.frame);
    Report {
        schema_version: SCHEMA_VERSION,
        photosite_version: env!("CARGO_PKG_VERSION").to_owned(),
        input: String::new(),
        overrides: Vec::new(),
        capture,
        fingerprint: None,
        seed: chain.settings.seed,
        traced,
        sensor: chain.sensor_report(taken.exposure, taken.raw, sensor_warnings),
        image: chain.image_report(),
        pixel_grid: chain.grid_report(),
        exposure,
        files: Vec::new(),
        sums: BTreeMap::new(),
        warnings: Vec::new(),
        timings: None,
    }
}

impl Prepared {
    /// Report of an image of light of `paths` paths, but for its files and times; paths of files are relative to a
    /// folder. `warnings` are those that turned out on the way.
    pub(crate) fn report_of(
        &self,
        taken: &Taken<'_>,
        (reached, paths): (Reached, u64),
        (warnings, not_found): (&[String], &NotFound),
        folder: &Path,
    ) -> Result<Report> {
        let Self { capture, scene, camera, truth, .. } = self;
        let traced = TracedReport {
            camera: Some(self.camera_report()),
            lens: Some(LensReport::new(capture.lens(), camera, capture.sensor().pixel_pitch_m, &self.focus_steps)),
            render: Some(render_report(capture, scene, reached)),
            scene_light: Some(LightReport::new(&self.light)),
            targets: Some(self.target_reports(not_found)),
            truth: truth.clone(),
            light_warnings: self.light_warnings.clone(),
            paths: Some(paths),
            paths_per_s: None,
        };
        let report = report_of(&self.chain(), traced, taken, capture.sensor_warnings(), capture.to_json(folder)?);
        let warnings = [self.warnings(), warnings, not_found.warning().as_slice()].concat();
        Ok(Report { overrides: capture.overrides().to_vec(), warnings, ..report })
    }

    /// Report of a shot in memory: there are no files.
    pub(crate) fn report(&self, light: &TracedLight, shot: &Shot) -> Result<Report> {
        let (rates, _) = self.rates(light)?;
        let target = self.capture.render().noise_target;
        let reached = Reached::new(&self.chain(), &rates, &light.samples, target, light.pilot_paths, light.plan);
        let taken = Taken::of(shot);
        let said = (&*shot.warnings, &NotFound::default());
        let report = self.report_of(&taken, (reached, light.paths), said, Path::new("."))?;
        Ok(Report { input: self.capture.source().path().display().to_string(), ..report })
    }

    /// Report of pose and intrinsics of the camera for the first image.
    pub fn camera_report(&self) -> CameraReport {
        let Self { capture, .. } = self;
        CameraReport::new(capture.lens(), &self.camera().halfway(), pixels(capture), capture.recording())
    }

    /// Reports of the calibration targets of the scene, as the first image shows them.
    fn target_reports(&self, not_found: &NotFound) -> Vec<TargetReport> {
        let camera = self.camera();
        let view = View::of(&self.scene, &camera, self.chain().image_grid()).counting(not_found);
        let report = |target: &PlacedTarget| TargetReport::new(target, &view);
        self.capture.targets().iter().map(report).collect()
    }
}

fn render_report(capture: &Capture, scene: &Scene, reached: Reached) -> RenderReport {
    let settings = capture.render();
    let Reached { samples_per_pixel, light_noise, noise, plan } = reached;
    RenderReport {
        seed: settings.seed,
        samples_per_pixel,
        max_depth: settings.max_depth,
        roulette_depth: settings.roulette_depth,
        splitting: plan.map_or(settings.splitting(), |plan| plan.splitting),
        light_paths: plan.map_or(settings.light_paths(), |plan| plan.light_paths),
        plan,
        wavelengths: settings.wavelengths,
        sampler: settings.sampler,
        device: capture.device().map(|device| device.name()),
        triangles: scene.geometry().triangles.len(),
        lights: scene.lights().len(),
        noise_ratio: light_noise.and_then(|noise| noise.ratio),
        saturated_part: light_noise.map(|noise| noise.saturated_part).filter(|&part| part > 0.0),
        noise,
    }
}
