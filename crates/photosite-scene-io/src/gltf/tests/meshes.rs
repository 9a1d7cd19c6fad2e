//! Triangles and what their corners carry.

use super::*;

#[test]
fn a_square_is_read_alike_from_text_and_binary() {
    for scene in [
        Fixture::square().scene(),
        read_bytes(&Fixture::square().glb(), Path::new("scene.glb"), Choice::default()).expect("a valid file").scene,
    ] {
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.name, "square");
        assert_eq!(mesh.positions[2], Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(mesh.normals, [Vec3::Z; 4]);
        assert_eq!(mesh.uvs, [[Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO]]);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!((scene.instances.len(), scene.instances[0].name.as_str()), (1, "node"));
        assert_eq!((scene.materials.len(), scene.materials[mesh.material].name.as_str()), (1, "default"));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
}

#[rstest]
#[case::u8(5121, vec![0, 1, 2, 0, 2, 3])]
#[case::u16(5123, [0u16, 1, 2, 0, 2, 3].map(u16::to_le_bytes).concat())]
#[case::u32(5125, [0u32, 1, 2, 0, 2, 3].map(u32::to_le_bytes).concat())]
fn every_index_type_is_read(#[case] component: u32, #[case] data: Vec<u8>) {
    let mut fixture = Fixture::square();
    let indices = fixture.accessor("SCALAR", component, 6, &data);
    fixture.primitive()["indices"] = json!(indices);
    assert_eq!(fixture.scene().meshes[0].triangles, [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn corners_without_indices_are_taken_in_order() {
    let mut fixture = Fixture::square();
    fixture.primitive()["mode"] = json!(6);
    fixture.primitive().as_object_mut().expect("an object").remove("indices");
    assert_eq!(fixture.scene().meshes[0].triangles, [[1, 2, 0], [2, 3, 0]]);
}

#[test]
fn points_and_lines_are_left_out_with_one_warning() {
    let scene = Fixture::square().with("/meshes/0/primitives/0/mode", json!(1)).scene();
    assert!(scene.meshes.is_empty() && scene.instances.is_empty());
    assert_eq!(scene.warnings.len(), 1);
}

#[test]
fn strides_offsets_and_sparse_replacements_are_followed() {
    let mut fixture = Fixture::square();
    // Positions in records of 16 bytes, the first of which is skipped.
    let records: Vec<u8> =
        (0..5).flat_map(|i| [i as f32, 0.0, (i * i) as f32, 9.0]).flat_map(f32::to_le_bytes).collect();
    let positions = fixture.accessor("VEC3", 5126, 4, &records);
    let view = fixture.json["accessors"][positions]["bufferView"].as_u64().expect("a view") as usize;
    fixture.json["bufferViews"][view]["byteStride"] = json!(16);
    fixture.json["accessors"][positions]["byteOffset"] = json!(16);
    let targets = fixture.view(&[2]);
    let values = fixture.view(&[7.0f32, 8.0, 9.0].map(f32::to_le_bytes).concat());
    fixture.json["accessors"][positions]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": targets, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    fixture.primitive()["attributes"]["POSITION"] = json!(positions);
    let [x, _, z] = [Vec3::X, Vec3::Y, Vec3::Z];
    assert_eq!(
        fixture.scene().meshes[0].positions,
        [x + z, x * 2.0 + z * 4.0, Vec3::new(7.0, 8.0, 9.0), x * 4.0 + z * 16.0]
    );
}

#[test]
fn normalised_integers_become_fractions() {
    let mut fixture = Fixture::square();
    let uvs = fixture.accessor("VEC2", 5121, 4, &[0, 255, 255, 255, 255, 0, 0, 51]);
    fixture.json["accessors"][uvs]["normalized"] = json!(true);
    fixture.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    assert_eq!(fixture.scene().meshes[0].uvs[0][3], Vec2::new(0.0, 0.2));
}

#[test]
fn a_second_uv_set_alone_stays_the_second() {
    let mut fixture = Fixture::square();
    let attributes = &mut fixture.primitive()["attributes"];
    attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"].take();
    attributes.as_object_mut().expect("an object").remove("TEXCOORD_0");
    let scene = fixture.scene();
    assert_eq!(scene.meshes[0].uvs[0], [Vec2::ZERO; 4]);
    assert_eq!(scene.meshes[0].uvs[1][1], Vec2::ONE);
}

#[test]
fn tangents_are_generated_where_a_normal_map_needs_them_only() {
    let mut plain = Fixture::square().scene();
    crate::complete(&mut plain, &mut crate::ChangedMeshes::default());
    assert!(plain.meshes[0].tangents.is_empty());

    let mut fixture = Fixture::square();
    let pixel = image::RgbImage::from_pixel(1, 1, image::Rgb([128, 128, 255]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    pixel.write_to(&mut bytes, image::ImageFormat::Png).expect("encoded");
    let view = fixture.view(&bytes.into_inner());
    fixture.json["images"] = json!([{ "bufferView": view }]);
    fixture.json["textures"] = json!([{ "source": 0 }]);
    fixture.json["materials"] = json!([{ "normalTexture": { "index": 0, "texCoord": 1 } }]);
    fixture.primitive()["material"] = json!(0);
    fixture.primitive()["attributes"].as_object_mut().expect("an object").remove("NORMAL");
    let mut scene = fixture.scene();
    crate::complete(&mut scene, &mut crate::ChangedMeshes::default());
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.tangents.len(), mesh.positions.len());
    assert_eq!(mesh.normals.len(), mesh.positions.len());
    assert!(mesh.tangents.iter().all(|t: &Vec4| (t.truncate().length() - 1.0).abs() < 1e-6));
    assert!(scene.warnings[0].contains("TEXCOORD_1"), "{:?}", scene.warnings);
}

#[test]
fn vertex_colours_are_read_with_and_without_alpha() {
    let mut fixture = Fixture::square();
    let colours = fixture.accessor("VEC3", 5121, 4, &[255, 0, 51, 0, 255, 0, 0, 0, 0, 9, 9, 9]);
    fixture.json["accessors"][colours]["normalized"] = json!(true);
    // Three bytes a vertex are not aligned; what matters is that they are found.
    fixture.primitive()["attributes"]["COLOR_0"] = json!(colours);
    assert_eq!(fixture.scene().meshes[0].colours[0], Vec4::new(1.0, 0.0, 0.2, 1.0));
    let mut fixture = Fixture::square();
    let colours = fixture.floats("VEC4", &[0.1, 0.2, 0.3, 0.4].repeat(4));
    fixture.primitive()["attributes"]["COLOR_0"] = json!(colours);
    assert_eq!(fixture.scene().meshes[0].colours[3], Vec4::new(0.1, 0.2, 0.3, 0.4));
}

#[test]
fn quantised_positions_are_read_as_they_stand_or_normalised() {
    // KHR_mesh_quantization: the node's scale undoes it.
    let corners: Vec<u8> =
        [0i16, 0, 0, 0, 127, 0, 0, 0, 127, 127, 0, 0, 0, 127, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    for (normalized, expected) in [(false, 127.0), (true, 127.0 / 32767.0)] {
        let mut fixture = Fixture::square().with("/extensionsRequired", json!(["KHR_mesh_quantization"]));
        let positions = fixture.accessor("VEC3", 5122, 4, &corners);
        let view = fixture.json["accessors"][positions]["bufferView"].as_u64().expect("a view") as usize;
        fixture.json["bufferViews"][view]["byteStride"] = json!(8);
        fixture.json["accessors"][positions]["normalized"] = json!(normalized);
        fixture.primitive()["attributes"]["POSITION"] = json!(positions);
        assert_eq!(fixture.scene().meshes[0].positions[2], Vec3::new(expected, expected, 0.0));
    }
}

#[test]
fn zero_area_triangles_are_counted_in_one_warning() {
    let mut fixture = Fixture::square();
    let indices = fixture.accessor("SCALAR", 5121, 9, &[0, 1, 2, 0, 0, 2, 1, 2, 1]);
    fixture.primitive()["indices"] = json!(indices);
    let scene = fixture.scene();
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]]);
    assert_eq!(scene.warnings, ["scene.gltf: 2 triangles of zero area are left out"]);
}
