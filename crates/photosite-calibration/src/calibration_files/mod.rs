//! Calibrations that other tools have made of a real camera: its matrix, its lens and, where the file has one, its pose.
//! In: the text of a file. Out: the [`Calibration`]s in it, in photosite's coordinates. What photosite writes
//! ([`camera_files`](super::camera_files)) is read back with the same numbers.
//!
//! | format | models | poses |
//! |---|---|---|
//! | Kalibr `camchain.yaml` | pinhole or omni with radtan or none, pinhole with equidistant | of each camera, of the IMU |
//! | OpenCV YAML, XML, JSON (`cv::FileStorage`, or lists) | `calib3d`, `fisheye`, `omnidir` | world, views, first of a pair |
//! | ROS `camera_info` YAML | `plumb_bob`, `rational_polynomial`, `equidistant` | – |
//! | COLMAP `cameras.txt` | all with a rectilinear, equidistant or division model | of each of `images.txt` |
//! | EuRoC `sensor.yaml` | pinhole with radial-tangential or equidistant | body |
//!
//! A model that photosite cannot render exactly is refused by its name, and keys that mean something and are not used
//! are told.

mod calibration;
mod colmap;
mod euroc;
mod file;
mod kalibr;
mod models;
mod opencv;
mod ros;
mod tree;
mod xml;
mod yaml;

#[cfg(test)]
mod tests;

pub use calibration::{Calibration, StatedPose};
pub use file::{CalibrationFile, ENDINGS};
