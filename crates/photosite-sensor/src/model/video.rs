//! `[video]`: the analogue signal on its way from the sensor to the converter, as a sensor file states it, and checked.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_core::units::Decibels;

use super::checks::positive;
use super::converter::Converter;
use super::kind::SensorKind;

/// The analogue signal on its way from the sensor to the converter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct VideoDescription {
    /// Curve of the amplifier: a signal becomes its power γ, both as parts of the converter's range, 0.4 to 5. Noise of
    /// the pixels and the gain come before it. Raw files in the DNG format tell how to make numbers linear again. Left
    /// out: 1, a straight line.
    #[schemars(transform = within(0.4..=5.0))]
    pub gamma: Option<f64>,
    /// Frequency at which the line passes 1/√2 of an amplitude (−3 dB), MHz: it is a low pass of the first order, as a
    /// resistor and a capacitor make it, so that neighbours along a row go together. It needs pixel_clock_mhz. Left out:
    /// no limit.
    #[schemars(transform = above(0.0..))]
    pub bandwidth_mhz: Option<f64>,
    /// Pixels of a row that follow each other in a microsecond, MHz.
    #[schemars(transform = above(0.0..))]
    pub pixel_clock_mhz: Option<f64>,
}

/// The way of the analogue signal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Video {
    /// Curve of the video amplifier; `None` for a straight line.
    pub curve: Option<VideoCurve>,
    /// Low-pass filter of the video line; `None` where its bandwidth is unlimited.
    pub low_pass: Option<LowPass>,
}

/// i = R·(y/R)^γ, the sensor curve of a signal y = K·(b + n) in the range R of the converter. Below zero the curve goes
/// on as its mirror image, so that noise about zero stays about zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VideoCurve {
    /// γ, 0.4 to 5.
    pub gamma: f64,
    /// Range R of the converter above the black level, DN.
    pub range_dn: f64,
}

/// A low pass of the first order whose line has the time of a pixel to follow its signal:
///
/// y_k = a·y_{k−1} + (1 − a)·s_k,  a = exp(−2π·f_c/f_p)
///
/// with the bandwidth f_c and the pixel clock f_p: the exact answer of such a line to a signal that is held for the time
/// of each pixel, at the end of that time. White noise along a row gets the autocovariance ρ(k) = a^|k| and (1 − a)/(1 +
/// a) of its variance; things move by a/(1 − a) pixels on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    /// a: part of a step that is missing at the end of a pixel, 0 to below 1.
    pub missing: f64,
}

/// Range of γ; curves beyond it are no sensor's.
const GAMMAS: [f64; 2] = [0.4, 5.0];

impl VideoCurve {
    /// Signal behind the amplifier for one before it, both in DN above the black level.
    pub fn bent(&self, signal_dn: f64) -> f64 {
        self.power(signal_dn, self.gamma)
    }

    /// The signal that has become a number above the black level, both in DN.
    pub fn straightened(&self, number_dn: f64) -> f64 {
        self.power(number_dn, 1.0 / self.gamma)
    }

    fn power(&self, value: f64, power: f64) -> f64 {
        (self.range_dn * (value.abs() / self.range_dn).powf(power)).copysign(value)
    }

    /// Step between neighbouring digital numbers, in DN of the signal before the amplifier, at a signal.
    pub(crate) fn step_dn(&self, signal_dn: f64) -> f64 {
        let number = self.bent(signal_dn);
        self.straightened(number + 0.5) - self.straightened(number - 0.5)
    }
}

impl LowPass {
    /// Part of the variance of white noise that the filter leaves along a row.
    pub fn noise_power(&self) -> f64 {
        (1.0 - self.missing) / (1.0 + self.missing)
    }

    /// Delay along a row, pixels: the distance that the filter moves the image.
    pub fn delay_px(&self) -> f64 {
        self.missing / (1.0 - self.missing)
    }
}

impl Video {
    /// Keys of errors are those of the sensor file.
    pub(super) fn new(d: &VideoDescription, kind: SensorKind, converter: &Converter) -> Result<Self, Invalid> {
        let VideoDescription { gamma, bandwidth_mhz, pixel_clock_mhz } = *d;
        if [gamma, bandwidth_mhz, pixel_clock_mhz].iter().any(Option::is_some) {
            check_analogue("video", kind, converter)?;
        }
        let [least, most] = GAMMAS;
        if let Some(gamma) = gamma.filter(|gamma| !(least..=most).contains(gamma)) {
            let message = format!("must lie between {least} and {most}, got {gamma}");
            return Err(Invalid::new("video.gamma", message).help("for example gamma = 0.45; leave it out for a line"));
        }
        if gamma.is_some() && converter.black_level.changes() {
            let message = "cannot be combined with black levels that change with gain, in noise.gain_steps";
            return Err(Invalid::new("video.gamma", message).help("keep one of them"));
        }
        let range_dn = f64::from(converter.max_dn() - converter.black_level_dn(Decibels(0.0)));
        let curve = gamma.filter(|gamma| *gamma != 1.0).map(|gamma| VideoCurve { gamma, range_dn });
        let low_pass = match (bandwidth_mhz, pixel_clock_mhz) {
            (None, None) => None,
            (Some(bandwidth), Some(clock)) => {
                positive("video.bandwidth_mhz", bandwidth, "4.2")?;
                positive("video.pixel_clock_mhz", clock, "13.5")?;
                Some(LowPass { missing: checked_rest(bandwidth, clock)? })
            }
            (Some(_), None) => {
                return Err(Invalid::new("video.pixel_clock_mhz", "missing; what bandwidth_mhz does depends on it")
                    .help("for example pixel_clock_mhz = 13.5"));
            }
            (None, Some(_)) => {
                return Err(Invalid::new("video.pixel_clock_mhz", "has no effect without bandwidth_mhz")
                    .help("for example bandwidth_mhz = 4.2, or leave it out"));
            }
        };
        Ok(Self { curve, low_pass })
    }
}

/// A line that takes more than a thousand pixels to follow shows no image.
fn checked_rest(bandwidth_mhz: f64, clock_mhz: f64) -> Result<f64, Invalid> {
    const LEAST: f64 = 1.6e-4;
    let ratio = bandwidth_mhz / clock_mhz;
    if ratio < LEAST {
        let message = format!("{bandwidth_mhz} MHz smears a pixel of {clock_mhz} MHz over a thousand others");
        let help = format!("write at least {} MHz", LEAST * clock_mhz);
        return Err(Invalid::new("video.bandwidth_mhz", message).help(help));
    }
    Ok((-TAU * ratio).exp())
}

/// Refuses sensors that hand out digital numbers of their own.
pub(super) fn check_analogue(key: &str, kind: SensorKind, converter: &Converter) -> Result<(), Invalid> {
    let clash = match kind {
        SensorKind::Spad => Some("kind = \"spad\""),
        SensorKind::Cmos | SensorKind::Ccd => converter.dual_gain.as_ref().map(|_| "adc.dual_gain"),
    };
    match clash {
        Some(clash) => {
            Err(Invalid::new(key, format!("cannot be combined with {clash}, whose sensors hand out numbers"))
                .help("keep one of them"))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_is_a_power_that_is_its_own_mirror_image() {
        let curve = VideoCurve { gamma: 2.0, range_dn: 1000.0 };
        for (y, bent) in [(0.0, 0.0), (100.0, 10.0), (500.0, 250.0), (1000.0, 1000.0), (-500.0, -250.0)] {
            assert!((curve.bent(y) - bent).abs() < 1e-12, "{y}");
        }
        for gamma in [0.4, 0.45, 1.7, 5.0] {
            let curve = VideoCurve { gamma, range_dn: 255.0 };
            for y in [-3.0, 1e-3, 0.5, 77.0, 255.0, 300.0] {
                assert!((curve.straightened(curve.bent(y)) / y - 1.0).abs() < 1e-12);
            }
        }
        // A number of 250 is 500²/1000: between 249.5 and 250.5 lie 2·√(1000·250)·½/250 = 1 DN of the signal.
        assert!((curve.step_dn(500.0) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_line_of_the_bandwidth_of_a_pixel_keeps_little() {
        let rest = checked_rest(4.0, 16.0).expect("wide enough");
        // exp(−π/2).
        assert!((rest - 0.207_879_6).abs() < 1e-6);
        let low_pass = LowPass { missing: 0.5 };
        assert_eq!((low_pass.noise_power(), low_pass.delay_px()), (1.0 / 3.0, 1.0));
        assert!(checked_rest(1e-3, 16.0).is_err());
    }
}
