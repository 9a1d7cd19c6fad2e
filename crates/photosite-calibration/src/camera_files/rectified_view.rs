//! Rectified image of one camera of a pair: the mapping of its pixels to those of the camera, as by
//! `cv2.initUndistortRectifyMap`, and the inverse.
//!
//! Positions are continuous, counted from the corner of the first pixel.

use glam::{DMat3, DVec2, DVec3};

use super::{CalibratedCamera, StereoPair, opencv_pose};
use photosite_core::projection::{Intrinsics, Projection, Reach};

/// Rectified image of one camera.
#[derive(Clone, Copy, Debug)]
pub struct RectifiedView<'a> {
    camera: &'a CalibratedCamera,
    /// Rotation from the camera's coordinates to the rectified ones.
    rotation: DMat3,
    /// Intrinsics of the rectified image.
    intrinsics: Intrinsics,
    resolution: [u32; 2],
    reach: Reach,
}

impl<'a> StereoPair<'a> {
    /// Columns and rows of both rectified images: those of the first camera.
    pub fn resolution(&self) -> [u32; 2] {
        self.cameras[0].resolution
    }

    /// Views of both cameras.
    pub fn views(&self) -> [RectifiedView<'a>; 2] {
        let (f, c) = (self.focal_length_px, self.centre_px + 0.5);
        [0, 1].map(|i| RectifiedView {
            camera: self.cameras[i],
            rotation: self.rotations[i],
            intrinsics: Intrinsics { fx: f, fy: f, cx: c.x, cy: c.y, skew: 0.0 },
            resolution: self.resolution(),
            reach: self.cameras[i].projection.reach(None),
        })
    }

    /// Direction, in rectified coordinates, within the epipolar plane of a row (a column for cameras one above the
    /// other), at an angle from −π/2 to π/2; 0 is across the baseline.
    pub fn in_epipolar_plane(&self, line: f64, angle: f64) -> DVec3 {
        let (sin, cos) = angle.sin_cos();
        let c = self.centre_px + 0.5;
        let slope = (line - if self.is_vertical { c.x } else { c.y }) / self.focal_length_px;
        let across = cos / slope.hypot(1.0);
        if self.is_vertical { DVec3::new(slope * across, sin, across) } else { DVec3::new(sin, slope * across, across) }
    }
}

impl RectifiedView<'_> {
    /// Direction that a position of the rectified image looks at, in the camera's coordinates; its component along the
    /// rectified axis is 1.
    pub fn direction(&self, position: DVec2) -> DVec3 {
        self.rotation.transpose() * self.intrinsics.place(position).extend(1.0)
    }

    /// Position in the camera's image of a position of the rectified one; `None` where the camera does not see it.
    pub fn source_px(&self, position: DVec2) -> Option<DVec2> {
        self.in_image(self.direction(position))
    }

    /// Position in the camera's image of a direction in rectified coordinates.
    pub fn source_of(&self, direction: DVec3) -> Option<DVec2> {
        self.in_image(self.rotation.transpose() * direction)
    }

    /// Position in the camera's image of a direction in the camera's coordinates.
    fn in_image(&self, direction: DVec3) -> Option<DVec2> {
        let source = self.camera.intrinsics.pixel(self.camera.projection.project(direction, &self.reach)?);
        let size = DVec2::from_array(self.camera.resolution.map(f64::from));
        (source.cmpge(DVec2::ZERO).all() && source.cmplt(size).all()).then_some(source)
    }

    /// Unit vector that a position of the camera's image looks at, in the camera's coordinates.
    pub fn seen_from(&self, source: DVec2) -> Option<DVec3> {
        let place = self.camera.intrinsics.place(source);
        self.camera.projection.unproject(place, &self.reach).map(|seen| seen.direction)
    }

    /// Depth of a point of the camera's coordinates along the rectified axis, m.
    pub fn depth_m(&self, point: DVec3) -> f64 {
        (self.rotation * point).z
    }

    /// Position in the rectified image of a position of the camera's; `None` where a plane cannot show it.
    pub fn place_px(&self, source: DVec2) -> Option<DVec2> {
        let seen = self.rotation * self.seen_from(source)?;
        (seen.z > 0.0).then(|| self.intrinsics.pixel(seen.truncate() / seen.z))
    }

    /// Rectangle of rectified pixels that are all within the camera's image: column, row, width and height, as
    /// `cv2.stereoRectify` gives it, between the innermost positions of the pixels along each edge of the camera's
    /// image. `None` where there is none.
    pub fn valid_region_px(&self) -> Option<[u32; 4]> {
        let [columns, rows] = self.camera.resolution;
        let along = |n: u32, place: &dyn Fn(f64) -> DVec2| -> Vec<DVec2> {
            (0..n).filter_map(|i| self.place_px(place(f64::from(i) + 0.5))).collect()
        };
        let (right, bottom) = (f64::from(columns) - 0.5, f64::from(rows) - 0.5);
        let innermost = |places: Vec<DVec2>, axis: usize, is_low: bool| {
            // What a plane cannot show bounds nothing.
            let none = if is_low { f64::NEG_INFINITY } else { f64::INFINITY };
            let inner = if is_low { f64::max } else { f64::min };
            places.into_iter().map(|place| place[axis]).fold(none, inner)
        };
        let low = [
            innermost(along(rows, &|y| DVec2::new(0.5, y)), 0, true),
            innermost(along(columns, &|x| DVec2::new(x, 0.5)), 1, true),
        ];
        let high = [
            innermost(along(rows, &|y| DVec2::new(right, y)), 0, false),
            innermost(along(columns, &|x| DVec2::new(x, bottom)), 1, false),
        ];
        let mut region = [0; 4];
        for axis in 0..2 {
            // Pixels whose centres lie between.
            let first = (low[axis] - 0.5).ceil().max(0.0);
            let last = (high[axis] - 0.5).floor().min(f64::from(self.resolution[axis]) - 1.0);
            if first > last {
                return None;
            }
            (region[axis], region[axis + 2]) = (first as u32, (last - first) as u32 + 1);
        }
        Some(region)
    }

    /// Camera that takes the rectified image: of the same name at the same place, turned, with a pinhole.
    pub fn rectified_camera(&self) -> CalibratedCamera {
        let to_world = (glam::DAffine3::from_mat3(self.rotation) * self.camera.from_world()).inverse();
        CalibratedCamera {
            name: self.camera.name.clone(),
            intrinsics: self.intrinsics,
            projection: Projection::Perspective,
            resolution: self.resolution,
            // Twice turned is not turned.
            to_world: opencv_pose(&to_world),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DQuat};
    use rstest::rstest;

    use super::*;
    use photosite_core::projection::BrownConrady;

    fn camera(projection: Projection, at: DVec3, turned: DVec3) -> CalibratedCamera {
        CalibratedCamera {
            name: "camera".to_owned(),
            intrinsics: Intrinsics { fx: 60.0, fy: 61.0, cx: 33.0, cy: 23.0, skew: 0.0 },
            projection,
            resolution: [64, 48],
            to_world: DAffine3::from_rotation_translation(DQuat::from_scaled_axis(turned), at),
        }
    }

    fn barrel() -> Projection {
        let k = [-0.2, 0.05, 0.0, 0.0, 0.0, 0.0];
        Projection::BrownConrady(BrownConrady { k, p: [1e-3, -2e-3], ..BrownConrady::default() })
    }

    #[rstest]
    #[case::turned(DVec3::new(0.12, 0.01, -0.02), DVec3::new(0.05, -0.1, 0.03))]
    #[case::above(DVec3::new(0.01, -0.15, 0.02), DVec3::new(0.06, -0.02, 0.03))]
    fn both_ways_are_each_others_and_the_rectified_pair_stays_as_it_is(
        #[case] at: DVec3,
        #[case] turned: DVec3,
        #[values(
            Projection::Perspective,
            barrel(),
            Projection::KannalaBrandt { k: [0.05, 0.01, 0.0, 0.0] },
            Projection::Division { lambda: -0.2 }
        )]
        projection: Projection,
    ) {
        let (first, second) = (camera(projection, DVec3::ZERO, DVec3::ZERO), camera(projection, at, turned));
        let pair = StereoPair::new(&first, &second).expect("a pair");
        let views = pair.views();
        for view in &views {
            let Some([left, top, width, height]) = view.valid_region_px() else { panic!("they overlap") };
            for (x, y) in (0..64).flat_map(|x| (0..48).map(move |y| (x, y))) {
                let position = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let within = (left..left + width).contains(&x) && (top..top + height).contains(&y);
                let Some(source) = view.source_px(position) else {
                    assert!(!within, "{x}, {y} is in the region of valid pixels");
                    continue;
                };
                let back = view.place_px(source).expect("a plane shows it");
                assert!((back - position).length() < 1e-9, "{back} {position}");
            }
        }
        let [left, right] = views.map(|view| view.rectified_camera());
        let again = StereoPair::new(&left, &right).expect("a pair");
        assert!(again.rotations.iter().all(|r| r.abs_diff_eq(DMat3::IDENTITY, 1e-12)));
        let all = |pair: &StereoPair<'_>| [pair.projections().as_flattened(), &pair.disparity_to_depth()].concat();
        let differs = all(&pair).iter().zip(all(&again)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(differs < 1e-9, "{differs}");
        // A row, or column, of the rectified image is what a plane through both cameras shows in either.
        for (view, angle) in views.iter().flat_map(|view| [-0.2, 0.0, 0.15].map(|angle| (view, angle))) {
            let Some(source) = view.source_of(pair.in_epipolar_plane(20.5, angle)) else { continue };
            let place = view.place_px(source).expect("a plane shows it");
            let across = if pair.is_vertical { place.x } else { place.y };
            assert!((across - 20.5).abs() < 1e-9, "{place}");
        }
    }
}
