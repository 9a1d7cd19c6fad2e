//! `photosite depth`: from a disparity map to a depth map, and back.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::file_args::FileArgs;
use super::log::{say, warning};
use super::print::print_json;
use photosite_calibration::camera_files::DisparityScale;
use photosite_core::{Error, Invalid, Result};
use photosite_dataset::disparity_scale;
use photosite_files::map_file::{check_map, check_map_name, read_map, write_map};

const EXAMPLES: &str = "\
Example:
  photosite depth disparity.png --rectified rectified -o depth.exr";

/// Turn a disparity map by any program into depth, or back.
///
/// Depth is Z = f·b/(d + c); f and b are those of a folder of `photosite rectify`, or are given. Maps are EXR
/// files, NPY arrays of floats and TIFF files of floats in px and m; or NPY, TIFF and PNG files of whole numbers,
/// in steps. Where no disparity is above 0 there is no depth: ∞, or 0 in PNG files.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct DepthArgs {
    /// The map: .exr, .npy, .tiff or .png.
    map: PathBuf,
    /// The other map, of the kind that its name says.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Take f and b of the images that `photosite rectify` has put there.
    #[arg(long, value_name = "DIR", required_unless_present = "focal_length_px", conflicts_with_all = ["focal_length_px", "baseline_m", "offset_px"])]
    rectified: Option<PathBuf>,
    /// Focal length of both rectified images, px.
    #[arg(long, value_name = "F", requires = "baseline_m", allow_negative_numbers = true)]
    focal_length_px: Option<f64>,
    /// Distance of the second camera to the right of the first, or below it, m.
    #[arg(long, value_name = "B", requires = "focal_length_px", allow_negative_numbers = true)]
    baseline_m: Option<f64>,
    /// c: column (or row) of the second image's principal point less that of the first, px.
    #[arg(long, value_name = "C", requires = "focal_length_px", allow_negative_numbers = true, default_value = "0")]
    offset_px: f64,
    /// The other way round: from depth to disparity.
    #[arg(long)]
    inverse: bool,
    /// Name of the plane to use in an EXR file.
    #[arg(long, value_name = "NAME")]
    channel: Option<String>,
    /// Disparity of a code of 1 in files of whole numbers, px: 0.0625 in those of OpenCV's matchers [default: 1/256,
    /// KITTI's].
    #[arg(long, value_name = "STEP", default_value = "0.00390625", hide_default_value = true, value_parser = parse_step)]
    disparity_step_px: f64,
    /// Depth of a code of 1 in files of whole numbers, mm.
    #[arg(long, value_name = "STEP", default_value = "1", value_parser = parse_step)]
    depth_step_mm: f64,
    #[command(flatten)]
    file: FileArgs,
}

fn parse_step(text: &str) -> Result<f64, String> {
    let step = text.parse::<f64>().ok().filter(|step| step.is_finite() && *step > 0.0);
    step.ok_or_else(|| "write a number above 0".to_owned())
}

pub(super) fn run(args: &DepthArgs) -> Result<()> {
    let format = check_map_name(&args.output)?;
    args.file.check(&args.output)?;
    let scale = scale(args)?;
    let (disparity_step, depth_step) = (args.disparity_step_px, args.depth_step_mm * 1e-3);
    let (from_step, to_step) = if args.inverse { (depth_step, disparity_step) } else { (disparity_step, depth_step) };
    let map = read_map(&args.map, args.channel.as_deref())?;
    let (other, without) = if args.inverse {
        map.converted(from_step, 0.0, |depth| scale.disparity_px(depth))
    } else {
        map.converted(from_step, f32::INFINITY, |disparity| scale.depth_m(disparity))
    };
    check_map(format, &other.values, to_step).map_err(|invalid| invalid.in_file(&args.output))?;
    let (name, unit) = if args.inverse { ("disparity", "px") } else { ("depth", "m") };
    args.file.write(&args.output, |to| write_map(format, &other, name, unit, to_step, to))?;
    let ([columns, rows], all) = (map.size, other.values.len());
    if args.file.json {
        return print_json(&json!({
            "map": args.map, "output": args.output, "holds": name, "unit": unit,
            "resolution_px": map.size, "pixels": all, "without": without, "warnings": map.warnings,
        }));
    }
    if !args.file.quiet {
        map.warnings.iter().for_each(|what| warning!("{what}"));
        say!(
            "wrote {name} of {columns} × {rows} pixels, {without} of them without a value, to {}",
            args.output.display()
        );
        if without == all {
            warning!("no pixel has a {name}");
        }
    }
    Ok(())
}

fn scale(args: &DepthArgs) -> Result<DisparityScale> {
    let option = |invalid: Invalid| Error::Usage {
        message: format!("--{}: {}", invalid.key.replace('_', "-"), invalid.message),
        help: invalid.help,
    };
    match (&args.rectified, args.focal_length_px, args.baseline_m) {
        (_, Some(focal_length), Some(baseline)) => {
            DisparityScale::new(focal_length, baseline, args.offset_px).map_err(option)
        }
        (Some(folder), ..) => disparity_scale(folder),
        (None, ..) => Err(option(Invalid::new("rectified", "is missing"))),
    }
}
