//! `photosite merge-hdr`: raw images of a bracket become one map of the light.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::develop_args::CommonDevelopArgs;
use super::log::{say, warning};
use super::print::{print_json, rounded};
use photosite_core::units::Seconds;
use photosite_core::{Error, Invalid, Result};
use photosite_develop::merge::merge;
use photosite_develop::{DevelopSettings, Development, Thresholding, develop_merged};
use photosite_files::developed::write_hdr;
use photosite_files::formats::{EXR, Format};
use photosite_files::raw_file::read_raw;

const EXAMPLES: &str = "\
Example:
  photosite merge-hdr out/raw-0.dng out/raw-1.dng out/raw-2.dng -o hdr.exr";

/// Merge raw files of different exposures to one linear image.
///
/// The exposure times, and the noise by which the images are weighted, are those stated in the DNG files. The
/// image is developed by the table [develop] except for its tone curve; 1 is saturation in the longest exposure,
/// and shorter ones reach above it.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct MergeHdrArgs {
    /// Two or more DNG files of the same light, aperture and speed.
    #[arg(required = true)]
    raw: Vec<PathBuf>,
    /// The image, an .exr file.
    #[arg(short, long, value_name = "FILE", default_value = "hdr.exr")]
    output: PathBuf,
    #[command(flatten)]
    common: CommonDevelopArgs,
}

/// Object that `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    photosite_version: &'static str,
    raw: Vec<String>,
    picture: String,
    resolution_px: [usize; 2],
    shortest_s: f64,
    longest_s: f64,
    /// Number of pixel values that are saturated in every exposure.
    saturated: usize,
    settings: &'a DevelopSettings,
    #[serde(flatten)]
    development: Development,
    warnings: Vec<String>,
    timings: Timings,
}

#[derive(Serialize)]
struct Timings {
    load_s: f64,
    merge_s: f64,
    write_s: f64,
}

pub(super) fn run(args: &MergeHdrArgs) -> Result<()> {
    if *Format::of_developed(&args.output)? != EXR {
        return Err(Error::Usage {
            message: format!("{} cannot hold the range of a bracket", args.output.display()),
            help: Some("give a name that ends with .exr".into()),
        });
    }
    let (settings, source) = args.common.settings()?;
    args.common.file.check(&args.output)?;
    let start = Instant::now();
    let images = args.raw.iter().map(|path| read_raw(path)).collect::<Result<Vec<_>>>()?;
    let load_s = start.elapsed().as_secs_f64();

    let mut warnings: Vec<String> = images.iter().flat_map(|raw| raw.metadata.left_out.clone()).collect();
    let start = Instant::now();
    let merged = merge(&images).map_err(|invalid| of_image(invalid, &args.raw))?;
    drop(images);
    let ([shortest_s, longest_s], saturated) = (merged.times_s, merged.saturated);
    if !merged.noise_is_stated {
        warnings.push("not all files state their noise (NoiseProfile); that of 10 000 electrons is assumed".to_owned());
    }
    for (key, is_given) in
        [("colour_model", !settings.colour_model.is_shown()), ("threshold", settings.threshold != Thresholding::None)]
    {
        if is_given {
            let file = args.output.display();
            warnings.push(format!("develop.{key} does not affect merged light; photosite develop {file} follows it"));
        }
    }
    let unused = EXR.unused_keys(&settings);
    warnings.extend(unused.into_iter().map(|key| format!("develop.{key} does not affect an EXR file")));
    let (planes, development) =
        develop_merged(merged, &settings).map_err(|invalid| source.error(invalid.within("develop")))?;
    let merge_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    args.common.file.write(&args.output, |to| {
        write_hdr(&planes, settings.colour_space, development.pixel_aspect, Seconds(longest_s), to)
    })?;
    if !args.common.file.quiet {
        warnings.iter().for_each(|warning| warning!("{warning}"));
    }
    let report = Report {
        photosite_version: env!("CARGO_PKG_VERSION"),
        raw: args.raw.iter().map(|path| path.display().to_string()).collect(),
        picture: args.output.display().to_string(),
        resolution_px: [planes.width(), planes.height()],
        shortest_s,
        longest_s,
        saturated,
        settings: &settings,
        development,
        warnings,
        timings: Timings { load_s, merge_s, write_s: start.elapsed().as_secs_f64() },
    };
    if args.common.file.json {
        return print_json(&report);
    }
    if !args.common.file.quiet {
        say!(
            "merged {} images of {} to {} s in {} s; {saturated} pixel values are saturated in all; wrote {}",
            report.raw.len(),
            rounded(shortest_s, 4),
            rounded(longest_s, 4),
            rounded(merge_s, 3),
            report.picture
        );
    }
    Ok(())
}

/// Error with the path of the image whose index its key begins with.
fn of_image(invalid: Invalid, paths: &[PathBuf]) -> Error {
    let (number, key) = invalid.key.split_once('.').unwrap_or((&invalid.key, ""));
    let Some(path) = number.parse::<usize>().ok().and_then(|number| paths.get(number)) else {
        return Error::Usage { message: invalid.message, help: invalid.help };
    };
    Invalid { key: key.to_owned(), ..invalid.clone() }.in_file(path)
}
