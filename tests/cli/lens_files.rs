//! `photosite lens`: lenses that ship and lens files, as text, JSON, page and file of ours.

use serde_json::Value;

use crate::folder::Folder;

/// A plano-convex lens of N-BK7: its focal length is R/(n_d − 1) = 50 mm / 0.5168.
const SEQ: &str =
    "RDM Y\nDIM M\nTITLE 'singlet'\nEPD 10\nYAN 0 5\nSO 0 1e13\nS 50 4 NBK7_SCHOTT\n  STO\nS 0 90\nSI 0 0\nGO\n";

/// A lens as DeepLens writes it.
const DEEPLENS: &str = r#"{
  "info": "a lens", "foclen": 96.7, "fnum": 9.67, "r_sensor": 8.5, "d_sensor": 94.0,
  "surfaces": [
    { "idx": 0, "type": "Spheric", "r": 5.0, "(c)": 0.02, "roc": 50.0, "d": 0.0, "mat2": "bk7", "d_next": 4.0 },
    { "idx": 1, "type": "Spheric", "r": 6.0, "roc": 0.0, "mat2": "air", "d_next": 90.0 }
  ]
}"#;

#[test]
fn a_lens_that_ships_is_shown_as_its_reference_has_it() {
    let folder = Folder::new([]);
    let outcome = folder.succeed("lens double-gauss --json");
    let figures = outcome.json();
    let position = &figures["positions"][0];
    // Optiland: 99.985804328, 100.00372967, 100.063426611 mm at F, d, C.
    for (row, efl) in [99.985804328, 100.00372967, 100.063426611].into_iter().enumerate() {
        let found = position["first_order"][row]["efl_mm"].as_f64().expect("a number");
        assert!((found - efl).abs() < 1e-6, "{found}");
    }
    let fields = position["fields"].as_array().expect("fields");
    assert_eq!(fields.len(), 7);
    let edge = &fields[6];
    // tests/reference/double-gauss.json: the chief ray of 14° at d.
    assert!((edge["image_height_mm"].as_f64().expect("a number") - 24.5887).abs() < 1e-3, "{edge}");
    assert!(edge["mtf"][1]["tangential"].as_array().is_some_and(|values| values[0] == 1.0), "{edge}");
    let text = folder.succeed("lens double-gauss --f-number 8").stdout;
    for part in ["Double Gauss", "N-SSK2", "First order", "MTF 20", "f/8.00"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // By its own description 50 mm f/5, by the figures of its surfaces 50.0 mm.
    let list = folder.succeed("lens --list").stdout;
    let words = |name: &str| {
        let line = list.lines().find(|line| line.starts_with(name)).expect(name);
        line.split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(words("cooke-triplet")[1..3], ["50.0", "5.00"], "{list}");
    let all = folder.succeed("lens zoom-laikin --json").json();
    // At d.
    let of = |position: &Value| position["first_order"][1]["efl_mm"].as_f64().expect("a number");
    let lengths: Vec<f64> = all["positions"].as_array().expect("positions").iter().map(of).collect();
    let [shortest, longest] = [f64::min, f64::max].map(|end| lengths.iter().copied().reduce(end).expect("positions"));
    assert_eq!(words("zoom-laikin")[1], format!("{shortest:.1}–{longest:.1}"), "{list}");
}

#[test]
fn a_lens_file_becomes_one_of_ours_and_a_page() {
    let folder = Folder::new([("singlet.seq", SEQ.into())]);
    folder.succeed("lens singlet.seq -o lens.toml -o lens.html --quiet");
    let page = folder.text("lens.html");
    for part in ["<h1>singlet</h1>", "Cross-section", "Field curves", "Spots", "Modulation transfer", "</html>"] {
        assert!(page.contains(part), "{part}");
    }
    // It refers to nothing but itself.
    assert!(!page.contains("src=") && !page.contains("href="));
    let efl = |file: &str| {
        let figures = folder.succeed(&format!("lens {file} --json")).json();
        figures["positions"][0]["first_order"][1]["efl_mm"].as_f64().expect("a number")
    };
    assert_eq!(efl("lens.toml"), efl("singlet.seq"));
    assert!((efl("lens.toml") - 50.0 / 0.5168).abs() < 1e-3);
    folder.fail("lens singlet.seq -o lens.toml", 2, &["lens.toml already exists", "--force"]);
    folder.succeed("lens singlet.seq -o lens.toml --force --quiet");
}

#[test]
fn a_sequence_without_rdm_and_a_file_of_deeplens_are_the_same_lens() {
    let curvatures = SEQ.replace("RDM Y\n", "").replace("S 50 4", "S 0.02 4");
    let folder = Folder::new([
        ("radii.seq", SEQ.replace("RDM Y\n", "").into()),
        ("curvatures.seq", curvatures.into()),
        ("deeplens.json", DEEPLENS.into()),
    ]);
    for (number, line) in ["radii.seq --radii", "curvatures.seq --curvatures", "deeplens.json"].into_iter().enumerate()
    {
        folder.succeed(&format!("lens {line} -q -o {number}.toml"));
        let toml = folder.text(&format!("{number}.toml"));
        assert!(toml.contains("radius = 50.0") && toml.contains("thickness = 90.0"), "{line}: {toml}");
    }
}

#[test]
fn what_cannot_be_shown_is_said() {
    let folder = Folder::new([
        ("no-rdm.seq", SEQ.replace("RDM Y\n", "").into()),
        ("glass.seq", SEQ.replace("NBK7_SCHOTT", "NBK77_SCHOTT").into()),
        ("lens.doc", "words".into()),
        ("other.json", "{\"lens\": 3}".into()),
        ("list.json", "[1, 2]".into()),
    ]);
    folder.fail("lens no-rdm.seq", 1, &["no-rdm.seq", "RDM Y", "RDM N"]);
    folder.fail("lens glass.seq", 1, &["glass.seq:7", "surface 1", "NBK77", "schott/N-BK7"]);
    folder.fail("lens lens.doc", 1, &["lens.doc", ".zmx"]);
    let read = ["photosite's own", "`surface_group`", "`optical_model`", "`d_next`"];
    let with = |words: &[&'static str]| [words, &read[..]].concat();
    folder.fail("lens no-rdm.seq --radii --curvatures", 2, &["--curvatures"]);
    folder.fail("lens glass.seq --radii -q", 1, &["NBK77"]);
    folder.fail("lens double-gauss --radii", 2, &["--radii", ".seq"]);
    folder.fail("lens other.json", 1, &with(&["other.json", "the keys `lens`, and none of `surfaces`"]));
    folder.fail("lens list.json", 1, &with(&["list.json", "no keys"]));
    folder.fail("lens missing.seq", 1, &["missing.seq"]);
    folder.fail("lens double-gaus", 2, &["double-gauss"]);
    folder.fail("lens canon-ef5", 2, &["did you mean `canon-ef50`?"]);
    folder.fail("lens double-gauss --f-number 1", 2, &["f/1", "f/2.012"]);
    folder.fail("lens double-gauss --half-field -3", 2, &["half field"]);
    folder.fail("lens double-gauss -o lens.zmx", 2, &["lens.zmx", ".toml"]);
    folder.fail("lens", 2, &[]);
}

/// A plano-convex lens, its curved side first, at infinity and at 900 mm.
const SINGLET: &str = "[descriptive data]\ntitle\tsinglet\n[constants]\nAsphericalOddCount\t1\n[variable distances]\n\
    Focal Length\t96.7\t97\nF-Number\t9.7\t9.7\nAngle of View\t10\t9\nImage Height\t17\t17\nd0\tInfinity\t900\n\
    d2\t90\t95\n[lens data]\n1\t50\t4\t1.5168\t16\t64.2\tN-BK7\tSchott\n2\tInfinity\td2\t\t16\n3\tAS\t5\t\t30\n\
    [aspherical data]\n1\t50\t-0.5\t1e-5\t1e-7\t1e-9\t1e-11\n";

/// All power is at the first vertex, where the principal plane of the object's side is: the image is 1/(1/f − 1/900 mm) from
/// the other, that is f before the focus.
#[test]
fn figures_of_a_near_position_are_for_objects_there() {
    let folder = Folder::new([("singlet.txt", SINGLET.into())]);
    let figures = folder.succeed("lens singlet.txt --position 2 --json").json();
    assert_eq!(figures["positions"].as_array().map(Vec::len), Some(1));
    let position = &figures["positions"][0];
    assert_eq!(position["object_distance_mm"], 900.0);
    let of_d = |key: &str| position["first_order"][1][key].as_f64().expect("a number");
    let (f, back) = (of_d("efl_mm"), of_d("bfl_mm"));
    let image = back - f + 1.0 / (1.0 / f - 1.0 / 900.0);
    let defocus = position["defocus_mm"].as_f64().expect("a number");
    assert!((defocus - (5.0 - image)).abs() < 1e-9, "{defocus} {image}");
    let axis = &position["fields"][0];
    // Rays 1e-4 mm beside the axis are paraxial.
    for key in ["tangential_focus_mm", "sagittal_focus_mm"] {
        assert!((axis[key].as_f64().expect("a number") + defocus).abs() < 1e-4, "{axis} {defocus}");
    }
    folder.fail("lens singlet.txt --position 3", 2, &["no position", "1 (", "2 ("]);
    folder.fail("lens double-gauss --position 1", 2, &["leave --position out"]);
}
