//! `photosite schema`: the JSON Schemas of the files that a user writes, with which editors complete and check them,
//! and of `capture.json`.

use clap::{Args, ValueEnum};

use super::print::println_out;
use photosite_capture::report::report_schema;
use photosite_capture::{capture_schema, dataset_schema, noise_schema, sensor_schema};

const EXAMPLES: &str = "\
Examples:
  photosite schema > capture.schema.json
  photosite schema dataset > dataset.schema.json";

/// Print the JSON Schema of a kind of file, for editors.
///
/// Editors with a TOML language server complete and check captures by it.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct SchemaArgs {
    /// The kind of file.
    #[arg(value_enum, default_value = "capture")]
    kind: Kind,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    /// Capture files.
    Capture,
    /// Data set files.
    Dataset,
    /// Sensor files.
    Sensor,
    /// capture.json, which each render leaves.
    Report,
    /// The keys of photosite noise add.
    Noise,
}

pub(super) fn run(args: &SchemaArgs) -> photosite_core::Result<()> {
    let schema = match args.kind {
        Kind::Capture => capture_schema(),
        Kind::Dataset => dataset_schema(),
        Kind::Sensor => sensor_schema(),
        Kind::Report => report_schema(),
        Kind::Noise => noise_schema(),
    };
    // The layout of the copies that ship, which other tools write, too.
    println_out(&serde_json::to_string_pretty(&schema).expect("a schema has string keys and finite numbers"))
}
