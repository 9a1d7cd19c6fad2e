//! Image lag: what stays in the pixels of a frame comes with the next ones, by the law that the module states.

use photosite::math::statistics::Moments;
use photosite::sensor::{
    ExposedFrame, ImageLag, LeftCharge, NoiseKey, NoiseMap, SensorModel, Stage, Stages, expose, expose_after,
};
use photosite::units::Electrons;
use rstest::rstest;

use crate::sensor_cases::{EXPOSURE, flat, quiet_sensor};

const SIDE: usize = 64;
const PIXELS: f64 = (SIDE * SIDE) as f64;
const BLACK: f64 = 1000.0;

fn sensor(fraction: f64, electrons: f64, decay: f64) -> SensorModel {
    SensorModel { image_lag: Some(ImageLag { fraction, electrons: Electrons(electrons), decay }), ..quiet_sensor() }
}

/// Frames of these mean electrons, one after the other.
fn series(sensor: &SensorModel, means: &[f32], stages: Stages) -> Vec<ExposedFrame> {
    let mut left: Option<LeftCharge> = None;
    let frames = (0..).zip(means).map(|(frame, &mean)| {
        let light = flat(sensor, SIDE, SIDE, mean);
        let key = NoiseKey { seed: 3, frame };
        let exposed = expose_after(&light, sensor, &EXPOSURE, stages, key, &[NoiseMap::ImageLagE], left.as_ref());
        let exposed = exposed.expect("valid");
        left.clone_from(&exposed.left);
        exposed
    });
    frames.collect()
}

fn signals(exposed: &ExposedFrame) -> Moments {
    exposed.raw.data.iter().map(|&dn| f64::from(dn) - BLACK).collect()
}

#[rstest]
#[case::incomplete_transfer(0.02, 0.0, 0.02)]
#[case::slow(0.01, 0.0, 0.6)]
#[case::pocket(0.0, 40.0, 0.3)]
#[case::both(0.005, 25.0, 0.8)]
fn no_electron_is_lost_or_made(#[case] fraction: f64, #[case] electrons: f64, #[case] decay: f64) {
    let sensor = sensor(fraction, electrons, decay);
    let means = [5000.0, 20_000.0, 0.0, 0.0, 300.0, 0.0];
    let frames = series(&sensor, &means, Stages::only(&[Stage::ImageLag]));
    let mut freed = 0.0;
    let mut read = 0.0;
    for (exposed, mean) in frames.iter().zip(means) {
        freed += f64::from(mean) * PIXELS;
        read += signals(exposed).mean() * PIXELS;
        let left = exposed.left.as_ref().expect("a sensor with lag").total_e();
        // Whole electrons at 1 DN/e⁻: sums of less than 2⁵³ are exact, the mean times its count to some roundings.
        assert!((freed - read - left).abs() < 1e-6, "{freed} {read} {left}");
    }
}

#[rstest]
#[case::incomplete_transfer(0.02, 0.0, 0.02)]
#[case::slow(0.01, 0.0, 0.6)]
#[case::pocket(0.0, 40.0, 0.3)]
#[case::both(0.005, 25.0, 0.8)]
fn frames_follow_the_law_of_the_mean(#[case] fraction: f64, #[case] electrons: f64, #[case] decay: f64) {
    const LIGHT: f64 = 10_000.0;
    let lit = 60;
    let means: Vec<f32> = (0..lit + 5).map(|i| if i < lit { LIGHT as f32 } else { 0.0 }).collect();
    let frames = series(&sensor(fraction, electrons, decay), &means, Stages::only(&[Stage::ImageLag]));
    // The recursion of the means, in f64.
    let mut kept = 0.0;
    for (i, (exposed, mean)) in frames.iter().zip(&means).enumerate() {
        let q = f64::from(*mean);
        let new = fraction * q + electrons.min((1.0 - fraction) * q);
        let expected = q - new + (1.0 - decay) * kept;
        // Electrons that stay or come are drawn one by one: the variance of what stays now is at most its mean, as is
        // that of what has been kept, whatever part of it comes.
        let spread = (new + kept).sqrt();
        kept = new + decay * kept;
        let found = signals(exposed).mean();
        assert!((found - expected).abs() <= 5.0 * spread / PIXELS.sqrt(), "frame {i}: {found} for {expected}");
        // Data sheets' figure: the first dark frame after steady light, and the decay of those after it.
        if i >= lit {
            let sheet = (fraction * LIGHT + electrons) * decay.powi((i - lit) as i32);
            let settled = decay.powi(lit as i32) * LIGHT;
            assert!((expected - sheet).abs() < 1e-9 + settled, "frame {i}: {expected} for {sheet}");
        }
        let map = &exposed.maps.planes.channels()[0].data;
        let change = map.iter().map(|&e| f64::from(e)).sum::<f64>() / PIXELS;
        assert!((change - (found - q)).abs() < 1e-6, "frame {i}: the map has {change}");
    }
}

#[test]
fn light_keeps_the_noise_of_light() {
    // Thinning and joining Poisson-distributed numbers leaves them so: variance and mean of a settled frame are equal.
    let sensor = sensor(0.1, 0.0, 0.5);
    let frames = series(&sensor, &[4000.0; 20], Stages::only(&[Stage::ShotNoise, Stage::ImageLag]));
    let m = signals(frames.last().expect("frames"));
    // The standard error of a variance is √(2/N) of it, of the mean √(mean/N).
    assert!((m.mean() - 4000.0).abs() < 5.0 * (4000.0 / PIXELS).sqrt(), "{}", m.mean());
    assert!((m.variance() / 4000.0 - 1.0).abs() < 5.0 * (2.0 / PIXELS).sqrt(), "{}", m.variance());
}

#[test]
fn a_sensor_without_lag_or_with_the_stage_off_keeps_nothing() {
    let lagging = sensor(0.02, 10.0, 0.5);
    let light = flat(&lagging, SIDE, SIDE, 3000.0);
    let key = NoiseKey { seed: 1, frame: 4 };
    let before = series(&lagging, &[20_000.0], Stages::ALL).remove(0).left;
    assert!(before.as_ref().is_some_and(|left| left.total_e() > 0.0));
    let off = Stages::ALL.without(Stage::ImageLag);
    let without = SensorModel { image_lag: None, ..lagging.clone() };
    let plain = expose(&light, &without, &EXPOSURE, Stages::ALL, key).expect("valid");
    let switched = expose_after(&light, &lagging, &EXPOSURE, off, key, &[], before.as_ref()).expect("valid");
    assert!(switched.raw == plain && switched.left.is_none());
    let none = expose_after(&light, &without, &EXPOSURE, Stages::ALL, key, &[], None).expect("valid");
    assert!(none.raw == plain && none.left.is_none());
}

#[test]
fn charge_of_a_frame_of_another_size_is_refused() {
    let sensor = sensor(0.02, 0.0, 0.02);
    let left = series(&sensor, &[5000.0], Stages::ALL).remove(0).left;
    let light = flat(&sensor, 8, 8, 100.0);
    let error = expose_after(&light, &sensor, &EXPOSURE, Stages::ALL, NoiseKey::default(), &[], left.as_ref());
    assert!(error.expect_err("another size").message.contains("[64, 64]"));
}
