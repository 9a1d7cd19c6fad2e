//! Interaction with a surface, common to paths from the camera and from lights: the rays that leave it, and the power
//! that they carry.

use glam::Vec3;

use crate::geometry::{Ray, SurfacePoint, offset};
use crate::light::{Facing, LightSampleContext};
use crate::scene::Shading;
use photosite_core::math::float::gamma;
use photosite_core::math::{Real, Vector};
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};

/// The context in which a surface samples lights.
#[inline]
pub(super) fn light_sample_context(point: &SurfacePoint, shading: &Shading) -> LightSampleContext {
    // The shading normal of a surface that only reflects is on the side that it is seen from.
    let normal = shading.frame.z;
    let facing = if shading.bsdf.transmits() { Facing::Both(normal) } else { Facing::Front(normal) };
    LightSampleContext { point: point.position, facing }
}

/// Whether light on its way wi → wo would leak through an opaque surface whose shading normal disagrees with the
/// geometric one ([Veach97](photosite_core::references#veach97) §5.3). Such light is dropped. Light that a dielectric
/// reflects or refracts to the wrong side of the surface is kept: both sides scatter light, and it would be missing.
#[inline]
pub(super) fn leaks(point: &SurfacePoint, shading: &Shading, wo: Vec3, wi: Vec3, is_transmission: bool) -> bool {
    let crosses = wo.dot(point.geometric_normal) * wi.dot(point.geometric_normal) < 0.0;
    crosses != is_transmission && !shading.bsdf.transmits()
}

/// Leaves the path its hero wavelength alone.
#[inline]
pub(super) fn terminate_secondary(wavelengths: &mut Wavelengths, throughput: &mut SampledSpectrum) {
    wavelengths.terminate_secondary();
    *throughput = SampledSpectrum::from([throughput[0], 0.0, 0.0, 0.0]);
}

/// The ray from a surface point to a light: up to just before its surface, or without end.
#[inline]
pub(super) fn shadow_ray(point: &SurfacePoint, wi: Vec3, light: Option<(Vec3, Vec3)>) -> Ray {
    let mut ray = point.spawn_ray(wi);
    if let Some((position, normal)) = light {
        let target = if normal == Vec3::ZERO {
            position
        } else {
            towards_light(position.into(), normal.into(), wi.into()).into()
        };
        ray.direction = target - ray.origin;
        ray.t_max = 1.0;
    }
    ray
}

/// End of a ray in the unit direction `wi` to a point of a light with this unit normal: just before the point.
#[inline(always)]
pub(super) fn towards_light<R: Real>(position: Vector<R>, normal: Vector<R>, wi: Vector<R>) -> Vector<R> {
    // A few roundings lie between the light's corners and its sampled point.
    offset(position, position.abs() * position.x.broadcast(gamma(8)), normal, -wi)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::accel_tests::{Numbers, geometry, in_world};
    use crate::geometry::{AcceptAll, Hit, Primitive, interpolate};
    use photosite_core::math::warp;

    #[test]
    fn lamps_of_any_shape_and_place_do_not_hide_themselves() {
        let mut numbers = Numbers(71);
        for (size, aspect) in [(0.1f32, 1.0f32), (1.0, 1.0), (1.0, 10.0), (1.0, 100.0), (10.0, 1e3), (100.0, 1e5)] {
            for distance in [0.01f32, 1.0, 100.0, 1e4] {
                for place in [0.0f32, 1.0, 1e3] {
                    let (mut lit, mut hidden) = (0, 0);
                    for _ in 0..400 {
                        let frame = photosite_core::math::Frame::from_normal(warp::uniform_sphere([
                            numbers.next(),
                            numbers.next(),
                        ]));
                        let centre = warp::uniform_sphere([numbers.next(), numbers.next()]) * place;
                        let corner = |x: f32, y: f32| centre + (frame.x * (x / aspect) + frame.y * y) * size;
                        let lamp = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.3, 1.0)];
                        let at = centre + warp::uniform_sphere([numbers.next(), numbers.next()]) * distance * size;
                        let side = warp::uniform_sphere([numbers.next(), numbers.next()]) * size;
                        let floor = [at, at + side, at + side.cross(frame.x + 0.3 * frame.z)];
                        let g = geometry(&[lamp, floor]);
                        let accel = in_world(&g);
                        let hit = Hit { t: 1.0, uv: [0.3, 0.3], primitive: Primitive::Triangle(1), instance: 0 };
                        let point = SurfacePoint::new(&g, &accel, &hit, 0.0);
                        let on_lamp = interpolate(lamp, warp::uniform_triangle([numbers.next(), numbers.next()]));
                        let normal = (lamp[1] - lamp[0]).cross(lamp[2] - lamp[0]).normalize();
                        let wi = (on_lamp - point.position).normalize();
                        if wi.dot(normal).abs() < 0.05 || wi.dot(point.geometric_normal).abs() < 0.05 {
                            continue;
                        }
                        lit += 1;
                        let ray = Ray { to: 0, ..shadow_ray(&point, wi, Some((on_lamp, normal))) };
                        hidden += u32::from(accel.occluded(&ray, &AcceptAll));
                    }
                    assert!(
                        hidden == 0 && lit > 100,
                        "size {size}, aspect {aspect}, distance {distance}, place {place}: {hidden} of {lit}"
                    );
                }
            }
        }
    }
}
