//! Settings of the exposure, from the table `[exposure]`.

use super::super::tables::{ExposureTable, LONGEST_STEP_EV};
use super::super::tree::numbers::positive_number;
use photosite_core::Invalid;
use photosite_core::units::{Celsius, Decibels, Seconds};
use photosite_raw::PixelArea;
use photosite_sensor::{
    AutoExposure, Binning, BinningMethod, Exposure, GainControl, Metering, RegionOfInterest, SensorModel, Stages,
};

/// Most frames of one capture, each of which has a file of its own in one folder.
const MOST_FRAMES: u32 = 1_000_000;

/// Longest time of an automatic exposure that is not told another, s: a camera on a stand, of which nobody waits longer
/// for an image; the gain rises instead.
pub(crate) const LONGEST_AUTO_S: f64 = 4.0;

/// Settings of the sensor's exposure.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposureSettings {
    /// Exposure time, stated or automatic.
    pub time: ExposureTime,
    /// Analogue gain; automatic gain control starts from here.
    pub gain: Decibels,
    /// Digital gain, behind the converter; automatic gain control starts from here.
    pub digital_gain: Decibels,
    /// Gain control, which lets the analogue gain follow the light from image to image.
    pub gain_control: Option<GainControl>,
    /// Temperature of the sensor.
    pub temperature: Celsius,
    /// Bracket: other times for which the same light is exposed, in place of frames.
    pub bracket: Option<Bracket>,
    /// Number of images of the same light, at least 1.
    pub frames: u32,
    /// Time from the start of one image to that of the next, where it is longer than the exposure.
    pub frame_interval: Option<Seconds>,
    /// Region of the sensor that is read out.
    pub region: RegionOfInterest,
    /// The stages of the sensor that take part.
    pub stages: Stages,
}

impl ExposureSettings {
    /// Whether images of the same light are exposed in the same way, however many there are.
    pub fn is_like(&self, other: &Self) -> bool {
        Self { frames: 1, ..self.clone() } == Self { frames: 1, ..other.clone() }
    }

    /// Warning about settings that change nothing.
    pub fn warning(&self) -> Option<String> {
        let is_idle = self.gain_control.is_some() && self.frames == 1;
        is_idle.then(|| "exposure.gain_control: acts from one image to the next, but exposure.frames is 1".to_owned())
    }

    /// An exposure of this time.
    pub fn at(&self, time: Seconds) -> Exposure {
        let &Self { gain, digital_gain, temperature, frame_interval, region, .. } = self;
        Exposure { time, gain, digital_gain, temperature, frame_interval, region }
    }
}

/// Times of a bracket.
#[derive(Clone, Debug, PartialEq)]
pub enum Bracket {
    /// Steps from the time of the exposure, EV.
    Steps(Vec<f64>),
    /// Times that are stated.
    Times(Vec<Seconds>),
}

impl Bracket {
    /// Number of images of the bracket.
    pub fn len(&self) -> usize {
        match self {
            Self::Steps(steps) => steps.len(),
            Self::Times(times) => times.len(),
        }
    }

    /// Whether the bracket has no images.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The times, in the order in which they were written, around that of the exposure.
    pub fn times(&self, exposure: Seconds) -> Vec<Seconds> {
        match self {
            Self::Steps(steps) => steps.iter().map(|step| Seconds(exposure.0 * step.exp2())).collect(),
            Self::Times(times) => times.clone(),
        }
    }

    /// Time that stands for all: that in the middle of the sorted ones.
    fn middle(&self) -> Option<Seconds> {
        match self {
            Self::Steps(_) => None,
            Self::Times(times) => {
                let mut times = times.clone();
                times.sort_by(|a, b| a.0.total_cmp(&b.0));
                times.get((times.len() - 1) / 2).copied()
            }
        }
    }
}

/// Exposure time, stated or automatic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExposureTime {
    /// Time that is stated.
    Fixed(Seconds),
    /// Time that automatic exposure finds for the image.
    Auto(AutoExposure),
}

/// Reads `[exposure]`.
pub(crate) fn exposure(table: &ExposureTable, sensor: &SensorModel) -> Result<ExposureSettings, Invalid> {
    let region = region(table, sensor)?;
    let [gain, digital_gain] = gains(table, sensor, region.binning)?;
    let gain_control = gain_control(table, sensor)?;
    let gain = gain_control.map_or(gain, |control| control.first(gain));
    let bracket = bracket(table, sensor)?;
    let time_s = table.time_s.or(bracket.as_ref().and_then(Bracket::middle).map(|time| time.0));
    let time = match (time_s, table.auto) {
        (Some(_), Some(true)) => {
            return Err(Invalid::new("auto", "cannot be combined with time_s").help("keep one of them"));
        }
        (Some(time), None | Some(false)) => ExposureTime::Fixed(Seconds(time)),
        (None, Some(false)) => {
            return Err(Invalid::new("auto", "is off, but no time is given").help("for example time_s = 0.01"));
        }
        (None, None | Some(true)) => ExposureTime::Auto(auto_exposure(table, sensor, gain.0 + digital_gain.0)?),
    };
    let of_automatic = [
        ("auto_target", table.auto_target),
        ("auto_brighter_part", table.auto_brighter_part),
        ("auto_mean", table.auto_mean),
        ("max_time_s", table.max_time_s),
        ("max_gain_db", table.max_gain_db),
        ("compensation_ev", table.compensation_ev),
    ];
    if let (ExposureTime::Fixed(_), Some((key, _))) = (time, of_automatic.iter().find(|(_, value)| value.is_some())) {
        return Err(Invalid::new(*key, "only applies with automatic exposure").help("remove it, or remove time_s"));
    }
    let settings = ExposureSettings {
        time,
        gain,
        digital_gain,
        gain_control,
        temperature: Celsius(table.temperature_c.unwrap_or(25.0)),
        frames: table.frames.unwrap_or(1),
        frame_interval: table.frame_interval_s.map(Seconds),
        region,
        stages: stages(table)?,
        bracket,
    };
    if settings.gain_control.is_some() {
        let clashes = [
            (settings.bracket.is_some(), "a bracket, which one gain makes comparable"),
            (matches!(settings.time, ExposureTime::Auto(_)), "automatic exposure: write time_s"),
        ];
        if let Some((_, clash)) = clashes.iter().find(|(is_there, _)| *is_there) {
            return Err(
                Invalid::new("gain_control", format!("cannot be combined with {clash}")).help("keep one of them")
            );
        }
    }
    if settings.bracket.is_some() && settings.frames != 1 {
        let message = "cannot be combined with a bracket, whose images are a series already";
        return Err(Invalid::new("frames", message).help("remove it, or the bracket"));
    }
    if settings.frames == 0 {
        return Err(Invalid::new("frames", "must be at least 1, got 0").help("for example frames = 1"));
    }
    if settings.frames > MOST_FRAMES {
        let message = format!("must be at most {MOST_FRAMES}, got {}", settings.frames);
        return Err(Invalid::new("frames", message).help("more images are a data set, whose frames have folders"));
    }
    // Any time serves to check the rest of an automatic exposure.
    let exposure = match settings.time {
        ExposureTime::Fixed(time) => settings.at(time),
        ExposureTime::Auto(_) => Exposure { frame_interval: None, ..settings.at(Seconds(1.0)) },
    };
    exposure.validate(sensor)?;
    if let (ExposureTime::Fixed(time), Some(bracket)) = (settings.time, &settings.bracket) {
        bracket.times(time).into_iter().try_for_each(|time| settings.at(time).validate(sensor))?;
    }
    if let (Some(bracket), true) = (&settings.bracket, sensor.logarithmic.is_some()) {
        let key = match bracket {
            Bracket::Steps(_) => "bracket_ev",
            Bracket::Times(_) => "bracket_times_s",
        };
        return Err(
            Invalid::new(key, "is of no use with a logarithmic sensor").help("it captures the whole range at once")
        );
    }
    Ok(settings)
}

/// The bracket that is asked for.
fn bracket(table: &ExposureTable, sensor: &SensorModel) -> Result<Option<Bracket>, Invalid> {
    const MOST: usize = 32;
    let (key, values, example) = match (&table.bracket_ev, &table.bracket_times_s) {
        (None, None) => return Ok(None),
        (Some(_), Some(_)) => {
            return Err(Invalid::new("bracket_times_s", "cannot be combined with bracket_ev").help("keep one of them"));
        }
        (Some(steps), None) => ("bracket_ev", steps, "[-4, 0, 4]"),
        (None, Some(times)) => ("bracket_times_s", times, "[0.001, 0.016]"),
    };
    if sensor.architecture.spad().is_some() {
        let message = format!("sensor {} counts photons, and its counts are not proportional to light", sensor.name);
        return Err(Invalid::new(key, message).help("remove it, or write frames"));
    }
    let wrong = |message: String| Invalid::new(key, message).help(format!("for example {key} = {example}"));
    if !(2..=MOST).contains(&values.len()) {
        return Err(wrong(format!("must be 2 to {MOST} exposures, got {}", values.len())));
    }
    if let Some(value) = values.iter().find(|value| !value.is_finite()) {
        return Err(wrong(format!("must be finite numbers, got {value}")));
    }
    if let Some((_, twice)) = values.iter().enumerate().find(|(i, value)| values[..*i].contains(value)) {
        return Err(wrong(format!("contains {twice} twice")));
    }
    if table.bracket_ev.is_some() {
        if let Some(step) = values.iter().find(|step| step.abs() > LONGEST_STEP_EV) {
            return Err(wrong(format!("must lie from -{LONGEST_STEP_EV} to {LONGEST_STEP_EV}, got {step}")));
        }
        return Ok(Some(Bracket::Steps(values.clone())));
    }
    if let Some(time) = values.iter().find(|time| **time <= 0.0) {
        return Err(wrong(format!("must be above 0, got {time}")));
    }
    let clash = [("time_s", table.time_s.is_some()), ("auto", table.auto == Some(true))];
    if let Some((other, _)) = clash.iter().find(|(_, is_given)| *is_given) {
        return Err(
            Invalid::new(key, format!("cannot be combined with {other}")).help("keep one of them, or write bracket_ev")
        );
    }
    Ok(Some(Bracket::Times(values.iter().copied().map(Seconds).collect())))
}

/// The analogue and the digital gain that are asked for.
fn gains(table: &ExposureTable, sensor: &SensorModel, binning: Binning) -> Result<[Decibels; 2], Invalid> {
    let Some(iso) = table.iso else {
        let [lowest, highest] = sensor.converter.gain_range.map(|gain| gain.0);
        let gain = table.gain_db.unwrap_or(0f64.clamp(lowest, highest));
        return Ok([gain, table.digital_gain_db.unwrap_or(0.0)].map(Decibels));
    };
    let explicit = [("gain_db", table.gain_db), ("digital_gain_db", table.digital_gain_db)];
    if let Some((key, _)) = explicit.iter().find(|(_, value)| value.is_some()) {
        return Err(Invalid::new("iso", format!("cannot be combined with {key}")).help("keep one of them"));
    }
    sensor.gains_for_iso(iso, binning)
}

/// The gain control that is asked for.
fn gain_control(table: &ExposureTable, sensor: &SensorModel) -> Result<Option<GainControl>, Invalid> {
    let Some(wanted) = &table.gain_control else { return Ok(None) };
    let control = GainControl {
        target: wanted.target.unwrap_or(0.18),
        attack: wanted.attack.unwrap_or(0.5),
        limits: wanted.limits_db.map_or(sensor.converter.gain_range, |limits| limits.map(Decibels)),
    };
    control.validate(sensor).map_err(|invalid| invalid.within("gain_control"))?;
    Ok(Some(control))
}

/// Region of the sensor that is read out.
fn region(table: &ExposureTable, sensor: &SensorModel) -> Result<RegionOfInterest, Invalid> {
    let pixels = table.region_px.map(|[x, y, width, height]| PixelArea { x, y, width, height });
    if let (None, Some(_)) = (table.binning, table.binning_method) {
        let message = "says how pixels are binned, but not how many";
        return Err(Invalid::new("binning_method", message).help("add binning = [2, 2]"));
    }
    let own_method = if sensor.architecture.ccd().is_some() { BinningMethod::Charge } else { BinningMethod::Mean };
    let binning = table
        .binning
        .map_or(Binning::NONE, |factor| Binning { factor, method: table.binning_method.unwrap_or(own_method) });
    Ok(RegionOfInterest { binning, pixels })
}

fn stages(table: &ExposureTable) -> Result<Stages, Invalid> {
    match (&table.stages, &table.stages_off) {
        (None, None) => Ok(Stages::ALL),
        (Some(on), None) => Ok(Stages::only(on)),
        (None, Some(off)) => Ok(off.iter().fold(Stages::ALL, |stages, &stage| stages.without(stage))),
        (Some(_), Some(_)) => {
            Err(Invalid::new("stages_off", "cannot be combined with stages").help("keep one of them"))
        }
    }
}

/// Automatic exposure that is asked for. `gain_db` is the gain that automatic gain control starts from.
fn auto_exposure(table: &ExposureTable, sensor: &SensorModel, gain_db: f64) -> Result<AutoExposure, Invalid> {
    let longest = positive_number("max_time_s", table.max_time_s.unwrap_or(LONGEST_AUTO_S), "0.04")?;
    let compensation_ev = table.compensation_ev.unwrap_or(0.0);
    if !(-20.0..=20.0).contains(&compensation_ev) {
        let message = format!("must lie between -20 and 20, got {compensation_ev}");
        return Err(Invalid::new("compensation_ev", message).help("for example compensation_ev = 1.0"));
    }
    if let Some(most) = table.max_gain_db.filter(|most| !(most.is_finite() && *most >= gain_db)) {
        let message = format!("must be at least {gain_db}, where the gain starts, got {most}");
        return Err(Invalid::new("max_gain_db", message).help("for example max_gain_db = 24.0"));
    }
    let is_stated = table.gain_db.is_some() || table.digital_gain_db.is_some() || table.iso.is_some();
    let [_, highest] = sensor.converter.gain_range;
    let default = (!is_stated).then_some(highest);
    Ok(AutoExposure {
        metering: metering(table)?,
        compensation_ev,
        max_time: Some(Seconds(longest)),
        max_gain: table.max_gain_db.map(Decibels).or(default),
    })
}

fn metering(table: &ExposureTable) -> Result<Metering, Invalid> {
    let (default_part, default_level) = match Metering::default() {
        Metering::Highlights { brighter_part, level } => (brighter_part, level),
        Metering::Mean(level) => (0.0, level),
    };
    if let Some(mean) = table.auto_mean {
        let others = [("auto_target", table.auto_target), ("auto_brighter_part", table.auto_brighter_part)];
        if let Some((key, _)) = others.iter().find(|(_, value)| value.is_some()) {
            return Err(Invalid::new("auto_mean", format!("cannot be combined with {key}")).help("keep one of them"));
        }
        if !(mean > 0.0 && mean < 1.0) {
            let message = format!("must lie between 0 and 1, got {mean}");
            return Err(Invalid::new("auto_mean", message).help("for example auto_mean = 0.18"));
        }
        return Ok(Metering::Mean(mean));
    }
    let level = table.auto_target.unwrap_or(default_level);
    let brighter_part = table.auto_brighter_part.unwrap_or(default_part);
    if !(level > 0.0 && level <= 1.0) {
        let message = format!("must lie above 0 and up to 1, got {level}");
        return Err(Invalid::new("auto_target", message).help("for example auto_target = 0.85"));
    }
    if !(0.0..1.0).contains(&brighter_part) {
        let message = format!("must lie from 0 to below 1, got {brighter_part}");
        return Err(Invalid::new("auto_brighter_part", message).help("for example auto_brighter_part = 0.005"));
    }
    Ok(Metering::Highlights { brighter_part, level })
}
