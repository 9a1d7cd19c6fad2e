//! The refractive index of a clear medium as a function of wavelength.
//!
//! Coefficients are those that glass makers publish, wavelengths are in nm. The index is relative to the medium that
//! the coefficients refer to, normally air. Fresnel reflection and refraction are left to the BSDFs of
//! `photosite-transport`; the coefficients of named glasses are in [`library`](super::library).

use super::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, Spectrum};
use crate::Invalid;

/// Fraunhofer lines that indices and Abbe numbers are published at, nm (ISO 7944).
pub mod lines {
    /// d, helium yellow.
    pub const D: f64 = 587.5618;
    /// F, hydrogen blue.
    pub const F: f64 = 486.1327;
    /// C, hydrogen red.
    pub const C: f64 = 656.2725;
}

/// Refractive index of a clear medium as a function of wavelength.
#[derive(Clone, Debug, PartialEq)]
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
        /// Coefficient of λ⁻², µm².
        b_um2: f64,
        /// Coefficient of λ⁻⁴, µm⁴.
        c_um4: f64,
    },
    /// n² = Σ aₖ·λ^eₖ, λ in µm: Schott's older formula, and those of other makers.
    Polynomial {
        /// Pairs aₖ, eₖ.
        terms: Vec<[f64; 2]>,
    },
    /// n = A + B/λ + C/λ^3.5, λ in µm ([Conrady60](crate::references#conrady60)).
    Conrady {
        /// Index at infinite wavelength.
        a: f64,
        /// Coefficient of λ⁻¹, µm.
        b_um: f64,
        /// Coefficient of λ^−3.5, µm^3.5.
        c_um35: f64,
    },
    /// Tabulated, or constant index.
    Table(Spectrum),
}

impl Dispersion {
    /// Medium of a constant index.
    pub fn constant(index: f64) -> Self {
        Self::Cauchy { a: index, b_um2: 0.0, c_um4: 0.0 }
    }

    /// Cauchy's formula with two terms from the figures that a catalogue gives: the index at the d line and the Abbe
    /// number V_d = (n_d − 1)/(n_F − n_C). An infinite Abbe number means no dispersion.
    pub fn from_abbe(n_d: f64, abbe: f64) -> Result<Self, Invalid> {
        if !n_d.is_finite() || n_d <= 0.0 {
            let message = format!("refractive index {n_d} is not above 0");
            return Err(Invalid::new("", message).help("window glass has 1.52, water 1.33"));
        }
        if abbe.is_nan() || abbe <= 0.0 {
            let message = format!("Abbe number {abbe} is not above 0");
            return Err(Invalid::new("", message).help("glasses have Abbe numbers of 20 to 90"));
        }
        let per_um2 = |line_nm: f64| (line_nm * 1e-3).powi(-2);
        let b_um2 = (n_d - 1.0) / (abbe * (per_um2(lines::F) - per_um2(lines::C)));
        Ok(Self::Cauchy { a: n_d - b_um2 * per_um2(lines::D), b_um2, c_um4: 0.0 })
    }

    /// Refractive index at a wavelength in nm. Beyond 300–1100 nm a table gives the index of its nearer end; a formula
    /// is evaluated as it stands. Meaningful only after [`validated`](Self::validated).
    pub fn index(&self, lambda_nm: f64) -> f64 {
        match self {
            Self::Sellmeier { b, c_um2 } => {
                let squared = (lambda_nm * 1e-3).powi(2);
                let sum: f64 = b.iter().zip(c_um2).map(|(b, c)| b * squared / (squared - c)).sum();
                (1.0 + sum).sqrt()
            }
            Self::Cauchy { a, b_um2, c_um4 } => {
                let inverse = (lambda_nm * 1e-3).powi(-2);
                a + inverse * (b_um2 + inverse * c_um4)
            }
            Self::Polynomial { terms } => {
                let um = lambda_nm * 1e-3;
                terms.iter().map(|&[a, e]| a * um.powf(e)).sum::<f64>().sqrt()
            }
            Self::Conrady { a, b_um, c_um35 } => {
                let um = lambda_nm * 1e-3;
                a + b_um / um + c_um35 * um.powf(-3.5)
            }
            Self::Table(spectrum) => f64::from(spectrum.eval((lambda_nm as f32).clamp(LAMBDA_MIN_NM, LAMBDA_MAX_NM))),
        }
    }

    /// The index at every nanometre from 300 to 1100 nm.
    pub fn to_spectrum(&self) -> Spectrum {
        Spectrum::from_fn(|lambda| self.index(lambda))
    }

    /// V_d = (n_d − 1)/(n_F − n_C); infinite where there is no dispersion.
    pub fn abbe_number(&self) -> f64 {
        let difference = self.index(lines::F) - self.index(lines::C);
        if difference == 0.0 { f64::INFINITY } else { (self.index(lines::D) - 1.0) / difference }
    }

    /// Whether the index is 1 at all wavelengths, as in vacuum: light goes straight on.
    pub fn is_one(&self) -> bool {
        self.is_constant() && self.index(lines::D) == 1.0
    }

    /// Whether the index is the same at every wavelength, so that a refracted path may keep all its wavelengths.
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Sellmeier { b, c_um2 } => b.iter().zip(c_um2).all(|(&b, &c)| b == 0.0 || c == 0.0),
            Self::Cauchy { b_um2, c_um4, .. } => *b_um2 == 0.0 && *c_um4 == 0.0,
            Self::Polynomial { terms } => terms.iter().all(|&[a, e]| a == 0.0 || e == 0.0),
            Self::Conrady { b_um, c_um35, .. } => *b_um == 0.0 && *c_um35 == 0.0,
            Self::Table(spectrum) => spectrum.min() == spectrum.max(),
        }
    }

    /// Checks that the index is a finite number above 0 from 300 to 1100 nm: coefficients in equal number, no resonance
    /// in that range. Indices below 1 are allowed, for a bubble of air is 1/1.33 relative to water.
    pub fn validated(self) -> Result<Self, Invalid> {
        if let Self::Sellmeier { b, c_um2 } = &self {
            if b.len() != c_um2.len() || b.is_empty() {
                let message = format!("{} Sellmeier strengths and {} resonances", b.len(), c_um2.len());
                return Err(Invalid::new("", message).help("give as many Bᵢ as Cᵢ (µm²), at least one"));
            }
            let [shortest, longest] = [LAMBDA_MIN_NM, LAMBDA_MAX_NM].map(|nm| f64::from(nm) * 1e-3);
            let inside = |(b, c): &(&f64, &f64)| **b != 0.0 && (shortest.powi(2)..=longest.powi(2)).contains(*c);
            if let Some((_, c)) = b.iter().zip(c_um2).find(inside) {
                let message = format!("Cᵢ = {c} µm² puts a resonance at {:.0} nm", c.sqrt() * 1e3);
                let help =
                    "Cᵢ are squared wavelengths in µm², below 0.09 or above 1.21; square them if they are not yet";
                return Err(Invalid::new("", message).help(help));
            }
        }
        let bad = |(_, n): &(f64, f64)| !(n.is_finite() && *n > 0.0);
        match self.to_spectrum().iter().find(bad) {
            Some((lambda, n)) => {
                let message = format!("refractive index {n} at {lambda} nm");
                Err(Invalid::new("", message).help("it must be above 0 from 300 to 1100 nm; check the coefficients"))
            }
            None => Ok(self),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Schott's coefficients of N-BK7.
    fn bk7() -> Dispersion {
        Dispersion::Sellmeier {
            b: vec![1.03961212, 0.231792344, 1.01046945],
            c_um2: vec![0.00600069867, 0.0200179144, 103.560653],
        }
    }

    #[test]
    fn sellmeier_gives_the_published_indices_of_n_bk7() {
        // Schott data sheet N-BK7 517642.251: five decimals, so half a unit of the fifth.
        for (line, published) in [(lines::D, 1.51680), (lines::F, 1.52238), (lines::C, 1.51432), (1060.0, 1.50669)] {
            assert!((bk7().index(line) - published).abs() <= 0.5e-5, "{line}: {}", bk7().index(line));
        }
        // V_d = 64.17, two decimals.
        assert!((bk7().abbe_number() - 64.17).abs() <= 0.005, "{}", bk7().abbe_number());
    }

    #[test]
    fn polynomials_and_conradys_formula_give_the_published_indices() {
        // Schott's catalogue of the 1980s, BK7: n² from λ² to λ⁻⁸.
        let terms = vec![
            [2.2718929, 0.0],
            [-0.010108077, 2.0],
            [0.010592509, -2.0],
            [0.00020816965, -4.0],
            [-7.6472538e-6, -6.0],
            [4.9240991e-7, -8.0],
        ];
        let bk7_of_1980 = Dispersion::Polynomial { terms };
        for (line, published) in [(lines::D, 1.51680), (lines::F, 1.52238), (lines::C, 1.51432)] {
            assert!((bk7_of_1980.index(line) - published).abs() <= 1e-5, "{line}: {}", bk7_of_1980.index(line));
        }
        assert!(!bk7_of_1980.is_constant());
        // The glass 1.6280/57.0 by NumPy, from n_d, n_F − n_C and the normal line.
        let patent = Dispersion::Conrady { a: 1.6028636120142, b_um: 0.012823735981701, c_um35: 0.00051481705470054 };
        assert!((patent.index(lines::D) - 1.628).abs() < 1e-12, "{}", patent.index(lines::D));
        assert!((patent.abbe_number() - 57.0).abs() < 1e-9, "{}", patent.abbe_number());
    }

    #[test]
    fn cauchy_from_abbe_gives_index_and_abbe_number_back() {
        let flint = Dispersion::from_abbe(1.62004, 36.37).expect("valid").validated().expect("valid");
        assert!((flint.index(lines::D) - 1.62004).abs() < 1e-12);
        assert!((flint.abbe_number() - 36.37).abs() < 1e-9);
        assert!(Dispersion::from_abbe(1.5, f64::INFINITY).expect("valid").is_constant());
    }

    #[test]
    fn tables_hold_their_ends_and_follow_the_formula() {
        let table = Dispersion::Table(bk7().to_spectrum());
        // A table of 1 nm of a smooth index: curvature below 3e-5 nm⁻² at 300 nm, so an error below 1e-5.
        for lambda in [300.0, 412.3, 587.5618, 1100.0] {
            assert!((table.index(lambda) - bk7().index(lambda)).abs() < 1e-5);
        }
        assert_eq!(table.index(2000.0), table.index(1100.0));
        assert!(table.index(100.0) > 1.5);
    }

    #[test]
    fn constant_indices_are_recognised() {
        assert!(Dispersion::constant(1.5).is_constant());
        assert!(Dispersion::Table(Spectrum::constant(1.5)).is_constant());
        assert!(!bk7().is_constant());
        assert!(Dispersion::constant(1.0).is_one() && !Dispersion::constant(1.5).is_one() && !bk7().is_one());
        assert_eq!(Dispersion::constant(1.5).abbe_number(), f64::INFINITY);
    }

    #[test]
    fn impossible_coefficients_are_refused() {
        let sellmeier = |b: &[f64], c: &[f64]| Dispersion::Sellmeier { b: b.to_vec(), c_um2: c.to_vec() };
        for bad in [
            sellmeier(&[], &[]),
            sellmeier(&[1.0, 0.2], &[0.006]),
            sellmeier(&[1.0], &[0.25]),
            sellmeier(&[-3.0], &[0.006]),
            sellmeier(&[f64::NAN], &[0.006]),
            Dispersion::constant(0.0),
            Dispersion::constant(f64::INFINITY),
            Dispersion::Table(Spectrum::constant(-1.0)),
        ] {
            assert!(bad.clone().validated().is_err(), "{bad:?}");
        }
        assert!(bk7().validated().is_ok());
        assert!(Dispersion::from_abbe(1.5, f64::NAN).is_err());
        assert!(Dispersion::from_abbe(f64::NAN, 60.0).is_err());
    }
}
