//! What an exact measurement of a sensor's model finds: the truth behind an image set.

use crate::sensor::{FixedPattern, SensorModel};
use crate::units::{Electrons, Seconds, photon_energy};

use super::figures::{Figures, SpatialFigures, sensitivity_threshold_e};
use super::plan::OperatingPoint;

/// Quantum efficiency η of a channel: electrons per photon that falls on the whole area of a pixel, whatever filters,
/// microlenses and fill factor make of it. From the response R of [`SensorModel::responses`], in e⁻/s for each
/// W·m⁻²·nm⁻¹ and nm, and the pixel's area A, η = R·(h·c/λ)/A. `channel` is one of the sensor's.
pub fn quantum_efficiency(sensor: &SensorModel, channel: usize, wavelength_nm: f64) -> f64 {
    let response = sensor.responses().swap_remove(channel).1;
    f64::from(response.eval(wavelength_nm as f32)) * photon_energy(wavelength_nm) / sensor.pixel_area_m2()
}

/// The figures of the sensor at an operating point. Non-uniformity is that of exposures of `spatial_time`, during which an
/// uneven dark current adds to that of the dark signal.
///
/// Where the converter's range ends before the full well, that is what saturates. No linearity error is expected of a
/// linear sensor, and of the dark current the mean and the variance tell the same.
pub fn expected_figures(sensor: &SensorModel, point: &OperatingPoint, spatial_time: Seconds) -> Figures {
    let gain = sensor.converter.system_gain(point.gain);
    let efficiency = quantum_efficiency(sensor, point.channel, point.wavelength_nm);
    // The variance at no exposure time, which includes quantisation's 1/(12·K²).
    let dark_variance = sensor.noise_variance(Electrons(0.0), &point.exposure(Seconds(0.0)));
    let quantisation = 1.0 / (12.0 * gain * gain);
    let saturation = sensor.saturation_capacity(&point.exposure(spatial_time)).0;
    let threshold = sensitivity_threshold_e(dark_variance.sqrt());
    // Hot pixels count with their part p of all: a mean of p·m, and of an exponential distribution a variance of p·(2 − p)·m².
    let noise = &sensor.noise;
    let hot = |time| noise.hot_electrons(point.temperature, time).0;
    let part = noise.defects.hot;
    let dark_current = noise.dark_current(point.temperature) + part * hot(Seconds(1.0));
    let dark_electrons = noise.dark_electrons(point.temperature, spatial_time).0;
    let uneven_dark_current =
        (noise.dark_current_nonuniformity * dark_electrons).powi(2) + part * (2.0 - part) * hot(spatial_time).powi(2);
    let dsnu = FixedPattern { pixel: (noise.dsnu.pixel.powi(2) + uneven_dark_current).sqrt(), ..noise.dsnu };
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
        prnu_percent: pattern(&noise.prnu, 100.0),
        linearity_error_min_percent: Some(0.0),
        linearity_error_max_percent: Some(0.0),
        dark_current_mean_e_per_s: Some(dark_current),
        dark_current_variance_e_per_s: Some(dark_current),
    }
}
