//! HTML page about a lens.

use std::fmt::Write;

use photosite_lens::files::Reading;

use super::compute::{InPosition, Options, lenses};
use super::figures::{ABSORPTION, FirstOrderRow, LensFigures, PositionFigures};
use super::{plots, section, spots};
use photosite_measure::characterisation::report::html::{self, escaped, page};

/// HTML page about a lens: its cross-section with rays, its curves, spots and modulation transfer. It refers to nothing
/// outside itself.
pub(crate) fn html(reading: &Reading, figures: &LensFigures) -> String {
    let title = if figures.name.is_empty() { "Lens" } else { &figures.name };
    let mut body = format!("<h1>{}</h1>\n", escaped(title));
    let origin: Vec<String> = [("Patent", &figures.patent), ("Source", &figures.source), ("Licence", &figures.licence)]
        .into_iter()
        .filter_map(|(what, text)| Some(format!("{what}: {}", escaped(text.as_deref()?))))
        .collect();
    let _ = writeln!(body, "<p class=\"subtitle\">{}</p>", origin.join(" · "));
    for warning in &figures.warnings {
        let _ = writeln!(body, "<p><strong>Warning:</strong> {}</p>", escaped(warning));
    }
    // The stop of the figures: that of the first position tells how far it was closed.
    let options = Options { f_number: figures.f_number, position: figures.position.clone(), ..Options::default() };
    let lenses = lenses(reading, &options).unwrap_or_default();
    for ((of_file, lens), position) in lenses.iter().zip(&figures.positions) {
        let in_position = InPosition::new(*of_file, lens);
        if !position.label.is_empty() {
            let _ = writeln!(body, "<h2>{}</h2>", escaped(&position.label));
        }
        body += &html::conditions(&facts(position));
        let _ = writeln!(
            body,
            "<figure style=\"margin-top:1.4rem\"><figcaption><strong>Cross-section.</strong> Rays of d from {} \
             at {}; the stop is drawn thick.</figcaption>\n{}</figure>",
            position
                .object_distance_mm
                .map_or_else(|| "infinitely far".to_owned(), |mm| format!("{mm} mm before the lens")),
            section::angles(position),
            section::svg(lens, &in_position, position)
        );
        body += &html::figures(&plots::plots(position));
        let _ = writeln!(
            body,
            "<figure style=\"margin-top:1.4rem\"><figcaption><strong>Spots.</strong> {}</figcaption>\n{}</figure>",
            spots::CAPTION,
            spots::svg(lens, &in_position, position)
        );
        body += &stops(position);
    }
    body += &surfaces(figures);
    body += &notes("Assumed", &figures.assumed);
    body += &notes("Ignored", &figures.ignored);
    page(title, &body)
}

/// First-order figures, each with its label.
fn facts(position: &PositionFigures) -> Vec<(String, String)> {
    let d = &position.first_order[1];
    let by_line = |of: &dyn Fn(&FirstOrderRow) -> f64| {
        position.first_order.iter().map(|row| format!("{:.4}", of(row))).collect::<Vec<_>>().join(" / ")
    };
    let edge = position.fields.last();
    [
        ("Focal length at F / d / C", format!("{} mm", by_line(&|row| row.efl_mm))),
        ("Back focal length", format!("{} mm", by_line(&|row| row.bfl_mm))),
        ("f-number", format!("{:.3} (traced {:.3})", d.f_number, position.working_f_number)),
        ("Field", format!("±{:.2}°, {}", position.half_field_deg, position.field_from)),
        ("Image", format!("±{:.3} mm", edge.map_or(0.0, |edge| edge.chief.image_height_mm))),
        (
            "Entrance pupil",
            format!(
                "{:.3} mm behind the first vertex, {:.3} mm wide",
                d.entrance_pupil_mm, d.entrance_pupil_diameter_mm
            ),
        ),
        (
            "Exit pupil",
            format!("{:.3} mm behind the last vertex, {:.3} mm wide", d.exit_pupil_mm, d.exit_pupil_diameter_mm),
        ),
        ("First vertex to sensor", format!("{:.3} mm", position.length_mm)),
        ("Axial colour from F to C", format!("{:.4} mm", position.axial_colour_mm)),
        ("Sensor behind the paraxial focus", format!("{:.4} mm", position.defocus_mm)),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}

/// Table of relative illumination and spots at each stop.
fn stops(position: &PositionFigures) -> String {
    let head: Vec<String> =
        position.fields.iter().map(|field| format!("<th class=\"n\">{:.1}°</th>", field.chief.field_deg)).collect();
    let mut html = format!(
        "<h3>At each stop</h3>\n<table><thead><tr><th>relative illumination</th>{0}</tr></thead>\n<tbody>\n",
        head.concat()
    );
    for stop in &position.stops {
        let cells: String = stop.relative_illumination.iter().map(|x| format!("<td class=\"n\">{x:.3}</td>")).collect();
        let _ = writeln!(html, "<tr><th>f/{:.2}</th>{cells}</tr>", stop.f_number);
    }
    let _ = write!(
        html,
        "</tbody></table>\n<table style=\"margin-top:1.4rem\"><thead><tr><th>spot of F, d, C: rms in µm</th>{}</tr></thead>\n<tbody>\n",
        head.concat()
    );
    for stop in &position.stops {
        let cell = |x: &Option<f64>| {
            format!("<td class=\"n\">{}</td>", x.map_or_else(|| "–".to_owned(), |x| format!("{x:.1}")))
        };
        let _ = writeln!(
            html,
            "<tr><th>f/{:.2}</th>{}</tr>",
            stop.f_number,
            stop.spot_rms_um.iter().map(cell).collect::<String>()
        );
    }
    html + "</tbody></table>\n"
}

fn surfaces(figures: &LensFigures) -> String {
    let mut html =
        "<h2>Surfaces</h2>\n<table><thead><tr><th></th><th class=\"n\">radius mm</th><th class=\"n\">thickness mm</th>\
                    <th>glass</th><th class=\"n\">semi-aperture mm</th><th></th></tr></thead>\n<tbody>\n"
            .to_owned();
    for (i, surface) in figures.surfaces.iter().enumerate() {
        let number = |x: Option<f64>, none: &str| x.map_or_else(|| none.to_owned(), |x| format!("{x:.4}"));
        let mut shape = Vec::new();
        if surface.stop {
            shape.push("stop".to_owned());
        }
        if surface.conic != 0.0 {
            shape.push(format!("k = {}", surface.conic));
        }
        shape.extend(surface.asphere.iter().map(|(order, a)| format!("r<sup>{order}</sup> {a:e}")));
        let _ = writeln!(
            html,
            "<tr><td>{i}</td><td class=\"n\">{}</td><td class=\"n\">{:.4}</td><td>{}</td><td class=\"n\">{}</td><td>{}</td></tr>",
            number(surface.radius_mm, "flat"),
            surface.thickness_mm,
            escaped(surface.glass.as_deref().unwrap_or_default()),
            number(surface.semi_aperture_mm, ""),
            shape.join(", ")
        );
    }
    html += "</tbody></table>\n<h2>Glasses</h2>\n<table><thead><tr><th>glass</th><th class=\"n\">n_d</th><th class=\"n\">ν_d</th>\
             <th>index from</th></tr></thead>\n<tbody>\n";
    for glass in &figures.glasses {
        let _ = writeln!(
            html,
            "<tr><td>{}</td><td class=\"n\">{:.5}</td><td class=\"n\">{:.2}</td><td>{}</td></tr>",
            escaped(&glass.name),
            glass.nd,
            glass.vd,
            escaped(&glass.source)
        );
    }
    html + &format!("</tbody></table>\n<p>{ABSORPTION}</p>\n")
}

fn notes(title: &str, notes: &[String]) -> String {
    if notes.is_empty() {
        return String::new();
    }
    let items: String = notes.iter().map(|note| format!("<li>{}</li>\n", escaped(note))).collect();
    format!("<h2>{title}</h2>\n<ul>\n{items}</ul>\n")
}
