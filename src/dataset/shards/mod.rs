//! A data set in files that training programs read in one go, written while it grows.
//!
//! Each file, a *shard*, holds the pictures of a fixed range of frames, so that whoever finds them all there can write
//! it: the workers that make the data set, as soon as one of them has finished the last picture of a range, or
//! `photosite layout` at any time. How many frames a shard has is decided once, and recorded in `layout.json` of its
//! folder. A shard has the same bytes whoever writes it.
//!
//! | format | file | of a picture |
//! |---|---|---|
//! | [WebDataset](photosite_core::references#webdataset) | `shard-000000.tar` | members `CAMERA-000000.png`, `.raw.npy`, `.depth.npy` …, `.json` |
//! | Parquet of Hugging Face `datasets` | `part-000000.parquet` | a row, with pictures as PNG |
//! | MCAP of ROS 2 | `part-000000.mcap` | messages `CameraInfo`, `Image`, `CompressedImage`, `TFMessage` |
//!
//! A shard that would be larger than its limit goes on in `shard-000000_01.tar` and so on, which have their names before
//! the first one gets its own.

mod cdr;
mod container;
mod growing;
mod mcap_file;
mod parquet_file;
mod raw_png;
mod ros_messages;
mod sample;
mod settings;
mod tar_file;
mod wids;

pub use growing::{Progress, Shards};
pub use settings::{ShardFormat, ShardSize};
