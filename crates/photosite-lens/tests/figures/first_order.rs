//! Focal lengths, pupils, chief rays and focus.

use photosite_lens::Lens;
use photosite_lens::focus::{Distance, FocusBy};

use crate::neutral::{Case, cases, close, list, number, numbers, prescription, read, wavelengths};

/// The data have twelve digits; positions of pupils differ by up to 1e-5 mm between the programs, which put infinity at
/// 1e10 mm.
#[test]
fn first_order_at_three_wavelengths() {
    for Case { name, lens, wavelengths, figures } in cases() {
        let expected = &figures["first_order"]["optiland"];
        for (i, &nm) in wavelengths.iter().enumerate() {
            let found = lens.at(nm).first_order();
            let relative = |key: &str, found: f64| {
                let expected = number(&expected[key][i]);
                close(&format!("{name}, {nm} nm, {key}"), found, expected, 1e-7 * expected.abs());
            };
            relative("efl_mm", found.efl_mm);
            relative("bfl_mm", found.bfl_mm);
            relative("entrance_pupil_diameter_mm", found.entrance_pupil_diameter_mm);
            relative("exit_pupil_diameter_mm", found.exit_pupil_diameter_mm);
            relative("f_number", found.f_number);
            for (key, found) in [("entrance_pupil_mm", found.entrance_pupil_mm), ("exit_pupil_mm", found.exit_pupil_mm)]
            {
                close(&format!("{name}, {nm} nm, {key}"), found, number(&expected[key][i]), 1e-4);
            }
        }
    }
}

#[test]
fn chief_rays_and_distortion_of_seven_fields() {
    for Case { name, lens, wavelengths, figures } in cases() {
        let (chief, fields) = (&figures["chief_rays"]["optiland"], numbers(&figures["chief_rays"]["field_deg"]));
        for (i, &nm) in wavelengths.iter().enumerate() {
            let at = lens.at(nm);
            let efl = at.first_order().efl_mm;
            for (j, field) in fields.iter().enumerate().skip(1) {
                let what = format!("{name}, {nm} nm, {field}°");
                let found = at.chief_ray(field.to_radians()).unwrap_or_else(|| panic!("{what}: no chief ray"));
                close(&what, found.image_height_mm, number(&chief["image_height_mm"][i][j]), 1e-6);
                let start = found.before.at_z(0.0).y;
                close(&what, start, number(&chief["height_at_first_vertex_plane_mm"][i][j]), 1e-6);
                let end = found.behind.direction.y;
                close(&what, end, number(&chief["direction_y_at_image"][i][j]), 1e-9);
                // The way back finds the same ray.
                let back = at.chief_ray_at_height(found.image_height_mm).expect("the same ray");
                close(&what, back.field_rad, found.field_rad, 1e-9);
                if let Some(expected) = figures.get("distortion_percent") {
                    close(&what, found.distortion_percent(efl), number(&expected["optiland"][i][j]), 1e-6);
                }
            }
        }
    }
}

#[test]
fn focus_of_the_whole_lens_to_first_order() {
    for Case { name, lens, wavelengths, figures } in cases() {
        for focus in figures.get("unit_focus").map_or(&[][..], |all| list(all)) {
            let distance = number(&focus["object_distance_from_first_vertex_mm"]);
            let at = Distance::FromFirstVertex(distance);
            let focused = lens.focused_paraxially(FocusBy::WholeLens, at, wavelengths[1]).expect("in reach");
            let gap = focused.gap_mm(lens.surfaces().len() - 1);
            close(&format!("{name} at {distance} mm"), gap, number(&focus["optiland"]["last_gap_mm"]), 1e-8);
            let magnification = focused.at(wavelengths[1]).image(distance).magnification;
            close(&name, magnification, number(&focus["optiland"]["magnification"]), 1e-10);
        }
    }
}

#[test]
fn focus_of_the_zoom_by_its_front_group() {
    let file = read("zoom-laikin");
    let prescription = prescription(&file);
    let lens = Lens::new(&prescription).expect("a lens");
    let nm = wavelengths(&file["figures"])[1];
    for (focus, position) in list(&file["figures"]["group_focus"]).iter().zip(&prescription.positions) {
        // The sensor where the paraxial image of infinity is.
        let lens = lens.in_position(position);
        let lens = lens.focused_paraxially(FocusBy::WholeLens, Distance::Infinity, nm).expect("in reach");
        let distance = number(&focus["object_distance_from_first_vertex_mm"]);
        let focused =
            lens.focused_paraxially(FocusBy::FrontGroup(4), Distance::FromFirstVertex(distance), nm).expect("in reach");
        let what = &position.label;
        close(what, focused.gap_mm(4) - lens.gap_mm(4), number(&focus["optiland"]["shift_mm"]), 1e-8);
        let magnification = focused.at(nm).image(distance).magnification;
        close(what, magnification, number(&focus["optiland"]["magnification"]), 1e-9);
        close(what, lens.at(nm).first_order().efl_mm, number(&focus["efl_at_infinity_mm"]), 1e-6);
        close(what, focused.at(nm).first_order().efl_mm, number(&focus["efl_when_focused_mm"]), 1e-6);
    }
}
