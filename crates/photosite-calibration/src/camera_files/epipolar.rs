//! Epipolar geometry: the line in one camera's image on which a point of the other camera's image must lie
//! ([OpenCv](photosite_core::references#opencv)).
//!
//! Pixels are homogeneous, x = (column, row, 1), without distortion and whole at their centres. A point that both
//! cameras see fulfils x₂ᵀ·F·x₁ = 0: it lies on the line F·x₁ of the second image, and on Fᵀ·x₂ of the first. All
//! lines of an image go through its epipole, where the other camera appears.

use glam::{DMat3, DVec3};

use super::{CalibratedCamera, StereoPair};

impl StereoPair<'_> {
    /// Essential matrix E = \[T\]ₓ·R in metres: directions in the cameras' coordinates fulfil d₂ᵀ·E·d₁ = 0.
    pub fn essential(&self) -> DMat3 {
        let (r, t) = (self.from_first.matrix3, self.from_first.translation);
        DMat3::from_cols(t.cross(r.x_axis), t.cross(r.y_axis), t.cross(r.z_axis))
    }

    /// Fundamental matrix F = K₂⁻ᵀ·E·K₁⁻¹.
    pub fn fundamental(&self) -> DMat3 {
        let [to_first, to_second] = self.cameras.map(|camera| matrix(camera).inverse());
        to_second.transpose() * self.essential() * to_first
    }

    /// Epipoles: the position in each camera's image at which the other camera appears, F·e₁ = 0 and Fᵀ·e₂ = 0.
    /// Homogeneous, with the depth in metres in the last place: e/e_z is a pixel, and one at infinity has e_z = 0.
    pub fn epipoles(&self) -> [DVec3; 2] {
        let [first, second] = self.cameras.map(matrix);
        [first * self.from_first.inverse().translation, second * self.from_first.translation]
    }

    /// Homographies H = P·R·K⁻¹ without the last column of P: from pixels without distortion to those of the rectified
    /// image.
    pub fn homographies(&self) -> [DMat3; 2] {
        let (f, c) = (self.focal_length_px, self.centre_px);
        let projection = DMat3::from_cols(DVec3::X * f, DVec3::Y * f, c.extend(1.0));
        [0, 1].map(|i| projection * self.rotations[i] * matrix(self.cameras[i]).inverse())
    }
}

/// Camera matrix K.
fn matrix(camera: &CalibratedCamera) -> DMat3 {
    DMat3::from_cols_array(&camera.matrix()).transpose()
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DQuat, DVec2};
    use rstest::rstest;

    use super::*;
    use photosite_core::projection::{Intrinsics, Projection};

    fn camera(at: DVec3, turned: DVec3) -> CalibratedCamera {
        CalibratedCamera {
            name: "camera".to_owned(),
            intrinsics: Intrinsics { fx: 500.0, fy: 505.0 + 10.0 * at.x, cx: 325.0, cy: 238.0, skew: 0.0 },
            projection: Projection::Perspective,
            resolution: [640, 480],
            to_world: DAffine3::from_rotation_translation(DQuat::from_scaled_axis(turned), at),
        }
    }

    /// Homogeneous pixel of a point of the world, in OpenCV's coordinates.
    fn pixel(camera: &CalibratedCamera, world: DVec3) -> DVec3 {
        let seen = camera.from_world().transform_point3(world);
        let pixel = camera.intrinsics.pixel(DVec2::new(seen.x / seen.z, seen.y / seen.z)) - 0.5;
        pixel.extend(1.0)
    }

    #[rstest]
    #[case::turned(DVec3::new(0.12, 0.01, -0.02), DVec3::new(0.05, -0.1, 0.03))]
    #[case::one_behind_the_other_too(DVec3::new(0.3, 0.02, -0.2), DVec3::new(0.0, 0.1, 0.0))]
    #[case::above(DVec3::new(0.01, -0.15, 0.02), DVec3::new(0.06, -0.02, 0.03))]
    fn what_both_see_lies_on_its_lines(#[case] at: DVec3, #[case] turned: DVec3) {
        let (first, second) = (camera(DVec3::ZERO, DVec3::ZERO), camera(at, turned));
        let pair = StereoPair::new(&first, &second).expect("a pair");
        let f = pair.fundamental();
        for world in [DVec3::new(0.1, 0.2, -1.0), DVec3::new(-0.4, -0.3, -2.0), DVec3::new(0.6, 0.1, -3.0)] {
            let [x1, x2] = [&first, &second].map(|camera| pixel(camera, world));
            let line = f * x1;
            // Pixels of some hundreds: 1e-13 of rounding, divided by the sine of small baselines.
            let distance = x2.dot(line) / line.truncate().length();
            assert!(distance.abs() < 1e-9, "{distance} px");
            let [y1, y2] = [0, 1].map(|i| {
                let h = pair.homographies()[i] * [x1, x2][i];
                h.truncate() / h.z
            });
            let across = if pair.is_vertical { y1.x - y2.x } else { y1.y - y2.y };
            assert!(across.abs() < 1e-9, "{across} px");
        }
        // The epipoles are where the cameras appear: by the way of points of the world.
        let [e1, e2] = pair.epipoles();
        let (eye1, eye2) = (first.to_world.translation, second.to_world.translation);
        assert!((e1 / e1.z - pixel(&first, eye2)).length() < 1e-8, "{e1}");
        assert!((e2 / e2.z - pixel(&second, eye1)).length() < 1e-8, "{e2}");
        assert!((f * e1).length() < 1e-12 && (f.transpose() * e2).length() < 1e-12);
        // Two singular values are alike, |T|, and the third is 0: the trace of EᵀE is 2|T|².
        let e = pair.essential();
        let squares = e.transpose() * e;
        let trace = squares.x_axis.x + squares.y_axis.y + squares.z_axis.z;
        assert!((trace - 2.0 * at.length_squared()).abs() < 1e-15 && e.determinant().abs() < 1e-15);
    }

    #[test]
    fn cameras_side_by_side_have_their_epipoles_at_infinity() {
        let (first, second) = (camera(DVec3::ZERO, DVec3::ZERO), camera(DVec3::new(0.1, 0.0, 0.0), DVec3::ZERO));
        let pair = StereoPair::new(&first, &second).expect("a pair");
        let [e1, e2] = pair.epipoles();
        assert_eq!((e1.y, e1.z, e2.y, e2.z), (0.0, 0.0, 0.0, 0.0));
        assert!((e1.x - 50.0).abs() < 1e-12 && (e2.x + 50.0).abs() < 1e-12, "{e1} {e2}");
    }
}
