//! `photosite measure sensitivities`: spectral sensitivities of a camera from photographs of a chart.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::arguments::sides;
use super::log::warning;
use super::print::{print_json, println_text, refuse_existing, write_result};
use photosite_core::sandbox::trust;
use photosite_core::spectrum::{Outside, SpectralTable, Spectrum, illuminant, library};
use photosite_core::{Error, Invalid, Result, input};
use photosite_develop::camera_colour::{camera_colour, chart_error};
use photosite_files::raw_file::read_raw;
use photosite_measure::characterisation::sensitivities::{
    ChartGrid, LitChart, Sensitivities, patch_means, sensitivities,
};
use photosite_raw::{Cfa, ColourCalibration, RawImage, read_profile};

const EXAMPLES: &str = "\
Examples:
  photosite measure sensitivities chart.dng --light D50 \\
      --corners 120,80,980,86,975,660,118,655 -o camera.csv
  photosite measure sensitivities a.dng b.dng --light A --light lamp.csv \\
      --corners 99,80,912,85,908,640,97,637 \\
      --corners 97,82,915,84,911,642,95,639 -o camera.csv";

/// Usage in less than 80 columns.
const USAGE: &str = "photosite measure sensitivities [OPTIONS] --light <NAME|FILE>
         --corners <X,Y,X,Y,X,Y,X,Y> --output <FILE> <RAW>...";

/// Relative departure of the patches from the curves from which on something is wrong.
const LARGE_ERROR: f64 = 0.05;

/// Standard error of a peak, as a part of it, from which on a curve is told roughly.
const ROUGH: f64 = 0.3;

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = USAGE)]
pub(super) struct SensitivitiesArgs {
    /// Raw images of the chart, in light that differs, such as incandescent light and daylight.
    #[arg(required = true, value_name = "RAW")]
    images: Vec<PathBuf>,
    /// Light of each image, once per image: an illuminant (A, D50, F11, LED-B3, 3000K …), or a CSV file of spectral
    /// power: nm and values.
    #[arg(long = "light", required = true, value_name = "NAME|FILE")]
    lights: Vec<String>,
    /// Centres of the corner patches in pixels, once per image: the first patch, the last of the first row, the last of
    /// all, and the first of the last row.
    #[arg(long = "corners", required = true, value_name = "X,Y,X,Y,X,Y,X,Y", value_parser = corners)]
    corners: Vec<[f64; 8]>,
    /// Reflectances of the chart: a CSV file of nm and a column per patch, in the order of reading [default: those of a
    /// colour checker of 24 patches].
    #[arg(long, value_name = "FILE", requires = "grid")]
    reflectances: Option<PathBuf>,
    /// Columns and rows of patches [default: 6x4].
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = grid, requires = "reflectances")]
    grid: Option<[usize; 2]>,
    /// Largest quantum efficiency of all channels, which images of a chart do not tell.
    #[arg(long, value_name = "QE", default_value_t = 1.0, value_parser = efficiency, allow_hyphen_values = true)]
    peak: f64,
    /// Camera profile (.dcp, or a DNG file) whose matrices are compared with those of the curves, as those of the first
    /// image are.
    #[arg(long, value_name = "FILE")]
    profile: Option<PathBuf>,
    /// Where to write the curves: a CSV file with a column per channel, as sensor files name them.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Overwrite the file if it exists.
    #[arg(long)]
    force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// Four places.
fn corners(text: &str) -> std::result::Result<[f64; 8], String> {
    let numbers: std::result::Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let numbers = numbers.ok().filter(|numbers| numbers.iter().all(|number| number.is_finite()));
    let found = numbers.and_then(|numbers| <[f64; 8]>::try_from(numbers).ok());
    found.ok_or_else(|| "expected eight numbers, column and row of four places".to_owned())
}

/// Quantum efficiency.
fn efficiency(text: &str) -> std::result::Result<f64, String> {
    let value = text.parse().ok().filter(|value| *value > 0.0 && *value <= 1.0);
    value.ok_or_else(|| "expected a number above 0, up to 1".to_owned())
}

/// Columns and rows of a chart.
fn grid(text: &str) -> std::result::Result<[usize; 2], String> {
    sides(text)
        .map(|sides| sides.map(|side| side as usize))
        .filter(|sides| sides.iter().all(|side| (2..=100).contains(side)))
        .ok_or_else(|| "expected columns and rows from 2 to 100, such as 6x4".to_owned())
}

/// Mean colour differences of a colour checker in one light.
#[derive(Serialize)]
struct MatrixCheck {
    light: &'static str,
    /// By the matrices that the file states.
    stated_delta_e_2000: Option<f64>,
    /// By the matrices of a camera profile.
    profile_delta_e_2000: Option<f64>,
    /// By those that follow from the curves.
    derived_delta_e_2000: Option<f64>,
}

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    found: &'a Sensitivities,
    matrices: &'a [MatrixCheck],
}

pub(super) fn run(args: &SensitivitiesArgs) -> Result<()> {
    refuse_existing(&args.output, args.force)?;
    let count = args.images.len();
    for (name, given) in [("--light", args.lights.len()), ("--corners", args.corners.len())] {
        if given != count {
            let message = format!("{given} times {name} for {count} images");
            let help = format!("write {name} once for each image, in their order");
            return Err(Error::Usage { message, help: Some(help.into()) });
        }
    }
    let profile = args.profile.as_deref().map(profile).transpose()?;
    let reflectances = reflectances(args.reflectances.as_deref())?;
    let patches = args.grid.unwrap_or([6, 4]);
    if patches[0] * patches[1] != reflectances.len() {
        let message = format!("{} x {} patches, and {} reflectances", patches[0], patches[1], reflectances.len());
        let help = "write the columns of the file in the order of reading, and --grid as the chart is".into();
        return Err(Error::Usage { message, help: Some(help) });
    }
    let (mut charts, mut first): (Vec<LitChart>, Option<RawImage>) = (Vec::new(), None);
    for ((path, light), corners) in args.images.iter().zip(&args.lights).zip(&args.corners) {
        let raw = read_raw(path)?.cropped().linear().into_owned();
        check(path, &raw, first.as_ref().map(|raw| &raw.cfa))?;
        let corners_px = [0, 2, 4, 6].map(|i| [corners[i], corners[i + 1]]);
        let means = patch_means(&raw, &ChartGrid { patches, corners_px }).map_err(|invalid| invalid.in_file(path))?;
        charts.push(LitChart { light: self::light(light)?, means });
        first.get_or_insert(raw);
    }
    let Some(first) = first else { return Ok(()) };
    if let (Some(path), Some(profile)) = (&args.profile, &profile) {
        check_profile(path, profile, &first.cfa)?;
    }
    let mut found = sensitivities(&charts, &reflectances, first.cfa.channels())
        .map_err(|invalid| invalid.in_file(&args.images[0]))?;
    found.channels.iter_mut().flat_map(|channel| &mut channel.values).for_each(|value| *value *= args.peak);
    if found.patch_error > LARGE_ERROR {
        warning!(
            "the patches depart by {:.0} % from any curves: look at the order of the corners, at the light, at glare, and at infrared \
             light that the camera sees",
            100.0 * found.patch_error
        );
    }
    if let Some(channel) = found.channels.iter().find(|channel| channel.error_at_peak() > ROUGH) {
        warning!(
            "channel {} is told to {:.0} % at its peak: images in further lights, or more patches, tell it better",
            channel.channel,
            100.0 * channel.error_at_peak()
        );
    }
    let matrices = matrix_checks(&found, &first, profile.as_deref()).unwrap_or_else(|Invalid { message, .. }| {
        warning!("the colours of the curves are not compared: {message}");
        Vec::new()
    });
    write_result(&args.output, args.force, |to| to.write_all(csv(&found, args.peak).as_bytes()))?;
    if args.json {
        return print_json(&Report { found: &found, matrices: &matrices });
    }
    println_text(&text(&found, &matrices, &args.output))
}

/// Refuses images of another pattern than that of the first, and warns of what is left out.
fn check(path: &Path, raw: &RawImage, first: Option<&Cfa>) -> Result<()> {
    if let Some(first) = first.filter(|first| **first != raw.cfa) {
        let message = format!("has the channels {}, and the first image {first}", raw.cfa);
        return Err(Invalid::new("", message).help("give images of one camera, cropped alike").in_file(path));
    }
    if raw.metadata.gain_maps().next().is_some() {
        warning!(
            "{}: its gain maps are left out: light that falls off counts as a property of the patches",
            path.display()
        );
    }
    Ok(())
}

/// Reflectances of a chart.
fn reflectances(path: Option<&Path>) -> Result<Vec<Spectrum>> {
    match path {
        Some(path) => {
            let table = table(path)?;
            table.names().map(|name| table.column(name).map_err(|error| error.in_file(path))).collect()
        }
        None => Ok(library::colour_checker().map(|(_, patch)| patch).collect()),
    }
}

/// Light by its name or file.
fn light(name: &str) -> Result<Spectrum> {
    if Path::new(name).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) {
        let path = Path::new(name);
        return table(path)?.single().map_err(|error| error.in_file(path));
    }
    illuminant::named(name).map_err(|Invalid { message, help, .. }| Error::Usage {
        message: format!("--light: {message}"),
        help: help.map(|help| format!("{help}; or write a .csv file").into()),
    })
}

fn table(path: &Path) -> Result<SpectralTable> {
    let text = input::read_text(path, input::TABLE_BYTES)
        .map_err(|error| Invalid::new("", format!("cannot read: {error}")).in_file(path))?;
    SpectralTable::parse(&text, Outside::Zero).map_err(|error| error.in_file(path))
}

/// Colour calibrations of a camera profile.
fn profile(path: &Path) -> Result<Vec<ColourCalibration>> {
    trust(path);
    let file = input::open(path).map_err(|source| Error::io(path, "read", source))?;
    read_profile(BufReader::new(file)).map_err(|invalid| invalid.in_file(path))
}

/// Refuses a profile of another number of channels than the camera's, or of channels without colours.
fn check_profile(path: &Path, profile: &[ColourCalibration], cfa: &Cfa) -> Result<()> {
    let channels = cfa.channels().len();
    let refused = |message: String| Err(Invalid::new("", message).help("leave out --profile").in_file(path));
    if channels < 3 {
        return refused(format!("is of colours, and the camera has the channels {}", cfa.channels().join(", ")));
    }
    match profile.iter().find(|calibration| calibration.colour_matrix.len() != channels) {
        Some(other) => refused(format!(
            "is of {} channels, and the camera has {channels}: {}",
            other.colour_matrix.len(),
            cfa.channels().join(", ")
        )),
        None => Ok(()),
    }
}

/// Colours of a colour checker by the matrices of the file and of a profile, and by those that follow from the curves.
fn matrix_checks(
    found: &Sensitivities,
    raw: &RawImage,
    profile: Option<&[ColourCalibration]>,
) -> Result<Vec<MatrixCheck>, Invalid> {
    if found.channels.len() < 3 {
        return Ok(Vec::new());
    }
    let curves: Result<Vec<(String, Spectrum)>, Invalid> = found
        .channels
        .iter()
        .map(|channel| Ok((channel.channel.clone(), channel.spectrum(&found.wavelengths_nm)?)))
        .collect();
    let curves = curves?;
    let mut checks = Vec::new();
    for name in ["A", "D50", "D65"] {
        let Some(light) = illuminant::illuminant(name) else { continue };
        let derived = camera_colour(&curves, &light)?;
        let error = |by: &[_]| chart_error(&curves, by, &light);
        checks.push(MatrixCheck {
            light: name,
            stated_delta_e_2000: error(&raw.metadata.calibrations)?,
            profile_delta_e_2000: profile.map_or(Ok(None), error).unwrap_or_else(|Invalid { message, .. }| {
                warning!("the matrices of the profile are not compared in {name}: {message}");
                None
            }),
            derived_delta_e_2000: derived.map_or(Ok(None), |derived| error(&derived.calibrations))?,
        });
    }
    Ok(checks)
}

/// Curves as a table.
fn csv(found: &Sensitivities, peak: f64) -> String {
    let mut text = format!(
        "# title: Spectral sensitivities of a camera from photographs of a chart\n\
         # note: signal per photon, {peak} at the largest value; patches depart by {:.2} % from the curves\n\
         # note: NAME_log_error is the standard error of the natural logarithm\n# outside: zero\nwavelength_nm",
        100.0 * found.patch_error
    );
    let names = found.channels.iter().map(|channel| format!(",{}", channel.channel));
    let errors = found.channels.iter().map(|channel| format!(",{}_log_error", channel.channel));
    text.extend(names.chain(errors));
    for (i, nm) in found.wavelengths_nm.iter().enumerate() {
        text += &format!("\n{nm}");
        text.extend(found.channels.iter().map(|channel| format!(",{:.6}", channel.values[i])));
        text.extend(found.channels.iter().map(|channel| format!(",{:.4}", channel.log_errors[i])));
    }
    text + "\n"
}

fn text(found: &Sensitivities, matrices: &[MatrixCheck], output: &Path) -> String {
    let mut text = "channel  peak, nm  half of it, nm  error at the peak".to_owned();
    for channel in &found.channels {
        let [from, to] = channel.half_maximum_nm;
        text += &format!(
            "\n{:<7}  {:>8}  {:>14}  {:>17}",
            channel.channel,
            channel.peak_nm,
            format!("{from} to {to}"),
            format!("{:.1} %", 100.0 * channel.error_at_peak())
        );
    }
    text += &match found.is_exact() {
        true => "\npatches depart by less than 0.1 % from the curves".to_owned(),
        false => format!("\npatches depart by {:.2} % from the curves", 100.0 * found.patch_error),
    };
    if found.saturated > 0 {
        text += &format!("; {} that are saturated in a channel are left out of it", found.saturated);
    }
    for check in matrices {
        let MatrixCheck {
            light,
            stated_delta_e_2000: stated,
            profile_delta_e_2000: profile,
            derived_delta_e_2000: derived,
        } = check;
        let by = [(derived, "the curves"), (stated, "the file"), (profile, "the profile")];
        let by: Vec<String> = by
            .iter()
            .filter_map(|(error, whose)| Some(format!("{:.2} by matrices of {whose}", error.as_ref()?)))
            .collect();
        if !by.is_empty() {
            text += &format!("\ncolours of a colour checker in {light}: mean ΔE2000 {}", by.join(", "));
        }
    }
    let [first, last] = [0, found.wavelengths_nm.len() - 1].map(|i| found.wavelengths_nm[i]);
    text += &format!("\nbeyond {first} to {last} nm nothing is known of the chart: the curves are 0 there\n");
    let file = output.display().to_string();
    for channel in &found.channels {
        let (table, file, column) = (&channel.channel, &file, &channel.channel);
        text += &format!("\n[channels.{table}]\nquantum_efficiency = {{ file = {file:?}, column = {column:?} }}");
    }
    text
}
