//! Rays per second of every kind that a path has.

use std::fmt;
use std::sync::LazyLock;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::Vec3;
use photosite::geometry::{Ray, offset_origin};
use photosite::math::{Frame, warp};
use photosite::sampler::{Sampler, SamplerKind};
use photosite::scene::{self, Scene};

use crate::scenes::{self, LARGE_SPHERE};

/// Rays of one kind are traced row by row of a square picture, as a render does.
const SIDE: u32 = 256;

#[divan::bench(args = Kind::ALL, sample_count = 10, sample_size = 1)]
fn cornell_box(bencher: Bencher, kind: &Kind) {
    static STAGE: LazyLock<Stage> = LazyLock::new(|| {
        let scene = scene::build(scenes::cornell_box(), &scenes::visible());
        Stage::new(scene, Vec3::new(278.0, 273.0, -800.0), Vec3::Z, 0.36, Vec3::new(278.0, 548.0, 280.0))
    });
    trace(bencher, &STAGE, *kind);
}

#[divan::bench(args = Kind::ALL, sample_count = 10, sample_size = 1)]
fn sphere_from_inside(bencher: Bencher, kind: &Kind) {
    static STAGE: LazyLock<Stage> = LazyLock::new(|| {
        let (bands, sectors) = LARGE_SPHERE;
        let scene = scene::build(scenes::sphere(bands, sectors), &scenes::visible());
        Stage::new(scene, Vec3::new(0.0, 0.0, 0.5), Vec3::NEG_Z, 0.6, Vec3::new(0.3, 0.5, 0.2))
    });
    trace(bencher, &STAGE, *kind);
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Primary,
    FirstBounce,
    SecondBounce,
    /// From where primary rays hit to a point light.
    FirstShadow,
    /// From where first bounces hit to it.
    SecondShadow,
}

impl Kind {
    const ALL: [Self; 5] =
        [Self::Primary, Self::FirstBounce, Self::SecondBounce, Self::FirstShadow, Self::SecondShadow];
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Primary => "primary",
            Self::FirstBounce => "first diffuse bounce",
            Self::SecondBounce => "second diffuse bounce",
            Self::FirstShadow => "shadow of the first hit",
            Self::SecondShadow => "shadow of the second hit",
        })
    }
}

/// A scene with rays to trace in it.
struct Stage {
    scene: Scene,
    bounces: [Vec<Ray>; 3],
    shadows: [Vec<Ray>; 2],
}

impl Stage {
    /// The camera looks from `eye` along `forward`; half of the picture is `half_width` wide at distance 1.
    fn new(scene: Scene, eye: Vec3, forward: Vec3, half_width: f32, light: Vec3) -> Self {
        let camera = Frame::from_normal(forward);
        let primary = (0..SIDE * SIDE).map(|pixel| {
            let centre = |i: u32| ((i as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0) * half_width;
            let direction = camera.to_world(Vec3::new(centre(pixel % SIDE), centre(pixel / SIDE), 1.0));
            Ray::new(eye, direction.normalize())
        });
        let mut stage =
            Self { scene, bounces: [primary.collect(), Vec::new(), Vec::new()], shadows: Default::default() };
        for bounce in 0..2 {
            let rays = stage.bounces[bounce].clone();
            for (pixel, ray) in rays.iter().enumerate() {
                let Some(hit) = stage.scene.closest(ray) else { continue };
                let point = stage.scene.point(&hit, 0.0);
                let facing = point.geometric_normal * -ray.direction.dot(point.geometric_normal).signum();
                let origin = offset_origin(point.position, point.error, facing, facing);
                stage.shadows[bounce].push(Ray { origin, direction: light - origin, t_max: 1.0, time: 0.0 });
                let u = Sampler::new(SamplerKind::Independent, bounce as u64, pixel as u64, 0).next_2d();
                let direction = Frame::from_normal(facing).to_world(warp::cosine_hemisphere(u));
                stage.bounces[bounce + 1].push(Ray::new(origin, direction));
            }
        }
        stage
    }
}

fn trace(bencher: Bencher, stage: &Stage, kind: Kind) {
    let scene = &stage.scene;
    let (rays, is_shadow) = match kind {
        Kind::Primary => (&stage.bounces[0], false),
        Kind::FirstBounce => (&stage.bounces[1], false),
        Kind::SecondBounce => (&stage.bounces[2], false),
        Kind::FirstShadow => (&stage.shadows[0], true),
        Kind::SecondShadow => (&stage.shadows[1], true),
    };
    let is_hit = |ray: &&Ray| if is_shadow { scene.occluded(ray) } else { scene.closest(ray).is_some() };
    bencher.counter(ItemsCount::new(rays.len())).bench(|| black_box(rays).iter().filter(is_hit).count());
}
