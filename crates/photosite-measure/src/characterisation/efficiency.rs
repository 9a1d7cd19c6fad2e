//! Quantum efficiency of a channel: electrons per photon on a pixel.

use photosite_core::units::photon_energy;
use photosite_raw::Cfa;
use photosite_sensor::SensorModel;

/// Quantum efficiency η of a channel: electrons that its pixels collect per photon that falls on the whole area of a
/// pixel, whatever filters, microlenses, fill factor and neighbours (crosstalk) make of it. `channel` is one of the
/// sensor's.
pub fn quantum_efficiency(sensor: &SensorModel, channel: usize, wavelength_nm: f64) -> f64 {
    let [x, y] = first_place(&sensor.cfa, channel);
    sensor.collected(&freed_per_photon(sensor, wavelength_nm), x, y)
}

/// Electrons that a photon on a pixel frees in each of the sensor's channels, wherever they are collected. From the
/// response R of [`SensorModel::responses`], in e⁻/s for each W·m⁻²·nm⁻¹ and nm, and the pixel's area A, it is
/// R·(h·c/λ)/A.
pub(super) fn freed_per_photon(sensor: &SensorModel, wavelength_nm: f64) -> Vec<f64> {
    let per_photon = photon_energy(wavelength_nm) / sensor.pixel_area_m2();
    let responses = sensor.responses().into_iter();
    responses.map(|(_, response)| f64::from(response.eval(wavelength_nm as f32)) * per_photon).collect()
}

/// First place of a channel in the tile of the colour filter array.
pub(super) fn first_place(cfa: &Cfa, channel: usize) -> [usize; 2] {
    let (columns, rows) = cfa.tile_size();
    let places = (0..columns * rows).map(|i| [i % columns, i / columns]);
    places.filter(|&[x, y]| cfa.channel_at(x, y) == channel).min_by_key(|&[x, y]| (y, x)).unwrap_or_default()
}
