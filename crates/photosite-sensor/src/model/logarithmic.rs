//! Logarithmic response of pixels.

use photosite_core::units::Seconds;

/// Pixels whose voltage follows the logarithm of their photocurrent,
///
/// V ∝ ln(1 + i/i₀),  i = q/t
///
/// with the charge q that light and heat free during the time t, over which the pixel averages, and the reference
/// current i₀, from which on the response is more logarithmic than linear
/// ([Kavadias00](photosite_core::references#kavadias00)). Signals are referred to electrons as those of linear pixels
/// are: s = q₀·ln(1 + q/q₀) with q₀ = i₀·t, which is q for little light. What the read-out adds, it adds to s. Below
/// zero the response is a straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Logarithmic {
    /// Reference current i₀, e⁻/s, above 0.
    pub reference_e_per_s: f64,
}

impl Logarithmic {
    pub(crate) fn signal(&self, charge_e: f64, time: Seconds) -> f64 {
        let reference = self.reference_e_per_s * time.0;
        if charge_e > 0.0 { reference * (charge_e / reference).ln_1p() } else { charge_e }
    }

    pub(crate) fn charge(&self, signal_e: f64, time: Seconds) -> f64 {
        let reference = self.reference_e_per_s * time.0;
        if signal_e > 0.0 { reference * (signal_e / reference).exp_m1() } else { signal_e }
    }
}
