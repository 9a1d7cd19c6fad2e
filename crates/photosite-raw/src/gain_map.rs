//! The lens's falloff, which a developer can correct.

use photosite_core::Invalid;
use serde::{Deserialize, Serialize};

use super::AreaSpec;

/// Gains that make an evenly lit image even: points on an even grid over the active area, the outermost on its edges,
/// with straight lines in between.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GainMap {
    columns: usize,
    gains: Vec<f32>,
    /// Pixels that the map is for and the places of its points; `None` for a map of all pixels.
    reach: Option<Reach>,
}

/// The pixels that a gain map is for, and where its points lie (DNG's opcode GainMap): maps of telephones differ between
/// the places of a mosaic's tile, and so between its colours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// Pixels of the active area that the map covers.
    pub pixels: AreaSpec,
    /// Distance from one point to the next, across and down, in sides of the active area.
    pub spacing: [f64; 2],
    /// The first point, in sides of the active area.
    pub origin: [f64; 2],
    /// Gains at each point: one for each of a pixel's values, the last for all beyond.
    pub gains_per_point: usize,
}

/// Two points of a gain map along an axis with a place between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Between {
    /// Index of the point before the place.
    pub first: usize,
    /// Index of the point behind it.
    pub second: usize,
    /// Distance of the place from the first point, in those between the points.
    pub part: f32,
}

impl GainMap {
    /// Gains of all pixels, row by row from the top-left corner; they are finite and above 0.
    pub fn new(columns: usize, rows: usize, gains: Vec<f32>) -> Result<Self, Invalid> {
        Self::check(columns, rows, 1, &gains)?;
        Ok(Self { columns, gains, reach: None })
    }

    /// Gains of some pixels, point by point.
    pub fn of_some(columns: usize, rows: usize, gains: Vec<f32>, reach: Reach) -> Result<Self, Invalid> {
        Self::check(columns, rows, reach.gains_per_point, &gains)?;
        let numbers = reach.spacing.iter().chain(&reach.origin);
        if reach.pixels.pitch.contains(&0)
            || numbers.into_iter().any(|x| !x.is_finite())
            || reach.spacing.contains(&0.0)
        {
            return Err(Invalid::new("GainMap", "its points lie nowhere").help("the file is damaged"));
        }
        Ok(Self { columns, gains, reach: Some(reach) })
    }

    fn check(columns: usize, rows: usize, per_point: usize, gains: &[f32]) -> Result<(), Invalid> {
        let count = columns.checked_mul(rows).and_then(|points| points.checked_mul(per_point));
        let complete = columns > 0 && rows > 0 && per_point > 0 && count == Some(gains.len());
        if !complete || gains.iter().any(|gain| !(gain.is_finite() && *gain > 0.0)) {
            let message = format!("{} gains do not form a map of {columns} × {rows} points", gains.len());
            return Err(Invalid::new("GainMap", message).help("give finite numbers above 0"));
        }
        Ok(())
    }

    /// Points in a row.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Rows of points.
    pub fn rows(&self) -> usize {
        self.gains.len() / self.columns / self.gains_per_point()
    }

    /// The gains, row by row.
    pub fn gains(&self) -> &[f32] {
        &self.gains
    }

    /// Pixels that the map is for; `None` of a map for all.
    pub fn reach(&self) -> Option<&Reach> {
        self.reach.as_ref()
    }

    fn gains_per_point(&self) -> usize {
        self.reach.as_ref().map_or(1, |reach| reach.gains_per_point)
    }

    /// Whether the map has the same gains at the same points as another one, for whatever pixels.
    pub fn is_like(&self, other: &Self) -> bool {
        let points = |map: &Self| map.reach.as_ref().map(|reach| (reach.spacing, reach.origin, reach.gains_per_point));
        self.columns == other.columns && self.gains == other.gains && points(self) == points(other)
    }

    /// Whether the map covers pixels of this row of the active area.
    pub fn has_row(&self, y: usize) -> bool {
        self.reach.as_ref().is_none_or(|reach| reach.pixels.has_row(y))
    }

    /// Whether the map covers a value of the pixels of this column.
    pub fn has_number(&self, x: usize, plane: usize) -> bool {
        self.reach.as_ref().is_none_or(|reach| reach.pixels.has_number(x, plane))
    }

    /// Gain of the first of a pixel's values at a place of the active area, from 0, 0 at its top-left corner to 1, 1 at
    /// the opposite one.
    pub fn at(&self, x: f64, y: f64) -> f32 {
        self.at_plane(x, y, 0)
    }

    /// Gain of any of a pixel's values at a place of the active area, from 0, 0 at its top-left corner to 1, 1 at the
    /// opposite one.
    pub fn at_plane(&self, x: f64, y: f64, plane: usize) -> f32 {
        let (across, down) = (self.between(0, x), self.between(1, y));
        let mix = |a: f32, b: f32, part: f32| a + (b - a) * part;
        let gain = |column: usize, row: usize| self.gains[self.index(column, row, plane)];
        let row = |row: usize| mix(gain(across.first, row), gain(across.second, row), across.part);
        mix(row(down.first), row(down.second), down.part)
    }

    /// Points on both sides of a place along an axis, 0 for columns and 1 for rows, from 0 at the first edge of the
    /// active area to 1 at the opposite one.
    #[inline]
    pub fn between(&self, axis: usize, place: f64) -> Between {
        let points = if axis == 0 { self.columns() } else { self.rows() };
        let position = match &self.reach {
            Some(reach) => (place - reach.origin[axis]) / reach.spacing[axis],
            None => place.clamp(0.0, 1.0) * (points - 1) as f64,
        };
        let position = position.clamp(0.0, (points - 1) as f64);
        let first = (position as usize).min(points.saturating_sub(2));
        Between { first, second: (first + 1).min(points - 1), part: (position - first as f64) as f32 }
    }

    /// Index into [`Self::gains`] of the gain at a point for one of a pixel's values.
    #[inline]
    pub fn index(&self, column: usize, row: usize, plane: usize) -> usize {
        let per_point = self.gains_per_point();
        (row * self.columns + column) * per_point + plane.min(per_point - 1)
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
