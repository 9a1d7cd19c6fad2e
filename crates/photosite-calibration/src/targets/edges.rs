//! Slanted edges, for the modulation transfer function.

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::{counts, length, margin};
use super::{Ink, Target};
use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

/// Reflectances of the light and the dark side of an edge: the contrast of 4:1 that [ISO
/// 12233](photosite_core::references#iso12233) asks of its slanted edges, at a level assumed here.
const LIGHT: f64 = 0.72;
const DARK: f64 = 0.18;

/// A dark square on a light sheet, turned a little. The origin is its middle.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct SlantedEdge {
    /// Side of the square, mm. Left out: 100.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub square_mm: f64,
    /// How far it is turned, degrees, clockwise. Left out: 5.
    #[schemars(transform = within(-44.5..=44.5))]
    pub angle_deg: f64,
    /// Light around it, mm. Left out: half as wide as the square.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..=100_000.0))]
    pub margin_mm: Option<f64>,
}

/// Dark squares in rows and columns, each turned a little, with a row of grey steps above and below.
/// The origin is the middle.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct EsfrChart {
    /// Squares across and down. Left out: [5, 3].
    #[schemars(transform = within(1.0..))]
    pub squares: [u32; 2],
    /// Side of a square, mm. Left out: 30.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub square_mm: f64,
    /// From middle to middle, mm. Left out: 60.
    #[schemars(transform = within(0.01..=100_000.0))]
    pub spacing_mm: f64,
    /// How far they are turned, degrees, clockwise. Left out: 5.
    #[schemars(transform = within(-44.5..=44.5))]
    pub angle_deg: f64,
    /// Grey steps in both rows together. Left out: 20.
    #[schemars(transform = within(2.0..))]
    pub grey_steps: u32,
}

impl Default for SlantedEdge {
    fn default() -> Self {
        Self { square_mm: 100.0, angle_deg: 5.0, margin_mm: None }
    }
}

impl Default for EsfrChart {
    fn default() -> Self {
        Self { squares: [5, 3], square_mm: 30.0, spacing_mm: 60.0, angle_deg: 5.0, grey_steps: 20 }
    }
}

/// Names of the corners of a square, clockwise in the image.
const CORNERS: [&str; 4] = ["top-left", "top-right", "bottom-right", "bottom-left"];

impl SlantedEdge {
    /// The points are the corners of the square.
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let side = length("square_mm", self.square_mm)?;
        let margin = margin(self.margin_mm, side / 2.0)?;
        let corners = turned_square(DVec2::ZERO, side, self.angle_deg)?;
        let half = corners.iter().map(|corner| corner.max_element()).fold(0.0, f64::max) + margin;
        let inks = vec![Ink::grey("light", LIGHT), Ink::grey("dark", DARK)];
        let mut target = Target::sheet(DVec2::splat(-half), DVec2::splat(half), inks);
        for (corner, name) in corners.iter().zip(CORNERS) {
            target.add_point(name, *corner);
        }
        target.add_polygon(corners, 1);
        Ok(target)
    }
}

impl EsfrChart {
    /// The points are the corners of the squares, row by row.
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let [across, down] = counts("squares", self.squares, 1)?;
        let side = length("square_mm", self.square_mm)?;
        let spacing = length("spacing_mm", self.spacing_mm)?;
        if spacing < 1.5 * side {
            let message =
                format!("{} mm leaves too little room between squares of {} mm", self.spacing_mm, self.square_mm);
            let help = format!("edges need light on their outer side: write at least {}", 1.5 * self.square_mm);
            return Err(Invalid::new("spacing_mm", message).help(help));
        }
        let [steps, rows] = counts("grey_steps", [self.grey_steps, 2], 2)?;
        if steps % rows != 0 {
            let message = format!("{steps} do not fill two rows");
            return Err(Invalid::new("grey_steps", message).help("write an even number"));
        }
        let size = DVec2::new(across.into(), down.into()) * spacing + DVec2::new(0.0, 2.0 * side);
        let mut target =
            Target::sheet(-size / 2.0, size / 2.0, vec![Ink::grey("light", LIGHT), Ink::grey("dark", DARK)]);
        for row in 0..down {
            for column in 0..across {
                let place = DVec2::new(column.into(), row.into()) + 0.5;
                let middle = place * spacing - size / 2.0 + DVec2::new(0.0, side);
                let corners = turned_square(middle, side, self.angle_deg)?;
                for (corner, name) in corners.iter().zip(CORNERS) {
                    target.add_point(format!("{column}.{row}.{name}"), *corner);
                }
                target.add_polygon(corners, 1);
            }
        }
        // Even steps of reflectance, from near white to near black, left to right, the darker half below.
        let per_row = steps / 2;
        for step in 0..steps {
            let reflectance = 0.9 - 0.88 * f64::from(step) / f64::from(steps - 1);
            let ink = target.inks.len();
            target.inks.push(Ink::grey(format!("grey-{:02}", step + 1), reflectance));
            let width = size.x / f64::from(per_row);
            let top = if step < per_row { -size.y / 2.0 } else { size.y / 2.0 - 0.75 * side };
            let left = f64::from(step % per_row) * width - size.x / 2.0;
            target.add_rectangle(DVec2::new(left, top), DVec2::new(left + width, top + 0.75 * side), ink);
        }
        Ok(target)
    }
}

/// Corners of a square, clockwise in the image from the top left.
fn turned_square(middle: DVec2, side: f64, angle_deg: f64) -> Result<Vec<DVec2>, Invalid> {
    if !(0.5..=44.5).contains(&angle_deg.abs()) {
        let message = format!("must lie between 0.5 and 44.5 either way, got {angle_deg}");
        return Err(
            Invalid::new("angle_deg", message).help("an edge along the pixels does not show anything; 5 is usual")
        );
    }
    let turn = DVec2::from_angle(angle_deg.to_radians());
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(DVec2::from_array);
    Ok(corners.iter().map(|corner| middle + turn.rotate(*corner * side)).collect())
}
