//! Figures measured from image sets.

use std::path::Path;

use photosite_core::input;
use photosite_core::math::float::rounded;
use photosite_core::{Invalid, Result};
use photosite_files::image_sets::{CONTENTS, ChannelSets, ImageSets, MeasuredSet, read_set};
use photosite_measure::characterisation::report::{ChannelReport, Report, SpectralPoint, ThermalPoint};
use photosite_measure::characterisation::{Figures, bound_at_95_percent, doubling_temperature, evaluate, responsivity};
use photosite_pipeline::{Event, Monitor, go_on};

/// Evaluates the images of any camera.
pub fn evaluate_descriptor(path: &Path, monitor: &dyn Monitor) -> Result<Report> {
    let set = read(path, &|| go_on(monitor), monitor)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let conditions = conditions([set.descriptor.width, set.descriptor.height], set.descriptor.bits);
    let channel = channel_report("Figures".to_owned(), set, None).map_err(|invalid| invalid.in_file(path))?;
    Ok(Report { sensor: name, description: String::new(), conditions, channels: vec![channel] })
}

/// Evaluates image sets that photosite took.
pub fn evaluate_sets(folder: &Path, monitor: &dyn Monitor) -> Result<Report> {
    if !folder.join(CONTENTS).exists() {
        let help = "give a folder that photosite emva1288 filled, or a descriptor of images (.txt)";
        return Err(Invalid::new("", format!("has no {CONTENTS}")).help(help).in_file(folder));
    }
    let sets = ImageSets::read(folder)?;
    monitor.report(Event::SetBegins { images: image_count(folder, &sets) });
    let mut channels = Vec::new();
    let mut bits = 0;
    for channel in &sets.channels {
        let (report, its_bits) = of_channel(folder, channel, monitor)?;
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

/// Reads a set and reports its warnings.
fn read(path: &Path, taken: &dyn Fn() -> Result<()>, monitor: &dyn Monitor) -> Result<MeasuredSet> {
    let set = read_set(path, taken)?;
    set.warnings.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
    Ok(set)
}

/// Number of images that all descriptors name.
fn image_count(folder: &Path, sets: &ImageSets) -> u64 {
    let of_channel = |c: &ChannelSets| {
        let spectral = c.wavelengths.iter().filter_map(|set| set.descriptor.clone());
        let thermal = c.temperatures.iter().map(|set| set.descriptor.clone());
        std::iter::once(c.descriptor.clone()).chain(spectral).chain(thermal).collect::<Vec<_>>()
    };
    let lines = |path: String| {
        let text = input::read_text(&folder.join(path), input::TABLE_BYTES).unwrap_or_default();
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

fn of_channel(folder: &Path, sets: &ChannelSets, monitor: &dyn Monitor) -> Result<(ChannelReport, u32)> {
    let taken = || {
        monitor.report(Event::ImageEnds(None));
        go_on(monitor)
    };
    let read = |path: &str| read(&folder.join(path), &taken, monitor);
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
        let MeasuredSet { points, more_dark, .. } = read(&set.descriptor)?;
        let evaluation = evaluate(points, &more_dark, None).map_err(unfit(&set.descriptor))?;
        let Some(fit) = evaluation.dark_current else { continue };
        let told_apart = |slope: f64, error: f64| bound_at_95_percent(slope, error).is_none().then_some(slope);
        let from_variance = fit.variance.and_then(|line| told_apart(line.slope, fit.variance_error));
        report.thermal.push(ThermalPoint {
            temperature_c: set.temperature_c,
            expected: set.dark_current_e_per_s,
            from_mean: told_apart(fit.mean.slope, fit.mean_error).map(|slope| slope / gain),
            from_variance: from_variance.map(|slope| slope / (gain * gain)),
        });
    }
    let currents = report.thermal.iter().filter_map(|p| Some((p.temperature_c, p.from_mean?)));
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
        pixels: set.descriptor.width * set.descriptor.height,
        expected,
        evaluation: evaluate(set.points, &set.more_dark, variances)?,
        stacks: set.stacks,
        spectral: Vec::new(),
        thermal: Vec::new(),
        doubling_temperature_k: None,
    })
}
