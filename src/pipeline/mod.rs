//! The pipeline: a capture becomes light, light becomes raw images, raw images become pictures.
//!
//! | step | from | to | module |
//! |---|---|---|---|
//! | load | files | [`Capture`](crate::Capture) | [`capture`](crate::capture) |
//! | prepare | capture | [`Prepared`]: scene, camera, the sensor's colours, warnings | `prepare` |
//! | trace | prepared | light with its variance | `trace` |
//! | expose | light | raw images, noise maps | `chain`, `results` |
//! | develop | raw image | picture | [`develop`](crate::develop) |
//! | write | all of these | a folder | [`OutputFolder`] |
//!
//! [`render`](crate::render) takes all steps in memory, for one picture; [`render_into`] takes them into a folder, with
//! strips, checkpoints, parts and series. [`StoredRender`] begins with light that was traced before. What is heard of
//! them goes through a [`Monitor`], which may stop them.

mod autofocus;
mod camera;
mod carried;
mod chain;
mod checkpoint;
mod colour_checker;
mod completed_rows;
mod earlier;
mod exposed_render;
mod file_names;
mod focusing;
mod ideal;
mod lens_corrections;
mod light;
mod monitor;
mod needs;
mod options;
mod output_folder;
mod parts;
mod picture_report;
mod prepare;
mod provenance;
mod reexpose;
mod render;
mod request;
mod responses;
mod results;
mod same_light;
mod series;
mod shot;
mod stored;
mod stored_light;
mod strips;
mod throttle;
mod trace;
mod truth_views;

pub use camera::{camera_of, pixels};
pub use carried::Carried;
pub(crate) use checkpoint::are_in as are_checkpoints_in;
pub use colour_checker::measure_checker;
pub use earlier::Place;
pub use exposed_render::ExposedRender;
pub use file_names::PART;
pub use focusing::{place_camera, standalone_camera, standalone_recording_camera};
pub use lens_corrections::{LensSeen, Resampled, image_grid};
pub use light::Light;
pub(crate) use monitor::go_on;
pub use monitor::{Event, MadeIn, Monitor, PictureOfFrame, Silent};
pub use options::Options;
pub use output_folder::OutputFolder;
pub use parts::{Parts, check_samples};
pub use prepare::Prepared;
pub(crate) use provenance::{add_file_of, difference, fingerprinted, keys_and_files};
pub use reexpose::StoredRender;
pub use render::{ReadyRender, Rendered, render_into};
pub use request::{LightSource, Request};
pub use shot::{Shot, render};
pub use stored::PictureScale;
pub use strips::FilmMemory;
