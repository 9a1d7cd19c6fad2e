//! `photosite emva1288`: the image sets of EMVA 1288 by a sensor model, and the figures that they must show.

use std::path::PathBuf;

use clap::Args;
use photosite_core::counted;

use super::arguments::{Steps, parse_steps, positive};
use super::figures_text::expected_text;
use super::monitor::TerminalMonitor;
use super::print::{print_json, println_text};
use photosite_capture::{NamedSensor, read_named_sensor};
use photosite_core::sandbox::trust;
use photosite_core::units::{Celsius, Decibels, Seconds};
use photosite_core::{Result, Sandbox};
use photosite_dataset::emva1288::{SetPlan, SetRequest, refuse_image_sets};
use photosite_files::formats::{Format, TIFF};
use photosite_files::image_sets::IMAGE_FORMATS;
use photosite_measure::characterisation::effects_left_out;
use photosite_pipeline::{Event, Monitor};

const EXAMPLES: &str = "\
Example:
  photosite emva1288 sony-imx249-mono --size 256x256";

/// Make the image sets that EMVA 1288 asks for.
///
/// Every pixel receives exactly the same light, without the noise of a renderer. For a colour sensor each channel
/// gets a set of its own, of the pixels of that channel alone.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Emva1288Args {
    /// A preset (see photosite sensors) or a sensor file.
    sensor: String,
    /// Folder for the image sets [default: emva1288-SENSOR].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Change a key of the sensor, for example noise.read_noise_e=2.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Take the same images as this set: a descriptor or a folder of image sets, with its exposure times, photons,
    /// numbers of images and size. The sensor may be a twin that photosite fit made.
    #[arg(long, value_name = "SET", conflicts_with_all = ["steps", "spatial", "saturation_time_s", "sweep", "temperatures", "size"])]
    like: Option<PathBuf>,
    /// Use only these channels, for example G [default: all].
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    channels: Option<Vec<String>>,
    /// Wavelength of the light [default: where each channel's quantum efficiency is greatest].
    #[arg(long, value_name = "NM", value_parser = wavelength)]
    wavelength_nm: Option<f64>,
    /// Exposure times of the photon transfer curve.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(5..=1000))]
    steps: u32,
    /// Images of each stack for spatial non-uniformity.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(3..=10_000))]
    spatial: u32,
    /// Exposure time that saturates [default: long enough to measure the dark current].
    #[arg(long, value_name = "S", value_parser = positive)]
    saturation_time_s: Option<f64>,
    /// Measure the quantum efficiency at these wavelengths, too, for example 380..1000:10.
    #[arg(long, value_name = "NM", value_parser = parse_steps)]
    sweep: Option<Steps>,
    /// Measure the dark current at these temperatures, too, for example 15..55:10.
    #[arg(long, value_name = "CELSIUS", value_parser = parse_steps, allow_hyphen_values = true)]
    temperatures: Option<Steps>,
    /// Temperature of the sensor [default: 25, or that of --like].
    #[arg(long, value_name = "CELSIUS", allow_hyphen_values = true)]
    temperature_c: Option<f64>,
    /// Gain of all exposures.
    #[arg(long, value_name = "DB", default_value_t = 0.0, allow_hyphen_values = true)]
    gain_db: f64,
    /// Columns and rows of the images, WIDTHxHEIGHT [default: 512x512, or what the sensor has].
    #[arg(long, value_name = "PX", value_parser = size)]
    size: Option<[usize; 2]>,
    /// Seed of temporal noise; another camera of the same make is --set serial=N.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// File format of the images.
    #[arg(long, default_value = TIFF.ending(), value_parser = IMAGE_FORMATS.map(Format::ending))]
    format: String,
    /// Replace existing image sets.
    #[arg(long)]
    force: bool,
    /// Print what emva1288.json holds instead of text.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors.
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

pub(super) fn run(args: &Emva1288Args, sandbox: &Sandbox) -> Result<()> {
    trust(args.sensor.as_ref());
    let NamedSensor { model: sensor, warnings, .. } = read_named_sensor(sandbox, &args.sensor, &args.overrides)?;
    let output = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("emva1288-{}", sensor.name)));
    trust(&output);
    let request = SetRequest {
        plan: None,
        channels: args.channels.clone(),
        wavelength_nm: args.wavelength_nm,
        steps: args.steps,
        spatial: args.spatial,
        saturation_time: args.saturation_time_s.map(Seconds),
        sweep_nm: args.sweep.map_or_else(Vec::new, Steps::values),
        temperatures_c: args.temperatures.map_or_else(Vec::new, Steps::values),
        temperature: args.temperature_c.map(Celsius),
        gain: Decibels(args.gain_db),
        size: args.size,
        seed: args.seed,
        format: Format::of_ending(&args.format).unwrap_or(&TIFF),
        overrides: args.overrides.clone(),
    };
    let request = match &args.like {
        Some(set) => request.like(set)?,
        None => request,
    };
    let plan = SetPlan::new(&sensor, request)?;
    refuse_image_sets(&output, args.force)?;
    let monitor = TerminalMonitor::new(args.quiet, args.json);
    let left_out = effects_left_out(&sensor);
    let left_out =
        left_out.iter().map(|key| format!("{key} is in the images, but not in the figures that are expected of them"));
    warnings.into_iter().chain(left_out).for_each(|warning| monitor.report(Event::Warning(&warning)));
    let sets = plan.take_into(&output, args.force, &monitor)?;
    if args.json {
        print_json(&sets)
    } else if args.quiet {
        Ok(())
    } else {
        println_text(&expected_text(&sets))?;
        println_text(&format!("\n{} in {}", counted(plan.images(), ["image", "images"]), output.display()))
    }
}

fn wavelength(text: &str) -> Result<f64, String> {
    let fits = |nm: &f64| (300.0..=1100.0).contains(nm);
    text.parse().ok().filter(fits).ok_or_else(|| "write a wavelength from 300 to 1100, in nm".to_owned())
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let parts = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parts.ok_or_else(|| "write width and height, for example 512x512".to_owned())
}
