//! `photosite schema`: the JSON Schema of capture files, by which editors complete and check them.

use clap::Args;

use super::print_json;

/// Print the JSON Schema of capture files, for editors.
#[derive(Args)]
pub(super) struct SchemaArgs {}

pub(super) fn run(_: &SchemaArgs) -> photosite::Result<()> {
    print_json(&photosite::io::capture::capture_schema())
}
