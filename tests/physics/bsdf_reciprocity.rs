//! Helmholtz reciprocity: light that goes one way goes the other.

use std::f64::consts::TAU;

use glam::Vec3;
use photosite::bsdf::Bsdf;
use photosite::spectrum::SampledSpectrum;

use super::bsdf_cases::{Uniform, drawn, squared_index, wide};
use super::quadrature::direction;

/// f as the integrator asks for it: a surface of two equal sides is turned towards `wo`.
fn eval(bsdf: &Bsdf, wo: Vec3, wi: Vec3) -> SampledSpectrum {
    if wo.z < 0.0 && !bsdf.refracts() && bsdf.transmits() {
        return bsdf.eval(Vec3::new(wo.x, wo.y, -wo.z), Vec3::new(wi.x, wi.y, -wi.z)).f;
    }
    bsdf.eval(wo, wi).f
}

#[test]
fn swapping_the_directions_changes_nothing_but_the_index_factor() {
    for (number, case) in wide().into_iter().chain(drawn(40)).enumerate() {
        let mut uniform = Uniform::new(number);
        let mut compared = 0;
        for _ in 0..4000 {
            let mut random = || direction(2.0 * f64::from(uniform.next()) - 1.0, TAU * f64::from(uniform.next()));
            let (a, b) = (random(), random());
            let (there, back) = (eval(&case.bsdf, a, b), eval(&case.bsdf, b, a));
            // η²·f(wo, wi) = f(wi, wo), η the index on the side of wi over that on the side of wo.
            let factor = squared_index(&case.bsdf, a, b);
            for lane in 0..4 {
                let (there, back) = (there[lane] * factor, back[lane]);
                // Half vectors of refraction are right to 6e-8·(1 + η)/|η − 1| = 4e-7, ln D changes by up to 2/α = 20 a
                // radian; cosines near 0 are right to 1e-7, here down to some 1e-3 (8000 directions a case).
                // From inside the cosine of refraction is the root of a difference near 0 at the critical angle, right
                // to √1.2e-7 = 3.5e-4, and reflectance falls with it by up to 4η/cos θ, some 5 times as fast.
                let relative = if a.z < 0.0 && b.z < 0.0 { 2e-3 } else { 1e-4 };
                let tolerance = relative * there.abs().max(back.abs()) + 1e-9;
                assert!((there - back).abs() <= tolerance, "{} {a} {b} lane {lane}: {there} {back}", case.name);
                compared += u32::from(there > 0.0);
            }
        }
        assert!(compared > 1000, "{}: only {compared} pairs scatter", case.name);
    }
}
