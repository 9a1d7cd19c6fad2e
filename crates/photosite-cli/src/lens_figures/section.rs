//! Cross-section of the lens along its axis, with rays.

use std::fmt::Write;

use glam::{DVec2, DVec3};
use photosite_lens::profile::Travel;
use photosite_lens::spots::ObjectPoint;
use photosite_lens::trace::{Apertures, Step};
use photosite_lens::{Lens, LensAt};

use super::compute::InPosition;
use super::figures::PositionFigures;
use super::plots::{COLOURS, shown_fields};
use photosite_core::spectrum::dispersion::lines;

/// Number of points of a drawn surface from rim to rim.
const POINTS: u32 = 48;
/// Number of directions in which the edge of a beam is searched, two of them in the plane of the drawing.
const DIRECTIONS: usize = 64;
/// Number of rays of a beam.
const RAYS: u32 = 7;

/// Angles of the beams that are drawn, as text.
pub(super) fn angles(position: &PositionFigures) -> String {
    let angles: Vec<String> =
        shown_fields(position).into_iter().map(|i| format!("{:.1}°", position.fields[i].chief.field_deg)).collect();
    angles.join(", ")
}

/// Cross-section of a lens as an `svg` element, whose unit is the mm.
pub(super) fn svg(lens: &Lens, in_position: &InPosition, position: &PositionFigures) -> String {
    let at = lens.at(lines::D);
    let rim = lens.surfaces().iter().map(|surface| surface.semi_aperture_mm).fold(0.0, f64::max);
    let edge = position.fields.last().map_or(0.0, |field| field.chief.image_height_mm.abs());
    let half_height = 1.08 * rim.max(edge);
    let sensor = lens.sensor_z_mm();
    let front = lens.surfaces().iter().map(|surface| sag(surface, surface.semi_aperture_mm) + surface.z_mm);
    // Light comes in from some way before the foremost glass.
    let before = front.fold(0.0, f64::min) - 0.12 * sensor;
    let width = sensor - before + 0.02 * sensor;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{:.4} {:.4} {:.4} {:.4}\" style=\"max-height:560px\">\n",
        before,
        -half_height,
        width,
        2.0 * half_height
    );
    // Lines stay as thin in every size.
    svg += "<g fill=\"none\" stroke-width=\"1\" style=\"vector-effect:non-scaling-stroke\">\n";
    let _ =
        writeln!(svg, "<path d=\"M{before:.4} 0H{sensor:.4}\" stroke=\"#b8bec8\" stroke-dasharray=\"8 4\" {THIN}/>");
    glasses(&mut svg, lens);
    for (i, colour) in shown_fields(position).into_iter().zip(COLOURS) {
        let colour = format!("#{:02x}{:02x}{:02x}", colour.0, colour.1, colour.2);
        for path in rays(&at, in_position.object(position.fields[i].chief.field_deg.to_radians()), before) {
            let _ = writeln!(svg, "<path d=\"{path}\" stroke=\"{colour}\" {THIN}/>");
        }
    }
    stop(&mut svg, lens, half_height);
    let _ = writeln!(
        svg,
        "<path d=\"M{sensor:.4} {:.4}V{:.4}\" stroke=\"#282c34\" {THICK}/>",
        -edge.max(0.2 * rim),
        edge.max(0.2 * rim)
    );
    svg + "</g>\n</svg>\n"
}

const THIN: &str = "vector-effect=\"non-scaling-stroke\"";
const THICK: &str = "stroke-width=\"3\" vector-effect=\"non-scaling-stroke\"";

fn sag(surface: &photosite_lens::lens::LensSurface, r: f64) -> f64 {
    surface.profile.sag(r * r).unwrap_or(0.0)
}

/// Draws every piece of glass: its two surfaces, joined at the rim of the wider one.
fn glasses(svg: &mut String, lens: &Lens) {
    for pair in lens.surfaces().windows(2) {
        let [front, back] = pair else { continue };
        if front.glass.is_none() {
            continue;
        }
        let rim = front.semi_aperture_mm.max(back.semi_aperture_mm);
        let curve = |surface: &photosite_lens::lens::LensSurface, sign: f64| {
            let semi = surface.semi_aperture_mm;
            let points = (0..=POINTS).map(|i| {
                let y = sign * semi * (2.0 * f64::from(i) / f64::from(POINTS) - 1.0);
                format!("{:.4} {:.4}", surface.z_mm + sag(surface, y.abs()), y)
            });
            let edge = surface.z_mm + sag(surface, semi);
            // From the rim of the piece to that of the surface, and on the other side back.
            let [start, end] = [-sign * rim, sign * rim].map(|y| format!("{edge:.4} {y:.4}"));
            std::iter::once(start).chain(points).chain(std::iter::once(end)).collect::<Vec<_>>().join("L")
        };
        let _ = writeln!(
            svg,
            "<path d=\"M{}L{}Z\" fill=\"#dbe8f4\" stroke=\"#5a7896\" {THIN}/>",
            curve(front, 1.0),
            curve(back, -1.0)
        );
    }
}

/// Draws the stop, from its rim outwards.
fn stop(svg: &mut String, lens: &Lens, half_height: f64) {
    let surface = &lens.surfaces()[lens.stop()];
    let radius = lens.stop_radius_mm();
    let z = surface.z_mm + sag(surface, radius);
    let outer = (1.6 * radius).min(half_height).max(1.15 * radius);
    for sign in [-1.0, 1.0] {
        let _ =
            writeln!(svg, "<path d=\"M{z:.4} {:.4}V{:.4}\" stroke=\"#282c34\" {THICK}/>", sign * radius, sign * outer);
    }
}

/// Paths of a beam's rays in the plane of the drawing, from `before` to the sensor.
fn rays(at: &LensAt, object: ObjectPoint, before: f64) -> Vec<String> {
    let Some(beam) = at.beam_of(object, DIRECTIONS) else { return Vec::new() };
    let [low, high] = beam.region.bounds();
    let path = |i: u32| {
        // Just within the rims, which cut off what lies on them.
        let part = 0.001 + 0.998 * f64::from(i) / f64::from(RAYS - 1);
        let ray = beam.ray(DVec2::new(0.0, low.y + part * (high.y - low.y)));
        let mut points: Vec<DVec3> = Vec::new();
        let steps = (0..at.lens.surfaces().len()).map(Step::refract);
        let out = at.trace(ray, Travel::ToSensor, steps, Apertures::Clip, |hit| points.push(hit.point)).ok()?;
        // The ray comes from further left than it starts; very oblique ones from above.
        let first = *points.first()?;
        let backwards = ray.direction / ray.direction.z.max(0.2);
        points.insert(0, first - backwards * (first.z - before).max(0.0));
        points.push(out.at_z(at.lens.sensor_z_mm()));
        // SVG counts y downwards, optics upwards.
        Some(format!("M{}", points.iter().map(|p| format!("{:.4} {:.4}", p.z, -p.y)).collect::<Vec<_>>().join("L")))
    };
    (0..RAYS).filter_map(path).collect()
}
