//! Charge-coupled devices as a whole: what transfer, smear, blooming and the wells beside the pixels do to an image.

use photosite::image::Planes;
use photosite::raw::RawImage;
use photosite::sensor::{
    Architecture, Ccd, CcdArchitecture, Exposure, MaskedPixels, NoiseKey, Overscan, SensorModel, Stage, Stages, expose,
    presets,
};
use photosite::units::{Electrons, Seconds};

use crate::sensor_cases::{EXPOSURE, flat, ideal_ccd, quiet_sensor};

const WIDTH: usize = 40;
const HEIGHT: usize = 60;
const BLACK: f64 = 1000.0;

fn ccd(ccd: Ccd) -> SensorModel {
    SensorModel { architecture: Architecture::Ccd(ccd), ..quiet_sensor() }
}

/// Light on single pixels: column, row, electrons.
fn spots(sensor: &SensorModel, spots: &[(usize, usize, f32)]) -> Planes {
    let mut light = flat(sensor, WIDTH, HEIGHT, 0.0);
    for &(x, y, mean_e) in spots {
        light.channels_mut()[0].data[y * WIDTH + x] = mean_e;
    }
    light
}

fn image(light: &Planes, sensor: &SensorModel, stages: &[Stage]) -> RawImage {
    expose(light, sensor, &EXPOSURE, Stages::only(stages), NoiseKey { seed: 8, frame: 0 }).expect("valid")
}

/// Electrons of a number, at 1 DN/e⁻.
fn electrons(raw: &RawImage, x: usize, y: usize) -> f64 {
    f64::from(raw.data[y * raw.width + x]) - BLACK
}

fn total(raw: &RawImage) -> f64 {
    raw.data.iter().map(|&dn| f64::from(dn) - BLACK).sum()
}

/// P(k) = C(n + k − 1, k)·(1 − ε)ⁿ·εᵏ, by the logarithms of its factors.
fn negative_binomial(n: usize, k: usize, inefficiency: f64) -> f64 {
    let choose: f64 = (1..=k).map(|i| ((n + i - 1) as f64 / i as f64).ln()).sum();
    (choose + n as f64 * (-inefficiency).ln_1p() + k as f64 * inefficiency.ln()).exp()
}

/// A trail must hold Q·P(k): binomial counts, 5 σ, and 5 electrons for those so rare that they are Poisson's.
fn assert_trail(trail: impl Iterator<Item = f64>, charge_e: f64, shifts: usize, inefficiency: f64) {
    for (k, found) in trail.enumerate() {
        let p = negative_binomial(shifts, k, inefficiency);
        let expected = charge_e * p;
        let spread = 5.0 * (expected * (1.0 - p)).sqrt() + 5.0;
        assert!((found - expected).abs() < spread, "{k} behind, {shifts} shifts: {found} for {expected}");
    }
}

#[test]
fn a_spot_trails_behind_as_its_number_of_shifts_says() {
    let overscan = Overscan { prescan_columns: 3, columns: 8, rows: 10 };
    let (x, y, charge_e) = (25, 50, 50_000.0f32);
    for (architecture, vertical_shifts) in
        [(CcdArchitecture::Interline, y + 1), (CcdArchitecture::FrameTransfer, y + 1 + HEIGHT)]
    {
        let inefficiency = 4e-3;
        let base = Ccd { architecture, overscan, ..ideal_ccd() };
        let sensor = ccd(Ccd { vertical_inefficiency: inefficiency, ..base.clone() });
        let light = spots(&sensor, &[(x, y, charge_e)]);
        let raw = image(&light, &sensor, &[Stage::VerticalTransfer]);
        assert_eq!((raw.width, raw.height), (WIDTH + 3 + 8, HEIGHT + 10));
        let trail = (y..raw.height).map(|row| electrons(&raw, x + 3, row));
        assert_trail(trail, charge_e.into(), vertical_shifts, inefficiency);
        assert_eq!(total(&raw), f64::from(charge_e), "no electron is lost");

        let sensor = ccd(Ccd { horizontal_inefficiency: inefficiency, ..base });
        let raw = image(&light, &sensor, &[Stage::HorizontalTransfer]);
        let trail = (x + 3..raw.width).map(|column| electrons(&raw, column, y));
        assert_trail(trail, charge_e.into(), 3 + x + 1, inefficiency);
        assert_eq!(total(&raw), f64::from(charge_e), "no electron is lost");
    }
}

#[test]
fn overscan_tells_the_inefficiency() {
    // Extended pixel edge response (Janesick 2001, §5.3.3): CTI = deferred charge / (charge of the last row · shifts).
    let inefficiency = 2e-4;
    let overscan = Overscan { rows: 12, ..Overscan::default() };
    let sensor = ccd(Ccd { vertical_inefficiency: inefficiency, overscan, ..ideal_ccd() });
    let raw = image(&flat(&sensor, WIDTH, HEIGHT, 40_000.0), &sensor, &[Stage::VerticalTransfer]);
    let row = |y: usize| (0..WIDTH).map(|x| electrons(&raw, x, y)).sum::<f64>();
    let deferred: f64 = (HEIGHT..HEIGHT + 12).map(row).sum();
    let found = deferred / (row(HEIGHT - 1) * HEIGHT as f64);
    // 60·2e-4·40 000·40 = 19 200 electrons are deferred: 5 σ of their number, and the second order, ε·N = 1.2 %.
    assert!((found / inefficiency - 1.0).abs() < 5.0 / 19_200f64.sqrt() + 0.012, "{found}");
}

#[test]
fn smear_of_an_interline_sensor_is_what_its_data_sheet_says() {
    for smear_db in [-80.0f64, -60.0] {
        let line_time = Seconds(20e-6);
        let smear_row_time = Seconds(10.0 * 10f64.powf(smear_db / 20.0) * line_time.0);
        let sensor = ccd(Ccd { smear_row_time, ..ideal_ccd() });
        let mut light = flat(&sensor, WIDTH, HEIGHT, 0.0);
        light.channels_mut()[0].data[24 * WIDTH..30 * WIDTH].fill(50_000.0);
        // Read in the time of the exposure, as the measurement asks for, and a quarter of it: four times the smear.
        for (part, times) in [(1.0, 1.0), (0.25, 4.0)] {
            let exposure = Exposure { time: Seconds(part * line_time.0 * HEIGHT as f64), ..EXPOSURE };
            let stages = Stages::only(&[Stage::Smear]);
            let raw = expose(&light, &sensor, &exposure, stages, NoiseKey::default()).expect("valid");
            let expected = times * 50_000.0 * 10f64.powf(smear_db / 20.0);
            assert!((electrons(&raw, 7, 3) - expected).abs() <= 0.5, "{} for {expected}", electrons(&raw, 7, 3));
        }
    }
}

#[test]
fn smear_conserves_the_light_of_the_shift() {
    let sensor = ccd(Ccd {
        architecture: CcdArchitecture::FrameTransfer,
        smear_row_time: Seconds(1.0 / 1024.0),
        overscan: Overscan { rows: 2, ..Overscan::default() },
        ..ideal_ccd()
    });
    let raw = image(&spots(&sensor, &[(4, 30, 20_480.0), (4, 31, 10_240.0)]), &sensor, &[Stage::Smear]);
    // A row passes all others of its column: 20 and 10 electrons; wells from beyond pass all.
    assert_eq!([electrons(&raw, 4, 0), electrons(&raw, 4, 30), electrons(&raw, 4, 31)], [30.0, 20_490.0, 10_260.0]);
    assert_eq!([electrons(&raw, 4, HEIGHT), electrons(&raw, 5, 30)], [30.0, 0.0]);
    let added = (HEIGHT - 1 + 2) as f64 * 30.0 + 30.0 - 30.0;
    assert_eq!(total(&raw), 30_720.0 + added, "each spot is collected in every other row, and twice beyond");
}

#[test]
fn blooming_fills_the_column_and_keeps_its_charge() {
    let mut sensor = ccd(ideal_ccd());
    sensor.full_well = Electrons(10_000.0);
    let light = spots(&sensor, &[(9, 30, 73_000.0), (20, 20, 9000.0)]);
    let stages = [Stage::Blooming, Stage::FullWell];
    let raw = image(&light, &sensor, &stages);
    assert_eq!(total(&raw), 82_000.0);
    let full = (0..HEIGHT).filter(|&y| electrons(&raw, 9, y) == 10_000.0).count();
    // 63 000 electrons overflow, 31 500 to either side: three full wells and 1500 electrons.
    assert_eq!((full, electrons(&raw, 9, 26), electrons(&raw, 9, 34)), (7, 1500.0, 1500.0));
    assert_eq!(electrons(&raw, 8, 30), 0.0, "channel stops keep the neighbouring columns dark");
    // Without the effect the same light is lost.
    assert_eq!(total(&image(&light, &sensor, &[Stage::FullWell])), 19_000.0);
    // A drain up to five times the full well takes 40 000 electrons of it.
    sensor.architecture = Architecture::Ccd(Ccd { anti_blooming_factor: 5.0, ..ideal_ccd() });
    assert_eq!(total(&image(&light, &sensor, &stages)), 42_000.0);
}

#[test]
fn masked_pixels_surround_the_image_and_see_no_light() {
    for preset in ["generic-cmos-color", "generic-stacked-color"] {
        let bare = presets::model(preset).expect("a preset");
        let masked = SensorModel { masked: MaskedPixels { columns: [5, 2], rows: [3, 1] }, ..bare.clone() };
        let mut light = flat(&bare, 12, 9, 0.0);
        for (c, channel) in light.channels_mut().iter_mut().enumerate() {
            channel.data.iter_mut().enumerate().for_each(|(i, e)| *e = (100 * i + 2000 * c) as f32);
        }
        let expect = |sensor| expose(&light, sensor, &EXPOSURE, Stages::NONE, NoiseKey::default()).expect("valid");
        let (plain, raw) = (expect(&bare), expect(&masked));
        raw.validate().expect("an image whose parts belong together");
        assert_eq!((raw.width, raw.height), (12 + 7, 9 + 4));
        assert_eq!(raw.cropped(), plain, "{preset}: numbers and the phase of the tile");
        let dark = raw.data.iter().filter(|&&dn| dn == bare.converter.black_level_dn(Default::default())).count();
        let samples = bare.cfa.samples_per_pixel();
        assert!(dark >= (19 * 13 - 12 * 9) * samples, "{preset}: {dark}");
    }
    // Thermal electrons gather in them like in all others.
    let mut sensor = quiet_sensor();
    sensor.masked.rows = [50, 0];
    sensor.noise.dark_current_e_per_s = 400.0;
    let light = flat(&sensor, 100, 1, 5000.0);
    let raw = expose(&light, &sensor, &EXPOSURE, Stages::ALL, NoiseKey::default()).expect("valid");
    let mean = raw.data[..5000].iter().map(|&dn| f64::from(dn) - BLACK).sum::<f64>() / 5000.0;
    assert!((mean - 400.0).abs() < 5.0 * (400.0f64 / 5000.0).sqrt(), "{mean}");
}

#[test]
fn the_chips_of_a_camera_have_noise_of_their_own() {
    let sensor = presets::model("generic-three-chip-ccd").expect("a preset");
    let light = flat(&sensor, 64, 64, 5000.0);
    let raw = expose(&light, &sensor, &EXPOSURE, Stages::ALL, NoiseKey::default()).expect("valid").cropped();
    let chip = |c: usize| raw.data.iter().skip(c).step_by(3).map(|&dn| f64::from(dn)).collect::<Vec<_>>();
    let [a, b] = [chip(0), chip(1)];
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(&a), mean(&b));
    let covariance = |u: &[f64], mu: f64, v: &[f64], mv: f64| {
        u.iter().zip(v).map(|(x, y)| (x - mu) * (y - mv)).sum::<f64>() / u.len() as f64
    };
    let correlation = covariance(&a, ma, &b, mb) / (covariance(&a, ma, &a, ma) * covariance(&b, mb, &b, mb)).sqrt();
    // Of 4096 independent pairs: standard deviation 1/64; 5 σ.
    assert!(correlation.abs() < 5.0 / 64.0, "{correlation}");
}
