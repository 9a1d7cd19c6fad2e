//! Stacked photodiodes: silicon itself is the colour filter. Short wavelengths are absorbed near its surface, long ones
//! deep below, so diodes at different depths of one pixel see different colours.

use std::f64::consts::PI;

use photosite_core::spectrum::{Spectrum, library};

/// Quantum efficiency of a diode that collects every electron freed between two depths (µm, the upper one first):
///
/// η(λ) = exp(−α(λ)·z₀) − exp(−α(λ)·z₁),  α = 4π·k/λ
///
/// the part of the light that entered the silicon which is absorbed there, by the law of Beer and Lambert with the
/// extinction coefficient k(λ) of [Green08](photosite_core::references#green08). What is reflected before it enters is
/// left to the sensor's filter. Electrons that wander from layer to layer are left out.
pub(super) fn quantum_efficiency(depth_um: [f64; 2]) -> Spectrum {
    let silicon = library::silicon();
    Spectrum::from_fn(|lambda_nm| {
        let per_um = absorption_per_um(lambda_nm, silicon.k.eval(lambda_nm as f32).into());
        let [entering, leaving] = depth_um.map(|depth| (-per_um * depth).exp());
        entering - leaving
    })
}

/// α = 4π·k/λ in µm⁻¹.
fn absorption_per_um(lambda_nm: f64, k: f64) -> f64 {
    4.0 * PI * k / (lambda_nm * 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absorption_is_that_of_the_published_table() {
        // Green 2008, table 1: α in cm⁻¹ at 300 K. k is printed with at least three digits.
        let silicon = library::silicon();
        for (lambda_nm, per_cm) in [(400.0, 9.30e4), (450.0, 2.41e4), (550.0, 6390.0), (650.0, 2790.0), (1000.0, 64.0)]
        {
            let alpha = absorption_per_um(f64::from(lambda_nm), silicon.k.eval(lambda_nm).into()) * 1e4;
            assert!((alpha / per_cm - 1.0).abs() < 2e-3, "{alpha} for {per_cm} at {lambda_nm} nm");
        }
    }

    #[test]
    fn layers_share_what_the_whole_depth_absorbs() {
        let edges = [0.0, 0.3, 0.9, 4.0];
        let whole = quantum_efficiency([0.0, 4.0]);
        let layers: Vec<Spectrum> = edges.windows(2).map(|z| quantum_efficiency([z[0], z[1]])).collect();
        for lambda_nm in [300.0, 381.0, 450.0, 533.0, 650.0, 900.0, 1100.0] {
            let sum: f32 = layers.iter().map(|layer| layer.eval(lambda_nm)).sum();
            // Three roundings to f32 of numbers up to 1.
            assert!((sum - whole.eval(lambda_nm)).abs() < 4.0 * f32::EPSILON, "{lambda_nm} nm");
        }
        // 550 nm by hand: α = 4π·0.027968/0.55 = 0.6390115 µm⁻¹; exp(−0.3·α) − exp(−0.9·α) = 0.8255515 − 0.5626425.
        assert!((layers[1].eval(550.0) - 0.262_909).abs() < 2e-6, "{}", layers[1].eval(550.0));
    }

    #[test]
    fn deeper_layers_see_longer_waves() {
        let peaks: Vec<f64> = [[0.0, 0.4], [0.4, 1.2], [1.2, 5.0]]
            .map(|depth| {
                let (lambda, _) =
                    quantum_efficiency(depth).iter().fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
                lambda
            })
            .to_vec();
        assert!(peaks.is_sorted() && peaks[2] - peaks[0] > 100.0, "{peaks:?}");
    }
}
