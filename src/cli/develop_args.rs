//! What `develop` and `merge-hdr` have in common on the command line.

use std::path::{Path, PathBuf};

use clap::Args;

use super::print::{refuse_existing, write_result};
use crate::Result;
use crate::capture::{CaptureSource, read_develop_settings};
use crate::develop::DevelopSettings;
use crate::io::output::Sink;

#[derive(Args)]
pub(super) struct CommonDevelopArgs {
    /// Take the table [develop] of this capture file.
    #[arg(long, value_name = "FILE")]
    capture: Option<PathBuf>,
    /// Change a key of that table, for example --set develop.colour_space=acescg.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Print nothing but errors.
    #[arg(short, long)]
    pub(super) quiet: bool,
    /// Print what was done as JSON on standard output.
    #[arg(long)]
    pub(super) json: bool,
    /// Overwrite the picture if it exists.
    #[arg(long)]
    force: bool,
}

impl CommonDevelopArgs {
    /// How to develop, and where that stands.
    pub(super) fn settings(&self) -> Result<(DevelopSettings, CaptureSource)> {
        read_develop_settings(self.capture.as_deref(), &self.overrides)
    }

    /// Refuses to overwrite a picture unasked.
    pub(super) fn check_output(&self, path: &Path) -> Result<()> {
        refuse_existing(path, self.force)
    }

    /// Writes the output, if it is still not there or may be overwritten.
    pub(super) fn write(&self, path: &Path, write: impl FnOnce(&mut dyn Sink) -> std::io::Result<()>) -> Result<()> {
        write_result(path, self.force, write)
    }
}
