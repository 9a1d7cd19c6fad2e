//! Documents that cannot be read.

use super::*;

#[test]
fn required_extensions_are_refused_by_name_and_optional_ones_reported_once() {
    let error = Fixture::square().with("/extensionsRequired", json!(["EXT_mesh_lines"])).error();
    assert!(error.contains("EXT_mesh_lines"), "{error}");
    let used = json!(["KHR_materials_subsurface", "KHR_materials_subsurface", "KHR_lights_punctual"]);
    let scene = Fixture::square().with("/extensionsUsed", used).scene();
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.warnings[0].starts_with("scene.gltf: ") && scene.warnings[0].contains("KHR_materials_subsurface"));
}

#[rstest]
#[case::accessor("/meshes/0/primitives/0/attributes/POSITION", json!(99), "meshes[0].primitives[0].attributes.POSITION: refers to accessors[99]")]
#[case::index_accessor("/meshes/0/primitives/0/indices", json!(99), "refers to accessors[99]")]
#[case::view("/accessors/0/bufferView", json!(99), "refers to bufferViews[99]")]
#[case::buffer("/bufferViews/0/buffer", json!(99), "refers to buffers[99]")]
#[case::mesh("/nodes/0/mesh", json!(99), "refers to meshes[99]")]
#[case::camera("/nodes/0/camera", json!(99), "refers to cameras[99]")]
#[case::material("/meshes/0/primitives/0/material", json!(99), "refers to materials[99]")]
#[case::scene("/scene", json!(99), "refers to scenes[99]")]
#[case::light("/nodes/0/extensions", json!({"KHR_lights_punctual": {"light": 99}}), "refers to lights[99]")]
#[case::huge_count("/accessors/0/count", json!(1u64 << 60), "reach beyond")]
#[case::overflowing_count("/accessors/0/count", json!(u64::MAX), "reach beyond")]
#[case::huge_offset("/accessors/0/byteOffset", json!(u64::MAX), "reach beyond")]
#[case::huge_view("/bufferViews/0/byteLength", json!(u64::MAX), "reach beyond")]
#[case::overlapping("/bufferViews/0/byteStride", json!(0), "overlap")]
#[case::wrong_type("/accessors/0/type", json!("VEC2"), "needs VEC3")]
#[case::unknown_component("/accessors/0/componentType", json!(1), "is unknown")]
#[case::float_indices("/accessors/3/componentType", json!(5126), "unsigned")]
#[case::uneven_count("/accessors/1/count", json!(3), "3 entries for 4 positions")]
#[case::no_triangle("/accessors/3/count", json!(2), "make no triangle")]
#[case::torn_triangle("/accessors/3/count", json!(5), "not a multiple of 3")]
#[case::no_vertices("/accessors/0/count", json!(0), "has no vertices")]
#[case::no_primitives("/meshes/0/primitives", json!([]), "is empty")]
#[case::no_positions("/meshes/0/primitives/0/attributes", json!({}), "has no POSITION")]
#[case::mode("/meshes/0/primitives/0/mode", json!(9), "is unknown")]
#[case::version("/asset/version", json!("1.0"), "glTF 1.0 is not supported")]
#[case::not_a_document("/nodes", json!(3), "is not a glTF document")]
fn damaged_documents_are_refused(#[case] pointer: &str, #[case] value: Value, #[case] message: &str) {
    let error = Fixture::square().with(pointer, value).error();
    assert!(error.contains(message), "{error}");
    assert!(error.starts_with("scene.gltf"), "{error}");
}

#[rstest]
#[case::with_its_version(r#"{"asset":{"version":"1.0"},"nodes":{"a":{"meshes":["m"]}},"meshes":{"m":{}}}"#)]
#[case::without_asset(r#"{"scene":"s","scenes":{"s":{"nodes":["a"]}},"nodes":{"a":{}}}"#)]
#[case::of_a_number(r#"{"asset":{"version":0.8},"accessors":{}}"#)]
fn documents_of_the_first_version_are_told_as_such(#[case] text: &str) {
    let error = read_bytes(text.as_bytes(), Path::new("old.gltf"), Choice::default()).expect_err("refused");
    let Error::Input(input) = &error else { panic!("{error:?}") };
    assert!(error.to_string().starts_with("old.gltf: asset.version: is glTF "), "{error}");
    assert!(input.help.as_ref().is_some_and(|help| format!("{help:?}").contains("gltf-pipeline")), "{input:?}");
}

#[test]
fn documents_may_begin_with_a_mark_or_be_in_utf16() {
    let text = Fixture::square().text();
    let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [[b"\xef\xbb\xbf", text.as_bytes()].concat(), [b"\xff\xfe", &wide[..]].concat(), wide] {
        assert_eq!(read_bytes(&bytes, Path::new("a.gltf"), Choice::default()).expect("valid").scene.meshes.len(), 1);
    }
}

#[test]
fn bad_vertices_are_named_with_mesh_primitive_and_line() {
    let mut fixture = Fixture::square();
    let positions = fixture.floats("VEC3", &[0., 0., 0., 1., 0., 0., 1., f32::NAN, 0., 0., 1., 0.]);
    fixture.primitive()["attributes"]["POSITION"] = json!(positions);
    let error = fixture.error();
    assert!(error.contains("meshes[0].primitives[0].attributes.POSITION: vertex 2 is not finite"), "{error}");
    let line = error.split(':').nth(1).and_then(|line| line.parse::<usize>().ok());
    assert!(line.is_some_and(|line| line > 1), "{error}");

    let mut fixture = Fixture::square();
    let indices = fixture.accessor("SCALAR", 5121, 3, &[0, 1, 4]);
    fixture.primitive()["indices"] = json!(indices);
    assert!(fixture.error().contains("triangle 0 uses vertex 4, but there are 4"));
}

#[test]
fn memory_is_not_spent_on_counts_that_nothing_backs() {
    let mut fixture = Fixture::square();
    fixture.json["accessors"][0] = json!({ "componentType": 5126, "count": 1u64 << 40, "type": "VEC3" });
    assert!(fixture.error().contains("too many"));
}

#[test]
fn missing_files_are_named() {
    let fixture = Fixture::square().with("/images", json!([{ "uri": "no%20such.png" }]));
    let fixture = fixture.with("/textures", json!([{ "source": 0 }]));
    let material = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    let error = fixture.with("/materials", material).error();
    assert!(error.contains("images[0].uri") && error.contains("no such.png"), "{error}");
    let text = Fixture::square().with("/buffers", json!([{ "byteLength": 4, "uri": "gone.bin" }])).json.to_string();
    let error =
        read_bytes(text.as_bytes(), Path::new("scene.gltf"), Choice::default()).expect_err("missing").to_string();
    assert!(error.contains("buffers[0].uri") && error.contains("gone.bin"), "{error}");
}

#[test]
fn every_prefix_of_a_binary_file_is_an_error_and_no_panic() {
    let glb = Fixture::square().glb();
    for len in 0..glb.len() {
        let error =
            read_bytes(&glb[..len], Path::new("torn.glb"), Choice::default()).expect_err("truncated").to_string();
        assert!(error.starts_with("torn.glb: "), "{error}");
    }
}

#[test]
fn no_flipped_byte_makes_a_binary_file_panic() {
    let glb = Fixture::square().glb();
    let path = Path::new("flipped.glb");
    for at in 0..glb.len() {
        for flip in [0x01, 0x10, 0x80, 0xff] {
            let mut damaged = glb.clone();
            damaged[at] ^= flip;
            if let Ok(mut file) = read_bytes(&damaged, path, Choice::default()) {
                crate::complete(&mut file.scene, &mut crate::ChangedMeshes::default());
            }
        }
    }
}
