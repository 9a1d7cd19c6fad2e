//! Progress of a render, reported while it runs.

use std::ops::ControlFlow;
use std::time::Duration;

use super::pilot::Pilot;
use crate::film::Film;

/// Step of a render, reported while it runs.
pub enum Step<'a> {
    /// Samples of this pass are done for some pixels. Called from any thread, some times a second.
    Band {
        /// Camera paths of those pixels.
        paths: u64,
    },
    /// Coarse image, of every [`COARSE_STEP`](super::COARSE_STEP)th pixel in every such row.
    Coarse {
        /// Film of the coarse image alone.
        film: &'a Film,
    },
    /// A pass is over, or was broken off.
    Pass {
        /// The film so far.
        film: &'a Film,
        /// The pilot, of a render that has one.
        pilot: Option<&'a Pilot>,
        /// Time since the start.
        elapsed: Duration,
        /// Camera paths of the whole render, once they are known.
        planned_paths: Option<u64>,
    },
}

/// Listener to the steps of a render; its answer ends the render or lets it go on. A pass that is broken off leaves
/// some pixels with fewer samples than others, and the next render goes on from there.
pub type Listener<'a> = dyn Fn(Step<'_>) -> ControlFlow<()> + Sync + 'a;
