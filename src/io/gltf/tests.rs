//! Whole documents, made here: what they mean, and what happens when they are damaged.

use std::path::Path;

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use rstest::rstest;
use serde_json::{Value, json};

use super::*;
use crate::scene::description::{AlphaMode, Colour, LightKind, MaterialModel};
use crate::texture::{Filter, Texels, Wrap};

/// A document under construction: accessors over one buffer.
struct Fixture {
    json: Value,
    bytes: Vec<u8>,
}

impl Fixture {
    /// One node with one mesh: a unit square of two triangles in the xy plane, with normals and UVs.
    fn square() -> Self {
        let mut fixture = Self {
            json: json!({
                "asset": { "version": "2.0" },
                "scene": 0,
                "scenes": [{ "nodes": [0] }],
                "nodes": [{ "name": "node", "mesh": 0 }],
                "buffers": [], "bufferViews": [], "accessors": [],
            }),
            bytes: Vec::new(),
        };
        let positions = fixture.floats("VEC3", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
        let normals = fixture.floats("VEC3", &[0., 0., 1.].repeat(4));
        let uvs = fixture.floats("VEC2", &[0., 1., 1., 1., 1., 0., 0., 0.]);
        let indices = fixture.accessor("SCALAR", 5123, 6, &[0u16, 1, 2, 0, 2, 3].map(u16::to_le_bytes).concat());
        fixture.json["meshes"] = json!([{ "name": "square", "primitives": [{
            "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs },
            "indices": indices,
        }]}]);
        fixture
    }

    /// Appends data with a view and an accessor of its own; returns the accessor's index.
    fn accessor(&mut self, kind: &str, component: u32, count: usize, data: &[u8]) -> usize {
        let view = self.view(data);
        let accessors = self.json["accessors"].as_array_mut().expect("an array");
        accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        accessors.len() - 1
    }

    fn view(&mut self, data: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let views = self.json["bufferViews"].as_array_mut().expect("an array");
        views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": data.len() }));
        self.bytes.extend_from_slice(data);
        views.len() - 1
    }

    fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|k| *k == kind).map_or(16, |i| i + 1);
        let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(kind, 5126, values.len() / width, &data)
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Sets the value at a JSON pointer, making what is missing on the way.
    fn with(mut self, pointer: &str, value: Value) -> Self {
        let mut place = &mut self.json;
        for step in pointer.split('/').skip(1) {
            place = match step.parse::<usize>() {
                Ok(index) => &mut place[index],
                Err(_) => &mut place[step],
            };
        }
        *place = value;
        self
    }

    /// With the buffer as a data URI.
    fn text(mut self) -> String {
        use base64::Engine;
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        let uri = format!("data:application/octet-stream;base64,{data}");
        self.json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        serde_json::to_string_pretty(&self.json).expect("JSON")
    }

    fn glb(mut self) -> Vec<u8> {
        self.json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        let mut json = self.json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let length = 12 + 8 + json.len() + 8 + self.bytes.len();
        let mut glb = b"glTF".to_vec();
        for (bytes, kind) in [(&json, b"JSON"), (&self.bytes, b"BIN\0")] {
            if glb.len() == 4 {
                glb.extend([2, length as u32].map(u32::to_le_bytes).concat());
            }
            glb.extend((bytes.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(bytes);
        }
        glb
    }

    fn read(self) -> Result<SceneDescription> {
        self.variant(None).map(|file| file.scene)
    }

    fn variant(self, variant: Option<&str>) -> Result<GltfFile> {
        read_bytes(self.text().as_bytes(), Path::new("scene.gltf"), Choice { variant, moment: None })
    }

    fn scene(self) -> SceneDescription {
        self.read().expect("a valid document")
    }

    fn error(self) -> String {
        self.read().expect_err("to be refused").to_string()
    }
}

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
fn a_material_keeps_all_it_says() {
    let picture = {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let pixels = image::RgbaImage::from_pixel(2, 2, image::Rgba([1, 2, 3, 4]));
        pixels.write_to(&mut bytes, image::ImageFormat::Png).expect("encoded");
        bytes.into_inner()
    };
    let mut fixture = Fixture::square();
    let view = fixture.view(&picture);
    fixture.json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    fixture.json["samplers"] = json!([{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }]);
    fixture.json["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    let moved =
        json!({ "KHR_texture_transform": { "offset": [0.5, 0.25], "rotation": 1.5, "scale": [2, 3], "texCoord": 0 }});
    fixture.json["materials"] = json!([{
        "name": "paint",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6,
            "baseColorTexture": { "index": 0, "texCoord": 1, "extensions": moved },
        },
        "normalTexture": { "index": 0, "scale": 0.7, "extensions": moved },
        "emissiveFactor": [1.0, 0.5, 0.0],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 300.0 } },
        "alphaMode": "MASK", "doubleSided": true,
    }]);
    fixture.primitive()["material"] = json!(0);
    let scene = fixture.scene();
    assert_eq!(scene.images.len(), 1, "an image is decoded once");
    assert!(matches!(&scene.images[0].texels, Texels::Rgba8(t) if t[3] == [1, 2, 3, 4]));
    let material = &scene.materials[0];
    assert_eq!((material.name.as_str(), material.double_sided, material.alpha_factor), ("paint", true, 0.4));
    assert_eq!(material.alpha, AlphaMode::Mask { cutoff: 0.5 });
    assert!(material.alpha_texture.is_some());
    let MaterialModel::Layered(layers) = &material.model else { panic!("{:?}", material.model) };
    let (Colour::Rgb(base), Some(texture)) = (&layers.base_colour.colour, &layers.base_colour.texture) else {
        panic!("{:?}", layers.base_colour)
    };
    assert_eq!((*base, layers.metallic.value, layers.roughness.value), ([0.1, 0.2, 0.3], 0.5, 0.6));
    assert_eq!(texture.uv_set, 0, "the transform overrides texCoord");
    assert_eq!(texture.sampler.wrap, [Wrap::ClampToEdge, Wrap::MirroredRepeat]);
    assert_eq!(texture.sampler.filter, Filter::Nearest);
    let (normal, scale) = material.normal_map.as_ref().expect("a normal map");
    assert_eq!((*scale, normal.transform.rotation_rad, normal.transform.scale), (0.7, 1.5, Vec2::new(2.0, 3.0)));
    let emission = material.emission.as_ref().expect("emission");
    assert!(matches!(emission.colour, Colour::Rgb([1.0, 0.5, 0.0])) && emission.level == Some(300.0));
}

#[test]
fn cameras_and_lights_stand_where_their_nodes_are() {
    let mut fixture = Fixture::square();
    fixture.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]);
    fixture.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "intensity": 40.0, "color": [1.0, 0.9, 0.8], "spot": { "outerConeAngle": 0.6 } },
        { "type": "directional", "name": "sun", "intensity": 1000.0 },
    ]}});
    fixture.json["nodes"] = json!([
        { "name": "rig", "scale": [2, 2, 2], "translation": [0, 1, 0], "children": [1, 2, 3] },
        { "name": "eye", "camera": 0, "translation": [0, 0, 3] },
        { "name": "lamp", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "extensions": { "KHR_lights_punctual": { "light": 1 } } },
    ]);
    let scene = fixture.scene();
    let camera = &scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.vertical_fov_rad), ("eye", 0.5));
    assert_eq!(camera.to_world.translation, DVec3::new(0.0, 1.0, 6.0));
    assert_eq!(camera.to_world.matrix3.determinant(), 1.0, "the scale of the parent is left out");
    assert_eq!(scene.lights[0].kind, LightKind::Spot { inner_rad: 0.0, outer_rad: 0.6 });
    assert_eq!((scene.lights[0].name.as_str(), scene.lights[0].emission.level), ("lamp", Some(40.0)));
    assert_eq!((scene.lights[1].name.as_str(), scene.lights[1].kind), ("sun", LightKind::Directional));
}

#[test]
fn tangents_are_generated_where_a_normal_map_needs_them_only() {
    let mut plain = Fixture::square().scene();
    crate::io::complete(&mut plain);
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
    crate::io::complete(&mut scene);
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.tangents.len(), mesh.positions.len());
    assert_eq!(mesh.normals.len(), mesh.positions.len());
    assert!(mesh.tangents.iter().all(|t: &Vec4| (t.truncate().length() - 1.0).abs() < 1e-6));
    assert!(scene.warnings[0].contains("TEXCOORD_1"), "{:?}", scene.warnings);
}

#[test]
fn required_extensions_are_refused_by_name_and_optional_ones_reported_once() {
    let error = Fixture::square().with("/extensionsRequired", json!(["KHR_draco_mesh_compression"])).error();
    assert!(error.contains("KHR_draco_mesh_compression"), "{error}");
    let used = json!(["KHR_materials_subsurface", "KHR_materials_subsurface", "KHR_lights_punctual"]);
    let scene = Fixture::square().with("/extensionsUsed", used).scene();
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.warnings[0].starts_with("scene.gltf: ") && scene.warnings[0].contains("KHR_materials_subsurface"));
}

#[test]
fn extensions_of_materials_are_read_with_their_defaults() {
    let with = |extensions: Value| {
        let scene = Fixture::square().with("/materials", json!([{ "extensions": extensions }])).scene();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let MaterialModel::Layered(layers) = &scene.materials[0].model else { panic!("not layered") };
        layers.clone()
    };
    let plain = with(json!({}));
    assert!((plain.index.index(589.0) - 1.5).abs() < 1e-9 && plain.metallic.value == 1.0);
    assert!(plain.coat.is_none() && plain.sheen.is_none() && plain.film.is_none() && plain.absorption_per_m.is_none());
    let index = with(json!({ "KHR_materials_ior": { "ior": 1.7 }, "KHR_materials_dispersion": { "dispersion": 0.5 } }));
    assert!((index.index.abbe_number() - 40.0).abs() < 0.01 && (index.index.index(587.5618) - 1.7).abs() < 1e-4);
    assert_eq!(with(json!({ "KHR_materials_ior": { "ior": 0 } })).normal_reflectance, Some(1.0));
    let thin = with(json!({ "KHR_materials_transmission": { "transmissionFactor": 0.8 }, "KHR_materials_volume": {} }));
    assert!(thin.transmission.value == 0.8 && thin.absorption_per_m.is_none());
    let volume = json!({ "thicknessFactor": 0.1, "attenuationDistance": 0.5, "attenuationColor": [0.25, 0.25, 0.25] });
    let thick = with(json!({ "KHR_materials_volume": volume }));
    // A grey of 1/4 after half a metre: ln 4 / 0.5 m at every wavelength.
    let absorption = thick.absorption_per_m.expect("a volume");
    assert!((f64::from(absorption.eval(500.0)) - 4f64.ln() / 0.5).abs() < 1e-5);
    let coat = with(json!({ "KHR_materials_clearcoat": { "clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.2 } }));
    assert!(coat.coat.is_some_and(|coat| coat.weight.value == 1.0 && coat.roughness.value == 0.2));
    let film = with(json!({ "KHR_materials_iridescence": { "iridescenceFactor": 1.0 } })).film.expect("a film");
    assert_eq!((film.index, film.thickness_nm), (1.3, [100.0, 400.0]));
    assert!(with(json!({ "KHR_materials_sheen": {} })).sheen.is_none());
    let leaf = json!({ "diffuseTransmissionFactor": 0.4 });
    let (part, _) = with(json!({ "KHR_materials_diffuse_transmission": leaf })).diffuse_transmission.expect("a leaf");
    assert_eq!(part.value, 0.4);
    let glossy = json!({ "glossinessFactor": 0.75, "specularFactor": [0.5, 0.25, 0.125] });
    let glossy = with(json!({ "KHR_materials_pbrSpecularGlossiness": glossy }));
    assert_eq!((glossy.roughness.value, glossy.metallic.value, glossy.normal_reflectance), (0.25, 0.0, Some(1.0)));
    assert!(matches!(glossy.specular_colour.colour, Colour::Rgb([0.5, 0.25, 0.125])));
}

#[rstest]
#[case::index("KHR_materials_ior", json!({ "ior": 0.5 }), "materials[0].extensions.KHR_materials_ior.ior: must be at least 1")]
#[case::film("KHR_materials_iridescence", json!({ "iridescenceIor": -1 }), "iridescenceIor: must be at least 1")]
#[case::distance("KHR_materials_volume", json!({ "thicknessFactor": 1, "attenuationDistance": 0 }), "must be above 0")]
#[case::negative("KHR_materials_dispersion", json!({ "dispersion": -1 }), "must not be negative")]
#[case::kind("KHR_materials_sheen", json!({ "sheenColorFactor": "red" }), "KHR_materials_sheen: invalid type")]
#[case::texture("KHR_materials_clearcoat", json!({ "clearcoatTexture": { "index": 7 } }), "refers to textures[7]")]
fn impossible_extensions_are_refused(#[case] name: &str, #[case] table: Value, #[case] message: &str) {
    let error = Fixture::square().with("/materials", json!([{ "extensions": { name: table } }])).error();
    assert!(error.contains(message), "{error}");
}

#[test]
fn a_variant_is_chosen_by_its_name() {
    let fixture = || {
        let mut fixture = Fixture::square().with("/materials", json!([{ "name": "red" }, { "name": "blue" }]));
        let variants = json!({ "variants": [{ "name": "summer" }, { "name": "winter" }] });
        fixture.json["extensions"] = json!({ "KHR_materials_variants": variants });
        fixture.primitive()["material"] = json!(0);
        let mappings = json!({ "mappings": [{ "variants": [1], "material": 1 }] });
        fixture.primitive()["extensions"] = json!({ "KHR_materials_variants": mappings });
        fixture
    };
    for (variant, material) in [(None, 0), (Some("summer"), 0), (Some("winter"), 1), (Some("autumn"), 0)] {
        let file = fixture().variant(variant).expect("valid");
        assert_eq!(file.variants, ["summer", "winter"]);
        assert_eq!(file.scene.meshes[0].material, material, "{variant:?}");
    }
    assert!(fixture().with("/extensions/KHR_materials_variants", json!(3)).error().contains("KHR_materials_variants"));
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
fn morph_targets_move_vertices_by_their_weights() {
    let morphed = || {
        let mut fixture = Fixture::square();
        let up = fixture.floats("VEC3", &[0., 0., 1.].repeat(4));
        let right = fixture.floats("VEC3", &[2., 0., 0.].repeat(4));
        fixture.primitive()["targets"] = json!([{ "POSITION": up }, { "POSITION": right }]);
        fixture
    };
    let first = |fixture: Fixture| fixture.scene().meshes[0].positions[0];
    assert_eq!(first(morphed()), Vec3::ZERO);
    assert_eq!(first(morphed().with("/meshes/0/weights", json!([0.5, 0.25]))), Vec3::new(0.5, 0.0, 0.5));
    let by_node = morphed().with("/meshes/0/weights", json!([0.5, 0.25])).with("/nodes/0/weights", json!([0, 1]));
    assert_eq!(first(by_node), Vec3::new(2.0, 0.0, 0.0));
    let mut torn = morphed().with("/meshes/0/weights", json!([1, 1]));
    let short = torn.floats("VEC3", &[0.0; 9]);
    torn.primitive()["targets"][1]["POSITION"] = json!(short);
    assert!(torn.error().contains("targets[1].POSITION: has 3 entries for 4 vertices"));
}

#[test]
fn skinned_vertices_follow_their_joints() {
    let mut fixture = Fixture::square();
    let joints = fixture.accessor("VEC4", 5121, 4, &[[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]].concat());
    let weights =
        fixture.floats("VEC4", &[[1., 0., 0., 0.], [1., 0., 0., 0.], [0.5, 0.5, 0., 0.], [0., 0., 0., 0.]].concat());
    // The second joint was bound one unit along x, and stands three along x now: it moves what follows it by two.
    let unmoved = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
    let mut bound = unmoved;
    bound[12] = -1.0;
    let binds = fixture.floats("MAT4", &[unmoved, bound].concat());
    fixture.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    fixture.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    fixture.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "translation": [50, 0, 0] }, {}, { "translation": [3, 0, 0] }
    ]);
    fixture.json["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    fixture.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": binds }]);
    let text = fixture.text();
    let file = read_bytes(text.as_bytes(), Path::new("scene.gltf"), Choice::default()).expect("valid");
    let [x, y] = [Vec3::X, Vec3::Y];
    assert_eq!(file.scene.meshes[0].positions, [Vec3::ZERO, x * 3.0, x * 2.0 + y, y]);
    assert_eq!(file.scene.instances[0].to_world, DAffine3::IDENTITY);
    let error = |from: &str, to: &str| {
        let damaged = text.replace(from, to);
        assert_ne!(damaged, text);
        read_bytes(damaged.as_bytes(), Path::new("scene.gltf"), Choice::default()).expect_err("damaged").to_string()
    };
    assert!(error("\"skin\": 0", "\"skin\": 4").contains("refers to skins[4]"));
    let compact = text.split_whitespace().collect::<String>();
    let fewer = compact.replace("\"joints\":[1,2]", "\"joints\":[1]");
    let error =
        read_bytes(fewer.as_bytes(), Path::new("scene.gltf"), Choice::default()).expect_err("damaged").to_string();
    assert!(error.contains("vertex 1 follows joint 1 of 1"), "{error}");
}

/// A square that goes 2 m along x in 2 s and then turns by 90° about y in 1 s, with a camera and a lamp on it, and a morph
/// target that comes in the same time.
fn animated() -> Fixture {
    let mut f = Fixture::square();
    let times = f.floats("SCALAR", &[0.0, 2.0]);
    let way = f.floats("VEC3", &[0., 0., 0., 2., 0., 0.]);
    let turning = f.floats("SCALAR", &[2.0, 3.0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turn = f.floats("VEC4", &[0., 0., 0., 1., 0., half, 0., half]);
    let weights = f.floats("SCALAR", &[0.0, 1.0]);
    let raised = f.floats("VEC3", &[0., 0., 1.].repeat(4));
    f.primitive()["targets"] = json!([{ "POSITION": raised }]);
    let sampler = |input: usize, output: usize| json!({ "input": input, "output": output });
    let channel = |sampler: usize, path: &str| json!({ "sampler": sampler, "target": { "node": 0, "path": path } });
    f.with(
        "/animations",
        json!([{ "name": "go", "samplers": [sampler(times, way), sampler(turning, turn), sampler(times, weights)],
            "channels": [channel(0, "translation"), channel(1, "rotation"), channel(2, "weights")] }]),
    )
    .with("/nodes", json!([{ "name": "node", "mesh": 0, "children": [1] }, { "camera": 0, "translation": [0, 0, 1] }]))
    .with("/cameras", json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]))
}

fn at_moment(fixture: Fixture, start_s: f64, duration_s: f64) -> Result<SceneDescription> {
    let moment = Moment { animation: "go".into(), start_s, duration_s };
    let choice = Choice { variant: None, moment: Some(&moment) };
    read_bytes(fixture.text().as_bytes(), Path::new("scene.gltf"), choice).map(|file| file.scene)
}

#[test]
fn animations_are_evaluated_over_the_time_of_a_picture() {
    // On a straight way two times are enough, at 0.5 m and 1.5 m; the morph target is there by a quarter, then three.
    let scene = at_moment(animated(), 0.5, 1.0).expect("valid");
    let (instance, mesh) = (&scene.instances[0], &scene.meshes[0]);
    assert_eq!((instance.to_world.translation, instance.later.len()), (DVec3::X * 0.5, 1));
    assert_eq!(instance.later[0].translation, DVec3::X * 1.5);
    assert_eq!((mesh.positions[2].z, mesh.later_shapes.len(), mesh.later_shapes[0].positions[2].z), (0.25, 1, 0.75));
    assert_eq!(scene.cameras[0].later[0].translation, DVec3::new(1.5, 0.0, 1.0));
    // A quarter turn is cut into parts of less than 5.2°, the angle of which the arc is 0.1 % off its chord: 32, of 2.8°.
    let scene = at_moment(animated(), 2.0, 1.0).expect("valid");
    let places = &scene.instances[0].later;
    assert_eq!(places.len(), 32);
    assert!(places[31].abs_diff_eq(
        DAffine3::from_translation(DVec3::X * 2.0) * DAffine3::from_rotation_y(std::f64::consts::FRAC_PI_2),
        1e-6
    ));
    // The weight has come to its end and stays.
    assert!(scene.meshes[0].later_shapes.is_empty() && scene.meshes[0].positions[2].z == 1.0);
    // Of an animation that the file lacks, and in no time, there is one place.
    let still = at_moment(animated(), 1.0, 0.0).expect("valid");
    assert_eq!((still.instances[0].to_world.translation, still.instances[0].later.len()), (DVec3::X, 0));
    assert_eq!(animated().scene().instances[0].to_world, DAffine3::IDENTITY);
}

#[rstest]
#[case::sampler("/animations/0/channels/0/sampler", json!(9), "animations[0].channels[0].sampler")]
#[case::node("/animations/0/channels/0/target/node", json!(9), "animations[0].channels[0].target.node")]
#[case::input("/animations/0/samplers/0/input", json!(99), "animations[0].samplers[0].input")]
#[case::still_times("/animations/0/samplers/0/input", json!(1), "needs SCALAR")]
#[case::count("/animations/0/samplers/0/output", json!(0), "holds 12 numbers for 2 times")]
#[case::interpolation("/animations/0/samplers/0/interpolation", json!("SPLINE"), "write LINEAR, STEP or CUBICSPLINE")]
#[case::matrix("/nodes/0/matrix", json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "has a matrix")]
fn damaged_animations_are_refused(#[case] pointer: &str, #[case] value: Value, #[case] message: &str) {
    let error = at_moment(animated().with(pointer, value), 0.0, 1.0).expect_err("refused");
    let text = format!("{error} {:?}", error);
    assert!(text.contains(message), "{text}");
}

#[test]
fn instances_stand_where_the_accessors_say() {
    let mut fixture = Fixture::square();
    let translations = fixture.floats("VEC3", &[0., 0., 0., 5., 0., 0.]);
    let scales = fixture.floats("VEC3", &[1., 1., 1., 2., 2., 2.]);
    fixture.json["nodes"][0]["translation"] = json!([0, 1, 0]);
    let attributes = json!({ "attributes": { "TRANSLATION": translations, "SCALE": scales, "_ID": 0 } });
    fixture.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": attributes });
    let scene = fixture.scene();
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    let corner = scene.instances[1].to_world.transform_point3(DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(corner, DVec3::new(7.0, 3.0, 0.0));
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
fn compressed_geometry_and_textures_are_refused_by_name() {
    let draco = json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": {} } });
    let error = Fixture::square().with("/meshes/0/primitives/0/extensions", draco).error();
    assert!(error.contains("KHR_draco_mesh_compression"), "{error}");
    let meshopt = json!({ "EXT_meshopt_compression": { "buffer": 0 } });
    let error = Fixture::square().with("/bufferViews/0/extensions", meshopt).error();
    assert!(error.contains("EXT_meshopt_compression"), "{error}");
    let texture = json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]);
    let material = json!([{ "emissiveTexture": { "index": 0 } }]);
    let error = Fixture::square().with("/textures", texture).with("/materials", material).error();
    assert!(error.contains("KHR_texture_basisu"), "{error}");
}

#[test]
fn webp_pictures_are_read() {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbaImage::from_pixel(2, 2, image::Rgba([1, 2, 3, 4]));
    pixels.write_to(&mut bytes, image::ImageFormat::WebP).expect("encoded");
    let mut fixture = Fixture::square();
    let view = fixture.view(&bytes.into_inner());
    fixture.json["images"] = json!([{ "bufferView": view, "mimeType": "image/webp" }]);
    fixture.json["textures"] = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    fixture.json["materials"] = json!([{ "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 } }]);
    let scene = fixture.with("/extensionsRequired", json!(["EXT_texture_webp"])).scene();
    assert!(matches!(&scene.images[0].texels, Texels::Rgba8(t) if t[3] == [1, 2, 3, 4]));
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
#[case::torn_triangle("/accessors/3/count", json!(5), "no multiple of 3")]
#[case::no_vertices("/accessors/0/count", json!(0), "has no vertices")]
#[case::no_primitives("/meshes/0/primitives", json!([]), "is empty")]
#[case::no_positions("/meshes/0/primitives/0/attributes", json!({}), "has no POSITION")]
#[case::mode("/meshes/0/primitives/0/mode", json!(9), "is unknown")]
#[case::version("/asset/version", json!("1.0"), "glTF 1.0 is not supported")]
#[case::not_a_document("/nodes", json!(3), "is no glTF document")]
fn damaged_documents_are_refused(#[case] pointer: &str, #[case] value: Value, #[case] message: &str) {
    let error = Fixture::square().with(pointer, value).error();
    assert!(error.contains(message), "{error}");
    assert!(error.starts_with("scene.gltf"), "{error}");
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
                crate::io::complete(&mut file.scene);
            }
        }
    }
}
