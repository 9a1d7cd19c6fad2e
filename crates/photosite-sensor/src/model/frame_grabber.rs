//! `[frame_grabber]`: what samples the analogue image, as a sensor file states it, and checked.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::cells::CellLayout;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

use photosite_raw::Cfa;

use super::checks::MAX_RESOLUTION;
use super::shutter::Shutter;

/// Frame grabber: samples the analogue image of a sensor and hands it to the converter; its columns and rows need not
/// be those of the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct FrameGrabberDescription {
    /// Columns and rows of the raw image, which shows what the sensor's resolution_px do. Covered pixels do not reach
    /// it.
    #[schemars(transform = within(1.0..=65_535.0))]
    pub size_px: [u32; 2],
    /// Interpolation of the signal between pixels. Left out: "linear".
    #[serde(default)]
    pub interpolation: SignalInterpolation,
}

/// Interpolation of the signal between pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum SignalInterpolation {
    /// Sample and hold: the value of the pixel whose time it is.
    Nearest,
    /// Linear interpolation between neighbouring pixels.
    #[default]
    Linear,
}

/// Frame grabber, which samples the analogue image: N samples of n pixels of a row, at the places
///
/// x_i = (i + ½)·n/N,  s = N/n
///
/// in pixels from the edge of the image, and so for rows. A lens of the focal length f_x pixels has s·f_x samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameGrabber {
    /// Columns and rows of samples.
    pub size: [usize; 2],
    /// Interpolation of the signal between pixels.
    pub interpolation: SignalInterpolation,
}

impl FrameGrabber {
    /// Keys of errors are those of the sensor file.
    pub(super) fn new(
        d: &FrameGrabberDescription,
        cfa: &Cfa,
        cells: &CellLayout,
        shutter: &Shutter,
    ) -> Result<Self, Invalid> {
        if let Some(side) = d.size_px.iter().find(|side| !(1..=MAX_RESOLUTION).contains(*side)) {
            let message = format!("must lie between 1 and {MAX_RESOLUTION}, got {side}");
            return Err(Invalid::new("frame_grabber.size_px", message).help("for example size_px = [768, 576]"));
        }
        let clashes = [
            (cfa.is_mosaic(), "a mosaic of filters, whose colours it would mix"),
            (cells.is_staggered(), "hexagonal cells, whose rows do not form columns"),
            (shutter.scans(), "a scanning sensor, whose image has as many lines as it is told"),
        ];
        match clashes.iter().find(|(is_there, _)| *is_there) {
            Some((_, clash)) => {
                Err(Invalid::new("frame_grabber", format!("cannot be combined with {clash}")).help("keep one of them"))
            }
            None => Ok(Self { size: d.size_px.map(|n| n as usize), interpolation: d.interpolation }),
        }
    }
}
