//! `photosite devices`: who can trace light on this machine.

use clap::Args;
use serde::Serialize;

use super::print::{print_json, println_out};

/// List the devices that can trace light, for `render --device`.
#[derive(Args)]
pub(super) struct DevicesArgs {
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
}

/// A device.
#[derive(Serialize)]
struct Row {
    /// Value of `--device`.
    device: String,
    name: String,
    /// Kind: "processor", "discrete", "integrated", "virtual", "software", "unknown".
    kind: &'static str,
    /// Interface of a graphics card: "vulkan", "metal", "dx12".
    interface: Option<String>,
    driver: Option<String>,
    /// Largest table of a scene, GiB.
    largest_table_gib: Option<f64>,
    /// Why it cannot be used.
    refusal: Option<String>,
}

pub(super) fn run(args: &DevicesArgs) -> photosite_core::Result<()> {
    let threads = rayon::current_num_threads();
    let processor = Row {
        device: "cpu".to_owned(),
        name: format!("the processor, {threads} threads"),
        kind: "processor",
        interface: None,
        driver: None,
        largest_table_gib: None,
        refusal: None,
    };
    let rows: Vec<Row> = std::iter::once(processor).chain(cards()).collect();
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
    #[cfg(not(feature = "gpu"))]
    println_out(super::device_arg::NOT_BUILT)?;
    Ok(())
}

#[cfg(not(feature = "gpu"))]
fn cards() -> Vec<Row> {
    Vec::new()
}

#[cfg(feature = "gpu")]
fn cards() -> Vec<Row> {
    let row = |(number, adapter): (usize, photosite_gpu::Adapter)| Row {
        device: format!("gpu:{number}"),
        name: adapter.name,
        kind: adapter.kind,
        interface: Some(adapter.interface),
        driver: Some(adapter.driver),
        largest_table_gib: Some(super::print::rounded(adapter.largest_binding as f64 / f64::from(1 << 30), 3)),
        refusal: adapter.refusal,
    };
    photosite_gpu::adapters().into_iter().enumerate().map(row).collect()
}
