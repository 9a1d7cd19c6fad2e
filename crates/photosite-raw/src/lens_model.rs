//! The model of the lens that took an image, and the way from a pinhole's image to that of the lens.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use photosite_core::projection::{Intrinsics, Projection, Reach};

/// The model of a lens in front of a grid of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LensModel {
    /// Intrinsics in pixels of the active area.
    pub intrinsics: Intrinsics,
    /// Projection from directions to places on the image.
    pub projection: Projection,
    /// Angle from the axis beyond which the lens sees nothing, rad; `None` for all that its projection can show.
    pub max_angle_rad: Option<f64>,
}

impl LensModel {
    /// The pinhole whose image a developer makes of that of this lens: its matrix, but for the
    /// [size](Projection::magnification) of the middle of the image, which stays as it is.
    pub fn pinhole(&self) -> Intrinsics {
        let Intrinsics { fx, fy, cx, cy, skew } = self.intrinsics;
        let size = self.projection.magnification();
        Intrinsics { fx: fx * size, fy: fy * size, cx, cy, skew: skew * size }
    }

    /// The way from that image back to the one of this lens.
    pub fn undistortion(&self) -> Undistortion {
        Undistortion { lens: *self, pinhole: self.pinhole(), reach: self.projection.reach(self.max_angle_rad) }
    }

    /// Whether all that the lens shows of a grid of these columns and rows lies less than 90° from its axis, as a
    /// pinhole could show it.
    pub fn is_within_a_half_space(&self, [columns, rows]: [usize; 2]) -> bool {
        let reach = self.projection.reach(self.max_angle_rad);
        let is_seen = |x: usize, y: usize| {
            let seen = self.projection.unproject(self.intrinsics.place(DVec2::new(x as f64, y as f64)), &reach);
            // What is beyond the reach is no farther away than that is.
            seen.map_or(reach.angle < std::f64::consts::FRAC_PI_2, |seen| seen.direction.z > 0.0)
        };
        // What lies within is nearer to the axis than the edge is, unless the axis is far outside; then the edge has
        // both.
        (0..=columns).all(|x| is_seen(x, 0) && is_seen(x, rows))
            && (0..=rows).all(|y| is_seen(0, y) && is_seen(columns, y))
    }
}

/// Map from the image of a pinhole to that of a lens.
#[derive(Clone, Copy, Debug)]
pub struct Undistortion {
    lens: LensModel,
    pinhole: Intrinsics,
    reach: Reach,
}

impl Undistortion {
    /// Position in the lens's image of a position in the pinhole's (continuous coordinates); `None` beyond the reach of
    /// the lens.
    #[inline]
    pub fn source(&self, pixel: DVec2) -> Option<DVec2> {
        let direction: DVec3 = self.pinhole.place(pixel).extend(1.0);
        self.lens.projection.project(direction, &self.reach).map(|place| self.lens.intrinsics.pixel(place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::projection::BrownConrady;

    #[test]
    fn lenses_that_see_less_than_a_half_space_are_told_from_others() {
        // A fisheye of f = 100 px shows 90° at 157 px.
        let of = |width: f64| LensModel {
            intrinsics: Intrinsics { fx: 100.0, fy: 100.0, cx: width / 2.0, cy: 20.0, skew: 0.0 },
            projection: Projection::KannalaBrandt { k: [0.0; 4] },
            max_angle_rad: None,
        };
        assert!(of(310.0).is_within_a_half_space([310, 40]));
        assert!(!of(316.0).is_within_a_half_space([316, 40]));
        // A rim at 80° is seen and what is beyond is not.
        assert!(LensModel { max_angle_rad: Some(1.4), ..of(316.0) }.is_within_a_half_space([316, 40]));
        let mirror = Projection::Omnidirectional { xi: 1.0, distortion: BrownConrady::default() };
        // x = tan(θ/2), which is 1 at 90°.
        let mirror = |width: f64| LensModel { projection: mirror, ..of(width) };
        assert!(mirror(190.0).is_within_a_half_space([190, 40]) && !mirror(206.0).is_within_a_half_space([206, 40]));
    }

    #[test]
    fn the_middle_of_the_image_keeps_its_size() {
        for projection in [
            Projection::KannalaBrandt { k: [0.1, 0.0, 0.0, 0.0] },
            Projection::Division { lambda: -0.2 },
            Projection::Omnidirectional { xi: 1.3, distortion: BrownConrady::default() },
        ] {
            let intrinsics = Intrinsics { fx: 300.0, fy: 310.0, cx: 100.0, cy: 80.0, skew: 2.0 };
            let lens = LensModel { intrinsics, projection, max_angle_rad: None };
            let way = lens.undistortion();
            for step in [DVec2::X, DVec2::Y] {
                let centre = DVec2::new(100.0, 80.0);
                let moved =
                    way.source(centre + step * 0.01).expect("seen") - way.source(centre - step * 0.01).expect("seen");
                // The models bend by some r² with r = 0.01/100.
                assert!((moved - step * 0.02).length() < 1e-8, "{projection:?}: {moved}");
            }
        }
    }
}
