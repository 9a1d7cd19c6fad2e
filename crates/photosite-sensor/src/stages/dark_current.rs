//! Dark current: heat frees electrons, too, at a rate that rises steeply with temperature, and in some pixels at a much
//! higher one.

use rand::RngExt;
use rand_distr::{Exp1, Poisson, StandardNormal};

use photosite_core::units::{BOLTZMANN, Celsius, ELEMENTARY_CHARGE, Electrons, Seconds, ZERO_CELSIUS};

use super::frame::Frame;
use super::shot_noise::{Counts, poisson};
use crate::model::{DarkCurrentLaw, DefectivePixels, Noise, PixelDefect};
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;
use crate::signal::words::{LogNormalWords, StreamWords, Tables, Wide, words};

impl DarkCurrentLaw {
    /// Factor by which the dark current rises from one temperature to another. With temperatures T, in K where they are
    /// not subtracted, and k in eV/K:
    ///
    /// - doubling: 2^((T − T_ref)/ΔT) ([Emva1288](photosite_core::references#emva1288), dark current);
    /// - Arrhenius: (T/T_ref)^(3/2) · exp(E_g(T_ref)/(2k·T_ref) − E_g(T)/(2k·T))
    ///   ([Janesick01](photosite_core::references#janesick01), dark current of depleted silicon), with a constant band
    ///   gap or silicon's, E_g = 1.1557 − 7.021·10⁻⁴·T²/(T + 1108) eV
    ///   ([Varshni67](photosite_core::references#varshni67)).
    pub fn factor(&self, reference: Celsius, temperature: Celsius) -> f64 {
        match *self {
            Self::Doubling { interval_k } => ((temperature.0 - reference.0) / interval_k).exp2(),
            Self::Arrhenius { band_gap_ev } => {
                let [warm, cool] = [temperature, reference].map(|t| t.0 + ZERO_CELSIUS);
                let exponent = |kelvin: f64| {
                    let gap = band_gap_ev.unwrap_or(1.1557 - 7.021e-4 * kelvin * kelvin / (kelvin + 1108.0));
                    gap * ELEMENTARY_CHARGE / (2.0 * BOLTZMANN * kelvin)
                };
                (warm / cool).powf(1.5) * (exponent(cool) - exponent(warm)).exp()
            }
        }
    }
}

impl Noise {
    /// Mean dark current at a temperature, e⁻/s, of all pixels but the hot ones.
    pub fn dark_current(&self, temperature: Celsius) -> f64 {
        self.dark_current_e_per_s * self.dark_current_law.factor(self.dark_current_reference, temperature)
    }

    /// Mean thermal electrons of an exposure, μ_d = I(T)·t.
    pub fn dark_electrons(&self, temperature: Celsius, time: Seconds) -> Electrons {
        Electrons(self.dark_current(temperature) * time.0)
    }

    /// Mean thermal electrons of a hot pixel beyond those of the others, on average over hot pixels.
    pub fn hot_electrons(&self, temperature: Celsius, time: Seconds) -> Electrons {
        let factor = self.dark_current_law.factor(self.dark_current_reference, temperature);
        Electrons(self.defects.hot_dark_current_e_per_s * factor * time.0)
    }
}

/// Thermal electrons of each pixel on average.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DarkElectrons {
    mean: Electrons,
    nonuniformity: Option<Nonuniformity>,
}

impl DarkElectrons {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let Frame { sensor, exposure, stages, .. } = frame;
        let mean = sensor.noise.dark_electrons(exposure.temperature, exposure.time);
        stages.has(Stage::DarkCurrent).then(|| Self { mean, nonuniformity: Nonuniformity::new(frame) })
    }

    /// Over all pixels.
    pub(crate) fn mean(&self) -> f64 {
        self.mean.0
    }

    #[inline]
    pub(crate) fn of_pixel(&self, x: usize, y: usize) -> f64 {
        self.mean.0 * self.nonuniformity.map_or(1.0, |nonuniformity| nonuniformity.factor(x, y))
    }
}

/// Adds thermal electrons, which have shot noise of their own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DarkCurrent {
    pub(crate) electrons: DarkElectrons,
    /// Distribution of the electrons of pixels that are all alike, prepared once.
    alike: Counts,
    /// `None` for mean electrons.
    streams: Option<Streams>,
}

words! {
    /// Dark current: its mean electrons, the same in all pixels but for a factor of each.
    DarkCurrentWords {
        streams: StreamWords,
        mean: Wide,
        /// e^(−mean) in parts of 2⁶⁴.
        e_to_minus_mean_low: u32,
        e_to_minus_mean_high: u32,
        factors: LogNormalWords,
    }
}

/// Pixels whose dark current is the mean times exp(s·n − s²/2), n standard normal: log-normal, as the concentrations of
/// impurities are that cause it ([Konnik14](photosite_core::references#konnik14), dark current fixed pattern noise).
/// The mean of the factor is 1, its standard deviation √(exp(s²) − 1).
#[derive(Clone, Copy, Debug)]
struct Nonuniformity {
    s: f64,
    streams: Streams,
}

impl Nonuniformity {
    fn new(frame: &Frame<'_>) -> Option<Self> {
        let ratio = frame.sensor.noise.dark_current_nonuniformity;
        let streams = frame.fixed(Stage::DarkCurrentNonuniformity).filter(|_| ratio > 0.0)?;
        Some(Self { s: (ratio * ratio).ln_1p().sqrt(), streams })
    }

    /// Words of the factors.
    fn words(&self) -> LogNormalWords {
        let shift = 0.5 * self.s * self.s;
        LogNormalWords { streams: self.streams.words(), scale: Wide::new(self.s), shift: Wide::new(shift) }
    }

    #[inline]
    fn factor(&self, x: usize, y: usize) -> f64 {
        let normal: f64 = self.streams.pixel(x, y).sample(StandardNormal);
        (self.s * normal - 0.5 * self.s * self.s).exp()
    }
}

impl DarkCurrent {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let (electrons, streams) = (DarkElectrons::new(frame)?, frame.temporal(Stage::DarkCurrent));
        let mean = electrons.mean.0;
        // More than the distribution can take fills any well; without any dark current there is none.
        (mean > 0.0).then(|| Self { electrons, alike: Counts::new(mean.min(Poisson::<f64>::MAX_LAMBDA)), streams })
    }

    /// Words of the stage, which draws random numbers.
    pub(crate) fn words(&self) -> DarkCurrentWords {
        let mean = self.electrons.mean.0;
        // Rounding up to 1 ends at the largest number below it.
        let e_to_minus_mean = ((-mean).exp() * 2f64.powi(64)) as u64;
        DarkCurrentWords {
            streams: self.streams.map(|streams| streams.words()).unwrap_or_default(),
            mean: Wide::new(mean),
            e_to_minus_mean_low: e_to_minus_mean as u32,
            e_to_minus_mean_high: (e_to_minus_mean >> 32) as u32,
            factors: self.electrons.nonuniformity.map(|factors| factors.words()).unwrap_or_default(),
        }
    }
}

impl RowStage for DarkCurrent {
    const MAP: NoiseMap = Stage::DarkCurrent.map();

    /// The charge with thermal electrons added.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        let y = row.y;
        match (&self.streams, self.electrons.nonuniformity) {
            (None, _) => {
                let pixels = row.values.iter_mut().enumerate();
                pixels.for_each(|(x, charge)| *charge += self.electrons.of_pixel(x, y) as f32);
            }
            (Some(streams), None) => {
                streams.pixels(row, |_, charge, random| charge + self.alike.sample(random) as f32);
            }
            (Some(streams), Some(_)) => {
                streams.pixels(row, |x, charge, random| charge + poisson(self.electrons.of_pixel(x, y), random) as f32);
            }
        }
    }
}

/// Adds what some pixels have more: electrons at rates that follow an exponential distribution.
#[derive(Clone, Debug)]
pub(crate) struct HotPixels {
    part: f64,
    mean: Electrons,
    places: Streams,
    /// Pixels whose places are known, in place of random ones, and the electrons of each for 1 e⁻/s.
    known: Option<(DefectivePixels, f64)>,
    /// `None` for mean electrons.
    electrons: Option<Streams>,
}

impl HotPixels {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let Frame { sensor, exposure, .. } = frame;
        let mean = sensor.noise.hot_electrons(exposure.temperature, exposure.time);
        let places = frame.fixed(Stage::HotPixels).filter(|_| mean.0 > 0.0)?;
        let electrons = frame.temporal(Stage::HotPixels);
        let per_rate = mean.0 / sensor.noise.defects.hot_dark_current_e_per_s;
        let known = sensor.noise.defective_pixels.clone().map(|pixels| (pixels, per_rate));
        Some(Self { part: sensor.noise.defects.hot, mean, places, known, electrons })
    }

    /// The hot pixels of the first `width` of a row, and the electrons that each has more on average.
    pub(crate) fn of_row(&self, y: usize, width: usize) -> impl Iterator<Item = (usize, f64)> {
        let known = self.known.iter().flat_map(move |(pixels, per_rate)| {
            pixels.row(y).filter_map(move |(x, defect)| match defect {
                PixelDefect::Hot(rate) => Some((x, rate * per_rate)),
                PixelDefect::Dead | PixelDefect::Stuck(_) => None,
            })
        });
        let part = if self.known.is_some() { 0.0 } else { self.part };
        known.chain(self.places.chosen(part, y, width).map(move |x| {
            let rate: f64 = self.places.part(0).pixel(x, y).sample(Exp1);
            (x, rate * self.mean.0)
        }))
    }

    /// Electrons that a pixel has more in this frame, of a mean.
    fn electrons(&self, x: usize, y: usize, mean: f64) -> f32 {
        self.electrons.map_or(mean, |streams| poisson(mean, &mut streams.pixel(x, y))) as f32
    }

    /// Place of the pixels and their electrons in the tables.
    pub(crate) fn words(&self, frame: &Frame<'_>, tables: &mut Tables) -> u32 {
        let [width, height] = frame.size;
        let of_row = |y| self.of_row(y, width).map(move |(x, mean)| (x, self.electrons(x, y, mean).to_bits()));
        tables.add_pixels(height, of_row)
    }
}

impl RowStage for HotPixels {
    const MAP: NoiseMap = Stage::HotPixels.map();

    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        for (x, mean) in self.of_row(row.y, row.values.len()) {
            row.values[x] += self.electrons(x, row.y, mean);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silicon_doubles_about_every_eight_kelvin_at_room_temperature() {
        let law = DarkCurrentLaw::Arrhenius { band_gap_ev: None };
        // By hand: E_g(298.15 K) = 1.1557 − 62.4113/1406.15 = 1.111315 eV, E_g(308.15 K) = 1.1557 − 66.6681/1416.15 =
        // 1.108622 eV; /(2·8.617333e-5·T): 21.627158 and 20.874621; exp(0.752537)·(308.15/298.15)^1.5 =
        // 2.122377·1.050730 = 2.230044.
        let ten_kelvin = law.factor(Celsius(25.0), Celsius(35.0));
        assert!((ten_kelvin - 2.230_044).abs() < 1e-5, "{ten_kelvin}");
        assert_eq!(law.factor(Celsius(25.0), Celsius(25.0)), 1.0);
    }

    #[test]
    fn both_laws_agree_on_a_doubling_interval() {
        // d ln I/dT = 3/(2T) + E_g/(2kT²) for a constant gap; ln 2 over that doubles it, for small steps.
        let (gap, kelvin) = (1.2, 300.0);
        let k_ev = BOLTZMANN / ELEMENTARY_CHARGE;
        let interval_k = std::f64::consts::LN_2 / (1.5 / kelvin + gap / (2.0 * k_ev * kelvin * kelvin));
        let reference = Celsius(kelvin - ZERO_CELSIUS);
        let factors = [DarkCurrentLaw::Arrhenius { band_gap_ev: Some(gap) }, DarkCurrentLaw::Doubling { interval_k }]
            .map(|law| law.factor(reference, Celsius(reference.0 + 0.01)).ln());
        // Second order in ΔT/T: 3e-5.
        assert!((factors[0] / factors[1] - 1.0).abs() < 1e-4, "{factors:?}");
    }
}
