//! `photosite fit`: the sensor file of a camera from its images.

use std::path::PathBuf;

use clap::Args;

use super::arguments::positive;
use super::monitor::TerminalMonitor;
use super::print::{print_json, println_text, refuse_existing, rounded, write_result};
use photosite_capture::FileKind;
use photosite_core::Result;
use photosite_core::units::Celsius;
use photosite_dataset::emva1288::{FitRequest, FittedCamera, fit_images};
use photosite_files::formats::NPY;
use photosite_files::map_file::{MapFile, write_map};
use photosite_measure::characterisation::camera_fit::{Assumption, CameraFit, KnownFacts, MapNames, Parameter};

const EXAMPLES: &str = "\
Examples:
  photosite fit emva1288.txt -o sensor.toml         an EMVA 1288 image set
  photosite fit frames/ -o sensor.toml              a folder of flats and darks
  photosite fit darks/ -o sensor.toml --system-gain 0.25
  photosite emva1288 sensor.toml --like emva1288.txt";

/// Fit a sensor file to the images of a camera: its twin.
///
/// The images are an EMVA 1288 set (a descriptor, or a folder that photosite emva1288 filled), a folder of flats and
/// dark images, or of dark images alone; at least two images of each light. In a folder, a table frames.csv (columns
/// file, kind, exposure_s, photons, gain, temperature_c), the metadata of raw files, and words such as dark, bias, flat,
/// 20ms, iso800 and 25C in names of files and folders say what each image was taken of; flats of one exposure time and
/// different brightness lie in folders of their own.
///
/// Each figure of the sensor file stands with its standard error. What the images do not tell, or cannot tell apart from
/// 0, is left out by name; what a sensor file needs all the same is marked as assumed.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct FitArgs {
    /// A descriptor of images (.txt), or a folder of images.
    input: PathBuf,
    /// The sensor file.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Channel to fit, for example G: of image sets of a colour sensor, or of a mosaic [default of a mosaic: G].
    #[arg(long, value_name = "NAME")]
    channel: Option<String>,
    /// System gain K in DN per electron, for images that do not tell it.
    #[arg(long, value_name = "DN", value_parser = positive)]
    system_gain: Option<f64>,
    /// Temperature of the sensor, where no image states it.
    #[arg(long, value_name = "CELSIUS", allow_hyphen_values = true, value_parser = celsius)]
    temperature_c: Option<f64>,
    /// Distance of the pixels, which images do not tell.
    #[arg(long, value_name = "UM", value_parser = positive)]
    pixel_pitch_um: Option<f64>,
    /// Wavelength of the light, for the statement about the quantum efficiency.
    #[arg(long, value_name = "NM", value_parser = positive)]
    wavelength_nm: Option<f64>,
    /// Write the measured patterns of response and dark signal, too, as SENSOR.prnu.npy and SENSOR.dsnu.npy beside the
    /// sensor file, which names them in place of PRNU and DSNU: the twin of this very camera.
    #[arg(long)]
    maps: bool,
    /// Overwrite the sensor file if it exists.
    #[arg(long)]
    force: bool,
    /// Print JSON instead of text: all parameters, curves and defective pixels.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors.
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

pub(super) fn run(args: &FitArgs) -> Result<()> {
    refuse_existing(&args.output, args.force)?;
    let stem = args.output.file_stem().unwrap_or_default().to_string_lossy();
    let maps = if args.maps { MapNames::beside(&stem) } else { MapNames::default() };
    for name in maps.names() {
        refuse_existing(&args.output.with_file_name(name), args.force)?;
    }
    FileKind::expect(&args.input, &[], "a folder of images or a descriptor of images (.txt)")?;
    let request = FitRequest {
        channel: args.channel.clone(),
        known: KnownFacts {
            system_gain: args.system_gain,
            temperature: args.temperature_c.map(Celsius),
            pixel_pitch_um: args.pixel_pitch_um.map(|um| [um, um]),
            wavelength_nm: args.wavelength_nm,
        },
        maps: args.maps,
    };
    let monitor = TerminalMonitor::new(args.quiet, args.json);
    let fitted = fit_images(&args.input, &request, &monitor)?;
    let maps = fitted.told(&maps);
    write_maps(&fitted, &maps, args)?;
    write_result(&args.output, args.force, |to| to.write_all(fitted.sensor_file(&maps).as_bytes()))?;
    if args.json {
        print_json(&fitted.report())
    } else if args.quiet {
        Ok(())
    } else {
        println_text(&text(&fitted))?;
        let beside: Vec<&str> = maps.names().collect();
        let named =
            if beside.is_empty() { String::new() } else { format!(", with {} beside it", beside.join(" and ")) };
        println_text(&format!("\nthe sensor file is {}{named}", args.output.display()))
    }
}

/// Writes the patterns that the images tell.
fn write_maps(fitted: &FittedCamera, names: &MapNames, args: &FitArgs) -> Result<()> {
    let prnu = fitted.prnu_map().map(<[f32]>::to_vec);
    let maps = [(&names.prnu, prnu, "response", "1"), (&names.dsnu, fitted.dsnu_map_e(), "offset", "e-")];
    for (name, values, quantity, unit) in maps {
        if let (Some(name), Some(values)) = (name, values) {
            let map = MapFile { size: fitted.fit.size, values, is_codes: false, warnings: Vec::new() };
            let path = args.output.with_file_name(name);
            write_result(&path, args.force, |to| write_map(&NPY, &map, quantity, unit, 1.0, to))?;
        }
    }
    if let (Some(name), Some(table)) = (&names.defects, fitted.defects_csv()) {
        write_result(&args.output.with_file_name(name), args.force, |to| to.write_all(table.as_bytes()))?;
    }
    Ok(())
}

/// Figures with their standard errors, as text.
fn text(fitted: &FittedCamera) -> String {
    let CameraFit { parameters, assumed, left_out, notes, defects, gain_steps, .. } = &fitted.fit;
    let width = parameters.iter().map(|p| p.key.len()).max().unwrap_or(0);
    let figure = |Parameter { key, unit, measured }: &Parameter| {
        let (value, error) = (rounded(measured.value, 6), rounded(measured.standard_error, 2));
        format!("{key:width$}  {value} ± {error} {unit}").trim_end().to_owned()
    };
    let assumption = |Assumption { key, value, is_stated, reason }: &Assumption| {
        let word = if *is_stated { "" } else { "assumed: " };
        format!("{word}{key} = {value}; {reason}")
    };
    let mut lines: Vec<String> = parameters.iter().map(figure).collect();
    for step in gain_steps {
        lines.push(format!("at {} dB ({}):", step.gain_db, step.name));
        lines.extend(step.parameters.iter().map(|parameter| format!("  {}", figure(parameter))));
    }
    lines.extend(assumed.iter().map(assumption));
    lines.extend(left_out.iter().map(|not| format!("left out: {}; {}", not.figure, not.reason)));
    lines.extend(notes.iter().map(|note| format!("note: {note}")));
    if !defects.is_empty() {
        lines.push(format!("{} defective pixels; --json lists them", defects.len()));
    }
    lines.join("\n")
}

fn celsius(text: &str) -> Result<f64, String> {
    let fits = |c: &f64| (-273.15..=1000.0).contains(c);
    text.parse().ok().filter(fits).ok_or_else(|| "write a temperature in degrees Celsius".to_owned())
}
