//! `photosite expose`: new exposures, sensors and noise from stored light.

use std::path::{Path, PathBuf};

use clap::Args;
use photosite::pipeline::{OutputFolder, StoredRender};
use photosite::report::REPORT;
use photosite::{Error, Result, Sandbox};

use super::log::say;
use super::print::{print_json, rounded};
use super::run_args::RunArgs;

/// Expose stored light again: another time, gain, temperature, seed or sensor.
///
/// INPUT is a folder that `photosite render` filled, or an EXR file from there. Electrons serve any exposure with the
/// sensor that they were counted for; irradiance serves any sensor. Light that a moving camera saw is that of its
/// exposure time and shutter, which stay as they were rendered.
#[derive(Args)]
pub(super) struct ExposeArgs {
    /// A folder with capture.json, or a file electrons.exr or irradiance.exr.
    input: PathBuf,
    #[command(flatten)]
    common: RunArgs,
}

pub(super) fn run(args: &ExposeArgs, sandbox: &Sandbox) -> Result<()> {
    let RunArgs { output, quiet, json, force, .. } = &args.common;
    let stored = StoredRender::read(sandbox, &args.input, &args.common.overrides())?;
    let folder = output.clone().unwrap_or_else(|| default_folder(&args.input));
    refuse_own_folder(&folder, &args.input)?;
    let mut folder = OutputFolder::claim(&folder, *force)?;
    let report = stored.expose_into(&mut folder, &args.common.monitor())?;
    if *json {
        return print_json(&report);
    }
    if !quiet {
        let time_ms = rounded(report.exposure.time_s * 1e3, 4);
        say!("exposed for {time_ms} ms; wrote {}, {REPORT} to {}", report.files.join(", "), folder.path().display());
    }
    Ok(())
}

/// `cornell-box` → `cornell-box-exposed`, `cornell-box/electrons.exr` → `electrons-exposed`.
fn default_folder(input: &Path) -> PathBuf {
    // A folder may be given as `.` or `..`.
    let whole = input.canonicalize();
    let name = if input.is_dir() { whole.as_deref().unwrap_or(input).file_name() } else { input.file_stem() };
    PathBuf::from(format!("{}-exposed", name.unwrap_or_default().to_string_lossy()))
}

/// Results in the folder of the light would take its place.
fn refuse_own_folder(output: &Path, input: &Path) -> Result<()> {
    let folder = if input.is_dir() { Some(input) } else { input.parent() };
    let folder = folder.map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    let (Ok(output), Some(Ok(folder))) = (output.canonicalize(), folder.map(Path::canonicalize)) else { return Ok(()) };
    if output != folder || !folder.join(REPORT).exists() {
        return Ok(());
    }
    Err(Error::Usage {
        message: format!("the results would take the place of the light in {}", folder.display()),
        help: Some("choose another folder with -o".into()),
    })
}
