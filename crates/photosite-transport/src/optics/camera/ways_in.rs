//! Way back through a prescription: the pixels in which light lands that a point of the scene sends into the lens, for
//! paths that come from lights.
//!
//! No equation need be solved, as for [other lenses](super::connection): a ray to a point that is drawn in the entrance pupil
//! goes on through the glass as light does, at each wavelength to a place of its own. With the power β that a path carries to
//! the vertex y and the area A from which that point is drawn, one of N paths adds
//!
//! E_j = β_j·f·cos θ_y · cos θ·A/r² · T_j / (A_p·N)
//!
//! to the irradiance of the pixel of the area A_p in which the wavelength j lands, since the glass, whose transmittance is
//! T_j, keeps étendue. What is blocked adds nothing.

use glam::Vec3;

use super::Camera;
use super::landings::{BLOCKED, Landing, LensRays};
use crate::optics::prescribed::WayIn;
use photosite_core::spectrum::{LANES, Wavelengths};

/// Point of the scene that is to be connected to the lens.
#[derive(Clone, Copy, Debug)]
pub struct TowardsLens {
    /// Point in world space.
    pub point: Vec3,
    /// Random numbers in [0, 1) for the point of the entrance pupil.
    pub sample: [f32; 2],
    /// Random numbers in [0, 1) for the point spread.
    pub spread: [f32; 2],
    /// Wavelengths of the light.
    pub wavelengths: Wavelengths,
}

/// Light of a point on its way into the lens.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// Point at which the light meets the first surface, in world space.
    pub front: Vec3,
    /// Landings of the wavelengths: E = weight · I with the spectral radiant intensity I of the point towards the lens,
    /// m⁻².
    pub landings: [Landing; LANES],
}

impl Camera {
    /// Leads light of points through the glass of a prescription to the image: gives `take` the index of each point
    /// with its arrival, where any wavelength lands. It finds nothing of a hero's other wavelengths where it is alone,
    /// of points nearer than [`least_distance_m`](Self::least_distance_m), and of other lenses. Of a camera that stands
    /// still.
    pub fn arrive_each(&self, points: &[TowardsLens], rays: &mut LensRays, mut take: impl FnMut(usize, &Arrival)) {
        let Some(lens) = &self.prescribed else { return };
        let to_camera = self.to_world.inverse();
        // Draw the ways in
        let mut ways = Vec::with_capacity(points.len());
        rays.back.clear();
        for TowardsLens { point, sample, wavelengths, .. } in points {
            let way = lens.way_in(to_camera.transform_point3(point.as_dvec3()), *sample);
            for lane in 0..LANES {
                let is_carried = lane == 0 || !wavelengths.is_hero_alone();
                let ray = way.as_ref().filter(|_| is_carried).map(|way| way.ray);
                rays.back.push(ray.map_or(BLOCKED, |ray| ray.at_wavelength(wavelengths.lambda_nm(lane))));
            }
            ways.push(way);
        }

        // Lead them through the glass
        lens.trace_in(&mut rays.back);

        let per_m2 = 1.0 / (self.pitch_m[0] * self.pitch_m[1]) as f32;
        for (i, way) in ways.into_iter().enumerate() {
            let Some(WayIn { front, ray: outside, solid_angle }) = way else { continue };
            let outside = (outside.point, -outside.direction);
            let mut landings = [Landing::default(); LANES];
            for (landing, ray) in landings.iter_mut().zip(&rays.back[i * LANES..]) {
                if ray.passed <= 0.0 {
                    continue;
                }
                let landed = lens.landing(ray, outside, points[i].spread);
                let Some(cell) = landed.and_then(|landed| self.lit_cell(self.pixel_of(landed))) else { continue };
                *landing = Landing { cell, weight: ray.passed * solid_angle * per_m2 };
            }
            if landings.iter().any(|landing| landing.weight > 0.0) {
                take(i, &Arrival { front: self.to_world.transform_point3(front).as_vec3(), landings });
            }
        }
    }

    /// Distance in m below which paths from lights do not find the lens: a prescription's pupil is tabulated up to
    /// there.
    pub fn least_distance_m(&self) -> f32 {
        self.prescribed.as_ref().map_or(0.0, |lens| lens.least_distance_m() as f32)
    }

    /// Whether light finds its way in by [`arrive_each`](Self::arrive_each), and not by [`connect`](Self::connect).
    pub fn has_glass(&self) -> bool {
        self.prescribed.is_some()
    }
}
