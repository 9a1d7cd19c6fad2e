//! The sensor's noise in closed form: what [`expose()`](crate::expose()) does, predicted. It tells a renderer
//! when Monte Carlo noise is small beside it, and a raw file what its noise profile is.

use photosite_core::units::{Decibels, DigitalNumber, Electrons};

use super::shares::Shares;
use crate::stages::converter::bow_dn;
use crate::stages::digital_gain::rounding_variance_e2;
use crate::{Converter, Exposure, SensorModel, Stages};

/// Noise of digital numbers at one exposure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoiseModel<'a> {
    sensor: &'a SensorModel,
    exposure: &'a Exposure,
    shares: Shares,
    /// Variance of what rounding adds behind the converter, (e⁻)².
    rounding_e2: f64,
}

impl<'a> NoiseModel<'a> {
    /// The noise of some stages.
    pub(crate) fn new(sensor: &'a SensorModel, exposure: &'a Exposure, stages: Stages) -> Self {
        let shares = Shares::new(sensor, exposure, stages);
        Self { sensor, exposure, shares, rounding_e2: rounding_variance_e2(sensor, exposure) }
    }

    /// Variance of temporal noise, (e⁻)², by [`SensorModel::noise_variance`]'s equation.
    pub(crate) fn variance(&self, mean: Electrons) -> f64 {
        let Self { sensor, exposure, shares, .. } = self;
        let binning = exposure.region.binning;
        let (light, heat) = (mean.0.max(0.0), shares.heat_e * binning.pixels() as f64);
        let charge = light + heat;
        let slope = sensor.pixel_slope(charge / binning.pixels() as f64, exposure.time);
        let signal = sensor.signal(charge, exposure);
        let steps = sensor.companding_variance(signal, exposure) + sensor.curve_variance(signal, exposure);
        shares.light_e2(light) + heat + (self.read_out_variance(charge) + steps) / (slope * slope)
    }

    /// Variance of what the read-out adds to a charge, (e⁻)² of the pixel that is read out.
    fn read_out_variance(&self, charge_e: f64) -> f64 {
        let Self { sensor, exposure, shares, rounding_e2 } = self;
        let [across, down] = exposure.region.binning.numbers().map(|n| n as f64);
        let low = usize::from(sensor.low_gain_counts(Electrons(charge_e / (across * down)), exposure.gain));
        let number = shares.pixel_e2[low] + shares.conversion_e2[low];
        number * (across * down) + shares.shared_e2([across, down]) + rounding_e2
    }
}

impl SensorModel {
    /// Variance of a digital number's temporal noise, referred to electrons ((e⁻)²), at a mean of `mean`
    /// photo-electrons, both of the pixel that is read out (of a bin, of all its pixels together):
    ///
    /// σ² = μ + μ_d + (σ_read² + σ_reset² + σ_row² + σ_column² + σ_flicker² + σ_telegraph² + (1/12 + σ_DNL²)/K²)/s²
    ///
    /// shot noise of light and dark current, noise of the read-out, quantisation (the linear model of
    /// [Emva1288](photosite_core::references#emva1288), whose σ_d² is all but the first and the last), and the rounding
    /// that follows a digital gain and companding: the sum of each stage's share. The slope s is 1 but for logarithmic
    /// pixels. In a bin of n numbers, what each brings is there n times, and what they share n² times. Hot pixels and
    /// telegraph signals count with their part of all pixels; with two gains, amplifier and converter of the one that
    /// counts. Fixed patterns are no temporal noise, and what transmission errors do has no
    /// useful variance. The steps of numbers behind a video curve are those at the signal. What the bandwidth of a video
    /// line takes of it, and what a frame grabber's interpolation does, is left out: they take as much of all other
    /// variance. Valid below saturation, and for amplifiers that are nearly linear.
    pub fn noise_variance(&self, mean: Electrons, exposure: &Exposure) -> f64 {
        NoiseModel::new(self, exposure, Stages::ALL).variance(mean)
    }

    /// The noise-free signal of a charge behind the amplifiers, both of the pixel that is read out, e⁻.
    fn signal(&self, charge_e: f64, exposure: &Exposure) -> f64 {
        let [across, down] = exposure.region.binning.numbers();
        let numbers = (across * down) as f64;
        self.amplified(self.pixel_signal(charge_e / numbers, exposure.time)) * numbers
    }

    /// Standard deviation of the amplifiers' noise σ_read in the pixel that is read out: that of n pixels whose numbers
    /// are added, or averaged, is √n times that of one.
    pub fn read_noise(&self, exposure: &Exposure) -> Electrons {
        let [across, down] = exposure.region.binning.numbers();
        Electrons(self.noise.read_out.at(exposure.gain).read.0 * ((across * down) as f64).sqrt())
    }

    /// Variance at a mean of `mean` photo-electrons before the signal becomes a number, (e⁻)², without binning; with
    /// two gains, σ_read is that of the one which counts.
    pub fn signal_variance(&self, mean: Electrons, exposure: &Exposure) -> f64 {
        let shares = Shares::new(self, exposure, Stages::ALL);
        let low = usize::from(self.low_gain_counts(mean, exposure.gain));
        mean.0.max(0.0) + shares.heat_e + shares.pixel_e2[low] + shares.shared_e2([1.0; 2])
    }

    /// Whether two gains look at a charge, and the low one counts.
    fn low_gain_counts(&self, charge: Electrons, gain: Decibels) -> bool {
        self.converter.dual_gain.as_ref().is_some_and(|dual| dual.is_clipped(self.amplified(charge.0), gain))
    }

    /// Variance that companding adds by its wider steps, (e⁻)².
    fn companding_variance(&self, signal_e: f64, exposure: &Exposure) -> f64 {
        let gain = self.system_gain(exposure);
        let level = signal_e * gain;
        let black = f64::from(self.converter.black_level_dn(exposure.gain));
        let step = self.step_dn((level + black) as u16);
        (step * step - 1.0) / 12.0 / (gain * gain)
    }

    /// Variance of the converter's steps behind a video curve at a signal, less that of steps of a straight line, (e⁻)².
    fn curve_variance(&self, signal_e: f64, exposure: &Exposure) -> f64 {
        let Some(curve) = self.video.curve else { return 0.0 };
        let gain = self.converter.system_gain(exposure.gain);
        let step = curve.step_dn(signal_e * gain);
        (step * step - 1.0) / 12.0 / (gain * gain)
    }

    /// Electrons at which the pixel that is read out saturates: the full well, the end of the converter's range, or the
    /// end of what a digital gain leaves of that, whichever comes first; of a bin, those of all its pixels together.
    pub fn saturation_capacity(&self, exposure: &Exposure) -> Electrons {
        let converter = &self.converter;
        let before_merging = converter.dual_gain.as_ref().map_or(f64::INFINITY, |dual| dual.low.range_e(exposure.gain));
        let binning = exposure.region.binning;
        let [across, down] = binning.numbers();
        let numbers = (across * down) as f64;
        let digital = exposure.digital_gain.factor() * binning.weight() * numbers;
        // A digital gain leaves the start of what the curve has bent.
        let range = self.video.curve.map_or(converter.range_e(exposure.gain) / digital, |curve| {
            curve.straightened(curve.range_dn / digital) / converter.conversion_gain_dn_per_e
        });
        let signal = before_merging.min(range) / exposure.gain.factor();
        let charge = self.pixel_charge(self.charge_for(signal), exposure.time) * numbers;
        Electrons((self.full_well.0 * binning.pixels() as f64).min(charge))
    }

    /// Electrons of each of the pixels that are read out as one at which they saturate: their part of
    /// [`saturation_capacity`](Self::saturation_capacity).
    pub fn pixel_saturation(&self, exposure: &Exposure) -> Electrons {
        Electrons(self.saturation_capacity(exposure).0 / exposure.region.binning.pixels() as f64)
    }

    /// Whether signal and noise are other than the linear model of [Emva1288](photosite_core::references#emva1288) has
    /// them, in which signals lie on a line and K·signal is all of the light's noise: amplifiers and converters that
    /// bend, two gains.
    pub fn is_nonlinear(&self) -> bool {
        let converter = &self.converter;
        !converter.amplifier_nonlinearity.is_empty() || converter.inl_dn != 0.0 || converter.dual_gain.is_some()
    }

    /// The number that becomes of a charge with its noise, e⁻, without digital gain, companding and the patterns of
    /// columns and converters, DN.
    pub fn number(&self, charge: Electrons, gain: Decibels) -> f64 {
        let signal = self.amplified(charge.0.min(self.full_well.0));
        let convert = |converter: &Converter, signal: f64| {
            let max = f64::from(converter.max_dn());
            let level = f64::from(converter.black_level_dn(gain)) + converter.system_gain(gain) * signal;
            (level + bow_dn(converter.inl_dn, level / max)).clamp(0.0, max).round()
        };
        let low = self.low_gain_counts(charge, gain);
        let branch = self.converter.dual_gain.as_ref().map(|dual| if low { &dual.low } else { &dual.high });
        let merged = branch.map_or(signal, |converter| {
            (convert(converter, signal) - f64::from(converter.black_level_dn(gain))) / converter.system_gain(gain)
        });
        convert(&self.converter, merged)
    }

    /// Smallest whole linear number at which a noise-free pixel is saturated, always above the black level.
    pub(crate) fn white_level_dn(&self, exposure: &Exposure) -> u16 {
        let linearisation = self.linearisation(exposure);
        linearisation
            .map_or_else(|| self.nonlinear_white_level_dn(exposure), |linearisation| linearisation.white_level_dn)
    }

    /// White level as the converter has it, before anything is made linear.
    pub(crate) fn nonlinear_white_level_dn(&self, exposure: &Exposure) -> u16 {
        let converter = &self.converter;
        let signal = self.signal(self.saturation_capacity(exposure).0, exposure);
        let black = converter.black_level_dn(exposure.gain);
        let level = DigitalNumber(f64::from(black) + self.number_of_signal(signal, exposure) + 0.5);
        (level.0 as u16).clamp(black + 1, converter.max_dn())
    }

    /// Noise as a raw file states it: variance of the normalised signal x = (DN − black)/(white − black) is
    /// S·x + O (DNG 1.6 specification, NoiseProfile). With R = white − black in DN,
    ///
    /// S = K/R, O = K²·σ_0²/R²
    ///
    /// where σ_0² is the noise without light, in (e⁻)²; both times what a video line's bandwidth leaves of white noise. What companding adds has no place in it; the noise of logarithmic pixels
    /// and behind a video curve has another form, and `None` is said of it.
    pub(crate) fn noise_profile(&self, exposure: &Exposure) -> Option<[f64; 2]> {
        let gain = self.system_gain(exposure);
        let range = f64::from(self.white_level_dn(exposure) - self.converter.black_level_dn(exposure.gain));
        let pixels = exposure.region.binning.pixels() as f64;
        let model = NoiseModel::new(self, exposure, Stages::ALL);
        let heat = model.shares.heat_e * pixels;
        let dark = heat + model.read_out_variance(0.0);
        let left = self.video.low_pass.map_or(1.0, |low_pass| low_pass.noise_power());
        let is_straight = self.logarithmic.is_none() && self.video.curve.is_none();
        is_straight.then_some([left * gain / range, left * dark * (gain / range).powi(2)])
    }
}
