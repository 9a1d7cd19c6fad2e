//! Spot diagrams: the positions at which rays of a point land, by field and wavelength.

use std::fmt::Write;

use glam::DVec2;
use photosite_lens::Lens;

use super::compute::{InPosition, LINES};
use super::figures::PositionFigures;
use super::plots::COLOURS;

pub(super) const CAPTION: &str = "Rays of F (blue), d (green) and C (orange) around the chief ray of d; upwards is away from \
                                  the axis. The circle is the Airy disk of d at the traced f-number.";

/// Number of rays along a side of a diagram.
const ACROSS: u32 = 20;
/// Side of a diagram, in units of the drawing.
const SIDE: f64 = 220.0;

/// Spot diagrams as an `svg` element: one for every field, all at one scale.
pub(super) fn svg(lens: &Lens, in_position: &InPosition, position: &PositionFigures) -> String {
    let diagrams: Vec<Vec<Vec<DVec2>>> = position
        .fields
        .iter()
        .map(|field| {
            let chief = DVec2::new(0.0, field.chief.image_height_mm);
            let object = in_position.object(field.chief.field_deg.to_radians());
            let of_line = |(_, nm): (&str, f64)| {
                let points = lens.at(nm).spot_diagram(object, ACROSS);
                points.into_iter().map(|point| (point - chief) * 1e3).collect()
            };
            LINES.into_iter().map(of_line).collect()
        })
        .collect();
    let airy_um = 1.22 * LINES[1].1 * 1e-3 * position.working_f_number;
    let reach = diagrams.iter().flatten().flatten().map(|p| p.x.abs().max(p.y.abs())).fold(airy_um, f64::max);
    let scale_um = round_up(reach);
    let per_um = 0.46 * SIDE / scale_um;
    let width = SIDE * diagrams.len() as f64;
    let mut svg = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {}\">\n", SIDE + 30.0);
    for (i, (diagram, field)) in diagrams.iter().zip(&position.fields).enumerate() {
        let middle = DVec2::new((i as f64 + 0.5) * SIDE, 0.5 * SIDE);
        let half = scale_um * per_um;
        let _ = writeln!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"#e4e7ec\"/>",
            middle.x - half,
            middle.y - half,
            2.0 * half,
            2.0 * half
        );
        for (points, colour) in diagram.iter().zip(COLOURS) {
            let _ = write!(svg, "<g fill=\"#{:02x}{:02x}{:02x}\">", colour.0, colour.1, colour.2);
            for point in points {
                let place = middle + DVec2::new(point.x, -point.y) * per_um;
                let _ = write!(svg, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"1\"/>", place.x, place.y);
            }
            svg += "</g>\n";
        }
        let _ = writeln!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.2}\" fill=\"none\" stroke=\"#282c34\"/>",
            middle.x,
            middle.y,
            airy_um * per_um
        );
        let rms = field.spot_rms_all_um.map_or_else(String::new, |rms| format!(", rms {rms:.1} µm"));
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"14\" \
             fill=\"#5a606b\">{:.1}°{rms}</text>",
            middle.x,
            SIDE + 14.0,
            field.chief.field_deg
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"4\" y=\"{:.1}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#5a606b\">each square \
         is {} µm wide</text>",
        SIDE + 28.0,
        2.0 * scale_um
    );
    svg + "</svg>\n"
}

/// Next larger of 1, 2 and 5 times a power of ten.
fn round_up(x: f64) -> f64 {
    let power = 10f64.powf(x.max(1e-6).log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|step| step * power).into_iter().find(|step| *step >= x).unwrap_or(10.0 * power)
}
