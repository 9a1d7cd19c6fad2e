//! Prescriptions that cannot be traced are errors that name surface and value.

use photosite_core::Invalid;
use photosite_core::spectrum::Dispersion;
use photosite_lens::prescription::{
    Blades, Claims, Coating, Glass, Layer, LayerIndex, Position, Prescription, Surface,
};
use photosite_lens::{Lens, checks};
use rstest::rstest;

fn glass(dispersion: Dispersion) -> Option<Glass> {
    Some(Glass { name: "glass".to_owned(), source: "here".to_owned(), dispersion, range_nm: None })
}

/// A biconvex lens with a stop 5 mm behind it.
fn singlet() -> Prescription {
    let surface = |radius_mm, thickness_mm, glass, semi_aperture_mm| Surface {
        radius_mm,
        thickness_mm,
        glass,
        semi_aperture_mm: Some(semi_aperture_mm),
        ..Surface::default()
    };
    Prescription {
        claims: Claims { f_number: Some(10.0), half_field_deg: Some(10.0), ..Claims::default() },
        surfaces: vec![
            surface(Some(50.0), 4.0, glass(Dispersion::constant(1.5)), 10.0),
            surface(Some(-50.0), 5.0, None, 10.0),
            Surface { is_stop: true, ..surface(None, 45.0, None, 2.5) },
        ],
        ..Prescription::default()
    }
}

fn refusal(change: impl FnOnce(&mut Prescription)) -> Invalid {
    let mut prescription = singlet();
    change(&mut prescription);
    Lens::new(&prescription).err().unwrap_or_else(|| panic!("accepted: {prescription:#?}"))
}

#[test]
fn a_singlet_is_accepted_with_the_focal_length_of_the_lensmakers_equation() {
    let lens = Lens::new(&singlet()).expect("a lens");
    let power: f64 = 0.5 * (1.0 / 50.0 + 1.0 / 50.0 - 0.5 * 4.0 / (1.5 * 50.0 * 50.0));
    assert!((lens.at(550.0).first_order().efl_mm * power - 1.0).abs() < 1e-14);
}

#[rstest]
#[case(|p: &mut Prescription| p.surfaces.clear(), "surfaces", "none of the 0 surfaces refracts")]
#[case(|p: &mut Prescription| p.surfaces[0].glass = None, "surfaces", "none of the 3 surfaces refracts")]
#[case(|p: &mut Prescription| p.surfaces[2].is_stop = false, "surfaces", "none of the 3 surfaces is the stop")]
#[case(|p: &mut Prescription| p.surfaces[0].is_stop = true, "surfaces", "surfaces 0 and 2 are both the stop")]
#[case(|p: &mut Prescription| p.surfaces = vec![p.surfaces[0].clone(); 201], "surfaces", "201 surfaces are more than 200")]
#[case(|p: &mut Prescription| p.surfaces[1].radius_mm = Some(0.0), "surfaces[1].radius_mm", "a radius of 0")]
#[case(|p: &mut Prescription| p.surfaces[1].radius_mm = Some(f64::NAN), "surfaces[1].radius_mm", "NaN is not a finite")]
#[case(|p: &mut Prescription| p.surfaces[1].thickness_mm = f64::INFINITY, "surfaces[1].thickness_mm", "inf is not a finite")]
#[case(|p: &mut Prescription| p.surfaces[0].conic = f64::NAN, "surfaces[0].conic", "not a finite")]
#[case(|p: &mut Prescription| p.surfaces[0].asphere = vec![(4, f64::NAN)], "surfaces[0].asphere", "r^4 NaN is not")]
#[case(|p: &mut Prescription| p.surfaces[0].asphere = vec![(31, 1e-9)], "surfaces[0].asphere", "orders go from 2 to 30")]
#[case(|p: &mut Prescription| p.surfaces[0].asphere = vec![(1, 1e-9)], "surfaces[0].asphere", "orders go from 2 to 30")]
#[case(|p: &mut Prescription| p.surfaces[0].asphere = vec![(4, 1.0)], "surfaces[0].asphere", "folds at")]
#[case(|p: &mut Prescription| p.surfaces[0].semi_aperture_mm = Some(0.0), "surfaces[0].semi_aperture_mm", "above 0, got 0 mm")]
#[case(|p: &mut Prescription| p.surfaces[0].semi_aperture_mm = Some(f64::NAN), "surfaces[0].semi_aperture_mm", "got NaN mm")]
#[case(|p: &mut Prescription| p.surfaces[0].radius_mm = Some(9.9), "surfaces[0].semi_aperture_mm", "10 mm is wider than the sphere")]
#[case(|p: &mut Prescription| p.surfaces[0].conic = 25.0, "surfaces[0].semi_aperture_mm", "ends at 9.8058 mm")]
#[case(|p: &mut Prescription| p.surfaces[1].thickness_mm = -0.1, "surfaces[1].thickness_mm", "air cannot be -0.1 mm thick")]
#[case(|p: &mut Prescription| p.surfaces[0].thickness_mm = -0.1, "surfaces[0].thickness_mm", "glass cannot be -0.1 mm thick")]
#[case(|p: &mut Prescription| p.surfaces[0].thickness_mm = 1.0, "surfaces[0].thickness_mm", "surface 0 runs through surface 1")]
#[case(|p: &mut Prescription| p.surfaces[2].thickness_mm = 0.0, "surfaces[2].thickness_mm", "the sensor must be behind the lens")]
#[case(|p: &mut Prescription| p.surfaces[0].glass = glass(Dispersion::constant(0.99)), "surfaces[0].glass", "index 0.99 at 400 nm")]
#[case(|p: &mut Prescription| p.surfaces[0].glass = glass(Dispersion::Polynomial { terms: vec![[1e9, 400.0], [-1.0, 0.0]] }), "surfaces[0].glass", "NaN at 400 nm")]
#[case(|p: &mut Prescription| p.surfaces[0].glass = glass(Dispersion::constant(1.0)), "surfaces", "afocal at 550 nm")]
#[case(|p: &mut Prescription| { p.surfaces[0].radius_mm = Some(-50.0); p.surfaces[1].radius_mm = Some(50.0); }, "surfaces", "the lens diverges")]
#[case(|p: &mut Prescription| p.blades = Some(Blades { count: 2, rotation_deg: 0.0 }), "blades", "2 blades do not enclose an opening")]
#[case(|p: &mut Prescription| p.surfaces[0].coating = layer(1.38, 0.0, -1.0), "surfaces[0].coating[0]", "cannot be -1 nm thick")]
#[case(|p: &mut Prescription| p.surfaces[0].coating = layer(0.0, 0.0, 1.0), "surfaces[0].coating[0]", "the index 0 + 0i")]
#[case(|p: &mut Prescription| p.surfaces[0].coating = layer(1.5, -1.0, 1.0), "surfaces[0].coating[0]", "the index 1.5 + -1i")]
#[case(|p: &mut Prescription| p.positions = vec![gaps(&[(3, 1.0)])], "positions[0]", "no gap behind surface 3")]
#[case(|p: &mut Prescription| p.positions = vec![gaps(&[(1, f64::NAN)])], "positions[0]", "gap behind surface 1 NaN is not")]
#[case(|p: &mut Prescription| p.positions = vec![gaps(&[]), gaps(&[(1, -1.0)])], "positions[1].surfaces[1].thickness_mm", "air cannot be -1 mm thick")]
#[case(|p: &mut Prescription| p.positions = vec![Position { stop_semi_aperture_mm: Some(0.0), ..Position::default() }], "positions[0]", "above 0, got 0 mm")]
#[case(|p: &mut Prescription| p.positions = vec![Position { object_distance_mm: Some(-3.0), ..Position::default() }], "positions[0]", "a distance of -3 mm")]
fn what_cannot_be_traced(#[case] change: impl FnOnce(&mut Prescription), #[case] key: &str, #[case] message: &str) {
    let error = refusal(change);
    assert!(error.key == key && error.message.contains(message), "{error}");
}

fn layer(n: f64, k: f64, thickness_nm: f64) -> Coating {
    Coating::Layers(vec![Layer { index: LayerIndex::Constant { n, k }, thickness_nm }])
}

fn gaps(gaps: &[(usize, f64)]) -> Position {
    Position { gaps: gaps.to_vec(), ..Position::default() }
}

/// The marginal ray of f/10 is 2.4 to 2.6 mm high at the lens, the chief ray, which crosses the axis about 5 mm behind it,
/// 0.9 to 1.6 mm.
#[test]
fn a_missing_semi_aperture_is_offered_for_the_full_beam() {
    let error = refusal(|p| p.surfaces[0].semi_aperture_mm = None);
    assert_eq!(error.key, "surfaces[0].semi_aperture_mm");
    let help = error.help.expect("a size").to_string();
    let size: f64 = help.split(' ').next().and_then(|word| word.parse().ok()).unwrap_or_else(|| panic!("{help}"));
    assert!((3.3..4.2).contains(&size), "{help}");
    // Without claims there is nothing to go by.
    let error = refusal(|p| (p.claims, p.surfaces[0].semi_aperture_mm) = (Claims::default(), None));
    assert!(error.help.expect("a help").to_string().contains("in mm"));
}

#[test]
fn a_conic_with_its_end_beyond_the_rim_and_surfaces_that_touch_are_fine() {
    let mut touching = singlet();
    // Both sags at 10 mm: 50 − √(50² − 10²) = 1.01020514 mm.
    touching.surfaces[0].thickness_mm = 2.0 * (50.0 - 2400.0_f64.sqrt());
    assert!(Lens::new(&touching).is_ok());
    let mut hemisphere = singlet();
    hemisphere.surfaces[0].radius_mm = Some(10.0);
    hemisphere.surfaces[0].thickness_mm = 12.0;
    assert!(Lens::new(&hemisphere).is_ok(), "{:?}", Lens::new(&hemisphere));
}

#[test]
fn indices_are_checked_over_the_wavelengths_of_the_sensor() {
    let mut infrared = singlet();
    // 1 at 1000 nm, 2.5 at 400 nm.
    infrared.surfaces[0].glass = glass(Dispersion::Cauchy { a: 0.0, b_um2: 0.0, c_um4: 0.0 });
    infrared.surfaces[0].glass = glass(Dispersion::Conrady { a: 0.0, b_um: 1.0, c_um35: 0.0 });
    assert!(Lens::new(&infrared).is_ok());
    let error = checks::check_indices(&infrared, [400.0, 1001.0]).expect_err("0.999 at 1001 nm");
    assert!(error.key == "surfaces[0].glass" && error.message.contains("at 1001 nm"), "{error}");
}
