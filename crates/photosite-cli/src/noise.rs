//! `photosite noise`: estimates of the noise of images; and `noise add`, `noise model`.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use photosite_core::counted;

use super::arguments::positive;
use super::log::{say, warning};
use super::noise_add::{self, NoiseAddArgs};
use super::noise_model::{self, NoiseModelArgs};
use super::noise_series::{NoiseSeries, sigma_map_format, write_sigma_map};
use super::print::{print_json, println_text, refuse_existing, write_result};
use photosite_core::output::{Sink, create_folders};
use photosite_core::{Error, Result, Sandbox};
use photosite_measure::characterisation::noise::{Request, figures};
use photosite_measure::characterisation::report::{NoiseReport, PlaneNoise};
use photosite_raw::Pixels;

const EXAMPLES: &str = "\
Examples:
  photosite noise out/raw.dng --patch 100,100,64,64
  photosite noise add photo.png -o noisy.png --set gaussian.sigma=4
  photosite noise model twin.toml --gains 0..24:6 -o noise.csv";

/// Estimate or add noise of images, or tabulate a sensor's.
///
/// From several images of the same scene: temporal noise, over all pixels and for each, and the fixed pattern beneath.
/// From one image: the spread in an even patch, the residual of a patch with linear shading after fitting a plane, and
/// the residual of many small squares after fitting a plane to each. The colours of a mosaic are treated one by one. In
/// raw files that state which pixels see light (DNG, raw EXR), only those are used.
#[derive(Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(after_help = EXAMPLES)]
pub(super) struct NoiseArgs {
    #[command(subcommand)]
    command: Option<NoiseCommand>,
    #[command(flatten)]
    estimate: EstimateArgs,
}

#[derive(Subcommand)]
enum NoiseCommand {
    Add(NoiseAddArgs),
    Model(NoiseModelArgs),
}

#[derive(Args)]
struct EstimateArgs {
    /// EXR, HDR, PNG, TIFF, JPEG or raw files (DNG, PGM, NPY); several are taken to show the same scene.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Use only this part: left, top, width and height in pixels, counted from the corner of the pixels that see
    /// light.
    #[arg(long, value_name = "X,Y,W,H", value_parser = rectangle)]
    patch: Option<[usize; 4]>,
    /// Use the masked pixels of raw files, too; --patch counts from the corner of the file.
    #[arg(long)]
    masked: bool,
    /// Standard deviation that every pixel should have: the χ² of planes is reported, and distributions are compared
    /// with it.
    #[arg(long, value_name = "X", value_parser = positive)]
    sigma: Option<f64>,
    /// Value of no light [default: the black level of a DNG, otherwise 0].
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    black: Option<f64>,
    /// Largest distance at which to look for correlations, in pixels of one colour.
    #[arg(long, value_name = "PX", default_value_t = 4, value_parser = clap::value_parser!(u64).range(0..=256))]
    lags: u64,
    /// Side of the squares to which planes are fitted, in pixels of one colour.
    #[arg(long, value_name = "PX", default_value_t = 8, value_parser = clap::value_parser!(u64).range(2..=1024))]
    square: u64,
    /// Write the standard deviation of every pixel over several images: .exr, .npy or .tiff.
    #[arg(long, value_name = "FILE")]
    sigma_map: Option<PathBuf>,
    /// Write all figures with their plots as one HTML page.
    #[arg(long, value_name = "FILE.html")]
    page: Option<PathBuf>,
    /// Write the plots as PNG files into this folder.
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Overwrite files that exist.
    #[arg(long)]
    force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &NoiseArgs, sandbox: &Sandbox) -> Result<()> {
    match &args.command {
        Some(NoiseCommand::Add(add)) => noise_add::run(add),
        Some(NoiseCommand::Model(model)) => noise_model::run(model, sandbox),
        None => run_estimate(&args.estimate),
    }
}

fn run_estimate(args: &EstimateArgs) -> Result<()> {
    let map = args.sigma_map.as_ref().map(|path| Ok((path, sigma_map_format(path)?))).transpose()?;
    for path in [&args.sigma_map, &args.page].into_iter().flatten() {
        refuse_existing(path, args.force)?;
    }
    let pixels = if args.masked { Pixels::All } else { Pixels::Active };
    let series = NoiseSeries::read(&args.files, pixels, args.patch)?;
    series.said().for_each(|what| warning!("{what}"));
    let request = Request { most_lag: args.lags as usize, side: args.square as usize };
    let report = series.estimate(args.black, args.sigma, request)?;
    let write = |path: &Path, write: &dyn Fn(&mut dyn Sink) -> std::io::Result<()>| {
        write_result(path, args.force, write)?;
        if !args.json {
            say!("wrote {}", path.display());
        }
        Ok(())
    };
    if let Some((path, format)) = map {
        let planes = series.sigma_map()?;
        write(path, &|to| write_sigma_map(&planes, report.unit.as_deref(), format, to))?;
    }
    if let Some(path) = &args.page {
        write(path, &|to| to.write_all(report.html().as_bytes()))?;
    }
    if let Some(folder) = &args.plots {
        let plots: Vec<(PathBuf, Vec<u8>)> =
            report.png_plots().into_iter().map(|(name, png)| (folder.join(format!("{name}.png")), png)).collect();
        plots.iter().try_for_each(|(path, _)| refuse_existing(path, args.force))?;
        create_folders(folder).map_err(|error| Error::io(folder, "create", error))?;
        plots.iter().try_for_each(|(path, png)| write(path, &|to| to.write_all(png)))?;
    }
    if args.json { print_json(&report) } else { println_text(&text(&report)) }
}

fn text(report: &NoiseReport) -> String {
    let of_plane = |PlaneNoise { name, estimate: e }: &PlaneNoise| {
        let lines = figures(e, report.unit());
        let width = lines.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        let body: Vec<String> = lines
            .iter()
            .map(|(name, value)| format!("  {name}{}  {value}", " ".repeat(width - name.chars().count())))
            .collect();
        let images = counted(e.pictures, ["image", "images"]);
        format!("{name}: {} × {} pixels of {images}\n{}", e.size[0], e.size[1], body.join("\n"))
    };
    let area = report.active_area_px.map(|[x, y, w, h]| format!("active area: {w} × {h} pixels at {x}, {y}"));
    area.into_iter().chain(report.planes.iter().map(of_plane)).collect::<Vec<_>>().join("\n\n")
}

fn rectangle(text: &str) -> Result<[usize; 4], String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    numbers
        .and_then(|n| <[usize; 4]>::try_from(n).ok())
        .ok_or_else(|| "write left, top, width and height, for example 100,100,64,64".to_owned())
}
