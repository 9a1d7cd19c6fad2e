//! Transfer functions from linear values to the encoded values of a file.

use serde::Serialize;

use crate::spectrum::rgb;

/// Encoding of linear values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Transfer {
    /// No encoding.
    Linear,
    /// The function of sRGB and Display P3 ([Srgb](crate::references#srgb)).
    #[default]
    Srgb,
    /// v^(1/γ).
    Gamma(f64),
}

impl Transfer {
    /// Linear value from 0 to 1 → encoded value. Negative values are mirrored.
    pub fn encode(self, linear: f32) -> f32 {
        match self {
            Self::Linear => linear,
            Self::Srgb => rgb::encode(linear),
            Self::Gamma(gamma) => linear.abs().powf(gamma.recip() as f32).copysign(linear),
        }
    }

    /// Linear value from 0 to 1 → encoded value, in double precision, for differences of encoded values.
    pub fn encode_exactly(self, linear: f64) -> f64 {
        match self {
            Self::Linear => linear,
            Self::Srgb if linear <= 0.003_130_8 => linear * 12.92,
            Self::Srgb => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
            Self::Gamma(gamma) => linear.powf(gamma.recip()),
        }
    }

    /// Encoded value → linear value; the inverse of [`Self::encode`].
    pub fn decode(self, encoded: f32) -> f32 {
        match self {
            Self::Linear => encoded,
            Self::Srgb => rgb::decode(encoded),
            Self::Gamma(gamma) => encoded.abs().powf(gamma as f32).copysign(encoded),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decoding_undoes_encoding() {
        for transfer in [Transfer::Linear, Transfer::Srgb, Transfer::Gamma(2.2), Transfer::Gamma(1.0)] {
            for i in -100..=1000 {
                let v = i as f32 / 1000.0;
                // Two powers of a few ulp each.
                assert!((transfer.decode(transfer.encode(v)) - v).abs() < 2e-6, "{transfer:?} {v}");
                let exact = transfer.encode_exactly(f64::from(v).max(0.0));
                assert!((f64::from(transfer.encode(v.max(0.0))) - exact).abs() < 1e-6, "{transfer:?} {v}");
            }
        }
        assert!((Transfer::Gamma(2.0).encode(0.25) - 0.5).abs() < 1e-7);
    }
}
