//! `photosite emva1288-report`: the figures that image sets show, against those that they are expected to show.

use std::path::{Path, PathBuf};

use clap::Args;
use photosite::characterisation::report::{ChannelReport, Report, SpectralPoint, ThermalPoint};
use photosite::characterisation::{Figures, NotMeasured, doubling_temperature, evaluate, responsivity};
use photosite::io::image_sets::{CONTENTS, ChannelSets, ImageSets, MeasuredSet, read_set};
use photosite::pipeline::{Event, Monitor};
use photosite::{Invalid, Result};
use serde::Serialize;

use super::figures_text::measured_text;
use super::monitor::TerminalMonitor;
use super::{print_json, println_out, refuse_existing, rounded, write_result};

/// Measure image sets as EMVA 1288 has it, and draw the curves as one HTML page.
///
/// A descriptor names the images and says what they are of: "n 12 640 480" for bits, columns and rows, "b 20000000 1234.5" for
/// exposure time in ns and photons a pixel before bright images, "d 20000000" before dark ones, "i images\a.tif" for each. Where
/// exposure times are not known and stated as 0, what needs them is left out and named.
#[derive(Args)]
pub(super) struct Emva1288ReportArgs {
    /// A folder that photosite emva1288 filled, or a descriptor of images of any camera (.txt).
    input: PathBuf,
    /// The page [default: report.html in the folder].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Overwrite the page if it exists.
    #[arg(long)]
    force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors.
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

/// The object that `--json` prints for each channel.
#[derive(Serialize)]
struct Measured<'a> {
    channel: &'a str,
    measured: Figures,
    /// What the images do not tell, and why.
    not_measured: Vec<NotMeasured>,
    expected: Option<Figures>,
    wavelengths: &'a [SpectralPoint],
    temperatures: &'a [ThermalPoint],
    /// Expected and measured.
    doubling_temperature_k: Option<[f64; 2]>,
}

pub(super) fn run(args: &Emva1288ReportArgs) -> Result<()> {
    let is_folder = args.input.is_dir();
    let folder = if is_folder { &*args.input } else { args.input.parent().unwrap_or(Path::new("")) };
    let output = args.output.clone().unwrap_or_else(|| folder.join("report.html"));
    refuse_existing(&output, args.force)?;
    let report = if is_folder { of_folder(folder, args.quiet || args.json)? } else { of_descriptor(&args.input)? };
    write_result(&output, args.force, |to| to.write_all(report.html().as_bytes()))?;
    if args.json {
        print_json(&report.channels.iter().map(measured).collect::<Vec<_>>())
    } else if args.quiet {
        Ok(())
    } else {
        println_out(&measured_text(&report))?;
        println_out(&format!("\nthe curves are in {}", output.display()))
    }
}

fn measured(channel: &ChannelReport) -> Measured<'_> {
    Measured {
        channel: &channel.title,
        measured: channel.evaluation.figures,
        not_measured: channel.evaluation.not_measured(),
        expected: channel.expected,
        wavelengths: &channel.spectral,
        temperatures: &channel.thermal,
        doubling_temperature_k: channel.doubling_temperature_k,
    }
}

/// The images of any camera.
fn of_descriptor(path: &Path) -> Result<Report> {
    let set = read_set(path, &|| {})?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let conditions = conditions([set.descriptor.width, set.descriptor.height], set.descriptor.bits);
    let channel = channel_report("Figures".to_owned(), set, None).map_err(|invalid| invalid.in_file(path))?;
    Ok(Report { sensor: name, description: String::new(), conditions, channels: vec![channel] })
}

/// The image sets that photosite took.
fn of_folder(folder: &Path, quiet: bool) -> Result<Report> {
    if !folder.join(CONTENTS).exists() {
        let help = "give a folder that photosite emva1288 filled, or a descriptor of images (.txt)";
        return Err(Invalid::new("", format!("holds no {CONTENTS}")).help(help).in_file(folder));
    }
    let sets = ImageSets::read(folder)?;
    let monitor = TerminalMonitor::new(quiet, false);
    monitor.report(Event::SetBegins { pictures: image_count(folder, &sets) });
    let mut channels = Vec::new();
    let mut bits = 0;
    for channel in &sets.channels {
        let (report, its_bits) = of_channel(folder, channel, &monitor)?;
        channels.push(report);
        bits = its_bits;
    }
    monitor.report(Event::SetEnds);
    let mut conditions = conditions(sets.size_px, bits);
    conditions.push(("Gain".to_owned(), format!("{} dB", sets.gain_db)));
    conditions.push(("Seed".to_owned(), sets.seed.to_string()));
    if !sets.overrides.is_empty() {
        conditions.push(("Changed".to_owned(), sets.overrides.join(", ")));
    }
    Ok(Report { sensor: sets.sensor, description: sets.description, conditions, channels })
}

/// How many images all descriptors name.
fn image_count(folder: &Path, sets: &ImageSets) -> u64 {
    let of_channel = |c: &ChannelSets| {
        let spectral = c.wavelengths.iter().filter_map(|set| set.descriptor.clone());
        let thermal = c.temperatures.iter().map(|set| set.descriptor.clone());
        std::iter::once(c.descriptor.clone()).chain(spectral).chain(thermal).collect::<Vec<_>>()
    };
    let lines = |path: String| {
        let text = std::fs::read_to_string(folder.join(path)).unwrap_or_default();
        text.lines().filter(|line| line.starts_with("i ")).count() as u64
    };
    sets.channels.iter().flat_map(of_channel).map(lines).sum()
}

fn conditions([width, height]: [usize; 2], bits: u32) -> Vec<(String, String)> {
    vec![
        ("Images".to_owned(), format!("{width} × {height} pixels")),
        ("Digital numbers".to_owned(), format!("{bits} bits")),
    ]
}

fn of_channel(folder: &Path, sets: &ChannelSets, monitor: &TerminalMonitor) -> Result<(ChannelReport, u32)> {
    let taken = || monitor.report(Event::PictureEnds);
    let read = |path: &str| read_set(&folder.join(path), &taken);
    let title = format!(
        "Channel {} at {} nm and {} °C",
        sets.channel,
        rounded(sets.wavelength_nm, 6),
        rounded(sets.temperature_c, 6)
    );
    let set = read(&sets.descriptor)?;
    let bits = set.descriptor.bits;
    let unfit = |path: &str| {
        let path = folder.join(path);
        move |invalid: Invalid| invalid.in_file(&path)
    };
    let mut report = channel_report(title, set, Some(sets.expected)).map_err(unfit(&sets.descriptor))?;
    // K is the sensor's, whatever the wavelength and the temperature.
    let gain = report.evaluation.figures.system_gain_dn_per_e;
    for set in &sets.wavelengths {
        let measured = match &set.descriptor {
            Some(path) => Some(responsivity(&read(path)?.points).map_err(unfit(path))? / gain),
            None => None,
        };
        report.spectral.push(SpectralPoint {
            wavelength_nm: set.wavelength_nm,
            expected: set.quantum_efficiency,
            measured,
        });
    }
    for set in &sets.temperatures {
        let evaluation = evaluate(read(&set.descriptor)?.points, None).map_err(unfit(&set.descriptor))?;
        let Some(fit) = evaluation.dark_current else { continue };
        report.thermal.push(ThermalPoint {
            temperature_c: set.temperature_c,
            expected: set.dark_current_e_per_s,
            from_mean: fit.mean.slope / gain,
            from_variance: fit.variance.slope / (gain * gain),
        });
    }
    let currents = report.thermal.iter().map(|p| (p.temperature_c, p.from_mean));
    report.doubling_temperature_k = sets.doubling_temperature_k.zip(doubling_temperature(currents)).map(Into::into);
    Ok((report, bits))
}

fn channel_report(title: String, set: MeasuredSet, expected: Option<Figures>) -> Result<ChannelReport, Invalid> {
    let variances = match &set.stacks {
        Some([dark, bright]) => Some([dark.variances()?, bright.variances()?]),
        None => None,
    };
    Ok(ChannelReport {
        title,
        expected,
        evaluation: evaluate(set.points, variances)?,
        stacks: set.stacks,
        spectral: Vec::new(),
        thermal: Vec::new(),
        doubling_temperature_k: None,
    })
}
