//! Multiple importance sampling between paths from the camera and paths from lights.
//!
//! A path x₀ … x_k from the lens to a light can be found from the camera in two ways, by BSDF sampling at every surface
//! or by light sampling for its last segment; and from the light by BSDF sampling back to x₁ and a connection to the
//! lens there. With the densities p₀, p₁ and p_L of the three per area, n camera paths for a sample of a pixel and N
//! light paths for a sample of all pixels,
//!
//! q = N·p_L/(n·(p₀ + p₁)),   w_camera = 1/(1 + q),   w_light = q/(1 + q):
//!
//! the balance heuristic ([Veach97](photosite_core::references#veach97) §9.2.2, §10.2). In p_L/p₀ all distances but the
//! first cancel. With the cosines to the geometric normal at xᵢ towards the camera (cᵢ, `cos_to_camera`) and towards
//! the light (lᵢ, `cos_to_light`), the densities per solid angle of scattering at xᵢ towards the camera (p⃖ᵢ,
//! `pdf_to_camera`) and towards the light (p⃗ᵢ, `pdf_to_light`), κ the pixels per solid angle on the axis, and p_E the
//! density with which light sets out, over its cosine (`emission_density`),
//!
//! p_L/p₀ = p_E · d₁²·l₁/(κ·c₁·p⃗₁) · Π_{i=2}^{k−1} lᵢ·p⃖ᵢ/(cᵢ·p⃗ᵢ),
//!
//! where a mirror has 1, and a smooth interface 1/η² with η the index towards the light over that towards the camera.
//! Any weights that sum to one are right, so that κ may stand for all of the image, and roulette may be left out.
//!
//! Light paths are kept for a [`LightPathKind`]: where that is caustics alone, x_{k−1} is a surface that
//! [casts them](crate::bsdf::Bsdf::casts_caustics), and in any case not the first that the camera sees. That first surface
//! is no mirror, since a mirror cannot be connected to the lens.

use super::settings::LightPathKind;

/// MIS ratio q without the factor p_E, over the surfaces that a path has passed.
#[derive(Clone, Copy, Debug)]
pub(super) struct MisRatio {
    /// Ratio so far; 0 where no light path can be this path.
    ratio: f32,
    kind: LightPathKind,
    /// Whether light paths bring what the last surface sends, and it is not the first.
    is_brought: bool,
    /// Distance from the lens, m, below which no light path finds the first surface.
    least_distance_m: f32,
}

/// Cosines, positive, to the geometric normal of a surface, and densities per solid angle of its scattering, both
/// towards the camera and towards the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathVertex {
    pub(super) cos_to_camera: f32,
    pub(super) cos_to_light: f32,
    pub(super) pdf_to_camera: f32,
    pub(super) pdf_to_light: f32,
}

impl PathVertex {
    /// The factor of a surface that is neither the first nor the last: lᵢ·p⃖ᵢ/(cᵢ·p⃗ᵢ).
    #[inline]
    pub(super) fn inner_term(&self) -> f32 {
        self.cos_to_light * self.pdf_to_camera / (self.cos_to_camera * self.pdf_to_light)
    }

    /// The factor of the last surface, at which light sampling has the density `light_pdf`.
    #[inline]
    pub(super) fn last_term(&self, light_pdf: f32) -> f32 {
        self.cos_to_light * self.pdf_to_camera / (self.cos_to_camera * (self.pdf_to_light + light_pdf))
    }

    /// The factor of the first surface without κ, at `distance` (m) from the lens.
    #[inline]
    pub(super) fn first_term(&self, distance: f32) -> f32 {
        distance * distance * self.cos_to_light / (self.cos_to_camera * self.pdf_to_light)
    }
}

/// The factor of a mirror or a smooth interface, with `eta` the index on the side of the light over that on the side of
/// the camera.
#[inline]
pub(super) fn delta_term(eta: f32) -> f32 {
    1.0 / (eta * eta)
}

/// MIS weight w_camera of q; 1 where q is undefined, as between surfaces that touch.
#[inline]
pub(super) fn camera_weight(q: f32) -> f32 {
    if q.is_nan() { 1.0 } else { 1.0 / (1.0 + q) }
}

/// w_light of q.
#[inline]
pub(super) fn light_weight(q: f32) -> f32 {
    1.0 - camera_weight(q)
}

impl MisRatio {
    /// The ratio of a render without light paths.
    pub(super) const NONE: Self = Self::new(LightPathKind::Caustics, 0.0, 0.0);

    /// The ratio before the first surface: N/(n·κ). Light paths find none that is nearer to the lens than a distance in m.
    pub(super) const fn new(kind: LightPathKind, scale: f32, least_distance_m: f32) -> Self {
        Self { ratio: scale, kind, is_brought: false, least_distance_m }
    }

    /// Whether light paths may find the light that this path finds.
    #[inline]
    pub(super) fn is_shared(&self) -> bool {
        self.ratio > 0.0
    }

    /// Whether light paths bring what a surface sends that casts caustics or not, and is not the first.
    #[inline]
    pub(super) fn holds(&self, casts_caustics: bool) -> bool {
        self.is_shared() && self.kind.holds(casts_caustics)
    }

    /// The ratio after the first surface, at `distance` (m) from the lens.
    #[inline]
    pub(super) fn after_first(self, path_vertex: &PathVertex, distance: f32) -> Self {
        let is_found = distance >= self.least_distance_m;
        let ratio = if is_found { self.ratio * path_vertex.first_term(distance) } else { 0.0 };
        Self { ratio, is_brought: false, ..self }
    }

    /// The ratio after another surface.
    #[inline]
    pub(super) fn after(self, path_vertex: &PathVertex, casts_caustics: bool) -> Self {
        Self { ratio: self.ratio * path_vertex.inner_term(), is_brought: self.kind.holds(casts_caustics), ..self }
    }

    /// The ratio after another mirror or smooth interface.
    #[inline]
    pub(super) fn after_delta(self, eta: f32) -> Self {
        Self { ratio: self.ratio * delta_term(eta), is_brought: true, ..self }
    }

    /// Weight of emission that BSDF sampling has found, whose light sets out with the density `emission_density`. Light
    /// sampling has found it with `light_pdf_ratio` times the density of BSDF sampling.
    #[inline]
    pub(super) fn mis_weight_bsdf(&self, emission_density: impl FnOnce() -> f32, light_pdf_ratio: f32) -> f32 {
        if !(self.is_brought && self.is_shared()) {
            return 1.0;
        }
        camera_weight(self.ratio * emission_density() / (1.0 + light_pdf_ratio))
    }

    /// Weight of a light sample with the density `light_pdf`, at a surface that is not the first and whose light is
    /// [brought](Self::holds).
    #[inline]
    pub(super) fn mis_weight_light(&self, path_vertex: &PathVertex, emission_density: f32, light_pdf: f32) -> f32 {
        camera_weight(self.ratio * path_vertex.last_term(light_pdf) * emission_density)
    }
}
