//! The GGX distribution against its defining integrals and textbook forms.

use glam::Vec3;
use photosite::bsdf::Ggx;

use super::bsdf_cases::{ALPHAS, above};
use super::quadrature::integrate_sphere;

/// The quadrature's own error, see there.
const QUADRATURE: f64 = 5e-5;

fn above_only(f: impl Fn(Vec3) -> f32) -> impl Fn(Vec3) -> f64 {
    move |m| if m.z > 0.0 { f64::from(f(m)) } else { 0.0 }
}

#[test]
fn projected_facets_cover_the_surface_once() {
    for [x, y] in ALPHAS {
        let ggx = Ggx::new(x, y);
        let area = integrate_sphere(above_only(|m| ggx.density(m) * m.z));
        assert!((area - 1.0).abs() < QUADRATURE, "α {x} {y}: ∫ D cos = {area}");
    }
}

#[test]
fn visible_facets_cover_the_view_once() {
    // ∫ G₁·⟨wo·m⟩·D dm = cos θₒ defines Smith's G₁ (Heitz 2014, eq. 14).
    for [x, y] in ALPHAS {
        for (from, wo) in above() {
            let ggx = Ggx::new(x, y);
            let area = integrate_sphere(above_only(|m| ggx.masking(wo) * wo.dot(m).max(0.0) * ggx.density(m)));
            assert!((area - f64::from(wo.z)).abs() < QUADRATURE, "α {x} {y} {from}: {area} is not {}", wo.z);
            let visible = integrate_sphere(above_only(|m| ggx.visible_density(wo, m)));
            // Divided by cos θₒ, as the error of the integral is.
            assert!((visible - 1.0).abs() < QUADRATURE / f64::from(wo.z), "α {x} {y} {from}: ∫ D_v = {visible}");
        }
    }
}

#[test]
fn smiths_function_has_its_textbook_form() {
    // Λ = (√(1 + α²·tan²θ) − 1)/2 with α² = α_x²·cos²φ + α_y²·sin²φ (Heitz 2014, eqs. 72 and 80).
    for [x, y] in ALPHAS {
        for (from, w) in above() {
            let [sin2, cos2] = [f64::from(w.x).powi(2) + f64::from(w.y).powi(2), f64::from(w.z).powi(2)];
            let stretched = (f64::from(x) * f64::from(w.x)).powi(2) + (f64::from(y) * f64::from(w.y)).powi(2);
            let alpha2 = if sin2 > 0.0 { stretched / sin2 } else { 0.0 };
            let lambda = 0.5 * ((1.0 + alpha2 * sin2 / cos2).sqrt() - 1.0);
            let found = f64::from(Ggx::new(x, y).lambda(w));
            assert!((found - lambda).abs() < 1e-6 * (1.0 + lambda), "α {x} {y} {from}: {found} is not {lambda}");
        }
    }
}

#[test]
fn masking_and_shadowing_together_hide_more_than_either_and_less_than_both() {
    for [x, y] in ALPHAS {
        let ggx = Ggx::new(x, y);
        for (from, wo) in above() {
            for (to, wi) in above() {
                let (g1o, g1i, g2) = (ggx.masking(wo), ggx.masking(wi), ggx.masking_shadowing(wo, wi));
                let slack = 1e-6;
                assert!(g2 <= g1o.min(g1i) + slack && g2 >= g1o * g1i - slack, "α {x} {y} {from} {to}: {g2}");
            }
        }
    }
}

#[test]
fn glossy_roughness_is_squared_and_anisotropy_keeps_the_mean() {
    for roughness in [0.1, 0.5, 1.0f32] {
        for anisotropy in [-1.0, -0.5, 0.0, 0.7, 1.0] {
            let [x, y] = Ggx::from_roughness(roughness, anisotropy).alpha();
            let (mean, ratio) = ((x * y).sqrt(), x / y);
            let name = format!("roughness {roughness} anisotropy {anisotropy}: α {x} {y}");
            assert!((mean / (roughness * roughness) - 1.0).abs() < 1e-5, "{name}");
            let expected = (1.0 - 0.9 * anisotropy.abs()).powf(-anisotropy.signum());
            assert!((ratio / expected - 1.0).abs() < 1e-5, "{name}");
        }
    }
}

#[test]
fn what_is_too_smooth_to_resolve_is_smooth() {
    for (alpha, smooth) in [(0.0, true), (5e-5, true), (1e-4, false), (0.5, false), (-1.0, true), (f32::NAN, true)] {
        assert_eq!(Ggx::new(alpha, alpha).is_smooth(), smooth, "α {alpha}");
    }
    assert!(!Ggx::new(0.0, 0.5).is_smooth());
}
