//! Shape of the pixels and the part of the sensor that sees light, as a sensor file states them, and checked.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use glam::DVec2;
use photosite_core::Invalid;
use photosite_core::cells::{CellLayout, CellShape, Hexagon, ImageCircle, REGULAR_ROWS};
use photosite_core::keys::Keys;

use super::checks::positive;

/// Shapes of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum CellShapeName {
    /// Rectangles in rows and columns.
    #[default]
    Rectangular,
    /// Hexagons: every second row, from the second on, lies half a pitch farther to the right. They are regular where
    /// the second number of pixel_pitch_um, the distance of rows, is 0.866 (√3/2) of the first.
    Hexagonal,
}

/// Beyond this part of the regular distance of rows, hexagons are not called regular: pitches are stated to three
/// digits.
const ROUNDED: f64 = 1e-3;

/// Layout of cells in these columns and rows. Keys of errors are those of the sensor file.
pub(super) fn cell_layout(
    shape: CellShapeName,
    image_circle_mm: Option<f64>,
    size: [usize; 2],
    pitch_m: [f64; 2],
) -> Result<CellLayout, Invalid> {
    let shape = match shape {
        CellShapeName::Rectangular => CellShape::Rectangular,
        CellShapeName::Hexagonal => CellShape::Hexagonal(Hexagon::new(pitch_m).ok_or_else(|| {
            let [x, y] = pitch_m.map(um);
            let message =
                format!("rows of hexagons lie at least half a pitch apart, and {y} µm is less than half of {x} µm");
            Invalid::new("pixel_pitch_um", message).help(format!("for regular ones write {}", regular(x)))
        })?),
    };
    let Some(diameter) = image_circle_mm else { return Ok(CellLayout { shape, image_circle: None }) };
    positive("image_circle_mm", diameter, "8.0")?;
    let circle = ImageCircle::new(diameter / 1e3, size, pitch_m);
    let cells = CellLayout { shape, image_circle: Some(circle) };
    if cells.sees_light(circle.centre_px) {
        return Ok(cells);
    }
    let message = format!("a circle of {diameter} mm is smaller than a pixel, so that none sees light");
    Err(Invalid::new("image_circle_mm", message)
        .help("write its diameter in millimetres, such as image_circle_mm = 8.0"))
}

/// Warnings about hexagons that are not regular, and about an image circle that covers nothing.
pub(super) fn warnings(cells: &CellLayout, size: [usize; 2], [pitch_m, rows_m]: [f64; 2]) -> Vec<String> {
    let mut warnings = Vec::new();
    let is_regular = (rows_m / pitch_m / REGULAR_ROWS - 1.0).abs() < ROUNDED;
    if cells.is_staggered() && !is_regular {
        let [x, y] = [pitch_m, rows_m].map(um);
        warnings.push(format!(
            "sensor.cells: rows {y} µm apart make hexagons of a pitch of {x} µm that are not regular; regular ones have \
             pixel_pitch_um = {}",
            regular(x)
        ));
    }
    let corner = DVec2::new(size[0] as f64 + 0.5, size[1] as f64);
    if cells.image_circle.is_some_and(|circle| circle.contains(DVec2::ZERO) && circle.contains(corner)) {
        warnings
            .push("sensor.image_circle_mm: the circle covers the whole sensor, so that it changes nothing".to_owned());
    }
    warnings
}

fn um(metres: f64) -> f64 {
    (metres * 1e9).round() / 1e3
}

/// The pitch of regular hexagons, as a sensor file states it.
fn regular(pitch_um: f64) -> String {
    format!("[{pitch_um}, {}]", (pitch_um * REGULAR_ROWS * 1e4).round() / 1e4)
}
