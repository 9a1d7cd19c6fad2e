//! One unit for all figures of a read-out: electrons of the pixel that is read out, whatever has become one number.
//! Photon transfer finds the system gain from the images alone, K = Δσ²/Δμ between two flat fields in DN.

use photosite::math::statistics::Moments;
use photosite::raw::Cfa;
use photosite::sensor::{
    Architecture, Binning, BinningMethod, Converter, Counting, DualGain, Exposure, NoiseKey, NoiseMap,
    RegionOfInterest, SensorModel, Spad, Stages, expose, expose_with_maps,
};
use photosite::units::{Decibels, Electrons, Seconds};
use rstest::rstest;

use crate::sensor_cases::{EXPOSURE, flat, ideal_ccd, quiet_sensor};

const SIDE: usize = 256;

/// A quiet sensor at 1 DN/e⁻ but for a read noise of 20 e⁻.
fn cmos() -> SensorModel {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.read = Electrons(20.0));
    sensor
}

fn colour() -> SensorModel {
    SensorModel { cfa: Cfa::parse("RGGB").expect("a Bayer tile"), ..cmos() }
}

fn ccd() -> SensorModel {
    SensorModel { architecture: Architecture::Ccd(ideal_ccd()), ..cmos() }
}

/// Counts without dead time, which are as random as the photons.
fn spad() -> SensorModel {
    let spad = Spad { counting: Counting::FreeRunning { dead_time: Seconds(0.0) }, afterpulsing: 0.0 };
    SensorModel { architecture: Architecture::Spad(spad), ..cmos() }
}

/// 4 DN/e⁻ up to 860 e⁻, then 1 DN/e⁻ up to 3695, merged at 1 DN/e⁻. Black levels leave room for 5 σ of noise.
fn dual_gain() -> SensorModel {
    let mut sensor = cmos();
    let branch = |conversion_gain_dn_per_e| Converter {
        bits: 12,
        conversion_gain_dn_per_e,
        black_level: 400.into(),
        ..sensor.converter.clone()
    };
    let dual_gain = DualGain { high: branch(4.0), low: branch(1.0), low_read_noise: Electrons(20.0) };
    sensor.converter.dual_gain = Some(Box::new(dual_gain));
    sensor
}

/// Mean of the numbers of a flat field, and their temporal variance from a pair, ½·Var(a − b).
fn flat_field(sensor: &SensorModel, exposure: &Exposure, mean_e: f32) -> (f64, f64) {
    let light = flat(sensor, SIDE, SIDE, mean_e);
    let image = |frame| {
        let key = NoiseKey { seed: 21, frame };
        expose(&light, sensor, exposure, Stages::ALL, key).expect("a valid exposure").data
    };
    let [a, b] = [0, 1].map(image);
    let mean: Moments = a.iter().chain(&b).map(|&dn| f64::from(dn)).collect();
    let difference: Moments = a.iter().zip(&b).map(|(&a, &b)| f64::from(a) - f64::from(b)).collect();
    (mean.mean(), difference.variance() / 2.0)
}

#[rstest]
fn figures_are_those_that_photon_transfer_finds(
    #[values((cmos(), [500.0, 2500.0]), (colour(), [500.0, 2500.0]), (ccd(), [500.0, 2500.0]), (spad(), [500.0, 2500.0]),
             (dual_gain(), [100.0, 600.0]), (dual_gain(), [1500.0, 3000.0]))]
    (sensor, levels_e): (SensorModel, [f32; 2]),
    #[values(Binning::NONE, Binning { factor: [2, 2], method: BinningMethod::Charge },
             Binning { factor: [2, 2], method: BinningMethod::Sum }, Binning { factor: [2, 2], method: BinningMethod::Mean },
             Binning { factor: [4, 1], method: BinningMethod::Mean })]
    binning: Binning,
    #[values(0.0, 20.0 * 2f64.log10())] digital_gain_db: f64,
) {
    let region = RegionOfInterest { binning, pixels: None };
    let exposure = Exposure { region, digital_gain: Decibels(digital_gain_db), ..EXPOSURE };
    let adds_charge = binning.method == BinningMethod::Charge;
    if exposure.validate(&sensor).is_err() {
        assert!(adds_charge && sensor.architecture.spad().is_some(), "counters have no charge to add");
        return;
    }
    // The wells of a bin are read out by one converter, for which there has to be room.
    let scale = if adds_charge { 1.0 / binning.pixels() as f32 } else { 1.0 };
    let [(low, low_variance), (high, high_variance)] =
        levels_e.map(|level| flat_field(&sensor, &exposure, level * scale));
    let (dark, dark_variance) = flat_field(&sensor, &exposure, 0.0);
    let (gain, n) = (sensor.system_gain(&exposure), (SIDE * SIDE / binning.pixels()) as f64);

    // A variance of n pairs is known to √(2/n), of Poisson numbers a little worse; 5 σ.
    let tolerance = 5.0 * (2.2 / n).sqrt() * low_variance.hypot(high_variance) / (high - low);
    let found = (high_variance - low_variance) / (high - low);
    assert!((found - gain).abs() < tolerance, "K = {found} ± {tolerance}, not {gain}");
    assert!(tolerance < 0.2 * gain, "the test could not tell");

    // Rounding adds up to 1/12 for each of two roundings of a number of at least 1/4 DN/e⁻: 1/600 of 20² e⁻.
    let read = (sensor.read_noise(&exposure).0 * gain).powi(2);
    assert!((dark_variance / read - 1.0).abs() < 5.0 * (2.2 / n).sqrt() + 1.0 / 300.0, "{dark_variance} for {read}");

    let light = flat(&sensor, SIDE, SIDE, levels_e[1] * scale);
    let (raw, maps) =
        expose_with_maps(&light, &sensor, &exposure, Stages::ALL, NoiseKey::default(), &[NoiseMap::PhotoElectronsE])
            .expect("a valid exposure");
    // Numbers are rounded evenly, so that their mean is known to σ/√n; 5 σ.
    let photo = f64::from(maps.planes.plane("photo_electrons_e").expect("the map")[0]);
    assert_eq!(photo, f64::from(levels_e[1] * scale) * binning.pixels() as f64);
    assert_eq!(maps.system_gain, gain);
    let error = 5.0 * (high_variance / n).sqrt() + 0.01;
    assert!((high - dark - gain * photo).abs() < error, "{high} − {dark} for {photo} e⁻");

    // A white level is the nearest number.
    let range = f64::from(raw.white_level_dn) - 1000.0;
    let capacity = sensor.saturation_capacity(&exposure).0;
    assert!((range - gain * capacity).abs() <= 0.5 + 1e-6 * range, "{range} DN for {capacity} e⁻");
    let [slope, offset] = raw.metadata.noise_profile[0];
    assert!((slope * range / gain - 1.0).abs() < 1e-12, "NoiseProfile: {} DN/e⁻ for {gain}", slope * range);
    assert!((offset * range * range / dark_variance - 1.0).abs() < 5.0 * (2.2 / n).sqrt() + 0.01);
}
