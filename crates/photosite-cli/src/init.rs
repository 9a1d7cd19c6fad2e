//! `photosite init`: the capture file of a model that is rendered without one.

use std::path::{Path, PathBuf};

use clap::Args;

use super::log::{say, warning};
use super::print::{println_out, refuse_existing, write_result};
use photosite_capture::{InitialCapture, initial_capture};
use photosite_core::{Result, Sandbox};

const EXAMPLES: &str = "\
Example:
  photosite init model.glb -o capture.toml";

/// Write a model's capture file, with a comment on each key.
///
/// The file gives the same images as the model alone, and everything in it can be changed: camera, lens, light, ground,
/// exposure, sensor.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct InitArgs {
    /// A scene (.gltf, .glb, .obj, .ply, .stl).
    input: PathBuf,
    /// File for the capture, whose folder exists [default: standard output, for a file in the current folder].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print nothing but errors, and the capture where it has no file.
    #[arg(short, long)]
    quiet: bool,
    /// Overwrite the file.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &InitArgs, sandbox: &Sandbox) -> Result<()> {
    if let Some(output) = &args.output {
        refuse_existing(output, args.force)?;
    }
    let folder = args.output.as_deref().and_then(Path::parent).filter(|folder| !folder.as_os_str().is_empty());
    let InitialCapture { text, warnings } = initial_capture(sandbox, &args.input, folder.unwrap_or(Path::new(".")))?;
    warnings.iter().filter(|_| !args.quiet).for_each(|warning| warning!("{warning}"));
    match &args.output {
        None => println_out(text.trim_end()),
        Some(output) => {
            write_result(output, args.force, |to| to.write_all(text.as_bytes()))?;
            if !args.quiet {
                say!("wrote {0}; photosite render {0} makes the image", output.display());
            }
            Ok(())
        }
    }
}
