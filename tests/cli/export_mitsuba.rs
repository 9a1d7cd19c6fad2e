//! `photosite export-mitsuba`: what it writes, and what it refuses. That Mitsuba sees the same in it is tested in
//! `tests/mitsuba`.

use std::collections::BTreeSet;

use quick_xml::Reader;
use quick_xml::events::Event;
use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;

/// A triangle, and all else as Mitsuba has it too.
const CAPTURE: &str = r#"
[scene]
geometry = ["triangle.obj"]
environment = { illuminant = "D65", illuminance_lux = 500 }
[materials.paint]
type = "diffuse"
reflectance = 0.5
[camera]
position_m = [0, 0, 3]
look_at_m = [0, 0, 0]
[lens]
falloff = "none"
[sensor]
resolution_px = [16, 12]
[exposure]
time_s = 0.01
"#;

fn triangle() -> Folder {
    let obj = "usemtl paint\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    Folder::new([("capture.toml", CAPTURE.into()), ("triangle.obj", obj.into())])
}

/// The tags of an XML file with the types of objects, and the values of `filename`.
fn parsed(text: &str) -> (BTreeSet<String>, BTreeSet<String>) {
    let (mut objects, mut files) = (BTreeSet::new(), BTreeSet::new());
    let mut reader = Reader::from_str(text);
    loop {
        let event = reader.read_event().expect("well-formed XML");
        if let Event::Start(element) | Event::Empty(element) = &event {
            let attribute = |name: &str| {
                let found = element.try_get_attribute(name).expect("attributes");
                found.map(|a| a.value.into_owned())
            };
            if let Some(kind) = attribute("type") {
                objects.insert(kind);
            }
            if attribute("name").as_deref() == Some("filename") {
                files.extend(attribute("value"));
            }
        }
        if event == Event::Eof {
            return (objects, files);
        }
    }
}

#[test]
fn a_scene_names_the_files_that_lie_beside_it() {
    let folder = triangle();
    let outcome = folder.succeed("export-mitsuba capture.toml -o out");
    assert!(outcome.text().contains("wrote 3 files to out"), "{}", outcome.stderr);
    let text = std::fs::read_to_string(folder.path("out/scene.xml")).expect("scene.xml");
    let (objects, files) = parsed(&text);
    for kind in ["path", "thinlens", "specfilm", "box", "twosided", "diffuse", "constant", "ply"] {
        assert!(objects.contains(kind), "{kind} is missing in {objects:?}");
    }
    assert_eq!(files.into_iter().collect::<Vec<_>>(), ["meshes/0.ply"]);
    let ply = std::fs::read(folder.path("out/meshes/0.ply")).expect("a mesh");
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                  property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    assert!(ply.starts_with(header.as_bytes()));
    // Three corners of three floats; a count and three indices.
    assert_eq!(ply.len() - header.len(), 3 * 12 + 1 + 12);
}

/// The material of the capture.
const PAINT: &str = "type = \"diffuse\"\nreflectance = 0.5";

#[rstest]
#[case::falloff("falloff = \"none\"", "", "the falloff of [lens]")]
#[case::blades("[lens]", "[lens]\nblades = 6", "an aperture with blades")]
#[case::distortion(
    "[lens]",
    "[lens]\ndistortion = { model = \"brown-conrady\", k = [0.1, 0, 0], p = [0, 0] }",
    "the distortion of [lens]"
)]
#[case::exposure("time_s = 0.01", "auto = true", "an automatic exposure")]
#[case::shadowing(PAINT, "type = \"conductor\"\nmetal = \"Au\"\nroughness = 0.4", "microfacets of material \"paint\"")]
#[case::further_bounces(
    PAINT,
    "type = \"conductor\"\nmetal = \"Au\"\nroughness = 0.4\nenergy_compensation = true",
    "light that bounces more than once between the microfacets of material \"paint\""
)]
#[case::dispersion(PAINT, "type = \"dielectric\"\nglass = \"BK7\"", "the dispersion of material \"paint\"")]
#[case::retroreflection(
    PAINT,
    "type = \"retroreflective\"\nretroreflectance = 0.4\nreflectance = 0.5",
    "the retroreflection of material \"paint\", for which it has no plugin"
)]
#[case::direction(
    PAINT,
    "type = \"conductor\"\nmetal = \"Au\"\nroughness = 0.4\nanisotropy = 0.5",
    "a mesh without UVs"
)]
#[case::model(
    PAINT,
    "type = \"metallic-roughness\"\nbase_colour = 0.5\nroughness = 0.5",
    "the model of material \"paint\" (\"plastic\""
)]
#[case::fisheye("[lens]", "[lens]\nprojection = \"fisheye\"", "the fisheye projection of [lens]")]
#[case::polished_half(
    PAINT,
    "type = \"mix\"\nweight = 0.5\nfirst = { type = \"diffuse\", reflectance = 0.5 }\nsecond = { type = \"conductor\", metal = \"Au\" }",
    "the polished half of material \"paint\""
)]
#[case::pane_before_a_lamp(
    PAINT,
    "type = \"thin-dielectric\"\nindex = 1.5\n[[lights]]\ntype = \"point\"\nposition_m = [0, 1, 1]\nintensity_cd = 100",
    "light of lamps without a surface through material \"paint\""
)]
fn what_has_no_counterpart_is_refused_by_name_or_listed(#[case] from: &str, #[case] to: &str, #[case] named: &str) {
    let folder = triangle();
    folder.add("capture.toml", CAPTURE.replace(from, to));
    let refusal = ["capture.toml", "Mitsuba has no exact counterpart for", "--approximate"];
    folder.fail("export-mitsuba capture.toml -o out", 1, &refusal);
    let outcome = folder.succeed("export-mitsuba capture.toml -o out --approximate");
    assert!(outcome.text().contains("approximated: "), "{}", outcome.stderr);
    assert!(outcome.text().contains(named), "{}", outcome.stderr);
    assert!(outcome.text().contains(named), "{}", outcome.stderr);
    parsed(&std::fs::read_to_string(folder.path("out/scene.xml")).expect("scene.xml"));
}

#[test]
fn colours_of_corners_are_left_out_by_name() {
    let folder = triangle();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n";
    folder.add("scan.ply", ply);
    let paint = "[materials.paint]\ntype = \"diffuse\"\nreflectance = 0.5\n";
    folder.add("capture.toml", CAPTURE.replace("triangle.obj", "scan.ply").replace(paint, ""));
    let outcome = folder.succeed("export-mitsuba capture.toml -o out --approximate");
    assert!(
        outcome.text().contains("the colours of the corners of mesh \"scan\": they are left out"),
        "{}",
        outcome.stderr
    );
}

#[test]
fn everything_of_a_room_can_be_approximated() {
    let folder = room("[render]\nsamples_per_pixel = 1");
    folder.succeed("export-mitsuba capture.toml -o out --approximate --quiet");
    let (_, files) = parsed(&std::fs::read_to_string(folder.path("out/scene.xml")).expect("scene.xml"));
    assert!(files.iter().any(|name| name.ends_with(".exr")) && files.iter().any(|name| name.ends_with(".ply")));
    for name in files {
        assert!(folder.path("out").join(&name).is_file(), "{name} is missing");
    }
}

#[test]
fn an_earlier_scene_is_kept_unless_told_otherwise() {
    let folder = triangle();
    folder.succeed("export-mitsuba capture.toml -o out");
    folder.fail("export-mitsuba capture.toml -o out", 2, &["out already contains a scene", "--force"]);
    folder.succeed("export-mitsuba capture.toml -o out --force");
}
