//! Dark current: heat frees electrons, too, at a rate that doubles every few kelvin.

use rand::distr::Distribution;
use rand_distr::Poisson;

use crate::units::{Celsius, Electrons, Seconds};

use super::charge_plane::{Row, RowStage};
use super::expose::Frame;
use super::model::Noise;
use super::noise_key::Streams;
use super::stage::Stage;

impl Noise {
    /// Dark current at a temperature, e⁻/s:
    ///
    /// I(T) = I(T_ref) · 2^((T − T_ref)/ΔT)
    ///
    /// with the doubling interval ΔT in K ([Emva1288](crate::references#emva1288), dark current).
    pub fn dark_current(&self, temperature: Celsius) -> f64 {
        let doublings = (temperature.0 - self.dark_current_reference.0) / self.dark_current_doubling_k;
        self.dark_current_e_per_s * doublings.exp2()
    }

    /// Mean thermal electrons of an exposure, μ_d = I(T)·t.
    pub fn dark_electrons(&self, temperature: Celsius, time: Seconds) -> Electrons {
        Electrons(self.dark_current(temperature) * time.0)
    }
}

/// Adds thermal electrons, which have shot noise of their own.
#[derive(Clone, Copy, Debug)]
pub(super) struct DarkCurrent {
    /// The same for all pixels, so prepared once.
    distribution: Poisson<f64>,
    streams: Streams,
}

impl DarkCurrent {
    pub(super) fn new(frame: &Frame<'_>) -> Option<Self> {
        let Frame { sensor, exposure, .. } = frame;
        let mean = sensor.noise.dark_electrons(exposure.temperature, exposure.time);
        let streams = frame.temporal(Stage::DarkCurrent)?;
        // More than the distribution can take fills any well; without any dark current there is no distribution.
        let distribution = Poisson::new(mean.0.min(Poisson::<f64>::MAX_LAMBDA)).ok()?;
        Some(Self { distribution, streams })
    }
}

impl RowStage for DarkCurrent {
    /// The charge with thermal electrons added.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        for (x, charge) in row.values.iter_mut().enumerate() {
            *charge += self.distribution.sample(&mut self.streams.pixel(x, row.y)) as f32;
        }
    }
}
