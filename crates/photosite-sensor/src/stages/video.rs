//! The analogue signal on its way to the converter: the curve of its amplifier, and the bandwidth of its line, which
//! noise that came before shares.

use super::frame::Frame;
use crate::model::{LowPass, VideoCurve};
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::{Exposure, SensorModel};

impl SensorModel {
    /// The number above the black level of a signal, e⁻ of the pixel that is read out, at an exposure's gains: a digital
    /// gain multiplies what the curve has bent.
    pub(crate) fn number_of_signal(&self, signal_e: f64, exposure: &Exposure) -> f64 {
        let number = signal_e * self.system_gain(exposure);
        let digital = exposure.digital_gain.factor();
        self.video.curve.map_or(number, |curve| curve.bent(number / digital) * digital)
    }

    /// The signal behind a number above the black level, the inverse of [`Self::number_of_signal`].
    pub(crate) fn signal_of_number(&self, number_dn: f64, exposure: &Exposure) -> f64 {
        let digital = exposure.digital_gain.factor();
        let number = self.video.curve.map_or(number_dn, |curve| curve.straightened(number_dn / digital) * digital);
        number / self.system_gain(exposure)
    }
}

impl VideoCurve {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        frame.sensor.video.curve
    }
}

impl RowStage for VideoCurve {
    const MAP: NoiseMap = NoiseMap::VideoCurveDn;

    /// i = R·(y/R)^γ of signals in DN.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        row.values.iter_mut().for_each(|value| *value = self.bent((*value).into()) as f32);
    }
}

/// The bandwidth of the line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VideoBandwidth {
    low_pass: LowPass,
    /// Lines side by side: one for each detector of a pixel.
    lines: usize,
}

impl VideoBandwidth {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let low_pass = frame.sensor.video.low_pass.filter(|_| frame.stages.has(Stage::VideoBandwidth))?;
        Some(Self { low_pass, lines: frame.sensor.cfa.samples_per_pixel() })
    }
}

impl RowStage for VideoBandwidth {
    const MAP: NoiseMap = Stage::VideoBandwidth.map();

    /// y_k = a·y_{k−1} + (1 − a)·s_k; a row begins as if its first pixel had gone on for long.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        let missing = self.low_pass.missing;
        for line in 0..self.lines.min(row.values.len()) {
            let mut reached = f64::from(row.values[line]);
            for value in row.values[line..].iter_mut().step_by(self.lines) {
                reached = missing * reached + (1.0 - missing) * f64::from(*value);
                *value = reached as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_followed_exponentially_in_each_line() {
        let bandwidth = VideoBandwidth { low_pass: LowPass { missing: 0.5 }, lines: 2 };
        let mut values = [0.0, 8.0, 0.0, 8.0, 16.0, 8.0, 16.0, 0.0, 16.0, 0.0];
        bandwidth.apply(&mut Row { y: 0, values: &mut values });
        assert_eq!(values, [0.0, 8.0, 0.0, 8.0, 8.0, 8.0, 12.0, 4.0, 14.0, 2.0]);
    }
}
