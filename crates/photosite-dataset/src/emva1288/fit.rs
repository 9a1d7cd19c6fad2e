//! The fit of a sensor to the images of a camera.

use std::path::Path;

use serde::Serialize;

use photosite_core::math::float::rounded;
use photosite_core::{Invalid, Result, counted};
use photosite_files::image_sets::CameraSet;
use photosite_measure::characterisation::NotMeasured;
use photosite_measure::characterisation::camera_fit::{
    Assumption, CameraFit, CameraFrames, Defect, DefectKind, FittedGainStep, KnownFacts, MapNames, Measured, Mosaic,
    Parameter, fit_camera,
};
use photosite_pipeline::{Event, Monitor, go_on};

/// Request of a fit.
#[derive(Clone, Debug, Default)]
pub struct FitRequest {
    /// Channel to evaluate, where the images have several.
    pub channel: Option<String>,
    /// Facts that the images do not hold.
    pub known: KnownFacts,
    /// Whether measured patterns are wanted, for [`FittedCamera::sensor_file`]: what they lack is noted.
    pub maps: bool,
}

/// Sensor fitted to the images of a camera.
pub struct FittedCamera {
    /// Parameters and what is left out.
    pub fit: CameraFit,
    /// Origin of the images, as the sensor file states it.
    source: String,
    mosaic: Mosaic,
    /// System gain that the user states, DN/e⁻.
    known_gain: Option<f64>,
}

/// Object that `photosite fit --json` prints.
#[derive(Serialize)]
pub struct FitReport<'a> {
    photosite_version: &'static str,
    /// Columns and rows that were evaluated.
    size_px: [usize; 2],
    parameters: &'a [Parameter],
    assumed: &'a [Assumption],
    left_out: &'a [NotMeasured],
    notes: &'a [String],
    defects: &'a [Defect],
    /// Noise of the read-out by gain, where the images have several.
    gain_steps: &'a [FittedGainStep],
    photon_transfer: Vec<PointOfReport>,
    dark: Vec<DarkOfReport>,
}

/// Point of the photon transfer curve, DN and DN².
#[derive(Serialize)]
struct PointOfReport {
    photons: Option<f64>,
    signal_dn: Measured,
    noise_dn2: Measured,
    /// Whether K and R are fitted to it.
    is_fitted: bool,
}

/// Dark images of one exposure time, DN and DN².
#[derive(Serialize)]
struct DarkOfReport {
    exposure_s: Option<f64>,
    mean_dn: Measured,
    noise_dn2: Measured,
    row_noise_dn2: Measured,
    column_noise_dn2: Measured,
}

impl FittedCamera {
    /// Text of the sensor file. Files of measured patterns that `maps` names, relative to it, take the place of standard
    /// deviations.
    pub fn sensor_file(&self, maps: &MapNames) -> String {
        self.fit.sensor_file(&self.source, &self.mosaic, &self.told(maps))
    }

    /// Names of the maps that the images tell: of responses where there are flats, and of offsets where they are the same at all
    /// gains.
    pub fn told(&self, maps: &MapNames) -> MapNames {
        MapNames {
            prnu: maps.prnu.clone().filter(|_| self.fit.maps.response.is_some()),
            dsnu: maps.dsnu.clone().filter(|_| !has_offsets_by_gain(&self.fit)),
            defects: maps.defects.clone().filter(|_| self.defects_csv().is_some()),
        }
    }

    /// Responses of the pixels over their mean, row by row, for `noise.prnu_map`; `None` without flats.
    pub fn prnu_map(&self) -> Option<&[f32]> {
        self.fit.maps.response.as_ref().map(|map| &map.values[..])
    }

    /// Offsets of the pixels in electrons of the sensor file, row by row, for `noise.dsnu_map`; `None` where they change with
    /// gain.
    pub fn dsnu_map_e(&self) -> Option<Vec<f32>> {
        if has_offsets_by_gain(&self.fit) {
            return None;
        }
        let gain = self.gain();
        Some(self.fit.maps.dark_dn.values.iter().map(|dn| (f64::from(*dn) / gain) as f32).collect())
    }

    /// Table of the defective pixels that a sensor can have, for `defects.pixels`; `None` where there are none.
    pub fn defects_csv(&self) -> Option<String> {
        let has_current = self.fit.parameter("noise.dark_current_e_per_s").is_some();
        let line = |&Defect { x, y, kind, value }: &Defect| match (kind, value) {
            (DefectKind::Hot, Some(more)) if has_current => {
                Some(format!("{x},{y},hot,{}\n", rounded(more / self.gain(), 6)))
            }
            (DefectKind::Dead, _) => Some(format!("{x},{y},dead,\n")),
            (DefectKind::Stuck, Some(number)) => Some(format!("{x},{y},stuck,{number}\n")),
            (DefectKind::Hot | DefectKind::Stuck | DefectKind::Odd, _) => None,
        };
        let lines: String = self.fit.defects.iter().filter_map(line).collect();
        (!lines.is_empty()).then(|| format!("column,row,kind,value\n{lines}"))
    }

    /// System gain of the sensor file, DN/e⁻; 1 where DN stand for electrons.
    fn gain(&self) -> f64 {
        let gain = self.fit.parameter("adc.conversion_gain_dn_per_e").map(|parameter| parameter.measured.value);
        gain.or(self.known_gain).unwrap_or(1.0)
    }

    /// Report for programs.
    pub fn report(&self) -> FitReport<'_> {
        let CameraFit { size, parameters, assumed, left_out, notes, defects, transfer, dark, gain_steps, .. } =
            &self.fit;
        let points = transfer.points.iter().enumerate().map(|(i, point)| PointOfReport {
            photons: point.photons,
            signal_dn: point.signal,
            noise_dn2: point.noise,
            is_fitted: i < transfer.used,
        });
        let of_dark = dark.frames().iter().map(|frames| DarkOfReport {
            exposure_s: frames.time.map(|time| time.0),
            mean_dn: frames.statistics.mean,
            noise_dn2: frames.statistics.temporal.pixel,
            row_noise_dn2: frames.statistics.temporal.row,
            column_noise_dn2: frames.statistics.temporal.column,
        });
        FitReport {
            photosite_version: env!("CARGO_PKG_VERSION"),
            size_px: *size,
            parameters,
            assumed,
            left_out,
            notes,
            defects,
            gain_steps,
            photon_transfer: points.collect(),
            dark: of_dark.collect(),
        }
    }
}

/// Whether DSNU is told for each gain.
fn has_offsets_by_gain(fit: &CameraFit) -> bool {
    fit.gain_steps.iter().flat_map(|step| &step.parameters).any(|parameter| parameter.key.starts_with("noise.dsnu"))
}

/// Notes about maps whose single pixels the averages tell roughly.
fn notes_of_maps(fit: &CameraFit) -> Vec<String> {
    /// Correlation from which on a map is as good as the camera's own pattern.
    const GOOD: f64 = 0.95;
    let by_gain = has_offsets_by_gain(fit);
    let offsets = Some(&fit.maps.dark_dn).filter(|_| !by_gain);
    let maps = [("response", fit.maps.response.as_ref()), ("dark offsets", offsets)];
    let rough = maps.into_iter().filter_map(|(name, map)| Some((name, map?.correlation))).filter(|(_, r)| *r < GOOD);
    let note = |(name, correlation)| match correlation {
        0.0 => format!("the map of {name} is flat: no pattern of pixels is told apart from the noise of the averages"),
        _ => format!(
            "pixels of the map of {name} correlate by {correlation:.2} with the camera's own, since the averages have \
             noise: more images tell them better"
        ),
    };
    let mut notes: Vec<String> = rough.map(note).collect();
    if by_gain {
        notes.push("there is no map of dark offsets: they change with gain, and DSNU is told for each".to_owned());
    }
    if !fit.defects.is_empty() {
        let count = counted(fit.defects.len(), ["defective pixel", "defective pixels"]);
        notes.push(format!(
            "the maps leave out {count}: those that are hot, dead or stuck stand in a table of their own"
        ));
    }
    notes
}

/// Fits a sensor to the images of a descriptor, of a folder that `photosite emva1288` filled, or of any folder of dark
/// images and flats.
///
/// # Errors
///
/// Images that cannot be read, that are not of one camera, or of which none are dark.
pub fn fit_images(path: &Path, request: &FitRequest, monitor: &dyn Monitor) -> Result<FittedCamera> {
    let sets = CameraSet::find(path, request.channel.as_deref())?;
    if request.maps && sets[0].cfa.is_mosaic() {
        let message = "measured patterns are of all pixels, and of a mosaic one channel is fitted";
        return Err(Invalid::new("", message).help("fit it without maps").in_file(path));
    }
    let images: usize = sets.iter().flat_map(|set| &set.groups).map(|group| group.images.len()).sum();
    monitor.report(Event::SetBegins { images: images as u64 });
    // Images are read again for patterns; progress counts each once.
    let left = std::cell::Cell::new(images);
    let fit_set = |set: &CameraSet, system_gain: Option<f64>| {
        let read = |group: usize, image: usize| {
            go_on(monitor)?;
            if left.get() > 0 {
                left.set(left.get() - 1);
                monitor.report(Event::ImageEnds(None));
            }
            set.image(group, image)
        };
        let frames = CameraFrames { groups: &set.groups, size: set.size, bits: set.bits, read: &read };
        let stated = set.pixel_pitch_m.map(|pitch| pitch.map(|m| m * 1e6));
        let known = KnownFacts {
            system_gain,
            pixel_pitch_um: request.known.pixel_pitch_um.or(stated),
            wavelength_nm: request.known.wavelength_nm.or(set.wavelength_nm),
            ..request.known.clone()
        };
        fit_camera(&frames, &known)
    };
    let fitted = fit_gains(path, &sets, request.known.system_gain, &fit_set);
    monitor.report(Event::SetEnds);
    let (mut fit, set) = (fitted?, &sets[0]);
    if set.bits_are_assumed {
        let reason = "no file states them and no image is saturated".to_owned();
        fit.left_out.push(NotMeasured { figure: "bits of the converter", reason });
    }
    if let Some(gain) = &set.gain {
        let figures = if fit.gain_steps.is_empty() { "all figures" } else { "all figures but those of gain steps" };
        fit.notes.push(format!("{figures} are those of {}, which the sensor file calls 0 dB", gain.name));
    }
    if request.maps {
        let notes = notes_of_maps(&fit);
        fit.notes.extend(notes);
    }
    let mosaic = Mosaic { cfa: set.cfa.to_string(), size: set.whole_size, responses: responses(set, &fit)? };
    Ok(FittedCamera { fit, source: path.display().to_string(), mosaic, known_gain: request.known.system_gain })
}

/// Fits the images of each gain, and gathers the noise of the read-out in steps.
fn fit_gains(
    path: &Path,
    sets: &[CameraSet],
    system_gain: Option<f64>,
    fit_set: &dyn Fn(&CameraSet, Option<f64>) -> Result<CameraFit>,
) -> Result<CameraFit> {
    /// Departure of measured gains from stated ones that is told, dB, where it is no chance either.
    const TOLD_DB: f64 = 0.1;
    let mut first = fit_set(&sets[0], system_gain)?;
    let (Some(lowest), [_, higher @ ..]) = (&sets[0].gain, sets) else { return Ok(first) };
    let own = first.parameter("adc.conversion_gain_dn_per_e").map(|parameter| parameter.measured.value);
    let mut others = Vec::new();
    for set in higher {
        let Some(gain) = &set.gain else { continue };
        let stated_db = gain.decibels_over(lowest);
        let known = stated_db.and_then(|db| Some(own.or(system_gain)? * 10f64.powf(db / 20.0)));
        let fit = fit_set(set, known)?;
        let measured_db = fit.gain_over(&first);
        if let (Some([db, error]), Some(stated_db)) = (measured_db, stated_db)
            && (db - stated_db).abs() > TOLD_DB.max(3.0 * error)
        {
            first.notes.push(format!(
                "by photon transfer {} is {db:.2} ± {error:.2} dB above {}, and by its name {stated_db:.2} dB",
                gain.name, lowest.name
            ));
        }
        // Settings in decibels are what a capture names; of others, light tells what they are.
        let db = match (measured_db, stated_db) {
            (_, Some(stated)) if gain.is_in_decibels() => stated,
            (Some([measured, _]), _) => measured,
            (None, Some(stated)) => stated,
            (None, None) => {
                let message = format!("nothing tells how many dB {} is above {}", gain.name, lowest.name);
                let help = "add flats of both gains, or write gains in dB or as ISO speeds";
                return Err(Invalid::new("", message).help(help).in_file(path));
            }
        };
        first.notes.extend(fit.notes.iter().map(|note| format!("{}: {note}", gain.name)));
        others.push((db, gain.name.clone(), fit));
    }
    others.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
    if let Some((db, name, _)) = others.first().filter(|(db, ..)| *db <= 0.0) {
        let message = format!("{name} is {db:.2} dB above {}, the lowest gain by its name", lowest.name);
        return Err(Invalid::new("", message).help("check the gains that the images state").in_file(path));
    }
    first.add_gains(&lowest.name, &others);
    Ok(first)
}

/// Names of the channels with their responses to the light of the clearest flats over that of the channel that was
/// evaluated; 1 where there are no flats.
fn responses(set: &CameraSet, fit: &CameraFit) -> Result<Vec<(String, f64)>> {
    let names = set.cfa.channels();
    if !set.cfa.is_mosaic() {
        return Ok(vec![(names[0].clone(), 1.0)]);
    }
    let clearest = fit.transfer.clearest().map(|point| point.group);
    let dark = (0..set.groups.len()).find(|&group| {
        set.groups[group].is_dark() && clearest.is_none_or(|bright| set.groups[bright].time == set.groups[group].time)
    });
    let dark = dark.or_else(|| set.groups.iter().position(|group| group.is_dark()));
    let mean = |group: usize, place: [usize; 2]| -> Result<f64> {
        let numbers = set.image_at(group, 0, place)?;
        Ok(numbers.iter().map(|&n| f64::from(n)).sum::<f64>() / numbers.len() as f64)
    };
    let signal = |channel: usize| -> Result<f64> {
        let (Some(bright), Some(dark)) = (clearest, dark) else { return Ok(1.0) };
        let places = set.places(channel);
        let signals: Vec<f64> =
            places.iter().map(|&place| Ok(mean(bright, place)? - mean(dark, place)?)).collect::<Result<_>>()?;
        Ok(signals.iter().sum::<f64>() / signals.len().max(1) as f64)
    };
    let own = signal(set.channel)?;
    (0..names.len()).map(|channel| Ok((names[channel].clone(), signal(channel)? / own))).collect()
}
