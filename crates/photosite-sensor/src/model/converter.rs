//! `[adc]`: amplifiers and converter of a sensor, as its file states them, and checked.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_core::units::{Decibels, Electrons};

use super::black_level::{BlackLevelByGain, checked_black_level};
use super::checks::{finite, not_negative, positive};
use super::companding::{Companding, CompandingDescription};

/// Analogue gain and analogue-to-digital converter.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct AdcDescription {
    /// Bits of the converter, 1–16. Where a capture gives a preset other bits, what the preset states in digital
    /// numbers of this converter follows, so that it takes the same charge: by the factor 2^(new − old), and with fewer
    /// than 8 bits by that of the largest numbers, (2^new − 1)/(2^old − 1), so that the few levels span the range. What
    /// the capture states too stays: conversion gain, black levels, offsets of columns, inl_dn and knee points (but not dnl_dn,
    /// which is of a single step, nor the numbers of single-photon detectors, which are counts).
    #[schemars(transform = within(1.0..=16.0))]
    pub bits: u32,
    /// System gain K at 0 dB, DN per electron.
    #[schemars(transform = above(0.0..))]
    pub conversion_gain_dn_per_e: f64,
    /// Digital number of no charge, at all gains for which no step of `noise.gain_steps` states another.
    #[schemars(transform = within(0.0..65_535.0))]
    pub black_level_dn: u32,
    /// Smallest and largest gain that an exposure may ask for, dB. Left out: 0 dB alone.
    #[serde(default)]
    pub gain_db_range: [f64; 2],
    /// Nonlinearity of the amplifiers: a charge q passes as q·(1 + c₁·q/F + c₂·(q/F)² + …), with the full well F and
    /// these c₁, c₂ … in percent. Left out: linear.
    #[serde(default)]
    pub amplifier_nonlinearity_percent: Vec<f64>,
    /// Integral nonlinearity of the converter: it bends by this number of DN in the middle of its range, upwards or downwards.
    /// With dual_gain, it is that of either converter in its own DN; so is dnl_dn.
    #[serde(default)]
    pub inl_dn: f64,
    /// Differential nonlinearity of the converter: standard deviation of the width of its steps, DN, up to 0.4. Steps
    /// stay as they are from image to image.
    #[serde(default)]
    #[schemars(transform = within(0.0..=0.4))]
    pub dnl_dn: f64,
    /// Whether one converter serves all pixels or every column has its own. Left out: "per-column".
    #[serde(default)]
    pub converters: Converters,
    /// Spatial standard deviation of the gains of the columns' amplifiers, percent of their mean.
    #[serde(default)]
    #[schemars(transform = within(0.0..))]
    pub column_gain_percent: f64,
    /// Spatial standard deviation of the offsets of the columns' converters, DN.
    #[serde(default)]
    #[schemars(transform = within(0.0..))]
    pub column_offset_dn: f64,
    /// Numbers of fewer bits leave the sensor, along a curve. Left out: those of the converter.
    pub companding: Option<CompandingDescription>,
    /// Two converters at two gains, whose numbers are merged into one of the bits and the gain above.
    pub dual_gain: Option<DualGainDescription>,
}

/// Number of converters of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum Converters {
    /// Every column has its own.
    #[default]
    PerColumn,
    /// One for all pixels.
    One,
}

/// Two converters at two gains that look at the same charge, and whose numbers are merged into one.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct DualGainDescription {
    /// Bits of each of the two converters, 1–16. What a preset states in their numbers follows as with adc.bits.
    #[schemars(transform = within(1.0..=16.0))]
    pub bits: u32,
    /// Number of no charge at each of the two.
    #[schemars(transform = within(0.0..65_535.0))]
    pub black_level_dn: u32,
    /// System gain of the one that takes small signals, DN per electron. Its noise is `noise.read_noise_e`.
    #[schemars(transform = above(0.0..))]
    pub high_gain_dn_per_e: f64,
    /// System gain of the one that takes large signals, DN per electron.
    #[schemars(transform = above(0.0..))]
    pub low_gain_dn_per_e: f64,
    /// Temporal dark noise of the latter, standard deviation in e⁻. Left out: none.
    #[serde(default)]
    #[schemars(transform = within(0.0..))]
    pub low_gain_read_noise_e: f64,
}

/// Amplifiers and analogue-to-digital converter.
#[derive(Clone, Debug, PartialEq)]
pub struct Converter {
    /// Bits, 1–16.
    pub bits: u32,
    /// System gain K at 0 dB, DN/e⁻.
    pub conversion_gain_dn_per_e: f64,
    /// Digital number of no charge at each gain.
    pub black_level: BlackLevelByGain,
    /// Smallest and largest gain.
    pub gain_range: [Decibels; 2],
    /// Nonlinearity of the amplifiers: c₁, c₂ … of q·(1 + c₁·q/F + c₂·(q/F)² + …) with the full well F; empty for
    /// linear ones.
    pub amplifier_nonlinearity: Vec<f64>,
    /// Integral nonlinearity in the middle of the converter's range, DN.
    pub inl_dn: f64,
    /// Differential nonlinearity: standard deviation of the width of a step, DN; 0–0.4.
    pub dnl_dn: f64,
    /// Number of converters of the sensor.
    pub converters: Converters,
    /// Spatial standard deviation of the columns' gains over their mean.
    pub column_gain: f64,
    /// Spatial standard deviation of the columns' offsets, DN.
    pub column_offset_dn: f64,
    /// Companding of the converter's numbers; `None` where they leave the sensor as they are.
    pub companding: Option<Companding>,
    /// The two converters behind this one, where its numbers are merged from theirs.
    pub dual_gain: Option<Box<DualGain>>,
}

/// The two converters.
#[derive(Clone, Debug, PartialEq)]
pub struct DualGain {
    /// Amplifier and converter for small signals.
    pub high: Converter,
    /// Amplifier and converter for large signals.
    pub low: Converter,
    /// Standard deviation of the read noise of the latter.
    pub low_read_noise: Electrons,
}

/// Beyond this, steps of a converter would have to vanish or change places.
const MAX_DNL_DN: f64 = 0.4;

impl Converter {
    /// System gain K at a gain setting, DN/e⁻.
    pub fn system_gain(&self, gain: Decibels) -> f64 {
        self.conversion_gain_dn_per_e * gain.factor()
    }

    /// Digital number of no charge at a gain setting.
    pub fn black_level_dn(&self, gain: Decibels) -> u16 {
        self.black_level.at(gain)
    }

    /// The signal that would reach the end of the range, of the black level of a gain setting, at 0 dB, referred to
    /// electrons.
    pub(crate) fn range_e(&self, gain: Decibels) -> f64 {
        f64::from(self.max_dn() - self.black_level_dn(gain)) / self.conversion_gain_dn_per_e
    }

    /// Largest digital number, 2^bits − 1.
    pub fn max_dn(&self) -> u16 {
        // At most 16 bits, so the sum of powers fits.
        ((1u32 << self.bits) - 1) as u16
    }

    /// A converter of 16 bits at 1 DN/e⁻ without black level, whose amplifiers are all alike and linear.
    pub fn ideal() -> Self {
        Self {
            bits: 16,
            conversion_gain_dn_per_e: 1.0,
            black_level: 0.into(),
            gain_range: [Decibels(0.0); 2],
            amplifier_nonlinearity: Vec::new(),
            inl_dn: 0.0,
            dnl_dn: 0.0,
            converters: Converters::PerColumn,
            column_gain: 0.0,
            column_offset_dn: 0.0,
            companding: None,
            dual_gain: None,
        }
    }

    pub(super) fn new(d: &AdcDescription) -> Result<Self, Invalid> {
        let black_level_dn = converter_range(d.bits, d.black_level_dn)?;
        let max_dn = (1 << d.bits) - 1;
        let [low, high] = d.gain_db_range;
        finite("gain_db_range", low)?;
        finite("gain_db_range", high)?;
        if low > high {
            return Err(Invalid::new("gain_db_range", format!("{low} dB is above {high} dB"))
                .help("write the smaller gain first"));
        }
        let gain_range = [Decibels(low), Decibels(high)];
        let dual_gain = d.dual_gain.as_ref().map(|dual| DualGain::new(dual, d, gain_range)).transpose();
        let dual_gain = dual_gain.map_err(|e| e.within("dual_gain"))?;
        let of_one_converter =
            [("column_gain_percent", d.column_gain_percent), ("column_offset_dn", d.column_offset_dn)];
        if let (Some(_), Some((key, _))) = (&dual_gain, of_one_converter.iter().find(|(_, value)| *value != 0.0)) {
            return Err(
                Invalid::new(*key, "cannot be combined with dual_gain").help("its converters are taken to be alike")
            );
        }
        let inl_dn = finite("inl_dn", d.inl_dn)?;
        // The nonlinearity is that of the two converters, and so are the bits.
        let max_dn = d.dual_gain.as_ref().map_or(max_dn, |dual| (1 << dual.bits.min(16)) - 1);
        // A larger one would make the converter's numbers fall with rising voltage: the slope at the ends is 1 ±
        // 4·INL/max.
        if 4.0 * inl_dn.abs() >= f64::from(max_dn) {
            let message = format!("{inl_dn} DN is too much for a range of {max_dn} DN");
            return Err(Invalid::new("inl_dn", message).help("the nonlinearity of converters is some DN at most"));
        }
        let dnl_dn = not_negative("dnl_dn", d.dnl_dn)?;
        if dnl_dn > MAX_DNL_DN {
            return Err(Invalid::new("dnl_dn", format!("must be at most {MAX_DNL_DN}, got {dnl_dn}"))
                .help("beyond that, steps of the converter would change places"));
        }
        let amplifier_nonlinearity: Vec<f64> = d.amplifier_nonlinearity_percent.iter().map(|c| c / 100.0).collect();
        if !rises(&amplifier_nonlinearity) {
            let message = format!("{:?} makes signals fall with rising charge", d.amplifier_nonlinearity_percent);
            return Err(Invalid::new("amplifier_nonlinearity_percent", message)
                .help("write finite numbers, such as [-2.0]: signals are 2 % too small at full well"));
        }
        Ok(Self {
            bits: d.bits,
            conversion_gain_dn_per_e: positive("conversion_gain_dn_per_e", d.conversion_gain_dn_per_e, "0.4")?,
            black_level: black_level_dn.into(),
            gain_range,
            amplifier_nonlinearity,
            // Merging two numbers adds no nonlinearity of its own.
            inl_dn: if d.dual_gain.is_some() { 0.0 } else { inl_dn },
            dnl_dn: if d.dual_gain.is_some() { 0.0 } else { dnl_dn },
            converters: d.converters,
            column_gain: not_negative("column_gain_percent", d.column_gain_percent)? / 100.0,
            column_offset_dn: not_negative("column_offset_dn", d.column_offset_dn)?,
            companding: d
                .companding
                .as_ref()
                .map(|companding| Companding::new(companding, d.bits).map_err(|e| e.within("companding")))
                .transpose()?,
            dual_gain: dual_gain.map(Box::new),
        })
    }
}

impl DualGain {
    /// Keys of errors are those of the table `[adc.dual_gain]`. Both converters have the nonlinearity of `adc`.
    pub(super) fn new(
        d: &DualGainDescription,
        adc: &AdcDescription,
        gain_range: [Decibels; 2],
    ) -> Result<Self, Invalid> {
        let black_level_dn = converter_range(d.bits, d.black_level_dn)?;
        positive("high_gain_dn_per_e", d.high_gain_dn_per_e, "4.0")?;
        positive("low_gain_dn_per_e", d.low_gain_dn_per_e, "0.1")?;
        not_negative("low_gain_read_noise_e", d.low_gain_read_noise_e)?;
        if d.low_gain_dn_per_e > d.high_gain_dn_per_e {
            let message = format!("{} is above the high gain, {}", d.low_gain_dn_per_e, d.high_gain_dn_per_e);
            return Err(Invalid::new("low_gain_dn_per_e", message).help("write the smaller of the two gains here"));
        }
        let converter = |conversion_gain_dn_per_e| Converter {
            bits: d.bits,
            conversion_gain_dn_per_e,
            black_level: black_level_dn.into(),
            gain_range,
            inl_dn: adc.inl_dn,
            dnl_dn: adc.dnl_dn,
            converters: adc.converters,
            ..Converter::ideal()
        };
        Ok(Self {
            high: converter(d.high_gain_dn_per_e),
            low: converter(d.low_gain_dn_per_e),
            low_read_noise: Electrons(d.low_gain_read_noise_e),
        })
    }
}

/// Whether d/dx of x·(1 + c₁·x + c₂·x² + …) is above 0 for all x in 0–1.
fn rises(coefficients: &[f64]) -> bool {
    let slope = |x: f64| {
        let terms = coefficients.iter().zip(2i32..).map(|(c, power)| f64::from(power) * c * x.powi(power - 1));
        1.0 + terms.sum::<f64>()
    };
    // Polynomials of a few terms have nothing between a thousand places.
    (0..=1000).all(|i| slope(f64::from(i) / 1000.0) > 0.0)
}

/// Checks bits and black level of a converter, and returns the latter.
fn converter_range(bits: u32, black_level_dn: u32) -> Result<u16, Invalid> {
    if !(1..=16).contains(&bits) {
        let message = format!("must lie between 1 and 16, got {bits}");
        return Err(Invalid::new("bits", message).help("for example bits = 12"));
    }
    // At most 16 bits.
    checked_black_level(black_level_dn, ((1u32 << bits) - 1) as u16)
}
