//! The models that calibration tools share.

use super::BrownConrady;

/// A lens as calibration tools know it. These are the three modules of OpenCV; ROS, Kalibr, COLMAP, EuRoC and BOP know
/// each of them with the same coefficients or with fewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CalibrationModel {
    /// `calib3d` without distortion.
    Pinhole,
    /// `calib3d`: a pinhole with radial, rational, tangential and thin-prism distortion.
    BrownConrady(BrownConrady),
    /// `fisheye`.
    KannalaBrandt {
        /// k₁ … k₄.
        k: [f64; 4],
    },
    /// `omnidir`.
    Omnidirectional {
        /// ξ.
        xi: f64,
        /// k₁, k₂, p₁, p₂.
        distortion: BrownConrady,
    },
}
