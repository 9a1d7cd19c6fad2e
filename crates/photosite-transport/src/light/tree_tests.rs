//! The tree against counting, and against all lights looked at one by one.

use glam::{DAffine3, DQuat, DVec3, Quat, Vec3};

use super::choice::Choice;
use super::tree::LightTree;
use super::{
    AreaLight, DeltaLight, Facing, Light, LightKind, LightPose, LightSampleContext, PointLight, SpotLight,
    SurfaceEmission, Tint,
};
use crate::geometry::{Deformation, Geometry, MeshRange, Motion, Primitive, Triangle};
use photosite_core::math::hash::{hash64, unit_f32};
use photosite_core::math::warp;
use photosite_core::spectrum::{Spectrum, SpectrumId, SpectrumTable};

/// Numbers in [0, 1) by two keys.
fn number(key: u64, i: u64) -> f32 {
    unit_f32(hash64(key, i) as u32)
}

fn direction(key: u64) -> Vec3 {
    warp::uniform_sphere([number(key, 100), number(key, 101)])
}

fn place(key: u64) -> Vec3 {
    Vec3::new(number(key, 102), number(key, 103), number(key, 104)) * 4.0 - 2.0
}

/// Triangles in the upper half of the numbers, that turn and grow in the time of the image; lights in the lower.
struct Lot {
    lights: Vec<Light>,
    motions: Vec<Option<Motion>>,
    powers: Vec<f64>,
    geometry: Geometry,
}

fn delta_light(kind: LightKind, position: Vec3, axis: Vec3, level: SpectrumId) -> Light {
    let world_to_light = Quat::from_rotation_arc(axis, Vec3::NEG_Z);
    Light::Delta(Box::new(DeltaLight::new(kind, LightPose { position, axis, world_to_light }, level)))
}

fn lot(count: u32, seed: u64) -> Lot {
    let radiance: SpectrumId = SpectrumTable::default().add(&Spectrum::constant(1.0));
    let mut lot = Lot { lights: Vec::new(), motions: Vec::new(), powers: Vec::new(), geometry: Geometry::default() };
    let mut later = Vec::new();
    for light in 0..count {
        let key = hash64(seed, u64::from(light));
        lot.powers.push(if number(key, 0) < 0.05 { 0.0 } else { f64::from(number(key, 1)).powi(4) });
        let (position, axis) = (place(key), direction(key));
        if light >= count / 2 {
            let triangle = lot.geometry.triangles.len() as u32;
            let size = 0.01 + number(key, 2).powi(3);
            let corners = [1, 2, 3].map(|i| position + direction(hash64(key, i)) * size);
            lot.geometry.positions.extend(corners);
            // A turn by up to 1 rad about the middle.
            let turn = glam::Quat::from_axis_angle(axis, number(key, 3)) * (0.5 + number(key, 4));
            later.extend(corners.map(|c| position + turn * (c - position)));
            lot.geometry.triangles.push(Triangle { corners: [0, 1, 2].map(|i| 3 * triangle + i), mesh: 0 });
            let emission = SurfaceEmission { radiance, tint: Tint::None, two_sided: number(key, 5) < 0.3 };
            lot.lights.push(Light::Area(AreaLight { primitive: Primitive::Triangle(triangle), emission }));
            lot.motions.push(None);
            continue;
        }
        let turn = DQuat::from_axis_angle(direction(hash64(key, 7)).as_dvec3(), f64::from(number(key, 6)));
        let places = [DAffine3::IDENTITY, DAffine3::from_rotation_translation(turn, DVec3::splat(0.3))];
        lot.motions.push((number(key, 8) < 0.3).then(|| Motion::new(&places)));
        let outer_rad = 0.05 + 1.5 * number(key, 9);
        lot.lights.push(match light % 2 {
            0 => delta_light(LightKind::Point(PointLight), position, axis, radiance),
            _ => delta_light(LightKind::Spot(SpotLight::new(0.0, outer_rad)), position, axis, radiance),
        });
    }
    let corner_count = lot.geometry.positions.len() as u32;
    let positions = lot.geometry.positions.iter().copied().chain(later).collect();
    lot.geometry.deformations.push(Deformation { first_corner: 0, corner_count, positions, normals: Vec::new() });
    lot.geometry.meshes.push(MeshRange {
        material: 0,
        first_primitive: 0,
        first_triangle: 0,
        triangle_count: corner_count / 3,
        first_light: None,
        normals_from: None,
        tangents_from: None,
        uvs_from: [None; 2],
        colours_from: None,
        deformation: Some(0),
        quadric: None,
    });
    lot
}

impl Lot {
    fn tree(&self) -> LightTree {
        let each = self.lights.iter().zip(&self.motions).zip(&self.powers);
        LightTree::new(each.map(|((l, m), p)| l.bounds(m.as_ref(), *p, &self.geometry)))
    }

    /// Whether a point gets any light from a light at a time.
    fn shines(&self, light: usize, ctx: &LightSampleContext, time: f32) -> bool {
        let arrives = |from: Vec3| match ctx.facing {
            Facing::Front(normal) => (from - ctx.point).normalize().dot(normal) > 1e-4,
            Facing::Both(_) | Facing::Anywhere => true,
        };
        let place = self.motions[light].as_ref().map(|motion| motion.at(time));
        let in_world = |position: Vec3| place.map_or(position, |place| place.to_world.transform_point3(position));
        self.powers[light] > 0.0
            && match &self.lights[light] {
                Light::Delta(light) => {
                    let LightPose { position, axis, .. } = *light.pose();
                    let axis = place.map_or(axis, |place| place.to_world.transform_vector3(axis));
                    let position = in_world(position);
                    let cos_outer =
                        if let LightKind::Spot(spot) = light.kind() { spot.outer_rad().cos() } else { -2.0 };
                    arrives(position) && (ctx.point - position).normalize().dot(axis) > cos_outer
                }
                Light::Area(AreaLight { primitive, emission }) => {
                    let triangle = primitive.triangle().expect("a triangle");
                    let corners = self.geometry.corners_at(triangle, time);
                    let [a, b, c] = corners;
                    let normal = (b - a).cross(c - a).normalize();
                    let cos = (ctx.point - a).normalize().dot(normal);
                    (cos > 1e-4 || emission.two_sided && cos < -1e-4) && corners.into_iter().any(arrives)
                }
                Light::Environment => false,
            }
    }
}

fn ctx(key: u64) -> LightSampleContext {
    let facing = [Facing::Front(direction(key)), Facing::Both(direction(key)), Facing::Anywhere][(key % 3) as usize];
    LightSampleContext { point: place(key) * (1.0 + (key % 5) as f32), facing }
}

#[test]
fn a_light_that_shines_at_a_point_can_be_found() {
    let mut shining = 0;
    for (count, seed) in [(1, 1), (2, 2), (3, 3), (8, 4), (100, 5), (1000, 6)] {
        let lot = lot(count, seed);
        let tree = lot.tree();
        for key in 0..60 {
            let ctx = ctx(hash64(seed, key));
            for light in 0..count {
                let probability = tree.probability(&ctx, light);
                let time = number(key, u64::from(light));
                if lot.shines(light as usize, &ctx, time) {
                    shining += 1;
                    assert!(probability > 0.0, "{count} {key} {:?} {ctx:?}", lot.lights[light as usize]);
                }
                assert!(lot.powers[light as usize] > 0.0 || probability == 0.0);
            }
        }
    }
    assert!(shining > 10_000, "{shining}");
}

#[test]
fn lights_are_found_as_often_as_the_probability_says() {
    for (count, seed) in [(1, 11), (2, 12), (5, 13), (40, 14), (300, 15)] {
        let tree = lot(count, seed).tree();
        for key in 0..12 {
            let ctx = ctx(hash64(seed, key));
            let expected: Vec<f64> = (0..count).map(|l| f64::from(tree.probability(&ctx, l))).collect();
            let n = 1 << 15;
            let (mut found, mut lost) = (vec![0u32; count as usize], 0u32);
            for i in 0..n {
                match tree.sample(&ctx, (i as f32 + 0.5) / n as f32) {
                    Some(Choice { light, probability, rest }) => {
                        found[light as usize] += 1;
                        assert!((0.0..1.0).contains(&rest));
                        // The same steps give the same bits.
                        assert_eq!(probability, tree.probability(&ctx, light));
                    }
                    None => lost += 1,
                }
            }
            // Each light has one interval of the numbers. It is off by a step at either end, and by the rounding of as
            // many quotients as the tree is deep, 2⁻²⁴ of the interval that they are of.
            let tolerance = 2.0 / f64::from(n) + 40.0 * 2f64.powi(-24);
            for (found, expected) in found.iter().zip(&expected) {
                assert!((f64::from(*found) / f64::from(n) - expected).abs() < tolerance, "{found} {expected}");
            }
            let sum: f64 = expected.iter().sum();
            let lost = f64::from(lost) / f64::from(n);
            assert!((sum + lost - 1.0).abs() < tolerance * f64::from(count), "{count} {key}: {sum} and {lost}");
        }
    }
}

#[test]
fn little_is_lost_where_lights_shine_all_around() {
    let lot = lot(300, 21);
    let points = (0..)
        .zip(&lot.lights)
        .filter(|(_, light)| matches!(light, Light::Delta(light) if matches!(light.kind(), LightKind::Point(_))));
    let points: Vec<usize> = points.map(|(i, _)| i).collect();
    let bounds = points.iter().map(|i| lot.lights[*i].bounds(None, lot.powers[*i], &lot.geometry));
    let tree = LightTree::new(bounds);
    for key in 0..100 {
        let ctx = LightSampleContext::anywhere(place(key));
        let sum: f64 = (0..points.len() as u32).map(|l| f64::from(tree.probability(&ctx, l))).sum();
        // Roundings of a product of some ten parts.
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
    }
}

#[test]
fn lights_in_one_place_and_on_a_line_make_a_tree() {
    let radiance = SpectrumTable::default().add(&Spectrum::constant(1.0));
    for place in [|_| Vec3::ONE, |i: u32| Vec3::X * i as f32] {
        let light = |i| delta_light(LightKind::Point(PointLight), place(i), Vec3::NEG_Z, radiance);
        let geometry = Geometry::default();
        let tree = LightTree::new((0..50).map(|i| light(i).bounds(None, 1.0, &geometry)));
        for ctx in [
            LightSampleContext::anywhere(Vec3::Y * 5.0),
            LightSampleContext::anywhere(Vec3::ONE),
            LightSampleContext::anywhere(Vec3::X),
        ] {
            let sum: f64 = (0..50).map(|l| f64::from(tree.probability(&ctx, l))).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        }
    }
}
