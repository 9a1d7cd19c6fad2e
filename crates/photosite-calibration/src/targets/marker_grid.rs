//! Grids of markers.

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::{counts, length, margin};
use super::markers::{Dictionary, MarkerStyle};
use super::{Ink, Target};
use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

/// Markers in rows and columns, as OpenCV's GridBoard. The origin is the top-left corner of the first.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct MarkerGrid {
    /// Markers across and down. Left out: [5, 7].
    #[schemars(transform = within(1.0..))]
    pub markers: [u32; 2],
    /// Side of a marker with its border, mm. Left out: 30.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub marker_mm: f64,
    /// White between markers, mm. Left out: 6.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub separation_mm: f64,
    /// OpenCV's name of the dictionary; those of AprilTags begin with DICT_APRILTAG. Left out: "DICT_5X5_100".
    pub dictionary: String,
    /// Number of the first marker; the others follow row by row. Left out: 0.
    pub first_id: u32,
    /// Width of the black border around the bits of a marker, in bits. Left out: 1.
    #[schemars(transform = within(1.0..=8.0))]
    pub border_bits: u32,
    /// White around the grid, mm. Left out: half as wide as a marker.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..=100_000.0))]
    pub margin_mm: Option<f64>,
}

impl Default for MarkerGrid {
    fn default() -> Self {
        Self {
            markers: [5, 7],
            marker_mm: 30.0,
            separation_mm: 6.0,
            dictionary: "DICT_5X5_100".to_owned(),
            first_id: 0,
            border_bits: 1,
            margin_mm: None,
        }
    }
}

/// Wider borders than this leave no bits to be read.
const WIDEST_BORDER: u32 = 8;

impl MarkerGrid {
    /// The points are the corners of the markers, clockwise from the top left, marker by marker.
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let [across, down] = counts("markers", self.markers, 1)?;
        let side = length("marker_mm", self.marker_mm)?;
        let pitch = side + length("separation_mm", self.separation_mm)?;
        let margin = margin(self.margin_mm, side / 2.0)?;
        if !(1..=WIDEST_BORDER).contains(&self.border_bits) {
            let message = format!("must lie between 1 and {WIDEST_BORDER}, got {}", self.border_bits);
            return Err(Invalid::new("border_bits", message));
        }
        let dictionary = Dictionary::with(&self.dictionary, self.first_id.saturating_add(across * down))?;
        let corner = |column: u32, row: u32| DVec2::new(column.into(), row.into()) * pitch;
        let end = corner(across - 1, down - 1) + side + margin;
        let mut target = Target::sheet(DVec2::splat(-margin), end, vec![Ink::white(), Ink::black()]);
        let style = MarkerStyle { side_m: side, border_bits: self.border_bits, turned: false, black: 1 };
        for row in 0..down {
            for column in 0..across {
                target.add_marker(&dictionary, self.first_id + row * across + column, corner(column, row), style);
            }
        }
        for marker in target.markers.clone() {
            for (i, corner) in marker.corners_m.into_iter().enumerate() {
                target.add_point(format!("{}.{i}", marker.id), corner);
            }
        }
        Ok(target)
    }
}
