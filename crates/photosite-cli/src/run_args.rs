//! Arguments that `render` and `expose` share.

use std::path::PathBuf;

use clap::Args;

use super::monitor::TerminalMonitor;

/// Output folder, and changes to the capture file.
#[derive(Args)]
pub(super) struct RunArgs {
    /// Folder for the results, created where missing [default: the input's name, in the current folder].
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// Change a key of the capture file, for example --set exposure.time_s=0.02.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Seed of light transport and sensor noise.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Images to take of the same light, each with new temporal noise and the same fixed patterns.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frames: Option<u32>,
}

/// Arguments on reporting the results. They come last in the help.
#[derive(Args)]
pub(super) struct OutcomeArgs {
    /// Overwrite earlier results.
    #[arg(long)]
    pub(super) force: bool,
    /// Print nothing but errors.
    #[arg(short, long)]
    pub(super) quiet: bool,
    /// Print the contents of capture.json on standard output.
    #[arg(long)]
    pub(super) json: bool,
}

impl RunArgs {
    /// All changes to keys of the capture; those with an option of their own come last.
    pub(super) fn overrides(&self) -> Vec<String> {
        let seed = self.seed.map(|seed| format!("render.seed={seed}"));
        let frames = self.frames.map(|frames| format!("exposure.frames={frames}"));
        self.overrides.iter().cloned().chain(seed).chain(frames).collect()
    }
}

impl OutcomeArgs {
    /// Monitor of the work, which stops it on a signal.
    pub(super) fn monitor(&self) -> TerminalMonitor {
        TerminalMonitor::new(self.quiet, self.json)
    }
}
