//! Black level: the digital numbers of no light.

use super::Cfa;
use photosite_core::Invalid;
use serde::{Deserialize, Serialize};

/// Black level, the digital number of no light, pixel by pixel: that of its place in a tile, plus what its column and
/// its row add (DNG BlackLevel, BlackLevelDeltaH and BlackLevelDeltaV, [Dng16](photosite_core::references#dng16)).
///
/// Like those of a [`Cfa`], columns of the tile count numbers along a row. Everything begins at the top-left pixel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlackLevel {
    width: usize,
    tile: Vec<f32>,
    column_deltas: Vec<f32>,
    row_deltas: Vec<f32>,
    samples_per_pixel: usize,
}

impl BlackLevel {
    /// Black level that is the same for all pixels, DN.
    pub fn uniform(dn: f32) -> Self {
        let (column_deltas, row_deltas) = (Vec::new(), Vec::new());
        Self { width: 1, tile: vec![dn], column_deltas, row_deltas, samples_per_pixel: 1 }
    }

    /// A level for each channel, DN, in the order of the CFA's channels.
    pub fn of_channels(cfa: &Cfa, dn: &[f32]) -> Result<Self, Invalid> {
        if dn.len() != cfa.channels().len() {
            let message = format!("{} levels for the channels {}", dn.len(), cfa.channels().join(", "));
            return Err(Invalid::new("black_level_dn", message).help("give one for each channel"));
        }
        if dn.iter().all(|level| *level == dn[0]) {
            return Ok(Self::uniform(dn[0]));
        }
        let (width, height) = cfa.tile_size();
        Self::of_tile(width, (0..width * height).map(|i| dn[cfa.channel_at(i % width, i / width)]).collect())
    }

    /// A level for each place of a tile of `width` columns, DN, row by row.
    pub fn of_tile(width: usize, dn: Vec<f32>) -> Result<Self, Invalid> {
        if width == 0 || dn.is_empty() || !dn.len().is_multiple_of(width) || dn.iter().any(|level| !level.is_finite()) {
            let message = format!("{} levels do not form a tile of {width} columns", dn.len());
            return Err(Invalid::new("black_level_dn", message).help("give finite numbers, row by row"));
        }
        Ok(Self { width, tile: dn, ..Self::uniform(0.0) })
    }

    /// Adds the deltas of columns of pixels and of rows of the image, DN; empty for none.
    pub fn with_deltas(self, cfa: &Cfa, column_deltas: Vec<f32>, row_deltas: Vec<f32>) -> Self {
        Self { column_deltas, row_deltas, samples_per_pixel: cfa.samples_per_pixel(), ..self }
    }

    /// Black level of values that are (DN − low)·scale.
    pub fn on_scale(&self, low: f64, scale: f64) -> Self {
        let delta = |dn: &f32| (f64::from(*dn) * scale) as f32;
        Self {
            tile: self.tile.iter().map(|dn| ((f64::from(*dn) - low) * scale) as f32).collect(),
            column_deltas: self.column_deltas.iter().map(delta).collect(),
            row_deltas: self.row_deltas.iter().map(delta).collect(),
            ..*self
        }
    }

    /// The levels of a part of the image that begins at the pixel in column x, row y.
    pub fn from(&self, cfa: &Cfa, x: usize, y: usize) -> Self {
        let height = self.tile.len() / self.width;
        let first = x * cfa.samples_per_pixel();
        let level = |i: usize| self.tile[(y + i / self.width) % height * self.width + (first + i) % self.width];
        Self {
            tile: (0..self.tile.len()).map(level).collect(),
            column_deltas: self.column_deltas.get(x..).unwrap_or_default().to_vec(),
            row_deltas: self.row_deltas.get(y..).unwrap_or_default().to_vec(),
            width: self.width,
            samples_per_pixel: self.samples_per_pixel,
        }
    }

    /// The level of the x-th number of row y, DN.
    #[inline]
    pub fn at(&self, x: usize, y: usize) -> f32 {
        let height = self.tile.len() / self.width;
        let column = self.column_deltas.get(x / self.samples_per_pixel).copied().unwrap_or(0.0);
        let row = self.row_deltas.get(y).copied().unwrap_or(0.0);
        self.tile[y % height * self.width + x % self.width] + column + row
    }

    /// The level where it is the same for all, DN.
    pub fn as_uniform(&self) -> Option<f32> {
        let same = self.tile.iter().all(|level| *level == self.tile[0]);
        (same && self.column_deltas.is_empty() && self.row_deltas.is_empty()).then_some(self.tile[0])
    }

    /// The mean of the tile, DN: the level to reckon with where one number has to do.
    pub fn mean(&self) -> f32 {
        self.tile.iter().sum::<f32>() / self.tile.len() as f32
    }

    /// Tile size (columns, rows) and its levels, row by row, DN.
    pub fn tile(&self) -> ((usize, usize), &[f32]) {
        ((self.width, self.tile.len() / self.width), &self.tile)
    }

    /// Deltas of the columns, DN; empty for none.
    pub fn column_deltas(&self) -> &[f32] {
        &self.column_deltas
    }

    /// Deltas of the rows, DN; empty for none.
    pub fn row_deltas(&self) -> &[f32] {
        &self.row_deltas
    }
}

impl Default for BlackLevel {
    fn default() -> Self {
        Self::uniform(0.0)
    }
}

impl From<u16> for BlackLevel {
    fn from(dn: u16) -> Self {
        Self::uniform(dn.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tile_columns_and_rows_add_up() {
        let cfa = Cfa::parse("GRBG").expect("known");
        let level = BlackLevel::of_channels(&cfa, &[64.0, 60.0, 68.5]).expect("three channels");
        assert_eq!(
            [(0, 0), (1, 0), (0, 1), (1, 1), (7, 2)].map(|(x, y)| level.at(x, y)),
            [60.0, 64.0, 68.5, 60.0, 64.0]
        );
        assert_eq!((level.as_uniform(), level.mean()), (None, 63.125));
        let level = level.with_deltas(&cfa, vec![0.0, 0.5, 1.0], vec![-1.0, 2.0]);
        assert_eq!([(0, 0), (1, 0), (2, 1), (5, 5)].map(|(x, y)| level.at(x, y)), [59.0, 63.5, 71.5, 60.0]);
    }

    #[test]
    fn a_part_keeps_its_levels() {
        let cfa = Cfa::parse("RGGB").expect("known");
        let level = BlackLevel::of_tile(2, vec![1.0, 2.0, 3.0, 4.0]).expect("a tile");
        let level = level.with_deltas(&cfa, vec![0.0, 10.0, 20.0, 30.0], vec![0.0, 100.0, 200.0]);
        let part = level.from(&cfa, 3, 1);
        assert!((0..6).all(|i| part.at(i % 3, i / 3) == level.at(3 + i % 3, 1 + i / 3)));
    }

    #[test]
    fn columns_are_of_pixels_where_pixels_have_several_numbers() {
        let cfa = Cfa::parse("full:RGB").expect("known");
        let level = BlackLevel::of_channels(&cfa, &[1.0, 2.0, 3.0]).expect("three channels");
        let level = level.with_deltas(&cfa, vec![10.0, 20.0], Vec::new());
        assert_eq!((0..6).map(|x| level.at(x, 9)).collect::<Vec<_>>(), [11.0, 12.0, 13.0, 21.0, 22.0, 23.0]);
    }

    #[test]
    fn what_is_no_tile_is_refused() {
        assert_eq!(BlackLevel::of_channels(&Cfa::mono(), &[8.0]), Ok(8.into()));
        assert!(BlackLevel::of_channels(&Cfa::mono(), &[]).is_err());
        assert!(BlackLevel::of_tile(2, vec![1.0; 3]).is_err());
        assert!(BlackLevel::of_tile(0, Vec::new()).is_err());
        assert!(BlackLevel::of_tile(1, vec![f32::NAN]).is_err());
    }
}
