//! `photosite sensors`: the presets as a table, or the sensor formats on the market.

use clap::Args;
use serde::Serialize;

use super::print::{print_json, println_out, rounded};
use photosite_core::spectrum::Spectrum;
use photosite_core::units::Decibels;
use photosite_sensor::{Binning, FORMATS, Format, SensorModel, presets};

const EXAMPLES: &str = "\
Examples:
  photosite sensors
  photosite sensors --formats 1920x1200";

/// List the sensor presets, or the sensor formats.
///
/// Every preset is a file in the words of EMVA 1288, which `photosite info NAME` shows.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct SensorsArgs {
    /// List the formats that `sensor.format` knows instead, with the pixel pitch for this resolution.
    #[arg(long, value_name = "COLUMNSxROWS", num_args = 0..=1, default_missing_value = "1920x1440")]
    formats: Option<String>,
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
}

/// Sensor format with its pixels at a resolution.
#[derive(Serialize)]
struct FormatRow {
    names: &'static [&'static str],
    size_mm: [f64; 2],
    diagonal_mm: f64,
    pixel_pitch_um: [f64; 2],
}

/// Preset in the terms of EMVA 1288.
#[derive(Serialize)]
struct Row {
    name: &'static str,
    kind: &'static str,
    description: String,
    resolution_px: [usize; 2],
    pixel_pitch_um: [f64; 2],
    format: Option<&'static str>,
    cfa: String,
    peak_quantum_efficiency: f32,
    full_well_e: f64,
    read_noise_e: f64,
    dark_current_e_per_s: f64,
    base_iso: Option<f64>,
    bits: u32,
    source: String,
}

pub(super) fn run(args: &SensorsArgs) -> photosite_core::Result<()> {
    if let Some(resolution) = &args.formats {
        return run_formats(resolution, args.json);
    }
    let rows: Vec<Row> = presets::names().filter_map(|name| presets::model(name).map(|m| row(name, &m))).collect();
    if args.json {
        return print_json(&rows);
    }
    let width = rows.iter().map(|r| r.name.len()).max().unwrap_or(0);
    println_out(&format!(
        "{:width$}  {:4}  {:>9}  {:>11}  {:>7}  {:8}  {:>7}  {:>12}  {:>11}  {:>8}  {:>4}",
        "name",
        "kind",
        "pixels",
        "pitch µm",
        "format",
        "CFA",
        "peak QE",
        "full well e⁻",
        "read noise",
        "base ISO",
        "bits"
    ))?;
    for r in &rows {
        let pitch = pitch(r.pixel_pitch_um);
        let pixels = format!("{}×{}", r.resolution_px[0], r.resolution_px[1]);
        println_out(&format!(
            "{:width$}  {:4}  {pixels:>9}  {pitch:>11}  {:>7}  {:8}  {:>6.0}%  {:>12.0}  {:>8.1} e⁻  {:>8}  {:>4}",
            r.name,
            r.kind,
            r.format.unwrap_or("–"),
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

/// Pixel pitch as text: one number for square pixels, else both.
fn pitch([x, y]: [f64; 2]) -> String {
    if x == y { x.to_string() } else { format!("{x}×{y}") }
}

fn run_formats(resolution: &str, json: bool) -> photosite_core::Result<()> {
    let sides: Option<Vec<u32>> = resolution.split(['x', '×']).map(|side| side.trim().parse().ok()).collect();
    let size = sides.and_then(|sides| <[u32; 2]>::try_from(sides).ok()).filter(|size| !size.contains(&0));
    let size = size.ok_or_else(|| photosite_core::Error::Usage {
        message: format!("--formats: {resolution:?} is not a number of columns and rows"),
        help: Some("for example --formats 1920x1200".into()),
    })?;
    let row = |format: &Format| FormatRow {
        names: format.names,
        size_mm: format.size_mm,
        diagonal_mm: rounded(format.size_mm[0].hypot(format.size_mm[1]), 4),
        pixel_pitch_um: format.pitch_m(size).map(|m| rounded(m * 1e6, 4)),
    };
    let rows: Vec<FormatRow> = FORMATS.iter().map(row).collect();
    if json {
        return print_json(&rows);
    }
    let names: Vec<String> = rows.iter().map(|row| row.names.join(", ")).collect();
    let width = names.iter().map(String::len).max().unwrap_or(0);
    let head = format!("pitch µm of {}×{}", size[0], size[1]);
    println_out(&format!("{:width$}  {:>12}  {:>11}  {head}", "format", "mm", "diagonal mm"))?;
    for (row, name) in rows.iter().zip(names) {
        let size = format!("{}×{}", row.size_mm[0], row.size_mm[1]);
        println_out(&format!("{name:width$}  {size:>12}  {:>11}  {}", row.diagonal_mm, pitch(row.pixel_pitch_um)))?;
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
        format: Format::nearest(model.size_m()).map(|format| format.names[0]),
        cfa: model.cfa.to_string(),
        peak_quantum_efficiency: model.efficiencies().iter().map(Spectrum::max).fold(0.0, f32::max),
        full_well_e: model.full_well.0,
        read_noise_e: model.noise.read_out.at(Decibels(0.0)).read.0,
        dark_current_e_per_s: model.noise.dark_current_e_per_s,
        base_iso: model.base_iso(Binning::NONE).map(f64::round),
        bits: model.converter.bits,
        source: model.source.clone(),
    }
}
