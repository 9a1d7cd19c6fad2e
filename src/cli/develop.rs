//! `photosite develop`: from a raw file to a picture.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use photosite::develop::{DevelopSettings, Development, develop_linear, encode};
use photosite::io::capture::read_develop_settings;
use photosite::io::developed::{PictureFormat, write_encoded, write_linear};
use photosite::io::output::write_whole;
use photosite::{Error, Result};
use serde::Serialize;

use super::{print_json, rounded, start_threads};

/// Develop a raw file to a picture: PNG, TIFF, JPEG, PPM or EXR.
///
/// The steps are those of the table [develop] of capture files: white_balance, demosaic, highlights, noise_filter,
/// colour_space, exposure_ev, tone_curve, sharpening, bits, dither and more; `photosite schema` describes them all. EXR
/// files hold linear light. TIFF, PGM and NPY files do not say what filters their pixels have and become grey.
#[derive(Args)]
pub(super) struct DevelopArgs {
    /// A raw file: DNG, TIFF, PGM, PPM or NPY.
    raw: PathBuf,
    /// The picture: .png, .tiff, .jpg, .ppm or .exr [default: the raw file's name with .png, in the current folder].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Take the table [develop] of this capture file.
    #[arg(long, value_name = "FILE")]
    capture: Option<PathBuf>,
    /// Change a key of that table, for example --set develop.demosaic=malvar.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Threads to use [default: all cores].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Print what was done as JSON on standard output.
    #[arg(long)]
    json: bool,
    /// Overwrite the picture if it exists.
    #[arg(long)]
    force: bool,
}

/// The object that `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    photosite_version: &'static str,
    raw: String,
    picture: String,
    resolution_px: [usize; 2],
    settings: &'a DevelopSettings,
    #[serde(flatten)]
    development: Development,
    timings: Timings,
}

#[derive(Serialize)]
struct Timings {
    load_s: f64,
    develop_s: f64,
    write_s: f64,
}

pub(super) fn run(args: &DevelopArgs) -> Result<()> {
    start_threads(args.threads)?;
    let path = args
        .output
        .clone()
        .unwrap_or_else(|| Path::new(args.raw.file_name().unwrap_or("picture".as_ref())).with_extension("png"));
    let format = PictureFormat::of(&path)?;
    let (settings, source) = read_develop_settings(args.capture.as_deref(), &args.overrides)?;
    format.check(&settings).map_err(|invalid| source.error(invalid.within("develop")))?;
    if path.exists() && !args.force {
        return Err(Error::Usage {
            message: format!("{} exists already", path.display()),
            help: Some("add --force to overwrite it, or choose another name with -o".to_owned()),
        });
    }
    let start = Instant::now();
    let raw = photosite::raw::read(&args.raw)?;
    let load_s = start.elapsed().as_secs_f64();

    let start = Instant::now();
    // What is wrong now lies between the settings and the raw file; either is named by its key.
    let is_setting = |key: &str| serde_json::to_value(&settings).is_ok_and(|keys| keys.get(key).is_some());
    let failed = |invalid: photosite::Invalid| {
        let is_given = is_setting(&invalid.key) && source.has(&format!("develop.{}", invalid.key));
        if is_given { source.error(invalid.within("develop")) } else { invalid.in_file(&args.raw) }
    };
    let (planes, development) = develop_linear(&raw, &settings).map_err(failed)?;
    let resolution_px = [planes.width(), planes.height()];
    let mut develop_s = start.elapsed().as_secs_f64();
    let write_s = if format == PictureFormat::Exr {
        let start = Instant::now();
        write_whole(&path, |to| write_linear(&planes, settings.colour_space, to))?;
        start.elapsed().as_secs_f64()
    } else {
        let start = Instant::now();
        let picture = encode(planes, &settings.encoding());
        develop_s += start.elapsed().as_secs_f64();
        let start = Instant::now();
        write_whole(&path, |to| write_encoded(&picture, format, to))?;
        start.elapsed().as_secs_f64()
    };
    let report = Report {
        photosite_version: env!("CARGO_PKG_VERSION"),
        raw: args.raw.display().to_string(),
        picture: path.display().to_string(),
        resolution_px,
        settings: &settings,
        development,
        timings: Timings { load_s, develop_s, write_s },
    };
    if args.json {
        return print_json(&report);
    }
    if !args.quiet {
        summarise(&report);
    }
    Ok(())
}

fn summarise(report: &Report<'_>) {
    let [width, height] = report.resolution_px;
    let light = match (report.development.temperature_k, report.development.tint) {
        (Some(kelvin), Some(tint)) => format!(", white of {} K and tint {}", rounded(kelvin, 3), rounded(tint, 2)),
        _ => String::new(),
    };
    eprintln!(
        "developed {width} × {height} pixels in {} s{light}; wrote {}",
        rounded(report.timings.develop_s, 3),
        report.picture
    );
}
