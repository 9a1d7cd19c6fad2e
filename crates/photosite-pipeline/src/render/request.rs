//! Request of a render: what does not stand in its capture.

use std::ops::Range;
use std::path::Path;

use crate::expose::frame_series::Carried;
use crate::expose::sensor_card::SensorCard;
use crate::monitor::Monitor;
use crate::prepare::strips::FilmMemory;
use crate::trace::parts::Parts;
use crate::trace::traced_light::TracedLight;

/// Source of the light of a render.
pub enum LightSource<'a> {
    /// Light of which all samples are traced.
    Traced,
    /// Light of some samples of each pixel, which make no image yet.
    Part(Range<u32>),
    /// Light merged from parts that were traced before.
    Merged(Parts),
    /// Light that was traced before, in memory. One image is made of it.
    Given(Given<'a>),
}

/// Light that was traced before, with the frame that is made of it.
pub struct Given<'a> {
    pub(crate) light: &'a TracedLight,
    /// The number of the frame, and the state after those before it.
    pub(crate) frame: (u32, Carried),
    /// Card that exposes and develops; `None` for the processor.
    pub(crate) card: Option<&'a SensorCard>,
}

/// Request of a render into a folder: what does not stand in its capture.
pub struct Request<'a> {
    /// The file that the capture was read from.
    pub input: &'a Path,
    /// The input as reports name it: relative to their folder, or to the data set file.
    pub named: String,
    /// Source of its light.
    pub light: LightSource<'a>,
    /// Memory for its film.
    pub film_memory: FilmMemory,
    /// Monitor that hears of the render, and may stop it.
    pub monitor: &'a dyn Monitor,
    /// Whether the report says how long it took, which differs from run to run.
    pub is_timed: bool,
}

impl LightSource<'_> {
    /// Card that exposes and develops; `None` for the processor, also of light that a card traces: its images then have
    /// the bytes that `photosite expose` makes of it.
    pub(crate) fn card(&self) -> Option<&SensorCard> {
        match self {
            Self::Given(given) => given.card,
            Self::Traced | Self::Part(_) | Self::Merged(_) => None,
        }
    }

    /// The number of the first frame that is made, and the state after those before it.
    pub(crate) fn begin(&self) -> (u32, Carried) {
        match self {
            Self::Given(given) => given.frame.clone(),
            Self::Traced | Self::Part(_) | Self::Merged(_) => Default::default(),
        }
    }
}
