//! Dropping of objects, which fall and come to rest on the ground, on fixed objects, and on each other.

use glam::DVec3;
use photosite_core::Invalid;
use photosite_core::math::hash::hash64;
use photosite_core::math::philox::Philox;

use crate::body::{Body, distance};
use crate::engine::{self, Surroundings};
use crate::pose::{Pose, Turn, between};
use crate::request::{Method, Region, Request};
use crate::scatter::draw_resting;

/// Number of times that all is drawn anew, and that objects which fell beside are dropped again.
const ATTEMPTS: u64 = 20;
const ROUNDS: usize = 8;
/// Gap between the objects of a stack at its start, relative to their size.
const LIFT: f64 = 0.01;

/// Reason why an attempt failed.
#[derive(Clone, Copy)]
enum Failure {
    /// Number of objects that came to rest elsewhere.
    Beside(usize),
    /// Objects that did not come to rest.
    Restless,
    /// Objects that came to rest inside each other.
    Overlap,
    /// Stack that fell over.
    Fallen,
}

/// Poses of all objects, at rest.
pub(crate) fn dropped(request: &Request, bodies: &[Body], fixed: &[(Body, Pose)]) -> Result<Vec<Pose>, Invalid> {
    let surroundings = Surroundings { fixed, ground_height: request.ground_height_m, contact: request.contact };
    let mut last = Failure::Restless;
    for attempt in 0..ATTEMPTS {
        let mut random = Philox::new(hash64(request.seed, attempt), 0);
        let tried = match &request.how {
            Method::Drop { region, keep_in } => pile(&surroundings, bodies, region, keep_in.as_ref(), &mut random),
            Method::Stack { position } => stack(&surroundings, bodies, *position, &mut random),
            Method::Box { .. } | Method::Surface { .. } | Method::Rest { .. } => return Ok(Vec::new()),
        };
        match tried {
            Ok(poses) => return Ok(poses),
            Err(failure) => last = failure,
        }
    }
    Err(last.told(bodies.len()))
}

impl Failure {
    fn told(self, count: usize) -> Invalid {
        let tried = format!("in {ATTEMPTS} attempts");
        let (message, help) = match self {
            Self::Beside(beside) => (
                format!("{beside} of {count} objects fall beside what should hold them, {tried}"),
                "place fewer or smaller objects, or make what holds them larger",
            ),
            Self::Restless => {
                (format!("the objects do not come to rest, {tried}"), "write a higher friction, or place fewer objects")
            }
            Self::Overlap => (
                format!("the objects get jammed into each other, {tried}"),
                "place fewer objects, or simpler ones; let them start in a larger region",
            ),
            Self::Fallen => (
                format!("the stack of {count} objects falls over, {tried}"),
                "stack fewer objects, or flatter ones, the largest first",
            ),
        };
        Invalid::new("", message).help(help)
    }
}

/// Drops objects from a region, above each other where they would overlap.
fn pile(
    surroundings: &Surroundings<'_>,
    bodies: &[Body],
    region: &Region,
    keep_in: Option<&Region>,
    random: &mut Philox,
) -> Result<Vec<Pose>, Failure> {
    let mut poses: Vec<Pose> = Vec::new();
    for body in bodies {
        let start = start(surroundings, body, region, &bodies[..poses.len()], &poses, random);
        poses.push(start);
    }
    let mut beside = 0;
    for _ in 0..ROUNDS {
        poses = engine::fall(surroundings, bodies, &poses);
        let is_beside: Vec<bool> =
            bodies.iter().zip(&poses).map(|(body, pose)| !is_kept(surroundings, body, pose, keep_in)).collect();
        beside = is_beside.iter().filter(|beside| **beside).count();
        if beside == 0 {
            let poses = engine::settle(surroundings, bodies, &poses).ok_or(Failure::Restless)?;
            let is_kept = bodies.iter().zip(&poses).all(|(body, pose)| is_kept(surroundings, body, pose, keep_in));
            return if is_kept { checked(surroundings, bodies, poses) } else { Err(Failure::Beside(1)) };
        }
        // Those that lie well stay; the others start again above them.
        let (mut lying, mut lying_poses): (Vec<Body>, Vec<Pose>) = bodies
            .iter()
            .cloned()
            .zip(poses.iter().copied())
            .zip(&is_beside)
            .filter(|(_, b)| !**b)
            .map(|(a, _)| a)
            .unzip();
        for (i, body) in bodies.iter().enumerate().filter(|(i, _)| is_beside[*i]) {
            poses[i] = start(surroundings, body, region, &lying, &lying_poses, random);
            lying.push(body.clone());
            lying_poses.push(poses[i]);
        }
    }
    Err(Failure::Beside(beside))
}

/// Start of an object's fall: any rotation, and the lowest height in the region or above it at which the object meets
/// nothing.
fn start(
    surroundings: &Surroundings<'_>,
    body: &Body,
    region: &Region,
    others: &[Body],
    poses: &[Pose],
    random: &mut Philox,
) -> Pose {
    // As far from the sides as the region allows.
    let mut along = |axis: usize| {
        let (low, high) = (region.min[axis], region.max[axis]);
        let inset = body.radius.min((high - low) / 2.0);
        between(low + inset, high - inset, random)
    };
    let (x, z) = (along(0), along(2));
    let rotation = Turn::Any.draw(random);
    let floor = surroundings.ground_height.map_or(region.min.y, |height| height.max(region.min.y));
    let mut y = floor + 1.05 * body.radius;
    for (other, pose) in others.iter().zip(poses) {
        let centre = pose.point(other.centre);
        let reach = 1.02 * (body.radius + other.radius);
        let aside = DVec3::new(centre.x - x, 0.0, centre.z - z).length_squared();
        if aside < reach * reach {
            y = y.max(centre.y + (reach * reach - aside).sqrt());
        }
    }
    let mut pose = body.centred(rotation, DVec3::new(x, y, z));
    let least = 0.02 * body.radius;
    let is_free =
        |pose: &Pose| surroundings.fixed.iter().all(|(other, at)| distance((body, pose), (other, at), least) >= least);
    // At last above all that stands still.
    let top = surroundings.fixed.iter().map(|(other, at)| other.bounds(at).maxs.y).fold(f64::NEG_INFINITY, f64::max);
    while !is_free(&pose) && pose.point(body.centre).y < top + 2.0 * body.radius {
        pose.position.y += 0.5 * body.radius;
    }
    pose
}

/// Whether an object's centre of mass lies in the required region, if any, and not below all that could support it.
fn is_kept(surroundings: &Surroundings<'_>, body: &Body, pose: &Pose, keep_in: Option<&Region>) -> bool {
    let centre = pose.point(body.centre);
    let lowest = surroundings.fixed.iter().map(|(other, at)| other.bounds(at).mins.y);
    let bottom = lowest.chain(surroundings.ground_height).fold(f64::INFINITY, f64::min);
    centre.is_finite() && centre.y >= bottom && keep_in.is_none_or(|region| region.contains(centre))
}

/// Stacks objects one upon the other, starting from their resting poses.
fn stack(
    surroundings: &Surroundings<'_>,
    bodies: &[Body],
    position: DVec3,
    random: &mut Philox,
) -> Result<Vec<Pose>, Failure> {
    let mut height = position.y.max(surroundings.ground_height.unwrap_or(f64::NEG_INFINITY));
    let mut poses: Vec<Pose> = Vec::new();
    for body in bodies {
        let mut pose = body.centred(draw_resting(&body.shape, random), DVec3::new(position.x, height, position.z));
        pose.position.y += height + LIFT * body.radius - body.lowest(&pose);
        height = body.highest(&pose);
        poses.push(pose);
    }
    let poses = engine::fall(surroundings, bodies, &poses);
    let poses = engine::settle(surroundings, bodies, &poses).ok_or(Failure::Restless)?;
    let poses = checked(surroundings, bodies, poses)?;
    // Each one still lies on the one below it.
    let touches = |i: usize| {
        let (below, above) = ((&bodies[i], &poses[i]), (&bodies[i + 1], &poses[i + 1]));
        distance(below, above, 1e-4) < 1e-4 && above.1.point(above.0.centre).y > below.1.point(below.0.centre).y
    };
    let stands = bodies.first().is_none_or(|body| is_kept(surroundings, body, &poses[0], None));
    if stands && (1..bodies.len()).all(|i| touches(i - 1)) { Ok(poses) } else { Err(Failure::Fallen) }
}

/// Poses that pass the exact test: no object meets another by its triangles.
fn checked(surroundings: &Surroundings<'_>, bodies: &[Body], poses: Vec<Pose>) -> Result<Vec<Pose>, Failure> {
    let meets = |a: (&Body, &Pose), b: (&Body, &Pose)| distance(a, b, 1e-5) == 0.0;
    for (i, (body, pose)) in bodies.iter().zip(&poses).enumerate() {
        let is_below = surroundings.ground_height.is_some_and(|height| body.lowest(pose) < height);
        let mut earlier = bodies.iter().zip(&poses).take(i);
        let is_in_fixed = surroundings.fixed.iter().any(|(other, at)| meets((body, pose), (other, at)));
        if is_below || is_in_fixed || earlier.any(|other| meets((body, pose), other)) {
            return Err(Failure::Overlap);
        }
    }
    Ok(poses)
}
