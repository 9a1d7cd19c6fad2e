//! Chessboards.

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::{counts, length, margin};
use super::{Ink, Target};
use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

/// A chessboard. The origin is its first inner corner.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct Chessboard {
    /// Squares across and down. OpenCV counts the inner corners, one fewer each. With one number even and the other
    /// odd, there is only one way up. Left out: [10, 7].
    #[schemars(transform = within(2.0..))]
    pub squares: [u32; 2],
    /// Side of a square, mm. Left out: 25.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub square_mm: f64,
    /// White around it, mm. Left out: as wide as a square.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..=100_000.0))]
    pub margin_mm: Option<f64>,
}

impl Default for Chessboard {
    fn default() -> Self {
        Self { squares: [10, 7], square_mm: 25.0, margin_mm: None }
    }
}

impl Chessboard {
    /// The square at the top left is black.
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let [across, down] = counts("squares", self.squares, 2)?;
        let side = length("square_mm", self.square_mm)?;
        let margin = margin(self.margin_mm, side)?;
        let corner = |column: u32, row: u32| DVec2::new(f64::from(column) - 1.0, f64::from(row) - 1.0) * side;
        let mut target =
            Target::sheet(corner(0, 0) - margin, corner(across, down) + margin, vec![Ink::white(), Ink::black()]);
        target.add_squares([across, down], corner);
        for row in 1..down {
            for column in 1..across {
                target.add_next_point(corner(column, row));
            }
        }
        Ok(target)
    }
}

impl Target {
    /// The black squares of a chessboard, where `corner` says where its corners lie. The second ink is black.
    pub(super) fn add_squares(&mut self, [across, down]: [u32; 2], corner: impl Fn(u32, u32) -> DVec2) {
        for row in 0..down {
            for column in (row % 2..across).step_by(2) {
                self.add_rectangle(corner(column, row), corner(column + 1, row + 1), 1);
            }
        }
    }
}
