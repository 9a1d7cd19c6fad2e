//! Figures of a lens as text.

use std::fmt::Write;

use photosite_core::shorten::shorten_name;

use super::figures::{ABSORPTION, FieldFigures, LensFigures, PositionFigures};
use super::mtf::TOLD_PER_MM;

impl LensFigures {
    /// Figures as text for people, without a line break at its end.
    pub(crate) fn text(&self) -> String {
        text(self)
    }
}

fn text(lens: &LensFigures) -> String {
    let mut text = String::new();
    let name = if lens.name.is_empty() { "a lens without a name" } else { &lens.name };
    let _ = writeln!(text, "{name}, read as {}", lens.format);
    for (what, value) in [("source", &lens.source), ("licence", &lens.licence), ("patent", &lens.patent)] {
        if let Some(value) = value {
            let _ = writeln!(text, "{what:8}  {value}");
        }
    }
    surfaces(&mut text, lens);
    let glasses = lens.glasses.iter().map(|glass| {
        let range = glass.range_nm.map_or_else(|| "–".to_owned(), |[from, to]| format!("{from}–{to} nm"));
        let behind: Vec<String> = glass.surfaces.iter().map(usize::to_string).collect();
        vec![
            glass.name.clone(),
            behind.join(", "),
            format!("{:.5}", glass.nd),
            format!("{:.2}", glass.vd),
            range,
            glass.source.clone(),
        ]
    });
    text += "\nGlasses\n";
    table(&mut text, &["glass", "behind", "n_d", "ν_d", "fitted to", "index from"], &glasses.collect::<Vec<_>>());
    let _ = writeln!(text, "{ABSORPTION}");
    for position in &lens.positions {
        self::position(&mut text, position);
    }
    for (title, notes) in [("Assumed", &lens.assumed), ("Ignored", &lens.ignored), ("Warnings", &lens.warnings)] {
        if !notes.is_empty() {
            let _ = write!(
                text,
                "\n{title}\n{}\n",
                notes.iter().map(|note| format!("- {note}")).collect::<Vec<_>>().join("\n")
            );
        }
    }
    text.trim_end().to_owned()
}

fn surfaces(text: &mut String, lens: &LensFigures) {
    let rows: Vec<Vec<String>> = lens
        .surfaces
        .iter()
        .enumerate()
        .map(|(i, surface)| {
            let mut shape = Vec::new();
            if surface.stop {
                shape.push("stop".to_owned());
            }
            if surface.conic != 0.0 {
                shape.push(format!("k = {}", surface.conic));
            }
            shape.extend(surface.asphere.iter().map(|(order, a)| format!("r^{order} {a:e}")));
            vec![
                i.to_string(),
                surface.radius_mm.map_or_else(|| "flat".to_owned(), |radius| format!("{radius:.4}")),
                format!("{:.4}", surface.thickness_mm),
                surface.glass.clone().unwrap_or_default(),
                surface.semi_aperture_mm.map_or_else(String::new, |radius| format!("{radius:.4}")),
                shape.join(", "),
            ]
        })
        .collect();
    *text += "\nSurfaces (mm)\n";
    table(text, &["", "radius", "thickness", "glass", "semi-aperture", ""], &rows);
}

fn position(text: &mut String, position: &PositionFigures) {
    let label = if position.label.is_empty() { String::new() } else { format!(" at {}", position.label) };
    let _ = writeln!(text, "\nFirst order{label} (mm)");
    let rows: Vec<Vec<String>> = position
        .first_order
        .iter()
        .map(|row| {
            let numbers = [
                row.efl_mm,
                row.bfl_mm,
                row.entrance_pupil_mm,
                row.entrance_pupil_diameter_mm,
                row.exit_pupil_mm,
                row.exit_pupil_diameter_mm,
            ];
            let mut cells = vec![format!("{} {:.1} nm", row.line, row.wavelength_nm)];
            cells.extend(numbers.map(|x| format!("{x:.4}")));
            cells.push(format!("{:.3}", row.f_number));
            cells
        })
        .collect();
    let head = [
        "line",
        "focal length",
        "back focus",
        "entrance pupil",
        "its diameter",
        "exit pupil",
        "its diameter",
        "f-number",
    ];
    table(text, &head, &rows);
    let _ = writeln!(
        text,
        "traced f/{:.3}, length {:.3} mm, axial colour F to C {:.4} mm, sensor {:.4} mm behind the paraxial focus",
        position.working_f_number, position.length_mm, position.axial_colour_mm, position.defocus_mm
    );
    let object =
        position.object_distance_mm.map_or_else(String::new, |mm| format!(", objects {mm} mm before the lens"));
    let _ = writeln!(text, "\nFields{label}{object}, ±{:.3}° {}", position.half_field_deg, position.field_from);
    let optional = |x: Option<f64>, digits: usize| x.map_or_else(|| "–".to_owned(), |x| format!("{x:.digits$}"));
    let rows: Vec<Vec<String>> = position
        .fields
        .iter()
        .map(|field| {
            vec![
                format!("{:.3}", field.chief.field_deg),
                format!("{:.4}", field.chief.image_height_mm),
                format!("{:.3}", field.chief.distortion_percent),
                format!("{:.4}", field.relative_illumination),
                optional(field.chief.lateral_colour_f_um, 2),
                optional(field.chief.lateral_colour_c_um, 2),
                optional(field.chief.tangential_focus_mm, 4),
                optional(field.chief.sagittal_focus_mm, 4),
                optional(field.spot_rms_um[0], 2),
                optional(field.spot_rms_um[1], 2),
                optional(field.spot_rms_um[2], 2),
                optional(field.spot_rms_all_um, 2),
                modulation(field, TOLD_PER_MM[0]),
                modulation(field, TOLD_PER_MM[1]),
            ]
        })
        .collect();
    let head = [
        "angle °",
        "height mm",
        "dist. %",
        "rel. ill.",
        "F µm",
        "C µm",
        "T mm",
        "S mm",
        "rms F µm",
        "d",
        "C",
        "all",
        "MTF 20 T/S",
        "40 T/S",
    ];
    table(text, &head, &rows);
    let _ = writeln!(text, "\nStops{label}: relative illumination, then rms of F, d, C in µm, by field");
    let rows: Vec<Vec<String>> = position
        .stops
        .iter()
        .map(|stop| {
            let mut cells = vec![format!("f/{:.2}", stop.f_number)];
            cells.extend(stop.relative_illumination.iter().map(|x| format!("{x:.3}")));
            cells.extend(stop.spot_rms_um.iter().map(|&x| optional(x, 1)));
            cells
        })
        .collect();
    let angles: Vec<String> = position.fields.iter().map(|field| format!("{:.1}°", field.chief.field_deg)).collect();
    let head: Vec<&str> = std::iter::once("").chain(angles.iter().chain(&angles).map(String::as_str)).collect();
    table(text, &head, &rows);
}

/// Modulation at d in and across the plane of the field.
fn modulation(field: &FieldFigures, frequency_per_mm: f64) -> String {
    let Some(mtf) = &field.mtf[1] else { return "–".to_owned() };
    let at = mtf.frequency_per_mm.iter().position(|known| *known == frequency_per_mm);
    at.map_or_else(String::new, |i| format!("{:.3}/{:.3}", mtf.tangential[i], mtf.sagittal[i]))
}

/// Table: rows below a line of names; columns of numbers are aligned to the right.
fn table(text: &mut String, head: &[&str], rows: &[Vec<String>]) {
    let head: Vec<String> = head.iter().map(|&cell| cell.to_owned()).collect();
    // A long name would make all rows as long.
    let rows: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(|cell| shorten_name(cell)).collect()).collect();
    let all: Vec<&Vec<String>> = std::iter::once(&head).chain(&rows).collect();
    let width = |i: usize| all.iter().map(|row| row.get(i).map_or(0, |cell| cell.chars().count())).max().unwrap_or(0);
    let is_number =
        |cell: &String| cell.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '–') || cell == "flat";
    let to_right: Vec<bool> =
        (0..head.len()).map(|i| rows.iter().all(|row| row.get(i).is_some_and(is_number))).collect();
    for row in &all {
        let cells = row.iter().enumerate().map(|(i, cell)| {
            let width = width(i);
            if to_right[i] { format!("{cell:>width$}") } else { format!("{cell:width$}") }
        });
        let _ = writeln!(text, "{}", cells.collect::<Vec<_>>().join("  ").trim_end());
    }
}
