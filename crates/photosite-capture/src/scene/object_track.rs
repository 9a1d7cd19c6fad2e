//! Track of an object in the time of an image.

use glam::{DAffine3, DQuat, DVec3};

use super::moments::Span;
use super::object_pose::ObjectPose;
use photosite_core::Invalid;
use photosite_transport::geometry::Trajectory;

/// Most parts that the time of an image is cut into.
const MOST_PARTS: usize = 1024;

/// Largest distance of an object from the straight line between the ends of a part, as a part of its whole way: a
/// hundredth of a pixel where it comes a hundred pixels far.
const TOLERANCE: f64 = 1e-4;

/// Largest angle that an object turns by in a part, rad. Emitters go straight from one end to the other, which takes
/// away 1 − cos(2.5°) of their size, a thousandth.
const MOST_TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Largest angle that an object turns by in a part of the shortest ones, rad. By half a turn it would not be known
/// which way it goes.
const UTMOST_TURN: f64 = std::f64::consts::FRAC_PI_4;

/// Track of an object in the time of an image.
pub(crate) struct ObjectTrack {
    start: ObjectPose,
    way: Option<(Trajectory, Span)>,
    /// Number of parts of equal length in which it goes straight, near enough: 0 where it stands still, or a power of
    /// two.
    parts: usize,
}

impl ObjectTrack {
    /// Track of an object that stands at `start` at the time 0 of the scene, in an image of that time. The key of
    /// errors is `motion`.
    pub(crate) fn new(start: ObjectPose, way: Option<(Trajectory, Span)>) -> Result<Self, Invalid> {
        let mut track = Self { start, way, parts: 0 };
        if track.way.is_none() {
            return Ok(track);
        }
        let mut parts = 1;
        while parts < MOST_PARTS && !track.is_straight(parts, MOST_TURN, TOLERANCE) {
            parts *= 2;
        }
        // What starts or stops all of a sudden is never straight, and is left a four thousandth of its way.
        if parts == MOST_PARTS && !track.is_straight(parts, UTMOST_TURN, f64::INFINITY) {
            let message = "turns more than a hundred times within the time of an image, too often to follow";
            return Err(Invalid::new("motion", message).help("let it turn more slowly, or expose for a shorter time"));
        }
        track.parts = parts;
        Ok(track)
    }

    /// Own axes → world when this part of the image's time, 0 to 1, has gone by, without the scale.
    pub(crate) fn rigid(&self, part: f64) -> DAffine3 {
        let start = self.start.rigid();
        match &self.way {
            None => start,
            Some((trajectory, span)) => trajectory.pose(&start, span.start_s + part * span.duration_s),
        }
    }

    /// Own axes → world when this part of the image's time, 0 to 1, has gone by, with the scale.
    pub(crate) fn to_world(&self, part: f64) -> DAffine3 {
        self.rigid(part) * DAffine3::from_scale(self.start.scale)
    }

    /// First place of a way, and those at the evenly spaced times that follow, at which both the object and something
    /// of its file in `parts_of_file` parts go straight.
    pub(crate) fn places(&self, parts_of_file: usize, at: impl Fn(f64) -> DAffine3) -> (DAffine3, Vec<DAffine3>) {
        let parts = self.parts.max(parts_of_file);
        (at(0.0), (1..=parts).map(|i| at(i as f64 / parts as f64)).collect())
    }

    /// Whether the object goes straight, near enough, between the evenly spaced times of `parts` parts, and turns by no
    /// more than that angle in a part.
    fn is_straight(&self, parts: usize, most_turn: f64, tolerance: f64) -> bool {
        // Not all at even parts, where a swing could be taken for rest.
        const INNER: [f64; 3] = [0.31, 0.5, 0.77];
        let pose = |part: f64| {
            let place = self.rigid(part);
            (place.translation, DQuat::from_mat3(&place.matrix3))
        };
        let keys: Vec<(DVec3, DQuat)> = (0..=parts).map(|i| pose(i as f64 / parts as f64)).collect();
        let way: f64 = keys.windows(2).map(|pair| pair[0].0.distance(pair[1].0)).sum();
        keys.windows(2).enumerate().all(|(i, pair)| {
            let [(from, first), (to, last)] = [pair[0], pair[1]];
            let inner_is_straight = |inner: f64| {
                let (place, turn) = pose((i as f64 + inner) / parts as f64);
                let rounding = f64::EPSILON * 16.0 * place.abs().max_element();
                let off = place.distance(from.lerp(to, inner));
                // Seen from both ends, as more than half a turn looks like less.
                let turned = turn.angle_between(first).max(turn.angle_between(last));
                let skewed = turn.angle_between(first.slerp(last, inner));
                off <= tolerance * way + rounding && turned <= most_turn && skewed <= (tolerance * most_turn).max(1e-7)
            };
            first.angle_between(last) <= most_turn && INNER.into_iter().all(inner_is_straight)
        })
    }
}
