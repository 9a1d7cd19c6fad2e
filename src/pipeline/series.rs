//! The pictures of a series, one after the other: traced, exposed, developed and written into a folder.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Map, Value};

use super::camera::pixels;
use super::chain::Chain;
use super::checkpoint::Checkpoints;
use super::completed_rows::CompletedRows;
use super::ideal;
use super::light::settings_of_frame;
use super::monitor::Event;
use super::output_folder::OutputFolder;
use super::prepare::Prepared;
use super::request::{LightSource, Request};
use super::results::{Frames, SeriesState, write_results};
use super::strips::Strips;
use super::trace::{Trace, Traced, trace};
use super::truth_views::{FirstViews, Moment, TruthViews};
use crate::calibration::truth::{NotFound, TruthJob, TruthLayer, TruthObject, View, truth};
use crate::capture::{Capture, TruthOutput};
use crate::image::Estimate;
use crate::io::truth::{TruthFormat, fits_png, lost_in_png};
use crate::optics::Camera;
use crate::raw::RawImage;
use crate::report::{NoiseReport, ObjectsReport, Timings};
use crate::scene::{self, Scene};
use crate::sensor::Exposure;
use crate::units::{Decibels, Seconds};
use crate::{Error, Invalid, Result};

/// All that the pictures of a series are made of.
pub(super) struct Series<'a> {
    pub(super) request: &'a Request<'a>,
    pub(super) provenance: &'a Map<String, Value>,
    pub(super) prepared: &'a Prepared,
    pub(super) strips: &'a Strips,
    pub(super) views: TruthViews<'a>,
    /// Counts what truth does not find.
    pub(super) not_found: &'a NotFound,
}

/// What has become of a series.
pub(super) struct Recorded {
    /// `None` for parts, which are not exposed.
    pub(super) exposed: Option<ExposedSeries>,
    /// Paths, over all light that was traced.
    pub(super) paths: u64,
    /// What turned out on the way, each once.
    pub(super) warnings: Vec<String>,
}

/// The last exposure and the first picture.
pub(super) struct ExposedSeries {
    pub(super) exposure: Exposure,
    /// Of each picture, where there is gain control.
    pub(super) gains: Vec<Decibels>,
    pub(super) first: RawImage,
    pub(super) reached: Reached,
}

/// What the samples have given.
pub(super) struct Reached {
    pub(super) samples_per_pixel: u32,
    pub(super) noise_ratio: Option<f64>,
    pub(super) noise: Option<NoiseReport>,
}

impl Reached {
    /// By so many samples of each pixel, and `pilot_paths` beside them that found how many it takes.
    pub(super) fn new(
        chain: &Chain<'_>,
        rates: &Estimate,
        counts: &[u32],
        noise_target: Option<f64>,
        pilot_paths: u64,
    ) -> Self {
        Self {
            samples_per_pixel: counts.iter().copied().max().unwrap_or(0),
            noise_ratio: chain.noise_ratio(rates, counts.iter().copied().min().unwrap_or(0)),
            noise: noise_target.map(|target| chain.noise_report(rates, counts, target, pilot_paths)),
        }
    }
}

impl Series<'_> {
    /// Traces, exposes and writes. Where nothing moves, all frames see the same light, which is traced once.
    pub(super) fn record(&self, folder: &mut OutputFolder, timings: &mut Timings) -> Result<Recorded> {
        let Prepared { capture, scene: first_scene, camera: still, importance, .. } = self.prepared;
        let objects: &[TruthObject] = &self.prepared.objects;
        let count = capture.exposure.frames;
        if let LightSource::Given { frame, .. } = self.request.light {
            let first = FirstViews::new(self.prepared, &self.views)?;
            let next = self.views.next(capture, first_scene, first.next(self.prepared));
            let frames = Frames::One { number: frame, of: 1 };
            let state = &mut SeriesState::default();
            return self.picture((first_scene, objects), &first.camera, next, frames, folder, timings, state);
        }
        let Some(recording) = &capture.recording else {
            let of_series = View::of(first_scene, still, self.prepared.chain().image_grid());
            let next = self.views.next(capture, first_scene, of_series);
            return self.picture(
                (first_scene, objects),
                still,
                next,
                Frames::All(count),
                folder,
                timings,
                &mut SeriesState::default(),
            );
        };
        let mut all = Recorded { exposed: None, paths: 0, warnings: Vec::new() };
        let mut now = Moment { recording: recording.clone(), scene: None };
        let mut state = SeriesState::default();
        for number in 0..count {
            // Only flow looks ahead.
            let mut next = match &self.views.common {
                Some(common) if capture.scene_moves => {
                    Some(self.moment(number + 1, |next| common.build(next), timings)?)
                }
                Some(_) | None => None,
            };
            let later = now.recording.later(1);
            let [camera, next_camera] = [&now.recording, next.as_ref().map_or(&later, |next| &next.recording)]
                .map(|recording| still.clone().recording(recording.clone()));
            let (scene, objects) =
                now.scene.as_ref().map_or((&**first_scene, objects), |(scene, objects)| (scene, objects));
            let next_scene = next.as_ref().and_then(|next| Some(&next.scene.as_ref()?.0)).unwrap_or(scene);
            let of_series = View::of(next_scene, &next_camera, self.prepared.chain().image_grid());
            let view = self.views.next(capture, scene, of_series);
            let frames = Frames::One { number, of: count };
            let recorded = self.picture((scene, objects), &camera, view, frames, folder, timings, &mut state)?;
            let first = all.exposed.map(|ExposedSeries { first, .. }| first);
            all.exposed = recorded.exposed.map(|last| ExposedSeries { first: first.unwrap_or(last.first), ..last });
            all.paths += recorded.paths;
            for warning in recorded.warnings {
                if !all.warnings.contains(&warning) {
                    all.warnings.push(warning);
                }
            }
            if number + 1 == count {
                break;
            }
            if next.is_none() && capture.scene_moves {
                // Two scenes need twice the memory.
                now.scene = None;
                let build = |next: &mut Capture| Ok(scene::build(Arc::unwrap_or_clone(next.take_scene()), importance));
                next = Some(self.moment(number + 1, build, timings)?);
            }
            now = next.unwrap_or(Moment { recording: later, scene: None });
        }
        Ok(all)
    }

    /// The picture of that number of an animated scene.
    fn moment(
        &self,
        number: u32,
        build: impl Fn(&mut Capture) -> Result<Scene>,
        timings: &mut Timings,
    ) -> Result<Moment> {
        let start = Instant::now();
        let mut capture = self.prepared.capture.at_frame(number).map_err(Error::since_begun)?;
        timings.load_s += start.elapsed().as_secs_f64();
        let start = Instant::now();
        let objects = TruthObject::of_scene(&capture.scene);
        let scene = Some((build(&mut capture)?, objects));
        timings.build_s += start.elapsed().as_secs_f64();
        let still = || self.prepared.capture.recording.as_ref().map(|recording| recording.later(number));
        let recording = capture.recording.clone().or_else(still);
        let recording = recording.expect("what is animated is recorded");
        Ok(Moment { recording, scene })
    }

    /// One picture, with the view of the next one.
    #[expect(clippy::too_many_arguments, reason = "a picture, where it goes, and its report")]
    fn picture(
        &self,
        (scene, objects): (&Scene, &[TruthObject]),
        camera: &Camera,
        next: Option<View<'_>>,
        frames: Frames,
        folder: &mut OutputFolder,
        timings: &mut Timings,
        state: &mut SeriesState,
    ) -> Result<Recorded> {
        let prepared = self.prepared;
        let (capture, chain, monitor) = (&prepared.capture, &prepared.chain(), self.request.monitor);
        let number = match frames {
            Frames::One { number, .. } => number,
            Frames::All(_) => 0,
        };
        let mut settings = settings_of_frame(&capture.render, number);
        if let LightSource::Part(samples) = &self.request.light {
            settings.part = Some(samples.clone());
        }
        let grid = chain.image_grid();
        let partner = self.views.partner_of(camera);
        let partner =
            partner.as_ref().map(|(camera, place)| View { scene, camera, place: *place, grid, not_found: None });
        let truth_job = TruthJob { view: View::of(scene, camera, grid), objects, next, partner };
        let mut warnings = check_png(&truth_job, &capture.output.truth)
            .map_err(|invalid| capture.source.error(invalid.within("output")))?;
        warnings.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
        let start = Instant::now();
        let traced = match &self.request.light {
            LightSource::Given { light, .. } => light.traced(),
            LightSource::Merged(parts) => {
                let light = parts.light(frames.light_number(), capture, &prepared.responses, self.strips, folder)?;
                let [width, height] = pixels(capture).map(u64::from);
                let paths = width * height * u64::from(settings.samples_per_pixel);
                Traced { rows: CompletedRows::Light(light, None), paths, pilot_paths: 0, earlier: Duration::ZERO }
            }
            LightSource::Traced | LightSource::Part(_) => {
                let interval = capture.output.checkpoint_interval;
                let number = frames.light_number();
                let is_part = matches!(self.request.light, LightSource::Part(_));
                let checkpoints = Checkpoints::new(
                    folder.path(),
                    folder.is_forced(),
                    number,
                    is_part,
                    settings.samples(),
                    self.provenance,
                    interval,
                );
                let traced = Trace {
                    capture,
                    settings: &settings,
                    scene,
                    camera,
                    responses: &prepared.responses,
                    filters: prepared.filters.as_ref(),
                    importance: std::ptr::eq(scene, &raw const *prepared.scene)
                        .then_some(&*prepared.importance_for_all),
                    strips: self.strips,
                    is_part,
                    is_coarse_first: false,
                    chain,
                    folder: Some(folder),
                    monitor,
                };
                trace(&traced, Some(checkpoints))?
            }
        };
        timings.trace_s += (traced.earlier + start.elapsed()).as_secs_f64();
        let Traced { rows, paths, pilot_paths, .. } = traced;
        let all_paths = paths + pilot_paths;
        let start = Instant::now();
        let light = match rows {
            CompletedRows::Light(light, _) => light,
            CompletedRows::Sums { file, .. } => {
                if frames.begin() {
                    folder.remove_earlier()?;
                }
                folder.write_film(frames.light_number(), file)?;
                timings.write_s += start.elapsed().as_secs_f64();
                return Ok(Recorded { exposed: None, paths: all_paths, warnings });
            }
        };
        let in_folder = |reason: std::io::Error| Error::io(folder.path(), "read from", reason);
        let rates = match &self.request.light {
            LightSource::Given { light, .. } => {
                let (rates, more) = prepared.rates(light)?;
                more.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
                warnings.extend(more);
                rates
            }
            LightSource::Traced | LightSource::Part(_) | LightSource::Merged(_) => {
                Arc::new(light.estimate(chain.channels()).map_err(in_folder)?)
            }
        };
        let counts = light.counts().map_err(in_folder)?;
        let reached = Reached::new(chain, &rates, &counts, settings.noise_target, pilot_paths);
        // Where no pixel stops by itself, all have the same number.
        let counts = settings.noise_target.map(|_| counts);
        let exposed = chain.expose(rates, Seconds(1.0), None)?;
        timings.expose_s += start.elapsed().as_secs_f64();
        let exposure = exposed.exposure;
        // An automatic exposure is one for all pictures.
        if frames.begin() {
            exposed.warnings.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
            warnings.extend_from_slice(&exposed.warnings);
        }
        let first = write_results(monitor, chain, exposed, frames, folder, timings, state, |folder, number| {
            if capture.output.ideal {
                let seen = light.means(ideal::NAMES).to_planes();
                let seen = seen.map_err(|reason| Error::io(folder.path(), "read from", reason))?;
                let picture = ideal::picture(seen, capture, &prepared.light, &exposure)?;
                let picture = match chain.ideal_resampling() {
                    Some(resampling) => resampling.apply(picture),
                    None => picture,
                };
                let [x, y] = capture.sensor.pixel_pitch_m;
                let aspect = if capture.develop.square_pixels { 1.0 } else { x / y };
                folder.write_ideal(number, picture, aspect, &capture.develop)?;
            }
            let truth_job = truth_job.counting(self.not_found);
            if !capture.output.truth.layers.is_empty() {
                let planes = truth(&truth_job, &capture.output.truth.layers);
                folder.write_truth(number, &capture.output.truth, &planes)?;
            }
            if capture.output.objects {
                let report = ObjectsReport::new(&truth_job.view, objects);
                if let Some(warning) = report.warning() {
                    monitor.report(Event::Warning(&warning));
                }
                folder.write_objects(number, &report)?;
            }
            if let Some(counts) = &counts {
                folder.write_samples(number, capture.sensor.resolution, counts)?;
            }
            match &capture.output.irradiance {
                Some(bands) => folder.write_irradiance(number, bands, &light),
                None => Ok(()),
            }
        })?;
        let gains = state.gains.clone();
        Ok(Recorded { exposed: Some(ExposedSeries { exposure, gains, first, reached }), paths: all_paths, warnings })
    }
}

/// Finds truth that no PNG file can hold before light is traced, which may take an hour; returns warnings about
/// what they leave out.
fn check_png(job: &TruthJob<'_>, output: &TruthOutput) -> Result<Vec<String>, Invalid> {
    if !output.formats.contains(&TruthFormat::Png) {
        return Ok(Vec::new());
    }
    let is_bounded = |layer: &TruthLayer| {
        matches!(layer, TruthLayer::Depth | TruthLayer::Distance | TruthLayer::Flow | TruthLayer::Disparity)
    };
    let bounded: Vec<TruthLayer> = output.layers.iter().copied().filter(is_bounded).collect();
    if bounded.is_empty() {
        return Ok(Vec::new());
    }
    let planes = truth(job, &bounded);
    fits_png(&planes, output.depth_unit_m)?;
    Ok(lost_in_png(&planes))
}
