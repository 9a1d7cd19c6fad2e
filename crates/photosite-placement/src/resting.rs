//! Resting poses of an object on a plane: on a face of its convex hull, above which its centre of mass is.
//!
//! Probabilities follow Goldberg, Mirtich, Zhuang, Craig, Carlisle, Canny, "Part pose statistics: estimators and
//! experiments", IEEE Transactions on Robotics and Automation 15 (1999): an object that is turned any way round falls
//! onto the face that is below its centre of mass, and from one that does not hold it rolls over an edge onto the next.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use libm::atan2;

use crate::hull::Hull;
use crate::pose::point;

/// Distance from the plane of a face, relative to the size of the hull, within which points belong to it.
const FLATNESS: f64 = 1e-7;

/// A resting pose on a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestingPose {
    /// Rotation of the object; any rotation about the vertical may follow.
    pub rotation: DQuat,
    /// Probability for an object thrown at a random rotation, 0 to 1.
    pub probability: f64,
}

/// A face of the hull.
struct Facet {
    /// Outward unit normal.
    normal: DVec3,
    /// Distance of the face's plane from the centre of mass.
    height: f64,
    /// Fraction of all directions from the centre of mass that meet the face.
    probability: f64,
    /// Face onto which the object rolls from here; `None` where it stays.
    next: Option<usize>,
}

/// Resting poses, the most probable first.
pub(crate) fn resting_poses(hull: &Hull, centre: DVec3) -> Vec<RestingPose> {
    let mut facets = facets(hull, centre);
    // Whatever rolls gets lower.
    let mut order: Vec<usize> = (0..facets.len()).collect();
    order.sort_by(|&a, &b| facets[b].height.total_cmp(&facets[a].height).then(a.cmp(&b)));
    for (rank, &from) in order.iter().enumerate() {
        let Some(to) = facets[from].next else { continue };
        // Of equal height but for rounding: it stays where it is.
        if order[..rank].contains(&to) {
            facets[from].next = None;
            continue;
        }
        facets[to].probability += std::mem::take(&mut facets[from].probability);
    }
    let stays = |f: &&Facet| f.next.is_none();
    let mut poses: Vec<RestingPose> = facets
        .iter()
        .filter(stays)
        .map(|f| RestingPose { rotation: downwards(f.normal), probability: f.probability })
        .collect();
    poses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    poses
}

/// Rotation by the least angle that turns a direction straight down.
fn downwards(direction: DVec3) -> DQuat {
    let (cross, dot) = (direction.cross(DVec3::NEG_Y), direction.dot(DVec3::NEG_Y));
    if dot < -1.0 + 1e-12 {
        return DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0);
    }
    DQuat::from_xyzw(cross.x, cross.y, cross.z, 1.0 + dot).normalize()
}

fn facets(hull: &Hull, centre: DVec3) -> Vec<Facet> {
    let points: Vec<DVec3> = hull.points.iter().map(|p| point(*p) - centre).collect();
    let size = points.iter().map(|p| p.length()).fold(0.0, f64::max);
    let corners = |t: usize| hull.triangles[t].map(|v| points[v as usize]);
    let area_vector = |t: usize| {
        let [a, b, c] = corners(t);
        (b - a).cross(c - a)
    };
    let edges: BTreeMap<(u32, u32), usize> = (hull.triangles.iter().enumerate())
        .flat_map(|(t, &[a, b, c])| [((a, b), t), ((b, c), t), ((c, a), t)])
        .collect();
    let neighbours = |t: usize| {
        let [a, b, c] = hull.triangles[t];
        [(a, b), (b, c), (c, a)].map(|(from, to)| ((from, to), edges.get(&(to, from)).copied()))
    };
    // From the largest triangles on, each takes those around it that lie in its plane.
    let mut order: Vec<usize> = (0..hull.triangles.len()).collect();
    order.sort_by(|&a, &b| area_vector(b).length().total_cmp(&area_vector(a).length()).then(a.cmp(&b)));
    let mut facet_of = vec![usize::MAX; order.len()];
    let mut members: Vec<Vec<usize>> = Vec::new();
    let mut planes = Vec::new();
    for seed in order {
        if facet_of[seed] != usize::MAX {
            continue;
        }
        let normal = area_vector(seed).normalize_or_zero();
        let height = normal.dot(corners(seed)[0]);
        let number = members.len();
        facet_of[seed] = number;
        let mut found = vec![seed];
        let mut next = 0;
        while let Some(&t) = found.get(next) {
            next += 1;
            for other in neighbours(t).into_iter().filter_map(|(_, other)| other) {
                let is_flat = corners(other).iter().all(|p| (normal.dot(*p) - height).abs() <= FLATNESS * size);
                if facet_of[other] == usize::MAX && is_flat {
                    facet_of[other] = number;
                    found.push(other);
                }
            }
        }
        members.push(found);
        planes.push((normal, height));
    }
    let facet = |(number, (found, &(normal, height))): (usize, (&Vec<usize>, &(DVec3, f64)))| {
        // The edge beyond which the centre is the farthest, as seen from above.
        let mut farthest = (FLATNESS * size, None);
        for ((from, to), other) in found.iter().flat_map(|&t| neighbours(t)) {
            let Some(next) = other.map(|t| facet_of[t]).filter(|&f| f != number) else { continue };
            let (a, b) = (points[from as usize], points[to as usize]);
            let outwards = (b - a).cross(normal).normalize_or_zero();
            // The centre is the origin.
            let beyond = -outwards.dot(a);
            if beyond > farthest.0 {
                farthest = (beyond, Some(next));
            }
        }
        let probability = found.iter().map(|&t| solid_angle(corners(t))).sum::<f64>() / (4.0 * std::f64::consts::PI);
        Facet { normal, height, probability, next: farthest.1 }
    };
    members.iter().zip(&planes).enumerate().map(facet).collect()
}

/// The solid angle of a triangle seen from the origin (van Oosterom, Strackee 1983), above 0 where it is
/// counter-clockwise as seen from the far side.
pub(crate) fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let numerator = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * atan2(numerator, denominator)
}
