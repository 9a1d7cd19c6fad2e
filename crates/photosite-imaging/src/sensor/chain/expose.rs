//! One exposure, from mean photo-electrons to digital numbers, as the list of its physical stages.

use crate::raw::{Cfa, PixelArea, RawImage, RawMetadata};
use photosite_core::Invalid;
use photosite_core::image::{Channel, Planes};

use super::noise_maps::{NoiseMaps, Recorder};
use crate::sensor::signal::charge_generation;
use crate::sensor::signal::charge_plane::{ChargePlane, Row, for_each_row};
use crate::sensor::signal::effects::{NoiseMap, Stage, Stages};
use crate::sensor::stages::amplifiers::{AmplifierNonlinearity, ColumnAmplifiers, Gain};
use crate::sensor::stages::companding::Compander;
use crate::sensor::stages::converter::Digitiser;
use crate::sensor::stages::crosstalk::spread;
use crate::sensor::stages::dark_current::{DarkCurrent, HotPixels};
use crate::sensor::stages::dark_offset::DarkOffset;
use crate::sensor::stages::dead_pixels::DeadPixels;
use crate::sensor::stages::defective_numbers::{StuckPixels, TransmissionErrors};
use crate::sensor::stages::digital_gain::DigitalGain;
use crate::sensor::stages::dual_gain::DualGainDigitiser;
use crate::sensor::stages::flicker::add_flicker;
use crate::sensor::stages::frame::Frame;
use crate::sensor::stages::full_well::FullWell;
use crate::sensor::stages::image_circle::cover;
use crate::sensor::stages::image_lag::{LeftCharge, keep_back};
use crate::sensor::stages::line_noise::{ColumnNoise, RowNoise};
use crate::sensor::stages::logarithmic::LogarithmicResponse;
use crate::sensor::stages::photo_response::PhotoResponse;
use crate::sensor::stages::photon_counting::PhotonCounter;
use crate::sensor::stages::read_noise::ReadNoise;
use crate::sensor::stages::reset_noise::ResetNoise;
use crate::sensor::stages::shot_noise::ShotNoise;
use crate::sensor::stages::telegraph::Telegraph;
use crate::sensor::stages::video::VideoBandwidth;
use crate::sensor::stages::{brighter_fatter, ccd};
use crate::sensor::{Binning, Exposure, NoiseKey, RegionOfInterest, SensorModel, VideoCurve};

/// A function that lets stages change a row one after the other, each with its noise map. A stage is a line of the
/// list.
macro_rules! row_stages {
    ($frame:ident, $record:ident;) => { |_: &mut Row<'_>| {} };
    ($frame:ident, $record:ident; $stage:ident => $map:ident, $($more:tt)*) => {{
        let stage = $stage::new($frame);
        let those_after = row_stages!($frame, $record; $($more)*);
        move |row: &mut Row<'_>| {
            $record.apply(NoiseMap::$map, &stage, row);
            those_after(row);
        }
    }};
}

/// Exposes the sensor to light that frees `mean_electrons` on average during the exposure: e⁻, noise-free, finite and
/// not negative, a plane for each of the sensor's channels, of which every pixel uses its own. The picture may be
/// smaller than the sensor; the colour filter array starts at its top-left pixel.
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
pub struct Exposed {
    /// Its digital numbers.
    pub raw: RawImage,
    /// What some effects have added to them.
    pub maps: NoiseMaps,
    /// Charge that it leaves to the frame after it; `None` of a sensor without [image lag](crate::sensor::ImageLag).
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
) -> Result<Exposed, Invalid> {
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

/// The channels of [`NoiseMap::RawClean`]. Of the numbers of an exposure whose stages take their means, rounding is
/// taken back, and they end where those of the converter do.
fn clean(mean_electrons: &Planes, frame: &Frame<'_>, before: Option<&LeftCharge>) -> Result<Vec<Channel>, Invalid> {
    let rounded = [NoiseMap::QuantisationDn, NoiseMap::RoundingDn];
    let of_means = Frame { is_mean: true, ..*frame };
    let Exposed { raw, maps, .. } = expose_once(mean_electrons, &of_means, &rounded, before)?;
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
) -> Result<Exposed, Invalid> {
    let Frame { sensor, exposure, stages, .. } = *frame;
    exposure.validate(sensor)?;
    exposure.region.fits(sensor, [mean_electrons.width(), mean_electrons.height()])?;
    let mut charge = charge_generation::collect(mean_electrons, &sensor.cfa)?;
    cover(&mut charge, sensor);
    let mut record = Recorder::start(maps, &charge);
    spread(&mut charge, sensor, stages);
    record.plane(NoiseMap::CrosstalkE, &charge);
    let mut charge = sensor.masked.surround(charge);
    record.embed([sensor.masked.columns[0] * charge.samples, sensor.masked.rows[0]], &charge);

    let frame = Frame { size: [charge.width, charge.height], ..*frame };
    let passing = free_electrons(&frame, &mut charge, &record);
    let before = before.filter(|_| stages.has(Stage::ImageLag));
    if let Some(before) = before {
        before.join(&mut charge)?;
        record.plane(NoiseMap::ImageLagE, &charge);
    }
    hold(&frame, &mut charge, &record);
    let left = keep_back(&frame, &mut charge, before);
    record.plane(NoiseMap::ImageLagE, &charge);
    let charge = transfer(&frame, charge, &passing, &mut record);
    let frame = Frame { size: [charge.width, charge.height], ..frame };
    let picture = [mean_electrons.width(), mean_electrons.height()];
    let (numbers, size) = read_out(&frame, charge, picture, &mut record);
    let frame = Frame { size, ..frame };
    let (data, size) = process(&frame, numbers, &mut record);

    let (whole, part) = raw_image(&frame, data, size, picture);
    let layout = exposure.region.binning.layout(&sensor.cfa);
    let names = if layout.is_full() { layout.channels() } else { &[String::new()] };
    let all = PixelArea { x: 0, y: 0, width: whole.width, height: whole.height };
    let maps = NoiseMaps {
        planes: record.finish(part.unwrap_or(all), names)?,
        system_gain: sensor.system_gain(exposure),
        black_level_dn: sensor.converter.black_level_dn.into(),
    };
    let raw = match part {
        None => whole,
        Some(part) => whole.part(part),
    };
    Ok(Exposed { raw, maps, left })
}

/// Light and heat free electrons in each pixel. Returns what a well of a CCD collects while it passes through each
/// column.
fn free_electrons(frame: &Frame<'_>, charge: &mut ChargePlane, record: &Recorder) -> Vec<f32> {
    let ccd = frame.sensor.architecture.ccd();
    let passing = ccd.map(|ccd| ccd::smear(ccd, frame, charge)).unwrap_or_default();
    record.plane(NoiseMap::SmearE, charge);
    let respond = row_stages!(frame, record;
        PhotoResponse => PrnuE,
        DeadPixels => DeadPixelsE,
    );
    let photon_counter = PhotonCounter::new(frame);
    let free = row_stages!(frame, record;
        ShotNoise => PhotonShotNoiseE,
        DarkCurrent => DarkShotNoiseE,
        HotPixels => HotPixelsE,
    );
    charge.for_each_row(|row| {
        respond(row);
        match &photon_counter {
            Some(photon_counter) => record.apply(NoiseMap::PhotonCountingE, photon_counter, row),
            None => free(row),
        }
    });
    record.gains(|| PhotoResponse::new(frame));
    if photon_counter.is_none() {
        record.split_dark_current(|| DarkCurrent::new(frame));
    }
    passing
}

/// The pixels hold them.
fn hold(frame: &Frame<'_>, charge: &mut ChargePlane, record: &Recorder) {
    brighter_fatter::apply(frame, charge);
    record.plane(NoiseMap::BrighterFatterE, charge);
    if let Some(ccd) = frame.sensor.architecture.ccd() {
        ccd::bloom(ccd, frame, charge);
    }
    record.plane(NoiseMap::BloomingE, charge);
    let full_well = FullWell::new(frame);
    let logarithmic_response = LogarithmicResponse::new(frame);
    charge.for_each_row(|row| {
        record.apply(NoiseMap::FullWellE, &full_well, row);
        record.mark(row, |charge| full_well.is_some_and(|full_well| full_well.is_full(charge)));
        record.apply(NoiseMap::LogarithmicResponseE, &logarithmic_response, row);
    });
}

/// CCDs move the charge to their output; that of pixels may be added.
fn transfer(frame: &Frame<'_>, mut charge: ChargePlane, passing: &[f32], record: &mut Recorder) -> ChargePlane {
    let (sensor, binning) = (frame.sensor, frame.exposure.region.binning);
    if let Some(ccd) = sensor.architecture.ccd() {
        let prescan = ccd.overscan.prescan_columns * charge.samples;
        charge = ccd::shift_out(ccd, frame, charge, passing);
        record.embed([prescan, 0], &charge);
    }
    record.plane(NoiseMap::ChargeTransferE, &charge);
    let charge = binning.add_charge(charge, &sensor.cfa);
    record.add_charge(&binning, &sensor.cfa);
    charge
}

/// Amplifiers turn charge into voltages, converters those into digital numbers. Returns these with the length of their
/// rows and their number.
fn read_out(
    frame: &Frame<'_>,
    mut charge: ChargePlane,
    picture: [usize; 2],
    record: &mut Recorder,
) -> (Vec<u16>, [usize; 2]) {
    add_flicker(&mut charge, frame);
    record.plane(NoiseMap::FlickerNoiseE, &charge);
    let Some(grabber) = &frame.sensor.frame_grabber else {
        let (amplify, convert) = (amplify(frame, record), convert(frame, record));
        let numbers = charge.read_out(|row, numbers| {
            amplify(row);
            convert(row, numbers);
        });
        return (numbers, frame.size);
    };
    charge.for_each_row(amplify(frame, record));
    let (area, samples) = (active_area(frame.sensor, picture, Binning::NONE), charge.samples);
    record.sample(grabber, area, samples);
    let (electrons, width) = grabber.sample(&charge.electrons, [charge.width, samples], area);
    let size = [width, grabber.size[1]];
    let sampled = ChargePlane { width, height: size[1], samples, electrons };
    (sampled.read_out(convert(&Frame { size, ..*frame }, record)), size)
}

/// From charge to the signal at the converter, DN above its black level; of a sensor with two gains, charge at their
/// amplifiers.
fn amplify<'a>(frame: &'a Frame<'_>, record: &'a Recorder) -> impl Fn(&mut Row<'_>) + Sync + 'a {
    let amplify = row_stages!(frame, record;
        ResetNoise => ResetNoiseE,
        Telegraph => TelegraphNoiseE,
        DarkOffset => DsnuE,
        RowNoise => RowNoiseE,
        ColumnNoise => ColumnNoiseE,
        AmplifierNonlinearity => AmplifierNonlinearityE,
    );
    let has_two_gains = frame.sensor.converter.dual_gain.is_some();
    let read_noise = ReadNoise::new(frame);
    let gain = Gain::new(frame);
    let transmit = row_stages!(frame, record;
        ColumnAmplifiers => ColumnAmplifiersDn,
        VideoCurve => VideoCurveDn,
        VideoBandwidth => VideoBandwidthDn,
    );
    move |row| {
        amplify(row);
        if !has_two_gains {
            record.apply(NoiseMap::ReadNoiseE, &read_noise, row);
            record.amplify(&gain, row);
            transmit(row);
        }
    }
}

/// From the signal at the converter to digital numbers.
fn convert<'a>(frame: &Frame<'a>, record: &'a Recorder) -> impl Fn(&mut Row<'_>, &mut Row<'_, u16>) + Sync + 'a {
    let converter = &frame.sensor.converter;
    let gain = Gain::new(frame);
    let digitiser = Digitiser::new(frame);
    let dual_gain = DualGainDigitiser::new(frame);
    let stuck_pixels = StuckPixels::new(frame);
    move |row, numbers| {
        match &dual_gain {
            Some(dual_gain) => {
                dual_gain.convert(row, numbers);
                record.changed(NoiseMap::ReadNoiseE, row);
                record.amplify(&gain, row);
            }
            None => digitiser.convert(row, numbers),
        }
        record.converted(numbers, converter);
        record.apply_to_numbers(NoiseMap::StuckPixelsDn, &stuck_pixels, numbers);
    }
}

/// Numbers are processed and sent. Returns them with the length of their rows and the number of these.
fn process(frame: &Frame<'_>, numbers: Vec<u16>, record: &mut Recorder) -> (Vec<u16>, [usize; 2]) {
    let (sensor, binning) = (frame.sensor, frame.exposure.region.binning);
    let (mut data, size) = binning.add_numbers(numbers, frame.size, sensor);
    record.add_numbers(&binning, sensor, &data, size[0]);
    let frame = &Frame { size, ..*frame };
    let digital_gain = DigitalGain::new(frame);
    let compander = Compander::new(frame).filter(|_| !frame.is_mean);
    let transmission_errors = TransmissionErrors::new(frame);
    for_each_row(&mut data, size[0], |numbers| {
        record.multiply(digital_gain.as_ref(), numbers);
        record.apply_to_numbers(NoiseMap::CompandingDn, &compander, numbers);
        record.apply_to_numbers(NoiseMap::TransmissionErrorsDn, &transmission_errors, numbers);
    });
    (data, size)
}

/// All that is read out of a picture of these columns and rows, with what a raw file says of it, and the part of it
/// that is asked for.
fn raw_image(
    frame: &Frame<'_>,
    data: Vec<u16>,
    [row_length, height]: [usize; 2],
    picture: [usize; 2],
) -> (RawImage, Option<PixelArea>) {
    let Frame { sensor, exposure, .. } = *frame;
    let RegionOfInterest { binning, pixels } = exposure.region;
    let layout = binning.layout(&sensor.cfa);
    let width = row_length / layout.samples_per_pixel();
    // What a frame grabber samples is the picture alone.
    let (area, per_number) = match &sensor.frame_grabber {
        Some(grabber) => (PixelArea { x: 0, y: 0, width, height }, grabber.pixels_per_sample(picture)),
        None => (active_area(sensor, picture, binning), binning.factor.map(|n| n as f64)),
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
        black_level_dn: linearisation.as_ref().map_or(sensor.converter.black_level_dn, |l| l.black_level_dn).into(),
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

/// Where among all that is read out the picture lies, in bins.
fn active_area(sensor: &SensorModel, picture: [usize; 2], binning: Binning) -> PixelArea {
    let prescan = sensor.architecture.ccd().map_or(0, |ccd| ccd.overscan.prescan_columns);
    let [across, down] = binning.factor;
    let [width, height] = binning.whole_bins(picture, &sensor.cfa);
    PixelArea { x: (prescan + sensor.masked.columns[0]) / across, y: sensor.masked.rows[0] / down, width, height }
}

/// The tile as it lies at the corner of all that is read out, so that it begins at that of the picture.
fn tile_from_corner(cfa: &Cfa, picture: PixelArea) -> Cfa {
    let (width, height) = cfa.tile_size();
    let width = width / cfa.samples_per_pixel();
    cfa.from(width - picture.x % width, height - picture.y % height)
}
