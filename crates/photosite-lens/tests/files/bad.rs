//! Errors of bad files: each names file, line, surface and value, and what to write instead.

use rstest::rstest;

use super::error;

const GOOD: &str = r#"name = "singlet"
unit = "mm"
surfaces = [
  { radius = 50.0, thickness = 4.0, glass = "N-BK7", semi_aperture = 8.0 },
  { radius = -50.0, thickness = 3.0, semi_aperture = 8.0 },
  { thickness = 40.0, semi_aperture = 4.0, stop = true },
]
"#;

#[test]
fn the_good_file_is_good() {
    super::reading("lens.toml", GOOD);
}

#[rstest]
#[case::no_stop(", stop = true", "", &["stop"])]
#[case::two_stops("semi_aperture = 8.0 },\n  { radius", "semi_aperture = 8.0, stop = true },\n  { radius", &["stop"])]
#[case::no_glass(", glass = \"N-BK7\"", "", &["glass"])]
#[case::unknown_glass("N-BK7", "N-BK77", &["lens.toml:4", "surfaces[0].glass", "N-BK77", "schott/N-BK7"])]
#[case::ambiguous_glass("N-BK7", "F2", &["lens.toml:4", "schott/F2", "cdgm/F2"])]
#[case::impossible_glass("N-BK7", "0.5/60", &["lens.toml:4", "0.5"])]
#[case::no_unit("unit = \"mm\"\n", "", &["unit"])]
#[case::unknown_unit("\"mm\"", "\"furlong\"", &["lens.toml:2", "furlong"])]
#[case::not_finite("50.0, thickness = 4.0", "nan, thickness = 4.0", &["lens.toml:4", "surfaces[0].radius", "NaN"])]
#[case::infinite("thickness = 3.0", "thickness = inf", &["lens.toml:5", "surfaces[1].thickness", "inf"])]
#[case::no_semi_aperture(", semi_aperture = 8.0 },\n  { radius", " },\n  { radius", &["lens.toml:4", "surfaces[0]", "semi-aperture is missing"])]
#[case::semi_aperture_of_0("semi_aperture = 4.0", "semi_aperture = 0.0", &["lens.toml:6", "surfaces[2].semi_aperture", "above 0"])]
#[case::semi_aperture_above_radius("radius = 50.0", "radius = 7.0", &["lens.toml:4", "surfaces[0].semi_aperture", "8 mm"])]
#[case::crossing("thickness = 4.0", "thickness = 0.5", &["lens.toml:4", "surfaces[0]", "runs through"])]
#[case::negative_gap("thickness = 3.0", "thickness = -1.0", &["lens.toml:5", "-1"])]
#[case::no_last_gap("thickness = 40.0", "thickness = 0.0", &["lens.toml:6", "last gap"])]
#[case::folded("semi_aperture = 8.0 },\n  { radius", "semi_aperture = 8.0, asphere = { 4 = 1.0 } },\n  { radius", &["lens.toml:4", "folds"])]
#[case::order("semi_aperture = 8.0 },\n  { radius", "semi_aperture = 8.0, asphere = { 32 = 1e-9 } },\n  { radius", &["lens.toml:4", "r^32"])]
#[case::no_order("semi_aperture = 8.0 },\n  { radius", "semi_aperture = 8.0, asphere = { four = 1e-9 } },\n  { radius", &["lens.toml:4", "four"])]
#[case::diverging("radius = -50.0", "radius = 20.0", &["focal length"])]
#[case::unknown_key("stop = true", "stopp = true", &["lens.toml:6", "stopp"])]
#[case::wrong_type("thickness = 4.0", "thickness = \"4\"", &["lens.toml:4"])]
#[case::no_thickness("thickness = 4.0, ", "", &["lens.toml:4", "thickness"])]
#[case::coating("stop = true", "stop = true, coating = \"blue\"", &["lens.toml:6", "blue"])]
#[case::layer("stop = true", "stop = true, coating = [{ index = \"butter\", thickness_nm = 90 }]", &["lens.toml:6", "butter"])]
fn our_own_form(#[case] what: &str, #[case] by: &str, #[case] expected: &[&str]) {
    let text = GOOD.replacen(what, by, 1);
    assert_ne!(text, GOOD);
    let message = error("lens.toml", &text);
    for part in expected {
        assert!(message.contains(part), "{part}: {message}");
    }
}

#[test]
fn positions_are_named() {
    let position = |gaps: &str| format!("{GOOD}\n[[positions]]\nlabel = \"near\"\ngaps = {{ {gaps} }}\n");
    super::reading("lens.toml", &position("2 = 41.0"));
    assert!(error("lens.toml", &position("7 = 41.0")).contains("behind surface 7"));
    assert!(error("lens.toml", &position("2 = -1.0")).contains("-1"));
    assert!(error("lens.toml", &position("0 = 0.1")).contains("runs through"));
}

#[test]
fn a_glass_that_is_defined_badly_is_named() {
    let with = |glass: &str| format!("{}\n[glasses.mine]\n{glass}\n", GOOD.replace("N-BK7", "mine"));
    super::reading("lens.toml", &with("nd = 1.5168\nvd = 64.2"));
    for (glass, part) in [
        ("range_nm = [300.0, 1000.0]", "nothing says what its index is"),
        ("sellmeier_b = [1.0, 0.2]\nsellmeier_c_um2 = [0.006]", "Sellmeier"),
        ("n = 0.0", "index"),
        ("nd = 0.5\nvd = 60", "0.5"),
        ("conrady = [1.0, 0.0]", "array of length 3"),
    ] {
        let message = error("lens.toml", &with(glass));
        assert!(message.contains(part), "{glass}: {message}");
    }
}

#[test]
fn texts_that_are_no_lens() {
    for (name, text, part) in [
        ("lens.toml", "surfaces = [", "lens.toml:1"),
        ("lens.json", "{\n\"surfaces\": [}\n", "lens.json:2"),
        ("lens.json", "{\"surface_group\": {}}", "surfaces"),
        ("lens.json", "{\"surface_group\": {\"surfaces\": [1, 2, 3]}}", "surfaces[0]"),
        ("lens.json", "{\"surfaces\": [{\"type\": \"Spheric\", \"d_next\": 1.0}]}", "surfaces[0]"),
        ("lens.json", "{\"surfaces\": [{\"type\": \"Fresnel\", \"d_next\": 1.0}]}", "surfaces[0]: \"Fresnel\""),
        (
            "lens.json",
            "{\"surfaces\": [{\"type\": \"Plane\", \"r\": 1, \"d_next\": 1}, {\"type\": \"DOE\"}]}",
            "surfaces[1]: \"DOE\"",
        ),
        ("lens.roa", "{\"optical_model\": {\"attributes\": {}}}", "seq_model"),
        ("lens.zmx", "", "UNIT"),
        ("lens.zmx", "UNIT MM\nSURF 0\n", "1 surfaces"),
        ("lens.zmx", "UNIT FATHOM\n", "lens.zmx:1"),
        ("lens.seq", "", "RDM"),
        ("lens.seq", "RDM Y\nS 1 2\n", "SI"),
        ("lens.seq", "RDM Y\nS x 2\nSI 0 0\n", "lens.seq:2"),
        ("lens.txt", "[lens data]\n", "[lens data]"),
        ("lens.txt", "[lens data]\n1\t20\td1\t1.5\t10\t60\n", "d1"),
        ("lens.txt", "words", "[lens data]"),
        ("lens.dat", "1 2 3", "3 numbers"),
        ("lens.dat", "1 2 three 4", "lens.dat:1: three"),
        ("lens.doc", "", "\"doc\""),
        ("lens", "", ".zmx"),
    ] {
        let message = error(name, text);
        assert!(message.contains(part), "{name} {text:?}: {message}");
    }
}

#[test]
fn what_is_no_refracting_surface_is_refused_by_name() {
    let zmx = |of_surface: &str| {
        format!(
            "UNIT MM\nSURF 0\n DISZ INFINITY\nSURF 1\n STOP\n DISZ 4\n{of_surface}\nSURF 2\n DISZ 9\nSURF 3\n DISZ 0\n"
        )
    };
    for (record, part) in [
        (" GLAS MIRROR 0 0", "mirror"),
        (" TYPE COORDBRK", "coordinate break"),
        (" TYPE PARAXIAL", "paraxial"),
        (" TYPE BINARY_2", "diffractive"),
        (" TYPE FRESNELS", "Fresnel"),
        (" TYPE GRADIENT", "GRADIENT"),
        (" TYPE ODDASPHE\n PARM 1 0.1", "r¹"),
        (" CURV x", "CURV x"),
        (" DISZ INFINITY", "INFINITY"),
    ] {
        let message = error("a.zmx", &zmx(record));
        assert!(message.contains(part) && message.contains("SURF 1"), "{record}: {message}");
    }
    for (command, part) in [
        ("S 1 2 REFL", "mirror"),
        ("S 1 2\nXDE 1", "XDE"),
        ("S 1 2\nDIF DOE", "diffractive"),
        ("S 1 2\nSPS XYP", "special"),
    ] {
        let message = error("a.seq", &format!("RDM Y\n{command}\nSI 0 0\n"));
        assert!(message.contains(part), "{command}: {message}");
    }
}

#[test]
fn files_that_are_too_long_are_refused() {
    let many = |count: usize| "50 1 1.5 10\n".repeat(count);
    assert!(error("a.dat", &many(201)).contains("200 surfaces"));
    assert!(error("a.seq", &format!("RDM Y\n{}", "S 50 1\n".repeat(201))).contains("200 surfaces"));
    assert!(error("a.zmx", &"SURF 1\n".repeat(300)).contains("200 surfaces"));
    assert!(error("a.toml", &" ".repeat(1_000_001)).contains("1 MB"));
}

#[test]
fn positions_of_other_formats_are_complete() {
    let bench = "[variable distances]\nFocal Length\t10\t20\nd1\t1\nBf\t5\t6\t7\n[lens data]\n1\t20\td1\t1.5\t6\t60\n2\t-20\tBf\t\t6\n3\tAS\t9\t\t5\n";
    assert!(error("a.txt", bench).contains("a.txt:3: d1: 1 columns"), "{}", error("a.txt", bench));
    let short = bench.replace("d1\t1\n", "d1\t1\t2\n").replace("Bf\t5\t6\t7", "Bf\t5\t6\t7\t8");
    assert!(error("a.txt", &short).contains("d1: 2 columns"), "{}", error("a.txt", &short));
    let zoom = "RDM Y\nZOO 3\nS 50 4 NBK7_SCHOTT\nSTO\nCIR 5\nS 0 90\nCIR 5\nSI 0 0\nZOO THI S2 90 91\n";
    assert!(error("a.seq", zoom).contains("2 thicknesses of 3"));
}
