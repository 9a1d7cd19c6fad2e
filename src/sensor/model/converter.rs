//! Gain and converter of a sensor.

use crate::Invalid;
use crate::sensor::description::AdcDescription;
use crate::units::Decibels;

use super::checks::{finite, positive};

/// Analogue gain and analogue-to-digital converter.
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
}

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
}

impl Converter {
    pub(super) fn new(d: &AdcDescription) -> Result<Self, Invalid> {
        if !(8..=16).contains(&d.bits) {
            return Err(Invalid::new("bits", format!("must lie between 8 and 16, got {}", d.bits))
                .help("for example bits = 12"));
        }
        positive("conversion_gain_dn_per_e", d.conversion_gain_dn_per_e, "0.4")?;
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
        Ok(Self {
            bits: d.bits,
            conversion_gain_dn_per_e: d.conversion_gain_dn_per_e,
            // Below 2^16 as checked above.
            black_level_dn: d.black_level_dn as u16,
            gain_range: [Decibels(low), Decibels(high)],
        })
    }
}
