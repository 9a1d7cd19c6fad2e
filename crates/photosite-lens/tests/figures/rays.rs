//! Single rays at every surface.

use glam::DVec2;
use photosite_lens::profile::Travel;
use photosite_lens::trace::{Apertures, Event, Hit, Step};
use photosite_lens::{Lens, Ray};
use rstest::rstest;

use crate::neutral::{Case, cases, close, list, number, numbers, prescription, read, vector};

/// Rays from the sensor out: all points of six rays, ends of the others, and the surfaces where blocked ones end.
#[test]
fn rays_at_every_surface() {
    for Case { name, lens, figures, .. } in cases() {
        let Some(rays) = figures.get("rays") else { continue };
        for (number_of_ray, ray) in list(&rays["rays"]).iter().enumerate() {
            let what = format!("{name}, ray {number_of_ray}");
            let at = lens.at(number(&ray["nm"]));
            let start = Ray { origin: vector(&ray["from_mm"]), direction: vector(&ray["direction"]).normalize() };
            let mut points = Vec::new();
            let steps = (0..lens.surfaces().len()).rev().map(Step::refract);
            let found = at.trace(start, Travel::ToScene, steps, Apertures::Clip, |hit| points.push(hit.point));
            match (found, ray["passes"].as_bool()) {
                (Ok(out), Some(true)) => {
                    assert!(out.origin.distance(vector(&ray["to_mm"])) < 1e-9, "{what}: {out:?}");
                    assert!(out.direction.distance(vector(&ray["exit_direction"])) < 1e-10, "{what}: {out:?}");
                    for (point, expected) in points.iter().zip(ray.get("points_mm").map_or(&[][..], |all| list(all))) {
                        assert!(point.distance(vector(expected)) < 1e-9, "{what}: {point} in place of {expected}");
                    }
                    // And back in.
                    let back = at.trace_in(out.reversed(), Apertures::Clip).expect("the same way");
                    assert!(back.at_z(start.origin.z).distance(start.origin) < 1e-9, "{what}: {back:?}");
                }
                (Err(stopped), Some(false)) => {
                    assert_eq!(Some(stopped.surface as u64), ray["blocked_at"].as_u64(), "{what}: {stopped:?}");
                }
                (found, expected) => panic!("{what}: {found:?} in place of {expected:?}"),
            }
        }
    }
}

/// Ghosts of two bounces, unfolded with two mirrors by both programs.
#[rstest]
#[case("cooke-triplet")]
#[case("canon-ef50")]
fn ghost_rays(#[case] name: &str) {
    let lens = Lens::new(&prescription(&read(name))).expect("a lens");
    for ghost in list(&read("ghosts")[name]) {
        let surface = |key: &str| ghost[key].as_u64().expect("a surface") as usize;
        let (first, then) = (surface("reflects_first_at"), surface("then_at"));
        let mirror = |surface| [Step { surface, event: Event::Reflect }];
        let steps: Vec<Step> = (0..first)
            .map(Step::refract)
            .chain(mirror(first))
            .chain((then + 1..first).rev().map(Step::refract))
            .chain(mirror(then))
            .chain((then + 1..lens.surfaces().len()).map(Step::refract))
            .collect();
        let at = lens.at(number(&ghost["nm"]));
        for ray in list(&ghost["rays"]) {
            let start = Ray { origin: vector(&ray["from_mm"]), direction: vector(&ray["direction"]) };
            let mut cosines = Vec::new();
            let mirrored = |hit: &Hit| {
                if hit.direction.z * hit.turned.z < 0.0 {
                    cosines.push(hit.cos_incidence);
                }
            };
            let end =
                at.trace(start, Travel::ToSensor, steps.iter().copied(), Apertures::Clip, mirrored).expect("passes");
            let landed = end.at_z(lens.sensor_z_mm()).truncate();
            let expected = DVec2::from_slice(&numbers(&ray["at_sensor_mm"]));
            assert!(landed.distance(expected) < 1e-9, "{name} {first} {then}: {landed} in place of {expected}");
            for (found, expected) in cosines.iter().zip(numbers(&ray["cosines_of_incidence"])) {
                close(&format!("{name} {first} {then}"), *found, expected, 1e-11);
            }
            assert_eq!(cosines.len(), 2);
        }
    }
}
