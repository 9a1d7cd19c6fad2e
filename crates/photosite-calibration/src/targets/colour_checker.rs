//! The colour checker.

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::{length, margin};
use super::{Ink, Target};
use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;
use photosite_core::spectrum::library;

/// 24 patches in four rows of six on a dark board. The origin is the middle.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct ColourChecker {
    /// Side of a patch, mm. Left out: 40.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub patch_mm: f64,
    /// Between patches, mm. Left out: 6.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub gap_mm: f64,
    /// Board around the patches, mm. Left out: 14.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..=100_000.0))]
    pub margin_mm: Option<f64>,
}

impl Default for ColourChecker {
    fn default() -> Self {
        Self { patch_mm: 40.0, gap_mm: 6.0, margin_mm: None }
    }
}

/// Where the spectra of the patches stand in the library.
const SPECTRA: &str = "colour-checker/";
/// Patches in a row.
const COLUMNS: u32 = 6;
/// Reflectance of the board, assumed.
const BOARD: f64 = 0.03;

impl ColourChecker {
    /// The points are the middles of the patches, named as their spectra.
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let side = length("patch_mm", self.patch_mm)?;
        let pitch = side + length("gap_mm", self.gap_mm)?;
        let margin = margin(self.margin_mm, 0.014)?;
        let mut names: Vec<&str> = library::reflectances().filter_map(|name| name.strip_prefix(SPECTRA)).collect();
        names.sort_unstable();
        let rows = names.len() as u32 / COLUMNS;
        let corner = |column: u32, row: u32| DVec2::new(column.into(), row.into()) * pitch;
        let end = corner(COLUMNS - 1, rows - 1) + side + margin;
        let mut target = Target::sheet(DVec2::splat(-margin), end, vec![Ink::grey("board", BOARD)]);
        for (i, name) in (0..).zip(names) {
            let top_left = corner(i % COLUMNS, i / COLUMNS);
            target.inks.push(Ink::named(name, &format!("{SPECTRA}{name}")));
            target.add_square(top_left, side, target.inks.len() - 1);
            target.add_point(name, top_left + side / 2.0);
        }
        Ok(target.centred())
    }
}
