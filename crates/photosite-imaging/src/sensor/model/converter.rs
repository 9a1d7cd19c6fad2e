//! Amplifiers and converter of a sensor.

use crate::sensor::description::{AdcDescription, Converters};
use crate::sensor::{Companding, DualGain};
use photosite_core::Invalid;
use photosite_core::units::Decibels;

use super::checks::{finite, not_negative, positive};

/// Amplifiers and analogue-to-digital converter.
#[derive(Clone, Debug, PartialEq)]
pub struct Converter {
    /// Bits, 8–16.
    pub bits: u32,
    /// System gain K at 0 dB, DN/e⁻.
    pub conversion_gain_dn_per_e: f64,
    /// Digital number of no charge.
    pub black_level_dn: u16,
    /// Smallest and largest gain.
    pub gain_range: [Decibels; 2],
    /// Nonlinearity of the amplifiers: c₁, c₂ … of q·(1 + c₁·q/F + c₂·(q/F)² + …) with the full well F; empty for linear
    /// ones.
    pub amplifier_nonlinearity: Vec<f64>,
    /// Integral nonlinearity in the middle of the converter's range, DN.
    pub inl_dn: f64,
    /// Differential nonlinearity: standard deviation of the width of a step, DN; 0–0.4.
    pub dnl_dn: f64,
    /// How many converters there are.
    pub converters: Converters,
    /// Spatial standard deviation of the columns' gains over their mean.
    pub column_gain: f64,
    /// Spatial standard deviation of the columns' offsets, DN.
    pub column_offset_dn: f64,
    /// What makes of its numbers those that leave the sensor; `None` for nothing.
    pub companding: Option<Companding>,
    /// The two converters behind this one, where its numbers are merged from theirs.
    pub dual_gain: Option<Box<DualGain>>,
}

/// Beyond this, steps of a converter would have to vanish or change places.
const MAX_DNL_DN: f64 = 0.4;

impl Converter {
    /// System gain K at a gain setting, DN/e⁻.
    pub fn system_gain(&self, gain: Decibels) -> f64 {
        self.conversion_gain_dn_per_e * gain.factor()
    }

    /// The signal at the end of the range at 0 dB, referred to electrons.
    pub(in crate::sensor) fn range_e(&self) -> f64 {
        f64::from(self.max_dn() - self.black_level_dn) / self.conversion_gain_dn_per_e
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
            black_level_dn: 0,
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
        let dual_gain = d.dual_gain.as_ref().map(|dual| DualGain::new(dual, d, gain_range));
        let of_one_converter =
            [("column_gain_percent", d.column_gain_percent), ("column_offset_dn", d.column_offset_dn)];
        if let (Some(_), Some((key, _))) = (&dual_gain, of_one_converter.iter().find(|(_, value)| *value != 0.0)) {
            return Err(Invalid::new(*key, "cannot go with dual_gain").help("its converters are taken to be alike"));
        }
        let inl_dn = finite("inl_dn", d.inl_dn)?;
        // It is the converters that bend, and theirs are the bits.
        let max_dn = d.dual_gain.as_ref().map_or(max_dn, |dual| (1 << dual.bits.min(16)) - 1);
        // A steeper bend would make the converter's numbers fall with rising voltage: the slope at the ends is 1 ± 4·INL/max.
        if 4.0 * inl_dn.abs() >= f64::from(max_dn) {
            let message = format!("{inl_dn} DN is too much for a range of {max_dn} DN");
            return Err(Invalid::new("inl_dn", message).help("converters are bent by some DN at most"));
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
            black_level_dn,
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
            dual_gain: dual_gain.transpose().map_err(|e| e.within("dual_gain"))?.map(Box::new),
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
pub(in crate::sensor) fn converter_range(bits: u32, black_level_dn: u32) -> Result<u16, Invalid> {
    if !(8..=16).contains(&bits) {
        let message = format!("must lie between 8 and 16, got {bits}");
        return Err(Invalid::new("bits", message).help("for example bits = 12"));
    }
    let max_dn = (1 << bits) - 1;
    if black_level_dn >= max_dn {
        let message = format!("{black_level_dn} leaves no room below the largest number, {max_dn}");
        return Err(Invalid::new("black_level_dn", message)
            .help(format!("write less than {max_dn}, the largest number of {bits} bits")));
    }
    // Below 2^16, as there are at most 16 bits.
    Ok(black_level_dn as u16)
}
