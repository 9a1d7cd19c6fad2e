//! Ways of frames that may move in the time of an image.

use glam::DAffine3;

use photosite_transport::geometry::Motion;

/// Way of a frame: frame → world at all times of an image.
#[derive(Clone, Debug)]
pub(super) struct PosePath {
    /// Number of parts of equal length of its time: 0 where it stands still.
    pub(super) parts: usize,
    first: DAffine3,
    motion: Option<Motion>,
}

impl PosePath {
    /// Way through a pose, and those that follow at evenly spaced times.
    pub(super) fn new(first: DAffine3, later: impl IntoIterator<Item = DAffine3>) -> Self {
        let poses: Vec<DAffine3> = [first].into_iter().chain(later).collect();
        let moves = poses.iter().any(|pose| *pose != first);
        Self { parts: if moves { poses.len() - 1 } else { 0 }, first, motion: moves.then(|| Motion::new(&poses)) }
    }

    /// Frame → world when this part of the image's time, 0 to 1, has gone by.
    pub(super) fn at(&self, time: f64) -> DAffine3 {
        self.motion.as_ref().map_or(self.first, |motion| motion.to_world(time))
    }

    /// Frame → world on straight lines from key to key, as the vertices of emitters go.
    pub(super) fn straight_at(&self, time: f64) -> DAffine3 {
        if self.parts == 0 {
            return self.first;
        }
        let (key, part) = segment(time, self.parts);
        let [a, b] = [key, key + 1].map(|key| self.at(key as f64 / self.parts as f64));
        lerp(&a, &b, part)
    }
}

/// Index of the part that a time falls into, of `count` equal parts of the time from 0 to 1, and the fraction of the
/// part that has gone by.
pub(super) fn segment(time: f64, count: usize) -> (usize, f64) {
    let along = time * count as f64;
    let index = (along as usize).min(count - 1);
    (index, along - index as f64)
}

/// The transform by which points go straight from where one has them to where another has them.
pub(super) fn lerp(a: &DAffine3, b: &DAffine3, part: f64) -> DAffine3 {
    DAffine3 {
        matrix3: a.matrix3 * (1.0 - part) + b.matrix3 * part,
        translation: a.translation.lerp(b.translation, part),
    }
}
