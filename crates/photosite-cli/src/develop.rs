//! `photosite develop`: from a raw file, or an image of linear light, to an image.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::develop_args::CommonDevelopArgs;
use super::log::{say, warning};
use super::print::{print_json, rounded};
use photosite_capture::FileKind;
use photosite_core::{Error, Invalid, Result};
use photosite_develop::{DevelopSettings, Development};
use photosite_files::developable::read_developable;
use photosite_files::developed::write_developed;
use photosite_files::formats::{
    Format, Holds,
    lists::{endings, names},
};
use photosite_pipeline::{DevelopedFile, DevelopedImage};

const EXAMPLES: &str = "\
Example:
  photosite develop out/raw.dng -o out.tiff --set develop.colour_space=acescg";

/// Develop a raw file, or an image of linear light.
///
/// The steps are those of the table [develop] of capture files, which `photosite schema` describes: white_balance,
/// demosaic, highlights, noise_filter, kernel, resize_px, colour_space, colour_model, exposure_ev, tone_curve,
/// threshold, sharpening, bits, dither and more. EXR and NPY images contain linear light.
///
/// Raw files other than DNG do not describe themselves. The pixel values of TIFF, PBM, PGM, PPM and NPY files are taken
/// to be proportional to light, from 0 to the largest that the file can hold, and become grey or RGB unless develop.raw
/// gives their filters and levels: --set develop.raw.cfa=RGGB --set develop.raw.black_level_dn=64 --set
/// develop.raw.white_level_dn=4095. They keep the distortion of their lens and the shape of their pixels, which they do
/// not state.
///
/// Images (PNG, JPEG, and EXR by merge-hdr and other programs) are first decoded to linear light as they state
/// their colours, and then take the steps from the noise filter on.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct DevelopArgs {
    #[arg(help = format!(
        "A raw file: {} (of 8 or 16 bits, or an EXR file of digital numbers). Or an image: {}",
        names(|format| format.raw_reader.is_some()),
        names(|format| format.reads_images() && matches!(format.holds, Holds::Codes | Holds::Light))
    ))]
    raw: PathBuf,
    #[arg(short, long, value_name = "FILE", help = format!(
        "The image: {} (.pgm for grey only) [default: the raw file's name with .png, in the current folder]",
        endings(|format| format.image_writer.is_some())
    ))]
    output: Option<PathBuf>,
    #[command(flatten)]
    common: CommonDevelopArgs,
}

/// Object that `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    photosite_version: &'static str,
    raw: String,
    picture: String,
    resolution_px: [usize; 2],
    settings: &'a DevelopSettings,
    #[serde(flatten)]
    development: Development,
    /// Assumption about a file that does not describe itself.
    assumed: Option<String>,
    /// Warnings: statements that are left out, and keys without effect.
    warnings: Vec<String>,
    timings: Timings,
}

#[derive(Serialize)]
struct Timings {
    load_s: f64,
    develop_s: f64,
    write_s: f64,
}

pub(super) fn run(args: &DevelopArgs) -> Result<()> {
    let path = args
        .output
        .clone()
        .unwrap_or_else(|| Path::new(args.raw.file_name().unwrap_or("picture".as_ref())).with_extension("png"));
    let format = Format::of_developed(&path)?;
    let source = args.common.settings()?;
    format.check(&source.0).map_err(|invalid| source.1.error(invalid.within("develop")))?;
    args.common.file.check(&path)?;
    let developable = [FileKind::Raw, FileKind::PixelValues, FileKind::Light, FileKind::Image];
    FileKind::expect(&args.raw, &developable, "a raw file or an image")?;
    let start = Instant::now();
    let file = read_developable(&args.raw)?;
    let load_s = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let developed = DevelopedImage::develop_file(file, &args.raw, &source, (format, &path))?;
    let DevelopedFile { image: DevelopedImage { linear: planes, development, .. }, assumed, warnings } = developed;
    format.check_image(&planes).map_err(|Invalid { message, help, .. }| Error::Usage { message, help })?;
    let resolution_px = [planes.width(), planes.height()];
    let develop_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let (settings, aspect) = (source.0, development.pixel_aspect);
    args.common.file.write(&path, |to| write_developed(planes, &settings, aspect, format, to))?;
    let write_s = start.elapsed().as_secs_f64();
    let report = Report {
        photosite_version: env!("CARGO_PKG_VERSION"),
        raw: args.raw.display().to_string(),
        picture: path.display().to_string(),
        resolution_px,
        settings: &settings,
        development,
        assumed,
        warnings,
        timings: Timings { load_s, develop_s, write_s },
    };
    if args.common.file.json {
        return print_json(&report);
    }
    if !args.common.file.quiet {
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
    say!(
        "developed {width} × {height} pixels in {} s{light}; wrote {}",
        rounded(report.timings.develop_s, 3),
        report.picture
    );
    report.assumed.iter().chain(&report.warnings).for_each(|what| warning!("{what}"));
}
