//! The noise sources of a sensor.

use crate::Invalid;
use crate::sensor::description::NoiseDescription;
use crate::units::{Celsius, Electrons};

use super::checks::{finite, not_negative, positive};

/// Noise sources, referred to electrons.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the read noise.
    pub read: Electrons,
    /// Dark current at the reference temperature, e⁻/s.
    pub dark_current_e_per_s: f64,
    /// Reference temperature of the dark current.
    pub dark_current_reference: Celsius,
    /// Rise of temperature that doubles the dark current, K.
    pub dark_current_doubling_k: f64,
    /// Photo response over its mean (PRNU, a ratio: 0.01 is 1 %).
    pub prnu: FixedPattern,
    /// Dark signal (DSNU), e⁻.
    pub dsnu: FixedPattern,
}

/// Spatial standard deviations of a pattern that is the same in every picture, in a unit of its own. Its parts are
/// independent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FixedPattern {
    /// What each pixel has to itself.
    pub pixel: f64,
    /// What the pixels of a row share.
    pub row: f64,
    /// What the pixels of a column share.
    pub column: f64,
}

impl FixedPattern {
    /// A pattern without rows and columns.
    pub const fn of_pixels(pixel: f64) -> Self {
        Self { pixel, row: 0.0, column: 0.0 }
    }

    /// Standard deviation of the whole pattern, √(pixel² + row² + column²).
    pub fn total(&self) -> f64 {
        (self.pixel * self.pixel + self.row * self.row + self.column * self.column).sqrt()
    }
}

impl Noise {
    /// No noise but that of light itself.
    pub const NONE: Self = Self {
        read: Electrons(0.0),
        dark_current_e_per_s: 0.0,
        dark_current_reference: Celsius(25.0),
        dark_current_doubling_k: 8.0,
        prnu: FixedPattern::of_pixels(0.0),
        dsnu: FixedPattern::of_pixels(0.0),
    };

    pub(super) fn new(d: &NoiseDescription) -> Result<Self, Invalid> {
        not_negative("read_noise_e", d.read_noise_e)?;
        not_negative("dark_current_e_per_s", d.dark_current_e_per_s)?;
        finite("dark_current_reference_c", d.dark_current_reference_c)?;
        positive("dark_current_doubling_k", d.dark_current_doubling_k, "8.0")?;
        for (key, value) in [
            ("prnu_percent", d.prnu_percent),
            ("prnu_row_percent", d.prnu_row_percent),
            ("prnu_column_percent", d.prnu_column_percent),
            ("dsnu_e", d.dsnu_e),
            ("dsnu_row_e", d.dsnu_row_e),
            ("dsnu_column_e", d.dsnu_column_e),
        ] {
            not_negative(key, value)?;
        }
        Ok(Self {
            read: Electrons(d.read_noise_e),
            dark_current_e_per_s: d.dark_current_e_per_s,
            dark_current_reference: Celsius(d.dark_current_reference_c),
            dark_current_doubling_k: d.dark_current_doubling_k,
            prnu: FixedPattern {
                pixel: d.prnu_percent / 100.0,
                row: d.prnu_row_percent / 100.0,
                column: d.prnu_column_percent / 100.0,
            },
            dsnu: FixedPattern { pixel: d.dsnu_e, row: d.dsnu_row_e, column: d.dsnu_column_e },
        })
    }
}
