//! `photosite render`: trace, expose, develop, write.

use std::cell::OnceCell;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use glam::DAffine3;
use photosite::calibration::targets::PlacedTarget;
use photosite::calibration::truth::{TruthJob, TruthLayer, View, truth};
use photosite::film::{Response, band_response};
use photosite::geometry::{Hit, Ray};
use photosite::integrator::{FilterTile, WavelengthChoice};
use photosite::io::capture::{Capture, NextPicture, REPORT, TruthOutput, relative_path};
use photosite::io::truth::{TruthFormat, fits_png, lost_in_png};
use photosite::math::hash::hash64;
use photosite::optics::{Camera, Focus, LensDescription, PixelGrid};
use photosite::raw::RawImage;
use photosite::scene::{self, Scene, spectral_coverage};
use photosite::sensor::{Exposure, LeftCharge, SensorModel};
use photosite::spectrum::Spectrum;
use photosite::units::Seconds;
use photosite::{Error, Invalid, Result};
use serde_json::{Map, Value};

use super::chain::{Chain, Optics, scene_light};
use super::checkpoint::Checkpoints;
use super::film_memory::{FilmMemory, Strips};
use super::ideal;
use super::kept_rows::KeptRows;
use super::other_pictures::{ChangedPicture, Common, Moment, partner_camera};
use super::output_folder::OutputFolder;
use super::parts::{PartReport, Parts, check_samples, makings};
use super::report::{
    CameraReport, LensReport, LightReport, NoiseReport, RenderReport, Report, TargetReport, Timings, TracedReport,
    TruthReport,
};
use super::results::{Frames, write_results};
use super::run_args::RunArgs;
use super::trace::{Trace, Traced, trace};
use super::{parse_range, print_json, rounded};

/// Render a scene as the camera of a capture file records it.
///
/// INPUT is a capture file (.toml) or a scene (.gltf, .glb, .obj), which then gets a camera that frames it, daylight, the
/// default lens and the default sensor.
#[derive(Args)]
pub(super) struct RenderArgs {
    /// A capture file (.toml) or a scene (.gltf, .glb, .obj).
    input: PathBuf,
    /// Trace these samples of every pixel only: from A up to, but without, B. `photosite merge` makes the picture of all parts.
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    samples: Option<Range<u32>>,
    #[command(flatten)]
    film_memory: FilmMemory,
    #[command(flatten)]
    common: RunArgs,
}

pub(super) fn run(args: &RenderArgs) -> Result<()> {
    let RunArgs { output, quiet, json, force, .. } = &args.common;
    args.common.start_threads()?;
    let start = Instant::now();
    let overrides = args.common.overrides();
    let capture = Capture::read(&args.input, &overrides)?;
    let timings = Timings { load_s: start.elapsed().as_secs_f64(), ..Timings::default() };
    let mut folder = OutputFolder::claim(&output.clone().unwrap_or_else(|| default_folder(&args.input)), *force)?;
    let request = Request {
        input: &args.input,
        named: relative_path(&args.input, folder.path()),
        overrides,
        light: args.samples.clone().map_or(Light::Traced, Light::Part),
        film_memory: args.film_memory,
        quiet: *quiet,
        silent: *quiet || *json,
        is_timed: true,
    };
    let rendered = render(capture, &request, &mut folder, timings)?;
    finish(&rendered, &folder, *quiet, *json)
}

/// Where the light of a render comes from.
pub(super) enum Light {
    /// It is traced.
    Traced,
    /// These samples of it are, which make no picture yet.
    Part(Range<u32>),
    /// It was.
    Merged(Parts),
}

/// What of a render does not stand in its capture.
pub(super) struct Request<'a> {
    pub(super) input: &'a Path,
    /// The same as reports call it: as it reads from their folder, or from the data set file.
    pub(super) named: String,
    pub(super) overrides: Vec<String>,
    pub(super) light: Light,
    pub(super) film_memory: FilmMemory,
    /// Whether warnings are kept from the user.
    pub(super) quiet: bool,
    /// Whether progress is.
    pub(super) silent: bool,
    /// Whether the report says how long it took, which differs from run to run.
    pub(super) is_timed: bool,
}

/// A render that is done and written.
pub(super) enum Rendered {
    Picture { report: Box<Report>, paths: u64, timings: Timings },
    Part(PartReport),
}

/// Renders a capture into a folder, the report last. `timings` holds what has passed before.
pub(super) fn render(
    mut capture: Capture,
    request: &Request<'_>,
    folder: &mut OutputFolder,
    mut timings: Timings,
) -> Result<Rendered> {
    match &request.light {
        Light::Traced => {}
        Light::Part(samples) => check_samples(samples, &capture)?,
        Light::Merged(parts) => parts.check(&capture)?,
    }
    let start = Instant::now();
    let responses = responses(&capture);
    let strips = request.film_memory.strips(&capture, responses.len())?;
    let importance = importance_of_light(&responses);
    let filters = filters(&capture);
    let description = std::mem::take(&mut capture.scene);
    let mut warnings = description.warnings.clone();
    warnings.extend(spectral_coverage::warning(&description, &seen_through_lens(&capture)));
    let truth_report = TruthReport::new(&capture.output.truth, &description, capture.recording.as_ref());
    let flows = capture.output.truth.layers.contains(&TruthLayer::Flow);
    let common = flows.then(|| Common { surfaces: description.surfaces(), importance: &importance });
    let scene = scene::build(description, &importance);
    let camera = place_camera(&capture, |ray| scene.closest(ray))?;
    if let (Focus::Autofocus { pixel: [x, y] }, true) = (capture.lens.focus, camera.focus_distance_m().is_infinite()) {
        warnings
            .push(format!("autofocus: pixel {x}, {y} sees nothing to focus on, so the lens is focused at infinity"));
    }
    warnings.extend(settings_in_vain(&capture, &scene));
    let light = scene_light(&capture, &scene)?;
    let optics = Optics {
        f_number: Some(capture.lens.f_number),
        focal_length_m: Some(capture.lens.focal_length_m),
        transmittance: capture.lens.transmittance.clone(),
    };
    let chain = Chain::new((&capture).into(), optics, &light, None, &mut warnings)?;
    let chain = chain.with_lens(&capture.lens, &camera, &mut warnings);
    if !request.quiet {
        warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    }
    timings.build_s = start.elapsed().as_secs_f64();

    let changed =
        common.as_ref().map(|common| ChangedPicture::read(request.input, &request.overrides, &capture, &scene, common));
    let place = capture.output.truth.partner.filter(|_| capture.output.truth.layers.contains(&TruthLayer::Disparity));
    let partner = place.map(|place| Ok((partner_camera(&capture, &camera, place, &scene)?, place)));
    let makings = makings(&capture)?;
    let traced = Series {
        input: request.input,
        makings: &makings,
        overrides: &request.overrides,
        source: &request.light,
        capture: &capture,
        scene: &scene,
        camera: &camera,
        light: &light,
        chain: &chain,
        responses: &responses,
        importance: &importance,
        filters: filters.as_ref(),
        strips,
        common,
        changed: changed.transpose()?.flatten(),
        partner: partner.transpose()?,
        quiet: request.quiet,
    };
    let recorded = traced.record(folder, &mut timings, request.silent);
    let recorded = recorded.map_err(|error| folder.since_claimed(error))?;
    let Recorded { shot, paths, warnings: more } = recorded;
    warnings.extend(more);
    let Some(Shot { exposure, first, reached }) = shot else {
        let samples = capture.render.samples_per_pixel;
        let part = PartReport::new(request, samples, makings, &responses, folder.files(), timings.trace_s);
        folder.write_part(&part)?;
        return Ok(Rendered::Part(part));
    };
    if let Light::Merged(parts) = &request.light {
        timings.trace_s = parts.trace_s().unwrap_or(0.0);
    }

    let first_camera = match &capture.recording {
        Some(recording) => camera.clone().recording(recording.clone()),
        None => camera.clone(),
    };
    let still = first_camera.halfway();
    let report_target =
        |target: &PlacedTarget| TargetReport::new(target, &View::of(&scene, &first_camera, pixels(&capture)));
    let traced = TracedReport {
        camera: CameraReport::new(&capture.lens, &still, pixels(&capture), capture.recording.as_ref()),
        lens: LensReport::new(&capture.lens, &camera),
        render: render_report(&capture, &scene, reached),
        scene_light: LightReport::new(&light),
        targets: capture.targets.iter().map(report_target).collect(),
        truth: truth_report,
        paths,
        paths_per_s: request.is_timed.then(|| paths as f64 / timings.trace_s),
    };
    let report = Report {
        photosite_version: env!("CARGO_PKG_VERSION"),
        input: request.named.clone(),
        overrides: request.overrides.clone(),
        capture: capture.to_json(folder.path())?,
        seed: capture.render.seed,
        traced: traced.into_map(),
        sensor: chain.sensor_report(&exposure, &first),
        image: chain.image_report(),
        exposure: chain.exposure_report(&exposure),
        files: folder.files(),
        warnings,
        timings: request.is_timed.then_some(timings),
    };
    folder.write_report(&report)?;
    Ok(Rendered::Picture { report: Box::new(report), paths, timings })
}

/// All that the pictures of a series are made of.
struct Series<'a> {
    input: &'a Path,
    makings: &'a Map<String, Value>,
    overrides: &'a [String],
    source: &'a Light,
    capture: &'a Capture,
    scene: &'a Scene,
    camera: &'a Camera,
    light: &'a Spectrum,
    chain: &'a Chain<'a>,
    responses: &'a [Response],
    importance: &'a Spectrum,
    filters: Option<&'a FilterTile>,
    strips: Strips,
    /// Where flow is asked for.
    common: Option<Common<'a>>,
    /// The next picture, if it is that of a changed capture and flow is asked for.
    changed: Option<ChangedPicture>,
    /// The camera of the partner where this one stands, and partner → camera, if disparity is asked for.
    partner: Option<(Camera, DAffine3)>,
    /// Whether warnings are kept from the user.
    quiet: bool,
}

/// What has become of a series.
struct Recorded {
    /// `None` for parts, which are not exposed.
    shot: Option<Shot>,
    /// Paths, over all light that was traced.
    paths: u64,
    /// What turned out on the way, each once.
    warnings: Vec<String>,
}

/// The last exposure and the first picture.
struct Shot {
    exposure: Exposure,
    first: RawImage,
    reached: Reached,
}

/// What the samples have given.
struct Reached {
    samples_per_pixel: u32,
    noise_ratio: Option<f64>,
    noise: Option<NoiseReport>,
}

impl Series<'_> {
    /// Traces, exposes and writes. Where nothing moves, all frames see the same light, which is traced once.
    fn record(&self, folder: &mut OutputFolder, timings: &mut Timings, silent: bool) -> Result<Recorded> {
        let count = self.capture.exposure.frames;
        let Some(recording) = &self.capture.recording else {
            let next = self.next(self.scene, View::of(self.scene, self.camera, pixels(self.capture)));
            return self.picture(self.scene, self.camera, next, Frames::All(count), folder, timings, &mut None, silent);
        };
        let mut all = Recorded { shot: None, paths: 0, warnings: Vec::new() };
        let mut now = Moment { recording: recording.clone(), scene: None };
        // Charge that stays in the sensor from frame to frame.
        let mut left = None;
        for number in 0..count {
            // Only flow looks ahead.
            let mut next = match &self.common {
                Some(common) if self.capture.scene_moves => {
                    Some(self.moment(number + 1, |capture| common.build(capture), timings)?)
                }
                Some(_) | None => None,
            };
            let later = now.recording.later(1);
            let [camera, next_camera] = [&now.recording, next.as_ref().map_or(&later, |next| &next.recording)]
                .map(|recording| self.camera.clone().recording(recording.clone()));
            let scene = now.scene.as_ref().unwrap_or(self.scene);
            let next_scene = next.as_ref().and_then(|next| next.scene.as_ref()).unwrap_or(scene);
            let view = self.next(scene, View::of(next_scene, &next_camera, pixels(self.capture)));
            let frames = Frames::One { number, of: count };
            let recorded = self.picture(scene, &camera, view, frames, folder, timings, &mut left, silent)?;
            let first = all.shot.map(|Shot { first, .. }| first);
            all.shot = recorded.shot.map(|last| Shot { first: first.unwrap_or(last.first), ..last });
            all.paths += recorded.paths;
            for warning in recorded.warnings {
                if !all.warnings.contains(&warning) {
                    all.warnings.push(warning);
                }
            }
            if number + 1 == count {
                break;
            }
            if next.is_none() && self.capture.scene_moves {
                // Two scenes need twice the memory.
                now.scene = None;
                let build =
                    |capture: &mut Capture| Ok(scene::build(std::mem::take(&mut capture.scene), self.importance));
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
        let mut capture = Capture::read_frame(self.input, self.overrides, number).map_err(Error::since_begun)?;
        timings.load_s += start.elapsed().as_secs_f64();
        let start = Instant::now();
        let scene = Some(build(&mut capture)?);
        timings.build_s += start.elapsed().as_secs_f64();
        let still = || self.capture.recording.as_ref().map(|recording| recording.later(number));
        let recording = capture.recording.clone().or_else(still);
        let recording = recording.expect("what is animated is recorded");
        Ok(Moment { recording, scene })
    }

    /// The picture that flow leads to from one of `scene`, after which `of_series` comes.
    fn next<'b>(&'b self, scene: &'b Scene, of_series: View<'b>) -> Option<View<'b>> {
        match &self.capture.output.truth.next {
            NextPicture::OfSeries => Some(of_series),
            NextPicture::Changed(_) => self.changed.as_ref().map(|changed| changed.view(scene)),
            NextPicture::None => None,
        }
    }

    /// One picture, with the view of the next one.
    #[expect(clippy::too_many_arguments, reason = "a picture, where it goes, and what is told of it")]
    fn picture(
        &self,
        scene: &Scene,
        camera: &Camera,
        next: Option<View<'_>>,
        frames: Frames,
        folder: &mut OutputFolder,
        timings: &mut Timings,
        left: &mut Option<LeftCharge>,
        silent: bool,
    ) -> Result<Recorded> {
        let Self { capture, chain, .. } = *self;
        let mut settings = capture.render.clone();
        if let Frames::One { number: number @ 1.., .. } = frames {
            // Noise of light that stays in its place from frame to frame would pass for a pattern.
            settings.seed = hash64(settings.seed, u64::from(number));
        }
        if let Light::Part(samples) = self.source {
            settings.part = Some(samples.clone());
        }
        let resolution = pixels(capture);
        let partner = self.partner.as_ref().map(|(partner, place)| (partner.clone().moving_as(camera), *place));
        let partner = partner.as_ref().map(|(camera, place)| View { scene, camera, place: *place, resolution });
        let truth_job = TruthJob { view: View::of(scene, camera, resolution), next, partner };
        let mut warnings = check_png(&truth_job, &capture.output.truth)
            .map_err(|invalid| capture.source.error(invalid.within("output")))?;
        if !self.quiet {
            warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
        }
        let start = Instant::now();
        let traced = match self.source {
            Light::Merged(parts) => {
                let light = parts.light(frames.light_number(), capture, self.responses, self.strips, folder)?;
                let [width, height] = pixels(capture).map(u64::from);
                let paths = width * height * u64::from(settings.samples_per_pixel);
                Traced { rows: KeptRows::Light(light), paths, pilot_paths: 0, earlier: Duration::ZERO }
            }
            Light::Traced | Light::Part(_) => {
                let interval = capture.output.checkpoint_interval;
                let number = frames.light_number();
                let is_part = matches!(self.source, Light::Part(_));
                let checkpoints = Checkpoints::new(folder, number, is_part, settings.samples(), self.makings, interval);
                let traced = Trace {
                    capture,
                    settings: &settings,
                    scene,
                    camera,
                    responses: self.responses,
                    filters: self.filters,
                    strips: self.strips,
                    is_part,
                    chain,
                    folder,
                    silent,
                };
                trace(&traced, checkpoints)?
            }
        };
        timings.trace_s += (traced.earlier + start.elapsed()).as_secs_f64();
        let Traced { rows, paths, pilot_paths, .. } = traced;
        let all_paths = paths + pilot_paths;
        let start = Instant::now();
        let light = match rows {
            KeptRows::Light(light) => light,
            KeptRows::Sums { file, .. } => {
                if frames.numbers().0.start == 0 {
                    folder.remove_earlier()?;
                }
                folder.write_film(frames.light_number(), file)?;
                timings.write_s += start.elapsed().as_secs_f64();
                return Ok(Recorded { shot: None, paths: all_paths, warnings });
            }
        };
        let in_folder = |reason: std::io::Error| Error::io(folder.path(), "read from", reason);
        let rates = light.estimate(chain.channels()).map_err(in_folder)?;
        let counts = light.counts().map_err(in_folder)?;
        let reached = Reached {
            samples_per_pixel: counts.iter().copied().max().unwrap_or(0),
            noise_ratio: chain.noise_ratio(&rates, counts.iter().copied().min().unwrap_or(0)),
            noise: settings.noise_target.map(|target| chain.noise_report(&rates, &counts, target, pilot_paths)),
        };
        // Where no pixel stops by itself, all have the same number.
        let counts = settings.noise_target.map(|_| counts);
        let exposed = chain.expose(rates, Seconds(1.0), None)?;
        timings.expose_s += start.elapsed().as_secs_f64();
        let exposure = exposed.exposure;
        // An automatic exposure is one for all pictures.
        if let Some(warning) = exposed.warning.clone().filter(|_| frames.numbers().0.start == 0) {
            if !self.quiet {
                eprintln!("warning: {warning}");
            }
            warnings.push(warning);
        }
        let first = write_results(chain, exposed, frames, folder, timings, left, |folder, number| {
            if capture.output.ideal {
                let seen = light.means(ideal::NAMES).to_planes();
                let seen = seen.map_err(|reason| Error::io(folder.path(), "read from", reason))?;
                let picture = ideal::picture(seen, capture, self.light, &exposure)?;
                let picture = match chain.ideal_resampling() {
                    Some(resampling) => resampling.apply(picture),
                    None => picture,
                };
                let [x, y] = capture.sensor.pixel_pitch_m;
                let aspect = if capture.develop.square_pixels { 1.0 } else { x / y };
                folder.write_ideal(number, picture, aspect, &capture.develop)?;
            }
            if !capture.output.truth.layers.is_empty() {
                let planes = truth(&truth_job, &capture.output.truth.layers);
                folder.write_truth(number, &capture.output.truth, &planes)?;
            }
            if let Some(counts) = &counts {
                folder.write_samples(number, capture.sensor.resolution, counts)?;
            }
            match &capture.output.irradiance {
                Some(bands) => folder.write_irradiance(number, bands, &light),
                None => Ok(()),
            }
        })?;
        Ok(Recorded { shot: Some(Shot { exposure, first, reached }), paths: all_paths, warnings })
    }
}

/// Finds truth that no PNG file can hold before light is traced, which may take an hour; returns what is to be said of what they
/// leave out.
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

/// `scenes/cornell-box/capture.toml` → `cornell-box`, `scenes/checker/capture-a.toml` → `checker-a`, `helmet.glb` →
/// `helmet`. An input in the current folder would give its own name to the folder, hence `capture`.
fn default_folder(input: &Path) -> PathBuf {
    let stem = input.file_stem().unwrap_or_default().to_string_lossy();
    let parent = input.parent().and_then(Path::file_name).map(|p| p.to_string_lossy());
    match (stem.strip_prefix("capture"), parent) {
        (Some(rest), Some(parent)) => PathBuf::from(format!("{parent}{rest}")),
        (None, _) | (Some(_), None) => PathBuf::from(&*stem),
    }
}

/// The sensor's channels, then the bands of `irradiance.exr` where they are asked for.
pub(super) fn responses(capture: &Capture) -> Vec<Response> {
    let channels = capture.sensor.responses().into_iter().map(|(name, spectrum)| Response::new(name, spectrum));
    let bands = capture.output.irradiance.iter().flat_map(|bands| (0..bands.count).map(|band| bands.edges_nm(band)));
    let observer = capture.output.ideal.then(ideal::responses);
    channels.chain(bands.map(band_response)).chain(observer.into_iter().flatten()).collect()
}

/// What the sensor makes of light before the lens.
fn seen_through_lens(capture: &Capture) -> Vec<Spectrum> {
    let responses = capture.sensor.responses().into_iter();
    responses.map(|(_, response)| response.product(&capture.lens.transmittance)).collect()
}

/// How much each wavelength matters: the sum of all responses, each scaled to a peak of 1.
pub(super) fn importance_of_light(responses: &[Response]) -> Spectrum {
    let scaled = responses.iter().filter(|r| r.spectrum.max() > 0.0).map(|r| (r, 1.0 / r.spectrum.max()));
    let scaled: Vec<_> = scaled.collect();
    Spectrum::from_fn(|lambda| scaled.iter().map(|(r, scale)| f64::from(r.spectrum.eval(lambda as f32) * scale)).sum())
}

/// What is to be said of settings that change nothing in this scene and with this sensor.
fn settings_in_vain(capture: &Capture, scene: &Scene) -> Vec<String> {
    let render = &capture.render;
    let (light_paths, shines) = (render.light_paths > 0.0, scene.lights().has_emitters());
    let own_filter = render.wavelengths == WavelengthChoice::OwnFilter;
    let focusing = "nothing focuses light, as mirrors, glass and polished metal do, so that no paths set out";
    [
        ("light_paths", light_paths && !shines, "no surface shines, so that no paths set out"),
        ("light_paths", light_paths && shines && !scene.may_focus(), focusing),
        (
            "reuse",
            render.reuse > 1 && !scene.has_diffuse(),
            "no material is purely diffuse, so that pixels share nothing",
        ),
        (
            "wavelengths",
            own_filter && !capture.sensor.cfa.is_mosaic(),
            "all pixels see the same, so that \"own-filter\" changes nothing",
        ),
    ]
    .into_iter()
    .filter(|(_, is_in_vain, _)| *is_in_vain)
    .map(|(key, _, why)| format!("render.{key}: {why}"))
    .collect()
}

/// The filters of the sensor, where pixels have different ones.
fn filters(capture: &Capture) -> Option<FilterTile> {
    let cfa = &capture.sensor.cfa;
    let (width, height) = cfa.tile_size();
    let tile = || FilterTile {
        responses: capture.sensor.responses().into_iter().map(|(_, spectrum)| spectrum).collect(),
        filters: (0..width * height).map(|i| cfa.channel_at(i % width, i / width)).collect(),
        width,
    };
    cfa.is_mosaic().then(tile)
}

/// Columns and rows of the picture.
pub(super) fn pixels(capture: &Capture) -> [u32; 2] {
    in_u32(capture.sensor.resolution)
}

fn in_u32(resolution: [usize; 2]) -> [u32; 2] {
    resolution.map(|n| u32::try_from(n).expect("resolutions are checked when they are read"))
}

/// The camera that lens and sensor make.
pub(super) fn camera_of(
    lens: &LensDescription,
    sensor: &SensorModel,
    to_world: DAffine3,
    autofocus_distance_m: f64,
) -> Result<Camera, Invalid> {
    let grid = PixelGrid { resolution: in_u32(sensor.pixel_array()), pitch_m: sensor.pixel_pitch_m };
    let camera = Camera::new(lens, &grid, to_world, autofocus_distance_m)?;
    Ok(if sensor.shutter.scans() { camera.scanning() } else { camera })
}

/// Puts the lens in its place, focused on what autofocus finds: `closest` is asked for it then only.
pub(super) fn place_camera(capture: &Capture, closest: impl Fn(&Ray) -> Option<Hit>) -> Result<Camera> {
    place_camera_at(capture, capture.camera_to_world, closest)
}

/// The same in another place.
pub(super) fn place_camera_at(
    capture: &Capture,
    to_world: DAffine3,
    closest: impl Fn(&Ray) -> Option<Hit>,
) -> Result<Camera> {
    let place = |lens: &_, distance| {
        let camera = camera_of(lens, &capture.sensor, to_world, distance);
        camera.map_err(|invalid| capture.source.error(invalid.within("lens")))
    };
    let covered = |camera: Camera| match camera.check_coverage() {
        Ok(()) => Ok(camera),
        Err(invalid) => Err(capture.source.error(invalid.within("lens"))),
    };
    let Focus::Autofocus { pixel } = capture.lens.focus else {
        return place(&capture.lens, f64::NAN).and_then(covered);
    };
    // Focusing moves the sensor and with it the direction of the chief ray; a few rounds settle it.
    let mut lens = capture.lens.clone();
    let mut distance = f64::INFINITY;
    for _ in 0..4 {
        lens.focus = if distance.is_finite() { Focus::Distance(distance) } else { Focus::Infinity };
        let hit = place(&lens, distance)?.chief_ray(pixel.into()).and_then(|ray| closest(&ray));
        distance = hit.map_or(f64::INFINITY, |hit| f64::from(hit.t));
        if distance <= lens.focal_length_m {
            break;
        }
    }
    place(&capture.lens, distance).and_then(covered)
}

/// The camera of a capture that is not rendered: its scene is built only where autofocus has to look at it.
pub(super) fn lone_camera(capture: &Capture) -> Result<Camera> {
    let built = OnceCell::new();
    let build = || scene::build(capture.scene.clone(), &importance_of_light(&responses(capture)));
    place_camera(capture, |ray| built.get_or_init(build).closest(ray))
}

/// The same taking the first picture of the capture.
pub(super) fn lone_recording_camera(capture: &Capture) -> Result<Camera> {
    let camera = lone_camera(capture)?;
    Ok(match &capture.recording {
        Some(recording) => camera.recording(recording.clone()),
        None => camera,
    })
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
        wavelengths: settings.wavelengths.name(),
        sampler: settings.sampler.name(),
        triangles: scene.geometry().triangles.len(),
        lights: scene.lights().len(),
        noise_ratio,
        noise,
    }
}

/// Says on standard output or on standard error what a render has given.
pub(super) fn finish(rendered: &Rendered, folder: &OutputFolder, quiet: bool, json: bool) -> Result<()> {
    match rendered {
        Rendered::Picture { report, .. } if json => return print_json(report),
        Rendered::Part(part) if json => return print_json(part),
        Rendered::Picture { .. } | Rendered::Part(_) if quiet => {}
        Rendered::Picture { report, paths, timings } => summarise(report, *paths, timings, folder),
        Rendered::Part(part) => {
            let ([from, to], all) = (part.samples, part.samples_per_pixel);
            let folder = folder.path().display();
            eprintln!("traced the samples {from}..{to} of {all}; {folder} is a part for photosite merge");
        }
    }
    Ok(())
}

fn summarise(report: &Report, paths: u64, timings: &Timings, folder: &OutputFolder) {
    let Report { exposure, files, .. } = report;
    let count = match paths {
        few @ ..1_000_000 => few.to_string(),
        many => format!("{:.1} M", many as f64 / 1e6),
    };
    eprintln!(
        "traced {count} paths in {} s ({:.2} M paths/s) and exposed for {} ms; wrote {}, {REPORT} to {}",
        rounded(timings.trace_s, 3),
        paths as f64 / timings.trace_s / 1e6,
        rounded(exposure.time_s * 1e3, 4),
        files.join(", "),
        folder.path().display()
    );
}
