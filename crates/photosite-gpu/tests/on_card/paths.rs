//! Whole paths: with the same random numbers they bring what they bring on the processor.

use glam::Vec3;
use photosite_core::spectrum::Wavelengths;
use photosite_transport::geometry::Ray;
use photosite_transport::integrator::{Device, PathLimits, PathStart, radiance};
use photosite_transport::sampler::{Sampler, SamplerKind};
use photosite_transport::scene::Scene;

use crate::scenes::{everything, lamps_behind_panes, moving, outdoors, panes, under_lamps};

/// Starts that look into a scene from all around.
fn starts(count: u32, kind: SamplerKind) -> Vec<PathStart> {
    let mut sampler = Sampler::new(kind, 17);
    (0..count)
        .map(|index| {
            sampler.start(u64::from(index / 64), index % 64);
            let ([x, y], turn) = (sampler.next_2d(), sampler.next_1d());
            let angle = std::f32::consts::TAU * turn;
            let origin = Vec3::new(1.9 * angle.sin(), 1.5, 1.9 * angle.cos());
            let target = Vec3::new(3.0 * x - 1.5, 1.2 * y, 1.5 * turn - 0.7);
            let wavelengths = [430.0, 520.0, 590.0, 660.0].map(|lambda| lambda + 25.0 * x);
            PathStart {
                ray: Ray::new(origin, (target - origin).normalize()).at_time(x),
                wavelengths: Wavelengths::new(wavelengths, [0.003; 4]),
                position: sampler.position(),
            }
        })
        .collect()
}

/// Compares paths one by one, of which one in `one_in` may be another.
fn check(name: &str, scene: &Scene, kind: SamplerKind, limits: PathLimits, one_in: usize) {
    let Some(card) = crate::card() else { return };
    let count = 1 << 14;
    let starts = starts(count, kind);
    let tracer = card.load(scene, limits, kind).expect("a scene that cards render");
    let mut arrivals = Vec::new();
    tracer.trace(&starts, &mut arrivals).expect("a card that goes on");
    assert_eq!(arrivals.len(), starts.len());
    let (mut sums, mut squares, mut differing, mut lit) = ([0.0f64; 2], 0.0f64, 0, 0);
    let mut sampler = Sampler::new(kind, 17);
    for (start, arrival) in starts.iter().zip(&arrivals) {
        let mut wavelengths = start.wavelengths;
        sampler.resume(start.position);
        let expected = radiance(scene, start.ray, &mut wavelengths, &mut sampler, limits);
        let lanes = if wavelengths.is_hero_alone() { 1 } else { 4 };
        let near = |lane: usize| {
            let (a, b) = (arrival.light[lane], expected[lane]);
            assert!(a.is_finite(), "{name}: {start:?} brings {a}");
            (a - b).abs() <= 2e-3 * b.abs().max(1e-4)
        };
        let is_same = arrival.is_hero_alone == wavelengths.is_hero_alone() && (0..lanes).all(near);
        differing += usize::from(!is_same);
        lit += usize::from(!expected.is_black());
        let apart = f64::from(arrival.light[0]) - f64::from(expected[0]);
        squares += apart * apart;
        sums[0] += f64::from(arrival.light[0]);
        sums[1] += f64::from(expected[0]);
    }
    println!(
        "{name}, {kind:?}, {limits:?}: {differing} of {count} differ, means {} and {}, {:?} rays",
        sums[0] / f64::from(count),
        sums[1] / f64::from(count),
        tracer.rays()
    );
    // Where a rounding chooses another light, another lobe or another side of an edge, a path goes on as another one that
    // is as likely.
    let is_lit = limits.max_depth == 1 || lit * 2 > starts.len();
    assert!(differing * one_in <= starts.len() && is_lit, "{name}: {differing} of {count}, {lit} lit");
    assert!(
        (sums[0] - sums[1]).abs() <= 4.5 * squares.sqrt() + 1e-4 * sums[1],
        "{name}: {sums:?} within {}",
        squares.sqrt()
    );
    // The same bytes again, whatever goes with them.
    let mut again = Vec::new();
    tracer.trace(&starts[7..], &mut again).expect("a card that goes on");
    assert!(again == arrivals[7..], "{name}: another time other paths");
}

#[test]
fn paths_bring_what_they_bring_on_the_processor() {
    let mut stage = everything();
    // A mix chooses by all bits of the place on a surface, a veil by those of the ray, of which the last differ.
    stage.0.instances.retain(|instance| !["mixed", "veil"].contains(&instance.name.as_str()));
    let (without, with) = (stage.build(), everything().build());
    let limits = |max_depth: u32, roulette_depth: u32| PathLimits { max_depth, roulette_depth, splitting: 1 };
    check("without choices", &without, SamplerKind::Sobol, limits(1, 5), 1000);
    check("without choices", &without, SamplerKind::Sobol, limits(2, 5), 1000);
    check("without choices", &without, SamplerKind::Sobol, limits(8, 100), 1000);
    // Within clear glass all light goes on, so that rounding decides whether roulette is played, and which numbers follow.
    check("without choices", &without, SamplerKind::Independent, limits(20, 4), 100);
    // Mixes and veils choose by bits of which rounding changes the last.
    check("everything", &with, SamplerKind::Sobol, limits(8, 3), 25);
}

#[test]
fn paths_bring_the_light_of_a_sky() {
    let limits = PathLimits { max_depth: 8, roulette_depth: 100, splitting: 1 };
    check("outdoors", &outdoors().build(), SamplerKind::Sobol, limits, 100);
}

#[test]
fn paths_bring_the_light_of_lamps_without_a_surface() {
    let limits = PathLimits { max_depth: 6, roulette_depth: 100, splitting: 1 };
    check("lamps", &under_lamps().build(), SamplerKind::Sobol, limits, 200);
}

#[test]
fn panes_let_pass_what_they_do_on_the_processor() {
    let limits = PathLimits { max_depth: 9, roulette_depth: 4, splitting: 1 };
    check("panes", &panes().build(), SamplerKind::Sobol, limits, 1000);
}

#[test]
fn paths_bring_what_they_bring_on_the_processor_where_things_move() {
    let limits = PathLimits { max_depth: 8, roulette_depth: 100, splitting: 1 };
    check("moving", &moving().build(), SamplerKind::Sobol, limits, 500);
}

#[test]
fn lamps_shine_through_panes_as_on_the_processor() {
    let mut stage = lamps_behind_panes();
    // A mix chooses by all bits of the place on a surface.
    stage.0.instances.retain(|instance| instance.name != "tinted");
    let limits = PathLimits { max_depth: 6, roulette_depth: 100, splitting: 1 };
    check("lamps behind panes", &stage.build(), SamplerKind::Sobol, limits, 100);
}
