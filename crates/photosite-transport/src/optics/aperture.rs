//! The opening of a lens: its area, what it lets onto the middle of the image, and how points on it are drawn.

use glam::{DVec2, Vec2};

use photosite_core::math::warp;

/// A disk, or a regular polygon inscribed in it, centred on the axis. The f-number is that of the disk: with blades,
/// the same f-number lets through less.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aperture {
    /// Radius of the disk, m.
    radius: f64,
    /// Corners; 0 for the disk.
    blades: u32,
    rotation_rad: f64,
}

impl Aperture {
    /// Makes an aperture of `radius` in m; `blades` is 0 for a disk or at least 3.
    pub(super) fn new(radius: f64, blades: u32, rotation_deg: f64) -> Self {
        Self { radius, blades, rotation_rad: rotation_deg.to_radians() }
    }

    /// Radius of the disk, m.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// Area in m²: πr², or n/2·r²·sin(2π/n) for n blades.
    pub(super) fn area(&self) -> f64 {
        let square = self.radius * self.radius;
        if self.blades == 0 {
            std::f64::consts::PI * square
        } else {
            let n = f64::from(self.blades);
            0.5 * n * square * (std::f64::consts::TAU / n).sin()
        }
    }

    /// The projected solid angle of the opening from a point on the axis at the distance v, m: ∫_A cos⁴θ/v² dA, sr.
    ///
    /// For the disk, π·sin²θ' with tan θ' = r/v; for the polygon, Lambert's sum over its edges
    /// ([Baum89](photosite_core::references#baum89)), n·γ/2·sin ψ: from the point an edge is seen under the angle
    /// γ, and its plane through the point is at the angle ψ to the axis. With the distance a = r·cos(π/n) of the edge
    /// from the axis and half its length h = r·sin(π/n), γ = 2·atan(h/√(a² + v²)) and sin ψ = a/√(a² + v²).
    pub(super) fn projected_solid_angle(&self, v: f64) -> f64 {
        let (r, v2) = (self.radius, v * v);
        if self.blades == 0 {
            return std::f64::consts::PI * r * r / (r * r + v2);
        }
        let n = f64::from(self.blades);
        let (half_length, from_axis) = (std::f64::consts::PI / n).sin_cos();
        let (half_length, from_axis) = (r * half_length, r * from_axis);
        let distance = (from_axis * from_axis + v2).sqrt();
        n * (half_length / distance).atan() * from_axis / distance
    }

    /// A point of the opening in m, uniform over its area.
    #[inline]
    pub(super) fn sample(&self, [u, v]: [f32; 2]) -> DVec2 {
        if self.blades == 0 {
            return Vec2::from(warp::concentric_disk([u, v])).as_dvec2() * self.radius;
        }
        // One of n equal triangles about the centre, then a point within it.
        let scaled = u * self.blades as f32;
        let blade = scaled.floor().min(self.blades as f32 - 1.0);
        let [b1, b2] = warp::uniform_triangle([scaled - blade, v]);
        self.corner(blade) * f64::from(b1) + self.corner(blade + 1.0) * f64::from(b2)
    }

    /// Corner i of the polygon, m.
    #[inline]
    fn corner(&self, i: f32) -> DVec2 {
        let angle = self.rotation_rad + std::f64::consts::TAU * f64::from(i) / f64::from(self.blades);
        DVec2::from_angle(angle) * self.radius
    }

    /// Corners of the polygon and the first once more, m; none of a disk.
    pub(super) fn corners(&self) -> Vec<[f32; 2]> {
        let corner = |i: u32| self.corner(i as f32).as_vec2().to_array();
        if self.blades == 0 { Vec::new() } else { (0..=self.blades).map(corner).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_projected_solid_angle_is_the_integral_over_the_opening() {
        let v = 0.9;
        for (radius, blades) in [(0.45, 0), (0.45, 3), (0.45, 5), (0.45, 8), (0.05, 0), (0.05, 6)] {
            let aperture = Aperture::new(radius, blades, 20.0);
            let n = 240;
            let at = |i: i32| (i as f32 + 0.5) / n as f32;
            let cos4 = |point: DVec2| (v * v / (v * v + point.length_squared())).powi(2);
            let mean =
                (0..n * n).map(|i| cos4(aperture.sample([at(i % n), at(i / n)]))).sum::<f64>() / f64::from(n * n);
            let expected = aperture.area() * mean / (v * v);
            let found = aperture.projected_solid_angle(v);
            // Midpoint rule on a 240² grid of a smooth function.
            assert!((found / expected - 1.0).abs() < 1e-4, "{radius} m, {blades} blades: {found} {expected}");
        }
        // A polygon of very many corners is the disk.
        let [disk, polygon] = [0, 100_000].map(|blades| Aperture::new(0.45, blades, 0.0).projected_solid_angle(v));
        assert!((polygon / disk - 1.0).abs() < 1e-8, "{polygon} {disk}");
    }

    #[test]
    fn points_fill_the_opening_evenly() {
        for blades in [0, 3, 5, 8] {
            let aperture = Aperture::new(2.0, blades, 20.0);
            // Second moment about the axis: r²/2 for a disk, r²·(2 + cos(2π/n))/6 for a regular polygon.
            let expected = match blades {
                0 => 2.0,
                n => 4.0 * (2.0 + (std::f64::consts::TAU / f64::from(n)).cos()) / 6.0,
            };
            let n = 240;
            let at = |i: i32| (i as f32 + 0.5) / n as f32;
            let mean = (0..n * n).map(|i| aperture.sample([at(i % n), at(i / n)]).length_squared()).sum::<f64>()
                / f64::from(n * n);
            // Midpoint rule on a 240² grid of a smooth function.
            assert!((mean / expected - 1.0).abs() < 1e-3, "{blades} blades: {mean} {expected}");
        }
    }
}
