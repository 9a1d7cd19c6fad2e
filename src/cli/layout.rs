//! `photosite layout`: a finished data set as other tools read it.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde_json::json;

use super::log::say;
use super::print::print_json;
use crate::calibration::layouts::Layout;
use crate::dataset::{LayoutFolder, read_dataset};
use crate::{Result, Sandbox};

/// Lay out a finished data set as other tools read it: folders, pictures, calibration, ground truth.
///
/// The data set is left as it is; pictures are copied. Cameras have OpenCV's axes, the world is that of glTF (y up).
#[derive(Args)]
pub(super) struct LayoutArgs {
    /// The folder that `photosite dataset` has filled.
    dataset: PathBuf,
    /// The layout.
    #[arg(long, value_enum)]
    format: Format,
    /// New folder for it.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Print what was made on standard output.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    /// mav0/ with state_groundtruth_estimate0, as of the EuRoC data sets (ASL).
    Euroc,
    /// cam0/ for kalibr_bagcreater, with camchain.yaml and a target file.
    Kalibr,
    /// images/ and sparse/0/ with the corners of targets as points.
    Colmap,
    /// train/ and models/; needs output.truth = ["depth", "instance"].
    Bop,
    /// images/ and annotations/instances.json, with key points of targets; needs output.truth = ["instance"].
    Coco,
}

impl Format {
    fn layout(self) -> Layout {
        match self {
            Self::Euroc => Layout::Euroc,
            Self::Kalibr => Layout::Kalibr,
            Self::Colmap => Layout::Colmap,
            Self::Bop => Layout::Bop,
            Self::Coco => Layout::Coco,
        }
    }
}

pub(super) fn run(args: &LayoutArgs, sandbox: &Sandbox) -> Result<()> {
    LayoutFolder::check(&args.output)?;
    let set = read_dataset(&args.dataset)?;
    let mut folder = LayoutFolder::begin(sandbox, &args.output, &args.dataset)?;
    args.format.layout().write(&set, &mut folder)?;
    folder.finish(&args.output)?;
    let pictures = set.shots.len();
    if args.json {
        return print_json(&json!({ "folder": args.output, "pictures": pictures, "cameras": set.cameras.len() }));
    }
    if !args.quiet {
        say!("laid out {pictures} pictures in {}", args.output.display());
    }
    Ok(())
}
