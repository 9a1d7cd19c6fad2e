//! Radii that surfaces need for the beams of a file's fields.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2, DVec3};
use photosite_core::spectrum::dispersion::lines;

use super::draft::Field;
use crate::profile::Travel;
use crate::trace::{Apertures, Step};
use crate::{Lens, LensAt, Ray};

/// Number of points on the stop's rim.
const AZIMUTHS: u32 = 16;
/// Steps of Newton's method; four or five are needed.
const STEPS: u32 = 20;
/// Distance from its point on the stop's rim at which a ray counts as found, relative to the stop's radius.
const TOLERANCE: f64 = 1e-9;

/// Largest distance from the axis at each surface of rays through the stop's rim, from parallel light on the axis and
/// at the fields, at the lines F, d and C. `None` where no such ray reaches the surface.
pub(super) fn radii(lens: &Lens, fields: &[Field]) -> Vec<Option<f64>> {
    let mut radii = vec![None; lens.surfaces().len()];
    let axis = Field { angle_deg: 0.0, vignetting: [0.0; 2] };
    for line in [lines::D, lines::F, lines::C] {
        let at = lens.at(line);
        for field in std::iter::once(&axis).chain(fields) {
            for point in beam(&at, field).into_iter().flatten() {
                for (radius, point) in radii.iter_mut().zip(point) {
                    let reached = point.truncate().length();
                    *radius = Some(radius.unwrap_or(0.0_f64).max(reached)).filter(|radius| *radius > 0.0);
                }
            }
        }
    }
    radii
}

/// Fraction of the stop's radius that light on the axis fills: 1 unless rays to its rim miss a surface, as they do
/// where the stop is wider than the glass.
pub(super) fn open_part(lens: &Lens) -> f64 {
    let passes = |part: f64| {
        let lens = lens.with_stop_radius(part * lens.stop_radius_mm());
        let axis = Field { angle_deg: 0.0, vignetting: [0.0; 2] };
        beam(&lens.at(lines::D), &axis).is_some_and(|rays| rays.len() == AZIMUTHS as usize)
    };
    // Where nothing passes, something else is wrong, and is found later.
    if passes(1.0) || !passes(1e-3) {
        return 1.0;
    }
    let (mut passed, mut missed) = (1e-3, 1.0);
    for _ in 0..STEPS {
        let middle = 0.5 * (passed + missed);
        *(if passes(middle) { &mut passed } else { &mut missed }) = middle;
    }
    passed
}

/// Least radius that each surface needs, mm: for the whole beam on the axis, and for the chief rays at these angles,
/// degrees. Infinite where no such ray comes to the surface.
pub(super) fn needed(lens: &Lens, angles_deg: &[f64]) -> Vec<f64> {
    let mut needed: Vec<f64> = radii(lens, &[]).into_iter().map(|radius| radius.unwrap_or(f64::INFINITY)).collect();
    let at = lens.at(lines::D);
    for angle in angles_deg.iter().filter(|angle| **angle != 0.0) {
        let chief = at.chief_ray(angle.to_radians()).and_then(|chief| points(&at, chief.before, needed.len()));
        for (needed, point) in needed.iter_mut().zip(chief.into_iter().flatten()) {
            *needed = needed.max(point.truncate().length());
        }
    }
    needed
}

/// Points at all surfaces of rays through the stop's rim. `None` where the field has no chief ray.
fn beam(at: &LensAt, field: &Field) -> Option<Vec<Vec<DVec3>>> {
    let angle = field.angle_deg.to_radians();
    let chief = if angle == 0.0 { at.chief_ray_of_stop_angle(0.0).ok()? } else { at.chief_ray(angle)? };
    let direction = DVec3::new(0.0, angle.sin(), angle.cos());
    let across = DVec3::new(0.0, angle.cos(), -angle.sin());
    let ray = |offset: DVec2| Ray { origin: chief.before.origin + DVec3::X * offset.x + across * offset.y, direction };
    let radius = at.lens.stop_radius_mm();
    let scale = 0.5 * at.first_order().entrance_pupil_diameter_mm / radius;
    let rays = (0..AZIMUTHS).filter_map(|i| {
        let on_rim = DVec2::from_angle(f64::from(i) * TAU / f64::from(AZIMUTHS));
        let [upper, lower] = field.vignetting;
        let cut = if on_rim.y > 0.0 { upper } else { lower };
        let target = radius * DVec2::new(on_rim.x, on_rim.y * (1.0 - cut));
        let miss = |offset: DVec2| Some(at_stop(at, ray(offset))? - target);
        let offset = solved(miss, scale * target, 1e-4 * scale * radius, TOLERANCE * radius)?;
        points(at, ray(offset), at.lens.surfaces().len())
    });
    Some(rays.collect())
}

/// Points at which a ray meets the surfaces from the first to before `end`.
fn points(at: &LensAt, ray: Ray, end: usize) -> Option<Vec<DVec3>> {
    let mut points = Vec::new();
    at.trace(ray, Travel::ToSensor, (0..end).map(Step::refract), Apertures::Ignore, |hit| points.push(hit.point))
        .ok()?;
    Some(points)
}

fn at_stop(at: &LensAt, ray: Ray) -> Option<DVec2> {
    points(at, ray, at.lens.stop() + 1)?.last().map(|point| point.truncate())
}

/// Zero of a function of the plane, by Newton's method with finite differences.
fn solved(f: impl Fn(DVec2) -> Option<DVec2>, start: DVec2, step: f64, tolerance: f64) -> Option<DVec2> {
    let mut x = start;
    for _ in 0..STEPS {
        let y = f(x)?;
        if y.length() < tolerance {
            return Some(x);
        }
        let column = |by: DVec2| Some((f(x + by)? - y) / step);
        let jacobian = DMat2::from_cols(column(DVec2::X * step)?, column(DVec2::Y * step)?);
        let next = x - jacobian.inverse() * y;
        if !next.is_finite() {
            return None;
        }
        x = next;
    }
    None
}
