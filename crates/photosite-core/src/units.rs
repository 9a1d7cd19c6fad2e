//! Units and constants: the newtypes that keep electrons from being taken for digital numbers, and the exact SI
//! constants of [CODATA 2018](crate::references#codata18), in one place.
//!
//! Inside the program quantities are SI, with two exceptions that the field agrees on: wavelengths are in nanometres
//! and temperatures of devices in degrees Celsius.

/// Planck constant h, J·s.
pub const PLANCK: f64 = 6.626_070_15e-34;
/// Speed of light in vacuum c, m·s⁻¹.
pub const SPEED_OF_LIGHT: f64 = 299_792_458.0;
/// Boltzmann constant k, J·K⁻¹.
pub const BOLTZMANN: f64 = 1.380_649e-23;
/// Charge of an electron e, C.
pub const ELEMENTARY_CHARGE: f64 = 1.602_176_634e-19;
/// Luminous efficacy of monochromatic radiation of 540 THz K_cd, lm·W⁻¹.
pub const LUMINOUS_EFFICACY: f64 = 683.0;
/// 0 °C in kelvin.
pub const ZERO_CELSIUS: f64 = 273.15;

/// Energy of one photon, J: E = h·c/λ. λ in nm, above 0.
pub fn photon_energy(lambda_nm: f64) -> f64 {
    PLANCK * SPEED_OF_LIGHT / (lambda_nm * 1e-9)
}

/// A charge, or a mean charge, in electrons (e⁻).
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Electrons(pub f64);

/// A digital number (DN), before or after rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct DigitalNumber(pub f64);

/// A duration in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Seconds(pub f64);

/// A temperature in degrees Celsius.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Celsius(pub f64);

/// A gain in decibels: factor = 10^(dB/20).
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Decibels(pub f64);

impl Decibels {
    /// The amplitude factor 10^(dB/20).
    pub fn factor(self) -> f64 {
        10f64.powf(self.0 / 20.0)
    }

    /// The gain of an amplitude factor above 0.
    pub fn of_factor(factor: f64) -> Self {
        Self(20.0 * factor.log10())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_green_photon_carries_3_58e_minus_19_joule() {
        // h·c = 1.98644586e-25 J·m, divided by 555 nm.
        assert!((photon_energy(555.0) - 3.579_182_6e-19).abs() < 1e-25);
    }

    #[test]
    fn twenty_decibels_are_a_factor_of_ten() {
        assert!((Decibels(20.0).factor() - 10.0).abs() < 1e-12);
        assert!((Decibels::of_factor(10.0).0 - 20.0).abs() < 1e-12);
    }
}
