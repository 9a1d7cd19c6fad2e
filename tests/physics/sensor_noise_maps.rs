//! Noise maps: they sum to the image, and each is what its stage does alone.

use photosite::image::Planes;
use photosite::math::statistics::Moments;
use photosite::raw::PixelArea;
use photosite::sensor::{
    Binning, BinningMethod, Companding, CompandingCurve, Exposure, Logarithmic, MapUnit, NoiseKey, NoiseMap, NoiseMaps,
    RegionOfInterest, SensorModel, Stage, Stages, expose, expose_with_maps, presets,
};
use photosite::units::{Decibels, Electrons};
use rstest::rstest;

use crate::sensor_cases::{EXPOSURE, flat, noisy_sensor, noisy_sensor_with, quiet_sensor};

const KEY: NoiseKey = NoiseKey { seed: 5, frame: 2 };

/// A ramp of light up to twice the mean.
fn ramp(sensor: &SensorModel, width: usize, height: usize, mean_e: f32) -> Planes {
    let mut planes = flat(sensor, width, height, mean_e);
    for channel in planes.channels_mut() {
        channel.data.iter_mut().enumerate().for_each(|(i, e)| *e *= 2.0 * (i % width) as f32 / width as f32);
    }
    planes
}

/// Sums the maps, and finds the pixel values of the image to within rounding.
fn assert_sum(light: &Planes, sensor: &SensorModel, exposure: &Exposure) -> NoiseMaps {
    let plain = expose(light, sensor, exposure, Stages::ALL, KEY).expect("valid");
    let (raw, maps) = expose_with_maps(light, sensor, exposure, Stages::ALL, KEY, &NoiseMap::ALL).expect("valid");
    assert_eq!(raw, plain, "looking changes nothing");
    assert_eq!((maps.planes.width(), maps.planes.height()), (raw.width, raw.height));
    let samples = raw.cfa.samples_per_pixel();
    assert_eq!(maps.planes.channels().len(), NoiseMap::ALL.len() * samples);
    for (i, &number) in raw.data.iter().enumerate() {
        let (mut sum, mut size) = (maps.black_level_dn, maps.black_level_dn);
        for (k, map) in NoiseMap::ALL.into_iter().enumerate() {
            let value = f64::from(maps.planes.channels()[k * samples + i % samples].data[i / samples]);
            let value = match map.unit() {
                MapUnit::Electrons => maps.system_gain * value,
                MapUnit::DigitalNumbers => value,
                MapUnit::None => continue,
            };
            sum += value;
            size += value.abs();
        }
        // Signals and maps are 32-bit floats, each rounded to a 2⁻²⁴th of itself. A map is rounded as a difference, in
        // bins, by the digital gain, and twice where it is told from another; the signal, no larger than the sum of all
        // changes, by the gain, in bins and by the digital gain. All else is taken down as it is.
        let tolerance = 8.0 * size * (-24f64).exp2();
        assert!((sum - f64::from(number)).abs() < tolerance, "{i}: {sum} ± {tolerance} for {number}");
        assert!(tolerance < 0.25, "the test could not tell");
    }
    maps
}

fn window(factor: [usize; 2], method: BinningMethod) -> Exposure {
    let binning = Binning { factor, method };
    let pixels = Some(PixelArea { x: 4, y: 8, width: 32, height: 16 });
    Exposure { region: RegionOfInterest { binning, pixels }, digital_gain: Decibels(5.0), ..EXPOSURE }
}

#[rstest]
#[case::cmos(noisy_sensor_with(Stage::BrighterFatter))]
#[case::ccd(noisy_sensor_with(Stage::Smear))]
#[case::lag(noisy_sensor_with(Stage::ImageLag))]
#[case::photon_counter(noisy_sensor_with(Stage::PhotonCounting))]
#[case::two_gains(noisy_sensor_with(Stage::LowGainReadNoise))]
#[case::logarithmic(SensorModel { logarithmic: Some(Logarithmic { reference_e_per_s: 500.0 }), ..noisy_sensor() })]
fn maps_sum_to_the_image(
    #[case] mut sensor: SensorModel,
    #[values(Exposure::of(EXPOSURE.time), window([2, 2], BinningMethod::Mean), window([2, 1], BinningMethod::Sum))]
    exposure: Exposure,
) {
    sensor.masked.columns = [2, 4];
    sensor.masked.rows = [2, 0];
    assert_sum(&ramp(&sensor, 48, 32, 2000.0), &sensor, &exposure);
}

#[rstest]
fn maps_of_added_charge_and_companded_numbers_sum_to_the_image(#[values(Stage::ReadNoise, Stage::Smear)] kind: Stage) {
    let mut sensor = noisy_sensor_with(kind);
    let curve = CompandingCurve::KneePoints(vec![[0, 0], [2048, 2048], [65_535, 4095]]);
    sensor.converter.companding = Some(Companding { bits: 12, curve });
    assert_sum(&ramp(&sensor, 48, 32, 2000.0), &sensor, &window([2, 2], BinningMethod::Charge));
}

#[rstest]
fn maps_of_presets_sum_to_the_image(
    #[values("generic-cmos-color", "generic-three-chip-ccd", "generic-stacked-color", "automotive-hdr-color")]
    preset: &str,
) {
    let sensor = presets::model(preset).expect("a preset");
    let light = ramp(&sensor, 48, 36, 0.6 * sensor.full_well.0 as f32);
    assert_sum(&light, &sensor, &Exposure { gain: Decibels(3.0), ..EXPOSURE });
}

#[rstest]
#[case(Stage::ResetNoise, NoiseMap::ResetNoiseE)]
#[case(Stage::Telegraph, NoiseMap::TelegraphNoiseE)]
#[case(Stage::DarkOffset, NoiseMap::DsnuE)]
#[case(Stage::ReadNoise, NoiseMap::ReadNoiseE)]
#[case(Stage::RowNoise, NoiseMap::RowNoiseE)]
#[case(Stage::ColumnNoise, NoiseMap::ColumnNoiseE)]
#[case(Stage::Flicker, NoiseMap::FlickerNoiseE)]
#[case(Stage::HotPixels, NoiseMap::HotPixelsE)]
#[case(Stage::PhotoResponse, NoiseMap::PrnuE)]
#[case(Stage::DeadPixels, NoiseMap::DeadPixelsE)]
#[case(Stage::StuckPixels, NoiseMap::StuckPixelsDn)]
#[case(Stage::TransmissionErrors, NoiseMap::TransmissionErrorsDn)]
#[case(Stage::ColumnAmplifiers, NoiseMap::ColumnAmplifiersDn)]
fn a_map_is_what_its_stage_does_alone(#[case] stage: Stage, #[case] map: NoiseMap) {
    // A gain of 1 DN/e⁻.
    let sensor = noisy_sensor();
    let light = flat(&sensor, 64, 48, 1500.0);
    let with = Stages::NONE.with(stage);
    let [with_it, without] =
        [with, Stages::NONE].map(|stages| expose(&light, &sensor, &EXPOSURE, stages, KEY).expect("valid"));
    let (_, maps) = expose_with_maps(&light, &sensor, &EXPOSURE, with, KEY, &[map]).expect("valid");
    let values = maps.planes.plane(map.name()).expect("the map");
    assert!(values.iter().any(|&value| value != 0.0));
    for (value, (with_it, without)) in values.iter().zip(with_it.data.iter().zip(&without.data)) {
        let difference = f64::from(*with_it) - f64::from(*without);
        // 1500 e⁻ are a whole number, so one rounding by half a DN, and 32-bit floats of 2¹¹.
        assert!((f64::from(*value) - difference).abs() <= 0.5 + 1e-3, "{value} for {difference}");
    }
}

#[test]
fn shot_noise_has_the_variance_of_its_mean_and_thermal_electrons_theirs() {
    let mut sensor = quiet_sensor();
    sensor.noise.dark_current_e_per_s = 400.0;
    sensor.noise.dark_current_nonuniformity = 0.3;
    let light = flat(&sensor, 256, 256, 2000.0);
    let (_, maps) = expose_with_maps(&light, &sensor, &EXPOSURE, Stages::ALL, KEY, &NoiseMap::ALL).expect("valid");
    let moments = |map: NoiseMap| -> Moments {
        maps.planes.plane(map.name()).expect("the map").iter().map(|&value| f64::from(value)).collect()
    };
    let n = 65_536.0f64;
    for (map, variance) in [(NoiseMap::PhotonShotNoiseE, 2000.0), (NoiseMap::DarkShotNoiseE, 400.0)] {
        let found = moments(map);
        // 5 σ: of the mean √(σ²/n), of the variance of nearly normal numbers √(2/n).
        assert!(found.mean().abs() < 5.0 * (variance / n).sqrt(), "{map:?}: {}", found.mean());
        assert!((found.variance() / variance - 1.0).abs() < 5.0 * (2.0 / n).sqrt(), "{map:?}: {}", found.variance());
    }
    assert!(maps.planes.plane("dark_current_e").expect("the map").iter().all(|&e| e == 400.0));
    // A log-normal factor of standard deviation 0.3: its kurtosis is 4.6, so the variance is known to √((4.6 − 1)/n).
    let uneven = moments(NoiseMap::DarkCurrentNonuniformityE);
    assert!((uneven.variance().sqrt() / 120.0 - 1.0).abs() < 2.5 * (3.6 / n).sqrt() + 0.005, "{}", uneven.variance());
    // Whole electrons at 1 DN/e⁻ need no rounding.
    assert!(maps.planes.plane("quantisation_dn").expect("the map").iter().all(|&dn| dn == 0.0));
}

#[test]
fn the_gain_map_is_the_response_and_saturated_pixels_are_marked() {
    let mut sensor = noisy_sensor();
    sensor.full_well = Electrons(2100.0);
    let light = ramp(&sensor, 64, 48, 2000.0);
    let stages = Stages::only(&[Stage::PhotoResponse, Stage::FullWell]);
    let (raw, maps) = expose_with_maps(&light, &sensor, &EXPOSURE, stages, KEY, &NoiseMap::ALL).expect("valid");
    let plane = |map: NoiseMap| maps.planes.plane(map.name()).expect("the map");
    for i in 0..raw.data.len() {
        let [gain, light, prnu] =
            [NoiseMap::PrnuGain, NoiseMap::PhotoElectronsE, NoiseMap::PrnuE].map(|map| plane(map)[i]);
        // Both are differences or factors of the same 32-bit floats.
        assert!((light * (gain - 1.0) - prnu).abs() <= 3.0 * light * f32::EPSILON, "{light} · {gain}, {prnu}");
        let cut = plane(NoiseMap::FullWellE)[i] < 0.0;
        assert_eq!(plane(NoiseMap::Saturated)[i] == 1.0, cut, "pixel {i}");
    }
    let marked = plane(NoiseMap::Saturated).iter().filter(|&&mark| mark == 1.0).count();
    assert!((1000..2000).contains(&marked), "about the brighter half of 3072: {marked}");
}

/// Sensors of each kind, far from the ends of what they hold.
fn roomy(stage: Stage) -> SensorModel {
    SensorModel { full_well: Electrons(60_000.0), ..noisy_sensor_with(stage) }
}

fn companded(mut sensor: SensorModel) -> SensorModel {
    let curve = CompandingCurve::KneePoints(vec![[0, 0], [1500, 1500], [65_535, 4095]]);
    sensor.converter.companding = Some(Companding { bits: 12, curve });
    sensor
}

fn raw_clean(light: &Planes, sensor: &SensorModel, exposure: &Exposure, stages: Stages) -> Vec<f64> {
    let maps = [NoiseMap::PrnuE, NoiseMap::RawClean];
    let (_, maps) = expose_with_maps(light, sensor, exposure, stages, KEY, &maps).expect("valid");
    let clean = maps.planes.plane(NoiseMap::RawClean.name()).expect("the map");
    clean.iter().map(|&dn| f64::from(dn)).collect()
}

#[rstest]
#[case::cmos(roomy(Stage::BrighterFatter))]
#[case::ccd(roomy(Stage::Smear))]
#[case::lag(roomy(Stage::ImageLag))]
#[case::photon_counter(roomy(Stage::PhotonCounting))]
#[case::two_gains(roomy(Stage::LowGainReadNoise))]
#[case::video(roomy(Stage::VideoBandwidth))]
fn the_mean_of_many_images_is_the_clean_one(
    #[case] sensor: SensorModel,
    #[values(Exposure::of(EXPOSURE.time), window([2, 2], BinningMethod::Mean), window([2, 1], BinningMethod::Sum),
        window([2, 2], BinningMethod::Charge))]
    exposure: Exposure,
) {
    const TAKES: u64 = 300;
    if exposure.region.binning.method == BinningMethod::Charge && sensor.architecture.spad().is_some() {
        // There is no charge to add.
        return;
    }
    let light = ramp(&sensor, 48, 32, 1000.0);
    let stages = Stages::ALL.without(Stage::TransmissionErrors);
    let clean = raw_clean(&light, &sensor, &exposure, stages);
    let mut of_pixels = vec![Moments::default(); clean.len()];
    let mut of_images = Moments::default();
    for seed in 0..TAKES {
        let key = NoiseKey { seed, frame: 0 };
        let raw = expose(&light, &sensor, &exposure, stages, key).expect("valid");
        let differences = raw.data.iter().zip(&clean).map(|(&dn, clean)| f64::from(dn) - clean);
        of_images.add(differences.clone().sum::<f64>() / clean.len() as f64);
        of_pixels.iter_mut().zip(differences).for_each(|(pixel, difference)| pixel.add(difference));
    }
    // Steps of unequal width are averaged by noise, up to 0.4 DN, and curves bend less than a DN within the noise; bins
    // add up to four pixels, behind a gain of 1.8.
    let bias = if exposure.region.binning.pixels() > 1 { 4.0 } else { 1.0 };
    let error = |moments: &Moments| (moments.variance() / TAKES as f64).sqrt();
    let mean = of_images.mean();
    assert!(mean.abs() < 5.0 * error(&of_images) + bias, "{mean} ± {}", error(&of_images));
    let noise = of_pixels.iter().map(|pixel| pixel.variance().sqrt()).fold(0.0, f64::max);
    let brightest = clean.iter().copied().fold(0.0, f64::max);
    for (i, (pixel, clean)) in of_pixels.iter().zip(&clean).enumerate() {
        // Read noise has heavy tails.
        let tolerance = 7.0 * error(pixel) + bias;
        // Where numbers may end, as bins of two gains do, the mean of those that do not reach the end lies below it: by
        // 0.4 standard deviations right there. Where two gains change over, numbers that noise lifts are read again.
        let changes_gain = exposure.region.binning.pixels() > 1 && sensor.converter.dual_gain.is_some();
        let ends = brightest - clean < 6.0 * noise || changes_gain;
        let below = if ends { 0.6 * noise } else { 0.0 };
        let mean = pixel.mean();
        assert!(mean < tolerance && mean > -tolerance - below, "{i}: {mean} ± {}", error(pixel));
    }
}

#[rstest]
#[case::plain(noisy_sensor(), Exposure::of(EXPOSURE.time), 0.5)]
#[case::ccd(noisy_sensor_with(Stage::Blooming), Exposure::of(EXPOSURE.time), 0.5)]
#[case::companded(companded(noisy_sensor()), Exposure::of(EXPOSURE.time), 1.0)]
// Rounding of the pixels, of the bin and behind a gain of 1.78.
#[case::binned(noisy_sensor(), window([2, 2], BinningMethod::Mean), 0.5 + 1.78 * (0.5 + 0.5))]
#[case::added(noisy_sensor(), window([2, 1], BinningMethod::Sum), 0.5 + 1.78 * (2.0 * 0.5))]
fn without_temporal_noise_the_clean_image_rounds_to_the_raw_one(
    #[case] sensor: SensorModel,
    #[case] exposure: Exposure,
    #[case] rounding: f64,
) {
    let stages = Stages::only(&[
        Stage::Crosstalk,
        Stage::Smear,
        Stage::PhotoResponse,
        Stage::DeadPixels,
        Stage::Blooming,
        Stage::FullWell,
        Stage::DarkOffset,
        Stage::AmplifierNonlinearity,
        Stage::ColumnAmplifiers,
    ]);
    // Up to far beyond the full well, and without charge.
    let light = ramp(&sensor, 48, 32, 40_000.0);
    let raw = expose(&light, &sensor, &exposure, stages, KEY).expect("valid");
    for (i, (&dn, clean)) in raw.data.iter().zip(raw_clean(&light, &sensor, &exposure, stages)).enumerate() {
        assert!((f64::from(dn) - clean).abs() <= rounding + 0.01, "{i}: {dn} is not {clean}");
    }
}

#[test]
fn names_end_with_units_and_tell_maps_apart() {
    for (i, map) in NoiseMap::ALL.into_iter().enumerate() {
        assert_eq!(serde_json::from_value::<NoiseMap>(map.name().into()).ok(), Some(map), "one name everywhere");
        assert!(NoiseMap::ALL[..i].iter().all(|other| other.name() != map.name()));
    }
    assert_eq!(NoiseMap::PrnuE.unit(), MapUnit::Electrons);
    assert_eq!(NoiseMap::ClippingDn.unit(), MapUnit::DigitalNumbers);
    for map in [NoiseMap::Saturated, NoiseMap::PrnuGain, NoiseMap::RawClean] {
        assert_eq!(map.unit(), MapUnit::None);
    }
}
