//! glTF's material against the formulae of its specification, appendix B.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use photosite::bsdf::{Bsdf, Ggx, Layered};
use photosite::spectrum::SampledSpectrum;

use super::bsdf_cases::{Uniform, above, gltf};
use super::quadrature::{direction, integrate_sphere};

/// F₀ + (1 − F₀)(1 − |V·H|)⁵.
fn schlick(f0: f64, cos: f64) -> f64 {
    f0 + (1.0 - f0) * (1.0 - cos).powi(5)
}

/// Facets of that reflectance at normal incidence over a base that absorbs all it gets.
fn black(f0: f32, distribution: Ggx) -> Bsdf {
    let (base_colour, f0) = (SampledSpectrum::ZERO, SampledSpectrum::splat(f0));
    Bsdf::Layered(Layered { base_colour, f0, distribution, ..Layered::default() })
}

/// The appendix's V·D, with its N·L and its α² (written a2), for one roughness in all directions.
fn specular(roughness: f64, v: DVec3, l: DVec3) -> f64 {
    let h = (v + l).normalize();
    let a2 = roughness.powi(4);
    let d = a2 / (PI * (h.z * h.z * (a2 - 1.0) + 1.0).powi(2));
    let visibility = 0.5 / (l.z * (v.z * v.z * (1.0 - a2) + a2).sqrt() + v.z * (l.z * l.z * (1.0 - a2) + a2).sqrt());
    visibility * d
}

#[test]
fn facets_over_black_are_those_of_the_specification() {
    for roughness in [0.2f32, 0.5, 0.8, 1.0] {
        let ggx = Ggx::from_roughness(roughness, 0.0);
        for f0 in [0.04, 0.6] {
            let mut uniform = Uniform::new(0);
            for (from, wo) in above() {
                for _ in 0..1000 {
                    let wi = direction(f64::from(uniform.next()).max(1e-3), 2.0 * PI * f64::from(uniform.next()));
                    let [v, l] = [wo.as_dvec3(), wi.as_dvec3()];
                    let expected = schlick(f0, v.dot((v + l).normalize())) * specular(f64::from(roughness), v, l);
                    let found = f64::from(black(f0 as f32, ggx).eval(wo, wi).f[0]);
                    // The half vector is right to 2e-7; ln D changes by at most 2/α = 50 a radian.
                    let tolerance = 2e-5 * expected + 1e-7;
                    let name = format!("roughness {roughness} F₀ {f0} {from} {wi}");
                    assert!((found - expected).abs() < tolerance, "{name}: {found} is not {expected}");
                }
            }
        }
    }
}

#[test]
fn the_specifications_diffuse_term_would_give_back_more_than_arrives() {
    // What `layered` says of it: base·(1 − F(wo·m)) + coat on a smooth white surface from 80°.
    let wo = direction(80f64.to_radians().cos(), 0.0);
    let base = integrate_sphere(|wi| {
        let cos = f64::from(wo.dot((wo + wi).normalize()));
        if wi.z > 0.0 { (1.0 - schlick(0.04, cos)) * f64::from(wi.z) / PI } else { 0.0 }
    });
    let power = base + schlick(0.04, f64::from(wo.z));
    assert!((power - 1.35).abs() < 0.005, "{power}");
}

#[test]
fn polished_metal_is_a_mirror_and_polished_plastic_is_not_only_one() {
    let (metal, plastic) = (gltf(0.7, 1.0, Ggx::SMOOTH), gltf(0.7, 0.0, Ggx::SMOOTH));
    assert!(metal.is_delta() && !plastic.is_delta());
    for (from, wo) in above() {
        for u_lobe in [0.0, 0.5, 0.999] {
            let ray = metal.sample(wo, u_lobe, [0.2, 0.3]).expect("a mirror reflects");
            assert_eq!(ray.wi, Vec3::new(-wo.x, -wo.y, wo.z), "{from}");
            assert!((f64::from(ray.throughput()[0]) - schlick(0.7, f64::from(wo.z))).abs() < 1e-6, "{from}");
        }
        assert!(plastic.sample(wo, 0.0, [0.2, 0.3]).expect("the coat reflects").is_delta, "{from}");
        let base = plastic.sample(wo, 0.999, [0.2, 0.3]).expect("the base reflects");
        assert!(!base.is_delta && base.f[0] > 0.0, "{from}");
    }
}
