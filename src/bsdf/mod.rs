//! How surfaces scatter light.

use crate::spectrum::Spectrum;

/// Refractive index of a clear medium as a function of wavelength.
#[derive(Clone, Debug)]
pub enum Dispersion {
    /// n² = 1 + Σ Bᵢλ²/(λ² − Cᵢ), λ in µm (Sellmeier).
    Sellmeier {
        /// Dimensionless strengths.
        b: Vec<f64>,
        /// Squared resonance wavelengths, µm².
        c_um2: Vec<f64>,
    },
    /// n = A + B/λ² + C/λ⁴, λ in µm (Cauchy).
    Cauchy {
        /// Index at infinite wavelength.
        a: f64,
        /// µm².
        b_um2: f64,
        /// µm⁴.
        c_um4: f64,
    },
    /// Tabulated, or constant.
    Table(Spectrum),
}
