"""Pose and intrinsics of a camera, as OpenCV has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

__all__ = ["Camera"]


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera in OpenCV's conventions: x right, y down, z forward; whole pixel coordinates at pixel centres.

    A point X of the world, in m, is at R @ X + t in the camera's coordinates, and its image, without distortion, at
    K @ (R @ X + t).

    Attributes:
        K: (3, 3) float64, the camera matrix: focal lengths and principal point in px.
        R: (3, 3) float64, rotation from the world to the camera.
        t: (3,) float64, translation from the world to the camera, m.
        distortion: float64 coefficients in OpenCV's order: k1 k2 p1 p2 k3 (k4 k5 k6 (s1 … s4)) of a perspective lens, k1
            … k4 of a fisheye, k1 k2 p1 p2 of an omnidirectional lens.
        projection: the model of the lens, as ``lens.projection`` of capture files names it: ``"perspective"``,
            ``"fisheye"`` …; ``"none"`` without a lens.
        xi: mirror parameter of an omnidirectional lens; None of others.
        position_m: (3,) float64, where the centre of the lens stands in the world, m.
        resolution_px: columns and rows.
        pose_time_s: when the camera stands so, s from the start of the first exposure; None where nothing moves.
    """

    K: "npt.NDArray[np.float64]"
    R: "npt.NDArray[np.float64]"
    t: "npt.NDArray[np.float64]"
    distortion: "npt.NDArray[np.float64]"
    projection: str
    xi: Optional[float]
    position_m: "npt.NDArray[np.float64]"
    resolution_px: "tuple[int, int]"
    pose_time_s: Optional[float]

    @classmethod
    def of_report(cls, report: "dict[str, Any]") -> "Camera":
        """Of what capture.json holds at its key ``camera``."""
        width, height = report["resolution_px"]
        return cls(
            K=np.array(report["camera_matrix"], np.float64),
            R=np.array(report["rotation"], np.float64),
            t=np.array(report["translation_m"], np.float64),
            distortion=np.array(report["distortion"], np.float64),
            projection=report["projection"],
            xi=report.get("xi"),
            position_m=np.array(report["position_m"], np.float64),
            resolution_px=(width, height),
            pose_time_s=report.get("pose_time_s"),
        )
