//! The planner: what it chooses, and that it depends on nothing but the seed and what is rendered.

use std::ops::ControlFlow;

use glam::{DAffine3, DQuat, DVec3};
use photosite::film::{FilmResponses, Response};
use photosite::integrator::{LightPathKind, Plan, RenderJob, RenderSettings, StrategyChoice, WavelengthChoice, plan};
use photosite::optics::{Camera, PixelGrid};
use photosite::scene::Scene;
use photosite::scene::description::{Diffuse, MaterialModel};
use photosite::spectrum::Spectrum;
use rayon::ThreadPoolBuilder;

use crate::light_paths::{glass, grey, lens, room, screened};
use crate::stage::camera;

const RESOLUTION: [u32; 2] = [64, 48];

/// 2²⁰ samples.
fn settings() -> RenderSettings {
    RenderSettings { samples_per_pixel: (1 << 20) / (64 * 48) + 1, max_depth: 6, ..RenderSettings::default() }
}

fn eye() -> Camera {
    let grid = PixelGrid { resolution: RESOLUTION, pitch_m: [2.5e-4; 2] };
    camera(&lens(), &grid, DAffine3::from_rotation_translation(DQuat::from_rotation_x(-0.5), DVec3::new(0.0, 0.1, 2.2)))
}

fn planned(scene: &Scene, settings: &RenderSettings) -> Option<Plan> {
    let responses = [Response::new("E", Spectrum::constant(1e-3))];
    let job = RenderJob {
        scene,
        camera: &eye(),
        transmittance: &Spectrum::constant(1.0),
        responses: &responses,
        filters: None,
        importance: None,
        resolution: RESOLUTION,
        settings,
        device: None,
    };
    plan(&job, &FilmResponses::new(&responses), None, &|_| ControlFlow::Continue(()))
}

fn diffuse() -> MaterialModel {
    MaterialModel::Diffuse(Diffuse { reflectance: grey(0.7) })
}

#[test]
fn light_paths_are_planned_where_glass_focuses_and_where_a_screen_is_before_the_lamp() {
    let of_glass = planned(&room(glass(0.0)).build(), &settings()).expect("a plan");
    assert!(of_glass.light_paths > 0.0 && of_glass.gain > 2.0, "{of_glass:?}");
    let behind_screen = planned(&screened(diffuse()).build(), &settings()).expect("a plan");
    assert!(behind_screen.light_paths > 0.0 && behind_screen.gain > 1.4, "{behind_screen:?}");
    // Something polished in the room makes the light of the lamp behind its screen no easier to find.
    let both = planned(&screened(glass(0.0)).build(), &settings()).expect("a plan");
    assert!(both.light_paths > 0.0 && both.gain > 1.4, "{both:?}");
    assert_eq!([behind_screen, both].map(|plan| plan.light_path_kind), [LightPathKind::Indirect; 2]);
    for plan in [of_glass, behind_screen, both] {
        assert!(plan.cost > 0.0 && plan.cost < 0.15, "{plan:?}");
    }
}

#[test]
fn a_plan_depends_on_neither_threads_nor_the_part_that_is_rendered() {
    let scene = room(glass(0.0)).build();
    let whole = planned(&scene, &settings());
    assert!(whole.is_some());
    let part = RenderSettings { part: Some(3..7), ..settings() };
    for threads in [1, 2, 7] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        assert_eq!(pool.install(|| planned(&scene, &part)), whole, "{threads}");
    }
    assert_ne!(planned(&scene, &RenderSettings { seed: 1, ..settings() }), whole);
}

#[test]
fn what_is_set_stays_and_nothing_is_planned_where_nothing_is_left_to_choose() {
    let [scene, matt] = [glass(0.0), diffuse()].map(|model| room(model).build());
    let split = planned(&scene, &RenderSettings { splitting: Some(3), ..settings() }).expect("a plan");
    assert!(split.splitting == 3 && split.light_paths > 0.0, "{split:?}");
    let without = planned(&scene, &RenderSettings { light_paths: Some(0.0), ..settings() }).expect("a plan");
    assert_eq!(without.light_paths, 0.0);
    // Of a number of light paths that is set, the light that they bring is left to choose where something is polished.
    let numbers = RenderSettings { splitting: Some(1), light_paths: Some(1.0), ..settings() };
    let set = planned(&scene, &numbers).expect("a plan");
    assert_eq!((set.splitting, set.light_paths), (1, 1.0));
    assert_eq!(planned(&matt, &numbers), None);
    for settings in [
        RenderSettings { strategy: StrategyChoice::Plain, ..settings() },
        RenderSettings { splitting: Some(1), light_paths: Some(0.0), ..settings() },
        RenderSettings { wavelengths: WavelengthChoice::OwnFilter, ..settings() },
        RenderSettings { samples_per_pixel: settings().samples_per_pixel - 1, ..settings() },
    ] {
        assert_eq!(planned(&scene, &settings), None, "{settings:?}");
    }
}
