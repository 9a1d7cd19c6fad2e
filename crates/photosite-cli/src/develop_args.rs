//! Arguments that `develop` and `merge-hdr` share.

use std::path::PathBuf;

use clap::Args;

use super::file_args::FileArgs;
use photosite_capture::{CaptureSource, read_develop_settings};
use photosite_core::Result;
use photosite_develop::DevelopSettings;

#[derive(Args)]
pub(super) struct CommonDevelopArgs {
    /// Take the table [develop] of this capture file.
    #[arg(long, value_name = "FILE")]
    capture: Option<PathBuf>,
    /// Change a key of that table, for example --set develop.colour_space=acescg.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    #[command(flatten)]
    pub(super) file: FileArgs,
}

impl CommonDevelopArgs {
    /// Settings of development, and the capture file that they come from.
    pub(super) fn settings(&self) -> Result<(DevelopSettings, CaptureSource)> {
        read_develop_settings(self.capture.as_deref(), &self.overrides)
    }
}
