//! Report of the camera: pose and intrinsics in OpenCV's conventions, motion, field of view.

use glam::{DAffine3, DMat3, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::matrix::{from_rows, rows};
use super::motion::MotionReport;
use photosite_calibration::camera_files::{FittedLens, Models};
use photosite_transport::optics::{Camera, FieldOfView, Intrinsics, LensDescription, LensKind, Projection, Recording};

/// Conversion between glTF's camera, which looks along −z with y up, and OpenCV's, along z with y down.
const FLIP: DMat3 = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));

/// Pose and intrinsics in OpenCV's conventions: x right, y down, z forward; integer coordinates at pixel centres.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct CameraReport {
    /// Columns and rows.
    pub resolution_px: [u32; 2],
    /// Camera matrix fx, 0, cx; 0, fy, cy; 0, 0, 1 row by row, with the skew in the first row. For a bare sensor, whose
    /// pixels look in no direction, fx and fy are 0.
    pub camera_matrix: [[f64; 3]; 3],
    /// Model of the lens, as `[lens]` names it; `prescription` of one that is traced, whose matrix holds near the axis
    /// alone; `none` of a bare sensor.
    pub projection: String,
    /// Distortion coefficients in OpenCV's order: k₁ k₂ p₁ p₂ k₃ (then k₄ k₅ k₆, then s₁ … s₄) of a rectilinear lens,
    /// k₁ … k₄ of a fisheye, k₁ k₂ p₁ p₂ of an omnidirectional lens.
    pub distortion: Vec<f64>,
    /// Mirror parameter of an omnidirectional lens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub xi: Option<f64>,
    /// Model of calibration tools that comes nearest to a lens that is traced. `null` of other lenses, which are a
    /// model, and where none shows all that the lens shows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fitted: Option<FittedLensReport>,
    /// Field of view of the lens.
    pub field_of_view: FieldOfViewReport,
    /// Time at which the camera has the pose stated here, s from the start of the first image: halfway between the
    /// start of its first row's exposure and the end of its last one's. Ground truth and targets refer to the middle of
    /// exposures, too. `null` where nothing moves.
    #[serde(default)]
    pub pose_time_s: Option<f64>,
    /// World → camera rotation, row by row: x_camera = R·x_world + t.
    pub rotation: [[f64; 3]; 3],
    /// Translation t of x_camera = R·x_world + t, m.
    pub translation_m: [f64; 3],
    /// Position of the centre of the lens in the world (glTF axes, metres).
    pub position_m: [f64; 3],
    /// Motion of the camera. `null` where nothing moves.
    pub motion: Option<MotionReport>,
}

/// Model fitted to a traced lens, by least squares over the image. It holds for points at one distance: the chief rays
/// of such a lens do not meet in one point.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct FittedLensReport {
    /// Camera matrix of the fitted model, in the convention of the camera's.
    pub camera_matrix: [[f64; 3]; 3],
    /// Model, as `[lens]` names it.
    pub projection: String,
    /// Distortion coefficients in OpenCV's order.
    pub distortion: Vec<f64>,
    /// Root mean square of the distances between positions by the model and those of chief rays, px.
    pub rms_px: f64,
    /// Largest of the distances between positions by the model and those of chief rays, px.
    pub largest_px: f64,
    /// Distance of the points that the model was fitted to, which is the focus distance, m. `null`: at infinity.
    pub distance_m: Option<f64>,
}

impl FittedLensReport {
    /// Report of a fitted model.
    fn new(fitted: &FittedLens) -> Self {
        let FittedLens { intrinsics, projection, rms_px, largest_px, distance_m } = *fitted;
        Self {
            camera_matrix: camera_matrix(&intrinsics),
            projection: projection.name().to_owned(),
            distortion: projection.coefficients(),
            rms_px,
            largest_px,
            distance_m: Some(distance_m).filter(|distance| distance.is_finite()),
        }
    }
}

/// Field of view: the angles at which the model of the lens is one to one, and the part of the image that sees
/// something.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct FieldOfViewReport {
    /// Angles of view from the left to the right edge and from the top to the bottom one, degrees; `null` where an edge
    /// sees nothing.
    pub across_deg: [Option<f64>; 2],
    /// Largest angle from the axis that the lens reaches.
    pub reach_deg: f64,
    /// Smallest and largest distance from the principal point at which that angle appears, px.
    pub radius_px: [f64; 2],
    /// Whether every pixel sees something.
    pub covers_sensor: bool,
}

impl FieldOfViewReport {
    /// Report of a camera's field of view.
    pub fn new(field: &FieldOfView) -> Self {
        Self {
            across_deg: field.across_rad.map(|angle| angle.map(f64::to_degrees)),
            reach_deg: field.reach_rad.to_degrees(),
            radius_px: field.radius_px,
            covers_sensor: field.blind_px.is_none(),
        }
    }
}

/// Camera matrix, row by row, with pixel centres at integers.
pub(super) fn camera_matrix(&Intrinsics { fx, fy, cx, cy, skew }: &Intrinsics) -> [[f64; 3]; 3] {
    [[fx, skew, cx - 0.5], [0.0, fy, cy - 0.5], [0.0, 0.0, 1.0]]
}

impl CameraReport {
    /// Report of a camera, which stands still or has the pose halfway through the recording.
    pub fn new(
        lens: &LensDescription,
        camera: &Camera,
        resolution_px: [u32; 2],
        recording: Option<&Recording>,
    ) -> Self {
        let DAffine3 { matrix3, translation } = camera.to_world();
        let rotation = FLIP * matrix3.transpose();
        let is_traced = lens.kind == LensKind::Prescription;
        let fitted = if is_traced { FittedLens::new(camera, Models::Rational) } else { None };
        Self {
            resolution_px,
            camera_matrix: camera_matrix(&camera.intrinsics()),
            projection: lens.projection_name().to_owned(),
            distortion: lens.projection.coefficients(),
            xi: lens.projection.xi(),
            fitted: fitted.as_ref().map(FittedLensReport::new),
            field_of_view: FieldOfViewReport::new(&camera.field_of_view()),
            pose_time_s: recording.map(Recording::middle_s),
            rotation: rows(rotation),
            translation_m: (DVec3::ZERO - rotation * translation).to_array(),
            position_m: translation.to_array(),
            motion: recording.map(MotionReport::new),
        }
    }

    /// Intrinsics with the principal point counted from the top-left corner of the image; for a traced lens those of
    /// the fitted model.
    pub fn intrinsics(&self) -> Intrinsics {
        let [[fx, skew, cx], [_, fy, cy], _] =
            self.fitted.as_ref().map_or(self.camera_matrix, |fitted| fitted.camera_matrix);
        Intrinsics { fx, fy, cx: cx + 0.5, cy: cy + 0.5, skew }
    }

    /// Projection of the lens, or of the model fitted to it; `None` where no projection has that name.
    pub fn projection(&self) -> Option<Projection> {
        match &self.fitted {
            Some(fitted) => Projection::named(&fitted.projection, &fitted.distortion, None),
            None => Projection::named(&self.projection, &self.distortion, self.xi),
        }
    }

    /// Camera → world in glTF's axes, at the time that the pose is of.
    pub fn to_world(&self) -> DAffine3 {
        let axes = from_rows(&self.rotation).transpose() * FLIP;
        DAffine3::from_mat3_translation(axes, DVec3::from_array(self.position_m))
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec2};

    use super::*;
    use photosite_transport::optics::{Focus, PixelGrid};

    /// Case: x = K·(R·X + t), OpenCV's equation of a pinhole, ends half a pixel up and left of where the camera, which
    /// counts from the image's corner, sees the point.
    #[test]
    fn what_opencv_projects_by_the_report_is_what_the_camera_sees() {
        let grid = PixelGrid { resolution: [640, 480], pitch_m: [5e-6, 6e-6] };
        let to_world = DAffine3::from_rotation_translation(
            DQuat::from_euler(glam::EulerRot::YXZ, 0.3, -0.2, 0.5),
            DVec3::new(0.4, -1.0, 2.0),
        );
        let mut lens = LensDescription::thin(0.004, 2.0, Focus::Infinity);
        let skewed = Intrinsics { fx: 700.0, fy: 650.0, cx: 300.0, cy: 250.0, skew: 1.5 };
        for intrinsics in [None, Some(skewed)] {
            lens.intrinsics = intrinsics;
            let camera = Camera::new(&lens, &grid, to_world, f64::NAN).expect("a lens");
            let report = CameraReport::new(&lens, &camera, grid.resolution, None);
            let k = from_rows(&report.camera_matrix);
            let seen = from_rows(&report.rotation);
            for point in [DVec3::new(0.0, 0.0, -2.0), DVec3::new(0.3, 0.2, -1.0), DVec3::new(-0.5, 0.1, -3.0)] {
                let in_world = to_world.transform_point3(point);
                let image = k * (seen * in_world + DVec3::from_array(report.translation_m));
                let pixel = camera.project_camera(point).expect("in front");
                let centred = DVec2::new(image.x / image.z + 0.5, image.y / image.z + 0.5);
                assert!((centred - pixel).length() < 1e-9, "{point}: {centred} {pixel}");
            }
            assert_eq!(report.intrinsics(), camera.intrinsics());
            assert!((report.to_world().inverse() * to_world).abs_diff_eq(DAffine3::IDENTITY, 1e-12));
        }
    }
}
