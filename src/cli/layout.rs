//! `photosite layout`: a data set as other tools read it.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use photosite_core::counted;
use serde_json::json;

use super::log::{say, warning};
use super::print::print_json;
use super::shards::{ShardSizeArgs, warner};
use crate::calibration::layouts::Layout;
use crate::dataset::{LayoutFolder, ShardFormat, Shards, read_dataset};
use crate::{Error, Invalid, Result, Sandbox};

const EXAMPLES: &str = "\
Example:
  photosite layout set --format colmap -o colmap";

/// Lay out a data set for other tools: COLMAP, BOP, COCO …
///
/// The data set is not changed; pictures are copied. Cameras have OpenCV's axes, and the world is that of glTF (y
/// up), except in nerfstudio's layout, which has its own. webdataset, parquet and mcap consist of shards, files of
/// some frames each, which can be written while the data set grows (--growing); when it is run again, the command
/// writes the shards that are missing.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct LayoutArgs {
    /// The folder that `photosite dataset` has filled, or fills.
    dataset: PathBuf,
    /// The layout.
    #[arg(long, value_enum)]
    format: Format,
    /// New folder for it; for shards, also one that already contains some of them.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// For an unfinished data set, write those shards whose frames are all complete.
    #[arg(long)]
    growing: bool,
    #[command(flatten)]
    size: ShardSizeArgs,
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
    /// shard-000000.tar … with an index, for WebDataset: pictures, raw images and ground truth as arrays.
    Webdataset,
    /// part-000000.parquet … for Hugging Face datasets: a row a picture, with image features.
    Parquet,
    /// part-000000.mcap … of ROS 2 messages: CameraInfo, Image, CompressedImage, tf.
    Mcap,
}

/// What a format is written by.
enum Written {
    Folder(Layout),
    Shards(ShardFormat),
}

impl Format {
    fn written(self) -> Written {
        match self {
            Self::Euroc => Written::Folder(Layout::Euroc),
            Self::Kalibr => Written::Folder(Layout::Kalibr),
            Self::Colmap => Written::Folder(Layout::Colmap),
            Self::Bop => Written::Folder(Layout::Bop),
            Self::Coco => Written::Folder(Layout::Coco),
            Self::Nerfstudio => Written::Folder(Layout::Nerfstudio),
            Self::Webdataset => Written::Shards(ShardFormat::Webdataset),
            Self::Parquet => Written::Shards(ShardFormat::Parquet),
            Self::Mcap => Written::Shards(ShardFormat::Mcap),
        }
    }
}

pub(super) fn run(args: &LayoutArgs, sandbox: &Sandbox) -> Result<()> {
    match args.format.written() {
        Written::Folder(layout) => write_folder(args, layout, sandbox),
        Written::Shards(format) => write_shards(args, format),
    }
}

fn write_folder(args: &LayoutArgs, layout: Layout, sandbox: &Sandbox) -> Result<()> {
    if args.growing || args.size.is_given() {
        let message = "--growing, --shard-mb and --shard-frames only apply to webdataset, parquet and mcap".to_owned();
        return Err(Error::Usage { message, help: Some("leave them out, or choose one of these formats".into()) });
    }
    LayoutFolder::check(&args.output)?;
    let set = read_dataset(&args.dataset)?;
    let mut folder = LayoutFolder::begin(sandbox, &args.output, &args.dataset)?;
    layout.write(&set, &mut folder)?;
    if !args.quiet {
        folder.warnings().iter().for_each(|what| warning!("{what}"));
    }
    folder.finish(&args.output)?;
    let pictures = set.shots.len();
    if args.json {
        return print_json(&json!({ "folder": args.output, "pictures": pictures, "cameras": set.cameras.len() }));
    }
    if !args.quiet {
        say!("laid out {} in {}", counted(pictures, ["picture", "pictures"]), args.output.display());
    }
    Ok(())
}

fn write_shards(args: &LayoutArgs, format: ShardFormat) -> Result<()> {
    if !args.growing {
        read_dataset(&args.dataset)?;
    }
    let warn = warner(args.quiet);
    let shards = Shards::open(&args.dataset, None, format, &args.output, args.size.size(), warn)?;
    let progress = shards.finish()?;
    if let (false, Some(left @ 1..)) = (args.growing, progress.left) {
        let message = format!("has damaged or missing pictures: {left} of the shards cannot be written");
        let help = "`photosite status` tells which; run the command that makes the data set again";
        return Err(Invalid::new("", message).help(help).in_file(&args.dataset));
    }
    if args.json {
        return print_json(&json!({
            "folder": args.output,
            "written": progress.written,
            "shards": progress.present,
            "left": progress.left,
        }));
    }
    if !args.quiet {
        let (written, folder) = (progress.written, args.output.display());
        match (progress.present, progress.left) {
            (present, Some(left)) => {
                say!("wrote {}; {present} of {} are in {folder}", counted(written, ["shard", "shards"]), present + left)
            }
            (_, None) => say!("wrote no shards: no frame is complete yet"),
        }
    }
    Ok(())
}
