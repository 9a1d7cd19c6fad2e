//! ChArUco boards.

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::{counts, fits, length, margin};
use super::markers::{Dictionary, MarkerStyle};
use super::{Ink, Target};
use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

/// A ChArUco board, as OpenCV's CharucoBoard draws it since version 4.6. The origin is its top-left corner.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct Charuco {
    /// Squares across and down. Left out: [8, 6].
    #[schemars(transform = within(2.0..))]
    pub squares: [u32; 2],
    /// Side of a square, mm. Left out: 30.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub square_mm: f64,
    /// Side of a marker with its border, mm. Left out: 22.
    #[schemars(transform = within(0.01..100_000.0))]
    pub marker_mm: f64,
    /// OpenCV's name of the dictionary. Left out: "DICT_5X5_100".
    pub dictionary: String,
    /// White around it, mm. Left out: half as wide as a square.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..=100_000.0))]
    pub margin_mm: Option<f64>,
}

impl Default for Charuco {
    fn default() -> Self {
        let dictionary = "DICT_5X5_100".to_owned();
        Self { squares: [8, 6], square_mm: 30.0, marker_mm: 22.0, dictionary, margin_mm: None }
    }
}

impl Charuco {
    /// Markers lie in the white squares, numbered row by row. The points are the inner corners of the squares.
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let [across, down] = counts("squares", self.squares, 2)?;
        let side = length("square_mm", self.square_mm)?;
        let marker = length("marker_mm", self.marker_mm)?;
        fits("marker_mm", self.marker_mm, "square", self.square_mm)?;
        let margin = margin(self.margin_mm, side / 2.0)?;
        let dictionary = Dictionary::with(&self.dictionary, across * down / 2)?;
        let corner = |column: u32, row: u32| DVec2::new(column.into(), row.into()) * side;
        let mut target =
            Target::sheet(DVec2::splat(-margin), corner(across, down) + margin, vec![Ink::white(), Ink::black()]);
        target.add_squares([across, down], corner);
        let style = MarkerStyle { side_m: marker, border_bits: 1, turned: false, black: 1 };
        let white = (0..down).flat_map(|row| ((row + 1) % 2..across).step_by(2).map(move |column| (column, row)));
        for (id, (column, row)) in (0..).zip(white) {
            target.add_marker(&dictionary, id, corner(column, row) + (side - marker) / 2.0, style);
        }
        for row in 1..down {
            for column in 1..across {
                target.add_next_point(corner(column, row));
            }
        }
        Ok(target)
    }
}
