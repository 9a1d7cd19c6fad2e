//! Damaged scenes: refused with one error, or mended with one warning.

use rstest::rstest;
use serde_json::json;

use crate::folder::Folder;
use crate::gltf::{Document, triangle, with_vertices};

fn truncated(document: Document) -> Vec<u8> {
    let mut bytes = document.binary();
    bytes.truncate(bytes.len() - 20);
    bytes
}

fn textured(document: Document) -> Document {
    document
        .with("/images", json!([{ "uri": "wood.png" }]))
        .with("/textures", json!([{ "source": 0 }]))
        .with("/materials/0/pbrMetallicRoughness", json!({ "baseColorTexture": { "index": 0 } }))
}

fn requiring(extension: &str) -> Document {
    triangle().with("/extensionsUsed", json!([extension])).with("/extensionsRequired", json!([extension]))
}

/// Three vertices and a line.
fn obj(line: &str) -> Vec<u8> {
    format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{line}\n").into()
}

/// Not a number at the second vertex.
fn damaged_vertex() -> Document {
    with_vertices([[0.0, 0.0, 0.0], [1.0, f32::NAN, 0.0], [0.0, 1.0, 0.0]], [0, 1, 2])
}

/// One scene file: its name and bytes, what stands on the line at fault where lines are known, what the message says and
/// what it advises.
#[rstest]
#[case::truncated("a.glb", truncated(triangle()), "", "is truncated: it should hold", "copy it again")]
#[case::torn_header("a.glb", b"glTF\x02".to_vec(), "", "is truncated", "the file is damaged")]
#[case::empty_glb("a.glb", vec![], "", "is no glTF document: it ends too early", "glTF 2.0")]
#[case::empty_gltf("a.gltf", vec![], "", "is no glTF document: it ends too early", "glTF 2.0")]
#[case::syntax("a.gltf", b"{\n\"asset\": }".to_vec(), "\"asset\"", "is no glTF document", "glTF 2.0")]
#[case::version(
    "a.gltf",
    triangle().with("/asset/version", json!("1.0")).text(),
    "\"version\"",
    "asset.version: glTF 1.0 is not supported",
    "glTF 2.0"
)]
#[case::extension(
    "a.gltf",
    requiring("KHR_draco_mesh_compression").text(),
    "KHR_draco_mesh_compression",
    "extensionsRequired[0]: the file requires the extension KHR_draco_mesh_compression, which is not supported",
    "export without it"
)]
#[case::index(
    "a.gltf",
    with_vertices([[0.0; 3]; 3], [0, 1, 7]).text(),
    "\"indices\"",
    "meshes[0].primitives[0].indices: triangle 0 uses vertex 7, but there are 3 (counted from 0)",
    "export it again"
)]
#[case::accessor(
    "a.gltf",
    triangle().with("/meshes/0/primitives/0/indices", json!(5)).text(),
    "\"indices\"",
    "meshes[0].primitives[0].indices: refers to accessors[5], but the file has 2 of them",
    "correct the number"
)]
#[case::not_a_number(
    "a.gltf",
    damaged_vertex().text(),
    "\"POSITION\"",
    "meshes[0].primitives[0].attributes.POSITION: vertex 1 is not finite: [1, NaN, 0]",
    "divided by zero"
)]
#[case::not_a_number_glb("a.glb", damaged_vertex().binary(), "", "meshes[0].primitives[0].attributes.POSITION: vertex 1 is not finite", "divided by zero")]
#[case::empty_mesh(
    "a.gltf",
    triangle().with("/accessors/0/count", json!(0)).text(),
    "\"POSITION\"",
    "meshes[0].primitives[0].attributes.POSITION: has no vertices",
    "remove the mesh"
)]
#[case::no_mesh("a.gltf", triangle().with("/scenes/0/nodes", json!([])).text(), "", "has no triangles", "give a scene")]
#[case::singular(
    "a.gltf",
    triangle().with("/nodes/0/scale", json!([1, 0, 1])).text(),
    "\"scale\"",
    "nodes[0].scale: the transform of the node \"sail\" is singular",
    "give every axis a scale other than 0"
)]
#[case::far_away(
    "a.gltf",
    triangle().with("/nodes/0/scale", json!([1, 1e30, 1])).text(),
    "",
    "reaches farther than 1e18 m",
    "correct the scale of its nodes"
)]
#[case::texture("a.gltf", textured(triangle()).text(), "\"wood.png\"", "images[0].uri: cannot read wood.png", "put the file")]
#[case::obj_index("a.obj", obj("f 1 2 9"), "f 1", "f: refers to vertex 9, but the file has 3", "indices count from 1")]
#[case::obj_zero("a.obj", obj("f 0 1 2"), "f 0", "f: \"0\" refers to vertex 0", "indices count from 1")]
#[case::obj_not_a_number("a.obj", obj("v 1 nan 0"), "nan", "v: \"nan\" is not finite", "divided by zero")]
#[case::obj_word("a.obj", obj("v 0 0 zero"), "zero", "v: \"zero\" is no number", "")]
#[case::obj_no_faces("a.obj", obj(""), "", "has no triangles", "export the scene with its faces")]
#[case::obj_zero_area("a.obj", obj("f 1 2 1"), "", "has no triangles but 1 of zero area", "")]
#[case::obj_empty("a.obj", vec![], "", "has no triangles", "")]
fn damaged_scenes_are_refused(
    #[case] name: &str,
    #[case] bytes: Vec<u8>,
    #[case] line: &str,
    #[case] message: &str,
    #[case] help: &str,
) {
    let place = match String::from_utf8_lossy(&bytes).lines().collect::<Vec<_>>().iter().rposition(|l| l.contains(line))
    {
        Some(index) if !line.is_empty() => format!("{name}:{}: ", index + 1),
        _ => format!("{name}: "),
    };
    let folder = Folder::new([(name, bytes)]);
    folder.fail(&format!("render {name}"), 1, &[&format!("{place}{message}"), help]);
}

#[rstest]
#[case::missing(None, "cannot read wood.png", "put the picture there")]
#[case::torn(Some("\u{89}PNG"), "cannot decode wood.png", "export it again")]
fn textures_of_obj_materials_are_named_by_their_line(
    #[case] picture: Option<&str>,
    #[case] message: &str,
    #[case] help: &str,
) {
    let folder = Folder::new([
        ("a.obj", b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n".to_vec()),
        ("a.mtl", b"newmtl m\nKd 1 1 1\nmap_Kd wood.png\n".to_vec()),
    ]);
    if let Some(picture) = picture {
        folder.add("wood.png", picture);
    }
    folder.fail("render a.obj", 1, &["a.mtl:3: map_Kd: ", message, help]);
}

/// Documents that programs write may be a single line of megabytes.
#[test]
fn long_lines_are_not_printed() {
    let document =
        triangle().with("/nodes/0/scale", json!([1, 0, 1])).with("/asset/generator", json!("x".repeat(5000)));
    let folder = Folder::new([("a.gltf", serde_json::to_vec(&document.json).expect("JSON"))]);
    let outcome = folder.fail("render a.gltf", 1, &["a.gltf:1: "]);
    assert!(outcome.stderr.len() < 1000, "{} bytes", outcome.stderr.len());
}

/// Long messages and paths stay in one piece where they are written to a file.
#[test]
fn messages_are_not_broken_into_lines() {
    let name = format!("{}/{}.obj", "a-folder-of-a-long-name".repeat(8), "b".repeat(100));
    let folder = Folder::new([(name.as_str(), b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n".to_vec())]);
    let outcome = folder.fail(&format!("render {name}"), 1, &[]);
    assert!(outcome.stderr.contains(&format!("{name}:4: f: refers to vertex 9, but the file has 3")), "{outcome:?}");
}

const SMALL: &str = "--set sensor.resolution_px=[16,12] --set render.samples_per_pixel=2";

#[test]
fn triangles_of_zero_area_are_skipped_and_counted() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 3\nf 1 2 2\n";
    let folder = Folder::new([("a.obj", obj.into())]);
    let outcome = folder.succeed(&format!("render a.obj -o out {SMALL}"));
    let warning = "a.obj: 3 triangles of zero area are left out";
    assert_eq!(outcome.stderr.matches("warning: ").count(), 1);
    assert!(outcome.stderr.contains(&format!("warning: {warning}\n")), "{}", outcome.stderr);
    let report = folder.report("out");
    assert_eq!((&report["warnings"], &report["render"]["triangles"]), (&json!([warning]), &json!(1)));
}

#[test]
fn unsupported_extensions_that_are_optional_are_warned_of_once() {
    let names = ["EXT_of_someone", "EXT_of_someone", "EXT_unheard_of", "KHR_texture_transform"];
    let folder = Folder::new([("a.gltf", triangle().with("/extensionsUsed", json!(names)).text())]);
    let outcome = folder.succeed(&format!("render a.gltf -o out {SMALL}"));
    let warnings: Vec<&str> = outcome.stderr.lines().filter(|line| line.starts_with("warning: ")).collect();
    assert_eq!(
        warnings,
        [
            "warning: a.gltf: the extension EXT_of_someone is not supported and is ignored",
            "warning: a.gltf: the extension EXT_unheard_of is not supported and is ignored"
        ]
    );
}
