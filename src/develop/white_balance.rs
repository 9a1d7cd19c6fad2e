//! White balance: the light of the scene becomes equal numbers in all channels.

use rayon::prelude::*;

use crate::Invalid;
use crate::raw::RawImage;

/// What counts as white.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum WhiteBalance {
    /// What the raw file says; no balance where it says nothing.
    #[default]
    AsShot,
    /// The camera's response to white.
    Neutral([f64; 3]),
}

impl WhiteBalance {
    /// The response to white, the largest component 1.
    pub(super) fn neutral(self, raw: &RawImage) -> Result<[f64; 3], Invalid> {
        let neutral = match self {
            Self::AsShot => match raw.metadata.as_shot_neutral.as_deref() {
                None => [1.0; 3],
                Some(&[r, g, b]) => [r, g, b],
                Some(other) => {
                    let message = format!("{} numbers instead of 3", other.len());
                    return Err(Invalid::new("AsShotNeutral", message));
                }
            },
            Self::Neutral(neutral) => neutral,
        };
        if neutral.iter().any(|n| !(n.is_finite() && *n > 0.0)) {
            let message = format!("{neutral:?} is no response to white");
            return Err(Invalid::new("AsShotNeutral", message).help("all three numbers must be above 0"));
        }
        let largest = neutral.into_iter().fold(0.0, f64::max);
        Ok(neutral.map(|n| n / largest))
    }
}

/// Divides the mosaic by the response to white, then clips it at 1. A saturated pixel only tells that its channel was at least so bright; the
/// factors would turn that into a colour, and blown highlights into pink. Clipped to what the most sensitive channel
/// can tell, they are white.
pub(super) fn apply(mosaic: &mut [f32], raw: &RawImage, neutral: [f64; 3]) {
    mosaic.par_chunks_mut(raw.width.max(1)).enumerate().for_each(|(y, row)| {
        let tile_width = raw.cfa.tile_size().0;
        for column in 0..tile_width {
            let factor = (1.0 / neutral[raw.cfa.channel_at(column, y)]) as f32;
            for value in row.iter_mut().skip(column).step_by(tile_width) {
                *value = (*value * factor).min(1.0);
            }
        }
    });
}
