//! Rays of every kind that a path has, in a scene.

use std::fmt;

use glam::Vec3;
use photosite::geometry::Ray;
use photosite::math::{Frame, warp};
use photosite::sampler::{Sampler, SamplerKind};
use photosite::scene::{self, Scene};

use crate::kitchen;
use crate::scenes;

/// Rays of one kind are traced row by row of a square image, as a render does.
const SIDE: u32 = 256;

#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    Primary,
    FirstBounce,
    SecondBounce,
    /// From where primary rays hit to a point light.
    FirstShadow,
    /// From where first bounces hit to it.
    SecondShadow,
}

impl Kind {
    pub(crate) const ALL: [Self; 5] =
        [Self::Primary, Self::FirstBounce, Self::SecondBounce, Self::FirstShadow, Self::SecondShadow];

    /// Whether any hit will do.
    pub(crate) fn is_shadow(self) -> bool {
        matches!(self, Self::FirstShadow | Self::SecondShadow)
    }
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
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    bounces: [Vec<Ray>; 3],
    shadows: [Vec<Ray>; 2],
}

impl Stage {
    /// The Cornell box from the published camera.
    pub(crate) fn cornell_box() -> Self {
        let scene = scene::build(scenes::cornell_box(), &scenes::visible());
        Self::new(scene, Vec3::new(278.0, 273.0, -800.0), Vec3::Z, 0.36, Vec3::new(278.0, 548.0, 280.0))
    }

    /// A sphere of [`scenes::sphere`] from within.
    pub(crate) fn sphere_from_inside(bands: u32, sectors: u32) -> Self {
        let scene = scene::build(scenes::sphere(bands, sectors), &scenes::visible());
        Self::new(scene, Vec3::new(0.0, 0.0, 0.5), Vec3::NEG_Z, 0.6, Vec3::new(0.3, 0.5, 0.2))
    }

    /// The kitchen from its door, with its lamp.
    pub(crate) fn kitchen() -> Self {
        let scene = scene::build(kitchen::kitchen(), &scenes::visible());
        let eye = Vec3::new(3.7, 1.6, 2.7);
        Self::new(scene, eye, (Vec3::new(1.4, 1.0, 0.6) - eye).normalize(), 0.7, Vec3::new(2.0, 2.4, 1.6))
    }

    /// The camera looks from `eye` along `forward`; half of the image is `half_width` wide at distance 1.
    pub(crate) fn new(scene: Scene, eye: Vec3, forward: Vec3, half_width: f32, light: Vec3) -> Self {
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
            let mut sampler = Sampler::new(SamplerKind::Independent, bounce as u64);
            for (pixel, ray) in rays.iter().enumerate() {
                let Some(hit) = stage.scene.closest(ray) else { continue };
                let point = stage.scene.point(&hit, 0.0);
                let facing = point.geometric_normal * -ray.direction.dot(point.geometric_normal).signum();
                let leaving = point.spawn_ray(facing);
                let direction = light - leaving.origin;
                stage.shadows[bounce].push(Ray { direction, t_max: 1.0, ..leaving });
                sampler.start(pixel as u64, 0);
                let direction = Frame::from_normal(facing).to_world(warp::cosine_hemisphere(sampler.next_2d()).into());
                stage.bounces[bounce + 1].push(Ray { direction, ..leaving });
            }
        }
        stage
    }

    /// All rays of a kind.
    pub(crate) fn rays(&self, kind: Kind) -> &[Ray] {
        match kind {
            Kind::Primary => &self.bounces[0],
            Kind::FirstBounce => &self.bounces[1],
            Kind::SecondBounce => &self.bounces[2],
            Kind::FirstShadow => &self.shadows[0],
            Kind::SecondShadow => &self.shadows[1],
        }
    }

    /// Traces all rays of a kind, as many together as a render does, and counts those that hit something.
    pub(crate) fn trace(&self, kind: Kind) -> usize {
        const TOGETHER: usize = 256;
        let (mut hits, mut occluded) = (Vec::new(), Vec::new());
        let hit_something = |rays: &[Ray]| {
            if kind.is_shadow() {
                self.scene.occluded_each(rays, &mut occluded);
                occluded.iter().filter(|&&is_occluded| is_occluded).count()
            } else {
                self.scene.closest_each(rays, &mut hits);
                hits.iter().flatten().count()
            }
        };
        self.rays(kind).chunks(TOGETHER).map(hit_something).sum()
    }

    /// The same, one ray after the other.
    pub(crate) fn trace_one_by_one(&self, kind: Kind) -> usize {
        let scene = &self.scene;
        let rays = self.rays(kind).iter();
        if kind.is_shadow() {
            rays.filter(|ray| scene.occluded(ray)).count()
        } else {
            rays.filter(|ray| scene.closest(ray).is_some()).count()
        }
    }
}
