//! `photosite render`: trace, expose, develop, write.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::arguments::parse_range;
use super::log::say;
use super::print::{print_json, rounded};
use super::run_args::{OutcomeArgs, RunArgs};
use super::scene_args::SceneArgs;
use super::shorthands::Shorthands;
use photosite_capture::report::{REPORT, RenderNoise, Report, Timings};
use photosite_capture::{Capture, relative_path};
use photosite_core::sandbox::trust;
use photosite_core::{Result, Sandbox};
use photosite_pipeline::{Destination, DeviceChoice, FilmMemory, LightSource, Rendered, Request, render_into};

const EXAMPLES: &str = "\
Examples:
  photosite render model.glb --spp 64 -o out
  photosite render capture.toml --set lens.f_number=2.8 --set exposure.iso=400";

/// Render a scene or capture as a raw file and an image.
///
/// INPUT is a capture file (.toml) or a scene (.gltf, .glb, .obj, .ply, .stl). A scene alone gets a camera that
/// shows all of it, the default lens and sensor, and, unless it has lights of its own, a clear day and a ground.
/// `photosite init` writes all that as a capture file.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct RenderArgs {
    /// A capture file (.toml) or a scene (.gltf, .glb, .obj, .ply, .stl).
    input: PathBuf,
    #[command(flatten)]
    common: RunArgs,
    #[command(flatten)]
    shorthands: Shorthands,
    #[command(flatten)]
    scene: SceneArgs,
    /// Trace only these samples of every pixel: from A up to, but not including, B. `photosite merge` makes the image
    /// of all parts.
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    samples: Option<Range<u32>>,
    /// Maximum memory for the film, GiB: an image of which it needs more is traced in strips, one after the other.
    #[arg(long, value_name = "GIB", default_value = "4")]
    film_memory: FilmMemory,
    /// Device that traces the light: cpu; gpu, the first graphics card; gpu:1 or gpu:NAME, one of `photosite devices`;
    /// auto, a graphics card where there is one that has what the settings ask for.
    #[arg(long, value_name = "DEVICE", default_value = "cpu")]
    device: DeviceChoice,
    #[command(flatten)]
    outcome: OutcomeArgs,
}

pub(super) fn run(args: &RenderArgs, sandbox: &Sandbox) -> Result<()> {
    let OutcomeArgs { force, quiet, json } = &args.outcome;
    let start = Instant::now();
    let overrides = args.shorthands.around(args.scene.after(&args.common.overrides(), &args.input), &args.input)?;
    let capture = Capture::load_within(sandbox, &args.input, &overrides)?;
    let timings = Timings { load_s: start.elapsed().as_secs_f64(), ..Timings::default() };
    let path = args.common.output.clone().unwrap_or_else(|| default_folder(&args.input));
    trust(&path);
    let terminal = &args.outcome.monitor();
    let capture = args.device.settle(capture, terminal)?;
    let light = args.samples.clone().map_or(LightSource::Traced, LightSource::Part);
    let mut folder = match Destination::claim(&path, *force, &capture, &light, terminal)? {
        Destination::Free(folder) => folder,
        Destination::Done(rendered) => return finish_again(&rendered, &path, *quiet, *json),
    };
    let request = Request {
        input: &args.input,
        named: relative_path(&args.input, folder.path()),
        light,
        film_memory: args.film_memory,
        monitor: terminal,
        is_timed: true,
    };
    let rendered = render_into(capture, &request, &mut folder, timings)?;
    finish(&rendered, folder.path(), *quiet, *json)
}

/// Default output folder: `scenes/cornell-box/capture.toml` → `cornell-box`, `scenes/checker/capture-a.toml` →
/// `checker-a`, `helmet.glb` → `helmet`. An input in the current folder would give its own name to the folder, hence
/// `capture`.
fn default_folder(input: &Path) -> PathBuf {
    let stem = input.file_stem().unwrap_or_default().to_string_lossy();
    let parent = input.parent().and_then(Path::file_name).map(|p| p.to_string_lossy());
    match (stem.strip_prefix("capture"), parent) {
        (Some(rest), Some(parent)) => PathBuf::from(format!("{parent}{rest}")),
        (None, _) | (Some(_), None) => PathBuf::from(&*stem),
    }
}

/// Reports the results of a render on standard output or standard error.
pub(super) fn finish(rendered: &Rendered, folder: &Path, quiet: bool, json: bool) -> Result<()> {
    match rendered {
        Rendered::Image { report, .. } if json => return print_json(report),
        Rendered::Part(part) if json => return print_json(part),
        Rendered::Image { .. } | Rendered::Part(_) if quiet => {}
        Rendered::Image { report, timings } => summarise(report, timings, folder),
        Rendered::Part(part) => {
            let ([from, to], all) = (part.samples, part.samples_per_pixel);
            let folder = folder.display();
            say!("traced the samples {from}..{to} of {all}; {folder} is a part for photosite merge");
        }
    }
    Ok(())
}

/// Reports that the render was there already.
pub(super) fn finish_again(rendered: &Rendered, folder: &Path, quiet: bool, json: bool) -> Result<()> {
    if !quiet {
        say!("{} already contains this render; --force renders it again", folder.display());
    }
    finish(rendered, folder, true, json)
}

fn summarise(report: &Report, timings: &Timings, folder: &Path) {
    let Report { exposure, files, traced, .. } = report;
    let paths = traced.paths.unwrap_or(0);
    let count = match paths {
        few @ ..1_000_000 => few.to_string(),
        many => format!("{:.1} M", many as f64 / 1e6),
    };
    say!(
        "traced {count} paths in {} s ({:.2} M paths/s) and exposed for {} ms; wrote {}, {REPORT} to {}",
        rounded(timings.trace_s, 3),
        paths as f64 / timings.trace_s / 1e6,
        rounded(exposure.time_s * 1e3, 4),
        files.join(", "),
        folder.display()
    );
    if let Some(plan) = traced.render.as_ref().and_then(|render| render.plan) {
        say!("{}", plan.words());
    }
    let noise = traced.render.as_ref().and_then(|render| RenderNoise::new(render, |n| format!("--spp {n}")));
    if let Some(RenderNoise { words, .. }) = noise {
        say!("{words}");
    }
}
