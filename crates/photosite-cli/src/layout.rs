//! `photosite layout`: a data set as other tools read it.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use photosite_core::counted;
use serde_json::json;

use super::log::{say, warning};
use super::print::print_json;
use photosite_calibration::layouts::Layout;
use photosite_core::{Error, Result, Sandbox};
use photosite_dataset::{LayoutFolder, read_dataset};

const EXAMPLES: &str = "\
Example:
  photosite layout set --format colmap -o colmap";

/// Lay out a data set for other tools: COLMAP, BOP, COCO …
///
/// The data set is not changed; images are copied. Cameras have OpenCV's axes, and the world is that of glTF (y up),
/// except in nerfstudio's layout, which has its own. WebDataset, Parquet and MCAP are written by the Python package,
/// `python -m photosite.train`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
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
    /// train/ and models/; needs the layers depth and instance of output.truth.
    Bop,
    /// images/ and annotations/instances.json, with key points of targets; needs the layer instance of output.truth.
    Coco,
    /// transforms.json with images/ and depths/, for Nerfstudio, instant-ngp, gsplat and 3DGUT.
    Nerfstudio,
    #[value(hide = true)]
    Webdataset,
    #[value(hide = true)]
    Parquet,
    #[value(hide = true)]
    Mcap,
}

impl Format {
    /// Layout of the format, or an error that says where the format is written instead.
    fn layout(self) -> Result<Layout> {
        let name = match self {
            Self::Euroc => return Ok(Layout::Euroc),
            Self::Kalibr => return Ok(Layout::Kalibr),
            Self::Colmap => return Ok(Layout::Colmap),
            Self::Bop => return Ok(Layout::Bop),
            Self::Coco => return Ok(Layout::Coco),
            Self::Nerfstudio => return Ok(Layout::Nerfstudio),
            Self::Webdataset => "webdataset",
            Self::Parquet => "parquet",
            Self::Mcap => "mcap",
        };
        let help =
            format!("pip install \"photosite[train]\", and then: python -m photosite.train {name} DATASET -o DIR");
        let message = format!("{name} is written by the Python package of photosite, on the packages that read it");
        Err(Error::Usage { message, help: Some(help.into()) })
    }
}

pub(super) fn run(args: &LayoutArgs, sandbox: &Sandbox) -> Result<()> {
    let layout = args.format.layout()?;
    LayoutFolder::check(&args.output)?;
    let set = read_dataset(&args.dataset)?;
    let mut folder = LayoutFolder::begin(sandbox, &args.output, &args.dataset)?;
    layout.write(&set, &mut folder)?;
    if !args.quiet {
        folder.warnings().iter().for_each(|what| warning!("{what}"));
    }
    folder.finish(&args.output)?;
    let images = set.shots.len();
    if args.json {
        return print_json(&json!({ "folder": args.output, "pictures": images, "cameras": set.cameras.len() }));
    }
    if !args.quiet {
        say!("laid out {} in {}", counted(images, ["image", "images"]), args.output.display());
    }
    Ok(())
}
