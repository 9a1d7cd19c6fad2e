//! Classical fisheye projections besides r = f·θ, which is [`KannalaBrandt`](super::Projection::KannalaBrandt) without
//! coefficients. Radii are in focal lengths, θ is the angle from the axis
//! ([KannalaBrandt06](crate::references#kannalabrandt06), section 2).
//!
//! | law | r | inverse | dΩ/dA | sees |
//! |---|---|---|---|---|
//! | equisolid | 2·sin(θ/2) | cos θ = 1 − r²/2 | 1 | all directions, r ≤ 2 |
//! | stereographic | 2·tan(θ/2) | cos θ = (4 − r²)/(4 + r²) | cos⁴(θ/2) | all but those just behind |
//! | orthographic | sin θ | cos θ = √(1 − r²) | 1/cos θ | a half-space, r ≤ 1 |

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::CalibrationModel;
use super::model::{Model, Seen};
use super::reach::{FLAT_ANGLE, Reach, ReachEnd};
use crate::math::linear;

/// A classical fisheye projection: the image radius as a function of the angle from the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FisheyeProjection {
    /// Equal-area projection: equal solid angles give equal areas.
    Equisolid,
    /// Conformal projection: circles stay circles, and angles are kept.
    Stereographic,
    /// Parallel projection of the unit hemisphere.
    Orthographic,
}

impl FisheyeProjection {
    const ALL: [Self; 3] = [Self::Equisolid, Self::Stereographic, Self::Orthographic];

    /// Projection by its name.
    pub(super) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|law| law.name() == name)
    }

    /// r(θ), focal lengths.
    #[inline]
    fn radius(self, theta: f64) -> f64 {
        match self {
            Self::Equisolid => 2.0 * (0.5 * theta).sin(),
            Self::Stereographic => 2.0 * (0.5 * theta).tan(),
            Self::Orthographic => theta.sin(),
        }
    }

    /// Coefficients of the [Kannala–Brandt](super::Projection::KannalaBrandt) series closest to the projection up to an
    /// angle in rad, by least squares, and the largest difference of the two radii, focal lengths.
    pub fn kannala_brandt(self, largest_angle: f64) -> Option<([f64; 4], f64)> {
        // Four coefficients of a smooth function: many more points than unknowns, closer together towards the end.
        const POINTS: u32 = 256;
        let angle = |i: u32| largest_angle * (f64::from(i) / f64::from(POINTS) * FRAC_PI_2).sin();
        // The unknowns are those of θ/θ_max, so that the powers are of one size.
        let powers = |part: f64| [3, 5, 7, 9].map(|n| part.powi(n));
        let (mut a, mut b) = (vec![vec![0.0; 4]; 4], vec![0.0; 4]);
        for theta in (1..=POINTS).map(angle) {
            let terms = powers(theta / largest_angle);
            let target = self.radius(theta) - theta;
            for (i, term) in terms.into_iter().enumerate() {
                (0..4).for_each(|j| a[i][j] += term * terms[j]);
                b[i] += term * target;
            }
        }
        let scaled = <[f64; 4]>::try_from(linear::solve(a, b)?).ok()?;
        let error = |theta: f64| {
            let series: f64 = powers(theta / largest_angle).into_iter().zip(scaled).map(|(term, c)| term * c).sum();
            (theta + series - self.radius(theta)).abs()
        };
        let largest = (1..=4 * POINTS).map(|i| error(largest_angle * f64::from(i) / f64::from(4 * POINTS)));
        let k = std::array::from_fn(|i| scaled[i] / largest_angle.powi(3 + 2 * i as i32));
        Some((k, largest.fold(0.0, f64::max)))
    }
}

impl Model for FisheyeProjection {
    const IS_FLAT: bool = false;

    fn name(&self) -> &'static str {
        match self {
            Self::Equisolid => "equisolid",
            Self::Stereographic => "stereographic",
            Self::Orthographic => "orthographic",
        }
    }

    fn coefficients(&self) -> Vec<f64> {
        Vec::new()
    }

    fn calibration_model(&self) -> Option<CalibrationModel> {
        None
    }

    /// Radius of the reach in the image, focal lengths.
    fn reach(&self) -> Reach {
        match self {
            Self::Equisolid => Reach::new(PI, ReachEnd::Sees, 2.0),
            Self::Stereographic => {
                let radius = FLAT_ANGLE.tan();
                Reach::new(2.0 * (0.5 * radius).atan(), ReachEnd::Sees, radius)
            }
            Self::Orthographic => Reach::new(FRAC_PI_2, ReachEnd::Sees, 1.0),
        }
    }

    #[inline]
    fn project(&self, direction: DVec3, _: &Reach) -> Option<DVec2> {
        let across = DVec2::new(direction.x, direction.y);
        let sin = across.length();
        let radius = self.radius(sin.atan2(direction.z));
        // The direction just behind is a whole circle, of which one point stands for all; ahead, the radius is 0.
        Some(if sin == 0.0 { DVec2::X * radius } else { across * (radius / sin) })
    }

    /// Solid angle with h = r/2: sin θ = r·√(1 − h²) (equisolid), r/(1 + h²) (stereographic), r (orthographic). dΩ =
    /// sin θ dθ dφ and dA = r dr dφ give dΩ/dA = sin θ/(r·dr/dθ).
    #[inline]
    fn unproject(&self, place: DVec2, reach: &Reach) -> Option<Seen> {
        let r2 = place.length_squared();
        let r = r2.sqrt();
        // The end itself counts, whatever roundings make of its radius.
        if r > reach.radius * (1.0 + 4.0 * f64::EPSILON) {
            return None;
        }
        let (sin_over_r, cos, solid_angle) = match self {
            Self::Equisolid => (((1.0 - 0.5 * r) * (1.0 + 0.5 * r)).max(0.0).sqrt(), 1.0 - 0.5 * r2, 1.0),
            Self::Stereographic => {
                let under = 1.0 / (1.0 + 0.25 * r2);
                (under, (1.0 - 0.25 * r2) * under, under * under)
            }
            Self::Orthographic => {
                // The rim is infinitely foreshortened: it has the smallest cosine that a radius below 1 gives.
                let cos = ((1.0 - r) * (1.0 + r)).max(f64::EPSILON).sqrt();
                (1.0, cos, 1.0 / cos)
            }
        };
        Some(Seen::all_round((place * sin_over_r).extend(cos), solid_angle))
    }
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::*;
    use crate::projection::Projection;

    /// ∫ dΩ/dA dA over the disk that shows a cone of this half-angle, by Simpson's rule in the radius.
    fn solid_angle_of_the_image(law: FisheyeProjection, angle: f64) -> f64 {
        const STEPS: u32 = 20_000;
        let (projection, end) = (Projection::ClassicalFisheye(law), law.radius(angle));
        let reach = projection.reach(None);
        let at = |i: u32| {
            let r = end * f64::from(i) / f64::from(STEPS);
            projection.unproject(DVec2::X * r, &reach).map_or(0.0, |seen| seen.solid_angle * 2.0 * PI * r)
        };
        let weight = |i: u32| if i == 0 || i == STEPS { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
        (0..=STEPS).map(|i| weight(i) * at(i)).sum::<f64>() * end / f64::from(STEPS) / 3.0
    }

    #[rstest]
    // A cone of half-angle θ is 2π(1 − cos θ): the hemisphere 2π, the sphere 4π.
    #[case(FisheyeProjection::Equisolid, PI)]
    #[case(FisheyeProjection::Equisolid, FRAC_PI_2)]
    #[case(FisheyeProjection::Stereographic, FRAC_PI_2)]
    #[case(FisheyeProjection::Stereographic, 2.5)]
    #[case(FisheyeProjection::Orthographic, 1.4)]
    fn the_image_of_a_cone_has_the_solid_angle_of_the_cone(#[case] law: FisheyeProjection, #[case] angle: f64) {
        let expected = 2.0 * PI * (1.0 - angle.cos());
        let found = solid_angle_of_the_image(law, angle);
        // Simpson's error is (b − a)h⁴/180 times a fourth derivative. That of r/√(1 − r²) at 1.4 rad is below
        // 105/cos⁹ 1.4 = 9e8, with h = 5e-5: 3e-11; the other laws are far smoother. 2e4 roundings: 1e-12.
        assert!((found / expected - 1.0).abs() < 1e-10, "{found} {expected}");
    }

    #[test]
    fn the_orthographic_hemisphere_is_seen_whole() {
        // dΩ/dA = 1/√(1 − r²) is infinite at the rim. With r = sin u the integral is that of 2π·sin u: no rim is left,
        // and the rest of the sum is that of a smooth function.
        let projection = Projection::ClassicalFisheye(FisheyeProjection::Orthographic);
        let reach = projection.reach(None);
        const STEPS: u32 = 2000;
        let at = |i: u32| {
            let u = FRAC_PI_2 * (f64::from(i) + 0.5) / f64::from(STEPS);
            let seen = projection.unproject(DVec2::Y * u.sin(), &reach).expect("within the hemisphere");
            seen.solid_angle * 2.0 * PI * u.sin() * u.cos()
        };
        let found = (0..STEPS).map(at).sum::<f64>() * FRAC_PI_2 / f64::from(STEPS);
        // The midpoint rule misses h²/24·[f′] = (π/4000)²/24·2π = 1.6e-7. The cosine from 1 − r² loses digits at the
        // rim: half a rounding of r over cos²; 1e-16/1.5e-7 in the last of 2000 cells.
        assert!((found - 2.0 * PI).abs() < 2e-7, "{found}");
    }

    #[rstest]
    fn both_directions_agree_up_to_the_end(
        #[values(FisheyeProjection::Equisolid, FisheyeProjection::Stereographic, FisheyeProjection::Orthographic)] law: FisheyeProjection,
    ) {
        let projection = Projection::ClassicalFisheye(law);
        let reach = projection.reach(None);
        for i in 0..=1000 {
            let theta = reach.angle * f64::from(i) / 1000.0;
            for about in [0.3_f64, 2.0, 4.4] {
                let direction = (DVec2::from_angle(about) * theta.sin()).extend(theta.cos());
                let place = projection.project(direction, &reach).expect("within reach");
                let seen = projection.unproject(place, &reach).expect("in the image");
                // The slope of r falls to 0 at the ends of equisolid (cos(θ/2)) and orthographic (cos θ): a rounding of
                // r becomes one over the slope, and its square root where the slope is 0. That of stereographic rises,
                // and θ of π itself is only known to a rounding.
                let slope = match law {
                    FisheyeProjection::Equisolid => (0.5 * theta).cos(),
                    FisheyeProjection::Stereographic => 1.0,
                    FisheyeProjection::Orthographic => theta.cos(),
                };
                let rounding = 4.0 * f64::EPSILON;
                let allowed = (rounding / slope.max(1e-300)).min(2.0 * rounding.sqrt());
                assert!((seen.direction - direction).length() <= allowed, "{theta}: {} {direction}", seen.direction);
                assert!((seen.direction.length() - 1.0).abs() < 2.0 * rounding || slope < 1e-7, "{theta}");
            }
        }
        // Beyond the end there is nothing.
        assert!(projection.unproject(DVec2::X * (law.radius(reach.angle) * (1.0 + 1e-9)), &reach).is_none());
    }

    #[rstest]
    // The Taylor series of each law, which least squares over a small cone come near: k₁ is that of θ³.
    #[case(FisheyeProjection::Equisolid, -1.0 / 24.0)]
    #[case(FisheyeProjection::Stereographic, 1.0 / 12.0)]
    #[case(FisheyeProjection::Orthographic, -1.0 / 6.0)]
    fn the_nearest_series_begins_as_taylors(#[case] law: FisheyeProjection, #[case] k1: f64) {
        let (k, error) = law.kannala_brandt(0.5).expect("a regular system");
        // Taylor's series without its term of θ¹¹, of which the largest is 2·1382/155925/2¹¹ = 8.7e-6 (stereographic),
        // is off by 8.7e-6·0.5¹¹ = 4.3e-9 at most, and the nearest series by no more; its k₁ by some times 4.3e-9/0.5³.
        assert!(error < 4.3e-9, "{error}");
        assert!((k[0] - k1).abs() < 10.0 * 4.3e-9 / 0.125, "{k:?}");
    }

    #[test]
    fn the_nearest_series_is_as_near_as_it_says() {
        for (law, angle) in [
            (FisheyeProjection::Equisolid, 1.6),
            (FisheyeProjection::Stereographic, 1.6),
            (FisheyeProjection::Orthographic, FRAC_PI_2),
        ] {
            let (k, error) = law.kannala_brandt(angle).expect("a regular system");
            let series = Projection::KannalaBrandt { k };
            let reach = [series, Projection::ClassicalFisheye(law)].map(|projection| projection.reach(None));
            for i in 0..777 {
                let theta = angle * f64::from(i) / 777.0;
                let direction = DVec3::new(theta.sin(), 0.0, theta.cos());
                let [near, exact] = [series, Projection::ClassicalFisheye(law)];
                let Some(near) = near.project(direction, &reach[0]) else { continue };
                let exact = exact.project(direction, &reach[1]).expect("within reach");
                // Between two of 1024 places the error changes by less than its own size.
                assert!((near - exact).length() < 1.01 * error + 1e-15, "{law:?} {theta}: {near} {exact} {error}");
            }
        }
    }
}
