//! `photosite rectify`: rectified images of a rig, in which a point appears in the same row of both.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use photosite_core::counted;

use super::log::{say, warning};
use super::print::{print_json, rounded};
use photosite_core::{Result, Sandbox};
use photosite_dataset::{FrameList, RectifiedReport, RectifySettings, rectify};
use photosite_develop::ResizeFilter;

const EXAMPLES: &str = "\
Example:
  photosite rectify set -o rectified --lines 12";

/// Rectify the images of two cameras of a data set.
///
/// Both cameras are turned virtually as cv2.stereoRectify does it, and the distortion of their lenses is undone in the
/// same step, for every lens that photosite has; for lenses without distortion this is a homography. DIR/stereo.yaml
/// describes the cameras of the new images as OpenCV does. Where the data set has truth.exr with depth, each new image
/// has it too: depth along the common axis, m, and disparity d = f·b/Z, px; with normals in it, both are exact on
/// planes. Pixels that a camera does not see are black. The folder appears whole or not at all.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct RectifyArgs {
    /// The folder that `photosite dataset` has filled.
    dataset: PathBuf,
    /// New folder for the rectified images.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Two cameras of the rig, the reference first [default: the two that it has].
    #[arg(long, value_name = "FIRST,SECOND", value_parser = parse_pair)]
    pair: Option<[String; 2]>,
    /// Rectify only these frames: numbers, and ranges from A up to, but not including, B, as in 0..4,9.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<FrameList>,
    /// Interpolation between pixels; ground truth is never interpolated.
    #[arg(long, value_enum, default_value = "linear")]
    interpolation: Interpolation,
    /// Draw this many epipolar lines over both images side by side, rectified and as they were.
    #[arg(long, value_name = "N", default_value = "0", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(0..=1000))]
    lines: u32,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Print what was made on standard output.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Interpolation {
    /// The nearest pixel.
    Nearest,
    /// Straight lines between pixels, cv2.INTER_LINEAR.
    Linear,
    /// Cubic convolution of four pixels, cv2.INTER_CUBIC.
    Cubic,
    /// Lanczos' window of eight pixels, cv2.INTER_LANCZOS4.
    Lanczos,
}

impl Interpolation {
    fn filter(self) -> ResizeFilter {
        match self {
            Self::Nearest => ResizeFilter::Nearest,
            Self::Linear => ResizeFilter::Linear,
            Self::Cubic => ResizeFilter::Cubic,
            Self::Lanczos => ResizeFilter::Lanczos,
        }
    }
}

fn parse_pair(text: &str) -> Result<[String; 2], String> {
    let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
    let pair = <[String; 2]>::try_from(names).ok().filter(|pair| pair.iter().all(|name| !name.is_empty()));
    pair.ok_or_else(|| "write two names, for example left,right".to_owned())
}

pub(super) fn run(args: &RectifyArgs, sandbox: &Sandbox) -> Result<()> {
    let settings = RectifySettings {
        pair: args.pair.clone(),
        frames: args.frames.clone(),
        filter: args.interpolation.filter(),
        lines: args.lines,
    };
    let report = rectify(sandbox, &args.dataset, &args.output, &settings)?;
    if args.json {
        return print_json(&report);
    }
    if !args.quiet {
        summarise(&report, args);
    }
    Ok(())
}

fn summarise(report: &RectifiedReport, args: &RectifyArgs) {
    let [first, second] = &report.cameras;
    let percent = report.valid_part.map(|part| rounded(100.0 * part, 3));
    say!(
        "rectified {} of {first} and {second} in {}: f = {} px, b = {} m; the cameras see {} % and {} % of the \
         pixels",
        counted(report.frames.len(), ["frame", "frames"]),
        args.output.display(),
        rounded(report.focal_length_px, 6),
        rounded(report.baseline_m, 6),
        percent[0],
        percent[1],
    );
    report.warnings.iter().for_each(|what| warning!("{what}"));
}
