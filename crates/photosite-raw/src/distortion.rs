//! Distortion of the lens as far as it is known, so that a developer can correct it.

use super::{LensModel, Warp};
use serde::{Deserialize, Serialize};

/// Distortion: the map from an image without distortion to that of the lens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Distortion {
    /// Model of the lens: exact.
    Lens(LensModel),
    /// Polynomial of a DNG opcode, in the files of other programs.
    Warp(Warp),
}
