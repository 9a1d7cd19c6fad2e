//! `photosite sensors`: the presets as a table.

use clap::Args;
use photosite::sensor::{Binning, SensorModel, presets};
use photosite::spectrum::Spectrum;
use serde::Serialize;

use super::print::{print_json, println_out};

/// List the sensor presets.
#[derive(Args)]
pub(super) struct SensorsArgs {
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
}

/// A preset in the words of EMVA 1288.
#[derive(Serialize)]
struct Row {
    name: &'static str,
    kind: &'static str,
    description: String,
    resolution_px: [usize; 2],
    pixel_pitch_um: [f64; 2],
    cfa: String,
    peak_quantum_efficiency: f32,
    full_well_e: f64,
    read_noise_e: f64,
    dark_current_e_per_s: f64,
    base_iso: Option<f64>,
    bits: u32,
    source: String,
}

pub(super) fn run(args: &SensorsArgs) -> photosite::Result<()> {
    let rows: Vec<Row> = presets::names().filter_map(|name| presets::model(name).map(|m| row(name, &m))).collect();
    if args.json {
        return print_json(&rows);
    }
    let width = rows.iter().map(|r| r.name.len()).max().unwrap_or(0);
    println_out(&format!(
        "{:width$}  {:4}  {:>9}  {:>11}  {:8}  {:>7}  {:>12}  {:>11}  {:>8}  {:>4}",
        "name", "kind", "pixels", "pitch µm", "CFA", "peak QE", "full well e⁻", "read noise", "base ISO", "bits"
    ))?;
    for r in &rows {
        let pitch = match r.pixel_pitch_um {
            [x, y] if x == y => x.to_string(),
            [x, y] => format!("{x}×{y}"),
        };
        let pixels = format!("{}×{}", r.resolution_px[0], r.resolution_px[1]);
        println_out(&format!(
            "{:width$}  {:4}  {pixels:>9}  {pitch:>11}  {:8}  {:>6.0}%  {:>12.0}  {:>8.1} e⁻  {:>8}  {:>4}",
            r.name,
            r.kind,
            r.cfa,
            100.0 * r.peak_quantum_efficiency,
            r.full_well_e,
            r.read_noise_e,
            r.base_iso.map_or_else(|| "–".to_owned(), |iso| iso.to_string()),
            r.bits
        ))?;
    }
    Ok(())
}

fn row(name: &'static str, model: &SensorModel) -> Row {
    Row {
        name,
        kind: model.architecture.name(),
        description: model.description.clone(),
        resolution_px: model.resolution,
        pixel_pitch_um: model.pixel_pitch_m.map(|m| (m * 1e9).round() / 1e3),
        cfa: model.cfa.to_string(),
        peak_quantum_efficiency: model.efficiencies().iter().map(Spectrum::max).fold(0.0, f32::max),
        full_well_e: model.full_well.0,
        read_noise_e: model.noise.read.0,
        dark_current_e_per_s: model.noise.dark_current_e_per_s,
        base_iso: model.base_iso(Binning::NONE).map(f64::round),
        bits: model.converter.bits,
        source: model.source.clone(),
    }
}
