//! Series of images, one after the other: traced, exposed, developed and written into a folder.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Map, Value};

use super::request::{LightSource, Request};
use super::results::{Frames, Results};
use crate::camera::capture_camera::pixels;
use crate::camera::film_responses::IDEAL;
use crate::expose::chain::Chain;
use crate::expose::frame_series::FrameSeries;
use crate::monitor::Event;
use crate::prepare::prepared::Prepared;
use crate::prepare::strips::Strips;
use crate::prepare::truth_views::{FirstViews, Moment, TruthViews};
use crate::trace::completed_rows::CompletedRows;
use crate::trace::trace_job::{Trace, Traced, trace};
use crate::trace::traced_light::settings_of_frame;
use crate::write::checkpoint::Checkpoints;
use crate::write::output_folder::OutputFolder;
use photosite_calibration::truth::{NotFound, TruthJob, TruthLayer, TruthObject, View, truth};
use photosite_capture::report::{NoiseReport, ObjectsReport, PlanReport, Timings};
use photosite_capture::{Capture, TruthOutput};
use photosite_core::image::Estimate;
use photosite_core::units::{Decibels, Seconds};
use photosite_core::{Error, Invalid, Result};
use photosite_files::truth::{TruthFormat, fits_png, lost_in_png};
use photosite_raw::RawImage;
use photosite_sensor::{Exposure, LightNoise};
use photosite_transport::optics::Camera;
use photosite_transport::scene::{self, Scene};

/// Inputs of the images of a series.
pub(crate) struct ImageSeries<'a> {
    pub(crate) request: &'a Request<'a>,
    pub(crate) provenance: &'a Map<String, Value>,
    pub(crate) prepared: &'a Prepared,
    pub(crate) strips: &'a Strips,
    pub(crate) views: TruthViews<'a>,
    /// Count of points that ground truth does not find.
    pub(crate) not_found: &'a NotFound,
}

/// Result of a series.
pub(crate) struct Recorded {
    /// Exposed images; `None` for parts, which are not exposed.
    pub(crate) exposed: Option<ExposedSeries>,
    /// Number of paths, over all light that was traced.
    pub(crate) paths: u64,
    /// Plan of the last light.
    pub(crate) plan: Option<PlanReport>,
    /// Warnings that turned out on the way, each once.
    pub(crate) warnings: Vec<String>,
}

/// Last exposure of a series, and its first image.
pub(crate) struct ExposedSeries {
    pub(crate) exposure: Exposure,
    /// Gain of each image, where there is gain control.
    pub(crate) gains: Vec<Decibels>,
    pub(crate) first: RawImage,
    pub(crate) reached: Reached,
    /// Name of the card that has exposed, or the warning that the processor has; `None` without a card.
    pub(crate) device: Option<Result<String, String>>,
}

/// Samples and paths that tracing has reached.
pub(crate) struct Reached {
    pub(crate) samples_per_pixel: u32,
    pub(crate) light_noise: Option<LightNoise>,
    pub(crate) noise: Option<NoiseReport>,
    pub(crate) plan: Option<PlanReport>,
}

impl Reached {
    /// Judges rates of `counts` samples of each pixel, and `pilot_paths` beside them that found how many it takes.
    pub(crate) fn new(
        chain: &Chain<'_>,
        rates: &Estimate,
        counts: &[u32],
        noise_target: Option<f64>,
        pilot_paths: u64,
        plan: Option<PlanReport>,
    ) -> Self {
        Self {
            samples_per_pixel: counts.iter().copied().max().unwrap_or(0),
            light_noise: chain.light_noise(rates, counts.iter().copied().min().unwrap_or(0)),
            noise: noise_target.map(|target| chain.noise_report(rates, counts, target, pilot_paths)),
            plan,
        }
    }
}

impl ImageSeries<'_> {
    /// Traces, exposes and writes. Where nothing moves, all frames see the same light, which is traced once.
    pub(crate) fn record(&self, folder: &mut OutputFolder, timings: &mut Timings) -> Result<Recorded> {
        let Prepared { capture, scene: first_scene, camera: still, importance, .. } = self.prepared;
        let objects: &[TruthObject] = &self.prepared.objects;
        let count = capture.exposure().frames;
        let begin = self.request.light.begin();
        let series = FrameSeries::new(
            self.prepared.chain().on(self.request.light.card()),
            &capture.output().noise.maps,
            begin.clone(),
        );
        let results = &mut Results { series, folder, timings, monitor: self.request.monitor, device: None };
        if let LightSource::Given(_) = self.request.light {
            let first = FirstViews::new(self.prepared, &self.views)?;
            let next = self.views.next(capture, first_scene, first.next(self.prepared));
            let frames = Frames::One { number: begin.0, of: 1 };
            return self.image((first_scene, objects), &first.camera, next, frames, results);
        }
        let Some(recording) = capture.recording() else {
            let of_series = View::of(first_scene, still, self.prepared.chain().image_grid());
            let next = self.views.next(capture, first_scene, of_series);
            return self.image((first_scene, objects), still, next, Frames::All(count), results);
        };
        let mut all = Recorded { exposed: None, paths: 0, plan: None, warnings: Vec::new() };
        let mut now = Moment { recording: recording.clone(), scene: None };
        for number in 0..count {
            // Only flow looks ahead.
            let mut next = match &self.views.common {
                Some(common) if capture.scene_moves() => {
                    Some(self.moment(number + 1, |next| common.build(next), results.timings)?)
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
            let recorded = self.image((scene, objects), &camera, view, frames, results)?;
            let first = all.exposed.map(|ExposedSeries { first, .. }| first);
            all.exposed = recorded.exposed.map(|last| ExposedSeries { first: first.unwrap_or(last.first), ..last });
            all.paths += recorded.paths;
            all.plan = recorded.plan;
            for warning in recorded.warnings {
                if !all.warnings.contains(&warning) {
                    all.warnings.push(warning);
                }
            }
            if number + 1 == count {
                break;
            }
            if next.is_none() && capture.scene_moves() {
                // Two scenes need twice the memory.
                now.scene = None;
                let build = |next: &mut Capture| Ok(scene::build(Arc::unwrap_or_clone(next.take_scene()), importance));
                next = Some(self.moment(number + 1, build, results.timings)?);
            }
            now = next.unwrap_or(Moment { recording: later, scene: None });
        }
        Ok(all)
    }

    /// Moment of an animated scene in which the image of that number is taken.
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
        let objects = TruthObject::of_scene(capture.scene());
        let scene = Some((build(&mut capture)?, objects));
        timings.build_s += start.elapsed().as_secs_f64();
        let still = || self.prepared.capture.recording().map(|recording| recording.later(number));
        let recording = capture.recording().cloned().or_else(still);
        let recording = recording.expect("what is animated is recorded");
        Ok(Moment { recording, scene })
    }

    /// Traces, exposes and writes an image, with the view of the next one.
    fn image(
        &self,
        (scene, objects): (&Scene, &[TruthObject]),
        camera: &Camera,
        next: Option<View<'_>>,
        frames: Frames,
        results: &mut Results<'_>,
    ) -> Result<Recorded> {
        let prepared = self.prepared;
        let (capture, chain, monitor) =
            (&prepared.capture, prepared.chain().on(self.request.light.card()), self.request.monitor);
        let folder = &mut *results.folder;
        let mut settings = settings_of_frame(capture.render(), frames.first());
        if let LightSource::Part(samples) = &self.request.light {
            settings.part = Some(samples.clone());
        }
        let grid = chain.image_grid();
        let partner = self.views.partner_of(camera);
        let partner =
            partner.as_ref().map(|(camera, place)| View { scene, camera, place: *place, grid, not_found: None });
        let truth_job = TruthJob { view: View::of(scene, camera, grid), objects, next, partner };
        let mut warnings = check_png(&truth_job, &capture.output().truth)
            .map_err(|invalid| capture.source().error(invalid.within("output")))?;
        warnings.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
        let start = Instant::now();
        let traced = match &self.request.light {
            LightSource::Given(given) => given.light.traced(),
            LightSource::Merged(parts) => {
                let light = parts.light(frames.light_number(), capture, &prepared.responses, self.strips, folder)?;
                let [width, height] = pixels(capture).map(u64::from);
                let paths = width * height * u64::from(settings.samples_per_pixel);
                Traced {
                    rows: CompletedRows::Light(light, None),
                    paths,
                    pilot_paths: 0,
                    plan: parts.first().plan,
                    earlier: Duration::ZERO,
                }
            }
            LightSource::Traced | LightSource::Part(_) => {
                let interval = capture.output().checkpoint_interval;
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
                    prepared,
                    job: prepared.job(scene, camera, &settings),
                    strips: self.strips,
                    is_coarse_first: false,
                    folder: Some(folder),
                    monitor,
                };
                trace(&traced, Some(checkpoints))?
            }
        };
        results.timings.trace_s += (traced.earlier + start.elapsed()).as_secs_f64();
        let Traced { rows, paths, pilot_paths, plan, .. } = traced;
        let all_paths = paths + pilot_paths;
        let start = Instant::now();
        let light = match rows {
            CompletedRows::Light(light, _) => light,
            CompletedRows::Sums { file, .. } => {
                if frames.begin() {
                    folder.remove_earlier()?;
                }
                folder.write_film(frames.light_number(), file)?;
                results.timings.write_s += start.elapsed().as_secs_f64();
                return Ok(Recorded { exposed: None, paths: all_paths, plan, warnings });
            }
        };
        let in_folder = |reason: std::io::Error| Error::io(folder.path(), "read from", reason);
        let rates = match &self.request.light {
            LightSource::Given(given) => {
                let (rates, more) = prepared.rates(given.light)?;
                more.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
                warnings.extend(more);
                rates
            }
            LightSource::Traced | LightSource::Part(_) | LightSource::Merged(_) => {
                Arc::new(light.estimate(chain.channels()).map_err(in_folder)?)
            }
        };
        let counts = light.counts().map_err(in_folder)?;
        let reached = Reached::new(&chain, &rates, &counts, settings.noise_target, pilot_paths, plan);
        // Where no pixel stops by itself, all have the same number.
        let counts = settings.noise_target.map(|_| counts);
        let exposed = chain.expose(rates, Seconds(1.0), None)?;
        results.timings.expose_s += start.elapsed().as_secs_f64();
        let exposure = exposed.exposure;
        // An automatic exposure is one for all images.
        if frames.begin() {
            exposed.warnings.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
            warnings.extend_from_slice(&exposed.warnings);
        }
        let first = results.write(exposed, frames, |folder, number| {
            if capture.output().ideal {
                let seen = light.means(IDEAL).to_planes();
                let seen = seen.map_err(|reason| Error::io(folder.path(), "read from", reason))?;
                let image = chain.ideal(seen, &prepared.light, &exposure)?;
                let [x, y] = capture.sensor().pixel_pitch_m;
                let aspect = if capture.develop().square_pixels { 1.0 } else { x / y };
                folder.write_ideal(number, image, aspect, capture.develop())?;
            }
            let truth_job = truth_job.counting(self.not_found);
            if !capture.output().truth.layers.is_empty() {
                let planes = truth(&truth_job, &capture.output().truth.layers);
                folder.write_truth(number, &capture.output().truth, &planes)?;
            }
            if capture.output().objects {
                let report = ObjectsReport::new(&truth_job.view, objects);
                if let Some(warning) = report.warning() {
                    monitor.report(Event::Warning(&warning));
                }
                folder.write_objects(number, &report)?;
            }
            if let Some(counts) = &counts {
                folder.write_samples(number, capture.sensor().resolution, counts)?;
            }
            match &capture.output().irradiance {
                Some(bands) => folder.write_irradiance(number, bands, &light),
                None => Ok(()),
            }
        })?;
        let gains = results.series.gains.clone();
        Ok(Recorded {
            exposed: Some(ExposedSeries { exposure, gains, first, reached, device: results.device.clone() }),
            paths: all_paths,
            plan,
            warnings,
        })
    }
}

/// Refuses ground truth that no PNG file can hold before light is traced, which may take an hour; returns warnings
/// about what they leave out.
fn check_png(job: &TruthJob<'_>, output: &TruthOutput) -> Result<Vec<String>, Invalid> {
    if !output.formats.contains(&TruthFormat::Png) {
        return Ok(Vec::new());
    }
    let bounded: Vec<TruthLayer> = output.layers.iter().copied().filter(|layer| layer.png().is_bounded()).collect();
    if bounded.is_empty() {
        return Ok(Vec::new());
    }
    let planes = truth(job, &bounded);
    fits_png(&planes, output.depth_unit_m)?;
    Ok(lost_in_png(&planes))
}
