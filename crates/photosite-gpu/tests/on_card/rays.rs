//! Rays find the surfaces that they find on the processor.

use glam::Vec3;
use photosite_gpu::probe;
use photosite_transport::geometry::{Primitive, Ray};
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::Scene;
use photosite_transport::scene::packed::{NONE, hierarchy};

use crate::Numbers;
use crate::scenes::{everything, moving};
use crate::stage::{Stage, ball, diffuse, placed};

const TEXT: &str = "
fn answer(words: array<vec4<u32>, 2>) -> array<vec4<u32>, 2> {
    let end = bitcast<f32>(words[0].w);
    let ray = Ray(bitcast<vec3<f32>>(words[0].xyz), end, bitcast<vec3<f32>>(words[1].xyz), NONE, 0u, NONE, bitcast<f32>(words[1].w));
    let hit = trace(ray, false);
    let is_hidden = trace(ray, true).slot != NONE;
    var primitive = hit.slot;
    if (hit.slot != NONE && (hit.slot & IS_QUADRIC) == 0u) {
        primitive = triangles[hit.slot * TRIANGLE_WORDS].w;
    }
    let instance = tables[params.instances + hit.instance * INSTANCE_WORDS + 6u].z;
    return array<vec4<u32>, 2>(
        vec4<u32>(bitcast<u32>(hit.t), primitive, instance, select(0u, 1u, is_hidden)),
        vec4<u32>(bitcast<vec2<u32>>(hit.uv), 0u, 0u),
    );
}";

/// Number by which the card knows what the processor has hit.
fn number(primitive: Primitive) -> u32 {
    match primitive {
        Primitive::Triangle(triangle) => triangle,
        Primitive::Quadric(quadric) => hierarchy::LEAF | quadric,
    }
}

/// Numbers of rays: those that hit, those that do so elsewhere than on the processor, and those whose distances differ by
/// more than four units in the last place.
#[derive(Debug, Default)]
struct Counts {
    hits: usize,
    elsewhere: usize,
    farther: usize,
}

impl Counts {
    /// Rays through edges that triangles share, and those that graze, may go either way: some in a hundred thousand.
    /// Distances of slender triangles, which the processor finds in f64, are off by some 1e-6: few triangles are.
    /// So are those of what moves, whose poses are of single precision on cards: one in `one_in` may be off.
    fn check(&self, one_in: usize) {
        let Self { hits, elsewhere, farther } = *self;
        assert!(hits > 1 << 15 && elsewhere * 25_000 <= hits && farther * one_in <= hits, "{self:?}");
    }
}

/// Traces rays between points around a scene.
fn compare(scene: &Scene, count: usize, size: f32) -> Option<Counts> {
    let card = crate::card()?;
    let mut numbers = Numbers(3);
    let mut point = || Vec3::from([(); 3].map(|()| (2.0 * numbers.next() - 1.0) * size)) + Vec3::Y * 0.4 * size;
    let rays: Vec<Ray> = (0..count)
        .map(|i| {
            let (origin, target) = (point(), point());
            let ray = Ray::new(origin, (target - origin).normalize());
            // Some end on their way.
            Ray { t_max: if i % 3 == 0 { 1.5 } else { 1e30 }, time: (i % 1000) as f32 / 999.0, ..ray }
        })
        .collect();
    let inputs: Vec<[[u32; 4]; 2]> = rays
        .iter()
        .map(|ray| {
            let word = |v: Vec3, beside: f32| [v.x, v.y, v.z, beside].map(f32::to_bits);
            [word(ray.origin, ray.t_max), word(ray.direction, ray.time)]
        })
        .collect();
    let packed = scene.packed().expect("a scene that cards render");
    let found = probe::answers::<2, 2>(card, &packed, SamplerKind::Sobol, TEXT, &inputs).expect("a kernel that runs");
    let mut counts = Counts::default();
    for (ray, [[t, primitive, instance, is_hidden], [u, v, ..]]) in rays.iter().zip(found) {
        let Some(hit) = scene.closest(ray) else {
            counts.elsewhere += usize::from(primitive != NONE || is_hidden != 0);
            continue;
        };
        counts.hits += 1;
        let apart = (f32::from_bits(t) - hit.t).abs() / hit.t.max(ray.origin.length());
        let places = [u, v].map(f32::from_bits);
        let is_near = places.iter().zip(hit.uv).all(|(a, b)| (a - b).abs() < 5e-4) && apart < 1e-5;
        let is_same = primitive == number(hit.primitive) && instance == hit.instance && is_hidden == 1;
        counts.elsewhere += usize::from(!(is_same && is_near));
        counts.farther += usize::from(apart > 4.0 * f32::EPSILON);
    }
    println!("{counts:?}");
    Some(counts)
}

#[test]
fn rays_meet_triangles_instances_and_quadrics_where_they_do_on_the_processor() {
    let Some(counts) = compare(&everything().build(), 1 << 19, 2.5) else { return };
    counts.check(3000);
}

#[test]
fn rays_meet_a_large_mesh_where_they_do_on_the_processor() {
    let scene =
        Stage::default().add("ball", diffuse([0.5; 3]), ball(128, 0.1, false), &[placed([0.2, 0.1, 0.0], 1.7)]).build();
    let Some(counts) = compare(&scene, 1 << 19, 2.5) else { return };
    counts.check(3000);
}

#[test]
fn rays_meet_what_moves_where_it_is_at_their_time() {
    let Some(counts) = compare(&moving().build(), 1 << 17, 2.5) else { return };
    counts.check(300);
}
