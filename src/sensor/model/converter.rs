//! Amplifiers and converter of a sensor.

use crate::Invalid;
use crate::sensor::description::{AdcDescription, Converters};
use crate::units::Decibels;

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
}

/// Beyond this, steps of a converter would have to vanish or change places.
const MAX_DNL_DN: f64 = 0.4;

impl Converter {
    /// System gain K at a gain setting, DN/e⁻.
    pub fn system_gain(&self, gain: Decibels) -> f64 {
        self.conversion_gain_dn_per_e * gain.factor()
    }

    /// Largest digital number, 2^bits − 1.
    pub fn max_dn(&self) -> u16 {
        // At most 16 bits, so the sum of powers fits.
        ((1u32 << self.bits) - 1) as u16
    }

    pub(super) fn new(d: &AdcDescription) -> Result<Self, Invalid> {
        if !(8..=16).contains(&d.bits) {
            return Err(Invalid::new("bits", format!("must lie between 8 and 16, got {}", d.bits))
                .help("for example bits = 12"));
        }
        let max_dn = (1 << d.bits) - 1;
        if d.black_level_dn >= max_dn {
            let message = format!("{} leaves no room below the largest number, {max_dn}", d.black_level_dn);
            return Err(Invalid::new("black_level_dn", message)
                .help(format!("write less than {max_dn}, the largest number of {} bits", d.bits)));
        }
        let [low, high] = d.gain_db_range;
        finite("gain_db_range", low)?;
        finite("gain_db_range", high)?;
        if low > high {
            return Err(Invalid::new("gain_db_range", format!("{low} dB is above {high} dB"))
                .help("write the smaller gain first"));
        }
        let inl_dn = finite("inl_dn", d.inl_dn)?;
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
            // Below 2^16 as checked above.
            black_level_dn: d.black_level_dn as u16,
            gain_range: [Decibels(low), Decibels(high)],
            amplifier_nonlinearity,
            inl_dn,
            dnl_dn,
            converters: d.converters,
            column_gain: not_negative("column_gain_percent", d.column_gain_percent)? / 100.0,
            column_offset_dn: not_negative("column_offset_dn", d.column_offset_dn)?,
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
