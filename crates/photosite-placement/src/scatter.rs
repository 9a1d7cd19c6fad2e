//! Scattering of objects one after the other at random places, drawn again where they would meet something.

use glam::{DQuat, DVec3};
use photosite_core::Invalid;
use photosite_core::math::hash::hash64;
use photosite_core::math::philox::Philox;
use rand::RngExt;

use crate::body::{Body, distance};
use crate::pose::{Pose, Turn, between};
use crate::request::{Method, Region, Request, Support};
use crate::shape::Shape;
use crate::surface::{Surface, TOUCH_M};

/// Number of draws of a place for one object, and of new starts with all objects.
const TRIES: usize = 500;
const STARTS: u64 = 10;
/// Smallest distance of objects from each other, m.
const APART_M: f64 = 1e-7;

/// Domain of the places of objects.
enum PoseDomain<'a> {
    Box(Region, Turn),
    Surface(Surface<'a>, Turn),
    RestOnGround(Region, f64),
    RestOnSurface(Surface<'a>),
}

/// Poses of all objects, none of which meets another.
pub(crate) fn scatter(request: &Request, bodies: &[Body], fixed: &[(Body, Pose)]) -> Result<Vec<Pose>, Invalid> {
    let surface = |on: usize| {
        let (body, pose) = &fixed[on];
        Surface::new(body, pose)
            .ok_or_else(|| Invalid::new("surface", "has no faces that look up").help("turn it, or name another object"))
    };
    // What is stood on is touched.
    let (place, support) = match &request.how {
        Method::Box { region, turn } => (PoseDomain::Box(*region, *turn), None),
        Method::Surface { on, turn } => (PoseDomain::Surface(surface(*on)?, *turn), Some(*on)),
        Method::Rest { on: Support::Fixed(on) } => (PoseDomain::RestOnSurface(surface(*on)?), Some(*on)),
        Method::Rest { on: Support::Ground(region) } => {
            (PoseDomain::RestOnGround(*region, request.ground_height_m.unwrap_or_default()), None)
        }
        Method::Drop { .. } | Method::Stack { .. } => return Ok(Vec::new()),
    };
    let others: Vec<&(Body, Pose)> =
        fixed.iter().enumerate().filter(|(i, _)| Some(*i) != support).map(|(_, other)| other).collect();
    // Large ones find room first.
    let mut order: Vec<usize> = (0..bodies.len()).collect();
    order.sort_by(|&a, &b| bodies[b].radius.total_cmp(&bodies[a].radius).then(a.cmp(&b)));
    let mut most = 0;
    for start in 0..STARTS {
        let mut random = Philox::new(hash64(request.seed, start), 0);
        let mut poses: Vec<Option<Pose>> = vec![None; bodies.len()];
        for (placed, &i) in order.iter().enumerate() {
            let body = &bodies[i];
            let is_free = |pose: &Pose| {
                let above = request.ground_height_m.is_none_or(|height| body.lowest(pose) >= height);
                let least = request.min_distance_m.max(APART_M);
                let clear = |other: &Body, at: &Pose| distance((body, pose), (other, at), least) >= least;
                // A floor in the plane of the ground is stood on, too.
                let is_floor = |other: &Body, at: &Pose| {
                    request.ground_height_m.is_some_and(|height| other.highest(at) <= height)
                        && distance((body, pose), (other, at), APART_M) >= APART_M
                };
                let earlier = poses.iter().zip(bodies).filter_map(|(pose, other)| Some((other, pose.as_ref()?)));
                above
                    && others.iter().all(|(other, at)| clear(other, at) || is_floor(other, at))
                    && earlier.into_iter().all(|(o, at)| clear(o, at))
            };
            let found = (0..TRIES).find_map(|_| place.draw(body, &mut random).filter(is_free));
            most = most.max(placed);
            let Some(pose) = found else { break };
            poses[i] = Some(pose);
            most = most.max(placed + 1);
        }
        let all: Option<Vec<Pose>> = poses.into_iter().collect();
        if let Some(all) = all {
            return Ok(all);
        }
    }
    let message = format!(
        "{most} of {} objects find room: the others meet something at each of {TRIES} places, in {STARTS} starts",
        bodies.len()
    );
    Err(Invalid::new("", message).help("place fewer or smaller objects, in a larger region, or nearer to each other"))
}

impl PoseDomain<'_> {
    /// Draws a pose, whether there is room or not; `None` where there can be none.
    fn draw(&self, body: &Body, random: &mut Philox) -> Option<Pose> {
        match self {
            Self::Box(region, turn) => {
                let centre = draw_in(region, random);
                Some(body.centred(turn.draw(random), centre))
            }
            Self::Surface(surface, turn) => {
                let (at, rotation) = (surface.draw(random), turn.draw(random));
                surface.lowered(body, rotation, at)
            }
            Self::RestOnGround(region, height) => {
                let centre = draw_in(region, random);
                let mut pose = body.centred(draw_resting(&body.shape, random), centre);
                pose.position.y += height + TOUCH_M - body.lowest(&pose);
                Some(pose)
            }
            Self::RestOnSurface(surface) => {
                let (at, rotation) = (surface.draw(random), draw_resting(&body.shape, random));
                surface.lowered(body, rotation, at).filter(|pose| surface.carries(body, pose))
            }
        }
    }
}

fn draw_in(region: &Region, random: &mut Philox) -> DVec3 {
    let (low, high) = (region.min, region.max);
    DVec3::from_array([0, 1, 2].map(|axis| between(low[axis], high[axis], random)))
}

/// Rotation of a resting pose, drawn by its probability, and turned about the vertical.
pub(crate) fn draw_resting(shape: &Shape, random: &mut Philox) -> DQuat {
    let poses = shape.resting_poses();
    let mut at = random.random::<f64>() * poses.iter().map(|pose| pose.probability).sum::<f64>();
    let chosen = poses.iter().find(|pose| {
        at -= pose.probability;
        at < 0.0
    });
    let rotation = chosen.or(poses.first()).map_or(DQuat::IDENTITY, |pose| pose.rotation);
    (Turn::Vertical.draw(random) * rotation).normalize()
}
