//! Options of commands that write one file.

use std::path::Path;

use clap::Args;
use photosite_core::Result;
use photosite_core::output::Sink;

use super::print::{refuse_existing, write_result};

#[derive(Args)]
pub(super) struct FileArgs {
    /// Print nothing but errors.
    #[arg(short, long)]
    pub(super) quiet: bool,
    /// Print what was done as JSON on standard output.
    #[arg(long)]
    pub(super) json: bool,
    /// Overwrite the file if it exists.
    #[arg(long)]
    force: bool,
}

impl FileArgs {
    /// Refuses to overwrite a file without --force.
    pub(super) fn check(&self, path: &Path) -> Result<()> {
        refuse_existing(path, self.force)
    }

    /// Writes the file, if it is still not there or may be overwritten.
    pub(super) fn write(&self, path: &Path, write: impl FnOnce(&mut dyn Sink) -> std::io::Result<()>) -> Result<()> {
        write_result(path, self.force, write)
    }
}
