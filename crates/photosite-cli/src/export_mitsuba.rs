//! `photosite export-mitsuba`: a capture as a scene of Mitsuba 3.

use std::path::{Path, PathBuf};

use clap::Args;

use super::log::{say, warning};
use super::scene_args::SceneArgs;
use super::shorthands::Shorthands;
use photosite_capture::Capture;
use photosite_core::output::{create_folder, write_whole};
use photosite_core::{Error, Result, Sandbox};
use photosite_files::lock::Lock;
use photosite_mitsuba::{RENDER_SCRIPT, export};
use photosite_pipeline::standalone_camera;

const EXAMPLES: &str = "\
Example:
  photosite export-mitsuba capture.toml -o mitsuba";

/// Export a capture to the renderer Mitsuba 3.
///
/// Mitsuba's image of scene.xml is comparable to electrons.exr. Parts without an exact counterpart in Mitsuba are
/// refused by name.
///
/// After pip install mitsuba, python DIR/render.py DIR/scene.xml mitsuba.exr renders it in independent batches and
/// also writes the variance of each pixel, so that photosite compare electrons.exr mitsuba.exr can tell noise from
/// a difference.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ExportMitsubaArgs {
    /// A capture file (.toml) or a scene (.gltf, .glb, .obj, .ply, .stl).
    input: PathBuf,
    /// Folder for scene.xml, the files that it names, and render.py, created where missing.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Change a key of the capture file, for example --set lens.falloff=none.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    shorthands: Shorthands,
    /// Use the closest that Mitsuba has where there is no exact counterpart, and list what is approximated.
    #[arg(long)]
    approximate: bool,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Overwrite an earlier scene.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &ExportMitsubaArgs, sandbox: &Sandbox) -> Result<()> {
    refuse_scene(&args.output, args.force)?;
    let overrides = args.shorthands.around(args.scene.after(&args.overrides, &args.input), &args.input)?;
    let capture = Capture::load_within(sandbox, &args.input, &overrides)?;
    let warnings = capture.warnings();
    let warnings = warnings.iter().filter(|_| !args.quiet);
    warnings.for_each(|warning| warning!("{warning}"));
    let camera = standalone_camera(&capture)?;
    let scene = export(&capture, &camera, args.approximate).map_err(|invalid| invalid.in_file(&args.input))?;
    let _lock = Lock::of_folder(&args.output)?;
    // Another process may have finished in the meantime.
    refuse_scene(&args.output, args.force)?;
    write_whole_in(&args.output, "render.py", RENDER_SCRIPT)?;
    // The scene itself comes last: where it is, all that it names is there too.
    for (name, bytes) in scene.files.iter().rev() {
        write_whole_in(&args.output, name, bytes)?;
    }
    if !args.quiet {
        scene.differences.iter().for_each(|what| say!("approximated: {what}"));
        say!("wrote {} files to {}", scene.files.len() + 1, args.output.display());
    }
    Ok(())
}

/// Writes a file below a folder, which is created where missing.
fn write_whole_in(folder: &Path, name: &str, bytes: &[u8]) -> Result<()> {
    let path = folder.join(name);
    create_folder(path.parent().unwrap_or(folder))?;
    write_whole(&path, |to| to.write_all(bytes))
}

fn refuse_scene(folder: &Path, force: bool) -> Result<()> {
    if force || !folder.join("scene.xml").exists() {
        return Ok(());
    }
    Err(Error::Usage {
        message: format!("{} already contains a scene", folder.display()),
        help: Some("add --force to overwrite it, or choose another folder with -o".into()),
    })
}
