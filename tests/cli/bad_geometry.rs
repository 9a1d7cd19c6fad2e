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

/// Three vertices and a face.
fn ply(face: &str) -> Vec<u8> {
    let head = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1";
    let list = "property list uchar int vertex_indices";
    format!("ply\nformat ascii 1.0\n{head}\n{list}\nend_header\n0 0 0\n1 0 0\n0 1 0\n{face}\n").into()
}

/// Not a number at the second vertex.
fn damaged_vertex() -> Document {
    with_vertices([[0.0, 0.0, 0.0], [1.0, f32::NAN, 0.0], [0.0, 1.0, 0.0]], [0, 1, 2])
}

/// One scene file: its name and bytes, what stands on the line at fault where lines are known, what the message says
/// and what it advises.
#[rstest]
#[case::truncated("a.glb", truncated(triangle()), "", "is truncated: it should hold", "copy it again")]
#[case::torn_header("a.glb", b"glTF\x02".to_vec(), "", "is truncated", "the file is damaged")]
#[case::empty_glb("a.glb", vec![], "", "is not a glTF document: it ends too early", "glTF 2.0")]
#[case::empty_gltf("a.gltf", vec![], "", "is not a glTF document: it ends too early", "glTF 2.0")]
#[case::syntax("a.gltf", b"{\n\"asset\": }".to_vec(), "\"asset\"", "is not a glTF document", "glTF 2.0")]
#[case::version(
    "a.gltf",
    triangle().with("/asset/version", json!("1.0")).text(),
    "\"version\"",
    "asset.version: glTF 1.0 is not supported",
    "glTF 2.0"
)]
#[case::extension(
    "a.gltf",
    requiring("KHR_node_hoverability").text(),
    "KHR_node_hoverability",
    "extensionsRequired[0]: the file requires the extension KHR_node_hoverability, which is not supported",
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
#[case::obj_word("a.obj", obj("v 0 0 zero"), "zero", "v: \"zero\" is not a number", "")]
#[case::obj_no_faces("a.obj", obj(""), "", "has no triangles", "export the scene with its faces")]
#[case::obj_zero_area("a.obj", obj("f 1 2 1"), "", "has no triangles but 1 of zero area", "")]
#[case::obj_empty("a.obj", vec![], "", "has no triangles", "")]
#[case::ply_index(
    "a.ply",
    ply("3 0 1 9"),
    "0 1 9",
    "face 0: refers to vertex 9, but there are 3",
    "copy or export it again"
)]
#[case::ply_cloud("a.ply", b"ply\nformat ascii 1.0\nelement vertex 9\nend_header\n".to_vec(), "", "is a cloud of 9 points", "Poisson")]
#[case::ply_empty("a.ply", vec![], "", "is not a PLY file", "begins with the line \"ply\"")]
#[case::stl_torn("a.stl", b"solid a\nfacet normal 0 0 1\n".to_vec(), "facet", "the file ends where \"outer\" must follow", "copy or export")]
#[case::stl_short("a.stl", vec![1; 99], "", "is truncated: 16843009 facets are announced, but only 0 follow", "copy or export")]
#[case::stl_empty("a.stl", vec![], "", "is not an STL file", "")]
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
    folder.refuse(name, &[&format!("{place}{message}"), help]);
}

/// A document whose buffer is read from another place.
fn from_uri(uri: &str) -> Vec<u8> {
    serde_json::to_vec_pretty(&triangle().with("/buffers/0/uri", json!(uri)).json).expect("JSON")
}

/// A binary file with other bytes at a place.
fn overwritten(at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut whole = triangle().binary();
    whole[at..at + bytes.len()].copy_from_slice(bytes);
    whole
}

fn sparse(count: u64, component: u32) -> serde_json::Value {
    json!({
        "count": count,
        "indices": { "bufferView": 1, "componentType": component },
        "values": { "bufferView": 0 },
    })
}

fn sampled(sampler: serde_json::Value) -> Document {
    textured(triangle()).with("/textures", json!([{ "source": 0, "sampler": 0 }])).with("/samplers", json!([sampler]))
}

fn with_attribute(name: &str, accessor: u32) -> Document {
    triangle()
        .with(&format!("/meshes/0/primitives/0/attributes/{name}"), json!(accessor))
        .with("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(0))
        .with("/nodes/0/skin", json!(0))
        .with("/skins", json!([{ "joints": [0] }]))
}

/// References that lead nowhere or round in circles, numbers of the wrong kind, counts that nothing backs, chunks that
/// are cut: one error that names the place.
#[rstest]
#[case::image(textured(triangle()).with("/textures", json!([{ "source": 3 }])), "textures[0].source: refers to images[3]")]
#[case::sampler(textured(triangle()).with("/textures", json!([{ "source": 0, "sampler": 2 }])), "textures[0].sampler: refers to samplers[2]")]
#[case::no_image(textured(triangle()).with("/images", json!([{ "mimeType": "image/png" }])), "images[0]: has neither a uri nor a bufferView")]
#[case::uv_set(textured(triangle()).with("/materials/0/pbrMetallicRoughness/baseColorTexture", json!({ "index": 0, "texCoord": 2 })), "uses TEXCOORD_2")]
#[case::wrap(sampled(json!({ "wrapS": 1 })), "samplers[0].wrapS: is unknown")]
#[case::filter(sampled(json!({ "magFilter": 1 })), "samplers[0]: has an unknown filter")]
#[case::alpha_mode(triangle().with("/materials/0/alphaMode", json!("GLASS")), "materials[0].alphaMode: is unknown")]
#[case::sparse_target(with_vertices([[0.0; 3]; 3], [9, 0, 1]).with("/accessors/0/sparse", sparse(1, 5123)), "accessors[0].sparse.indices: entry 0 replaces element 9 of only 3")]
#[case::sparse_component(triangle().with("/accessors/0/sparse", sparse(1, 5126)), "accessors[0].sparse.indices.componentType: is not an unsigned integer type")]
#[case::sparse_count(triangle().with("/accessors/0/sparse", sparse(1 << 40, 5123)), "reach beyond")]
#[case::skin(triangle().with("/nodes/0/skin", json!(4)), "nodes[0].skin: refers to skins[4]")]
#[case::joint(triangle().with("/nodes/0/skin", json!(0)).with("/skins", json!([{ "joints": [7] }])), "skins[0].joints[0]: refers to nodes[7]")]
#[case::joints(with_attribute("JOINTS_0", 0), "JOINTS_0 needs VEC4")]
#[case::binds(triangle().with("/nodes/0/skin", json!(0)).with("/skins", json!([{ "joints": [0], "inverseBindMatrices": 0 }])), "inverseBindMatrices needs MAT4")]
#[case::morph_target(triangle().with("/meshes/0/primitives/0/targets", json!([{ "POSITION": 9 }])).with("/nodes/0/weights", json!([1])), "refers to accessors[9]")]
#[case::morph_kind(triangle().with("/meshes/0/primitives/0/targets", json!([{ "POSITION": 1 }])).with("/nodes/0/weights", json!([1])), "needs VEC3")]
#[case::rotation(triangle().with("/nodes/0/rotation", json!([0, 0, 0, 0])), "nodes[0].rotation: ")]
#[case::projective(triangle().with("/nodes/0/matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])), "nodes[0].matrix: ")]
#[case::child(triangle().with("/nodes/0/children", json!([5])), "nodes[0].children[0]: refers to nodes[5]")]
#[case::cycle(triangle().with("/nodes/0/children", json!([0])), "cycle")]
#[case::twice(triangle().with("/scenes/0/nodes", json!([0, 0])), "nodes[0] appears in the hierarchy twice")]
#[case::instances(triangle().with("/nodes/0/extensions", json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 9 } } })), "refers to accessors[9]")]
#[case::camera(triangle().with("/nodes/0/camera", json!(0)).with("/cameras", json!([{ "type": "perspective", "perspective": { "yfov": 0, "znear": 0.1 } }])), "cameras[0].perspective.yfov: must lie between 0 and π")]
fn damaged_references_are_refused(#[case] document: Document, #[case] message: &str) {
    refused(document.text(), "a.gltf", message);
}

#[rstest]
#[case::no_comma("a.gltf", from_uri("data:nothing"), "is a data URI without a comma")]
#[case::base64("a.gltf", from_uri("data:application/octet-stream;base64,@@@@"), "invalid base64")]
#[case::scheme("a.gltf", from_uri("https://example.org/a.bin"), "has the scheme \"https\"")]
#[case::short("a.gltf", from_uri("data:application/octet-stream;base64,AAAA"), "buffers[0].byteLength")]
#[case::missing("a.gltf", from_uri("gone.bin"), "cannot read gone.bin")]
#[case::glb_version("a.glb", overwritten(4, &[1]), "is binary glTF of version 1")]
#[case::glb_length("a.glb", overwritten(8, &[0xff; 4]), "should hold 4294967295 bytes")]
#[case::chunk_length("a.glb", overwritten(12, &[0xff; 4]), "the chunk \"JSON\" should hold 4294967295 bytes")]
#[case::no_json("a.glb", overwritten(16, b"XXXX"), "without a JSON chunk")]
fn damaged_containers_are_refused(#[case] name: &str, #[case] bytes: Vec<u8>, #[case] message: &str) {
    refused(bytes, name, message);
}

fn refused(bytes: Vec<u8>, name: &str, message: &str) {
    Folder::new([(name, bytes)]).refuse(name, &[name, message]);
}

#[rstest]
#[case::missing(None, "cannot read wood.png", "put the image there")]
#[case::torn(Some("\u{89}PNG"), "cannot decode wood.png", "export it again")]
fn textures_of_obj_materials_are_named_by_their_line(
    #[case] image: Option<&str>,
    #[case] message: &str,
    #[case] help: &str,
) {
    let folder = Folder::new([
        ("a.obj", b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n".to_vec()),
        ("a.mtl", b"newmtl m\nKd 1 1 1\nmap_Kd wood.png\n".to_vec()),
    ]);
    if let Some(image) = image {
        folder.add("wood.png", image);
    }
    folder.refuse("a.obj", &["a.mtl:3: map_Kd: ", message, help]);
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
    let outcome = folder.succeed(&format!("render a.obj -o out {SMALL} --set scene.environment=even"));
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
