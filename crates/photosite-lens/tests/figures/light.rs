//! What passes, and where it lands.

use glam::{DVec2, DVec3};
use photosite_lens::Ray;
use photosite_lens::spots::Spot;
use photosite_lens::trace::Apertures;

use crate::neutral::{Case, cases, close, number, numbers};

/// Both programs agree to 2e-4 at equal azimuths, and their polygons of 360 corners are within 5e-5 of the region.
#[test]
fn projected_solid_angles_from_axis_to_corner() {
    for Case { name, lens, wavelengths, figures } in cases() {
        let heights = numbers(&figures["illumination"]["image_height_mm"]);
        for (i, &nm) in wavelengths.iter().enumerate() {
            for (j, &height) in heights.iter().enumerate() {
                let what = format!("{name}, {nm} nm, {height} mm");
                let expected = number(&figures["illumination"]["optiland"]["projected_solid_angle_sr"][i][j]);
                let region = lens.at(nm).pupil_region(height, 360).unwrap_or_else(|| panic!("{what}: dark"));
                close(&what, region.area() / expected, 1.0, 5e-4);
            }
        }
    }
}

/// 41 × 41 rays on the plane of the first vertex, of which the same number pass.
#[test]
fn spots_of_the_same_rays() {
    for Case { name, lens, wavelengths, figures } in cases() {
        let Some(spots) = figures.get("spots") else { continue };
        let (half, centre) = (numbers(&spots["e_mm"]), numbers(&spots["y0_mm"]));
        for (j, field) in numbers(&spots["field_deg"]).into_iter().enumerate() {
            let direction = DVec3::new(0.0, field.to_radians().sin(), field.to_radians().cos());
            for (i, &nm) in wavelengths.iter().enumerate() {
                let at = lens.at(nm);
                let place = |k: u32| half[j] * (f64::from(k) / 20.0 - 1.0);
                let rays = (0..41 * 41)
                    .map(|k| Ray { origin: DVec3::new(place(k % 41), centre[j] + place(k / 41), 0.0), direction });
                let landed: Vec<DVec2> = rays.filter_map(|ray| at.landing(ray, Apertures::Clip)).collect();
                let what = format!("{name}, {nm} nm, {field}°");
                let spot = Spot::of(&landed).unwrap_or_else(|| panic!("{what}: dark"));
                assert_eq!(spot.rays as u64, spots["optiland"]["rays"][j][i].as_u64().expect("a count"), "{what}");
                close(&what, spot.rms_mm * 1e3, number(&spots["optiland"]["rms_um"][j][i]), 1e-6);
                close(&what, spot.centroid_mm.y, number(&spots["optiland"]["centroid_mm"][j][i]), 1e-9);
            }
        }
    }
}
