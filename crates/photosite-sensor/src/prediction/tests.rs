//! Shares of the variance, measured: each stage of the list is exposed alone, whatever it is.

use std::f64::consts::PI;

use photosite_core::image::Planes;
use photosite_core::math::statistics::Moments;
use photosite_core::units::{Decibels, Electrons, Seconds};

use super::noise_model::NoiseModel;
use super::shares::Share;
use crate::chain::tests::sensors;
use crate::{Exposure, NoiseKey, SensorModel, Stage, Stages, expose};

const SIZE: [usize; 2] = [96, 64];
const EXPOSURE: Exposure = Exposure::of(Seconds(1.0));
/// Light as parts of the full well: with two gains, the one and the other counts.
const LEVELS: [f64; 2] = [0.02, 0.4];

/// Signals of two takes of a sensor, e⁻: seed, and so chance, is all that they differ in. Light differs by up to `step_e`
/// between pixels, about a mean.
fn pair(sensor: &SensorModel, stages: Stages, [mean_e, step_e]: [f64; 2], number: u64) -> [Vec<f64>; 2] {
    const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;
    let of_pixel = |i: usize| mean_e + step_e * ((i as f64 * GOLDEN_RATIO).fract() - 0.5);
    let mut light = Planes::zeros(SIZE[0], SIZE[1], sensor.cfa.channels());
    for channel in light.channels_mut() {
        channel.data.iter_mut().enumerate().for_each(|(i, electrons)| *electrons = of_pixel(i) as f32);
    }
    let sensor = SensorModel { serial: number, ..sensor.clone() };
    let black = f64::from(sensor.converter.black_level_dn(Decibels(0.0)));
    [0, 1].map(|take| {
        let key = NoiseKey { seed: 2 * number + take, frame: 0 };
        let raw = expose(&light, &sensor, &EXPOSURE, stages, key).expect("an exposure");
        let electrons = |&dn: &u16| (f64::from(dn) - black) / sensor.system_gain(&EXPOSURE);
        let active = raw.active_area.map_or_else(|| raw.clone(), |area| raw.part(area));
        active.data.iter().map(electrons).collect()
    })
}

/// Mean, variance (e⁻)², and the standard error of that: of pairs of takes, each of a sensor with patterns of its own.
fn measured(sensor: &SensorModel, stages: Stages, mean_e: f64) -> (f64, f64, f64) {
    const PAIRS: u64 = 32;
    // Eight steps of the coarsest converter: rounding is up and down alike, however little noise there is, and merging
    // makes numbers of one gain 12 and 13 of the other.
    let converter = sensor.converter.dual_gain.as_ref().map_or(&sensor.converter, |dual| &dual.low);
    let light = [mean_e, 8.0 / converter.system_gain(EXPOSURE.gain)];
    let (mut means, mut variances) = (Moments::default(), Moments::default());
    for number in 1..=PAIRS {
        let [a, b] = pair(sensor, stages, light, number);
        let halves: Moments = a.iter().zip(&b).map(|(a, b)| 0.5 * (a - b) * (a - b)).collect();
        variances.add(halves.mean());
        means.add(a.iter().sum::<f64>() / a.len() as f64);
    }
    (means.mean(), variances.mean(), (variances.variance() / PAIRS as f64).sqrt())
}

/// Variance of rounding to whole numbers, (e⁻)².
fn rounded(sensor: &SensorModel) -> f64 {
    1.0 / 12.0 / sensor.system_gain(&EXPOSURE).powi(2)
}

#[test]
fn the_share_of_each_stage_is_what_it_adds() {
    // Where a stage leaves all numbers as they are, rounding is no noise.
    let dither = Stages::only(&[Stage::ReadNoise, Stage::LowGainReadNoise]);
    let sensors = sensors();
    for stage in Stage::ALL {
        let sensor = sensors.iter().rev().find(|sensor| sensor.has_stage(stage) && !sensor.shutter.scans());
        let sensor = sensor.expect("one has it");
        let mut is_seen = false;
        for mean_e in LEVELS.map(|level| level * sensor.full_well.0) {
            let case = format!("{stage:?} of {} at {mean_e} e⁻", sensor.name);
            let variance = |stages, mean_e| NoiseModel::new(sensor, &EXPOSURE, stages).variance(Electrons(mean_e));
            let share = sensor.share(stage, &EXPOSURE);
            match share {
                Share::Light
                | Share::Heat(_)
                | Share::Pixel(_)
                | Share::Amplifier(_)
                | Share::LowGain(_)
                | Share::Row(_)
                | Share::Column(_)
                | Share::Steps(_) => {
                    let stages = dither.with(stage);
                    let (_, found, error) = measured(sensor, stages, mean_e);
                    let without = variance(dither.without(stage), mean_e);
                    // Thresholds that are displaced by d move the mean of normal numbers of standard deviation σ, in
                    // steps, by d·φ, in every take: of all d² this is ∫φ² = 1/(2·√π·σ), which is no noise.
                    let steps = (without - rounded(sensor)).sqrt() * sensor.system_gain(&EXPOSURE);
                    let is_pattern = if matches!(share, Share::Steps(_)) { 0.5 / (PI.sqrt() * steps) } else { 0.0 };
                    let expected = variance(stages, mean_e);
                    let expected = expected - is_pattern * (expected - without);
                    // Errors of 32 pairs are known to an eighth. With two gains, numbers of the one that counts that are
                    // whole ones of the merged numbers are not rounded twice.
                    let merging = if sensor.converter.dual_gain.is_some() { rounded(sensor) } else { 0.0 };
                    let tolerance = 5.5 * error + merging;
                    assert!((found - expected).abs() < tolerance, "{case}: {found} ± {error} for {expected}");
                    is_seen |= (found - without).abs() > tolerance;
                }
                Share::Moved => {
                    let stages = dither.with(Stage::ShotNoise).with(stage);
                    let (mean, found, error) = measured(sensor, stages, mean_e);
                    let expected = variance(stages, mean);
                    assert!((found - expected).abs() < 5.5 * error, "{case}: {found} ± {error} for {expected}");
                    is_seen = true;
                }
                Share::Mean | Share::Fixed => {
                    let [a, b] = pair(sensor, Stages::only(&[stage]), [mean_e, 0.0], 1);
                    assert_eq!(a, b, "{case}: {share:?} does not change from take to take");
                    let is_even = a.iter().all(|&e| e == a[0]);
                    assert!(is_even || matches!(share, Share::Fixed), "{case}: {share:?} is even");
                    is_seen = true;
                }
                Share::Untold => {
                    let [a, b] = pair(sensor, Stages::only(&[stage, Stage::ShotNoise]), [mean_e, 0.0], 1);
                    is_seen |= a != b;
                }
            }
        }
        assert!(is_seen, "{stage:?} shows at no level");
    }
}
