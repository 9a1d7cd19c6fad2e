//! The lens's falloff, which a developer can correct.

use photosite_core::Invalid;
use serde::{Deserialize, Serialize};

/// Gains that make an evenly lit picture even: points on an even grid over the active area, the outermost on its edges,
/// with straight lines in between.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GainMap {
    columns: usize,
    gains: Vec<f32>,
}

impl GainMap {
    /// Gains row by row from the top-left corner; they are finite and above 0.
    pub fn new(columns: usize, rows: usize, gains: Vec<f32>) -> Result<Self, Invalid> {
        let complete = columns > 0 && rows > 0 && columns.checked_mul(rows) == Some(gains.len());
        if !complete || gains.iter().any(|gain| !(gain.is_finite() && *gain > 0.0)) {
            let message = format!("{} gains do not form a map of {columns} × {rows} points", gains.len());
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
}
