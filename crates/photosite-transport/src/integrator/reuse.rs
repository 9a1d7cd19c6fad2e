//! Neighbouring pixels that share what lies beyond their first surfaces.
//!
//! Where light comes off other surfaces, most of a path's work goes into what the second surface sends back, which a
//! diffuse one sends to all that see it. So a group of pixels connects each of its first surfaces with each second
//! surface that any of them has found ([Bekaert02](photosite_core::references#bekaert02)), at the cost of a shadow ray.
//! A piece of the sky is such a surface too, infinitely far away. For the density pₖ(y), per area, with which the path
//! at xₖ finds y, Vₖ(y) = 1 where xₖ sees y and else 0, and the radiance L that y sends back, as one path has estimated
//! it, what arrives along the path at xⱼ from the second surfaces yᵢ of all is
//!
//! Lⱼ = Σᵢ ρⱼ·pⱼ(yᵢ)·Vⱼ(yᵢ)·L(yᵢ) / (s·Σₖ pₖ(yᵢ)·Vₖ(yᵢ)),   p(y) = cos θ·cos θ′/(π·d²),
//!
//! the balance heuristic over the paths of the group, s of which go on from each first surface, of the reflectance ρ by
//! Lambert's law. Lights that paths come to are left to each pixel: most of their light is found by looking at
//! them. What the sky sends has the weight that it has for a path alone, against looking at it.
//!
//! Groups are as near to squares as their numbers of pixels allow: what these see is close together then, and the Sobol
//! points of a square are stratified together ([`PixelOrder`](crate::sampler::PixelOrder)), those of a row are not.
//! Sixteen in a square had 0.78 of the error of sixteen in a row (Cornell box).
//!
//! Every pixel keeps its mean, and its samples stay independent of each other, so that their variance is right. What
//! changes is that errors of the pixels of a group go together.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::interaction::shadow_ray;
use crate::bsdf::EDGE_ON_COSINE;
use crate::geometry::{Ray, SurfacePoint};
use crate::light::{Facing, LightSampleContext};
use crate::scene::Scene;
use photosite_core::math::{Pdf, SolidAngle};
use photosite_core::spectrum::SampledSpectrum;

/// A diffuse surface on its side that a path has come to.
#[derive(Clone, Copy)]
pub(super) struct Side {
    /// Position of the surface point.
    position: Vec3,
    /// Geometric and shading normal on that side.
    geometric: Vec3,
    shading: Vec3,
}

/// The first surface of a path from the camera.
#[derive(Clone, Copy)]
pub(super) struct FirstSurface {
    /// Index of its path.
    pub(super) path: u32,
    /// Index of the group that shares.
    pub(super) group: u32,
    pub(super) side: Side,
    pub(super) point: SurfacePoint,
    /// Throughput of the path, times the reflectance here.
    pub(super) throughput: SampledSpectrum,
}

/// The second surface of a path.
#[derive(Clone, Copy)]
pub(super) struct SecondSurface {
    /// Index of the path that it is a branch of, which is that of its first surface.
    pub(super) origin: u32,
    /// Index of the group that shares.
    pub(super) group: u32,
    /// Index of the branch, whose light is what the surface sends back.
    pub(super) branch: u32,
    pub(super) location: Location,
}

/// Location of a second surface.
#[derive(Clone, Copy)]
pub(super) enum Location {
    Diffuse(Side),
    /// The sky in this unit direction.
    Sky(Vec3),
}

impl FirstSurface {
    /// MIS weight of the sky that BSDF sampling has found, against light sampling.
    #[inline]
    fn weight_of_sky(&self, scene: &Scene, direction: Vec3, density: f32) -> f32 {
        let ctx = LightSampleContext { point: self.side.position, facing: Facing::Front(self.side.shading) };
        Pdf::<SolidAngle>::new(density).power_heuristic(scene.lights().environment_pdf(&ctx, direction))
    }
}

impl Side {
    /// The side of `wo`, with the shading normal that is seen from there; `None` where it is seen edge-on.
    #[inline]
    pub(super) fn new(point: &SurfacePoint, shading_normal: Vec3, wo: Vec3) -> Option<Self> {
        let geometric = point.geometric_normal * 1f32.copysign(wo.dot(point.geometric_normal));
        let side = Self { position: point.position, geometric, shading: shading_normal };
        side.faces(wo).then_some(side)
    }

    #[inline]
    // Directions along the surface are left to each pixel: what is seen edge-on has another shading normal for each
    // viewer.
    fn faces(&self, w: Vec3) -> bool {
        w.dot(self.shading) > EDGE_ON_COSINE && w.dot(self.geometric) > 0.0
    }

    /// The direction to a location and the density with which it is found from here by Lambert's law, per area, or of
    /// the sky per solid angle; `None` where one of both does not face the other.
    #[inline]
    fn density_of(&self, location: &Location) -> Option<(Vec3, f32)> {
        let (wi, per_solid_angle) = match location {
            Location::Diffuse(other) => {
                let to = other.position - self.position;
                let distance_squared = to.length_squared();
                let wi = to / distance_squared.sqrt();
                (wi, if other.faces(-wi) { -wi.dot(other.geometric) / distance_squared } else { 0.0 })
            }
            Location::Sky(direction) => (*direction, 1.0),
        };
        let density = wi.dot(self.shading) * FRAC_1_PI * per_solid_angle;
        (self.faces(wi) && density > 0.0).then_some((wi, density))
    }
}

/// Connects the surfaces of groups.
#[derive(Default)]
pub(super) struct Connections {
    pairs: Vec<Pair>,
    rays: Vec<Ray>,
    occluded: Vec<bool>,
}

/// A first surface that may see a second one.
#[derive(Clone, Copy)]
struct Pair {
    /// Indices of both in their lists.
    first: u32,
    second: u32,
    /// Density of finding the second.
    density: f32,
    /// Index of the shadow ray; `None` for the path's own second surface.
    ray: Option<u32>,
}

impl Connections {
    /// Adds to each path what its first surface scatters of the light from all second surfaces of its group: calls
    /// `add` with the index of the path and that light, for one of the branches. Both lists are in the order of their
    /// groups, `light` is what a second surface sends back, by its index in the list.
    pub(super) fn share(
        &mut self,
        scene: &Scene,
        (firsts, seconds): (&[FirstSurface], &[SecondSurface]),
        light: impl Fn(usize) -> SampledSpectrum,
        mut add: impl FnMut(u32, SampledSpectrum),
    ) {
        self.pairs.clear();
        self.rays.clear();
        let mut from = 0;
        for (number, second) in seconds.iter().enumerate() {
            from += firsts[from..].iter().take_while(|first| first.group < second.group).count();
            // Darkness needs no rays.
            if !light(number).is_black() {
                self.connect(number, second, (from, &firsts[from..]));
            }
        }
        scene.occluded_each(&self.rays, &mut self.occluded);
        let sees = |pair: &&Pair| pair.ray.is_none_or(|ray| !self.occluded[ray as usize]);
        for pairs in self.pairs.chunk_by(|a, b| a.second == b.second) {
            let light = light(pairs[0].second as usize);
            let sum: f32 = pairs.iter().filter(sees).map(|pair| pair.density).sum();
            for pair in pairs.iter().filter(sees) {
                let first = &firsts[pair.first as usize];
                let of_sky = match seconds[pair.second as usize].location {
                    Location::Diffuse(_) => 1.0,
                    Location::Sky(direction) => first.weight_of_sky(scene, direction, pair.density),
                };
                add(first.path, first.throughput * light * (of_sky * pair.density / sum));
            }
        }
    }

    /// Pairs of a second surface with those of the first that are of its group, of which `from` are before.
    fn connect(&mut self, number: usize, second: &SecondSurface, (from, firsts): (usize, &[FirstSurface])) {
        let number = number as u32;
        let own = || (from as u32..).zip(firsts).take_while(|(_, first)| first.group == second.group);
        let origin = own().find(|(_, first)| first.path == second.origin);
        let Some((origin, origin_side)) = origin.map(|(i, first)| (i, first.side)) else { return };
        // What the path itself has found edge-on stays its own.
        let Some((_, density)) = origin_side.density_of(&second.location) else {
            let density = match second.location {
                Location::Diffuse(_) => 1.0,
                Location::Sky(direction) => direction.dot(origin_side.shading).max(0.0) * FRAC_1_PI + f32::MIN_POSITIVE,
            };
            self.pairs.push(Pair { first: origin, second: number, density, ray: None });
            return;
        };
        self.pairs.push(Pair { first: origin, second: number, density, ray: None });
        for (i, first) in own().filter(|(i, _)| *i != origin) {
            let Some((wi, density)) = first.side.density_of(&second.location) else { continue };
            self.pairs.push(Pair { first: i, second: number, density, ray: Some(self.rays.len() as u32) });
            let target = match second.location {
                Location::Diffuse(side) => Some((side.position, side.geometric)),
                Location::Sky(_) => None,
            };
            self.rays.push(shadow_ray(&first.point, wi, target));
        }
    }
}
