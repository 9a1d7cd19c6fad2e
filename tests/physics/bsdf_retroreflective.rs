//! Retroreflective sheeting: what makes it one, by other routes than its formulas.

use glam::{DVec3, Vec3};
use photosite::bsdf::CubeCorners;
use photosite::spectrum::SampledSpectrum;

use super::bsdf_cases::{above, sheeting};
use super::quadrature::integrate_sphere;

const BLACK: SampledSpectrum = SampledSpectrum::ZERO;
const WHITE: SampledSpectrum = SampledSpectrum::ONE;

/// The part of the rays from an angle outside, rad, that enter a corner of a cube by a circular opening, meet its three
/// faces and leave by the opening, traced one by one. The faces are the coordinate planes.
fn traced(index: f64, theta: f64) -> f64 {
    let axis = DVec3::ONE.normalize();
    let x = DVec3::new(1.0, -1.0, 0.0).normalize();
    let y = axis.cross(x);
    // The largest circle in the opening of a corner of height 1, whose sides are at 54.7° to the axis.
    let radius = 0.5f64.sqrt();
    let sin = theta.sin() / index;
    let (mut inside, mut back) = (0, 0);
    for i in 0..200 {
        for j in 0..200 {
            let [u, v] = [i, j].map(|k| (f64::from(k) + 0.5) / 100.0 - 1.0);
            if u * u + v * v >= 1.0 {
                continue;
            }
            inside += 1;
            let (mut position, mut direction) =
                (axis + radius * (u * x + v * y), x * sin - axis * (1.0 - sin * sin).sqrt());
            let entered = direction;
            for _ in 0..3 {
                // The nearest face ahead.
                let distance = |k: usize| if direction[k] < 0.0 { position[k] / -direction[k] } else { f64::INFINITY };
                let face = (0..3).min_by(|a, b| distance(*a).total_cmp(&distance(*b))).expect("three faces");
                if distance(face).is_finite() {
                    position += direction * distance(face);
                    direction[face] = -direction[face];
                }
            }
            // The plane of the opening again.
            position += direction * ((1.0 - position.dot(axis)) / direction.dot(axis));
            let returns = direction.dot(entered) < -1.0 + 1e-12;
            back += u32::from(returns && (position - axis).length() < radius);
        }
    }
    f64::from(back) / f64::from(inside)
}

#[test]
fn the_active_part_is_what_rays_through_a_corner_find() {
    for index in [1.0, 1.5, 2.0] {
        let corners = CubeCorners::new(index as f32);
        for degrees in [0.0f64, 10.0, 25.0, 40.0, 60.0, 80.0] {
            let theta = degrees.to_radians();
            let (found, expected) = (f64::from(corners.active_part(theta.cos() as f32)), traced(index, theta));
            // The rim cuts some 4·200 of the 31 400 cells, half of them wrongly with random signs: √800/2/31 400 =
            // 5e-4; 5 of it.
            assert!((found - expected).abs() < 2.5e-3, "n {index} {degrees}°: {found} is not {expected}");
        }
    }
}

#[test]
fn luminance_falls_with_the_observation_angle_as_the_facets_slopes_do() {
    // D/D(0) = 1/(cos⁴·(1 + tan²/α²)²) at half the observation angle; the other factors change with its cosine.
    let alpha = 0.01f64;
    let sign = sheeting(WHITE * 0.4, BLACK, 1.5, alpha as f32);
    let at = |angle: f64| {
        let wi = Vec3::new(angle.sin() as f32, 0.0, angle.cos() as f32);
        f64::from(sign.eval(Vec3::Z, wi).f[0])
    };
    for degrees in [0.1f64, 0.33, 0.737, 1.5, 3.0] {
        let angle = degrees.to_radians();
        let tan = (angle / 2.0).tan() / alpha;
        let expected = 1.0 / (1.0 + tan * tan).powi(2);
        // a falls by 1.8/n of the angle; a unit vector in f32 is right to 6e-8, which is 6e-8/α of a slope of order 1.
        let tolerance = 1.8 / 1.5 * angle + 5e-4;
        let found = at(angle) / at(0.0);
        assert!((found / expected - 1.0).abs() < tolerance, "{degrees}°: {found} is not {expected}");
    }
    // Half at 2·arctan(α·√(√2 − 1)), which the documentation says is 1.29·α.
    let half = 2.0 * (alpha * (2f64.sqrt() - 1.0).sqrt()).atan();
    assert!((half / alpha - 1.29).abs() < 5e-3, "{half}");
}

#[test]
fn light_goes_back_to_where_it_comes_from_and_nowhere_else() {
    let alpha = 0.02f32;
    let sign = sheeting(WHITE * 0.4, BLACK, 1.586, alpha);
    for degrees in [0.0f32, 5.0, 20.0, 40.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let wo = Vec3::new(sin, 0.0, cos);
        let back = sign.eval(wo, wo).f[0];
        for i in 0..40 {
            for j in 0..80 {
                let (z, phi) = ((i as f32 + 0.5) / 40.0, (j as f32 + 0.5) / 80.0 * std::f32::consts::TAU);
                let radius = (1.0 - z * z).sqrt();
                let wi = Vec3::new(radius * phi.cos(), radius * phi.sin(), z);
                // At half the angle between both the slope is at least half its tangent, whatever the azimuth.
                let tan = (0.5 * wi.angle_between(wo)).tan() / alpha;
                let elsewhere = sign.eval(wo, wi).f[0];
                // Beside D, which is at most that, cosines of both directions divide: twice as much at most within the
                // lobe.
                assert!(elsewhere <= 2.0 * back / (1.0 + tan * tan), "{degrees}° {wi}: {elsewhere} of {back}");
            }
        }
    }
}

#[test]
fn what_does_not_return_is_scattered_to_the_last_bit() {
    for index in [1.0f32, 1.5, 2.0] {
        for returned in [0.0f32, 0.4, 1.0] {
            let power = |reflectance: f32, wo: Vec3| {
                let bsdf = sheeting(WHITE * returned, WHITE * reflectance, index, 0.2);
                integrate_sphere(|wi| f64::from(bsdf.eval(wo, wi).f[0] * wi.z.abs()))
            };
            for (from, wo) in above() {
                let corners = CubeCorners::new(index);
                let active = f64::from(returned * corners.active_part(wo.z));
                let (lobe, all) = (power(0.0, wo), power(1.0, wo));
                // The quadrature is right to 1e-4 where f bends, as a does at its end.
                assert!((all - lobe - (1.0 - active)).abs() < 2e-4, "n {index} R {returned} {from}: {all} − {lobe}");
                assert!(lobe < active + 1e-4 && all < 1.0 + 1e-4, "n {index} R {returned} {from}: {lobe} of {active}");
            }
        }
    }
}
