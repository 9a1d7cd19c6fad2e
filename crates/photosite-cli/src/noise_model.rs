//! `photosite noise model`: the noise of a sensor over its gains, as training of raw denoisers asks for it.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::arguments::{Steps, parse_steps, positive};
use super::file_args::FileArgs;
use super::isetcam;
use super::log::{say, warning};
use super::print::{print_json, println_out};
use photosite_capture::{NamedSensor, read_named_sensor};
use photosite_core::sandbox::trust;
use photosite_core::units::{Celsius, Decibels, Seconds};
use photosite_core::{Error, Invalid, Result, Sandbox};
use photosite_sensor::{Exposure, GainLine, NoiseAtGain, SensorModel, Stage};

const EXAMPLES: &str = "\
Examples:
  photosite noise model sony-imx249-mono
  photosite noise model twin.toml --gains 0..24:6 -o noise.csv
  photosite noise model twin.toml --isetcam twin.json";

/// Number of gains where none are asked for.
const DEFAULT_GAINS: u32 = 5;

/// Tabulate the noise of a sensor over its gains.
///
/// For each analogue gain: ISO speed, system gain K, standard deviations of read noise, row and column noise, DSNU,
/// rounding and all dark noise in DN, black and white level, saturation, and the two numbers of a DNG file's
/// NoiseProfile; and the lines of ln σ against ln K, from which training of raw denoisers draws.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct NoiseModelArgs {
    /// A preset (see photosite sensors) or a sensor file, such as photosite fit writes.
    sensor: String,
    /// Analogue gains, first..last:step, for example 0..24:6 [default: five over what the sensor has].
    #[arg(long, value_name = "DB", value_parser = parse_steps, allow_hyphen_values = true)]
    gains: Option<Steps>,
    /// Exposure time, to which dark noise and NoiseProfile belong.
    #[arg(long, value_name = "S", value_parser = positive, default_value_t = 0.01)]
    time_s: f64,
    /// Temperature of the sensor.
    #[arg(long, value_name = "CELSIUS", allow_hyphen_values = true, default_value_t = 25.0)]
    temperature_c: f64,
    /// Change a key of the sensor, for example noise.read_noise_e=2.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Table to write, .csv.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the sensor at the first of these gains as the fields of ISETCam's sensor and pixel structures, .json.
    #[arg(long, value_name = "FILE")]
    isetcam: Option<PathBuf>,
    #[command(flatten)]
    file: FileArgs,
}

/// Object that `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    photosite_version: &'static str,
    sensor: &'a str,
    exposure_s: f64,
    temperature_c: f64,
    gains: &'a [NoiseAtGain],
    lines: Lines,
    /// Degrees of freedom of read noise that follows Student's t distribution; `null` of a normal one.
    read_noise_degrees_of_freedom: Option<f64>,
    /// Spatial standard deviation of the pixels' read noise over its mean, %.
    read_noise_spread_percent: f64,
    warnings: &'a [String],
}

/// Lines of ln σ against ln K; `null` of noise that is not there, and of a single gain.
#[derive(Serialize)]
struct Lines {
    read_noise: Option<GainLine>,
    row_noise: Option<GainLine>,
    column_noise: Option<GainLine>,
    dsnu: Option<GainLine>,
    dark_noise: Option<GainLine>,
}

impl Lines {
    fn of(rows: &[NoiseAtGain]) -> Self {
        Self {
            read_noise: GainLine::fit(rows, |row| row.read_noise_dn),
            row_noise: GainLine::fit(rows, |row| row.row_noise_dn),
            column_noise: GainLine::fit(rows, |row| row.column_noise_dn),
            dsnu: GainLine::fit(rows, |row| row.dsnu_dn),
            dark_noise: GainLine::fit(rows, |row| row.dark_noise_dn),
        }
    }

    fn named(&self) -> [(&'static str, Option<GainLine>); 5] {
        let Self { read_noise, row_noise, column_noise, dsnu, dark_noise } = *self;
        [
            ("read noise", read_noise),
            ("row noise", row_noise),
            ("column noise", column_noise),
            ("DSNU", dsnu),
            ("dark noise", dark_noise),
        ]
    }
}

pub(super) fn run(args: &NoiseModelArgs, sandbox: &Sandbox) -> Result<()> {
    trust(args.sensor.as_ref());
    check_outputs(args)?;
    let NamedSensor { model: sensor, mut warnings, .. } = read_named_sensor(sandbox, &args.sensor, &args.overrides)?;
    let exposures = exposures(args, &sensor);
    let rows = rows(&exposures, &sensor)?;
    warnings.extend(left_out(&sensor));
    let isetcam = match (&args.isetcam, exposures.first()) {
        (Some(path), Some(exposure)) => {
            warnings.extend(isetcam::left_out(&sensor, exposure));
            Some((path, isetcam::fields(&sensor, exposure)?))
        }
        _ => None,
    };
    let report = Report {
        photosite_version: env!("CARGO_PKG_VERSION"),
        sensor: &sensor.name,
        exposure_s: args.time_s,
        temperature_c: args.temperature_c,
        gains: &rows,
        lines: Lines::of(&rows),
        read_noise_degrees_of_freedom: sensor.noise.read_degrees_of_freedom,
        read_noise_spread_percent: 100.0 * sensor.noise.read_spread,
        warnings: &warnings,
    };
    if let Some(path) = &args.output {
        args.file.write(path, |to| to.write_all(csv(&rows).as_bytes()))?;
    }
    if let Some((path, fields)) = &isetcam {
        args.file.write(path, |to| to.write_all(format!("{fields:#}\n").as_bytes()))?;
    }
    if args.file.json {
        return print_json(&report);
    }
    if !args.file.quiet {
        warnings.iter().for_each(|what| warning!("{what}"));
        println_out(&text(&report))?;
        for path in args.output.iter().chain(&args.isetcam) {
            say!("wrote {}", path.display());
        }
    }
    Ok(())
}

/// Refuses names of files that cannot be written, before anything is read.
fn check_outputs(args: &NoiseModelArgs) -> Result<()> {
    let outputs =
        [(&args.output, "csv", "table", "-o noise.csv"), (&args.isetcam, "json", "sensor", "--isetcam twin.json")];
    for (path, wanted, what, example) in outputs {
        let Some(path) = path else { continue };
        if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case(wanted)) {
            let message = format!("{}: the {what} is a .{wanted} file", path.display());
            return Err(Error::Usage {
                message,
                help: Some(format!("for example {example}; --json prints JSON").into()),
            });
        }
        args.file.check(path)?;
    }
    Ok(())
}

/// Exposures at all gains.
fn exposures(args: &NoiseModelArgs, sensor: &SensorModel) -> Vec<Exposure> {
    let [least, most] = sensor.converter.gain_range.map(|gain| gain.0);
    let gains = match &args.gains {
        Some(steps) => steps.values(),
        None if least == most => vec![least],
        None => {
            let part = |i: u32| f64::from(i) / f64::from(DEFAULT_GAINS - 1);
            (0..DEFAULT_GAINS).map(|i| least + part(i) * (most - least)).collect()
        }
    };
    let exposure = |gain: f64| Exposure {
        gain: Decibels(gain),
        temperature: Celsius(args.temperature_c),
        ..Exposure::of(Seconds(args.time_s))
    };
    gains.into_iter().map(exposure).collect()
}

fn rows(exposures: &[Exposure], sensor: &SensorModel) -> Result<Vec<NoiseAtGain>> {
    let unfit = |Invalid { message, help, .. }| Error::Usage { message, help };
    exposures.iter().map(|exposure| sensor.noise_at_gain(exposure).map_err(unfit)).collect()
}

/// What a table of one number for each gain does not tell of a sensor.
fn left_out(sensor: &SensorModel) -> Vec<String> {
    let mut left_out = Vec::new();
    if sensor.converter.dual_gain.is_some() {
        left_out.push("the sensor has two gains at once; the noise is that of dark pixels, of the high one".to_owned());
    }
    if sensor.is_nonlinear() || sensor.logarithmic.is_some() || sensor.video.curve.is_some() {
        left_out.push("the response bends; the system gain is that of dark pixels".to_owned());
    }
    if sensor.has_stage(Stage::Telegraph) {
        left_out.push(
            "telegraph signals make tails heavier than those of a normal distribution; they count in dark_noise_dn alone"
                .to_owned(),
        );
    }
    left_out
}

/// Figures of the table: their names in files, and on the terminal.
type Column = (&'static str, &'static str, fn(&NoiseAtGain) -> Option<f64>);

const COLUMNS: [Column; 14] = [
    ("gain_db", "gain, dB", |row| Some(row.gain_db)),
    ("iso", "ISO speed", |row| row.iso),
    ("system_gain_dn_per_e", "K, DN/e⁻", |row| Some(row.system_gain_dn_per_e)),
    ("read_noise_dn", "read noise, DN", |row| Some(row.read_noise_dn)),
    ("row_noise_dn", "row noise, DN", |row| Some(row.row_noise_dn)),
    ("column_noise_dn", "column noise, DN", |row| Some(row.column_noise_dn)),
    ("dsnu_dn", "DSNU, DN", |row| Some(row.dsnu_dn)),
    ("quantisation_dn", "rounding, DN", |row| Some(row.quantisation_dn)),
    ("dark_noise_dn", "dark noise, DN", |row| Some(row.dark_noise_dn)),
    ("black_level_dn", "black level, DN", |row| Some(f64::from(row.black_level_dn))),
    ("white_level_dn", "white level, DN", |row| Some(f64::from(row.white_level_dn))),
    ("saturation_e", "saturation, e⁻", |row| Some(row.saturation_e)),
    ("noise_profile_s", "NoiseProfile S", |row| row.noise_profile.map(|[s, _]| s)),
    ("noise_profile_o", "NoiseProfile O", |row| row.noise_profile.map(|[_, o]| o)),
];

fn csv(rows: &[NoiseAtGain]) -> String {
    let mut text = COLUMNS.map(|(name, ..)| name).join(",") + "\n";
    for row in rows {
        let cells = COLUMNS.map(|(_, _, figure)| figure(row).map(|value| value.to_string()).unwrap_or_default());
        text += &(cells.join(",") + "\n");
    }
    text
}

/// A line for each figure, a column for each gain.
fn text(report: &Report<'_>) -> String {
    let lines = COLUMNS.map(|(_, heading, figure)| {
        let cell = |row| format!("{:>12}", figure(row).map_or_else(|| "–".to_owned(), five_digits));
        format!("{heading:<18}{}", report.gains.iter().map(cell).collect::<String>())
    });
    let fits = report.lines.named().into_iter().filter_map(|(name, line)| {
        let GainLine { slope, intercept, scatter } = line?;
        Some(format!("{name}: ln σ = {slope:.4} ln K {intercept:+.4}, scatter {scatter:.4}"))
    });
    lines.into_iter().chain(fits).chain(shape(report)).collect::<Vec<_>>().join("\n")
}

/// Distribution of the read noise, where there is any.
fn shape(report: &Report<'_>) -> Option<String> {
    if report.gains.iter().all(|row| row.read_noise_dn == 0.0) {
        return None;
    }
    let of_pixel = match report.read_noise_degrees_of_freedom {
        Some(freedom) => {
            format!("Student's t distribution with {} degrees of freedom", five_digits(freedom))
        }
        None => "a normal distribution".to_owned(),
    };
    Some(match report.read_noise_spread_percent {
        0.0 => format!("read noise: {of_pixel}, the same in all pixels"),
        percent => format!("read noise: {of_pixel}, pixels differ by {} %", five_digits(percent)),
    })
}

/// A number to five digits.
fn five_digits(value: f64) -> String {
    let before = value.abs().log10().floor();
    if value == 0.0 || (-2.0..6.0).contains(&before) {
        let after = (4.0 - before.max(-2.0)).clamp(0.0, 6.0) as usize;
        let text = format!("{value:.after$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.4e}")
    }
}
