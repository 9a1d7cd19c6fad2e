//! DeepLens' JSON: the reference lenses written in it, and what misleads its readers.

use photosite_core::spectrum::dispersion::lines;
use photosite_lens::files::{Format, Reading, names};

use super::{error, reading, reference};

fn efl(reading: &Reading) -> f64 {
    reading.lens.at(lines::D).first_order().efl_mm
}

fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

/// A plano-convex lens of n = 1.5168: EFL = R/(n − 1); BFL = EFL where the flat side is behind, less d/n.
const PLANO: &str = r#"{"info": "US 7,000,001 example 1", "foclen": 96.7, "fnum": 9.67, "r_sensor": 8.5, "(d_sensor)": 1.0, "surfaces": [
 {"type": "Aspheric", "r": 5.0, "(c)": 9.0, "roc": 50.0, "k": 0.0, "ai": [], "mat2": "1.5168/64.17", "d_next": 4.0},
 {"type": "Spheric", "r": 6.0, "roc": 0.0, "mat2": "air", "d_next": 1.0},
 {"type": "Aperture", "r": 4.0, "is_square": false, "mat2": "occluder", "d_next": 90.0}]}"#;

#[test]
fn the_reference_lenses_are_those_that_were_written() {
    let mut written = 0;
    for name in names() {
        let lens = reference(name).prescription;
        let is_even = lens.surfaces.iter().flat_map(|surface| &surface.asphere).all(|(order, _)| order % 2 == 0);
        if !is_even || lens.positions.len() > 1 {
            continue;
        }
        written += 1;
        // Numbers as PyTorch has them; places along the axis, too.
        let mut z = 0.0;
        let surfaces = lens.surfaces.iter().map(|surface| {
            let next = single(z + surface.thickness_mm);
            let gap = next - single(z);
            z += surface.thickness_mm;
            let numbers = surface.glass.as_ref().map(|g| (g.dispersion.index(lines::D), g.dispersion.abbe_number()));
            let mat2 = numbers.map_or("air".to_owned(), |(nd, vd)| format!("{nd:.6}/{vd:.3}"));
            let kind = match (surface.is_stop && surface.radius_mm.is_none(), surface.asphere.is_empty()) {
                (true, _) => "Aperture",
                (false, true) if surface.conic == 0.0 => "Spheric",
                (false, _) => "Aspheric",
            };
            let highest = surface.asphere.iter().map(|(order, _)| *order).max().unwrap_or(0);
            let term = |order: u32| surface.asphere.iter().find(|(known, _)| *known == order).map_or(0.0, |(_, a)| *a);
            let ai: Vec<String> = (1..=highest / 2).map(|i| format!("{:e}", single(term(2 * i)))).collect();
            let (r, roc) = (surface.semi_aperture_mm.expect("given"), single(surface.radius_mm.unwrap_or(0.0)));
            let (k, ai) = (single(surface.conic), ai.join(", "));
            format!(
                "{{\"type\": \"{kind}\", \"r\": {r}, \"roc\": {roc}, \"k\": {k}, \"ai\": [{ai}], \"mat2\": \"{mat2}\", \"d_next\": {gap}}}"
            )
        });
        let surfaces: Vec<String> = surfaces.collect();
        let read = reading("lens.json", &format!("{{\"surfaces\": [{}]}}", surfaces.join(",\n"))).prescription;
        assert_eq!(read.surfaces.len(), lens.surfaces.len(), "{name}");
        for (i, (a, b)) in read.surfaces.iter().zip(&lens.surfaces).enumerate() {
            // Decimals come back; what has more digits than six keeps the precision of its file.
            let near = |x: f64, y: f64, whole: f64| (x - y).abs() <= 1.2e-7 * whole.abs();
            let [x, y] = [a, b].map(|surface| surface.radius_mm.unwrap_or(0.0));
            assert!(near(x, y, y), "{name} {i}: {x} {y}");
            assert!(near(a.thickness_mm, b.thickness_mm, z), "{name} {i}: {} {}", a.thickness_mm, b.thickness_mm);
            assert!(near(a.conic, b.conic, b.conic) && a.asphere.len() == b.asphere.len(), "{name} {i}");
            for ((order, x), (other, y)) in a.asphere.iter().zip(&b.asphere) {
                assert!(order == other && near(*x, *y, *y), "{name} {i}: {x} {y}");
            }
            let [x, y] = [a, b].map(|s| s.glass.as_ref().map_or(1.0, |glass| glass.dispersion.index(lines::D)));
            assert!((x - y).abs() <= 1e-4, "{name} {i}: {x} {y}");
        }
        let stop = |lens: &photosite_lens::Prescription| lens.surfaces.iter().position(|surface| surface.is_stop);
        // Only flat stops have a type of their own.
        if lens.surfaces[stop(&lens).expect("one")].radius_mm.is_none() {
            assert_eq!(stop(&read), stop(&lens), "{name}");
        }
    }
    assert!(written >= 7, "{written}");
}

#[test]
fn a_plano_convex_lens_has_the_focal_length_of_the_lensmakers_equation() {
    let lens = reading("lens.json", PLANO);
    assert_eq!(lens.report.format, Format::DeepLens);
    let first_order = lens.lens.at(lines::D).first_order();
    let n = lens.report.glasses[0].nd;
    assert!((first_order.efl_mm - 50.0 / (n - 1.0)).abs() < 1e-9);
    // From the stop, 1 mm behind.
    assert!((first_order.bfl_mm - (first_order.efl_mm - 4.0 / n - 1.0)).abs() < 1e-9);
    assert_eq!(lens.prescription.patent.as_deref(), Some("US 7,000,001"));
    assert_eq!(lens.prescription.claims.image_half_diagonal_mm, Some(8.5));
    assert_eq!(lens.lens.stop(), 2);
}

#[test]
fn coefficients_begin_at_r2_unless_the_file_says_otherwise() {
    let a2 = 1e-3;
    let of = |rest: &str| reading("lens.json", &PLANO.replace("\"ai\": []", &format!("\"ai\": [{a2}, 1e-6]{rest}")));
    // c + 2·a₂ is the curvature at the vertex.
    let lens = of("");
    let n = lens.report.glasses[0].nd;
    assert!((efl(&lens) - 1.0 / ((n - 1.0) * (0.02 + 2.0 * a2))).abs() < 1e-9);
    assert_eq!(lens.prescription.surfaces[0].asphere, [(2, 1e-3), (4, 1e-6)]);
    let lens = of(", \"use_ai2\": false");
    assert_eq!(lens.prescription.surfaces[0].asphere, [(4, 1e-3), (6, 1e-6)]);
    // Keys in brackets are comments, ai4 and so on repeat what stands in ai.
    assert_eq!(of(", \"ai4\": 7.0, \"(ai2)\": 3.0").prescription.surfaces[0].asphere, [(2, 1e-3), (4, 1e-6)]);
}

#[test]
fn curvatures_names_of_glasses_and_a_missing_stop() {
    let expected = efl(&reading("lens.json", PLANO));
    let by_c = PLANO.replace("\"(c)\": 9.0, \"roc\": 50.0", "\"c\": 0.02");
    assert!((efl(&reading("lens.json", &by_c)) - expected).abs() < 1e-9);
    for (glass, nd) in
        [("bk7", 1.5168), ("f2", 1.62004), ("coc", 1.5337), ("okp4", 1.6328), ("pmma", 1.4906), ("h-k51", 1.52307)]
    {
        let lens = reading("lens.json", &PLANO.replace("1.5168/64.17", glass));
        assert!((lens.report.glasses[0].nd - nd).abs() < 1e-3, "{glass}: {:?}", lens.report.glasses);
    }
    assert!(error("lens.json", &PLANO.replace("1.5168/64.17", "butter")).contains("butter"));
    // The smallest surface is the stop.
    let open = PLANO.replace("\"Aperture\"", "\"Plane\"").replace("\"r\": 4.0", "\"l\": 24.0");
    let lens = reading("lens.json", &open);
    assert_eq!(lens.lens.stop(), 0);
    assert!(lens.report.assumed.iter().any(|note| note.contains("there is no Aperture")), "{:?}", lens.report.assumed);
    assert_eq!(lens.prescription.surfaces[2].semi_aperture_mm, Some(12.0));
    let doe = PLANO.replace("{\"info\"", "{\"DOE\": {\"type\": \"Binary2\"}, \"info\"");
    assert!(error("lens.json", &doe).contains("Binary2"));
}
