//! `photosite render`: trace, expose, develop, write.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use photosite::film::{Response, band_response};
use photosite::geometry::{Hit, Ray};
use photosite::integrator::RenderSettings;
use photosite::io::capture::Capture;
use photosite::optics::{Camera, Focus, PixelGrid};
use photosite::scene::{self, Scene};
use photosite::spectrum::Spectrum;
use photosite::{Error, Result};

use super::chain::Chain;
use super::output_folder::{OutputFolder, REPORT};
use super::report::{CameraReport, LensReport, RenderReport, Report, Timings};
use super::trace::{Trace, trace};
use super::{print_json, rounded};

/// Render a scene as the camera of a capture file records it.
///
/// INPUT is a capture file (.toml) or a scene (.gltf, .glb, .obj), which then gets a camera that frames it, daylight, the
/// default lens and the default sensor.
#[derive(Args)]
pub(super) struct RenderArgs {
    /// A capture file (.toml) or a scene (.gltf, .glb, .obj).
    input: PathBuf,
    /// Folder for the results, created where missing [default: the input's name, in the current folder].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Seed of light transport and sensor noise.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Threads to use [default: all cores].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Change a key of the capture file, for example --set lens.f_number=4.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Print the contents of capture.json on standard output.
    #[arg(long)]
    json: bool,
    /// Overwrite the results of an earlier render.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &RenderArgs) -> Result<()> {
    if let Some(threads) = args.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global();
        pool.map_err(|e| Error::Usage { message: format!("cannot start {threads} threads: {e}"), help: None })?;
    }
    let start = Instant::now();
    let mut overrides = args.overrides.clone();
    overrides.extend(args.seed.map(|seed| format!("render.seed={seed}")));
    let mut capture = Capture::read(&args.input, &overrides)?;
    let mut timings = Timings { load_s: start.elapsed().as_secs_f64(), ..Timings::default() };
    let mut folder =
        OutputFolder::claim(&args.output.clone().unwrap_or_else(|| default_folder(&args.input)), args.force)?;

    let start = Instant::now();
    let responses = responses(&capture);
    let importance = importance(&responses);
    let description = std::mem::take(&mut capture.scene);
    let mut warnings = description.warnings.clone();
    let scene = scene::build(description, &importance);
    let camera = place_camera(&capture, |ray| scene.closest(ray))?;
    if let (Focus::Autofocus { pixel: [x, y] }, true) = (capture.lens.focus, camera.focus_distance_m().is_infinite()) {
        warnings
            .push(format!("autofocus: pixel {x}, {y} sees nothing to focus on, so the lens is focused at infinity"));
    }
    let chain = Chain::new(&capture, &scene, &mut warnings)?.with_camera(&camera, &mut warnings);
    if !args.quiet {
        warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    }
    timings.build_s = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let film = trace(&Trace {
        capture: &capture,
        scene: &scene,
        camera: &camera,
        responses: &responses,
        importance: &importance,
        chain: &chain,
        folder: &folder,
        silent: args.quiet || args.json,
    })?;
    timings.trace_s = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let rates = chain.rates(&film);
    let exposed = chain.expose(&rates)?;
    let first = chain.read_out(&exposed, 0)?;
    timings.expose_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let picture = chain.develop(&first)?;
    timings.develop_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut reading_out = 0.0;
    folder.remove_earlier()?;
    folder.write_frame(&capture, 0, &first)?;
    // One after the other: a series may be larger than the memory.
    for frame in 1..capture.exposure.frames {
        let start = Instant::now();
        let raw = chain.read_out(&exposed, frame)?;
        reading_out += start.elapsed().as_secs_f64();
        folder.write_frame(&capture, frame, &raw)?;
    }
    folder.write_pictures(&capture.output, &exposed, &film, &picture)?;
    timings.expose_s += reading_out;
    timings.write_s = start.elapsed().as_secs_f64() - reading_out;

    let [width, height] = pixels(&capture).map(u64::from);
    let paths = width * height * u64::from(film.samples());
    let report = Report {
        photosite_version: env!("CARGO_PKG_VERSION"),
        input: args.input.display().to_string(),
        overrides,
        capture: capture.to_json()?,
        seed: capture.render.seed,
        camera: CameraReport::new(&capture.lens, &camera, pixels(&capture)),
        lens: LensReport::new(&capture.lens, &camera),
        sensor: chain.sensor_report(&exposed, &first),
        exposure: chain.exposure_report(&exposed),
        render: render_report(&capture.render, &scene, film.samples(), chain.noise_ratio(&film)),
        files: folder.files(),
        warnings,
        timings,
        paths,
        paths_per_s: paths as f64 / timings.trace_s,
    };
    folder.write_report(&report)?;
    if args.json {
        return print_json(&report);
    }
    if !args.quiet {
        summarise(&report, &folder);
    }
    Ok(())
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
    let channels = capture.sensor.responses().into_iter().map(|(name, spectrum)| Response { name, spectrum });
    let bands = capture.output.irradiance.iter().flat_map(|bands| (0..bands.count).map(|band| bands.edges_nm(band)));
    channels.chain(bands.map(band_response)).collect()
}

/// How much each wavelength matters: the sum of all responses, each scaled to a peak of 1.
pub(super) fn importance(responses: &[Response]) -> Spectrum {
    let scaled = responses.iter().filter(|r| r.spectrum.max() > 0.0).map(|r| (r, 1.0 / r.spectrum.max()));
    let scaled: Vec<_> = scaled.collect();
    Spectrum::from_fn(|lambda| scaled.iter().map(|(r, scale)| f64::from(r.spectrum.eval(lambda as f32) * scale)).sum())
}

/// Columns and rows of the picture.
pub(super) fn pixels(capture: &Capture) -> [u32; 2] {
    capture.sensor.resolution.map(|n| u32::try_from(n).expect("resolutions are checked when they are read"))
}

/// Puts the lens in its place, focused on what autofocus finds: `closest` is asked for it then only.
pub(super) fn place_camera(capture: &Capture, closest: impl Fn(&Ray) -> Option<Hit>) -> Result<Camera> {
    let grid = PixelGrid { resolution: pixels(capture), pitch_m: capture.sensor.pixel_pitch_m };
    let place = |lens: &_, distance| {
        let camera = Camera::new(lens, &grid, capture.camera_to_world, distance);
        camera.map_err(|invalid| capture.source.error(invalid.within("lens")))
    };
    let Focus::Autofocus { pixel } = capture.lens.focus else { return place(&capture.lens, f64::NAN) };
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
    place(&capture.lens, distance)
}

fn render_report(
    settings: &RenderSettings,
    scene: &Scene,
    samples_per_pixel: u32,
    noise_ratio: Option<f64>,
) -> RenderReport {
    RenderReport {
        samples_per_pixel,
        max_depth: settings.max_depth,
        roulette_depth: settings.roulette_depth,
        sampler: settings.sampler.name(),
        triangles: scene.geometry().triangles.len(),
        lights: scene.lights().len(),
        noise_ratio,
    }
}

fn summarise(report: &Report, folder: &OutputFolder) {
    let Report { timings, exposure, .. } = report;
    let paths = match report.paths {
        few @ ..1_000_000 => few.to_string(),
        many => format!("{:.1} M", many as f64 / 1e6),
    };
    eprintln!(
        "traced {paths} paths in {} s ({:.2} M paths/s) and exposed for {} ms; wrote {}, {REPORT} to {}",
        rounded(timings.trace_s, 3),
        report.paths_per_s / 1e6,
        rounded(exposure.time_s * 1e3, 4),
        report.files.join(", "),
        folder.path().display()
    );
}
