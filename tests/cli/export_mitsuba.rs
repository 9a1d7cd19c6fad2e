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
    let text = folder.text("out/scene.xml");
    let (objects, files) = parsed(&text);
    for kind in ["path", "thinlens", "specfilm", "box", "twosided", "diffuse", "constant", "ply"] {
        assert!(objects.contains(kind), "{kind} is missing in {objects:?}");
    }
    assert_eq!(files.into_iter().collect::<Vec<_>>(), ["meshes/0.ply"]);
    let ply = folder.bytes("out/meshes/0.ply");
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                  property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    assert!(ply.starts_with(header.as_bytes()));
    // Three corners of three floats; a count and three indices.
    assert_eq!(ply.len() - header.len(), 3 * 12 + 1 + 12);
}

#[rstest]
#[case::once("falloff = \"none\"", "", &["the falloff of [lens]"])]
#[case::twice(
    "falloff = \"none\"",
    "blades = 6",
    &["the falloff of [lens]: Mitsuba's cameras have none", "an aperture with blades: it becomes round"]
)]
fn what_has_no_counterpart_is_refused_by_name_or_listed(#[case] from: &str, #[case] to: &str, #[case] named: &[&str]) {
    let folder = triangle();
    folder.add("capture.toml", CAPTURE.replace(from, to));
    let refusal = ["capture.toml", "Mitsuba has no exact counterpart for", "--approximate"];
    folder.fail("export-mitsuba capture.toml -o out", 1, &refusal);
    let outcome = folder.succeed("export-mitsuba capture.toml -o out --approximate");
    assert!(outcome.text().contains("approximated: "), "{}", outcome.stderr);
    assert!(named.iter().all(|named| outcome.text().contains(named)), "{}", outcome.stderr);
    parsed(&folder.text("out/scene.xml"));
}

/// Every type of material: its keys, and what is said of it; nothing where Mitsuba has the same.
const TYPES: [(&str, &str, &str); 11] = [
    ("diffuse", "reflectance = 0.5", ""),
    ("conductor", "metal = 'Au'", ""),
    ("dielectric", "index = 1.5", ""),
    ("metallic-roughness", "base_colour = [0.5, 0.5, 0.5]\nroughness = 0.3", "the \"metallic-roughness\" model of"),
    ("oren-nayar", "reflectance = 0.5\nroughness = 0.3", "of the type \"oren-nayar\""),
    ("plastic", "reflectance = 0.5", "the \"plastic\" model of"),
    ("thin-dielectric", "index = 1.5", ""),
    ("translucent", "reflectance = 0.3\ntransmittance = 0.3", "of the type \"translucent\""),
    ("phong", "diffuse = 0.3\nspecular = 0.3\nexponent = 20", "Phong's lobe of"),
    ("retroreflective", "retroreflectance = 0.3\nreflectance = 0.1", "of the type \"retroreflective\""),
    (
        "mix",
        "first = { type = 'diffuse', reflectance = 0.5 }\nsecond = { type = 'plastic', reflectance = 0.2 }\nweight = 0.5",
        "the \"plastic\" model of",
    ),
];

#[test]
fn every_type_of_material_is_named_as_its_capture_names_it() {
    let schema: serde_json::Value =
        serde_json::from_str(include_str!("../../assets/capture.schema.json")).expect("JSON");
    let all = schema["$defs"]["TypedMaterialTable"]["oneOf"].as_array().expect("types");
    let all: Vec<&str> = all.iter().filter_map(|one| one["properties"]["type"]["const"].as_str()).collect();
    assert_eq!(all, TYPES.map(|(kind, ..)| kind), "the table has every type");
    for (kind, keys, said) in TYPES {
        let folder = triangle();
        let material = format!("type = \"{kind}\"\n{keys}\n");
        folder.add("capture.toml", CAPTURE.replace("type = \"diffuse\"\nreflectance = 0.5\n", &material));
        let outcome = folder.succeed("export-mitsuba capture.toml -o out --approximate");
        let told: Vec<&str> = outcome.stderr.lines().filter(|line| line.contains("paint")).collect();
        assert_eq!(told.is_empty(), said.is_empty(), "{kind}: {}", outcome.stderr);
        assert!(outcome.text().contains(said), "{kind}: {}", outcome.stderr);
        // Mitsuba's own names stand behind a colon.
        let ours = told.iter().map(|line| line.rsplit_once(": ").map_or(*line, |(ours, _)| ours)).collect::<String>();
        let is_part = |other: &str| other == kind || kind == "mix" && other == "plastic";
        let names = TYPES.map(|(other, ..)| other).into_iter().filter(|other| !is_part(other));
        let named: Vec<&str> = names.filter(|other| ours.contains(&format!("{other:?}"))).collect();
        assert!(named.is_empty(), "{kind}: {named:?} in {}", outcome.stderr);
    }
}

#[test]
fn everything_of_a_room_can_be_approximated() {
    let folder = room("[render]\nsamples_per_pixel = 1");
    folder.succeed("export-mitsuba capture.toml -o out --approximate --quiet");
    let (_, files) = parsed(&folder.text("out/scene.xml"));
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
