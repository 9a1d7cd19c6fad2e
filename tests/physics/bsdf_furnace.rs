//! White furnace at every angle: no direction down to a cosine of 10⁻⁴ gives back more than arrives.
//!
//! The rule over directions is dense at the horizon, z = t², and about the planes of reflection and return,
//! φ = π(s − sin(2πs)/2π); lobes of a single direction are found by sampling.

use std::f64::consts::PI;

use glam::Vec3;
use photosite::bsdf::{Bsdf, Layered, Sheen};
use photosite::spectrum::SampledSpectrum;

use super::bsdf_cases::{Case, drawn, layered, squared_index, wide};
use super::quadrature::direction;

const COSINES: [f64; 10] = [1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 0.7, 1.0];

/// ∫ f·|cos| dω of each lane over both sides as power, in lobes of some width.
fn in_lobes(bsdf: &Bsdf, wo: Vec3, steps: usize) -> [f64; 4] {
    let mut sums = [0.0; 4];
    let at = |i: usize| (i as f64 + 0.5) / steps as f64;
    for (i, j) in (0..2 * steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
        let (t, s) = (at(i % steps), 2.0 * at(j) - 1.0);
        let z = if i < steps { t * t } else { -t * t };
        let wi = direction(z, PI * s - 0.5 * (2.0 * PI * s).sin());
        let solid_angle = 2.0 * t * 2.0 * PI * (1.0 - (2.0 * PI * s).cos()) / (steps * steps) as f64;
        let f = bsdf.eval(wo, wi).f * squared_index(bsdf, wo, wi);
        for (lane, sum) in sums.iter_mut().enumerate() {
            *sum += f64::from(f[lane]) * z.abs() * solid_angle;
        }
    }
    sums
}

/// Power in lobes of a single direction, which differ in their probabilities.
fn in_single_directions(bsdf: &Bsdf, wo: Vec3) -> [f64; 4] {
    let mut seen = Vec::new();
    let mut sums = [0.0; 4];
    for i in 0..4096 {
        let Some(sample) = bsdf.sample(wo, (i as f32 + 0.5) / 4096.0, [0.5; 2]).filter(|s| s.is_delta) else {
            continue;
        };
        if !seen.contains(&sample.pdf.0) {
            seen.push(sample.pdf.0);
            let part = sample.throughput() * (sample.pdf.0 * sample.eta * sample.eta);
            (0..4).for_each(|lane| sums[lane] += f64::from(part[lane]));
        }
    }
    sums
}

/// Sheen of every roughness on every base, polished and rough, without and with a coat above.
fn sheens() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, base) in layered(SampledSpectrum::ONE, &[[0.0, 0.0], [0.1, 0.1], [1.0, 1.0]]) {
        let is_under_coat = name.contains("coat 0.25") && name.contains("α 0.1");
        if !(name.contains("bare") || is_under_coat) || name.starts_with("half sheet") {
            continue;
        }
        for roughness in [0.0f32, 0.1, 0.2, 0.4, 1.0] {
            let sheen = Some(Sheen { colour: SampledSpectrum::ONE, alpha: roughness * roughness });
            let bsdf = Bsdf::Layered(Layered { sheen, ..base });
            cases.push(Case { name: format!("sheen of roughness {roughness} on {name}"), bsdf });
        }
    }
    cases
}

#[test]
fn no_angle_gives_back_more_than_arrives() {
    // Interpolated albedos of facets near the horizon, see `bsdf_robustness`, and what the coarser table of anisotropic
    // ones adds to them, see `bsdf_layered`.
    const TABLE: f64 = 0.03;
    const ANISOTROPIC: f64 = 0.009;
    const STEPS: usize = 64;
    let mut wrong = Vec::new();
    for case in wide().into_iter().chain(drawn(4)).chain(sheens()) {
        let table = if let Bsdf::Layered(layers) = &case.bsdf {
            let [x, y] = layers.distribution.alpha();
            if x == y { TABLE } else { TABLE + ANISOTROPIC }
        } else {
            0.0
        };
        for cos in COSINES {
            let wo = direction(cos, 0.0);
            let [coarse, fine] = [STEPS / 2, STEPS].map(|steps| in_lobes(&case.bsdf, wo, steps));
            let single = in_single_directions(&case.bsdf, wo);
            for lane in 0..4 {
                let power = fine[lane] + single[lane];
                // The rules' errors fall at least with the square of the step: the finer one's is below a third of this.
                let rule = (fine[lane] - coarse[lane]).abs() + 1e-4;
                if power > 1.0 + table + rule {
                    wrong.push(format!("{} cos {cos} lane {lane}: {power:.4} ± {rule:.4}", case.name));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of all:\n{}", wrong.len(), wrong.join("\n"));
}
