//! Passing light, and where it lands.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use photosite_core::math::philox::Philox;
use photosite_lens::Ray;
use photosite_lens::chief_map::ChiefMap;
use photosite_lens::entrance_table::EntranceTable;
use photosite_lens::prescription::Blades;
use photosite_lens::pupil_table::PupilTable;
use photosite_lens::spots::{ObjectPoint, Spot};
use photosite_lens::trace::Apertures;
use rand::RngExt;

use crate::neutral::{Case, cases, cases_with, close, number, numbers};

/// Wavelengths of a table.
const TABLE_NM: [f64; 5] = [400.0, 475.0, 550.0, 625.0, 700.0];
/// Number of rays of each case.
const RAYS: u32 = 39_000;

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

/// Grids of 41 × 41 rays on the plane of the first vertex, of which the same number pass.
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
                let landed: Vec<(DVec2, f64)> =
                    rays.filter_map(|ray| Some((at.landing(ray, Apertures::Clip)?, 1.0))).collect();
                let what = format!("{name}, {nm} nm, {field}°");
                let spot = Spot::of(&landed).unwrap_or_else(|| panic!("{what}: dark"));
                assert_eq!(spot.rays as u64, spots["optiland"]["rays"][j][i].as_u64().expect("a count"), "{what}");
                close(&what, spot.rms_mm * 1e3, number(&spots["optiland"]["rms_um"][j][i]), 1e-6);
                close(&what, spot.centroid_mm.y, number(&spots["optiland"]["centroid_mm"][j][i]), 1e-9);
            }
        }
    }
}

/// Quadrature over the pupil agrees with a grid of rays, which counts cells that the edge cuts as whole or not at all:
/// 4·300 of π/4·300² cells at most, by half.
#[test]
fn spots_by_quadrature_are_those_of_many_rays() {
    for (name, distance) in [("double-gauss", f64::INFINITY), ("canon-ef50", 700.0), ("canon-rf24", 400.0)] {
        let lens = photosite_lens::files::shipped(name).expect("ships").lens;
        let at = lens.at(587.5618);
        for degrees in [0.0_f64, 8.0, 16.0] {
            let chief = at.chief_ray(degrees.to_radians()).expect("a chief ray");
            let object = ObjectPoint::on(&chief, distance);
            let rms = |points: &[(DVec2, f64)]| Spot::of(points).expect("light").rms_mm;
            let found = rms(&at.spot(object, 48));
            let grid: Vec<_> = at.spot_diagram(object, 300).into_iter().map(|point| (point, 1.0)).collect();
            close(&format!("{name} {degrees}°"), found / rms(&grid), 1.0, 0.5 * 4.0 * 300.0 / (0.25 * PI * 9e4));
        }
    }
}

/// Rays drawn by the table mostly pass, and none passes beyond it: of as many, half close to its edge, half up to four
/// times as far out. The lens is open or stopped down to 0.35, the rays from the axis to the corner, at any wavelength.
fn the_pupil_table_draws_what_passes_and_misses_nothing(blades: Option<Blades>, rays: u32) {
    for Case { name, lens, figures, .. } in cases_with(blades) {
        // Of the zoom's positions the first and the last.
        if figures.get("spots").is_none() {
            continue;
        }
        let corner = number(&figures["image_half_diagonal_mm"]);
        for opening in [1.0, 0.35] {
            let lens = lens.with_stop_radius(opening * lens.stop_radius_mm());
            let table = PupilTable::new(&lens, corner, &TABLE_NM);
            let mut random = Philox::new(37, 0);
            let mut unit = || random.random::<f64>();
            let (mut drawn, mut passed) = (0_u32, 0_u32);
            for i in 0..rays {
                let point = DVec2::from_angle(unit() * std::f64::consts::TAU) * corner * unit();
                let at = lens.at(TABLE_NM[0] + unit() * (TABLE_NM[4] - TABLE_NM[0]));
                let Some(direction) = table.sample(point, [unit(), unit()]) else { continue };
                drawn += 1;
                passed += u32::from(at.passes(point, direction.cosines));
                let middle = table.sample(point, [0.0, 0.0]).expect("drawn from above").cosines;
                let edge = table.sample(point, [unit(), 1.0]).expect("drawn from above").cosines - middle;
                let beyond = middle + edge * (1.0 + 1e-9 + unit() * if i % 2 == 0 { 0.1 } else { 3.0 });
                let what = format!("{name} opened to {opening}: {beyond} from {point} at {} nm", at.wavelength_nm);
                assert!(!at.passes(point, beyond), "{what}");
                assert!(table.contains(point, direction.cosines) && !table.contains(point, beyond), "{what}");
            }
            let share = f64::from(passed) / f64::from(drawn);
            println!("{name} {opening}: {share:.4}");
            assert!(share >= 0.84, "{name} opened to {opening}: {share:.3} pass");
        }
    }
}

#[test]
fn of_a_round_stop_the_pupil_table_draws_what_passes() {
    the_pupil_table_draws_what_passes_and_misses_nothing(None, RAYS);
}

#[test]
fn of_a_stop_with_blades_the_pupil_table_draws_what_passes() {
    for (count, rotation_deg) in [(5, 10.0), (7, 0.0), (9, 33.0)] {
        the_pupil_table_draws_what_passes_and_misses_nothing(Some(Blades { count, rotation_deg }), RAYS / 3);
    }
}

/// Points drawn for scene points mostly lie on light that passes, and no light that reaches the image goes beside the
/// region they are drawn from: near and far, open and stopped down to 0.35, at any wavelength.
#[test]
fn the_entrance_table_draws_what_passes_and_misses_nothing() {
    for Case { name, lens, figures, .. } in cases() {
        if figures.get("spots").is_none() {
            continue;
        }
        let corner = number(&figures["image_half_diagonal_mm"]);
        for opening in [1.0, 0.35] {
            let lens = lens.with_stop_radius(opening * lens.stop_radius_mm());
            let pupil = PupilTable::new(&lens, corner, &TABLE_NM);
            let table = EntranceTable::new(&lens, &pupil, corner, &[TABLE_NM[0], TABLE_NM[2], TABLE_NM[4]]);
            let mut random = Philox::new(43, 0);
            let mut unit = || random.random::<f64>();
            let (mut drawn, mut passed) = (0_u32, 0_u32);
            for i in 0..RAYS {
                let place = DVec2::from_angle(unit() * std::f64::consts::TAU) * corner * unit();
                let at = lens.at(TABLE_NM[0] + unit() * (TABLE_NM[4] - TABLE_NM[0]));
                let Some(direction) = pupil.sample(place, [unit(), unit()]) else { continue };
                let Ok(out) = at.trace_out(at.ray_from_sensor(place, direction.cosines), Apertures::Clip) else {
                    continue;
                };
                // From the least distance to a hundred times as far, and farther.
                let far = table.least_distance_mm() * 100_f64.powf(unit()) * if i % 8 == 0 { 1e4 } else { 1.0 };
                let point = out.origin + out.direction * far;
                let what = format!("{name} opened to {opening}: {point} by {out:?} at {} nm", at.wavelength_nm);
                assert!(table.contains(point, -out.direction), "{what}");
                let met = lens.front_point(point, -out.direction).unwrap_or_else(|| panic!("{what}: passes by"));
                close(&what, met.distance(out.origin), 0.0, 1e-6);

                let entrance = table.sample(point, [unit(), unit()]).unwrap_or_else(|| panic!("{what}: dark"));
                let ray = Ray { origin: entrance.point, direction: (entrance.point - point).normalize() };
                assert!(table.contains(point, ray.direction), "{what}: {entrance:?}");
                drawn += 1;
                passed += u32::from(at.trace_in(ray, Apertures::Clip).is_ok());
            }
            let share = f64::from(passed) / f64::from(drawn);
            println!("{name} {opening}: {share:.4} of {drawn}");
            assert!(share >= 0.6, "{name} opened to {opening}: {share:.3} pass");
        }
    }
}

/// Curves through 512 chief rays agree with rays of their own to 1e-5 mm, 1/100 of a small pixel.
#[test]
fn the_chief_map_knows_what_a_place_looks_at_and_where_a_point_appears() {
    for Case { name, lens, wavelengths, figures } in cases() {
        let corner = number(&figures["image_half_diagonal_mm"]);
        let at = lens.at(wavelengths[1]);
        let map = ChiefMap::new(&at, corner).expect("chief rays");
        for i in 1..=37 {
            let height = corner * f64::from(i) / 37.0;
            let what = format!("{name}, {height} mm");
            let chief = at.chief_ray_at_height(height).expect("a chief ray");
            let point = DVec2::from_angle(0.3 * f64::from(i)) * height;
            let sighting = map.sighting(point).expect("known");
            // A change of the field angle moves the image by about the focal length times it.
            let scale = at.first_order().efl_mm;
            close(&what, map.field_rad(height).expect("known"), chief.field_rad, 1e-5 / scale);
            close(&what, sighting.pupil_mm, chief.entrance_pupil_mm(), 1e-3);
            for distance in [3.0 * lens.sensor_z_mm(), 1e5] {
                let seen = DVec3::new(0.0, 0.0, sighting.pupil_mm) + sighting.direction * distance;
                let place = map.place(seen).unwrap_or_else(|| panic!("{what}: {seen} has no place"));
                assert!(place.distance(point) < 2e-5, "{what}: {place} in place of {point}");
            }
        }
        let axis = map.sighting(DVec2::ZERO).expect("known");
        assert_eq!(axis.direction, DVec3::NEG_Z, "{name}");
        assert_eq!(map.sighting(DVec2::new(3.0 * corner, 0.0)), None, "{name}");
        assert_eq!(map.place(DVec3::new(0.0, 0.0, axis.pupil_mm + 10.0)), None, "{name}");
    }
}
