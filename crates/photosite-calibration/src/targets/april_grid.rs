//! Kalibr's grids of AprilTags.

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::{counts, length, margin};
use super::markers::{Dictionary, MarkerStyle};
use super::{Ink, Target};
use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

/// Kalibr's aprilgrid: tags of the family 36h11 with a border of two bits and black squares where their corners meet.
/// As Kalibr has it, tags are numbered row by row from the bottom left, and the tags stand as AprilTag has them.
/// The origin is the bottom-left corner of the first tag; y points down all the same, so that the others have a
/// negative y.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct AprilGrid {
    /// Tags across and down (tagCols, tagRows). Left out: [6, 6].
    #[schemars(transform = within(1.0..))]
    pub tags: [u32; 2],
    /// Side of a tag with its border (tagSize), mm. Left out: 24.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub tag_mm: f64,
    /// Space between tags over their side (tagSpacing). Left out: 0.3.
    #[schemars(transform = within(0.05..=2.0))]
    pub spacing: f64,
    /// White around the squares, mm. Left out: as wide as the space between tags.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..=100_000.0))]
    pub margin_mm: Option<f64>,
}

impl Default for AprilGrid {
    fn default() -> Self {
        Self { tags: [6, 6], tag_mm: 24.0, spacing: 0.3, margin_mm: None }
    }
}

impl AprilGrid {
    /// The points are the corners of all tags in rows from the bottom, each from the left: Kalibr's order.
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let [across, down] = counts("tags", self.tags, 1)?;
        let side = length("tag_mm", self.tag_mm)?;
        if !(0.05..=2.0).contains(&self.spacing) {
            let message = format!("must lie between 0.05 and 2, got {}", self.spacing);
            return Err(Invalid::new("spacing", message).help("it is a part of the tag's side; Kalibr's own has 0.3"));
        }
        let gap = self.spacing * side;
        let margin = margin(self.margin_mm, gap)?;
        let dictionary = Dictionary::with("DICT_APRILTAG_36h11", across * down).map_err(|invalid| Invalid {
            key: "tags".to_owned(),
            help: None,
            ..invalid
        })?;
        // Where column i begins to the right, and where row i ends upwards.
        let along = |i: u32| f64::from(i) * (side + gap);
        let end = DVec2::new(along(across), along(down) - gap);
        let sheet = [DVec2::new(-gap - margin, -end.y - gap - margin), DVec2::new(end.x + margin, gap + margin)];
        let mut target = Target::sheet(sheet[0], sheet[1], vec![Ink::white(), Ink::black()]);
        for row in 0..=down {
            for column in 0..=across {
                target.add_square(DVec2::new(along(column) - gap, -along(row)), gap, 1);
            }
        }
        let style = MarkerStyle { side_m: side, border_bits: 2, turned: true, black: 1 };
        for row in 0..down {
            for column in 0..across {
                let top_left = DVec2::new(along(column), -along(row) - side);
                target.add_marker(&dictionary, row * across + column, top_left, style);
            }
        }
        for row in 0..2 * down {
            for column in 0..2 * across {
                let at = |i: u32| along(i / 2) + f64::from(i % 2) * side;
                target.add_next_point(DVec2::new(at(column), -at(row)));
            }
        }
        Ok(target)
    }
}
