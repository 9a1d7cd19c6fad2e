//! Files that describe a camera to other tools: its matrix, its lens and its pose. In: a [`CalibratedCamera`]. Out:
//! text; a lens that a format cannot express is an error.
//!
//! | format | lenses | coordinates of pixels | pose |
//! |---|---|---|---|
//! | OpenCV YAML | all of OpenCV's | centres at whole numbers | world → camera |
//! | ROS `camera_info` | `plumb_bob`, `rational_polynomial`, `equidistant` | centres at whole numbers | of a pair, rectification and Tx |
//! | Kalibr `camchain.yaml` | pinhole or omni with radtan, pinhole with equidistant | centres at whole numbers | from camera to camera |
//! | COLMAP `cameras.txt`, `images.txt`, `points3D.txt` | PINHOLE, OPENCV, FULL_OPENCV, OPENCV_FISHEYE | centres at halves | world → camera |
//! | EuRoC `sensor.yaml` | pinhole with radial-tangential or equidistant | centres at whole numbers | sensor → body |
//!
//! For a rig, Kalibr has the transform from each camera to the next; ROS and OpenCV have pairs, each of the rig's first
//! camera, the reference, with another one ([`StereoPair`]). A [`RectifiedView`] maps pixels between a rectified image
//! and the camera's, and a [`DisparityScale`] converts between disparity and depth.

mod colmap;
mod disparity;
mod epipolar;
mod euroc;
mod fit;
mod kalibr;
mod opencv;
mod rectification;
mod rectified_view;
mod ros;
pub(super) mod yaml;

#[cfg(test)]
mod tests;

use glam::{DAffine3, DMat3, DVec2, DVec3};

pub use colmap::{ColmapImage, ColmapPoint, colmap_cameras, colmap_images, colmap_points};
pub use disparity::DisparityScale;
pub use euroc::euroc;
pub use fit::{FittedLens, Models};
pub use kalibr::kalibr;
pub use opencv::{opencv, opencv_pair};
pub use rectification::StereoPair;
pub use rectified_view::RectifiedView;
pub use ros::{ros, ros_distortion, ros_name, ros_pair};

use photosite_core::Invalid;
use photosite_core::image_grid::ImageGrid;
use photosite_transport::optics::{BrownConrady, Camera, Intrinsics, Projection};

/// Calibrated camera: name, intrinsics, projection, size and pose, as files describe it to other tools.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibratedCamera {
    /// Name of the camera in files.
    pub name: String,
    /// Intrinsics in photosite's coordinates, where the centre of the first pixel is 0.5, 0.5.
    pub intrinsics: Intrinsics,
    /// Projection of the lens.
    pub projection: Projection,
    /// Columns and rows of the image.
    pub resolution: [u32; 2],
    /// Camera → world, with the axes of glTF (x right, y up, z backward), m.
    pub to_world: DAffine3,
}

impl CalibratedCamera {
    /// Calibration of `camera`, under a name.
    pub fn new(name: impl Into<String>, camera: &Camera) -> Self {
        Self {
            name: name.into(),
            intrinsics: camera.intrinsics(),
            projection: *camera.projection(),
            resolution: camera.resolution(),
            to_world: camera.to_world(),
        }
    }

    /// Camera with a fitted model in place of its lens.
    #[must_use]
    pub fn with_fitted(self, fitted: &FittedLens) -> Self {
        Self { intrinsics: fitted.intrinsics, projection: fitted.projection, ..self }
    }

    /// Camera as an image of these pixels shows it.
    #[must_use]
    pub fn on_grid(self, grid: &ImageGrid) -> Self {
        Self { intrinsics: grid.intrinsics(&self.intrinsics), resolution: grid.resolution, ..self }
    }

    /// Transform world → camera with the axes of OpenCV (x right, y down, z forward).
    pub fn from_world(&self) -> DAffine3 {
        opencv_pose(&self.to_world).inverse()
    }

    /// Intrinsics fx, fy, cx, cy with the centre of the first pixel at 0, 0.
    pub fn at_centres(&self) -> [f64; 4] {
        let Intrinsics { fx, fy, cx, cy, .. } = self.intrinsics;
        [fx, fy, cx - 0.5, cy - 0.5]
    }

    /// Camera matrix fx, 0, cx; 0, fy, cy; 0, 0, 1 in OpenCV's coordinates, with the skew in the first row.
    pub fn matrix(&self) -> [f64; 9] {
        let [fx, fy, cx, cy] = self.at_centres();
        [fx, self.intrinsics.skew, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
    }

    /// Refuses a skew, which most formats have no place for.
    pub(super) fn without_skew(&self, format: &str) -> Result<(), Invalid> {
        if self.intrinsics.skew == 0.0 {
            return Ok(());
        }
        let message = format!("{format} files have no skew, and that of {} is {} px", self.name, self.intrinsics.skew);
        Err(Invalid::new("lens.intrinsics.skew", message).help("make it 0, or choose another format"))
    }

    /// Error for a lens that a format has no model for.
    pub(super) fn no_model(&self, format: &str, instead: &str) -> Invalid {
        let name = self.projection.name();
        let message =
            format!("{format} files have no model for the {name} lens of {} with these coefficients", self.name);
        let help = match self.nearest_fisheye() {
            Some(nearest) => format!("{instead}; {nearest}"),
            None => instead.to_owned(),
        };
        Invalid::new("lens", message).help(help)
    }

    /// Advice that names the fisheye with coefficients which comes nearest to a classical one in this image.
    fn nearest_fisheye(&self) -> Option<String> {
        let Projection::ClassicalFisheye(law) = self.projection else { return None };
        let (k, error) = law.kannala_brandt(self.largest_angle()?)?;
        let k = k.map(|k| k.to_string()).join(", ");
        let error_px = error * self.intrinsics.fx.abs().max(self.intrinsics.fy.abs());
        Some(format!(
            "projection = \"fisheye\" with distortion = {{ model = \"kannala-brandt\", k = [{k}] }} is the same lens to \
             {error_px:.2e} px in this image"
        ))
    }

    /// Angle from the axis that the farthest corner of the image shows, or at which the lens ends before it, rad.
    fn largest_angle(&self) -> Option<f64> {
        let reach = self.projection.reach(None);
        let [width, height] = self.resolution.map(f64::from);
        let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]].map(|corner| {
            let seen = self.projection.unproject(self.intrinsics.place(DVec2::from_array(corner)), &reach);
            seen.map_or(reach.angle, |seen| seen.direction.truncate().length().atan2(seen.direction.z))
        });
        corners.into_iter().max_by(f64::total_cmp).filter(|angle| *angle > 0.0)
    }
}

/// Half a turn about x, which takes the axes of OpenCV to those of glTF and back.
pub(crate) fn half_turn() -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)))
}

/// Pose with the axes of OpenCV in place of those of glTF.
pub(super) fn opencv_pose(to_world: &DAffine3) -> DAffine3 {
    *to_world * half_turn()
}

/// Coefficients k₁ k₂ p₁ p₂ of a distortion that has no more than these.
fn four(distortion: &BrownConrady) -> Option<[f64; 4]> {
    let BrownConrady { k: [k1, k2, rest @ ..], p: [p1, p2], s } = *distortion;
    (rest == [0.0; 4] && s == [0.0; 4]).then_some([k1, k2, p1, p2])
}

/// Matrix row by row. Adding zero makes zeros of negative ones.
fn by_rows(matrix: &DMat3) -> [f64; 9] {
    matrix.transpose().to_cols_array().map(|x| x + 0.0)
}

/// Matrix of a pose, row by row.
pub(super) fn rows(pose: &DAffine3) -> [[f64; 4]; 4] {
    let m = glam::DMat4::from(*pose).transpose().to_cols_array_2d();
    // Adding zero makes zeros of negative ones.
    m.map(|row| row.map(|x| x + 0.0))
}
