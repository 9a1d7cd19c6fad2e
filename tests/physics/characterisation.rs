//! Figures that EMVA 1288 recovers from images of a sensor's model, against what was put into it.

use photosite::characterisation::{
    Evaluation, FlatField, Light, OperatingPoint, PairStatistics, Plan, SpatialStack, TemporalPoint, evaluate,
    expected_figures, quantum_efficiency,
};
use photosite::raw::Cfa;
use photosite::sensor::{FixedPattern, Kernel, SensorModel, presets};
use photosite::units::{Celsius, Decibels};
use rstest::rstest;

const SIZE: [usize; 2] = [96, 80];
const PIXELS: f64 = 96.0 * 80.0;
const STEPS: u32 = 20;
const STACK: u32 = 12;

/// Takes all images of the linear camera model and evaluates them, without any file.
fn measure(sensor: &SensorModel, point: &OperatingPoint, plan: &Plan) -> Evaluation {
    let flat = FlatField::new(sensor, point, SIZE);
    let (mut points, mut stacks, mut dark) = (Vec::new(), Vec::new(), PairStatistics::default());
    let mut frame = 0;
    for shot in &plan.shots {
        let frames = frame..frame + u64::from(shot.images);
        frame += u64::from(shot.images);
        let images: Vec<Vec<u16>> =
            flat.images(shot.light.photons(), shot.time, 5, frames).map(|image| image.expect("a flat").data).collect();
        if shot.images > 2 {
            let mut stack = SpatialStack::new(SIZE[0], SIZE[1]);
            images.iter().for_each(|image| stack.add(image).expect("fits"));
            stacks.push(stack.variances().expect("images"));
            continue;
        }
        let pair = PairStatistics::new(&images[0], &images[1]).expect("a pair");
        match shot.light {
            Light::Dark => dark = pair,
            Light::Bright { photons } => points.push(TemporalPoint {
                time: shot.time,
                photons,
                mean: pair.mean,
                variance: pair.variance,
                dark_mean: dark.mean,
                dark_variance: dark.variance,
            }),
        }
    }
    evaluate(points, &[], <[_; 2]>::try_from(stacks).ok()).expect("a set")
}

/// Relative deviation in standard errors.
fn deviation(found: f64, expected: f64, relative_error: f64) -> f64 {
    (found / expected - 1.0) / relative_error
}

fn check(sensor: &SensorModel, channel: usize, wavelength_nm: f64, gain: Decibels) {
    let point = OperatingPoint { channel, wavelength_nm, gain, temperature: Celsius(35.0) };
    let plan = Plan::linear(sensor, &point, STEPS, STACK, None).expect("light to see");
    let found = measure(sensor, &point, &plan);
    let expected = expected_figures(sensor, &point, &plan);
    let f = found.figures;

    // Of a slope through the origin over 12 even points whose variance is that of a difference of n pixels,
    // 2·σ⁴/n with σ² = K·μ: √(2/n)·√Σi⁴/Σi², i to 12.
    let sums = |power: i32| (1..=12).map(|i| f64::from(i).powi(power)).sum::<f64>();
    let of_gain = (2.0 / PIXELS).sqrt() * sums(4).sqrt() / sums(2);
    // Of the offset of a line over 20 even points: 2/√20; of its slope: √(12/20)/span, where the dark variance doubles.
    let of_variance = (2.0 / PIXELS).sqrt();
    let of_dark_noise = 0.5 * of_variance * 2.0 / f64::from(STEPS).sqrt() * 1.5;
    let of_dark_variance = of_variance * (12.0 / f64::from(STEPS)).sqrt() * 1.6;
    let dark_electrons = sensor.noise.dark_electrons(point.temperature, plan.half_time).0 * 2.0;
    let of_dark_mean =
        (2.0 * dark_electrons / (2.0 * PIXELS)).sqrt() * (12.0 / f64::from(STEPS)).sqrt() / dark_electrons;
    // Of a pattern, √(2/n)/2, more where temporal noise is left by averaging.
    let left = |total: f64, temporal: f64| 0.5 * of_variance * (1.0 + temporal / f64::from(STACK) / (total * total));
    let dark_temporal = f.dark_noise_e.powi(2) + dark_electrons;
    let of_dsnu = left(expected.dsnu_e.total.expect("known"), dark_temporal);
    let half = 0.5 * expected.saturation_e;
    let of_prnu = left(expected.prnu_percent.total.expect("known") / 100.0 * half, half);

    for (name, found, expected, error) in [
        ("K", f.system_gain_dn_per_e, expected.system_gain_dn_per_e, of_gain),
        ("η", f.quantum_efficiency, expected.quantum_efficiency, of_gain),
        ("σ_d", f.dark_noise_e, expected.dark_noise_e, of_dark_noise + of_gain),
        ("DSNU", f.dsnu_e.total.expect("a stack"), expected.dsnu_e.total.expect("known"), of_dsnu + of_gain),
        ("PRNU", f.prnu_percent.total.expect("a stack"), expected.prnu_percent.total.expect("known"), of_prnu),
        (
            "μ_I.mean",
            f.dark_current_mean_e_per_s.expect("times"),
            expected.dark_current_mean_e_per_s.expect("known"),
            of_dark_mean + of_gain,
        ),
        (
            "μ_I.var",
            f.dark_current_variance_e_per_s.expect("times"),
            expected.dark_current_variance_e_per_s.expect("known"),
            of_dark_variance + 2.0 * of_gain,
        ),
    ] {
        let sigmas = deviation(found, expected, error);
        assert!(
            sigmas.abs() < 4.0,
            "{}, channel {channel}: {name} is {found} instead of {expected}: {sigmas} σ",
            sensor.name
        );
    }
    // The noise of the dimmest point, at 5 %: √μ/μ over √(2n), about three of them.
    let noise = 100.0 * 4.0 / (0.05 * expected.saturation_e * 2.0 * PIXELS).sqrt();
    assert!(f.linearity_error_max_percent.expect("points") < noise);
    assert!(f.linearity_error_min_percent.expect("points") > -noise);
    // Saturation is told to a step of 5.5 %, and four standard deviations of the pixels below the capacity.
    let spread =
        4.0 * (expected.saturation_e.recip() + (expected.prnu_percent.total.expect("known") / 100.0).powi(2)).sqrt();
    let ratio = f.saturation_e / expected.saturation_e;
    assert!(ratio < 1.06 && ratio > 1.0 - spread - 0.06, "{ratio}");
}

#[test]
fn a_monochrome_sensor_is_recovered() {
    let sensor = presets::model("sony-imx249-mono").expect("a preset");
    check(&sensor, 0, 550.0, Decibels(0.0));
    check(&sensor, 0, 800.0, Decibels(6.0));
}

#[test]
fn every_channel_of_a_colour_sensor_is_recovered() {
    let mut sensor = presets::model("sony-imx249-color").expect("a preset");
    for (channel, wavelength_nm, cfa) in [(0, 620.0, "RGGB"), (1, 540.0, "GBRG"), (2, 460.0, "GRBG")] {
        sensor.cfa = Cfa::parse(cfa).expect("a Bayer phase");
        check(&sensor, channel, wavelength_nm, Decibels(0.0));
    }
}

#[rstest]
#[case::of_pixels([4.0, 0.0], [0.006, 0.0])]
#[case::of_amplifiers([2.0, 3.0], [0.004, 0.006])]
fn rows_and_columns_are_told_from_pixels(#[case] offsets_e: [f64; 2], #[case] gains: [f64; 2]) {
    let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
    sensor.noise.read_out.change(|noise| noise.dsnu = FixedPattern { pixel: 5.0, row: 3.0, column: offsets_e[0] });
    sensor.noise.prnu = FixedPattern { pixel: 0.01, row: 0.004, column: gains[0] };
    sensor.converter.column_offset_dn = offsets_e[1] * sensor.converter.conversion_gain_dn_per_e;
    sensor.converter.column_gain = gains[1];
    let point = OperatingPoint { channel: 0, wavelength_nm: 550.0, gain: Decibels(0.0), temperature: Celsius(25.0) };
    let plan = Plan::linear(&sensor, &point, STEPS, STACK, None).expect("light to see");
    let found = measure(&sensor, &point, &plan).figures;
    let expected = expected_figures(&sensor, &point, &plan);
    // Rows and columns are few: their spread is known to √(2/80)/2 = 8 % and √(2/96)/2 = 7 %, pixels to 0.8 %; 4 times
    // that, and twice for what one pattern leaves in the other.
    for (name, found, expected) in
        [("DSNU", found.dsnu_e, expected.dsnu_e), ("PRNU", found.prnu_percent, expected.prnu_percent)]
    {
        for (part, found, expected, within) in [
            ("rows", found.row, expected.row, 0.4),
            ("columns", found.column, expected.column, 0.4),
            ("pixels", found.pixel, expected.pixel, 0.04),
        ] {
            let ratio = found.expect("a pattern") / expected.expect("known");
            assert!((ratio - 1.0).abs() < within, "{name} of {part}: {found:?} instead of {expected:?}");
        }
    }
}

#[test]
fn nonlinear_amplifiers_and_converters_are_expected_to_bend() {
    let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
    let point = OperatingPoint { channel: 0, wavelength_nm: 550.0, gain: Decibels(0.0), temperature: Celsius(25.0) };
    for (amplifier, inl_dn) in [(vec![-0.04], 0.0), (vec![0.01, -0.03], 0.0), (vec![], 15.0)] {
        sensor.converter.amplifier_nonlinearity = amplifier;
        sensor.converter.inl_dn = inl_dn;
        let plan = Plan::linear(&sensor, &point, STEPS, STACK, None).expect("light to see");
        let found = measure(&sensor, &point, &plan).figures;
        let expected = expected_figures(&sensor, &point, &plan);
        // The dimmest point, at 5 %, has a relative error of √μ/μ/√n, and pulls the line with it: in all three of it.
        let noise = 100.0 * 3.0 / (0.05 * expected.saturation_e * PIXELS).sqrt();
        for (found, expected) in [
            (found.linearity_error_min_percent, expected.linearity_error_min_percent),
            (found.linearity_error_max_percent, expected.linearity_error_max_percent),
        ] {
            let (found, expected) = (found.expect("points"), expected.expect("points"));
            assert!((found - expected).abs() < noise, "{found} % for {expected} % ± {noise}");
            assert!(expected.abs() > 2.0 * noise, "{expected} % would be lost in the noise of {noise} %");
        }
        let sums = |power: i32| (1..=12).map(|i| f64::from(i).powi(power)).sum::<f64>();
        let of_gain = (2.0 / PIXELS).sqrt() * sums(4).sqrt() / sums(2);
        let gains = (found.system_gain_dn_per_e, expected.system_gain_dn_per_e);
        assert!(deviation(gains.0, gains.1, of_gain).abs() < 4.0, "{gains:?}");
    }
}

#[test]
fn crosstalk_is_part_of_the_quantum_efficiency() {
    let mut sensor = presets::model("sony-imx249-color").expect("a preset");
    let plain = quantum_efficiency(&sensor, 0, 540.0);
    // Of a red pixel in light that green ones see: the kernel leaves it 0.9 and brings it a tenth of its green
    // neighbours.
    let parts = [[0.0, 0.03, 0.0], [0.02, 0.9, 0.02], [0.0, 0.03, 0.0]].map(|row| row.to_vec());
    sensor.crosstalk = Some(vec![Kernel::new(&parts).expect("a kernel"); 3]);
    let expected = quantum_efficiency(&sensor, 0, 540.0);
    let green = sensor.efficiencies()[1].eval(540.0);
    assert!((expected - (0.9 * plain + 0.1 * f64::from(green))).abs() < 1e-6, "{expected}");
    check(&sensor, 0, 540.0, Decibels(0.0));
}
