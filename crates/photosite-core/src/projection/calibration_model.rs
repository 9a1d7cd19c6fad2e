//! The models that calibration tools share.

use super::BrownConrady;

/// A lens model of calibration tools. The models are those of OpenCV's three modules; ROS, Kalibr, COLMAP, EuRoC and
/// BOP have each of them with the same coefficients or with fewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CalibrationModel {
    /// OpenCV's `calib3d` without distortion.
    Pinhole,
    /// OpenCV's `calib3d`: a pinhole with radial, rational, tangential and thin-prism distortion.
    BrownConrady(BrownConrady),
    /// OpenCV's `fisheye`.
    KannalaBrandt {
        /// k₁ … k₄.
        k: [f64; 4],
    },
    /// OpenCV's `omnidir`.
    Omnidirectional {
        /// ξ.
        xi: f64,
        /// k₁, k₂, p₁, p₂.
        distortion: BrownConrady,
    },
}
