//! Exposure: the list of physical stages from mean photo-electrons to digital numbers.

use photosite_core::Invalid;
use photosite_core::image::{Channel, Planes};
use photosite_raw::{Cfa, PixelArea, RawImage, RawMetadata};

use super::noise_maps::NoiseMaps;
use super::recorded::{Charge, DigitalNumbers, RecordedRow};
use crate::signal::charge_generation;
use crate::signal::charge_plane::ChargePlane;
use crate::signal::effects::{NoiseMap, Stage, Stages};
use crate::stages::amplifiers::{AmplifierNonlinearity, ColumnAmplifiers, Gain};
use crate::stages::companding::Compander;
use crate::stages::converter::Digitiser;
use crate::stages::crosstalk::spread;
use crate::stages::dark_current::{DarkCurrent, HotPixels};
use crate::stages::dark_offset::DarkOffset;
use crate::stages::dead_pixels::DeadPixels;
use crate::stages::defective_numbers::{StuckPixels, TransmissionErrors};
use crate::stages::digital_gain::DigitalGain;
use crate::stages::dual_gain::DualGainDigitiser;
use crate::stages::flicker::add_flicker;
use crate::stages::frame::Frame;
use crate::stages::frame_grabber::Sampling;
use crate::stages::full_well::FullWell;
use crate::stages::image_circle::cover;
use crate::stages::image_lag::{LeftCharge, keep_back};
use crate::stages::line_noise::{ColumnNoise, RowNoise};
use crate::stages::logarithmic::LogarithmicResponse;
use crate::stages::photo_response::PhotoResponse;
use crate::stages::photon_counting::PhotonCounter;
use crate::stages::read_noise::ReadNoise;
use crate::stages::reset_noise::ResetNoise;
use crate::stages::shot_noise::ShotNoise;
use crate::stages::telegraph::Telegraph;
use crate::stages::video::VideoBandwidth;
use crate::stages::{brighter_fatter, ccd};
use crate::{Binning, Exposure, NoiseKey, RegionOfInterest, SensorModel, VideoCurve};

/// A function that lets stages change a row one after the other. A stage is a name of the list.
macro_rules! row_stages {
    ($frame:ident;) => { |_: &mut RecordedRow<'_>| {} };
    ($frame:ident; $stage:ident, $($more:tt)*) => {{
        let stage = $stage::new($frame);
        let those_after = row_stages!($frame; $($more)*);
        move |row: &mut RecordedRow<'_>| {
            row.apply(&stage);
            those_after(row);
        }
    }};
}

/// Exposes the sensor to light that frees `mean_electrons` on average during the exposure: e⁻, noise-free, finite and
/// not negative, a plane for each of the sensor's channels, of which every pixel uses the one that it sees. The image
/// may be smaller than the sensor; the colour filter array starts at its top-left pixel.
pub fn expose(
    mean_electrons: &Planes,
    sensor: &SensorModel,
    exposure: &Exposure,
    stages: Stages,
    key: NoiseKey,
) -> Result<RawImage, Invalid> {
    expose_with_maps(mean_electrons, sensor, exposure, stages, key, &[]).map(|(raw, _)| raw)
}

/// Exposes the sensor as [`expose`] does, and records what each of some effects has added to every number.
pub fn expose_with_maps(
    mean_electrons: &Planes,
    sensor: &SensorModel,
    exposure: &Exposure,
    stages: Stages,
    key: NoiseKey,
    maps: &[NoiseMap],
) -> Result<(RawImage, NoiseMaps), Invalid> {
    let exposed = expose_after(mean_electrons, sensor, exposure, stages, key, maps, None)?;
    Ok((exposed.raw, exposed.maps))
}

/// A frame that was exposed.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposedFrame {
    /// Raw image with the digital numbers of the exposure.
    pub raw: RawImage,
    /// Noise maps: contributions of single effects to the digital numbers.
    pub maps: NoiseMaps,
    /// Charge that it leaves to the frame after it; `None` of a sensor without [image lag](crate::ImageLag).
    pub left: Option<LeftCharge>,
}

/// Exposes the sensor as [`expose_with_maps`] does after another frame, which has left charge in the pixels;
/// `None` for a sensor that was long in the dark.
pub fn expose_after(
    mean_electrons: &Planes,
    sensor: &SensorModel,
    exposure: &Exposure,
    stages: Stages,
    key: NoiseKey,
    maps: &[NoiseMap],
    before: Option<&LeftCharge>,
) -> Result<ExposedFrame, Invalid> {
    let drawn: Vec<NoiseMap> = maps.iter().copied().filter(|map| *map != NoiseMap::RawClean).collect();
    let size = [mean_electrons.width(), mean_electrons.height()];
    let frame = Frame { sensor, exposure, stages, key, size, is_mean: false };
    let mut exposed = expose_once(mean_electrons, &frame, &drawn, before)?;
    if let Some(place) = maps.iter().position(|map| *map == NoiseMap::RawClean) {
        let clean = clean(mean_electrons, &frame, before)?;
        let mut channels = exposed.maps.planes.into_channels();
        let place = place * clean.len();
        channels.splice(place..place, clean);
        exposed.maps.planes = Planes::new(exposed.raw.width, exposed.raw.height, channels)?;
    }
    Ok(exposed)
}

/// Channels of [`NoiseMap::RawClean`]: digital numbers of an exposure whose stages take their means, without rounding
/// and within the range of the converter.
fn clean(mean_electrons: &Planes, frame: &Frame<'_>, before: Option<&LeftCharge>) -> Result<Vec<Channel>, Invalid> {
    let rounded = [NoiseMap::QuantisationDn, NoiseMap::RoundingDn];
    let of_means = Frame { is_mean: true, ..*frame };
    let ExposedFrame { raw, maps, .. } = expose_once(mean_electrons, &of_means, &rounded, before)?;
    let (converter, samples) = (&frame.sensor.converter, raw.cfa.samples_per_pixel());
    let [quantisation, rounding] = [0, 1].map(|map| &maps.planes.channels()[map * samples..][..samples]);
    let level = |number: u16, rounded: [f32; 2]| {
        let level = f64::from(number) - rounded.map(f64::from).iter().sum::<f64>();
        let level = level.clamp(0.0, converter.max_dn().into());
        converter.companding.as_ref().map_or(level, |companding| companding.level(level, converter.max_dn())) as f32
    };
    let channel = |sample: usize| {
        let numbers = raw.data.iter().skip(sample).step_by(samples);
        let rounded = quantisation[sample].data.iter().zip(&rounding[sample].data);
        let name = quantisation[sample].name.replacen(NoiseMap::QuantisationDn.name(), NoiseMap::RawClean.name(), 1);
        let data = numbers.zip(rounded).map(|(&number, (&q, &r))| level(number, [q, r])).collect();
        Channel { name, data }
    };
    Ok((0..samples).map(channel).collect())
}

/// Exposes the sensor once; a frame of means is without random numbers and, as its curve would hide what rounding has
/// changed, without companding.
fn expose_once(
    mean_electrons: &Planes,
    frame: &Frame<'_>,
    maps: &[NoiseMap],
    before: Option<&LeftCharge>,
) -> Result<ExposedFrame, Invalid> {
    let Frame { sensor, exposure, stages, .. } = *frame;
    check(sensor, exposure, [mean_electrons.width(), mean_electrons.height()])?;
    let mut charge = Charge::new(collect(mean_electrons, sensor)?, maps);
    charge.change(NoiseMap::CrosstalkE, |charge| spread(charge, sensor, stages));
    let masked = [sensor.masked.columns[0] * charge.samples, sensor.masked.rows[0]];
    let mut charge = charge.embed(masked, NoiseMap::PhotoElectronsE, |charge| sensor.masked.surround(charge));

    let frame = Frame { size: [charge.width, charge.height], ..*frame };
    let passing = free_electrons(&frame, &mut charge);
    let before = before.filter(|_| stages.has(Stage::ImageLag));
    if let Some(before) = before {
        charge.change(NoiseMap::ImageLagE, |charge| before.join(charge))?;
    }
    hold(&frame, &mut charge);
    let left = charge.change(NoiseMap::ImageLagE, |charge| keep_back(&frame, charge, before));
    let charge = transfer(&frame, charge, &passing);
    let frame = Frame { size: [charge.width, charge.height], ..frame };
    let image = [mean_electrons.width(), mean_electrons.height()];
    let numbers = read_out(&frame, charge, image);
    let DigitalNumbers { data, size, record } = process(&Frame { size: numbers.size, ..frame }, numbers);
    let frame = Frame { size, ..frame };

    let (whole, part) = raw_image(&frame, data, size, image);
    let layout = exposure.region.binning.layout(&sensor.cfa);
    let names = if layout.is_full() { layout.channels() } else { &[String::new()] };
    let all = PixelArea { x: 0, y: 0, width: whole.width, height: whole.height };
    let maps = NoiseMaps {
        planes: record.finish(part.unwrap_or(all), names)?,
        system_gain: sensor.system_gain(exposure),
        black_level_dn: frame.black_level_dn().into(),
    };
    let raw = match part {
        None => whole,
        Some(part) => whole.part(part),
    };
    Ok(ExposedFrame { raw, maps, left })
}

/// Refuses an exposure of so many columns and rows that the sensor cannot make.
pub(super) fn check(sensor: &SensorModel, exposure: &Exposure, image: [usize; 2]) -> Result<(), Invalid> {
    exposure.validate(sensor)?;
    exposure.region.fits(sensor, image)?;
    sensor.patterns_fit(image)
}

/// Mean electrons of the channel that each pixel sees, none beyond the image circle.
pub(super) fn collect(mean_electrons: &Planes, sensor: &SensorModel) -> Result<ChargePlane, Invalid> {
    let mut charge = charge_generation::collect(mean_electrons, &sensor.cfa)?;
    cover(&mut charge, sensor);
    Ok(charge)
}

/// Frees electrons in each pixel by light and heat. Returns what a well of a CCD collects while it passes through each
/// column.
fn free_electrons(frame: &Frame<'_>, charge: &mut Charge) -> Vec<f32> {
    let ccd = frame.sensor.architecture.ccd();
    let smear = |charge: &mut ChargePlane| ccd.map(|ccd| ccd::smear(ccd, frame, charge)).unwrap_or_default();
    let passing = charge.change(NoiseMap::SmearE, smear);
    let respond = row_stages!(frame; PhotoResponse, DeadPixels,);
    let photon_counter = PhotonCounter::new(frame);
    let free = row_stages!(frame; ShotNoise, DarkCurrent, HotPixels,);
    charge.for_each_row(|row| {
        respond(row);
        match &photon_counter {
            Some(photon_counter) => row.apply(photon_counter),
            None => free(row),
        }
    });
    charge.record.gains(|| PhotoResponse::new(frame));
    if photon_counter.is_none() {
        charge.record.split_dark_current(|| DarkCurrent::new(frame));
    }
    passing
}

/// Collects the electrons in the wells of the pixels.
fn hold(frame: &Frame<'_>, charge: &mut Charge) {
    charge.change(NoiseMap::BrighterFatterE, |charge| brighter_fatter::apply(frame, charge));
    if let Some(ccd) = frame.sensor.architecture.ccd() {
        charge.change(NoiseMap::BloomingE, |charge| ccd::bloom(ccd, frame, charge));
    }
    let full_well = FullWell::new(frame);
    let logarithmic_response = LogarithmicResponse::new(frame);
    charge.for_each_row(|row| {
        row.apply(&full_well);
        row.mark(|charge| full_well.is_some_and(|full_well| full_well.is_full(charge)));
        row.apply(&logarithmic_response);
    });
}

/// Moves the charge of a CCD to its output, and adds the charge of binned pixels.
fn transfer(frame: &Frame<'_>, mut charge: Charge, passing: &[f32]) -> Charge {
    let (sensor, binning) = (frame.sensor, frame.exposure.region.binning);
    if let Some(ccd) = sensor.architecture.ccd() {
        let prescan = [ccd.overscan.prescan_columns * charge.samples, 0];
        let shift_out = |charge| ccd::shift_out(ccd, frame, charge, passing);
        charge = charge.embed(prescan, NoiseMap::ChargeTransferE, shift_out);
    }
    charge.add(&binning, &sensor.cfa)
}

/// Amplifiers turn charge into voltages, converters those into digital numbers.
fn read_out(frame: &Frame<'_>, mut charge: Charge, image: [usize; 2]) -> DigitalNumbers {
    charge.change(NoiseMap::FlickerNoiseE, |charge| add_flicker(charge, frame));
    let Some(sampling) = Sampling::new(frame.sensor, active_area(frame.sensor, image, Binning::NONE)) else {
        let (amplify, convert) = (amplify(frame), convert(frame));
        return charge.read_out(|row, numbers| {
            amplify(row);
            convert(row, numbers);
        });
    };
    charge.for_each_row(amplify(frame));
    let sampled = charge.sample(&sampling);
    let convert = convert(&Frame { size: [sampled.width, sampled.height], ..*frame });
    sampled.read_out(convert)
}

/// Amplifies a row of charge to the signal at the converter, DN above its black level; where a sensor has two gains,
/// the row stays charge, e⁻, at the input of both amplifiers.
fn amplify(frame: &Frame<'_>) -> impl Fn(&mut RecordedRow<'_>) + Sync {
    let amplify = row_stages!(frame; ResetNoise, Telegraph, DarkOffset, RowNoise, ColumnNoise, AmplifierNonlinearity,);
    let has_two_gains = frame.sensor.converter.dual_gain.is_some();
    let read_noise = ReadNoise::new(frame);
    let gain = Gain::new(frame);
    let transmit = row_stages!(frame; ColumnAmplifiers, VideoCurve, VideoBandwidth,);
    move |row| {
        amplify(row);
        if !has_two_gains {
            row.apply(&read_noise);
            row.amplify(&gain);
            transmit(row);
        }
    }
}

/// Converts a row of signals to digital numbers.
fn convert<'a>(frame: &Frame<'a>) -> impl Fn(&mut RecordedRow<'_>, &mut RecordedRow<'_, u16>) + Sync + 'a {
    let frame = *frame;
    let gain = Gain::new(&frame);
    let digitiser = Digitiser::new(&frame);
    let dual_gain = DualGainDigitiser::new(&frame);
    let stuck_pixels = StuckPixels::new(&frame);
    move |row, numbers| {
        numbers.convert(&frame, |numbers| match &dual_gain {
            Some(dual_gain) => {
                row.change(NoiseMap::ReadNoiseE, |row| dual_gain.convert(row, numbers));
                row.amplify(&gain);
            }
            None => digitiser.convert(row, numbers),
        });
        numbers.apply(&stuck_pixels);
    }
}

/// Processes the digital numbers and sends them out.
fn process(frame: &Frame<'_>, numbers: DigitalNumbers) -> DigitalNumbers {
    let mut numbers = numbers.add(frame);
    let frame = &Frame { size: numbers.size, ..*frame };
    let digital_gain = DigitalGain::new(frame);
    let compander = Compander::new(frame).filter(|_| !frame.is_mean);
    let transmission_errors = TransmissionErrors::new(frame);
    numbers.for_each_row(|numbers| {
        numbers.multiply(digital_gain.as_ref());
        numbers.apply(&compander);
        numbers.apply(&transmission_errors);
    });
    numbers
}

/// Builds the raw image of these columns and rows with its metadata, from all that is read out, and cuts out the part
/// that is asked for.
pub(super) fn raw_image(
    frame: &Frame<'_>,
    data: Vec<u16>,
    [row_length, height]: [usize; 2],
    image: [usize; 2],
) -> (RawImage, Option<PixelArea>) {
    let Frame { sensor, exposure, .. } = *frame;
    let RegionOfInterest { binning, pixels } = exposure.region;
    let layout = binning.layout(&sensor.cfa);
    let width = row_length / layout.samples_per_pixel();
    let pixels_read = active_area(sensor, image, binning);
    // What is sampled is the image alone.
    let (area, per_number) = match Sampling::new(sensor, pixels_read) {
        Some(sampling) => (PixelArea { x: 0, y: 0, width, height }, sampling.pixels_per_sample()),
        None => (pixels_read, binning.factor.map(|n| n as f64)),
    };
    let channels = layout.channels().len();
    let linearisation = sensor.linearisation(exposure);
    let whole = RawImage {
        width,
        height,
        data,
        cfa: tile_from_corner(&layout, area),
        active_area: ([width, height] != [area.width, area.height]).then_some(area),
        bits: sensor.output_bits(),
        black_level_dn: linearisation.as_ref().map_or(frame.black_level_dn(), |linear| linear.black_level_dn).into(),
        white_level_dn: sensor.white_level_dn(exposure),
        channel_whites_dn: None,
        linearisation: linearisation.map(|linearisation| linearisation.table),
        metadata: RawMetadata {
            camera_model: sensor.name.clone(),
            camera_serial: sensor.serial.to_string(),
            exposure_time_s: exposure.time.0,
            iso: sensor.iso(exposure).map(|iso| iso.round() as u32),
            pixel_pitch_m: Some([0, 1].map(|axis| sensor.pixel_pitch_m[axis] * per_number[axis])),
            is_staggered: sensor.cells.is_staggered(),
            noise_profile: sensor.noise_profile(exposure).map(|profile| vec![profile; channels]).unwrap_or_default(),
            ..RawMetadata::default()
        },
    };
    let part = pixels.map(|region| PixelArea {
        x: area.x + region.x / binning.factor[0],
        y: area.y + region.y / binning.factor[1],
        width: region.width / binning.factor[0],
        height: region.height / binning.factor[1],
    });
    (whole, part)
}

/// Area of the image among all that is read out, in bins.
fn active_area(sensor: &SensorModel, image: [usize; 2], binning: Binning) -> PixelArea {
    let prescan = sensor.architecture.ccd().map_or(0, |ccd| ccd.overscan.prescan_columns);
    let [across, down] = binning.factor;
    let [width, height] = binning.whole_bins(image, &sensor.cfa);
    PixelArea { x: (prescan + sensor.masked.columns[0]) / across, y: sensor.masked.rows[0] / down, width, height }
}

/// The tile as it lies at the corner of all that is read out, so that it begins at that of the image.
fn tile_from_corner(cfa: &Cfa, image: PixelArea) -> Cfa {
    let (width, height) = cfa.tile_size();
    let width = width / cfa.samples_per_pixel();
    cfa.from(width - image.x % width, height - image.y % height)
}
