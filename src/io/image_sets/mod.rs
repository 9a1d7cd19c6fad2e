//! Image sets for [`characterisation`](crate::characterisation) on disk: a folder with a folder for each channel.
//!
//! | file | what it is |
//! |---|---|
//! | `emva1288.json` | which sets there are, and the figures that they are expected to show: [`ImageSets`] |
//! | `G/emva1288.txt` | the set of channel G for the linear camera model: a [`Descriptor`](crate::characterisation::Descriptor) |
//! | `G/images/` | its images |
//! | `G/wavelengths/0550.txt` | a set for the quantum efficiency at 550 nm |
//! | `G/temperatures/+25.txt` | a set for the dark current at 25 °C |

mod contents;
mod read;
mod write;

pub use contents::{CONTENTS, ChannelSets, ImageSets, SpectralSet, ThermalSet};
pub use read::{MeasuredSet, read_set};
pub use write::{ImageFormat, SetWriter};
