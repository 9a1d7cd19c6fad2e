//! Maps from the unit square to the shapes that light transport samples. Each function states its density.

use std::f32::consts::{FRAC_PI_4, PI};

use glam::Vec3;

use super::{Real, Vector};

/// Unit square → unit disk, density 1/π; keeps neighbouring points together (Shirley & Chiu 1997).
#[inline(always)]
pub fn concentric_disk<R: Real>([u, v]: [R; 2]) -> [R; 2] {
    let (zero, one, two) = (u.broadcast(0.0), u.broadcast(1.0), u.broadcast(2.0));
    let (x, y) = (two * u - one, two * v - one);
    // The angle is counted from the axis of the larger one.
    let is_x = y.abs().lt(x.abs());
    let (larger, smaller) = (R::select(is_x, x, y), R::select(is_x, y, x));
    let is_centre = larger.abs().le(zero);
    let (sin, cos) = sin_cos_of_eighth(u.broadcast(FRAC_PI_4) * (smaller / R::select(is_centre, one, larger)));
    let (along, aside) = (larger * cos, larger * sin);
    [R::select(is_x, along, aside), R::select(is_x, aside, along)]
}

/// Sine and cosine of an angle of −π/4 to π/4, to the last bit or two: Taylor's series up to x⁹ and x¹⁰, whose first
/// term left out is 2·10⁻⁹ and 10⁻¹⁰ of the whole at most. The result is the same on every machine, and cheaper than
/// functions of any angle.
#[inline(always)]
fn sin_cos_of_eighth<R: Real>(x: R) -> (R, R) {
    // Written out, since a closure would not be compiled for wide registers.
    let one = x.broadcast(1.0);
    let [s3, s5, s7, s9] =
        [x.broadcast(-1.0 / 6.0), x.broadcast(1.0 / 120.0), x.broadcast(-1.0 / 5040.0), x.broadcast(1.0 / 362_880.0)];
    let [c2, c4, c6, c8, c10] = [
        x.broadcast(-0.5),
        x.broadcast(1.0 / 24.0),
        x.broadcast(-1.0 / 720.0),
        x.broadcast(1.0 / 40_320.0),
        x.broadcast(1.0 / 3_628_800.0),
    ];
    let x2 = x * x;
    let sin = x + x * x2 * (s3 + x2 * (s5 + x2 * (s7 + x2 * s9)));
    let cos = one + x2 * (c2 + x2 * (c4 + x2 * (c6 + x2 * (c8 - x2 * c10))));
    (sin, cos)
}

/// Unit square → upper hemisphere, density cos θ/π per steradian.
#[inline(always)]
pub fn cosine_hemisphere<R: Real>(u: [R; 2]) -> Vector<R> {
    let [x, y] = concentric_disk(u);
    Vector::new(x, y, (x.broadcast(1.0) - (x * x + y * y)).max(x.broadcast(0.0)).sqrt())
}

/// Unit square → unit sphere, density 1/(4π) per steradian.
#[inline]
pub fn uniform_sphere([u, v]: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * v).sin_cos();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Unit square → cone about +Z with half-angle acos(`cos_max`), density 1/(2π(1 − cos_max)) per steradian.
#[inline]
pub fn uniform_cone([u, v]: [f32; 2], cos_max: f32) -> Vec3 {
    let z = (1.0 - u) + u * cos_max;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * v).sin_cos();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Unit square → barycentric coordinates (b₁, b₂) of the second and third corner, uniform over the triangle
/// (Heitz, "A Low-Distortion Map Between Triangle and Square", 2019).
#[inline(always)]
pub fn uniform_triangle<R: Real>([u, v]: [R; 2]) -> [R; 2] {
    let is_below = u.lt(v);
    let half = u.broadcast(0.5) * R::select(is_below, u, v);
    let rest = R::select(is_below, v, u) - half;
    [R::select(is_below, half, rest), R::select(is_below, rest, half)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of `f` over an n × n grid of cell centres in the unit square.
    fn grid_mean(n: usize, f: impl Fn([f32; 2]) -> f64) -> f64 {
        let at = |i: usize| (i as f32 + 0.5) / n as f32;
        let sum: f64 = (0..n * n).map(|i| f([at(i % n), at(i / n)])).sum();
        sum / (n * n) as f64
    }

    // The midpoint rule on a 512² grid of these smooth integrands is good to 1e-4 or better.
    const TOLERANCE: f64 = 1e-4;

    #[test]
    fn sine_and_cosine_of_small_angles_are_right_to_two_ulp() {
        for i in -1000i16..=1000 {
            let x = FRAC_PI_4 * f32::from(i) / 1000.0;
            let ((sin, cos), exact) = (sin_cos_of_eighth::<f32>(x), f64::from(x).sin_cos());
            let ulp = |value: f64| f64::from(f32::EPSILON) * value.abs().max(1e-30);
            assert!((f64::from(sin) - exact.0).abs() <= 2.0 * ulp(exact.0), "sin {x}");
            assert!((f64::from(cos) - exact.1).abs() <= 2.0 * ulp(exact.1), "cos {x}");
        }
    }

    #[test]
    fn disk_has_the_moments_of_a_uniform_disk() {
        assert!(
            (grid_mean(512, |u| f64::from(concentric_disk(u).iter().map(|x| x * x).sum::<f32>())) - 0.5).abs()
                < TOLERANCE
        );
        assert!(grid_mean(512, |u| f64::from(concentric_disk(u)[0])).abs() < TOLERANCE);
    }

    #[test]
    fn cosine_hemisphere_has_mean_height_two_thirds() {
        assert!((grid_mean(512, |u| f64::from(cosine_hemisphere(u).z)) - 2.0 / 3.0).abs() < TOLERANCE);
    }

    #[test]
    fn sphere_and_cone_have_the_right_moments() {
        assert!((grid_mean(512, |u| f64::from(uniform_sphere(u).z.powi(2))) - 1.0 / 3.0).abs() < TOLERANCE);
        assert!((grid_mean(512, |u| f64::from(uniform_cone(u, 0.25).z)) - 0.625).abs() < TOLERANCE);
    }

    #[test]
    fn triangle_has_its_centroid_and_stays_inside() {
        for axis in 0..2 {
            assert!((grid_mean(512, |u| f64::from(uniform_triangle(u)[axis])) - 1.0 / 3.0).abs() < TOLERANCE);
        }
        assert!(grid_mean(64, |u| f64::from(u8::from(uniform_triangle(u).iter().sum::<f32>() > 1.0))) == 0.0);
    }
}
