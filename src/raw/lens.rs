//! What is known of the lens that a developer can correct: falloff and distortion.

use crate::Invalid;

/// Gains that make an evenly lit picture even: points on an even grid over the active area, the outermost on its edges,
/// with straight lines in between.
#[derive(Clone, Debug, PartialEq)]
pub struct GainMap {
    columns: usize,
    gains: Vec<f32>,
}

impl GainMap {
    /// Gains row by row from the top-left corner; they are finite and above 0.
    pub fn new(columns: usize, rows: usize, gains: Vec<f32>) -> Result<Self, Invalid> {
        let complete = columns > 0 && rows > 0 && columns.checked_mul(rows) == Some(gains.len());
        if !complete || gains.iter().any(|gain| !(gain.is_finite() && *gain > 0.0)) {
            let message = format!("{} gains are no map of {columns} × {rows} points", gains.len());
            return Err(Invalid::new("GainMap", message).help("give finite numbers above 0"));
        }
        Ok(Self { columns, gains })
    }

    /// Points in a row.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Rows of points.
    pub fn rows(&self) -> usize {
        self.gains.len() / self.columns
    }

    /// The gains, row by row.
    pub fn gains(&self) -> &[f32] {
        &self.gains
    }

    /// The gain at a place of the active area, from 0, 0 at its top-left corner to 1, 1 at the opposite one.
    pub fn at(&self, x: f64, y: f64) -> f32 {
        let split = |position: f64, points: usize| {
            let position = position.clamp(0.0, 1.0) * (points - 1) as f64;
            let first = (position as usize).min(points.saturating_sub(2));
            (first, (first + 1).min(points - 1), (position - first as f64) as f32)
        };
        let (left, right, part_x) = split(x, self.columns());
        let (top, bottom, part_y) = split(y, self.rows());
        let mix = |a: f32, b: f32, part: f32| a + (b - a) * part;
        let row = |y: usize| mix(self.gains[y * self.columns + left], self.gains[y * self.columns + right], part_x);
        mix(row(top), row(bottom), part_y)
    }
}

/// Where a corrected pixel is found in the distorted picture: DNG's WarpRectilinear
/// ([Dng16](crate::references#dng16), chapter 7).
///
/// With the offset (x, y) from the centre, in units of the distance from the centre to the farthest corner, and
/// r² = x² + y²,
///
/// x' = x·(k₀ + k₁r² + k₂r⁴ + k₃r⁶) + t₀·2xy + t₁·(r² + 2x²)
///
/// y' = y·(k₀ + k₁r² + k₂r⁴ + k₃r⁶) + t₁·2xy + t₀·(r² + 2y²)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warp {
    /// k₀ … k₃.
    pub radial: [f64; 4],
    /// t₀, t₁.
    pub tangential: [f64; 2],
    /// The centre: 0, 0 is the centre of the active area's top-left pixel, 1, 1 that of the opposite one.
    pub centre: [f64; 2],
}

impl Warp {
    /// That of OpenCV's model of Brown and Conrady, whose coordinates are in units of the focal length in pixels, about a
    /// principal point in continuous pixel coordinates. Both models go from the ideal to the distorted picture and are
    /// the same polynomial; only the unit differs, so the correction is exact where pixels are square.
    pub fn brown_conrady(
        k: [f64; 3],
        p: [f64; 2],
        focal_length_px: f64,
        principal_point_px: [f64; 2],
        size_px: [usize; 2],
    ) -> Self {
        let centre = principal_point_px.map(|c| c - 0.5);
        let last = size_px.map(|n| n as f64 - 1.0);
        let farthest = |axis: usize| centre[axis].abs().max((last[axis] - centre[axis]).abs());
        let unit = farthest(0).hypot(farthest(1)) / focal_length_px;
        Self {
            radial: [1.0, k[0] * unit.powi(2), k[1] * unit.powi(4), k[2] * unit.powi(6)],
            tangential: p.map(|p| p * unit),
            centre: std::array::from_fn(|axis| centre[axis] / last[axis].max(1.0)),
        }
    }

    /// Where to find the corrected pixel of these coordinates (integer at centres) in a picture of that size.
    pub fn source_px(&self, pixel: [f64; 2], size_px: [usize; 2]) -> [f64; 2] {
        let last = size_px.map(|n| n as f64 - 1.0);
        let centre: [f64; 2] = std::array::from_fn(|axis| self.centre[axis] * last[axis]);
        let farthest = |axis: usize| centre[axis].abs().max((last[axis] - centre[axis]).abs());
        let unit = farthest(0).hypot(farthest(1)).max(f64::MIN_POSITIVE);
        let [x, y] = std::array::from_fn(|axis| (pixel[axis] - centre[axis]) / unit);
        let r2 = x * x + y * y;
        let [k0, k1, k2, k3] = self.radial;
        let [t0, t1] = self.tangential;
        let radial = k0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        [
            centre[0] + unit * (x * radial + t0 * 2.0 * x * y + t1 * (r2 + 2.0 * x * x)),
            centre[1] + unit * (y * radial + t1 * 2.0 * x * y + t0 * (r2 + 2.0 * y * y)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_between_points_lie_on_straight_lines() {
        let map = GainMap::new(3, 2, vec![1.0, 2.0, 4.0, 2.0, 3.0, 5.0]).expect("6 gains");
        for (x, y, gain) in [(0.0, 0.0, 1.0), (0.25, 0.0, 1.5), (0.75, 0.5, 3.5), (1.0, 1.0, 5.0), (2.0, -1.0, 4.0)] {
            assert_eq!(map.at(x, y), gain, "{x} {y}");
        }
        assert_eq!(GainMap::new(1, 1, vec![2.0]).expect("one gain").at(0.5, 0.5), 2.0);
        for (columns, rows, gains) in [(2, 2, vec![1.0; 3]), (0, 0, vec![]), (1, 1, vec![0.0]), (1, 1, vec![f32::NAN])]
        {
            assert!(GainMap::new(columns, rows, gains).is_err());
        }
    }

    #[test]
    fn the_warp_is_that_of_opencv() {
        // OpenCV's projectPoints by hand: f = 100 px, the centre of the picture at 50, 40 in integer coordinates.
        let (k, p) = ([-0.1, 0.03, -0.01], [2e-3, -1e-3]);
        let warp = Warp::brown_conrady(k, p, 100.0, [50.5, 40.5], [101, 81]);
        assert_eq!(warp.centre, [0.5, 0.5]);
        for pixel in [[50.0, 40.0], [80.0, 10.0], [0.0, 0.0], [100.0, 80.0]] {
            let [x, y] = [(pixel[0] - 50.0) / 100.0, (pixel[1] - 40.0) / 100.0];
            let r2: f64 = x * x + y * y;
            let radial = 1.0 + k[0] * r2 + k[1] * r2.powi(2) + k[2] * r2.powi(3);
            let distorted = [
                x * radial + 2.0 * p[0] * x * y + p[1] * (r2 + 2.0 * x * x),
                y * radial + p[0] * (r2 + 2.0 * y * y) + 2.0 * p[1] * x * y,
            ];
            let found = warp.source_px(pixel, [101, 81]);
            assert!((found[0] - 50.0 - 100.0 * distorted[0]).abs() < 1e-10, "{found:?}");
            assert!((found[1] - 40.0 - 100.0 * distorted[1]).abs() < 1e-10, "{found:?}");
        }
    }
}
