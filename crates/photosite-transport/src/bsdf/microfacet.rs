//! The GGX (Trowbridge–Reitz) microfacet distribution with Smith's masking and shadowing.
//!
//! In: unit directions in the local shading frame, and the roughness α along local x and y, the slope that half of the
//! projected area exceeds. Out: densities per steradian and fractions between 0 and 1. What a facet does with the light
//! that meets it is left to the models.
//!
//! The functions are arranged so that no cosine of the two directions ends up alone in a denominator: with
//! s(w) = √(α_x²·x² + α_y²·y² + z²), Smith's function is Λ(w) = (s(w)/z − 1)/2, and
//!
//! | quantity | textbook | here |
//! |---|---|---|
//! | masking G₁(w) | 1/(1 + Λ(w)) | 2z/(z + s) |
//! | height-correlated G₂ | 1/(1 + Λ(wo) + Λ(wi)) | 2·zₒ·zᵢ/(sₒ·zᵢ + sᵢ·zₒ) |
//! | reflection kernel | D·G₂/(4·zₒ·zᵢ) | D/(2(sₒ·zᵢ + sᵢ·zₒ)) |
//! | density of visible normals | D·G₁(wo)·⟨wo·m⟩/zₒ | 2D·⟨wo·m⟩/(zₒ + sₒ) |

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::directions::GRAZING;

/// Smallest roughness α, below which a surface counts as smooth: its lobe is narrower than 0.01°, and the rounding of
/// unit vectors (6e-8) would show in D.
pub const SMALLEST_ALPHA: f32 = 1e-4;

/// A GGX distribution of facet normals, or no roughness at all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// Roughness α along x and y: both zero, or at least [`SMALLEST_ALPHA`].
    alpha_x: f32,
    alpha_y: f32,
}

impl Ggx {
    /// Absence of microstructure: reflection and refraction as in a mirror and in polished glass.
    pub const SMOOTH: Self = Self { alpha_x: 0.0, alpha_y: 0.0 };

    /// Distribution of the roughness α along local x and y. Smooth where both are below 10⁻⁴; negative and NaN count as
    /// 0.
    #[inline]
    pub fn new(alpha_x: f32, alpha_y: f32) -> Self {
        if alpha_x.max(alpha_y) >= SMALLEST_ALPHA {
            Self { alpha_x: alpha_x.max(SMALLEST_ALPHA), alpha_y: alpha_y.max(SMALLEST_ALPHA) }
        } else {
            Self::SMOOTH
        }
    }

    /// Distribution of the perceptual roughness 0–1, α = roughness² (glTF's convention), and anisotropy −1–1: the ratio
    /// of the smaller to the larger α is 1 − 0.9·|anisotropy| at unchanged geometric mean, a positive anisotropy being
    /// rougher along x ([Burley12](photosite_core::references#burley12) §5.4).
    #[inline]
    pub fn from_roughness(roughness: f32, anisotropy: f32) -> Self {
        let alpha = roughness * roughness;
        let aspect = (1.0 - 0.9 * anisotropy.abs().min(1.0)).sqrt();
        if anisotropy >= 0.0 {
            Self::new(alpha / aspect, alpha * aspect)
        } else {
            Self::new(alpha * aspect, alpha / aspect)
        }
    }

    /// Whether reflection and refraction go into one direction each.
    #[inline]
    pub fn is_smooth(&self) -> bool {
        self.alpha_x == 0.0
    }

    /// Roughness α along local x and y.
    #[inline]
    pub fn alpha(&self) -> [f32; 2] {
        [self.alpha_x, self.alpha_y]
    }

    /// Larger α of both directions: the width of the widest part of the lobe, in radians where it is small.
    #[inline]
    pub fn widest(&self) -> f32 {
        self.alpha_x.max(self.alpha_y)
    }

    /// The geometric mean of both α.
    #[inline]
    pub(super) fn mean_alpha(&self) -> f32 {
        if self.alpha_x == self.alpha_y { self.alpha_x } else { (self.alpha_x * self.alpha_y).sqrt() }
    }

    /// Whether the lobe is narrow enough to cast caustics, α < 0.3: see
    /// [`Bsdf::casts_caustics`](super::Bsdf::casts_caustics).
    #[inline]
    pub(crate) fn is_near_specular(&self) -> bool {
        self.mean_alpha() < 0.3
    }

    /// Area of facets per unit of surface whose normal is `m`, sr⁻¹:
    /// D(m) = 1/(π·α_x·α_y·(m_x²/α_x² + m_y²/α_y² + m_z²)²) ([Heitz18](photosite_core::references#heitz18) eq. 1).
    /// Normalised so that ∫ D(m)·m_z dm = 1. `m` is a unit vector with m_z ≥ 0. Not for a smooth surface.
    #[inline]
    pub fn density(&self, m: Vec3) -> f32 {
        let (x, y) = (m.x / self.alpha_x, m.y / self.alpha_y);
        let stretched = x * x + y * y + m.z * m.z;
        FRAC_1_PI / (self.alpha_x * self.alpha_y * stretched * stretched)
    }

    /// s(w) = √(α_x²·x² + α_y²·y² + z²), from which Smith's functions follow (see the module): the area that the facets
    /// facing `w` would show without masking is (s + z)/2 per unit of surface.
    #[inline]
    pub fn stretched_length(&self, w: Vec3) -> f32 {
        let (x, y) = (self.alpha_x * w.x, self.alpha_y * w.y);
        (x * x + y * y + w.z * w.z).sqrt()
    }

    /// Smith's Λ(w) = (s(w)/z − 1)/2: area hidden over area seen ([Heitz14](photosite_core::references#heitz14) eq.
    /// 72).
    #[inline]
    pub fn lambda(&self, w: Vec3) -> f32 {
        0.5 * (self.stretched_length(w) / w.z.abs() - 1.0)
    }

    /// The fraction of the facets facing `w` that `w` sees: G₁(w) = 1/(1 + Λ(w)).
    #[inline]
    pub fn masking(&self, w: Vec3) -> f32 {
        let z = w.z.abs();
        2.0 * z / (z + self.stretched_length(w))
    }

    /// The fraction seen from `wo` and from `wi`, both on the side of +Z, with the correlation that both see the high
    /// facets: G₂ = 1/(1 + Λ(wo) + Λ(wi)) ([Heitz14](photosite_core::references#heitz14) eq. 99).
    #[inline]
    pub fn masking_shadowing(&self, wo: Vec3, wi: Vec3) -> f32 {
        2.0 * wo.z * wi.z / (self.stretched_length(wo) * wi.z + self.stretched_length(wi) * wo.z)
    }

    /// Density of the facet normals that `wo` sees, sr⁻¹: D_v(m) = D(m)·G₁(wo)·⟨wo·m⟩/zₒ
    /// ([Heitz18](photosite_core::references#heitz18) eq. 3). It integrates to 1, and [`Self::sample_visible`] has it.
    #[inline]
    pub fn visible_density(&self, wo: Vec3, m: Vec3) -> f32 {
        2.0 * self.density(m) * wo.dot(m).max(0.0) / (wo.z + self.stretched_length(wo))
    }

    /// Draws a facet normal that `wo` (z > 0) sees, by reflecting the stretched `wo` at a uniformly chosen point of the
    /// spherical cap that it lights ([Dupuy23](photosite_core::references#dupuy23)).
    #[inline]
    pub fn sample_visible(&self, wo: Vec3, [u, v]: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(self.alpha_x * wo.x, self.alpha_y * wo.y, wo.z).normalize();
        let z = (1.0 - v) * (1.0 + stretched.z) - stretched.z;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = sin_cos_turn(u);
        let m = Vec3::new(radius * cos, radius * sin, z) + stretched;
        Vec3::new(self.alpha_x * m.x, self.alpha_y * m.y, m.z.max(f32::MIN_POSITIVE)).normalize()
    }
}

/// D·G₂/(4·zₒ·zᵢ), the part of a reflection lobe that is left when Fresnel's factor is taken out, together with the
/// density with which [`Ggx::sample_visible`] and mirror reflection find `wi`: D_v(m)/(4·wo·m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectionKernel {
    /// D·G₂/(4·zₒ·zᵢ), sr⁻¹.
    pub value: f32,
    /// Density of `wi` per steradian.
    pub pdf: f32,
    /// Cosine of the angle between either direction and the facet normal.
    pub cos_facet: f32,
}

impl Ggx {
    /// Reflection of `wo` into `wi`, both with z > 0, by facets whose normal is the half vector
    /// ([Walter07](photosite_core::references#walter07) eq. 20).
    #[inline]
    pub fn reflection(&self, wo: Vec3, wi: Vec3) -> ReflectionKernel {
        let m = (wo + wi).normalize();
        self.reflection_at(wo, wi, m)
    }

    /// Reflection of `wo` into `wi` where the half vector `m` is known already.
    #[inline]
    pub fn reflection_at(&self, wo: Vec3, wi: Vec3, m: Vec3) -> ReflectionKernel {
        let density = self.density(m);
        let (s_o, s_i) = (self.stretched_length(wo), self.stretched_length(wi));
        ReflectionKernel {
            value: density / (2.0 * (s_o * wi.z + s_i * wo.z)),
            pdf: density / (2.0 * (wo.z + s_o)),
            cos_facet: wo.dot(m).clamp(0.0, 1.0),
        }
    }

    /// Draws `wi` by mirror reflection at a visible facet. None where it would lie below the horizon: there the model
    /// of a single bounce loses the light.
    #[inline]
    pub fn sample_reflection(&self, wo: Vec3, u: [f32; 2]) -> Option<(Vec3, ReflectionKernel)> {
        let m = self.sample_visible(wo, u);
        let wi = reflect(wo, m);
        (wi.z > GRAZING).then(|| (wi, self.reflection_at(wo, wi, m)))
    }
}

/// Mirror image of `w` about the unit vector `m`; both point away from the surface.
#[inline]
pub fn reflect(w: Vec3, m: Vec3) -> Vec3 {
    (2.0 * w.dot(m)) * m - w
}

/// Sine and cosine of 2π·u for u in 0–1, to 1e-7: Taylor series within an eighth of a turn, then a rotation by
/// quarters. Saves a sample some 10 ns over `f32::sin_cos`, which takes any angle.
#[inline]
fn sin_cos_turn(u: f32) -> (f32, f32) {
    let quarter = (4.0 * u + 0.5) as u32;
    let x = (u - 0.25 * quarter as f32) * (2.0 * PI);
    let x2 = x * x;
    let sin = x * (1.0 + x2 * (-1.0 / 6.0 + x2 * (1.0 / 120.0 + x2 * (-1.0 / 5040.0 + x2 * (1.0 / 362_880.0)))));
    let cos = 1.0 + x2 * (-0.5 + x2 * (1.0 / 24.0 + x2 * (-1.0 / 720.0 + x2 * (1.0 / 40320.0))));
    let (sin, cos) = if quarter & 1 == 0 { (sin, cos) } else { (cos, -sin) };
    if quarter & 2 == 0 { (sin, cos) } else { (-sin, -cos) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_of_turns_are_sines() {
        for i in 0..=100_000 {
            let u = i as f32 / 100_000.0;
            let (sin, cos) = sin_cos_turn(u);
            let (expected_sin, expected_cos) = (std::f64::consts::TAU * f64::from(u)).sin_cos();
            let error = (f64::from(sin) - expected_sin).abs().max((f64::from(cos) - expected_cos).abs());
            // Rounding of 2π·u below an eighth of a turn, and of the sums: 2 ulp of 1; the cosine's next term is
            // 2.5e-8.
            assert!(error < 1.5e-7, "{u}: off by {error}");
        }
    }
}
