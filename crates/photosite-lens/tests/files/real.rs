//! Files that programs wrote, and what Optiland 0.6.3 and ray-optics 0.9.8 make of them.

use std::path::Path;

use photosite_core::spectrum::dispersion::lines;
use photosite_lens::files::{Format, Reading, read};

use super::reference;

fn data(name: &str) -> Reading {
    let path = format!("{}/tests/files/data/{name}", env!("CARGO_MANIFEST_DIR"));
    let bytes = std::fs::read(&path).expect("committed");
    read(&bytes, Path::new(&path)).unwrap_or_else(|error| panic!("{error}"))
}

fn efl(reading: &Reading) -> f64 {
    reading.lens.at(lines::D).first_order().efl_mm
}

#[test]
fn opticstudio_in_utf16_with_fields_and_an_f_number() {
    let reading = data("double-gauss-1888.zmx");
    assert_eq!(reading.report.format, Format::Zmx);
    let at = reading.lens.at(lines::D);
    let first_order = at.first_order();
    // Both programs read 49.388975846763 mm; ray-optics has 41.60051190450 mm behind the last vertex.
    assert!((first_order.efl_mm - 49.388975846763).abs() < 1e-9, "{first_order:?}");
    assert!((first_order.bfl_mm - 41.60051190450).abs() < 1e-9, "{first_order:?}");
    assert!((first_order.f_number - 4.5).abs() < 1e-9, "{first_order:?}");
    // Optiland's chief rays, at 17° and 24° in F, d, C; its d is 587.5618 nm, too.
    for (angle, heights) in [
        (17.0_f64, [15.40015196508141, 15.397609522688036, 15.39649278186393]),
        (24.0, [22.558500521359115, 22.552515655688964, 22.549896486281984]),
    ] {
        for (line, height) in [486.1327, 587.5618, 656.2725].into_iter().zip(heights) {
            let chief = reading.lens.at(line).chief_ray(angle.to_radians()).expect("a chief ray");
            assert!((chief.image_height_mm - height).abs() < 1e-6, "{angle}° {line}: {}", chief.image_height_mm);
        }
    }
    assert_eq!(reading.prescription.patent.as_deref(), Some("583336"));
    assert_eq!(reading.prescription.surfaces.len(), 11, "{:?}", reading.report.ignored);
    assert!(reading.report.ignored.iter().any(|note| note.contains("SURF 1")), "{:?}", reading.report.ignored);
}

#[test]
fn code_v_with_the_defocus_on_its_image() {
    let (reading, reference) = (data("double-gauss.seq"), reference("double-gauss"));
    // The reference has radii of ten digits for the file's curvatures.
    assert!((efl(&reading) - efl(&reference)).abs() < 1e-8, "{} {}", efl(&reading), efl(&reference));
    for (read, reference) in reading.prescription.surfaces.iter().zip(&reference.prescription.surfaces) {
        let [a, b] = [read, reference].map(|surface| surface.radius_mm.map_or(0.0, f64::recip));
        assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} {b}");
        assert!((read.thickness_mm - reference.thickness_mm).abs() < 1e-9, "{read:?}");
        assert_eq!(read.glass.as_ref().map(|glass| &glass.name), reference.glass.as_ref().map(|glass| &glass.name));
    }
    // EPD 50: half of it over the magnification to the stop, by both programs' pupils.
    let first_order = reading.lens.at(lines::D).first_order();
    assert!((first_order.entrance_pupil_diameter_mm - 50.0).abs() < 1e-9);
    let told = |what: &str| reading.report.assumed.iter().any(|note| note.contains(what));
    assert!(told("defocus") && told("apertures"), "{:?}", reading.report.assumed);
    // Without vignetting the beam of 14° would need more than the 29.4 mm of the first surface.
    let first = reading.prescription.surfaces[0].semi_aperture_mm.expect("derived");
    assert!((29.0..30.0).contains(&first), "{first}");
}

#[test]
fn optiland_with_glasses_by_paths_of_its_author() {
    let (reading, reference) = (data("cooke-triplet.optiland.json"), reference("cooke-triplet"));
    assert_eq!(reading.report.format, Format::Optiland);
    assert!((efl(&reading) - efl(&reference)).abs() < 1e-9);
    for (read, reference) in reading.prescription.surfaces.iter().zip(&reference.prescription.surfaces) {
        assert_eq!(read.radius_mm, reference.radius_mm);
        assert!((read.thickness_mm - reference.thickness_mm).abs() < 1e-9, "{read:?}");
        assert_eq!(read.glass.as_ref().map(|g| &g.dispersion), reference.glass.as_ref().map(|g| &g.dispersion));
        assert_eq!(read.is_stop, reference.is_stop);
    }
    let stop = reading.lens.stop_radius_mm();
    // An EPD of 10 mm; the reference rounds it to five digits.
    assert!((stop - 3.80456).abs() < 1e-5, "{stop}");
    // What clears the beam of 20° is wider than what the reference clears, 14°.
    let [a, b] = [&reading, &reference].map(|r| r.prescription.surfaces[0].semi_aperture_mm.expect("derived"));
    assert!(a > b + 1.0, "{a} {b}");
}

#[test]
fn ray_optics_with_odd_orders_and_a_conic_constant_plus_one() {
    let (reading, reference) = (data("phone.roa"), reference("phone-us7535658"));
    assert_eq!(reading.report.format, Format::RayOptics);
    assert!((efl(&reading) - efl(&reference)).abs() < 1e-9);
    for (read, reference) in reading.prescription.surfaces.iter().zip(&reference.prescription.surfaces) {
        assert!((read.conic - reference.conic).abs() < 1e-12);
        assert_eq!(read.asphere, reference.asphere);
        let [a, b] = [read, reference].map(|surface| surface.semi_aperture_mm.expect("given"));
        assert!((a - b).abs() < 1e-7, "{a} {b}");
    }
    assert_eq!(reading.prescription.patent.as_deref(), Some("7,535,658"));
    assert_eq!(reading.prescription.claims.image_half_diagonal_mm, Some(3.5));
}
