//! `photosite schema`: the JSON Schema of capture files, by which editors complete and check them.

use clap::Args;

use super::println_out;

/// Print the JSON Schema of capture files, for editors.
#[derive(Args)]
pub(super) struct SchemaArgs {}

pub(super) fn run(_: &SchemaArgs) -> photosite::Result<()> {
    let schema = photosite::capture::capture_schema();
    // The layout of the copy that ships, which other tools write, too.
    println_out(&serde_json::to_string_pretty(&schema).expect("a schema has string keys and finite numbers"))
}
