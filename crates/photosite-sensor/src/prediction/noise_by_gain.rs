//! Noise of a sensor over its gains in digital numbers: the parameters by which raw denoisers are trained, and the lines
//! of log σ against log K on which they lie ([Wei20](photosite_core::references#wei20), section 4).

use serde::Serialize;

use photosite_core::Invalid;
use photosite_core::units::Electrons;

use crate::{Exposure, SensorModel};

/// Noise at one analogue gain. Standard deviations are those of digital numbers, DN.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NoiseAtGain {
    /// Analogue gain, dB.
    pub gain_db: f64,
    /// Saturation-based ISO speed of this gain; `None` of logarithmic sensors.
    pub iso: Option<f64>,
    /// System gain K, DN/e⁻.
    pub system_gain_dn_per_e: f64,
    /// Temporal noise of the read-out of a pixel, σ_read·K.
    pub read_noise_dn: f64,
    /// Temporal noise that a row shares.
    pub row_noise_dn: f64,
    /// Temporal noise that a column shares.
    pub column_noise_dn: f64,
    /// Fixed pattern of the dark signal, of pixels, rows and columns together.
    pub dsnu_dn: f64,
    /// Rounding to whole numbers, 1/√12.
    pub quantisation_dn: f64,
    /// All temporal noise without light at the exposure time: the above with dark current, reset noise, flicker and
    /// telegraph signals; by [`SensorModel::noise_variance`].
    pub dark_noise_dn: f64,
    /// Number of no light.
    pub black_level_dn: u16,
    /// Smallest number of a saturated pixel.
    pub white_level_dn: u16,
    /// Charge that saturates a pixel, e⁻.
    pub saturation_e: f64,
    /// S and O of the variance S·x + O of the normalised signal x, as a DNG file has them in NoiseProfile; `None` of
    /// sensors whose noise has another form.
    pub noise_profile: Option<[f64; 2]>,
}

/// Line ln σ = slope · ln K + intercept through standard deviations in DN over the system gain in DN/e⁻.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GainLine {
    /// Change of ln σ with ln K: 1 of noise that is there before the gain, 0 of noise behind it.
    pub slope: f64,
    /// ln σ at K = 1 DN/e⁻.
    pub intercept: f64,
    /// Standard deviation of ln σ about the line.
    pub scatter: f64,
}

impl SensorModel {
    /// Noise at the gain of an exposure, whose time and temperature the dark current goes by.
    ///
    /// # Errors
    ///
    /// An exposure that the sensor cannot do.
    pub fn noise_at_gain(&self, exposure: &Exposure) -> Result<NoiseAtGain, Invalid> {
        exposure.validate(self)?;
        let gain = self.system_gain(exposure);
        let noise = self.noise.read_out.at(exposure.gain);
        Ok(NoiseAtGain {
            gain_db: exposure.gain.0,
            iso: self.iso(exposure),
            system_gain_dn_per_e: gain,
            read_noise_dn: noise.read.0 * gain,
            row_noise_dn: noise.row.0 * gain,
            column_noise_dn: noise.column.0 * gain,
            dsnu_dn: noise.dsnu.total() * gain,
            quantisation_dn: 12.0_f64.sqrt().recip(),
            dark_noise_dn: self.noise_variance(Electrons(0.0), exposure).sqrt() * gain,
            black_level_dn: self.converter.black_level_dn(exposure.gain),
            white_level_dn: self.white_level_dn(exposure),
            saturation_e: self.pixel_saturation(exposure).0,
            noise_profile: self.noise_profile(exposure),
        })
    }
}

impl GainLine {
    /// Line of least squares through a figure of several gains; `None` of fewer than two gains, and of noise that is not
    /// there.
    pub fn fit(rows: &[NoiseAtGain], figure: impl Fn(&NoiseAtGain) -> f64) -> Option<Self> {
        let points: Vec<[f64; 2]> = rows.iter().map(|row| [row.system_gain_dn_per_e.ln(), figure(row).ln()]).collect();
        let n = points.len() as f64;
        let [x, y] = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / n);
        let squares: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
        let slope = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum::<f64>() / squares;
        let left: f64 = points.iter().map(|point| (point[1] - y - slope * (point[0] - x)).powi(2)).sum();
        (squares > 0.0 && slope.is_finite()).then(|| Self {
            slope,
            intercept: y - slope * x,
            scatter: (left / (n - 2.0).max(1.0)).sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use photosite_core::units::{Decibels, Seconds};

    use super::*;
    use crate::model::{GainStepDescription, ReadOutNoise, ReadOutNoiseByGain};
    use crate::presets;

    fn rows(sensor: &SensorModel, gains: &[f64]) -> Vec<NoiseAtGain> {
        let at = |&gain: &f64| Exposure { gain: Decibels(gain), ..Exposure::of(Seconds(0.01)) };
        gains.iter().map(|gain| sensor.noise_at_gain(&at(gain)).expect("a gain that it has")).collect()
    }

    /// Electrons that are there before the gain lie on a line of slope 1, whose value at K = 1 is their logarithm.
    #[test]
    fn noise_before_the_gain_rises_with_it() {
        let sensor = presets::model("sony-imx249-mono").expect("a preset");
        let most = sensor.converter.gain_range[1].0;
        let rows = rows(&sensor, &[0.0, most / 3.0, most]);
        let line = GainLine::fit(&rows, |row| row.read_noise_dn).expect("a line");
        let read = sensor.noise.read_out.at(Decibels(0.0)).read.0;
        assert!((line.slope - 1.0).abs() < 1e-12 && (line.intercept - read.ln()).abs() < 1e-12, "{line:?}");
        assert!(line.scatter < 1e-12);
        // S = K/(white − black).
        for row in &rows {
            let [s, o] = row.noise_profile.expect("a straight response");
            let range = f64::from(row.white_level_dn - row.black_level_dn);
            assert!((s - row.system_gain_dn_per_e / range).abs() < 1e-12 * s);
            assert!((o.sqrt() * range - row.dark_noise_dn).abs() < 1e-9 * row.dark_noise_dn);
        }
    }

    /// Steps whose noise in electrons falls by as much as the gain rises are noise behind it: a line of slope 0.
    #[test]
    fn noise_behind_the_gain_stays() {
        let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
        let most = sensor.converter.gain_range[1];
        let step = |gain: Decibels| GainStepDescription {
            gain_db: gain.0,
            read_noise_e: Some(6.0 / gain.factor()),
            ..GainStepDescription::default()
        };
        let steps = [step(Decibels(0.0)), step(most)];
        sensor.noise.read_out = ReadOutNoiseByGain::new(ReadOutNoise::NONE, &steps).expect("steps");
        let rows = rows(&sensor, &[0.0, most.0 / 2.0, most.0]);
        let line = GainLine::fit(&rows, |row| row.read_noise_dn).expect("a line");
        assert!(line.slope.abs() < 1e-9, "{line:?}");
        assert_eq!(GainLine::fit(&rows, |row| row.row_noise_dn), None);
        assert_eq!(GainLine::fit(&rows[..1], |row| row.read_noise_dn), None);
    }
}
