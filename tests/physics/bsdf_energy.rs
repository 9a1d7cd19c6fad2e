//! White furnace: a surface under uniform light gives back no more than arrives, and exactly what the model keeps.
//!
//! The reference integrates over the slopes of the facets instead of over directions, in f64, with D, Λ and Fresnel's
//! equations in their textbook forms, so that it shares neither code nor parametrisation with the program.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use photosite::bsdf::{Bsdf, Conductor, Diffuse, Ggx, OrenNayar, Phong, RelativeIndex, ThinDielectric, Translucent};
use photosite::spectrum::SampledSpectrum;

use super::bsdf_cases::{ALPHAS, above, compensated, glass, gltf, gold, lossless_metal, squared_index, visible_from};
use super::quadrature::integrate_sphere;

/// ∫ f·|cos| dω of the hero over the side of `wo` and over the other.
fn albedo(bsdf: &Bsdf, wo: Vec3) -> [f64; 2] {
    let over = |same_side: bool| {
        integrate_sphere(|wi| {
            if (wi.z * wo.z > 0.0) == same_side { f64::from(bsdf.eval(wo, wi).f[0] * wi.z.abs()) } else { 0.0 }
        })
    };
    [over(true), over(false)]
}

/// Smith's Λ in tan θ.
fn lambda(w: DVec3, [x, y]: [f64; 2]) -> f64 {
    0.5 * ((1.0 + ((x * w.x).powi(2) + (y * w.y).powi(2)) / (w.z * w.z)).sqrt() - 1.0)
}

/// Light that facets reflect and refract of uniform light, as fractions of the power: mean over the slopes
/// (p, q) = r·(α_x·cos φ, α_y·sin φ), whose density is dφ/(2π)·d(r²/(1 + r²)), of the facet's area seen from wo, times
/// what it does with the light. `eta` is that of the far side; the reflectance is `fresnel(cos)`. The area grows with
/// r, so the radial variable is t = 1/√(1 + r²), in which nothing diverges: d(r²/(1 + r²)) = 2t dt.
fn single_bounce(wo: DVec3, alpha: [f64; 2], eta: f64, fresnel: impl Fn(f64) -> f64) -> [f64; 2] {
    let n = 200;
    let (mut reflected, mut refracted) = (0.0, 0.0);
    for i in 0..n * n {
        let (t, phi) = (((i / n) as f64 + 0.5) / n as f64, 2.0 * PI * ((i % n) as f64 + 0.5) / n as f64);
        let r = (1.0 - t * t).sqrt() / t;
        let facet = DVec3::new(-alpha[0] * r * phi.cos(), -alpha[1] * r * phi.sin(), 1.0);
        let (slope, m) = (facet.length(), facet.normalize());
        let cos = wo.dot(m);
        if cos <= 0.0 {
            continue;
        }
        let seen = 2.0 * t * cos * slope / wo.z;
        let r = fresnel(cos);
        let mirror = 2.0 * cos * m - wo;
        if mirror.z > 0.0 {
            reflected += r * seen / (1.0 + lambda(wo, alpha) + lambda(mirror, alpha));
        }
        let cos_far2 = 1.0 - (1.0 - cos * cos) / (eta * eta);
        if cos_far2 > 0.0 {
            let through = (cos / eta - cos_far2.sqrt()) * m - wo / eta;
            if through.z < 0.0 {
                refracted += (1.0 - r) * seen / ((1.0 + lambda(wo, alpha)) * (1.0 + lambda(through, alpha)));
            }
        }
    }
    [reflected, refracted].map(|sum| sum / (n * n) as f64)
}

/// The clear interface, by r_s = −sin(θ − θ')/sin(θ + θ'), r_p = tan(θ − θ')/tan(θ + θ').
fn clear(cos: f64, eta: f64) -> f64 {
    let theta = cos.min(1.0).acos();
    let sin_far = theta.sin() / eta;
    if sin_far >= 1.0 {
        return 1.0;
    }
    if theta < 1e-6 {
        return ((eta - 1.0) / (eta + 1.0)).powi(2);
    }
    let far = sin_far.asin();
    let (s, p) = ((theta - far).sin() / (theta + far).sin(), (theta - far).tan() / (theta + far).tan());
    0.5 * (s * s + p * p)
}

/// The midpoint rule on 200² points: the horizon cuts through cells, whose number is of order n, for an error of some
/// 1/n² each with random sign; the other integral is good to 1e-4.
const TOLERANCE: f64 = 5e-4;

/// η² of refraction: transmitted radiance is the power over η².
fn radiance_to_power(bsdf: &Bsdf, wo: Vec3) -> f64 {
    f64::from(squared_index(bsdf, wo, -wo))
}

#[test]
fn a_white_diffuse_surface_gives_back_everything() {
    let white = Bsdf::Diffuse(Diffuse { reflectance: SampledSpectrum::ONE });
    for (from, wo) in above() {
        let [power, _] = albedo(&white, wo);
        assert!((power - 1.0).abs() < 1e-5, "{from}: {power}");
    }
}

#[test]
fn a_white_surface_with_relief_gives_back_everything() {
    for roughness in [0.2, 0.6, 1.0] {
        let white = Bsdf::OrenNayar(OrenNayar { reflectance: SampledSpectrum::ONE, roughness });
        for (from, wo) in above() {
            let [power, _] = albedo(&white, wo);
            // The quadrature's 1e-5, and as much again for f's bends.
            assert!((power - 1.0).abs() < 1e-4, "roughness {roughness} {from}: {power}");
        }
    }
}

#[test]
fn phongs_lobe_along_the_normal_holds_all_of_its_part() {
    // ∫ (n + 2)/2π·cosⁿ⁺¹ dω = 1; from elsewhere the horizon cuts some off.
    for exponent in [0.0, 4.0, 50.0] {
        let [diffuse, specular] = [0.3, 0.5].map(SampledSpectrum::splat);
        let phong = Bsdf::Phong(Phong { diffuse, specular, exponent });
        let powers: Vec<f64> = above().into_iter().map(|(_, wo)| albedo(&phong, wo)[0]).collect();
        assert!((powers[0] - 0.8).abs() < 1e-4, "n {exponent}: {powers:?}");
        assert!(powers.iter().all(|&power| power < 0.8 + 1e-4), "n {exponent}: {powers:?}");
    }
}

#[test]
fn translucent_sheets_keep_their_two_parts() {
    let sheet = Bsdf::Translucent(Translucent {
        reflectance: SampledSpectrum::splat(0.25),
        transmittance: SampledSpectrum::splat(0.6),
    });
    for (from, wo) in above() {
        let [reflected, passed] = albedo(&sheet, wo);
        assert!((reflected - 0.25).abs() < 1e-5 && (passed - 0.6).abs() < 1e-5, "{from}: {reflected} {passed}");
    }
}

#[test]
fn panes_are_the_sum_of_the_bounces_between_their_surfaces() {
    for (index, transmittance) in [(1.5f32, 1.0f32), (1.5, 0.7), (2.4, 0.95), (1.0, 0.5)] {
        let pane = Bsdf::ThinDielectric(ThinDielectric {
            index: RelativeIndex::constant(index),
            transmittance: SampledSpectrum::splat(transmittance),
        });
        for (from, wo) in above() {
            let (n, cos) = (f64::from(index), f64::from(wo.z));
            let r = clear(cos, n);
            let inside = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
            let once = f64::from(transmittance).powf(1.0 / inside);
            let (mut reflected, mut passed, mut left) = (r, 0.0, (1.0 - r) * once);
            for bounce in 0..200 {
                let out = left * (1.0 - r);
                if bounce % 2 == 0 {
                    passed += out
                } else {
                    reflected += out
                }
                left *= r * once;
            }
            let power = |u_lobe: f32| {
                let ray = pane.sample(wo, u_lobe, [0.5; 2]).expect("goes on");
                assert!(ray.is_delta && (ray.is_transmission == (u_lobe > 0.5)), "{from}");
                f64::from(ray.throughput()[0] * ray.pdf.0)
            };
            // Rounding of f32 Fresnel equations, at 80° some 1e-6. Without an interface nothing is reflected.
            assert!((power(0.999_999) - passed).abs() < 1e-5, "n {index} τ {transmittance} {from}: {passed}");
            if index > 1.0 {
                assert!((power(0.0) - reflected).abs() < 1e-5, "n {index} τ {transmittance} {from}: {reflected}");
            }
        }
    }
}

#[test]
fn a_lossless_metal_loses_the_second_bounce_only() {
    for [x, y] in ALPHAS {
        for (from, wo) in above() {
            let [found, _] = albedo(&lossless_metal(Ggx::new(x, y)), wo);
            let [expected, _] = single_bounce(wo.as_dvec3(), [x, y].map(f64::from), 1.0, |_| 1.0);
            assert!((found - expected).abs() < TOLERANCE, "α {x} {y} {from}: {found} is not {expected}");
        }
    }
}

#[test]
fn gold_gives_back_what_its_facets_do() {
    let Bsdf::Conductor(Conductor { eta, k, .. }) = gold(Ggx::SMOOTH) else { unreachable!("gold is a conductor") };
    for [x, y] in ALPHAS {
        for (from, wo) in above() {
            let [found, _] = albedo(&gold(Ggx::new(x, y)), wo);
            let fresnel = |cos: f64| f64::from(photosite::bsdf::fresnel::conductor(cos as f32, eta, k)[0]);
            let [expected, _] = single_bounce(wo.as_dvec3(), [x, y].map(f64::from), 1.0, fresnel);
            assert!((found - expected).abs() < TOLERANCE, "α {x} {y} {from}: {found} is not {expected}");
        }
    }
}

#[test]
fn rough_glass_reflects_and_refracts_what_its_facets_do() {
    for eta in [1.33f32, 2.4] {
        for [x, y] in ALPHAS {
            let bsdf = glass(eta, Ggx::new(x, y));
            for (from, wo) in visible_from(&bsdf) {
                let [reflected, transmitted] = albedo(&bsdf, wo);
                let found = [reflected, transmitted * radiance_to_power(&bsdf, wo)];
                let relative = f64::from(if wo.z > 0.0 { eta } else { 1.0 / eta });
                let above = wo.as_dvec3().with_z(f64::from(wo.z.abs()));
                let expected = single_bounce(above, [x, y].map(f64::from), relative, |cos| clear(cos, relative));
                for (which, found, expected) in
                    [("reflected", found[0], expected[0]), ("refracted", found[1], expected[1])]
                {
                    assert!(
                        (found - expected).abs() < TOLERANCE,
                        "η {eta} α {x} {y} {from}: {which} {found} is not {expected}"
                    );
                }
            }
        }
    }
}

/// glTF's coat: the specification's α = roughness², Schlick's factor.
fn schlick(f0: f64) -> impl Fn(f64) -> f64 {
    move |cos: f64| f0 + (1.0 - f0) * (1.0 - cos).powi(5)
}

/// The tabulated albedo is interpolated: right to 1e-3 beyond 3° from the surface.
const TABLE: f64 = 1e-3;

#[test]
fn a_white_base_under_a_coat_gives_back_everything() {
    for roughness in [0.32f32, 0.45, 0.6, 0.8, 1.0] {
        for (from, wo) in above() {
            let [power, _] = albedo(&gltf(1.0, 0.0, Ggx::from_roughness(roughness, 0.0)), wo);
            assert!((power - 1.0).abs() < TABLE + TOLERANCE, "roughness {roughness} {from}: {power}");
        }
    }
}

#[test]
fn a_white_base_under_a_smooth_coat_gives_back_everything() {
    let bsdf = gltf(1.0, 0.0, Ggx::SMOOTH);
    for (from, wo) in above() {
        let mirror = bsdf.sample(wo, 0.0, [0.5; 2]).expect("reflects");
        assert!(mirror.is_delta, "{from}");
        let [base, _] = albedo(&bsdf, wo);
        let power = base + f64::from(mirror.throughput()[0] * mirror.pdf.0);
        assert!((power - 1.0).abs() < TABLE, "{from}: {power}");
    }
}

/// ∫2μ·E(μ) dμ of white facets, by Gauss–Legendre quadrature with 5 points in μ².
fn mean_white(alpha: f64) -> f64 {
    let rule = [
        (0.046_910_077, 0.118_463_443),
        (0.230_765_345, 0.239_314_335),
        (0.5, 0.284_444_444),
        (0.769_234_655, 0.239_314_335),
        (0.953_089_923, 0.118_463_443),
    ];
    let at = |x: f64| DVec3::new((1.0 - x).sqrt(), 0.0, x.sqrt());
    rule.iter().map(|&(x, weight)| weight * single_bounce(at(x), [alpha; 2], 1.0, |_| 1.0)[0]).sum()
}

#[test]
fn coat_base_and_metal_each_keep_their_share() {
    for [metallic, base] in [[0.0, 0.0], [0.0, 0.5], [0.4, 0.5], [1.0, 0.5], [1.0, 1.0]] {
        for alpha in [0.1f32, 0.5, 1.0] {
            for (from, wo) in above() {
                let [power, _] = albedo(&gltf(base as f32, metallic as f32, Ggx::new(alpha, alpha)), wo);
                let facets = |f0| single_bounce(wo.as_dvec3(), [f64::from(alpha); 2], 1.0, schlick(f0))[0];
                // What the coat lets in comes out times the base colour: K integrates to 1 − E.
                let coat = facets(0.04);
                // Light that bounces on between metal facets takes their mean reflectance each time (Kulla and Conty):
                // of what leaves a bounce, Ē escapes.
                let mean = mean_white(f64::from(alpha));
                let f = base + (1.0 - base) / 21.0;
                let bounced = f * f * mean / (1.0 - f * (1.0 - mean)) * (1.0 - facets(1.0));
                let expected = (1.0 - metallic) * (coat + base * (1.0 - coat)) + metallic * (facets(base) + bounced);
                let name = format!("metallic {metallic} base {base} α {alpha} {from}");
                assert!((power - expected).abs() < TABLE + TOLERANCE, "{name}: {power} is not {expected}");
                assert!(power < 1.0 + TABLE, "{name}: {power}");
            }
        }
    }
}

#[test]
fn compensated_metals_and_glass_keep_what_further_bounces_do() {
    for alpha in [0.1f32, 0.3, 0.6, 1.0] {
        let ggx = Ggx::new(alpha, alpha);
        let mean = mean_white(f64::from(alpha));
        let Bsdf::Conductor(Conductor { eta, k, .. }) = gold(ggx) else { unreachable!("gold is a conductor") };
        let fresnel = |cos: f64| f64::from(photosite::bsdf::fresnel::conductor(cos as f32, eta, k)[0]);
        let average: f64 = (0..1000).map(|i| (i as f64 + 0.5) / 1000.0).map(|mu| 2.0 * mu * fresnel(mu) / 1000.0).sum();
        for (from, wo) in above() {
            let facets =
                |fresnel: &dyn Fn(f64) -> f64| single_bounce(wo.as_dvec3(), [f64::from(alpha); 2], 1.0, fresnel)[0];
            let [white, _] = albedo(&compensated(lossless_metal(ggx)), wo);
            assert!((white - 1.0).abs() < TABLE + TOLERANCE, "white metal α {alpha} {from}: {white}");
            // Kulla and Conty: of what leaves a bounce Ē escapes, and each takes the mean reflectance.
            let further = average * average * mean / (1.0 - average * (1.0 - mean)) * (1.0 - facets(&|_| 1.0));
            let expected = facets(&fresnel) + further;
            let [found, _] = albedo(&compensated(gold(ggx)), wo);
            // Four points of Gauss and Legendre integrate gold's smooth reflectance to 1e-4.
            assert!((found - expected).abs() < TABLE + TOLERANCE + 1e-4, "gold α {alpha} {from}: {found}, {expected}");
        }
        for eta in [1.33f32, 1.5, 2.4] {
            let bsdf = compensated(glass(eta, ggx));
            for (from, wo) in visible_from(&bsdf) {
                let [reflected, transmitted] = albedo(&bsdf, wo);
                let found = reflected + transmitted * radiance_to_power(&bsdf, wo);
                // The table of interfaces, see `bsdf::albedo::glass`.
                assert!((found - 1.0).abs() < 6e-3 + TOLERANCE, "glass η {eta} α {alpha} {from}: {found}");
            }
        }
    }
    // Anisotropic facets have a coarser table, see `bsdf::albedo::reflection`.
    for [x, y] in [[0.5, 0.9], [0.9, 0.2]] {
        for (from, wo) in above() {
            let [white, _] = albedo(&compensated(lossless_metal(Ggx::new(x, y))), wo);
            assert!((white - 1.0).abs() < 0.015 + TOLERANCE, "white metal α {x} {y} {from}: {white}");
        }
    }
}
