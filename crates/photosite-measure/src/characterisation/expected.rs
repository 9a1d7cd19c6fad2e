//! Expected figures: those that an exact measurement of a sensor's model finds, the truth behind an image set.

use photosite_core::units::{Electrons, Seconds};
use photosite_sensor::{FixedPattern, SensorModel};

use super::descriptor::Light;
use super::efficiency::quantum_efficiency;
use super::evaluation::{TemporalPoint, evaluate};
use super::figures::{Figures, SpatialFigures, sensitivity_threshold_e};
use super::plan::{OperatingPoint, Plan, Shot};

/// The figures of the sensor at an operating point, from the images of a plan. Non-uniformity is that of its stacks,
/// during whose exposure an uneven dark current adds to that of the dark signal.
///
/// Where the converter's range ends before the full well, that is what saturates. No linearity error is expected of a
/// linear sensor, and of the dark current the mean and the variance tell the same. Amplifiers or converters that bend
/// have other gains at other signals, and the second of two gains adds noise of its own to bright images alone, which K
/// takes for the light's: of such sensors the figures are those that the standard's evaluation finds in the exact means
/// and variances of the plan's images.
pub fn expected_figures(sensor: &SensorModel, point: &OperatingPoint, plan: &Plan) -> Figures {
    let linear = linear_figures(sensor, point, plan.half_time);
    if !sensor.is_nonlinear() {
        return linear;
    }
    let Ok(found) = evaluate(exact_points(sensor, point, &plan.shots), &[], None) else { return linear };
    let found = found.figures;
    let scale = linear.system_gain_dn_per_e / found.system_gain_dn_per_e;
    let scaled = |figure: Option<f64>| figure.map(|e| e * scale);
    let SpatialFigures { total, row, column, pixel } = linear.dsnu_e;
    let dsnu_e =
        SpatialFigures { total: scaled(total), row: scaled(row), column: scaled(column), pixel: scaled(pixel) };
    // The evaluation knows saturation to a step of the plan only; photons are counted whatever the amplifiers do.
    let saturation_e = linear.saturation_p * found.quantum_efficiency;
    Figures {
        saturation_e,
        saturation_p: linear.saturation_p,
        snr_max: saturation_e.sqrt(),
        dynamic_range: saturation_e / found.sensitivity_threshold_e,
        dsnu_e,
        prnu_percent: linear.prnu_percent,
        ..found
    }
}

/// Keys of the effects that a sensor has and [`expected_figures`] leaves out, which has no closed form for them:
/// defective pixels and numbers, steps of unequal width, pixels that repel each other's charge.
pub fn effects_left_out(sensor: &SensorModel) -> Vec<&'static str> {
    let SensorModel { noise, converter, brighter_fatter_per_e, .. } = sensor;
    let effects = [
        ("defects.dead_per_million", noise.defects.dead > 0.0),
        ("defects.stuck_per_million", noise.defects.stuck > 0.0),
        ("noise.transmission_errors_per_million", noise.transmission_errors > 0.0),
        ("adc.dnl_dn", converter.dnl_dn > 0.0),
        ("charge.brighter_fatter_per_e", brighter_fatter_per_e.iter().any(|&a| a > 0.0)),
    ];
    effects.into_iter().filter(|(_, is_there)| *is_there).map(|(key, _)| key).collect()
}

/// Means and variances of the plan's pairs, over infinitely many pixels: rounded, and clipped near saturation, which
/// decides where the evaluation finds it.
fn exact_points(sensor: &SensorModel, point: &OperatingPoint, shots: &[Shot]) -> Vec<TemporalPoint> {
    let efficiency = quantum_efficiency(sensor, point.channel, point.wavelength_nm);
    // Patterns are wider than what they hide; numbers round within a standard deviation of a quiet sensor.
    let (pixels, samples) = (normal_numbers(0.25), normal_numbers(1.0 / 16.0));
    let dsnu_e = sensor.noise.read_out.at(point.gain).dsnu.total();
    let moments = |photons: f64, time: Seconds| {
        let exposure = point.exposure(time);
        let dark = sensor.noise.dark_electrons(point.temperature, time).0;
        let of_pixel = |deviation: f64| {
            let light = efficiency * photons * (1.0 + sensor.noise.prnu.total() * deviation);
            let charge = light + dark + dsnu_e * deviation;
            let noise = sensor.signal_variance(Electrons(light), &exposure).sqrt();
            let number = |z: f64| sensor.number(Electrons(charge + noise * z), point.gain);
            let numbers: Vec<(f64, f64)> = samples.iter().map(|&(z, part)| (number(z), part)).collect();
            let mean: f64 = numbers.iter().map(|(number, part)| part * number).sum();
            (mean, numbers.iter().map(|(number, part)| part * (number - mean).powi(2)).sum::<f64>())
        };
        pixels.iter().fold((0.0, 0.0), |(mean, variance), &(deviation, part)| {
            let (its_mean, its_variance) = of_pixel(deviation);
            (mean + part * its_mean, variance + part * its_variance)
        })
    };
    let bright = shots.iter().filter(|shot| shot.images == 2).filter_map(|shot| match shot.light {
        Light::Dark => None,
        Light::Bright { photons } => Some((shot.time, photons)),
    });
    let point = |(time, photons)| {
        let ((mean, variance), (dark_mean, dark_variance)) = (moments(photons, time), moments(0.0, time));
        TemporalPoint { time, photons, mean, variance, dark_mean, dark_variance }
    };
    bright.map(point).collect()
}

/// Values of a standard normal distribution, `step` apart, with their parts of all.
fn normal_numbers(step: f64) -> Vec<(f64, f64)> {
    let density = |z: f64| (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
    let last = (6.0 / step) as i32;
    (-last..=last).map(|i| step * f64::from(i)).map(|z| (z, step * density(z))).collect()
}

/// The figures of a sensor after the linear model.
fn linear_figures(sensor: &SensorModel, point: &OperatingPoint, spatial_time: Seconds) -> Figures {
    let gain = sensor.converter.system_gain(point.gain);
    let efficiency = quantum_efficiency(sensor, point.channel, point.wavelength_nm);
    // The variance at no exposure time, which includes quantisation's 1/(12·K²).
    let dark_variance = sensor.noise_variance(Electrons(0.0), &point.exposure(Seconds(0.0)));
    let quantisation = 1.0 / (12.0 * gain * gain);
    let saturation = sensor.saturation_capacity(&point.exposure(spatial_time)).0;
    let threshold = sensitivity_threshold_e(dark_variance.sqrt());
    // Hot pixels count with their part p of all: a mean of p·m, and of an exponential distribution a variance of p·(2 −
    // p)·m².
    let noise = &sensor.noise;
    let hot = |time| noise.hot_electrons(point.temperature, time).0;
    let part = noise.defects.hot;
    let dark_current = noise.dark_current(point.temperature) + part * hot(Seconds(1.0));
    let dark_electrons = noise.dark_electrons(point.temperature, spatial_time).0;
    let uneven_dark_current =
        (noise.dark_current_nonuniformity * dark_electrons).powi(2) + part * (2.0 - part) * hot(spatial_time).powi(2);
    // Amplifiers of columns that differ look like columns of pixels that do.
    let converter = &sensor.converter;
    let own = noise.read_out.at(point.gain).dsnu;
    let dsnu = FixedPattern {
        pixel: (own.pixel.powi(2) + uneven_dark_current).sqrt(),
        column: own.column.hypot(converter.column_offset_dn / gain),
        ..own
    };
    let prnu = FixedPattern { column: noise.prnu.column.hypot(converter.column_gain), ..noise.prnu };
    let pattern = |p: &FixedPattern, scale: f64| SpatialFigures {
        total: Some(scale * p.total()),
        row: Some(scale * p.row),
        column: Some(scale * p.column),
        pixel: Some(scale * p.pixel),
    };
    Figures {
        system_gain_dn_per_e: gain,
        responsivity_dn_per_p: gain * efficiency,
        quantum_efficiency: efficiency,
        dark_noise_e: (dark_variance - quantisation).max(0.0).sqrt(),
        dark_noise_dn: dark_variance.sqrt() * gain,
        saturation_e: saturation,
        saturation_p: saturation / efficiency,
        sensitivity_threshold_p: threshold / efficiency,
        sensitivity_threshold_e: threshold,
        snr_max: saturation.sqrt(),
        dynamic_range: saturation / threshold,
        dsnu_e: pattern(&dsnu, 1.0),
        prnu_percent: pattern(&prnu, 100.0),
        linearity_error_min_percent: Some(0.0),
        linearity_error_max_percent: Some(0.0),
        dark_current_mean_e_per_s: Some(dark_current),
        dark_current_variance_e_per_s: Some(dark_current),
        dark_current_mean_error_e_per_s: None,
        dark_current_variance_error_e_per_s: None,
    }
}
