//! Grids of circles and dots.

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::{counts, fits, length, margin};
use super::{Ink, Target};
use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

/// Circles in rows and columns. The origin is the first.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct CircleGrid {
    /// Circles across and down. Left out: [9, 7].
    #[schemars(transform = within(2.0..))]
    pub circles: [u32; 2],
    /// From middle to middle, mm. Left out: 20.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub spacing_mm: f64,
    /// Diameter of a circle, mm. Left out: 12.
    #[schemars(transform = within(0.01..100_000.0))]
    pub diameter_mm: f64,
    /// White from the outer middles to the edge of the sheet, mm. Left out: as much as the spacing.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.01..=100_000.0))]
    pub margin_mm: Option<f64>,
}

/// Circles in rows, every other of which is shifted by half a spacing of its circles. The origin is the first.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct AsymmetricCircleGrid {
    /// Circles in a row, and rows. Left out: [4, 11].
    #[schemars(transform = within(2.0..))]
    pub circles: [u32; 2],
    /// From row to row, mm; within a row, circles are twice as far apart. Left out: 20.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub spacing_mm: f64,
    /// Diameter of a circle, mm. Left out: 15.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub diameter_mm: f64,
    /// White from the outer middles to the edge of the sheet, mm. Left out: twice the spacing.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.01..=100_000.0))]
    pub margin_mm: Option<f64>,
}

/// Many small dots. The origin is the one in the middle.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct DotChart {
    /// Dots across and down, odd numbers. Left out: [25, 17].
    #[schemars(transform = within(3.0..))]
    pub dots: [u32; 2],
    /// From middle to middle, mm. Left out: 10.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub spacing_mm: f64,
    /// Diameter of a dot, mm. Left out: 5.
    #[schemars(transform = within(0.01..100_000.0))]
    pub diameter_mm: f64,
    /// White from the outer middles to the edge of the sheet, mm. Left out: as much as the spacing.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.01..=100_000.0))]
    pub margin_mm: Option<f64>,
}

impl Default for CircleGrid {
    fn default() -> Self {
        Self { circles: [9, 7], spacing_mm: 20.0, diameter_mm: 12.0, margin_mm: None }
    }
}

impl Default for AsymmetricCircleGrid {
    fn default() -> Self {
        Self { circles: [4, 11], spacing_mm: 20.0, diameter_mm: 15.0, margin_mm: None }
    }
}

impl Default for DotChart {
    fn default() -> Self {
        Self { dots: [25, 17], spacing_mm: 10.0, diameter_mm: 5.0, margin_mm: None }
    }
}

impl CircleGrid {
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let [across, down] = counts("circles", self.circles, 2)?;
        let spacing = length("spacing_mm", self.spacing_mm)?;
        fits("diameter_mm", self.diameter_mm, "spacing", self.spacing_mm)?;
        let margin = margin(self.margin_mm, spacing)?;
        let places = grid([across, down]).map(|place| place * spacing);
        discs(places, self.diameter_mm, margin)
    }
}

impl AsymmetricCircleGrid {
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let [across, down] = counts("circles", self.circles, 2)?;
        let spacing = length("spacing_mm", self.spacing_mm)?;
        // Neighbours are a diagonal apart.
        fits("diameter_mm", self.diameter_mm, "distance between circles", self.spacing_mm * 2f64.sqrt())?;
        let margin = margin(self.margin_mm, 2.0 * spacing)?;
        let places = grid([across, down]).map(|place| DVec2::new(2.0 * place.x + place.y % 2.0, place.y) * spacing);
        discs(places, self.diameter_mm, margin)
    }
}

impl DotChart {
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let [across, down] = counts("dots", self.dots, 3)?;
        if across % 2 == 0 || down % 2 == 0 {
            let message = format!("{across} across and {down} down have none in the middle");
            return Err(Invalid::new("dots", message).help("write odd numbers, for example [25, 17]"));
        }
        let spacing = length("spacing_mm", self.spacing_mm)?;
        fits("diameter_mm", self.diameter_mm, "spacing", self.spacing_mm)?;
        let margin = margin(self.margin_mm, spacing)?;
        let middle = DVec2::new((across / 2).into(), (down / 2).into());
        discs(grid([across, down]).map(|place| (place - middle) * spacing), self.diameter_mm, margin)
    }
}

/// Columns and rows, row by row.
fn grid([across, down]: [u32; 2]) -> impl Iterator<Item = DVec2> {
    (0..down).flat_map(move |row| (0..across).map(move |column| DVec2::new(column.into(), row.into())))
}

/// Black discs, whose middles are the points.
fn discs(places: impl Iterator<Item = DVec2>, diameter_mm: f64, margin: f64) -> Result<Target, Invalid> {
    let radius = length("diameter_mm", diameter_mm)? / 2.0;
    if margin <= radius {
        let message = format!("{} mm from the outer middles are within the circles", margin * 1e3);
        return Err(Invalid::new("margin_mm", message).help(format!("write more than {}", radius * 1e3)));
    }
    let places: Vec<DVec2> = places.collect();
    let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    let mut target = Target::sheet(low - margin, high + margin, vec![Ink::white(), Ink::black()]);
    for place in places {
        target.add_disc(place, radius, 1);
        target.add_next_point(place);
    }
    Ok(target)
}
