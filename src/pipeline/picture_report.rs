//! What a report says of pictures that were made of light that was traced.

use std::collections::BTreeMap;
use std::path::Path;

use super::camera::pixels;
use super::light::Light;
use super::prepare::Prepared;
use super::series::{ExposedSeries, Reached};
use super::shot::Shot;
use crate::Result;
use crate::calibration::targets::PlacedTarget;
use crate::calibration::truth::{NotFound, View};
use crate::capture::Capture;
use crate::io::file_sum::FileSum;
use crate::report::{
    CameraReport, LensReport, LightReport, RenderReport, Report, SCHEMA_VERSION, TargetReport, Timings, TracedReport,
};
use crate::scene::Scene;

/// What was made, and where.
pub(super) struct Made<'a> {
    /// The input as the report names it.
    pub(super) named: String,
    /// The folder that paths in the report are relative to.
    pub(super) folder: &'a Path,
    /// The number of the frame of a single picture, or of the first.
    pub(super) frame: u32,
    pub(super) series: ExposedSeries,
    pub(super) paths: u64,
    /// Those that turned out on the way.
    pub(super) warnings: &'a [String],
    /// Counts what truth did not find.
    pub(super) not_found: &'a NotFound,
    pub(super) fingerprint: Option<&'a str>,
    pub(super) files: Vec<String>,
    pub(super) sums: BTreeMap<String, FileSum>,
    pub(super) timings: Option<Timings>,
}

pub(super) fn picture_report(prepared: &Prepared, made: Made<'_>) -> Result<Report> {
    let Prepared { capture, scene, camera, truth, .. } = prepared;
    let Made { named, folder, frame, series, paths, warnings, not_found, fingerprint, files, sums, timings } = made;
    let ExposedSeries { exposure, gains, first, reached } = series;
    let chain = prepared.chain();
    let traced = TracedReport {
        camera: Some(prepared.camera_report()),
        lens: Some(LensReport::new(&capture.lens, camera, capture.sensor.pixel_pitch_m, &prepared.focus_steps)),
        render: Some(render_report(capture, scene, reached)),
        scene_light: Some(LightReport::new(&prepared.light)),
        targets: Some(prepared.target_reports(not_found)),
        truth: truth.clone(),
        light_warnings: prepared.light_warnings.clone(),
        paths: Some(paths),
        paths_per_s: timings.map(|timings| paths as f64 / timings.trace_s),
    };
    // Of a later frame alone, its capture is not all that decides it.
    let is_first = frame == 0;
    let mut exposure_report = chain.exposure_report(&exposure, &gains);
    exposure_report.frame = (!is_first).then_some(frame);
    Ok(Report {
        schema_version: SCHEMA_VERSION,
        photosite_version: env!("CARGO_PKG_VERSION").to_owned(),
        input: named,
        overrides: capture.overrides().to_vec(),
        capture: capture.to_json(folder)?,
        fingerprint: fingerprint.filter(|_| is_first).map(str::to_owned),
        seed: capture.render.seed,
        traced,
        sensor: chain.sensor_report(&exposure, &first, &capture.sensor_warnings),
        image: chain.image_report(),
        pixel_grid: chain.grid_report(),
        exposure: exposure_report,
        files,
        sums,
        warnings: [prepared.warnings(), warnings, not_found.warning().as_slice()].concat(),
        timings,
    })
}

impl Prepared {
    /// What a report says of a shot in memory: there are no files.
    ///
    /// # Errors
    ///
    /// Values of the capture that cannot be written.
    pub fn report(&self, light: &Light, shot: &Shot, frame: u32) -> Result<Report> {
        let path = self.capture.source.path();
        let (rates, _) = self.rates(light)?;
        let settings = &self.capture.render;
        let reached = Reached::new(&self.chain(), &rates, &light.samples, settings.noise_target, light.pilot_paths());
        let series = ExposedSeries { exposure: shot.exposure, gains: Vec::new(), first: shot.raw.clone(), reached };
        picture_report(
            self,
            Made {
                named: path.display().to_string(),
                folder: Path::new("."),
                frame,
                series,
                paths: light.paths,
                warnings: &shot.warnings,
                not_found: &NotFound::default(),
                fingerprint: None,
                files: Vec::new(),
                sums: BTreeMap::new(),
                timings: None,
            },
        )
    }

    /// Pose and intrinsics of the first picture.
    pub fn camera_report(&self) -> CameraReport {
        let Self { capture, .. } = self;
        CameraReport::new(&capture.lens, &self.camera().halfway(), pixels(capture), capture.recording.as_ref())
    }

    /// The calibration targets of the scene, as the first picture shows them.
    fn target_reports(&self, not_found: &NotFound) -> Vec<TargetReport> {
        let camera = self.camera();
        let view = View::of(&self.scene, &camera, self.chain().image_grid()).counting(not_found);
        let report = |target: &PlacedTarget| TargetReport::new(target, &view);
        self.capture.targets.iter().map(report).collect()
    }
}

fn render_report(capture: &Capture, scene: &Scene, reached: Reached) -> RenderReport {
    let settings = &capture.render;
    let Reached { samples_per_pixel, noise_ratio, noise } = reached;
    RenderReport {
        seed: settings.seed,
        samples_per_pixel,
        max_depth: settings.max_depth,
        roulette_depth: settings.roulette_depth,
        splitting: settings.splitting,
        reuse: settings.reuse,
        light_paths: settings.light_paths,
        wavelengths: settings.wavelengths.name().to_owned(),
        sampler: settings.sampler.name().to_owned(),
        triangles: scene.geometry().triangles.len(),
        lights: scene.lights().len(),
        noise_ratio,
        noise,
    }
}
