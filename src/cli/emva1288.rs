//! `photosite emva1288`: the image sets that EMVA 1288 asks for, of a sensor's model, and the figures that they must show.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use photosite::capture::read_named_sensor;
use photosite::characterisation::{
    Descriptor, FlatField, OperatingPoint, Plan, Series, Shot, doubling_temperature, effects_left_out,
    expected_figures, quantum_efficiency,
};
use photosite::io::image_sets::{CONTENTS, ChannelSets, ImageFormat, ImageSets, SetWriter, SpectralSet, ThermalSet};
use photosite::io::lock::Lock;
use photosite::io::output::{create_folder, write_unsynced};
use photosite::io::unfinished::{UnfinishedFolder, is_filled, unfinished_folders};
use photosite::pipeline::{Event, Monitor};
use photosite::sensor::SensorModel;
use photosite::units::{Celsius, Decibels, Seconds};
use photosite::{Error, Invalid, Result};

use super::figures_text::expected_text;
use super::monitor::TerminalMonitor;
use super::{print_json, println_out};

/// Take the images that EMVA 1288 asks for, and tell what they must show.
///
/// Every pixel receives exactly the same light, which is no renderer's. Of a colour sensor each channel gets a set of its
/// own, of the pixels of that channel alone.
#[derive(Args)]
pub(super) struct Emva1288Args {
    /// A preset (see photosite sensors) or a sensor file.
    sensor: String,
    /// Folder for the image sets [default: emva1288-SENSOR].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Change a key of the sensor, for example noise.read_noise_e=2.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Take these channels only, for example G [default: all].
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
    #[arg(long, value_name = "NM", value_parser = range)]
    sweep: Option<Range>,
    /// Measure the dark current at these temperatures, too, for example 15..55:10.
    #[arg(long, value_name = "CELSIUS", value_parser = range, allow_hyphen_values = true)]
    temperatures: Option<Range>,
    /// Temperature of the sensor.
    #[arg(long, value_name = "CELSIUS", default_value_t = 25.0, allow_hyphen_values = true)]
    temperature_c: f64,
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
    #[arg(long, value_enum, default_value_t = Format::Tiff)]
    format: Format,
    /// Replace image sets that are there already.
    #[arg(long)]
    force: bool,
    /// Print what emva1288.json holds instead of text.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors.
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    Tiff,
    Dng,
    Png,
}

/// First value, last value, step: `380..1000:10`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range([f64; 3]);

impl Range {
    fn values(self) -> Vec<f64> {
        let [first, last, step] = self.0;
        // The last value belongs to it, whatever rounding makes of the division.
        let count = ((last - first) / step * (1.0 + 1e-12)).floor() as u32;
        (0..=count).map(|i| first + f64::from(i) * step).collect()
    }
}

/// Exposure times of a set for the dark current.
const THERMAL_STEPS: u32 = 10;
/// Most values of a range.
const MOST_VALUES: f64 = 10_000.0;

pub(super) fn run(args: &Emva1288Args) -> Result<()> {
    let (sensor, warnings) = read_named_sensor(&args.sensor, &args.overrides)?;
    let output = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("emva1288-{}", sensor.name)));
    let size = image_size(&sensor, args.size)?;
    let work = works(args, &sensor)?;
    refuse_output(&output, args.force)?;
    if !args.quiet {
        warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
        for key in effects_left_out(&sensor) {
            eprintln!("warning: {key} is in the images, but not in the figures that are expected of them");
        }
    }

    create_folder(output.parent().unwrap_or(Path::new("")))?;
    let lock = Lock::beside(&output)?;
    // Another process may have finished in the meantime.
    refuse_output(&output, args.force)?;
    if lock.is_proven() {
        // Of dead processes; nothing depends on it.
        unfinished_folders(&output).iter().for_each(|folder| drop(fs::remove_dir_all(folder)));
    }
    let folder = UnfinishedFolder::beside(&output, |_| false)?;
    let images = work.iter().map(Work::images).sum();
    let monitor = TerminalMonitor::new(args.quiet, args.json);
    monitor.report(Event::SetBegins { pictures: images });
    let mut camera = Camera {
        sensor: &sensor,
        size,
        writer: SetWriter::new(folder.path(), args.format.into(), args.seed),
        monitor: &monitor,
    };
    let channels = work.iter().map(|work| camera.take_channel(work)).collect::<Result<_>>()?;
    monitor.report(Event::SetEnds);

    let sets = ImageSets {
        photosite_version: env!("CARGO_PKG_VERSION").to_owned(),
        sensor: sensor.name.clone(),
        description: sensor.description.clone(),
        overrides: args.overrides.clone(),
        seed: args.seed,
        size_px: size,
        gain_db: args.gain_db,
        channels,
    };
    write_unsynced(&folder.path().join(CONTENTS), |to| {
        serde_json::to_writer_pretty(&mut *to, &sets)?;
        writeln!(to)
    })?;
    move_into_place(folder, &output, args.force)?;
    if args.json {
        print_json(&sets)
    } else if args.quiet {
        Ok(())
    } else {
        println_out(&expected_text(&sets))?;
        println_out(&format!("\n{images} images in {}", output.display()))
    }
}

impl From<Format> for ImageFormat {
    fn from(format: Format) -> Self {
        match format {
            Format::Tiff => ImageFormat::Tiff,
            Format::Dng => ImageFormat::Dng,
            Format::Png => ImageFormat::Png,
        }
    }
}

/// All that is to be taken of one channel.
struct Work {
    point: OperatingPoint,
    linear: Plan,
    /// Wavelengths with their plans; none where the channel is blind.
    spectral: Vec<(f64, Option<Plan>)>,
    /// Temperatures with their plans.
    thermal: Vec<(f64, Plan)>,
}

impl Work {
    fn images(&self) -> u64 {
        let plans = std::iter::once(&self.linear)
            .chain(self.spectral.iter().filter_map(|(_, plan)| plan.as_ref()))
            .chain(self.thermal.iter().map(|(_, plan)| plan));
        plans.flat_map(|plan| &plan.shots).map(|shot| u64::from(shot.images)).sum()
    }
}

/// Settles what is to be done before anything is.
fn works(args: &Emva1288Args, sensor: &SensorModel) -> Result<Vec<Work>> {
    let names = sensor.cfa.channels();
    let usage = |Invalid { key, message, help }: Invalid| {
        let message = if key.is_empty() { message } else { format!("{key}: {message}") };
        Error::Usage { message, help }
    };
    let work = |channel: usize| {
        let wavelength_nm = args.wavelength_nm.unwrap_or_else(|| peak(sensor, channel));
        let (gain, temperature) = (Decibels(args.gain_db), Celsius(args.temperature_c));
        let point = OperatingPoint { channel, wavelength_nm, gain, temperature };
        point.validate(sensor)?;
        let linear = Plan::linear(sensor, &point, args.steps, args.spatial, args.saturation_time_s.map(Seconds))?;
        let half = linear.half_time;
        let spectral = |nm: f64| (nm, Plan::spectral(sensor, &OperatingPoint { wavelength_nm: nm, ..point }, half));
        let thermal = |celsius: f64| -> Result<(f64, Plan), Invalid> {
            let point = OperatingPoint { temperature: Celsius(celsius), ..point };
            point.validate(sensor)?;
            Ok((celsius, Plan::dark_current(sensor, &point, THERMAL_STEPS)?))
        };
        Ok(Work {
            point,
            spectral: args.sweep.map_or_else(Vec::new, Range::values).into_iter().map(spectral).collect(),
            thermal: args
                .temperatures
                .map_or_else(Vec::new, Range::values)
                .into_iter()
                .map(thermal)
                .collect::<Result<_, _>>()?,
            linear,
        })
    };
    let find = |name: &String| {
        names.iter().position(|n| n == name).ok_or_else(|| Error::Usage {
            message: format!("sensor {} has no channel {name:?}", sensor.name),
            help: Some(format!("its channels are {}", names.join(", "))),
        })
    };
    let wanted: Vec<usize> = match &args.channels {
        Some(names) => names.iter().map(find).collect::<Result<_>>()?,
        None => (0..names.len()).collect(),
    };
    wanted.into_iter().map(|channel| work(channel).map_err(usage)).collect()
}

/// Wavelength at which a channel's quantum efficiency is greatest, nm.
fn peak(sensor: &SensorModel, channel: usize) -> f64 {
    let response = &sensor.responses()[channel].1;
    // The response counts electrons per energy; per photon it is smaller by the wavelength.
    let greatest = response.iter().max_by(|(l, a), (m, b)| (a / l).total_cmp(&(b / m)));
    greatest.map_or(550.0, |(lambda_nm, _)| lambda_nm)
}

fn image_size(sensor: &SensorModel, wanted: Option<[usize; 2]>) -> Result<[usize; 2]> {
    let largest = FlatField::largest_size(sensor);
    if largest.iter().any(|&side| side < 3) {
        return Err(Error::Usage {
            message: format!("sensor {} is a line of pixels, and EMVA 1288 measures areas", sensor.name),
            help: Some("photosite noise takes the figures of its pictures".to_owned()),
        });
    }
    let size = wanted.unwrap_or(largest.map(|side| side.min(512)));
    if (0..2).any(|axis| size[axis] > largest[axis] || size[axis] < 3) {
        let [[w, h], [most_w, most_h]] = [size, largest];
        return Err(Error::Usage {
            message: format!("images of {w} × {h} pixels cannot be taken of one channel of sensor {}", sensor.name),
            help: Some(format!("it has {most_w} × {most_h} pixels of each; write at least 3x3")),
        });
    }
    Ok(size)
}

/// A sensor in front of a lamp, and the folder that its images go to.
struct Camera<'a> {
    sensor: &'a SensorModel,
    size: [usize; 2],
    writer: SetWriter,
    monitor: &'a TerminalMonitor,
}

impl Camera<'_> {
    fn take_channel(&mut self, work: &Work) -> Result<ChannelSets> {
        let Work { point, linear, spectral, thermal } = work;
        let sensor = self.sensor;
        let channel = sensor.cfa.channels()[point.channel].clone();
        let descriptor = format!("{channel}/emva1288.txt");
        self.take_set(&descriptor, &channel, point, &linear.shots)?;

        let folder = format!("{channel}/wavelengths");
        let mut wavelengths = Vec::new();
        for (wavelength_nm, plan) in spectral {
            let point = OperatingPoint { wavelength_nm: *wavelength_nm, ..*point };
            let mut path = None;
            if let Some(plan) = plan {
                let name = format!("{wavelength_nm:04}");
                self.take_set(
                    path.insert(format!("{folder}/{name}.txt")),
                    &folder,
                    &point,
                    &named(&name, &plan.shots),
                )?;
            }
            wavelengths.push(SpectralSet {
                wavelength_nm: *wavelength_nm,
                descriptor: path,
                quantum_efficiency: quantum_efficiency(sensor, point.channel, *wavelength_nm),
            });
        }

        let folder = format!("{channel}/temperatures");
        let mut temperatures = Vec::new();
        for (temperature_c, plan) in thermal {
            let point = OperatingPoint { temperature: Celsius(*temperature_c), ..*point };
            let name = format!("{temperature_c:+}");
            let descriptor = format!("{folder}/{name}.txt");
            self.take_set(&descriptor, &folder, &point, &named(&name, &plan.shots))?;
            temperatures.push(ThermalSet {
                temperature_c: *temperature_c,
                descriptor,
                dark_current_e_per_s: sensor.noise.dark_current(point.temperature),
            });
        }
        Ok(ChannelSets {
            descriptor,
            wavelength_nm: point.wavelength_nm,
            temperature_c: point.temperature.0,
            expected: expected_figures(sensor, point, linear),
            wavelengths,
            doubling_temperature_k: doubling_temperature(
                temperatures.iter().map(|set| (set.temperature_c, set.dark_current_e_per_s)),
            ),
            temperatures,
            channel,
        })
    }

    /// Takes the images of a set into the folder `set` and describes them.
    fn take_set(&mut self, descriptor: &str, set: &str, point: &OperatingPoint, shots: &[Shot]) -> Result<()> {
        let flat = FlatField::new(self.sensor, point, self.size);
        let taken = || self.monitor.report(Event::PictureEnds);
        let series: Vec<Series> =
            shots.iter().map(|shot| self.writer.take(set, &flat, shot, &taken)).collect::<Result<_>>()?;
        let [width, height] = self.size;
        self.writer.describe(descriptor, &Descriptor { bits: self.sensor.converter.bits, width, height, series })
    }
}

/// Shots whose names begin with that of their set.
fn named(set: &str, shots: &[Shot]) -> Vec<Shot> {
    shots.iter().map(|shot| Shot { name: format!("{set}-{}", shot.name), ..shot.clone() }).collect()
}

/// Only image sets may be replaced, and only if asked for.
fn refuse_output(output: &Path, force: bool) -> Result<()> {
    let usage = |message, help: &str| Err(Error::Usage { message, help: Some(help.to_owned()) });
    let Ok(mut entries) = fs::read_dir(output) else {
        if output.exists() {
            return usage(format!("{} is no folder", output.display()), "choose another name with -o");
        }
        return Ok(());
    };
    if entries.next().is_none() {
        return Ok(());
    }
    if !output.join(CONTENTS).exists() {
        return usage(format!("{} holds other files", output.display()), "choose a new folder with -o");
    }
    if !force {
        let help = "add --force to replace them, or choose another folder with -o";
        return usage(format!("{} holds image sets already", output.display()), help);
    }
    Ok(())
}

/// Gives the finished folder its name, in the place of an older one if that may be replaced.
fn move_into_place(folder: UnfinishedFolder, output: &Path, force: bool) -> Result<()> {
    if force && is_filled(output) {
        // Out of the way in one step, so that it is never there in part.
        let older = UnfinishedFolder::beside(output, |_| false)?;
        if !older.take_over(output) {
            let message = "cannot be replaced";
            return Err(Invalid::new("", message).help("choose another folder with -o").in_file(output));
        }
        return give_name(folder, output).inspect_err(|_| {
            // As it was, as far as that is possible.
            let _ = fs::rename(older.path(), output);
        });
    }
    give_name(folder, output)
}

fn give_name(folder: UnfinishedFolder, output: &Path) -> Result<()> {
    if folder.finish()? {
        return Ok(());
    }
    let message = format!("{} was filled by another process", output.display());
    Err(Error::Usage { message, help: Some("choose another folder with -o".to_owned()) })
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or_else(|| "write a number above 0".to_owned())
}

fn wavelength(text: &str) -> Result<f64, String> {
    let fits = |nm: &f64| (300.0..=1100.0).contains(nm);
    text.parse().ok().filter(fits).ok_or_else(|| "write a wavelength from 300 to 1100, in nm".to_owned())
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let parts = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parts.ok_or_else(|| "write width and height, for example 512x512".to_owned())
}

fn range(text: &str) -> Result<Range, String> {
    let wrong = || "write first, last and step, for example 380..1000:10".to_owned();
    let (ends, step) = text.split_once(':').ok_or_else(wrong)?;
    let (first, last) = ends.split_once("..").ok_or_else(wrong)?;
    let number = |text: &str| text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(wrong);
    let range = [number(first)?, number(last)?, number(step)?];
    let [first, last, step] = range;
    if step > 0.0 && last >= first && (last - first) / step < MOST_VALUES { Ok(Range(range)) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_both_ends() {
        let sweep = range("380..1000:10").expect("a range").values();
        assert_eq!((sweep.len(), sweep[0], sweep[62]), (63, 380.0, 1000.0));
        assert_eq!(range("-0.3..0.3:0.1").expect("a range").values().len(), 7);
        assert_eq!(range("25..25:5").expect("a range").values(), [25.0]);
        for wrong in ["380..1000", "380-1000:10", "1000..380:10", "0..1:0", "0..inf:1", "0..1e9:1e-3"] {
            assert!(range(wrong).is_err(), "{wrong}");
        }
    }
}
