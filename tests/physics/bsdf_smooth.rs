//! Mirrors and polished glass: laws of reflection and refraction, energy, dispersion.

use std::collections::BTreeMap;

use glam::Vec3;
use photosite::bsdf::{Bsdf, BsdfSample, Conductor, Dielectric, Ggx, RelativeIndex, fresnel};
use photosite::spectrum::SampledSpectrum;

use super::bsdf_cases::{above, glass, gold, visible_from};

/// The reflected and the refracted ray of a smooth dielectric, each found by choosing its lobe.
fn both_rays(bsdf: &Bsdf, wo: Vec3) -> BTreeMap<bool, BsdfSample> {
    let rays = [0.0, 0.999_999_9].into_iter().filter_map(|u| bsdf.sample(wo, u, [0.3, 0.7]));
    rays.map(|ray| (ray.is_transmission, ray)).collect()
}

#[test]
fn a_mirror_reflects_what_fresnel_says_into_one_direction() {
    let Bsdf::Conductor(Conductor { eta, k, .. }) = gold(Ggx::SMOOTH) else { unreachable!("gold is a conductor") };
    for (from, wo) in above() {
        let ray = gold(Ggx::SMOOTH).sample(wo, 0.5, [0.1, 0.9]).expect("a mirror reflects");
        assert_eq!(ray.wi, Vec3::new(-wo.x, -wo.y, wo.z), "{from}");
        assert!(ray.is_delta && !ray.is_transmission && ray.eta == 1.0, "{from}");
        let expected = fresnel::conductor(wo.z, eta, k);
        assert!(((ray.throughput() - expected).0.abs().max_element()) < 1e-6, "{from}");
    }
}

#[test]
fn reflected_and_refracted_power_sum_to_one() {
    for eta in [0.7, 1.0, 1.0001, 1.33, 1.5, 2.4] {
        let bsdf = glass(eta, Ggx::SMOOTH);
        for (from, wo) in visible_from(&bsdf) {
            let rays = both_rays(&bsdf, wo);
            // Power = probability × throughput, times η² where radiance was refracted.
            let power: f32 = rays.values().map(|ray| ray.pdf.0 * ray.throughput()[0] * ray.eta * ray.eta).sum();
            assert!((power - 1.0).abs() < 1e-5, "η {eta} {from}: {power}");
        }
    }
}

#[test]
fn refraction_follows_snells_law_in_the_plane_of_incidence() {
    for eta in [0.7f32, 1.33, 1.5, 2.4] {
        let bsdf = glass(eta, Ggx::SMOOTH);
        for (from, wo) in visible_from(&bsdf) {
            let relative = if wo.z > 0.0 { eta } else { 1.0 / eta };
            let Some(ray) = both_rays(&bsdf, wo).remove(&true) else {
                let sin = (1.0 - wo.z * wo.z).sqrt();
                assert!(sin > relative, "η {eta} {from}: no refracted ray below the critical angle");
                continue;
            };
            assert!(wo.z * ray.wi.z < 0.0 && (ray.wi.length() - 1.0).abs() < 1e-6, "η {eta} {from}");
            assert!((ray.eta - relative).abs() < 1e-6, "η {eta} {from}");
            // n·sin θ as a vector: the tangential part of n·w is the same on both sides.
            let tangential = wo.truncate() + relative * ray.wi.truncate();
            assert!(tangential.length() < 1e-6, "η {eta} {from}: {tangential}");
        }
    }
}

#[test]
fn short_waves_are_bent_more() {
    // Index of BK7 at 400, 500, 600 and 700 nm: 1.5308, 1.5214, 1.5163, 1.5131.
    let indices = [1.5308f32, 1.5214, 1.5163, 1.5131];
    let wo = Vec3::new(0.8, 0.0, 0.6);
    let mut last_angle = 0.0;
    for hero in 0..4 {
        let mut eta = indices;
        eta.rotate_left(hero);
        let bsdf = Bsdf::Dielectric(Dielectric {
            index: RelativeIndex { eta: eta.into(), dispersive: true, is_one: false },
            distribution: Ggx::SMOOTH,
            energy_compensation: false,
        });
        let ray = bsdf.sample(wo, 0.9, [0.5; 2]).expect("refracts");
        let angle = (-ray.wi.z).acos();
        assert!((angle - (0.8 / indices[hero]).asin()).abs() < 1e-6, "hero {hero}: {angle}");
        assert!(angle > last_angle, "hero {hero}");
        last_angle = angle;
        assert!(ray.terminates_secondary, "hero {hero}");
        assert_eq!(ray.f.to_array()[1..], [0.0; 3], "hero {hero}");
    }
}

#[test]
fn dispersive_reflection_weighs_every_wavelength_by_its_own_fresnel_factor() {
    let eta = SampledSpectrum::from([1.3, 1.5, 1.7, 2.0]);
    let bsdf = Bsdf::Dielectric(Dielectric {
        index: RelativeIndex { eta, dispersive: true, is_one: false },
        distribution: Ggx::SMOOTH,
        energy_compensation: false,
    });
    assert!(bsdf.is_delta() && !bsdf.needs_single_wavelength());
    for (from, wo) in above() {
        let ray = bsdf.sample(wo, 0.0, [0.5; 2]).expect("reflects");
        assert!(!ray.terminates_secondary && !ray.is_transmission, "{from}");
        for lane in 0..4 {
            let expected = fresnel::dielectric(wo.z, eta[lane]).reflectance;
            let power = ray.pdf.0 * ray.throughput()[lane];
            assert!((power - expected).abs() < 1e-6, "{from} lane {lane}: {power} is not {expected}");
        }
    }
}

#[test]
fn without_an_interface_light_goes_straight_on() {
    for alpha in [0.0, 0.01, 0.5, 1.0] {
        let bsdf = glass(1.0, Ggx::new(alpha, alpha));
        assert!(bsdf.is_delta(), "α {alpha}");
        for wo in [Vec3::Z, Vec3::new(0.6, 0.0, -0.8), Vec3::new(1.0, 0.0, 1e-6), Vec3::new(0.0, 1.0, -1e-5)] {
            let ray = bsdf.sample(wo, 0.0, [0.5; 2]).expect("passes");
            assert!((ray.wi + wo).length() < 1e-7, "α {alpha} {wo}: {}", ray.wi);
            assert!((ray.throughput() - SampledSpectrum::ONE).0.abs().max_element() < 1e-6, "α {alpha} {wo}");
        }
    }
}

#[test]
fn a_slightly_rough_surface_tends_to_the_smooth_one() {
    // With v = 0.5 the sampled microfacet has a slope of α in the stretched space, to 1 % of it for the stretched wo
    // aslant; the scattered direction turns by twice that at most.
    const ALPHA: f32 = 1e-3;
    const TILT: f32 = 1.01 * ALPHA;
    // G is 1 to α²·tan²80°/4, 1e-5; the rounding of a microfacet normal, 6e-8, is 6e-8/α of a slope of order 1 in D,
    // which counts four times in the ratio of f to its density.
    const ROUNDING: f32 = 4.0 * 6e-8 / ALPHA + 1e-5;
    let Bsdf::Conductor(Conductor { eta, k, .. }) = gold(Ggx::SMOOTH) else { unreachable!("gold is a conductor") };
    for (from, wo) in above() {
        // How much gold's reflectance changes over the tilt, either way. Glass chooses between its lobes by its
        // reflectance, which leaves none of that in the weight.
        let reflectance = |tilt: f32| fresnel::conductor((wo.z.min(1.0).acos() + tilt).cos(), eta, k).0;
        let change = [-TILT, TILT].map(|tilt| (reflectance(tilt) - reflectance(0.0)).abs().max_element());
        let change = change[0].max(change[1]);
        for (name, rough, smooth, change) in [
            ("gold", gold(Ggx::new(ALPHA, ALPHA)), gold(Ggx::SMOOTH), change),
            ("glass", glass(1.5, Ggx::new(ALPHA, ALPHA)), glass(1.5, Ggx::SMOOTH), 0.0),
        ] {
            for u_lobe in [0.0, 0.999] {
                let (a, b) = (rough.sample(wo, u_lobe, [0.3, 0.5]), smooth.sample(wo, u_lobe, [0.3, 0.5]));
                let (a, b) = (a.expect("scatters"), b.expect("scatters"));
                assert!((a.wi - b.wi).length() < 2.0 * TILT, "{name} {from}: {} is not {}", a.wi, b.wi);
                let difference = (a.throughput() - b.throughput()).0.abs().max_element();
                assert!(difference < change + ROUNDING, "{name} {from}: throughput differs by {difference}");
            }
        }
    }
}

#[test]
fn rough_dispersive_glass_asks_for_a_single_wavelength() {
    let eta = SampledSpectrum::from([1.53, 1.52, 1.51, 1.50]);
    let bsdf = Bsdf::Dielectric(Dielectric {
        index: RelativeIndex { eta, dispersive: true, is_one: false },
        distribution: Ggx::new(0.2, 0.2),
        energy_compensation: false,
    });
    assert!(bsdf.needs_single_wavelength() && !bsdf.is_delta());
    let wo = Vec3::new(0.6, 0.0, 0.8);
    for (u_lobe, wi) in [(0.0, Vec3::new(-0.6, 0.0, 0.8)), (0.9, Vec3::new(-0.4, 0.0, -0.9165))] {
        assert_eq!(bsdf.eval(wo, wi).f.to_array()[1..], [0.0; 3]);
        assert!(bsdf.eval(wo, wi).f[0] > 0.0);
        assert!(bsdf.sample(wo, u_lobe, [0.1, 0.2]).expect("scatters").terminates_secondary);
    }
}
