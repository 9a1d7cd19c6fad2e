//! Siemens stars.

use std::f64::consts::TAU;

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::{counts, length, margin};
use super::{Ink, Target};
use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

/// A Siemens star: black sectors that meet in a point. The origin is there.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct SiemensStar {
    /// Pairs of black and white sectors. Left out: 36.
    #[schemars(transform = within(4.0..))]
    pub cycles: u32,
    /// mm. Left out: 180.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub diameter_mm: f64,
    /// White around it, mm. Left out: a tenth of the diameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..=100_000.0))]
    pub margin_mm: Option<f64>,
}

impl Default for SiemensStar {
    fn default() -> Self {
        Self { cycles: 36, diameter_mm: 180.0, margin_mm: None }
    }
}

/// Straight pieces of the outer circle, at least: they leave it by no more than 10⁻⁴ of the radius.
const PIECES: u32 = 256;

impl SiemensStar {
    /// The point is the middle.
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let [cycles, _] = counts("cycles", [self.cycles, 4], 4)?;
        let radius = length("diameter_mm", self.diameter_mm)? / 2.0;
        let half = radius + margin(self.margin_mm, radius / 5.0)?;
        let mut target = Target::sheet(DVec2::splat(-half), DVec2::splat(half), vec![Ink::white(), Ink::black()]);
        let pieces = PIECES.div_ceil(2 * cycles);
        let rim = |piece: u32| radius * DVec2::from_angle(f64::from(piece) * TAU / f64::from(2 * cycles * pieces));
        for cycle in 0..cycles {
            let first = 2 * cycle * pieces;
            let arc = (first..=first + pieces).map(rim);
            target.add_polygon(std::iter::once(DVec2::ZERO).chain(arc).collect(), 1);
        }
        target.add_point("middle", DVec2::ZERO);
        Ok(target)
    }
}
