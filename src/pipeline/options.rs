//! How the pipeline runs in memory.

use std::path::Path;

use super::monitor::{Monitor, Silent};
use super::strips::FilmMemory;

/// How a capture is rendered, besides what it says itself.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Hears of the work, and may stop it.
    pub monitor: &'a dyn Monitor,
    /// Memory for the film. The picture does not depend on it.
    pub film_memory: FilmMemory,
    /// A folder for the checkpoint of light that is traced in memory: work that is stopped goes on from there. It is
    /// gone when the work is done.
    pub checkpoint: Option<&'a Path>,
    /// Whether a coarse picture of some pixels is traced before all others, so that there is something to see at once. The
    /// picture does not depend on it. Not with a time limit.
    pub is_coarse_first: bool,
}

impl Default for Options<'_> {
    /// Silent, with 4 GiB for the film, no checkpoint, and all pixels alike.
    fn default() -> Self {
        Self { monitor: &Silent, film_memory: FilmMemory::default(), checkpoint: None, is_coarse_first: false }
    }
}
