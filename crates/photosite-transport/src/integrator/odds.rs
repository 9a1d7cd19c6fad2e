//! How paths from the camera and paths from lamps share what both can find.
//!
//! A path x₀ … x_k from the lens to a lamp can be found from the camera, by scattering at every surface or, for its last segment,
//! by looking at the lamp; and from the lamp, by scattering back to x₁ and looking at the lens there. With the densities p₀, p₁
//! and p_L of the three per area, n paths of the first kinds for a sample of a pixel and N of the last for a sample of all pixels,
//!
//! q = N·p_L/(n·(p₀ + p₁)),   w_camera = 1/(1 + q),   w_light = q/(1 + q):
//!
//! the balance heuristic ([Veach97](photosite_core::references#veach97) §9.2.2, §10.2). In p_L/p₀ all distances but the first cancel.
//! With ωᵢ the cosines to the geometric normal at xᵢ, in towards the camera and out towards the lamp, p⃗ and p⃖ the densities of
//! scattering at xᵢ towards the lamp and towards the camera per solid angle, κ the pixels per solid angle on the axis, and p_E
//! the density with which light sets out, over its cosine,
//!
//! p_L/p₀ = p_E · d₁²·cos out₁/(κ·cos in₁·p⃗₁) · Π_{i=2}^{k−1} cos outᵢ·p⃖ᵢ/(cos inᵢ·p⃗ᵢ),
//!
//! where a mirror has 1, and a smooth interface 1/η² with η the index towards the lamp over that towards the camera. Any weights
//! that sum to one are right, so that κ may stand for all of the picture, and roulette may be left out.
//!
//! Paths from lamps look for caustics only: x_{k−1} is a surface that [focuses](crate::bsdf::Bsdf::casts_caustics), and not the one that
//! the camera sees first. That is no mirror: towards the lens there is no other way to it than from it.

/// q without the factor p_E, of the surfaces that a path has come by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Odds {
    /// 0 where no path from a lamp can be this one.
    ratio: f32,
    /// Whether the last surface focuses and is not the first.
    focused: bool,
}

/// Cosines, positive, to the geometric normal of a surface, and densities per solid angle of its scattering, both towards the
/// camera and towards the lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) cos_to_camera: f32,
    pub(super) cos_to_lamp: f32,
    pub(super) pdf_to_camera: f32,
    pub(super) pdf_to_lamp: f32,
}

impl Crossing {
    /// The factor of a surface that is neither the first nor the last.
    #[inline]
    pub(super) fn factor(&self) -> f32 {
        self.cos_to_lamp * self.pdf_to_camera / (self.cos_to_camera * self.pdf_to_lamp)
    }

    /// That of the last, where the lamp may have been looked at with the density `light_pdf` instead.
    #[inline]
    pub(super) fn last_factor(&self, light_pdf: f32) -> f32 {
        self.cos_to_lamp * self.pdf_to_camera / (self.cos_to_camera * (self.pdf_to_lamp + light_pdf))
    }

    /// That of the first but for κ, at a distance from the lens, m.
    #[inline]
    pub(super) fn first_factor(&self, distance: f32) -> f32 {
        distance * distance * self.cos_to_lamp / (self.cos_to_camera * self.pdf_to_lamp)
    }
}

/// The factor of a mirror or a smooth interface, from the index on the side of the lamp over that on the side of the camera.
#[inline]
pub(super) fn delta_factor(eta: f32) -> f32 {
    1.0 / (eta * eta)
}

/// What the camera's paths are worth, from q: all where there is no telling, as between surfaces that touch.
#[inline]
pub(super) fn camera_weight(q: f32) -> f32 {
    if q.is_nan() { 1.0 } else { 1.0 / (1.0 + q) }
}

/// What the lamps' paths are worth, from q.
#[inline]
pub(super) fn light_weight(q: f32) -> f32 {
    1.0 - camera_weight(q)
}

impl Odds {
    /// Without paths from lamps.
    pub(super) const NONE: Self = Self::new(0.0);

    /// Before the first surface, with N/(n·κ).
    pub(super) const fn new(scale: f32) -> Self {
        Self { ratio: scale, focused: false }
    }

    /// Whether paths from lamps may find what this one finds.
    #[inline]
    pub(super) fn are_shared(&self) -> bool {
        self.ratio > 0.0
    }

    /// After the first surface, of that distance from the lens.
    #[inline]
    pub(super) fn after_first(self, crossing: &Crossing, distance: f32) -> Self {
        Self { ratio: self.ratio * crossing.first_factor(distance), focused: false }
    }

    /// After another surface.
    #[inline]
    pub(super) fn after(self, crossing: &Crossing, focuses: bool) -> Self {
        Self { ratio: self.ratio * crossing.factor(), focused: focuses }
    }

    /// After another mirror or smooth interface.
    #[inline]
    pub(super) fn after_delta(self, eta: f32) -> Self {
        Self { ratio: self.ratio * delta_factor(eta), focused: true }
    }

    /// Weight of a lamp that the path has come to, whose light sets out with the density `emission_density`, where it may have
    /// been looked at with a density of `looked_at` times that of having come there.
    #[inline]
    pub(super) fn weight_of_found(&self, emission_density: impl FnOnce() -> f32, looked_at: f32) -> f32 {
        if !(self.focused && self.are_shared()) {
            return 1.0;
        }
        camera_weight(self.ratio * emission_density() / (1.0 + looked_at))
    }

    /// Weight of a lamp that was looked at from a surface, neither the first nor one that does not focus, with the density
    /// `light_pdf`.
    #[inline]
    pub(super) fn weight_of_looked_at(&self, crossing: &Crossing, emission_density: f32, light_pdf: f32) -> f32 {
        camera_weight(self.ratio * crossing.last_factor(light_pdf) * emission_density)
    }
}
