//! Dark current: heat frees electrons, too, at a rate that doubles every few kelvin.

use rand::distr::Distribution;
use rand_distr::Poisson;

use crate::units::{Celsius, Electrons, Seconds};

use super::model::Noise;
use super::noise_key::{NoiseKey, NoiseStage, PixelStreams};

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
    /// The same for all pixels, so prepared once; `None` for no dark current.
    distribution: Option<Poisson<f64>>,
    streams: PixelStreams,
}

impl DarkCurrent {
    /// `mean`: thermal electrons of the exposure, finite. More than the distribution can take fills any well.
    pub(super) fn new(mean: Electrons, key: NoiseKey) -> Self {
        let distribution = Poisson::new(mean.0.min(Poisson::<f64>::MAX_LAMBDA)).ok();
        Self { distribution, streams: key.temporal(NoiseStage::DarkCurrent) }
    }

    /// The pixel's charge with thermal electrons added.
    #[inline]
    pub(super) fn apply(&self, charge_e: f64, pixel: usize) -> f64 {
        match &self.distribution {
            Some(distribution) => charge_e + distribution.sample(&mut self.streams.pixel(pixel)),
            None => charge_e,
        }
    }
}
