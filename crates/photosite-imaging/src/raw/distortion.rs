//! What is known of the lens's distortion, which a developer can correct.

use super::{LensModel, Warp};
use serde::{Deserialize, Serialize};

/// Where the lens has put what one without distortion would show.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Distortion {
    /// By the model of the lens: exact.
    Lens(LensModel),
    /// As DNG's opcodes say it, in the files of other programs.
    Warp(Warp),
}
