//! Image sets for [`characterisation`](photosite_measure::characterisation) on disk: a folder with a folder for each channel.
//!
//! | file | what it is |
//! |---|---|
//! | `emva1288.json` | which sets there are, and the figures that they are expected to show: [`ImageSets`] |
//! | `G/emva1288.txt` | the set of channel G for the linear camera model: a [`Descriptor`](photosite_measure::characterisation::Descriptor) |
//! | `G/images/` | its images |
//! | `G/wavelengths/0550.txt` | a set for the quantum efficiency at 550 nm |
//! | `G/temperatures/+25.txt` | a set for the dark current at 25 °C |
//!
//! Images of any camera that a sensor is fitted to are a [`CameraSet`].

mod camera_set;
mod contents;
mod frame_folder;
mod frame_table;
mod read;
mod write;

pub use camera_set::CameraSet;
pub use contents::{CONTENTS, ChannelSets, ImageSets, SpectralSet, ThermalSet};
pub use frame_folder::FrameGain;
pub use frame_table::FRAME_TABLE;
pub use read::{MeasuredSet, read_set};
pub use write::{IMAGE_FORMATS, SetWriter};
