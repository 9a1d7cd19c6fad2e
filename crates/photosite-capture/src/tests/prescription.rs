//! Tests of lenses from a prescription.

use super::*;
use photosite_transport::optics::{Focus, LensKind};

#[test]
fn a_lens_that_ships_goes_by_its_name() {
    let capture = capture(&room("[lens]\nprescription = 'double-gauss'\nfocus_distance_m = 1.5\nblades = 7"));
    let lens = &capture.lens;
    // Optiland: 99.4 to 99.5 mm, f/2.
    assert_eq!((lens.kind, lens.focus, lens.blades), (LensKind::Prescription, Focus::Distance(1.5), 7));
    assert!((lens.focal_length_m - 0.0995).abs() < 1e-3, "{}", lens.focal_length_m);
    assert!((lens.f_number - 2.0).abs() < 0.05, "{}", lens.f_number);
    let stopped = super::capture(&room("[lens]\nprescription = 'double-gauss'\nf_number = 8"));
    assert_eq!((stopped.lens.f_number, stopped.lens.focal_length_m), (8.0, lens.focal_length_m));
}

#[test]
fn a_lens_of_a_file_is_read_beside_the_capture_and_its_assumptions_are_told() {
    let dat = "# a singlet\n#50mm\n50 4 1.5 20\n-50 5 1 20\n0 5 0 5\n1000 4 1.5 20\n-1000 45 1 20\n";
    let files = Files::new(&room("[lens]\nprescription = 'lens.dat'"));
    files.add("lens.dat", dat.as_bytes());
    let capture = files.read(&[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(capture.lens.prescription.as_ref().map(|lens| lens.surfaces.len()), Some(5));
    let warnings = capture.warnings();
    assert!(warnings.iter().any(|w| w.starts_with("lens.prescription lens.dat")), "{warnings:?}");
}

#[test]
fn texts_that_list_lens_files_name_every_ending() {
    let schema = capture_schema()["$defs"]["LensTable"]["properties"]["prescription"]["description"].to_string();
    let guide = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/guides/lenses.md");
    let guide = fs::read_to_string(guide).expect("the guide of lenses");
    for ending in photosite_lens::files::endings() {
        assert!(schema.contains(&format!(".{ending}")), "the schema leaves out .{ending}: {schema}");
        assert!(guide.contains(&format!(".{ending}")), "the guide leaves out .{ending}");
    }
}

#[test]
fn what_does_not_go_with_a_prescription_is_an_error_that_names_the_key() {
    for (keys, start) in [
        (
            "prescription = 'double-gaus'",
            "lens.prescription: no lens \"double-gaus\" ships with photosite; did you mean",
        ),
        ("prescription = 'none.zmx'", "lens.prescription: cannot read"),
        ("prescription = 'double-gauss'\ntype = 'thin'", "lens.type: cannot be combined with prescription"),
        ("prescription = 'double-gauss'\nhorizontal_fov_deg = 30", "lens.horizontal_fov_deg: cannot be combined with"),
        ("prescription = 'double-gauss'\nfalloff = 'none'", "lens.falloff: cannot be combined with lens.prescription"),
        (
            "prescription = 'double-gauss'\npsf = { kind = 'airy' }",
            "lens.psf: cannot be combined with lens.prescription",
        ),
        (
            "focal_length_mm = 50\npsf = { kind = 'wave' }",
            "lens.psf: a point spreads by the wave fronts of a prescription",
        ),
        (
            "prescription = 'double-gauss'\nautofocus_px = 'centre'\nautofocus = { method = 'contrast' }",
            "lens.autofocus.method: the search for contrast",
        ),
        (
            "prescription = 'double-gauss'\ndistortion = { model = 'brown-conrady', k = [-0.1, 0, 0] }",
            "lens.distortion: cannot be combined with lens.prescription",
        ),
    ] {
        let error = Files::new(&room(&format!("[lens]\n{keys}"))).read(&[]).expect_err(keys).to_string();
        assert!(error.contains(start), "{keys}: {error}");
    }
}

/// Case: a lens is focused for the light that the sensor sees: one that sees red alone has its focus there.
#[test]
fn the_focus_is_that_of_the_sensors_own_spectrum() {
    let spectrum = |keys: &str| {
        let files = Files::new(&room(&format!("[lens]\nprescription = 'double-gauss'\n{keys}")));
        files.add("red.csv", b"300,0\n600,0\n601,1\n1100,1\n");
        let capture = files.read(&[]).unwrap_or_else(|error| panic!("{error}"));
        let wavelengths: Vec<f64> = capture.lens.focus_spectrum.iter().map(|(nm, _)| *nm).collect();
        assert_eq!(wavelengths.len(), 9, "{wavelengths:?}");
        assert!(wavelengths.is_sorted() && capture.lens.focus_spectrum.iter().all(|(_, weight)| *weight == 1.0));
        let responses = capture.sensor.responses();
        let below = |nm: f64| -> f64 {
            let of = |nm: u32| {
                let tau = f64::from(capture.lens.transmittance.eval(nm as f32));
                responses.iter().map(|(_, response)| f64::from(response.eval(nm as f32))).sum::<f64>() * tau
            };
            (300..=nm as u32).map(of).sum()
        };
        // Each in the middle of a ninth of the light.
        for (i, nm) in wavelengths.iter().enumerate() {
            let part = (i as f64 + 0.5) / 9.0;
            assert!(
                below(nm - 1.0) < part * below(1100.0) && below(*nm) >= part * below(1100.0) * (1.0 - 1e-9),
                "{nm}"
            );
        }
        wavelengths
    };
    let (whole, red) = (spectrum(""), spectrum("transmittance = { file = 'red.csv' }"));
    assert!(whole[0] < 500.0 && red[0] > 600.0, "{whole:?} {red:?}");
}
