//! Exact ray tracing through a lens at one wavelength.

use std::borrow::Cow;
use std::fmt;

use glam::DVec3;

use crate::lens::Lens;
use crate::profile::Travel;

/// A ray, in mm, with z = 0 at the first vertex and +z towards the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Point on the ray.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

impl Ray {
    /// Point at which the ray crosses the plane of `z`.
    pub fn at_z(&self, z: f64) -> DVec3 {
        let distance = (z - self.origin.z) / self.direction.z;
        let DVec3 { x, y, .. } = self.origin + self.direction * distance;
        DVec3::new(x, y, z)
    }

    /// Reversed ray.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { origin: self.origin, direction: -self.direction }
    }
}

/// Treatment of semi-apertures and the stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Apertures {
    /// Apertures of the lens cut rays off.
    Clip,
    /// Apertures are ignored: for chief rays, which represent a bundle even where they are cut off themselves.
    Ignore,
}

/// Event of a ray at a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Refraction.
    Refract,
    /// Reflection.
    Reflect,
}

/// A step in a sequence of surfaces that a ray is traced through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Surface, counted from 0.
    pub surface: usize,
    /// Event at the surface.
    pub event: Event,
}

impl Step {
    /// Refraction at a surface.
    pub fn refract(surface: usize) -> Self {
        Self { surface, event: Event::Refract }
    }
}

/// Intersection of a ray with a surface, and the ray's directions before and after it.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Surface, counted from 0.
    pub surface: usize,
    /// Way of the ray before the surface.
    pub travel: Travel,
    /// Point of intersection, mm.
    pub point: DVec3,
    /// Unit direction before the surface.
    pub direction: DVec3,
    /// Unit direction after the surface.
    pub turned: DVec3,
    /// Unit normal of the surface, on the side of the ray's direction.
    pub normal: DVec3,
    /// Cosine of the angle of incidence.
    pub cos_incidence: f64,
    /// Distance from the point before, mm, in the medium of index `index`.
    pub distance: f64,
    /// Index before the surface.
    pub index: f64,
    /// Index behind the surface, also for a ray that is reflected.
    pub index_behind: f64,
}

/// End of a ray inside a lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped {
    /// Surface, counted from 0.
    pub surface: usize,
    /// Reason of the end.
    pub reason: Reason,
}

/// Reason for the end of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// No intersection with the surface.
    Missed,
    /// Intersection outside the semi-aperture, or on a blade.
    Blocked,
    /// Total reflection.
    TotalReflection,
}

impl fmt::Display for Reason {
    /// Verb phrase that precedes the surface.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Missed => "misses",
            Self::Blocked => "is blocked at",
            Self::TotalReflection => "is totally reflected at",
        })
    }
}

/// A lens at one wavelength: its indices are computed once for many rays.
#[derive(Clone, Debug)]
pub struct LensAt<'a> {
    /// Lens.
    pub lens: &'a Lens,
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Index before each surface, and behind the last.
    pub(crate) index: Cow<'a, [f64]>,
}

impl Lens {
    /// Lens at a wavelength in nm.
    pub fn at(&self, wavelength_nm: f64) -> LensAt<'_> {
        let behind = self.surfaces().iter().map(|surface| surface.index_behind(wavelength_nm));
        LensAt { lens: self, wavelength_nm, index: std::iter::once(1.0).chain(behind).collect() }
    }
}

impl LensAt<'_> {
    /// Index before a surface, counted from 0; for the number of surfaces, the index behind the last.
    pub fn index_before(&self, surface: usize) -> f64 {
        self.index[surface]
    }

    /// Traces a ray from the scene: the ray that leaves the last surface towards the sensor.
    pub fn trace_in(&self, ray: Ray, apertures: Apertures) -> Result<Ray, Stopped> {
        let steps = (0..self.lens.surfaces().len()).map(Step::refract);
        self.trace(ray, Travel::ToSensor, steps, apertures, |_| {})
    }

    /// Traces a ray from the sensor: the ray that leaves the first surface towards the scene.
    pub fn trace_out(&self, ray: Ray, apertures: Apertures) -> Result<Ray, Stopped> {
        let steps = (0..self.lens.surfaces().len()).rev().map(Step::refract);
        self.trace(ray, Travel::ToScene, steps, apertures, |_| {})
    }

    /// Least margin of a ray within all apertures, relative to their radii; below 0 where one cuts it off, and −∞ where
    /// it ends otherwise.
    pub(crate) fn margin(&self, ray: Ray, travel: Travel) -> f64 {
        let mut least = f64::INFINITY;
        let visit = |hit: &Hit| least = least.min(self.lens.margin(hit.surface, hit.point.truncate()));
        let surfaces = self.lens.surfaces().len();
        let in_order = |i: usize| Step::refract(if travel == Travel::ToSensor { i } else { surfaces - 1 - i });
        let traced = self.trace(ray, travel, (0..surfaces).map(in_order), Apertures::Ignore, visit);
        if traced.is_ok() || least < 0.0 { least } else { f64::NEG_INFINITY }
    }

    /// Traces a ray through a sequence of surfaces and calls `visit` for each intersection. `travel` is its way at
    /// first, which reflections turn. The surfaces of the sequence must follow each other as a ray meets them.
    ///
    /// Refraction is D′ = µ·D + (√(1 − µ²·(1 − cos²i)) − µ·cos i)·N with µ = n/n′ and the normal N along the ray
    /// ([Welford86](photosite_core::references#welford86) §4.3); reflection is D′ = D − 2·cos i·N.
    pub fn trace(
        &self,
        ray: Ray,
        travel: Travel,
        steps: impl IntoIterator<Item = Step>,
        apertures: Apertures,
        mut visit: impl FnMut(&Hit),
    ) -> Result<Ray, Stopped> {
        let (mut ray, mut travel) = (ray, travel);
        for Step { surface: number, event } in steps {
            let stopped = |reason| Stopped { surface: number, reason };
            let surface = &self.lens.surfaces()[number];
            let vertex = DVec3::new(0.0, 0.0, surface.z_mm);
            let Some(met) = surface.profile.meet(ray.origin - vertex, ray.direction, travel) else {
                return Err(stopped(Reason::Missed));
            };
            if apertures == Apertures::Clip && !self.lens.passes(number, met.point.truncate()) {
                return Err(stopped(Reason::Blocked));
            }
            let (index, index_behind) = match travel {
                Travel::ToSensor => (self.index[number], self.index[number + 1]),
                Travel::ToScene => (self.index[number + 1], self.index[number]),
            };
            let normal = met.normal * travel.sign();
            let cos_incidence = normal.dot(ray.direction);
            let turned = match event {
                Event::Reflect => ray.direction - normal * (2.0 * cos_incidence),
                Event::Refract => {
                    let ratio = index / index_behind;
                    let cos2 = 1.0 - ratio * ratio * (1.0 - cos_incidence * cos_incidence);
                    if cos2 < 0.0 {
                        return Err(stopped(Reason::TotalReflection));
                    }
                    ray.direction * ratio + normal * (cos2.sqrt() - ratio * cos_incidence)
                }
            };
            let point = met.point + vertex;
            visit(&Hit {
                surface: number,
                travel,
                point,
                direction: ray.direction,
                turned,
                normal,
                cos_incidence,
                distance: met.distance,
                index,
                index_behind,
            });
            ray = Ray { origin: point, direction: turned };
            if event == Event::Reflect {
                travel = travel.reversed();
            }
        }
        Ok(ray)
    }
}
