//! Radiation of a blackbody.

use crate::units::{BOLTZMANN, PLANCK, SPEED_OF_LIGHT};

/// Planck's law: B(λ, T) = 2hc²/λ⁵ / (exp(hc/(λkT)) − 1) in W·m⁻²·sr⁻¹·nm⁻¹, λ in nm and T in K, both above 0.
pub fn planck(lambda_nm: f64, temperature_k: f64) -> f64 {
    let lambda = lambda_nm * 1e-9;
    let exponent = PLANCK * SPEED_OF_LIGHT / (lambda * BOLTZMANN * temperature_k);
    // W·m⁻²·sr⁻¹ per metre of wavelength, then per nanometre.
    2.0 * PLANCK * SPEED_OF_LIGHT.powi(2) / lambda.powi(5) / exponent.exp_m1() * 1e-9
}
