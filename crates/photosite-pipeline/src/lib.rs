//! The pipeline: a capture becomes light, light becomes raw images, raw images become images.
//!
//! | step | from | to | module |
//! |---|---|---|---|
//! | load | files | [`Capture`](photosite_capture::Capture) | [`capture`](photosite_capture) |
//! | prepare | capture | [`Prepared`]: scene, camera, the sensor's colours, warnings | `prepare` |
//! | trace | prepared | light with its variance | `trace` |
//! | expose | light | raw images, noise maps | `expose`; [`Light`] in memory |
//! | develop | raw image | image | [`develop`](photosite_develop) |
//! | write | all of these | a folder | [`OutputFolder`] |
//!
//! [`render`] takes all steps in memory, for one image; [`render_into`] takes them into a folder, with strips,
//! checkpoints, parts and series. [`Light::read`] begins with light that was traced before. What is heard of them goes
//! through a [`Monitor`], which may stop them. Folders see those before them alone: `camera`, `expose`, `prepare`,
//! `write`, `trace`, `render`, `light`.

#![forbid(unsafe_code)]

pub mod cache;
pub mod camera_projection;
mod developed_image;

pub use developed_image::{DevelopedFile, DevelopedImage};
mod camera;
mod device_choice;
mod expose;
mod light;
mod monitor;
mod options;
mod prepare;
mod render;
mod trace;
mod write;

pub use camera::capture_camera::{camera_of, pixels};
pub use camera::colour_checker::measure_checker;
pub use camera::focusing::{place_camera, standalone_camera, standalone_recording_camera};
pub use camera::lens_corrections::{LensSeen, Resampled, image_grid};
pub use device_choice::{BUILT_WITHOUT, DeviceChoice, DeviceFacts, devices};
pub use expose::chain::SensorSettings;
pub use expose::sensor_card::SensorCard;
pub use expose::shot::Shot;
pub use light::{ImageScale, Light, LightPlane, Shots, StoredPlanes, render};
pub use monitor::go_on;
pub use monitor::{Event, ImageOfFrame, MadeIn, Monitor, Silent};
pub use options::Options;
pub use prepare::prepared::Prepared;
pub use prepare::strips::FilmMemory;
pub use render::destination::Destination;
pub use render::render_into::{ReadyRender, Rendered, render_into};
pub use render::request::{Given, LightSource, Request};
pub use trace::parts::{FormerDevice, Parts, check_samples};
pub use trace::traced_light::TracedLight;
pub use write::checkpoint::are_in as are_checkpoints_in;
pub use write::file_names::PART;
pub use write::output_folder::OutputFolder;
pub use write::provenance::{DEVICE, add_file_of, difference, fingerprinted, keys_and_files};
