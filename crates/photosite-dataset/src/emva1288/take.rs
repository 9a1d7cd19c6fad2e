//! Taking the image sets of EMVA 1288 with a sensor model in front of an even light.

use photosite_core::{Help, Remedy, input};
use std::fs;
use std::path::Path;

use photosite_core::output::{create_folder, write_unsynced};
use photosite_core::units::{Celsius, Decibels, Seconds};
use photosite_core::{Error, Invalid, Result, memory};
use photosite_files::formats::Format;
use photosite_files::image_sets::{CONTENTS, CameraSet, ChannelSets, ImageSets, SetWriter, SpectralSet, ThermalSet};
use photosite_files::lock::Lock;
use photosite_files::unfinished::{UnfinishedFolder, is_filled, unfinished_folders};
use photosite_measure::characterisation::{
    Descriptor, FlatField, OperatingPoint, Plan, Series, Shot, doubling_temperature, expected_figures,
    quantum_efficiency,
};
use photosite_pipeline::{Event, Monitor, go_on};
use photosite_sensor::SensorModel;

/// Number of exposure times of a set for the dark current.
const THERMAL_STEPS: u32 = 10;

/// Image sets that are to be taken.
#[derive(Clone, Debug)]
pub struct SetRequest {
    /// Names of the channels; `None` for all.
    pub channels: Option<Vec<String>>,
    /// Wavelength of the light; `None` for where each channel's quantum efficiency is greatest.
    pub wavelength_nm: Option<f64>,
    /// Plan of the linear model's set in place of the one that `steps`, `spatial` and `saturation_time` make.
    pub plan: Option<Plan>,
    /// Number of exposure times of the photon transfer curve.
    pub steps: u32,
    /// Number of images of each stack for spatial non-uniformity.
    pub spatial: u32,
    /// Exposure time that saturates; `None` for one that is long enough to measure the dark current.
    pub saturation_time: Option<Seconds>,
    /// Wavelengths at which the quantum efficiency is measured, too.
    pub sweep_nm: Vec<f64>,
    /// Temperatures at which the dark current is measured, too.
    pub temperatures_c: Vec<f64>,
    /// Temperature of the sensor; `None` for 25 °C.
    pub temperature: Option<Celsius>,
    /// Gain of all exposures.
    pub gain: Decibels,
    /// Columns and rows of the images; `None` for 512 × 512, or what the sensor has.
    pub size: Option<[usize; 2]>,
    /// Seed of temporal noise.
    pub seed: u64,
    /// File format of the images.
    pub format: &'static Format,
    /// Changes to the sensor that `emva1288.json` states, `key=value`.
    pub overrides: Vec<String>,
}

impl SetRequest {
    /// The request of the same images as a set: a descriptor, or a folder that [`SetPlan::take_into`] filled. What the
    /// request itself says of wavelength, temperature and size stays.
    pub fn like(self, set: &Path) -> Result<Self> {
        let channel = self.channels.as_deref().and_then(|names| names.first()).map(String::as_str);
        let mut sets = CameraSet::find(set, channel)?;
        let CameraSet { groups, size, wavelength_nm, .. } = sets.swap_remove(0);
        if !sets.is_empty() {
            let help = "give a folder of one gain: an image set has one";
            return Err(Invalid::new("", "has images of several gains").help(help).in_file(set));
        }
        let temperature = groups.iter().find(|group| !group.is_dark()).and_then(|group| group.temperature);
        let of_set: Vec<_> = groups.into_iter().filter(|group| group.temperature == temperature).collect();
        let plan = Plan::like(&of_set).map_err(|invalid| invalid.in_file(set))?;
        Ok(Self {
            plan: Some(plan),
            size: self.size.or(Some(size)),
            wavelength_nm: self.wavelength_nm.or(wavelength_nm),
            temperature: self.temperature.or(temperature),
            ..self
        })
    }
}

/// Image sets that can be taken of a sensor.
pub struct SetPlan<'a> {
    sensor: &'a SensorModel,
    request: SetRequest,
    size: [usize; 2],
    work: Vec<Work>,
}

impl<'a> SetPlan<'a> {
    /// Plans the image sets.
    ///
    /// # Errors
    ///
    /// A channel that the sensor lacks, images that it cannot take, exposures that it cannot make.
    pub fn new(sensor: &'a SensorModel, request: SetRequest) -> Result<Self> {
        let size = image_size(sensor, request.size)?;
        let work = works(&request, sensor)?;
        Ok(Self { sensor, request, size, work })
    }

    /// Number of images to take.
    pub fn images(&self) -> u64 {
        self.work.iter().map(Work::images).sum()
    }

    /// Takes the images into a new folder, or replaces image sets if that is allowed.
    pub fn take_into(&self, output: &Path, force: bool, monitor: &dyn Monitor) -> Result<ImageSets> {
        let Self { sensor, request, size, work } = self;
        check_memory(sensor, *size)?;
        create_folder(output.parent().unwrap_or(Path::new("")))?;
        let lock = Lock::beside(output)?;
        // Another process may have finished in the meantime.
        refuse_image_sets(output, force)?;
        if lock.is_proven() {
            // Of dead processes; nothing depends on it.
            unfinished_folders(output).iter().for_each(|folder| drop(fs::remove_dir_all(folder)));
        }
        let folder = UnfinishedFolder::beside(output, |_| false)?;
        monitor.report(Event::SetBegins { images: self.images() });
        let writer = SetWriter::new(folder.path(), request.format, request.seed);
        let mut camera = Camera { sensor, size: *size, writer, monitor };
        let channels = work.iter().map(|work| camera.take_channel(work)).collect::<Result<_>>();
        monitor.report(Event::SetEnds);
        let sets = ImageSets {
            photosite_version: env!("CARGO_PKG_VERSION").to_owned(),
            sensor: sensor.name.clone(),
            description: sensor.description.clone(),
            overrides: request.overrides.clone(),
            seed: request.seed,
            size_px: *size,
            gain_db: request.gain.0,
            channels: channels?,
        };
        write_unsynced(&folder.path().join(CONTENTS), |to| {
            serde_json::to_writer_pretty(&mut *to, &sets)?;
            writeln!(to)
        })?;
        move_into_place(folder, output, force)?;
        Ok(sets)
    }
}

/// Refuses images that take more memory than there is. The bytes per pixel are measured.
fn check_memory(sensor: &SensorModel, [width, height]: [usize; 2]) -> Result<()> {
    const PIXEL: u64 = 14;
    let channels = sensor.cfa.channels().len() as u64;
    let bytes = (width as u64).saturating_mul(height as u64).saturating_mul(PIXEL * channels);
    let checked = memory::check(bytes, &format!("an image of {width} × {height} pixels"), "ask for smaller ones");
    checked.map_err(|Invalid { message, help, .. }| Error::Resources { message, help })
}

/// Image sets of one channel that are to be taken.
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

/// Plans all image sets before any is taken.
fn works(request: &SetRequest, sensor: &SensorModel) -> Result<Vec<Work>> {
    let names = sensor.cfa.channels();
    let usage = |Invalid { key, message, help }: Invalid| {
        let message = if key.is_empty() { message } else { format!("{key}: {message}") };
        Error::Usage { message, help }
    };
    let work = |channel: usize| {
        let wavelength_nm = request.wavelength_nm.unwrap_or_else(|| peak(sensor, channel));
        let (gain, temperature) = (request.gain, request.temperature.unwrap_or(Celsius(25.0)));
        let point = OperatingPoint { channel, wavelength_nm, gain, temperature };
        point.validate(sensor)?;
        let linear = match &request.plan {
            Some(plan) => plan.clone(),
            None => Plan::linear(sensor, &point, request.steps, request.spatial, request.saturation_time)?,
        };
        let half = linear.half_time;
        let spectral = |nm: f64| (nm, Plan::spectral(sensor, &OperatingPoint { wavelength_nm: nm, ..point }, half));
        let thermal = |celsius: f64| -> Result<(f64, Plan), Invalid> {
            let point = OperatingPoint { temperature: Celsius(celsius), ..point };
            point.validate(sensor)?;
            Ok((celsius, Plan::dark_current(sensor, &point, THERMAL_STEPS)?))
        };
        Ok(Work {
            point,
            spectral: request.sweep_nm.iter().copied().map(spectral).collect(),
            thermal: request.temperatures_c.iter().copied().map(thermal).collect::<Result<_, _>>()?,
            linear,
        })
    };
    let find = |name: &String| {
        names.iter().position(|n| n == name).ok_or_else(|| Error::Usage {
            message: format!("sensor {} has no channel {name:?}", sensor.name),
            help: Some(format!("its channels are {}", names.join(", ")).into()),
        })
    };
    let wanted: Vec<usize> = match &request.channels {
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
            help: Some("use photosite noise to measure its images".into()),
        });
    }
    let has_patterns = sensor.has_measured_patterns();
    let size = wanted.unwrap_or(largest.map(|side| if has_patterns { side } else { side.min(512) }));
    if has_patterns && size != sensor.resolution {
        let ([w, h], [columns, rows]) = (size, sensor.resolution);
        return Err(Error::Usage {
            message: format!(
                "images of {w} × {h} pixels: the measured patterns of sensor {} are of {columns} × {rows}",
                sensor.name
            ),
            help: Some(
                "take images of all pixels of a sensor of one channel, or leave out its prnu_map and dsnu_map".into(),
            ),
        });
    }
    if (0..2).any(|axis| size[axis] > largest[axis] || size[axis] < 3) {
        let [[w, h], [most_w, most_h]] = [size, largest];
        return Err(Error::Usage {
            message: format!("images of {w} × {h} pixels cannot be taken of one channel of sensor {}", sensor.name),
            help: Some(format!("it has {most_w} × {most_h} pixels of each; write at least 3x3").into()),
        });
    }
    Ok(size)
}

/// Sensor in front of a light source, and the folder of its images.
struct Camera<'a> {
    sensor: &'a SensorModel,
    size: [usize; 2],
    writer: SetWriter,
    monitor: &'a dyn Monitor,
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
        let taken = || {
            self.monitor.report(Event::ImageEnds(None));
            go_on(self.monitor)
        };
        let series: Vec<Series> =
            shots.iter().map(|shot| self.writer.take(set, &flat, shot, &taken)).collect::<Result<_>>()?;
        let [width, height] = self.size;
        self.writer.describe(descriptor, &Descriptor { bits: self.sensor.converter.bits, width, height, series })
    }
}

/// Shots with the name of their set before their own.
fn named(set: &str, shots: &[Shot]) -> Vec<Shot> {
    shots.iter().map(|shot| Shot { name: format!("{set}-{}", shot.name), ..shot.clone() }).collect()
}

/// Refuses an output folder that holds something other than image sets, or image sets without `force`.
pub fn refuse_image_sets(output: &Path, force: bool) -> Result<()> {
    let usage = |message, help: Help| Err(Error::Usage { message, help: Some(help) });
    let Ok(mut entries) = input::entries(output) else {
        if output.exists() {
            return usage(
                format!("{} is not a folder", output.display()),
                Remedy::Elsewhere("another name".to_owned()).into(),
            );
        }
        return Ok(());
    };
    if entries.next().is_none() {
        return Ok(());
    }
    if !output.join(CONTENTS).exists() {
        return usage(
            format!("{} contains other files", output.display()),
            Remedy::Elsewhere("a new folder".to_owned()).into(),
        );
    }
    if !force {
        let help = Help::any([Remedy::Overwrite, elsewhere()]);
        return usage(format!("{} already contains image sets", output.display()), help);
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
            return Err(Invalid::new("", message).help(elsewhere()).in_file(output));
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
    Err(Error::Usage { message, help: Some(elsewhere().into()) })
}

fn elsewhere() -> Remedy {
    Remedy::Elsewhere("another folder".to_owned())
}
