//! The opening of a lens: its area and how points on it are drawn.

use glam::{DVec2, Vec2};

use crate::math::warp;

/// A disk, or a regular polygon inscribed in it, centred on the axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aperture {
    /// Radius of the disk, m.
    radius: f64,
    /// Corners; 0 for the disk.
    blades: u32,
    rotation_rad: f64,
}

impl Aperture {
    /// `radius` in m; `blades` is 0 for a disk or at least 3.
    pub(super) fn new(radius: f64, blades: u32, rotation_deg: f64) -> Self {
        Self { radius, blades, rotation_rad: rotation_deg.to_radians() }
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
        let corner = |i: f32| {
            let angle = self.rotation_rad + std::f64::consts::TAU * f64::from(i) / f64::from(self.blades);
            DVec2::from_angle(angle) * self.radius
        };
        corner(blade) * f64::from(b1) + corner(blade + 1.0) * f64::from(b2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
