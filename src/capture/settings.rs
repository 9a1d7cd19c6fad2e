//! `[exposure]`, `[render]` and `[output]`: from tables to settings.

use std::time::Duration;

use glam::DAffine3;

use super::tables::{
    ExposureTable, IrradianceSource, NextSource, NoiseSource, OutputTable, PartnerSource, PartnerTable, RawFormat,
    RenderTable, SamplerName, TruthSource, WavelengthsName,
};
use crate::Invalid;
use crate::calibration::truth::TruthLayer;
use crate::develop::RawLayout;
use crate::integrator::{RenderSettings, WavelengthChoice};
use crate::io::noise_maps::NoiseFormat;
use crate::io::truth::TruthFormat;
use crate::raw::{Cfa, DngCompression, PixelArea, dng_can_hold};
use crate::sampler::SamplerKind;
use crate::scene::description::looking;
use crate::sensor::{
    AutoExposure, Binning, BinningMethod, Exposure, GainControl, Metering, NoiseMap, RegionOfInterest, SensorModel,
    Stages,
};
use crate::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM};
use crate::units::{Celsius, Decibels, Seconds};

/// Most frames of one capture, each of which has a file of its own in one folder.
const MOST_FRAMES: u32 = 1_000_000;

/// Longest time of an automatic exposure that is not told another, s: a camera on a stand, of which nobody waits longer
/// for a picture; the gain rises instead.
pub(super) const LONGEST_AUTO_S: f64 = 4.0;

/// How the sensor is exposed.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposureSettings {
    /// How long.
    pub time: ExposureTime,
    /// Analogue gain; automatic gain control starts from here.
    pub gain: Decibels,
    /// Gain of the numbers behind the converter, likewise.
    pub digital_gain: Decibels,
    /// Lets the analogue gain follow the light from picture to picture.
    pub gain_control: Option<GainControl>,
    /// Temperature of the sensor.
    pub temperature: Celsius,
    /// Other times for which the same light is exposed, in place of frames.
    pub bracket: Option<Bracket>,
    /// How many pictures of the same light, at least 1.
    pub frames: u32,
    /// Time from the start of one picture to that of the next, where it is longer than the exposure.
    pub frame_interval: Option<Seconds>,
    /// What of the sensor is read out.
    pub region: RegionOfInterest,
    /// The stages of the sensor that take part.
    pub stages: Stages,
}

impl ExposureSettings {
    /// Whether pictures of the same light are exposed in the same way, however many there are.
    pub fn is_like(&self, other: &Self) -> bool {
        Self { frames: 1, ..self.clone() } == Self { frames: 1, ..other.clone() }
    }

    /// What is to be said of settings that change nothing.
    pub fn warning(&self) -> Option<String> {
        let is_idle = self.gain_control.is_some() && self.frames == 1;
        is_idle.then(|| "exposure.gain_control: acts from one picture to the next, but exposure.frames is 1".to_owned())
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
    /// These times.
    Times(Vec<Seconds>),
}

impl Bracket {
    /// Number of pictures.
    pub fn len(&self) -> usize {
        match self {
            Self::Steps(steps) => steps.len(),
            Self::Times(times) => times.len(),
        }
    }

    /// Whether there are none.
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

    /// The time that stands for all: that in the middle of the sorted ones.
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

/// How long an exposure takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExposureTime {
    /// As long as this.
    Fixed(Seconds),
    /// As long as the picture needs.
    Auto(AutoExposure),
}

/// What is written.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputSettings {
    /// Formats of the raw picture.
    pub raw: Vec<RawFormat>,
    /// How DNG files are compressed.
    pub dng_compression: DngCompression,
    /// By how much developers brighten DNG files unasked, EV.
    pub dng_baseline_exposure_ev: f64,
    /// The colour filter array that raw files state.
    pub raw_layout: RawLayout,
    /// Whether the developed picture is written.
    pub image: bool,
    /// Whether the mean electrons are written.
    pub electrons: bool,
    /// The bands in which the spectral irradiance is written, if it is.
    pub irradiance: Option<SpectralBands>,
    /// Whether the picture of an ideal observer is written.
    pub ideal: bool,
    /// What is reported of the surfaces that pixels see.
    pub truth: TruthOutput,
    /// Whether what is known of each object is written.
    pub objects: bool,
    /// What is reported of the sensor's noise.
    pub noise: NoiseOutput,
    /// Time between pictures of a render that is under way; `None` for no such pictures.
    pub preview_interval: Option<Duration>,
    /// Time between checkpoints of a render that is under way; `None` for none.
    pub checkpoint_interval: Option<Duration>,
}

/// Which ground truth is written, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthOutput {
    /// The layers, none twice.
    pub layers: Vec<TruthLayer>,
    /// The formats of each.
    pub formats: Vec<TruthFormat>,
    /// What one step of depth stands for in files of whole numbers, m.
    pub depth_unit_m: f64,
    /// Partner → camera of a stereo pair, m.
    pub partner: Option<DAffine3>,
    /// Which picture flow leads to.
    pub next: NextPicture,
}

/// The picture that flow leads to.
#[derive(Clone, Debug, PartialEq)]
pub enum NextPicture {
    /// The next picture of the same series, in which what moves has moved on.
    OfSeries,
    /// The picture of the capture with these overrides.
    Changed(Vec<String>),
    /// There is none.
    None,
}

/// Which noise maps are written, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseOutput {
    /// The maps, none twice.
    pub maps: Vec<NoiseMap>,
    /// The formats of each.
    pub formats: Vec<NoiseFormat>,
}

/// Spectral bands of equal width next to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralBands {
    /// Lower edge of the first, nm.
    pub first_nm: f64,
    /// Width of each, nm.
    pub width_nm: f64,
    /// How many.
    pub count: usize,
}

impl Default for SpectralBands {
    /// 30 bands of 10 nm from 400 to 700 nm.
    fn default() -> Self {
        Self { first_nm: 400.0, width_nm: 10.0, count: 30 }
    }
}

impl SpectralBands {
    /// Lower and upper edge of a band, nm.
    pub fn edges_nm(&self, band: usize) -> [f64; 2] {
        [band, band + 1].map(|edge| self.first_nm + edge as f64 * self.width_nm)
    }

    /// Centre of a band, nm.
    pub fn centre_nm(&self, band: usize) -> f64 {
        self.first_nm + (band as f64 + 0.5) * self.width_nm
    }
}

/// Reads `[exposure]`.
pub(super) fn exposure(table: &ExposureTable, sensor: &SensorModel) -> Result<ExposureSettings, Invalid> {
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
        let message = "cannot be combined with a bracket, whose pictures are a series already";
        return Err(Invalid::new("frames", message).help("remove it, or the bracket"));
    }
    if settings.frames == 0 {
        return Err(Invalid::new("frames", "must be at least 1, got 0").help("for example frames = 1"));
    }
    if settings.frames > MOST_FRAMES {
        let message = format!("must be at most {MOST_FRAMES}, got {}", settings.frames);
        return Err(Invalid::new("frames", message).help("more pictures are a data set, whose frames have folders"));
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

/// What of the sensor is read out.
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

/// `gain_db` is what automatic gain control starts from.
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

pub(super) fn positive_number(key: &str, value: f64, example: &str) -> Result<f64, Invalid> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(Invalid::new(key, format!("must be above 0, got {value}")).help(format!("for example {key} = {example}")))
}

/// Reads `[render]`.
pub(super) fn render(table: &RenderTable) -> Result<RenderSettings, Invalid> {
    let default = RenderSettings::default();
    let settings = RenderSettings {
        part: None,
        samples_per_pixel: table.samples_per_pixel.unwrap_or(default.samples_per_pixel),
        time_limit: table.time_limit_s.map(|s| duration("time_limit_s", s)).transpose()?,
        noise_target: table.noise_target,
        max_depth: table.max_depth.unwrap_or(default.max_depth),
        roulette_depth: table.roulette_depth.unwrap_or(default.roulette_depth),
        splitting: table.splitting.unwrap_or(default.splitting),
        reuse: table.reuse.unwrap_or(default.reuse),
        light_paths: table.light_paths.unwrap_or(default.light_paths),
        wavelengths: match table.wavelengths {
            None => default.wavelengths,
            Some(WavelengthsName::AllFilters) => WavelengthChoice::AllFilters,
            Some(WavelengthsName::OwnFilter) => WavelengthChoice::OwnFilter,
        },
        sampler: match table.sampler {
            None => default.sampler,
            Some(SamplerName::Sobol) => SamplerKind::Sobol,
            Some(SamplerName::Independent) => SamplerKind::Independent,
        },
        seed: table.seed.unwrap_or(default.seed),
    };
    settings.validate()?;
    Ok(settings)
}

/// Reads `[output]`.
pub(super) fn output(table: &OutputTable, sensor: &SensorModel) -> Result<OutputSettings, Invalid> {
    let raw_layout = table.raw_layout.unwrap_or_default();
    raw_layout.check(&sensor.cfa)?;
    let full = Cfa::full(["R", "G", "B"])?;
    let cfa = if raw_layout == RawLayout::Linear { &full } else { &sensor.cfa };
    let baseline = table.dng_baseline_exposure_ev.unwrap_or(0.0);
    if !(-10.0..=10.0).contains(&baseline) {
        let message = format!("must be from -10 to 10, got {baseline}");
        return Err(
            Invalid::new("dng_baseline_exposure_ev", message).help("for example dng_baseline_exposure_ev = 0.5")
        );
    }
    let raw = without_repetition(table.raw.as_deref().unwrap_or(&[RawFormat::Dng]));
    for format in &raw {
        can_hold(*format, cfa).map_err(|invalid| Invalid { key: "raw".to_owned(), ..invalid })?;
    }
    let interval = |key: &str, value: Option<f64>, usual: f64| match value.unwrap_or(usual) {
        0.0 => Ok(None),
        seconds => duration(key, seconds).map(Some),
    };
    Ok(OutputSettings {
        raw,
        dng_compression: table.dng_compression.unwrap_or_default(),
        dng_baseline_exposure_ev: baseline,
        raw_layout,
        image: table.image.unwrap_or(true),
        electrons: table.electrons.unwrap_or(true),
        ideal: table.ideal.unwrap_or(false),
        truth: truth(table)?,
        objects: table.objects.unwrap_or(false),
        noise: noise(table)?,
        irradiance: match table.irradiance {
            None | Some(IrradianceSource::Flag(false)) => None,
            Some(IrradianceSource::Flag(true)) => Some(SpectralBands::default()),
            Some(IrradianceSource::Bands(bands)) => {
                Some(spectral_bands(bands.bands_nm).map_err(|e| e.within("bands_nm").within("irradiance"))?)
            }
        },
        preview_interval: interval("preview_interval_s", table.preview_interval_s, 10.0)?,
        checkpoint_interval: interval("checkpoint_interval_s", table.checkpoint_interval_s, 60.0)?,
    })
}

fn truth(table: &OutputTable) -> Result<TruthOutput, Invalid> {
    let mut layers = match &table.truth {
        None | Some(TruthSource::Flag(false)) => Vec::new(),
        Some(TruthSource::Flag(true)) => {
            // Without a partner there is no disparity.
            let is_there = |layer: &TruthLayer| *layer != TruthLayer::Disparity || table.truth_partner.is_some();
            TruthLayer::ALL.into_iter().filter(is_there).collect()
        }
        Some(TruthSource::Layers(layers)) => without_repetition(layers),
    };
    let is_asked = !layers.is_empty();
    let place = match table.truth_partner {
        None => None,
        Some(PartnerSource::Place(place)) => Some(place),
        Some(PartnerSource::Flag(false)) => {
            layers.retain(|layer| *layer != TruthLayer::Disparity);
            None
        }
        Some(PartnerSource::Flag(true)) => {
            let invalid = Invalid::new("truth_partner", "does not say where the other camera is");
            return Err(invalid.help("for example truth_partner = { position_m = [0.1, 0, 0] }"));
        }
    };
    let next = match &table.truth_next {
        None => NextPicture::OfSeries,
        Some(NextSource::Flag(false)) => NextPicture::None,
        Some(NextSource::Changes(changes)) => NextPicture::Changed(changes.clone()),
        Some(NextSource::Flag(true)) => {
            let invalid = Invalid::new("truth_next", "does not say what the next picture is");
            return Err(invalid.help("for example truth_next = [\"camera.position_m=[0.1, 0, 1]\"]"));
        }
    };
    let others = [
        ("truth_formats", table.truth_formats.is_some()),
        ("truth_depth_unit_mm", table.truth_depth_unit_mm.is_some()),
    ];
    if let (false, Some((key, _))) = (is_asked, others.iter().find(|(_, is_given)| *is_given)) {
        return Err(
            Invalid::new(*key, "has no meaning without layers").help("write truth = [\"depth\"] or the like, too")
        );
    }
    if layers.contains(&TruthLayer::Disparity) && place.is_none() {
        let message = "\"disparity\" is that of a pair of cameras, and the other one is missing";
        return Err(Invalid::new("truth", message)
            .help("add truth_partner = { position_m = [0.1, 0, 0] }; to a camera of a data set, disparity_to"));
    }
    let partner = place.map(|table| partner(&table).map_err(|e| e.within("truth_partner")));
    let formats = without_repetition(table.truth_formats.as_deref().unwrap_or(&[TruthFormat::Exr]));
    for format in &formats {
        // All layers are those that the format holds.
        if let Some(TruthSource::Layers(layers)) = &table.truth {
            layers.iter().try_for_each(|layer| format.check(*layer))?;
        }
    }
    let unit_mm = table.truth_depth_unit_mm.map(|mm| positive_number("truth_depth_unit_mm", mm, "0.1"));
    let depth_unit_m = unit_mm.transpose()?.unwrap_or(1.0) * 1e-3;
    Ok(TruthOutput { layers, formats, depth_unit_m, partner: partner.transpose()?, next })
}

fn noise(table: &OutputTable) -> Result<NoiseOutput, Invalid> {
    let maps = match &table.noise {
        None | Some(NoiseSource::Flag(false)) => Vec::new(),
        Some(NoiseSource::Flag(true)) => NoiseMap::ALL.to_vec(),
        Some(NoiseSource::Maps(maps)) => without_repetition(maps),
    };
    if maps.is_empty() && table.noise_formats.is_some() {
        return Err(Invalid::new("noise_formats", "has no meaning without maps").help("write noise = true, too"));
    }
    let formats = without_repetition(table.noise_formats.as_deref().unwrap_or(&[NoiseFormat::Exr]));
    Ok(NoiseOutput { maps, formats })
}

/// Partner → camera.
fn partner(table: &PartnerTable) -> Result<DAffine3, Invalid> {
    let [x, y, z] = table.position_m;
    looking(table.position_m, table.look_at_m.unwrap_or([x, y, z - 1.0]), table.up)
}

fn without_repetition<T: Copy + PartialEq>(values: &[T]) -> Vec<T> {
    let first = |(i, value): (usize, &T)| (!values[..i].contains(value)).then_some(*value);
    values.iter().enumerate().filter_map(first).collect()
}

/// Whether a format has room for such pixels.
fn can_hold(format: RawFormat, cfa: &Cfa) -> Result<(), Invalid> {
    match format {
        RawFormat::Dng => dng_can_hold(cfa),
        RawFormat::Pgm if ![1, 3].contains(&cfa.samples_per_pixel()) => {
            let message = format!("PGM and PPM have no pixels of {} numbers", cfa.samples_per_pixel());
            Err(Invalid::new("raw", message).help("write raw = [\"tiff\"] or [\"npy\"], which hold any channels"))
        }
        RawFormat::Pgm | RawFormat::Tiff | RawFormat::Npy | RawFormat::Exr => Ok(()),
    }
}

fn spectral_bands([first, last, width]: [f64; 3]) -> Result<SpectralBands, Invalid> {
    let range = f64::from(LAMBDA_MIN_NM)..=f64::from(LAMBDA_MAX_NM);
    if !(range.contains(&first) && range.contains(&last) && first < last) {
        let message = format!("{first} to {last} nm does not rise within 300 to 1100 nm");
        return Err(Invalid::new("", message).help("for example bands_nm = [400, 700, 10]"));
    }
    let count = ((last - first) / width).round();
    // Edges are written with few digits; a thousandth of a band is nothing.
    if !(width > 0.0 && (1.0..=801.0).contains(&count) && ((last - first) / width - count).abs() < 1e-3) {
        let message = format!("bands of {width} nm do not fill {first} to {last} nm");
        return Err(Invalid::new("", message).help("write first edge, last edge and width: [400, 700, 10]"));
    }
    Ok(SpectralBands { first_nm: first, width_nm: width, count: count as usize })
}

fn duration(key: &str, seconds: f64) -> Result<Duration, Invalid> {
    match Duration::try_from_secs_f64(seconds) {
        Ok(duration) if !duration.is_zero() => Ok(duration),
        Ok(_) | Err(_) => {
            Err(Invalid::new(key, format!("must be above 0, got {seconds}")).help(format!("for example {key} = 30")))
        }
    }
}
