//! Options of the pipeline in memory.

use std::path::Path;

use super::monitor::{Monitor, Silent};
use super::prepare::strips::FilmMemory;

/// Options of a render beside its capture.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Monitor that hears of the work, and may stop it.
    pub monitor: &'a dyn Monitor,
    /// Memory for the film. The image does not depend on it.
    pub film_memory: FilmMemory,
    /// A folder for the checkpoint of light that is traced in memory: work that is stopped goes on from there. It is
    /// gone when the work is done.
    pub checkpoint: Option<&'a Path>,
    /// Whether a coarse image of some pixels is traced before all others, so that there is something to see at once.
    /// The image does not depend on it. It cannot be combined with a time limit.
    pub is_coarse_first: bool,
}

impl Default for Options<'_> {
    /// Options of a silent render, with 4 GiB for the film, no checkpoint, and all pixels alike.
    fn default() -> Self {
        Self { monitor: &Silent, film_memory: FilmMemory::default(), checkpoint: None, is_coarse_first: false }
    }
}
