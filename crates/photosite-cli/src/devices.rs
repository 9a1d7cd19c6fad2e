//! `photosite devices`: what can trace light and expose on this machine.

use clap::Args;
use photosite_pipeline::{BUILT_WITHOUT, devices};

use super::print::{print_json, println_out};

/// List the devices that trace light and expose, for --device.
#[derive(Args)]
pub(super) struct DevicesArgs {
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &DevicesArgs) -> photosite_core::Result<()> {
    let rows = devices();
    if args.json {
        return print_json(&rows);
    }
    let width = rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0);
    println_out(&format!("{:8}  {:width$}  {:10}  {:9}  driver", "device", "name", "kind", "interface"))?;
    for row in &rows {
        let [interface, driver] = [&row.interface, &row.driver].map(|text| text.as_deref().unwrap_or("–"));
        println_out(&format!("{:8}  {:width$}  {:10}  {interface:9}  {driver}", row.device, row.name, row.kind))?;
        if let Some(refusal) = &row.refusal {
            println_out(&format!("{:8}  cannot be used: {refusal}", ""))?;
        }
    }
    BUILT_WITHOUT.map_or(Ok(()), println_out)
}
