//! Stereo rectification: two cameras of a rig are turned virtually until they look the same way across the line between
//! them, so that a point appears in the same row of both images (in the same column, where they stand one above the
//! other). The method is Bouguet's, as in `cv2.stereoRectify` with `CALIB_ZERO_DISPARITY` and alpha = −1
//! ([OpenCv](photosite_core::references#opencv)).
//!
//! Coordinates are OpenCV's: x right, y down, z forward, whole numbers at the centres of pixels, metres.

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};

use super::CalibratedCamera;
use photosite_core::Invalid;

/// Stereo pair: two cameras and their rectification.
#[derive(Clone, Debug, PartialEq)]
pub struct StereoPair<'a> {
    /// Cameras: the reference and the other one.
    pub cameras: [&'a CalibratedCamera; 2],
    /// Transform from the coordinates of the reference to those of the other camera: R and T of `cv2.stereoCalibrate`.
    pub from_first: DAffine3,
    /// Rotations R₁ and R₂, from each camera's coordinates to its rectified ones.
    pub rotations: [DMat3; 2],
    /// Focal length f and principal point c of both rectified images, c with the centre of the first pixel at 0, 0.
    pub focal_length_px: f64,
    /// Principal point c of both rectified images, px, with the centre of the first pixel at 0, 0.
    pub centre_px: DVec2,
    /// Translation from the first to the second camera in rectified coordinates, m: but for rounding along one axis
    /// alone.
    baseline_m: DVec3,
    /// Whether the cameras stand one above the other.
    pub is_vertical: bool,
}

impl<'a> StereoPair<'a> {
    /// Rectifies two cameras. Both turn by half of the rotation between them, and then together until their line is
    /// that of the rows, or that of the columns if that is nearer. f is the mean of the focal lengths across the line.
    /// c is the mean over both cameras of the principal points that bring the mean of the corners, without distortion,
    /// to the centre of the image; for a fisheye, whose corners a plane need not have, the middle of the sensor takes
    /// their place.
    pub fn new(first: &'a CalibratedCamera, second: &'a CalibratedCamera) -> Result<Self, Invalid> {
        let cameras = [first, second];
        let from_first = second.from_world() * first.from_world().inverse();
        let refused = |why: &str| {
            let message = format!("{} and {} cannot be rectified: {why}", first.name, second.name);
            Invalid::new("cameras", message).help("place them side by side, looking at the same things")
        };
        let turn = DQuat::from_mat3(&from_first.matrix3).normalize();
        let turn = if turn.w < 0.0 { -turn } else { turn };
        let half = DQuat::from_scaled_axis(turn.to_scaled_axis() * -0.5);
        let between = half * from_first.translation;
        let is_vertical = between.x.abs() <= between.y.abs();
        let along = if is_vertical { between.y } else { between.x };
        if along == 0.0 {
            return Err(refused("they are at the same place, or one behind the other"));
        }
        let wanted = if is_vertical { DVec3::Y } else { DVec3::X } * along.signum();
        let axis = between.normalize().cross(wanted);
        let align = match axis.length() {
            0.0 => DQuat::IDENTITY,
            sin => DQuat::from_axis_angle(axis / sin, sin.atan2(between.normalize().dot(wanted))),
        };
        let rotations = [align * half.inverse(), align * half].map(DMat3::from_quat);
        let across = |camera: &CalibratedCamera| {
            let f = if is_vertical { camera.intrinsics.fx } else { camera.intrinsics.fy };
            f * camera.projection.magnification()
        };
        let focal_length_px = 0.5 * (across(first) + across(second));
        let mut centre_px = DVec2::ZERO;
        for (camera, rotation) in cameras.into_iter().zip(rotations) {
            let shown = mean_direction(camera, rotation).ok_or_else(|| refused("they look in different directions"))?;
            let middle = DVec2::from_array(camera.resolution.map(|n| (f64::from(n) - 1.0) / 2.0));
            centre_px += 0.5 * (middle - focal_length_px * shown);
        }
        let baseline_m = rotations[1] * from_first.translation;
        Ok(Self { cameras, from_first, rotations, focal_length_px, centre_px, baseline_m, is_vertical })
    }

    /// Projection matrices P₁ and P₂ row by row: f, 0, c_x, T_x; 0, f, c_y, T_y; 0, 0, 1, 0. The last column of P₂ is
    /// the translation times f, so that T_x = −f·b where the second camera is b to the right of the first.
    pub fn projections(&self) -> [[f64; 12]; 2] {
        let (f, c) = (self.focal_length_px, self.centre_px);
        let [x, y] = self.offset();
        let matrix = |x: f64, y: f64| [f, 0.0, c.x, x, 0.0, f, c.y, y, 0.0, 0.0, 1.0, 0.0];
        [matrix(0.0, 0.0), matrix(x, y)]
    }

    /// Matrix Q row by row: from column, row and disparity to the point in the rectified coordinates of the first
    /// camera.
    pub fn disparity_to_depth(&self) -> [f64; 16] {
        let (f, c, b) = (self.focal_length_px, self.centre_px, self.baseline_m());
        [[1.0, 0.0, 0.0, -c.x], [0.0, 1.0, 0.0, -c.y], [0.0, 0.0, 0.0, f], [0.0, 0.0, 1.0 / b, 0.0]]
            .as_flattened()
            .try_into()
            .unwrap_or([0.0; 16])
    }

    /// Baseline b in d = f·b/Z, m: distance of the second camera to the right of the first, or below it, in rectified
    /// coordinates. d is the position in the first image less that in the second.
    pub fn baseline_m(&self) -> f64 {
        -if self.is_vertical { self.baseline_m.y } else { self.baseline_m.x }
    }

    /// Last column of P₂, px·m.
    fn offset(&self) -> [f64; 2] {
        let f = self.focal_length_px;
        if self.is_vertical { [0.0, f * self.baseline_m.y] } else { [f * self.baseline_m.x, 0.0] }
    }
}

/// Mean position of the corners of an image, or of the middle of that of a fisheye, on the plane z = 1 of a camera that
/// is turned.
fn mean_direction(camera: &CalibratedCamera, rotation: DMat3) -> Option<DVec2> {
    let reach = camera.projection.reach(None);
    let last = DVec2::from_array(camera.resolution.map(|n| f64::from(n) - 1.0));
    let parts: &[DVec2] =
        if camera.projection.is_flat() { &[DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE] } else { &[DVec2::splat(0.5)] };
    let on_plane = |part: &DVec2| {
        // Positions count from the corner of the first pixel, whole numbers from its centre.
        let place = camera.intrinsics.place(*part * last + 0.5);
        let seen = camera.projection.unproject(place, &reach)?;
        let turned = rotation * seen.direction;
        (turned.z > 0.0).then(|| turned.truncate() / turned.z)
    };
    let shown: Vec<DVec2> = parts.iter().map(on_plane).collect::<Option<_>>()?;
    Some(shown.iter().sum::<DVec2>() / shown.len() as f64)
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::*;
    use photosite_core::projection::{BrownConrady, Intrinsics, Projection};

    fn camera(projection: Projection, at: DVec3, turned: DVec3) -> CalibratedCamera {
        CalibratedCamera {
            name: "camera".to_owned(),
            intrinsics: Intrinsics { fx: 500.0 + 100.0 * at.x, fy: 505.0, cx: 325.0, cy: 238.0, skew: 0.0 },
            projection,
            resolution: [640, 480],
            to_world: DAffine3::from_rotation_translation(DQuat::from_scaled_axis(turned), at),
        }
    }

    fn barrel() -> Projection {
        Projection::BrownConrady(BrownConrady {
            k: [-0.1, 0.02, 0.01, 0.0, 0.0, 0.0],
            p: [1e-3, -2e-3],
            ..BrownConrady::default()
        })
    }

    /// Case: a point of the world lies in one row (column) of both rectified images, at positions f·b/Z apart.
    #[rstest]
    #[case::side_by_side(DVec3::new(0.12, 0.0, 0.0), DVec3::ZERO, false)]
    #[case::turned(DVec3::new(0.12, 0.01, -0.02), DVec3::new(0.05, -0.1, 0.03), false)]
    #[case::right_first(DVec3::new(-0.2, 0.02, 0.01), DVec3::new(-0.02, 0.08, 0.1), false)]
    #[case::above(DVec3::new(0.01, -0.15, 0.02), DVec3::new(0.06, -0.02, 0.03), true)]
    fn points_lie_on_one_line_at_their_disparity(
        #[case] at: DVec3,
        #[case] turned: DVec3,
        #[case] is_vertical: bool,
        #[values(barrel(), Projection::KannalaBrandt { k: [0.02, -0.01, 0.0, 0.0] })] projection: Projection,
    ) {
        let first = camera(projection, DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.1, 0.2, 0.0));
        let second = CalibratedCamera {
            to_world: first.to_world * camera(projection, at, turned).to_world,
            ..camera(projection, at, turned)
        };
        let pair = StereoPair::new(&first, &second).expect("a pair");
        let projections = pair.projections();
        let offset = pair.offset();
        assert_eq!(offset[usize::from(!is_vertical)], 0.0);
        for point in [DVec3::new(0.1, 0.2, -1.0), DVec3::new(-0.4, -0.3, -2.0), DVec3::new(0.6, 0.1, -3.0)] {
            let world = first.to_world.transform_point3(point);
            let rectified = |i: usize| pair.rotations[i] * pair.cameras[i].from_world().transform_point3(world);
            let seen: [DVec2; 2] = std::array::from_fn(|i| {
                // The last column counts for points of the first camera's coordinates alone.
                let [f, _, cx, ..] = projections[i];
                let p = rectified(i);
                DVec2::new(f * p.x / p.z + cx, f * p.y / p.z + projections[i][6])
            });
            let apart = seen[1] - seen[0];
            let depth = rectified(0).z;
            let wanted = DVec2::from_array(offset) / depth;
            // Pixels of some hundreds: 1e-10 of rounding.
            assert!((apart - wanted).length() < 1e-9, "{apart} {wanted}");
            let q = pair.disparity_to_depth();
            let disparity = if is_vertical { -apart.y } else { -apart.x };
            let w = q[14] * disparity;
            assert!((q[11] / w - depth).abs() < 1e-9 * depth, "{} {depth}", q[11] / w);
        }
        // The length of the baseline stays.
        let along = offset[usize::from(is_vertical)].abs() / projections[1][0];
        assert!((along - at.length()).abs() < 1e-12, "{along}");
    }

    #[test]
    fn a_rig_that_is_rectified_stays_as_it_is() {
        let first = camera(Projection::Perspective, DVec3::ZERO, DVec3::ZERO);
        let second =
            CalibratedCamera { to_world: DAffine3::from_translation(DVec3::new(0.3, 0.0, 0.0)), ..first.clone() };
        let pair = StereoPair::new(&first, &second).expect("a pair");
        assert!(pair.rotations.iter().all(|r| r.abs_diff_eq(DMat3::IDENTITY, 1e-15)));
        let [p1, p2] = pair.projections();
        // f = fy; c keeps the middle of the image, (319.5, 239.5), where the corners' mean has been: with square
        // pixels that would be the principal point itself.
        let scale = 505.0 / 500.0;
        let expected = [319.5 - (319.5 - 324.5) * scale, 237.5];
        assert!((p1[2] - expected[0]).abs() < 1e-9 && (p1[6] - expected[1]).abs() < 1e-9, "{p1:?}");
        assert!((p2[3] + 505.0 * 0.3).abs() < 1e-9 && p1[3] == 0.0, "{p2:?}");
    }

    #[test]
    fn cameras_that_cannot_be_rectified_are_refused() {
        let first = camera(Projection::Perspective, DVec3::ZERO, DVec3::ZERO);
        for (at, turned) in [
            (DVec3::ZERO, DVec3::ZERO),
            (DVec3::new(0.0, 0.0, 0.3), DVec3::ZERO),
            (DVec3::new(0.1, 0.0, 0.0), DVec3::new(0.0, 3.0, 0.0)),
        ] {
            let second = camera(Projection::Perspective, at, turned);
            let error = StereoPair::new(&first, &second).expect_err("no pair");
            assert!(error.message.contains("cannot be rectified"), "{error:?}");
        }
    }
}
