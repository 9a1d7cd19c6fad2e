//! Fresnel reflectance against closed forms and complex arithmetic in double precision.

use photosite::bsdf::fresnel;
use photosite::spectrum::SampledSpectrum;

/// A handful of f32 operations: relative error of some 1e-6, absolute since reflectances stay below 1.
const ROUNDING: f64 = 2e-6;

fn conductor(cos: f64, eta: f64, k: f64) -> f64 {
    let [eta, k] = [eta, k].map(|v| SampledSpectrum::splat(v as f32));
    f64::from(fresnel::conductor(cos as f32, eta, k)[0])
}

/// √(re + i·im), the root with the positive real part.
fn complex_sqrt([re, im]: [f64; 2]) -> [f64; 2] {
    let modulus = re.hypot(im);
    [(0.5 * (modulus + re)).max(0.0).sqrt(), (0.5 * (modulus - re)).max(0.0).sqrt().copysign(im)]
}

/// |p/q|² of complex numbers.
fn ratio_squared(p: [f64; 2], q: [f64; 2]) -> f64 {
    (p[0] * p[0] + p[1] * p[1]) / (q[0] * q[0] + q[1] * q[1])
}

/// Fresnel's equations as they are printed: r_s = (cos θ − w)/(cos θ + w), r_p = (N²·cos θ − w)/(N²·cos θ + w) with
/// N = η + ik, w = √(N² − sin²θ).
fn printed_equations(cos: f64, eta: f64, k: f64) -> f64 {
    let n2 = [eta * eta - k * k, 2.0 * eta * k];
    let w = complex_sqrt([n2[0] - (1.0 - cos * cos), n2[1]]);
    let s = ratio_squared([cos - w[0], -w[1]], [cos + w[0], w[1]]);
    let p = ratio_squared([n2[0] * cos - w[0], n2[1] * cos - w[1]], [n2[0] * cos + w[0], n2[1] * cos + w[1]]);
    0.5 * (s + p)
}

#[test]
fn normal_incidence_is_the_square_of_the_index_contrast() {
    for eta in [0.4, 0.75, 1.0, 1.0003, 1.33, 1.5, 2.4, 4.0] {
        let r = fresnel::dielectric(1.0, eta).reflectance;
        let expected = ((f64::from(eta) - 1.0) / (f64::from(eta) + 1.0)).powi(2);
        assert!((f64::from(r) - expected).abs() < ROUNDING, "η {eta}: {r} is not {expected}");
    }
}

#[test]
fn at_brewsters_angle_only_s_is_reflected() {
    // tan θ_B = η: r_p = 0 and r_s = (1 − η²)/(1 + η²), so R = r_s²/2.
    for eta in [0.75f64, 1.33, 1.5, 2.4] {
        let cos = 1.0 / (1.0 + eta * eta).sqrt();
        let r = f64::from(fresnel::dielectric(cos as f32, eta as f32).reflectance);
        let expected = 0.5 * ((1.0 - eta * eta) / (1.0 + eta * eta)).powi(2);
        assert!((r - expected).abs() < ROUNDING, "η {eta}: {r} is not {expected}");
    }
}

#[test]
fn reflection_is_total_beyond_the_critical_angle_only() {
    for n in [1.05f64, 1.33, 1.5, 2.4] {
        let critical = (1.0 / n).asin();
        // 0.001 rad inside the critical angle δ below it R ≈ 1 − c·√δ, at least 0.03 from 1.
        let inside = fresnel::dielectric((critical - 1e-3).cos() as f32, (1.0 / n) as f32);
        let outside = fresnel::dielectric((critical + 1e-3).cos() as f32, (1.0 / n) as f32);
        assert!(inside.reflectance < 0.99 && inside.cos_transmitted > 0.0, "n {n}: {inside:?}");
        assert!(outside.reflectance == 1.0 && outside.cos_transmitted == 0.0, "n {n}: {outside:?}");
    }
}

#[test]
fn what_is_not_reflected_is_transmitted() {
    for eta in [0.4f32, 0.75, 1.0, 1.0003, 1.5, 2.4] {
        for i in 0..=1000 {
            let interface = fresnel::dielectric(i as f32 / 1000.0, eta);
            let sum = f64::from(interface.reflectance) + f64::from(interface.transmittance);
            assert!((sum - 1.0).abs() < ROUNDING, "η {eta} cos {}: {interface:?}", i as f32 / 1000.0);
        }
    }
}

#[test]
fn snells_law_holds_for_the_refracted_cosine() {
    for eta in [0.7f64, 1.0, 1.0001, 1.5, 2.4] {
        for i in 1..=100 {
            let cos = f64::from(i) / 100.0;
            let sin = (1.0 - cos * cos).sqrt() / eta;
            if sin < 0.999 {
                let found = f64::from(fresnel::dielectric(cos as f32, eta as f32).cos_transmitted);
                // Near total reflection the error of the sine is magnified by tan θₜ < 1/√(1 − 0.999²) = 22.
                let tolerance = 22.0 * 2e-7;
                assert!((found - (1.0 - sin * sin).sqrt()).abs() < tolerance, "η {eta} cos {cos}: {found}");
            }
        }
    }
}

#[test]
fn an_interface_between_equals_does_nothing() {
    for cos in [0.0, 1e-7, 1e-4, 0.1, 0.5, 1.0] {
        let interface = fresnel::dielectric(cos, 1.0);
        assert_eq!(interface.reflectance, 0.0, "cos {cos}");
        assert!((f64::from(interface.transmittance) - 1.0).abs() < ROUNDING, "cos {cos}: {interface:?}");
        assert!((interface.cos_transmitted - cos).abs() <= cos * f32::EPSILON, "cos {cos}: {interface:?}");
    }
}

#[test]
fn grazing_light_is_reflected() {
    for eta in [0.5, 1.5, 2.4] {
        assert_eq!(fresnel::dielectric(0.0, eta).reflectance, 1.0, "η {eta}");
    }
    assert_eq!(conductor(0.0, 0.2, 3.0), 1.0);
}

#[test]
fn gold_reflects_at_normal_incidence_what_its_n_and_k_say() {
    // Johnson & Christy (1972), 1.91 eV = 649 nm: n = 0.14, k = 3.697, so R = ((n−1)² + k²)/((n+1)² + k²) = 0.96258;
    // 2.88 eV = 430 nm: n = 1.46, k = 1.933 gives 0.40336.
    for (n, k, expected) in [(0.14, 3.697, 0.962_58), (1.46, 1.933, 0.403_36)] {
        // The figures are given to five digits.
        assert!((conductor(1.0, n, k) - expected).abs() < 1e-5, "{}", conductor(1.0, n, k));
    }
}

#[test]
fn metals_follow_the_printed_equations() {
    for (eta, k) in [(0.05, 3.1), (0.14, 3.697), (1.46, 1.933), (2.9, 3.1), (1.5, 0.01), (20.0, 90.0), (1e-3, 8.0)] {
        for i in 0..=200 {
            let cos = f64::from(i) / 200.0;
            let (found, expected) = (conductor(cos, eta, k), printed_equations(cos, eta, k));
            // What is absorbed, 1 − R, is what a path sees after many bounces, but f32 holds R near 1 to 6e-8 only.
            assert!((found - expected).abs() < ROUNDING, "n {eta} k {k} cos {cos}: {found} is not {expected}");
        }
    }
}

#[test]
fn a_metal_without_absorption_is_a_dielectric() {
    for eta in [0.6f32, 1.0, 1.33, 2.4] {
        for i in 0..=100 {
            let cos = i as f32 / 100.0;
            let metal = conductor(f64::from(cos), f64::from(eta), 0.0);
            let clear = f64::from(fresnel::dielectric(cos, eta).reflectance);
            // At the critical angle both change with infinite slope; f32 rounding of η² enters under a square root.
            assert!((metal - clear).abs() < 2e-3, "η {eta} cos {cos}: {metal} is not {clear}");
        }
    }
}

#[test]
fn a_metal_with_no_real_index_reflects_everything() {
    for i in 0..=100 {
        assert_eq!(conductor(f64::from(i) / 100.0, 0.0, 1.0), 1.0, "cos {}", f64::from(i) / 100.0);
    }
}
