//! `photosite schema`: the JSON Schemas of capture files, by which editors complete and check them, of `capture.json`,
//! and of the keys of `photosite noise add`.

use clap::Args;

use super::print::println_out;

/// Print the JSON Schema of capture files, for editors.
#[derive(Args)]
pub(super) struct SchemaArgs {
    /// Print that of capture.json, which each render leaves.
    #[arg(long)]
    report: bool,
    /// Print that of the keys of photosite noise add.
    #[arg(long, conflicts_with = "report")]
    noise: bool,
}

pub(super) fn run(args: &SchemaArgs) -> crate::Result<()> {
    let schema = match (args.report, args.noise) {
        (true, _) => crate::report::report_schema(),
        (false, true) => crate::capture::noise_schema(),
        (false, false) => crate::capture::capture_schema(),
    };
    // The layout of the copies that ship, which other tools write, too.
    println_out(&serde_json::to_string_pretty(&schema).expect("a schema has string keys and finite numbers"))
}
