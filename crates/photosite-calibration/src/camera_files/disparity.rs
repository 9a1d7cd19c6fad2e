//! Conversion between disparity and depth, as by Q of `cv2.stereoRectify` and `cv2.reprojectImageTo3D`.

use super::StereoPair;
use photosite_core::Invalid;

/// Scale between disparity and depth, Z = f·b/(d + c): the depth along the common axis of a point that appears d pixels
/// farther left (or above) in the second of two rectified images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisparityScale {
    /// Product f·b, px·m; below 0 where the second camera stands left of the first.
    focal_times_baseline: f64,
    /// Offset c, px: c_x of the second image less that of the first. 0 where both have the same.
    offset_px: f64,
}

impl DisparityScale {
    /// Scale for images with these f, b and c; b is below 0 where the second camera stands left of the first.
    pub fn new(focal_length_px: f64, baseline_m: f64, offset_px: f64) -> Result<Self, Invalid> {
        let refused = |key: &str, x: f64, range: &str| Err(Invalid::new(key, format!("{x} is not {range}")));
        if !(focal_length_px.is_finite() && focal_length_px > 0.0) {
            return refused("focal_length_px", focal_length_px, "above 0");
        }
        if !baseline_m.is_finite() || baseline_m == 0.0 {
            return refused("baseline_m", baseline_m, "a length other than 0");
        }
        if !offset_px.is_finite() {
            return refused("offset_px", offset_px, "a number of pixels");
        }
        Ok(Self { focal_times_baseline: focal_length_px * baseline_m, offset_px })
    }

    /// Depth Z, m; `None` for a disparity of a point at infinity, or behind the cameras.
    pub fn depth_m(&self, disparity_px: f64) -> Option<f64> {
        let depth = self.focal_times_baseline / (disparity_px + self.offset_px);
        (depth.is_finite() && depth > 0.0).then_some(depth)
    }

    /// Disparity d, px; `None` for a depth that is infinite, or not in front of the cameras.
    pub fn disparity_px(&self, depth_m: f64) -> Option<f64> {
        let disparity = self.focal_times_baseline / depth_m - self.offset_px;
        (depth_m > 0.0 && depth_m.is_finite() && disparity.is_finite()).then_some(disparity)
    }
}

impl StereoPair<'_> {
    /// Scale of disparity in the rectified images.
    pub fn disparity_scale(&self) -> DisparityScale {
        DisparityScale { focal_times_baseline: self.focal_length_px * self.baseline_m(), offset_px: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_and_disparity_lead_to_each_other() {
        for (baseline, offset) in [(0.12, 0.0), (-0.12, 0.0), (0.12, 3.5)] {
            let scale = DisparityScale::new(500.0, baseline, offset).expect("a scale");
            for depth in [0.1, 1.0, 30.0] {
                let disparity = scale.disparity_px(depth).expect("before the cameras");
                assert!((disparity - (500.0 * baseline / depth - offset)).abs() < 1e-12);
                let back = scale.depth_m(disparity).expect("before the cameras");
                assert!((back - depth).abs() < 1e-12 * depth, "{back}");
            }
        }
    }

    #[test]
    fn what_is_not_before_the_cameras_has_neither() {
        let scale = DisparityScale::new(500.0, 0.12, 0.0).expect("a scale");
        for none in [0.0, -0.0, -3.0, f64::NAN, f64::INFINITY] {
            assert_eq!((scale.depth_m(none), scale.disparity_px(none)), (None, None), "{none}");
        }
        for (f, b, c) in [(0.0, 0.1, 0.0), (f64::NAN, 0.1, 0.0), (500.0, 0.0, 0.0), (500.0, 0.1, f64::INFINITY)] {
            assert!(DisparityScale::new(f, b, c).is_err());
        }
    }
}
