//! Packed geometry and images, made by the tools of others (see packed/make.py), compared with their originals.

use base64::Engine;
use gltf::json::buffer;
use serde::Deserialize;

use super::*;
use crate::bitmap_file::decode_bitmap;
use crate::gltf::meshopt::Packed;
use crate::gltf::{contained, ktx2};
use photosite_transport::texture::Bitmap;

macro_rules! file {
    ($name:literal) => {
        ($name, include_bytes!(concat!("packed/", $name)).as_slice())
    };
}

const PACKED: [(&str, &[u8]); 7] = [
    file!("draco.glb"),
    file!("draco-sequential.glb"),
    file!("meshopt.glb"),
    file!("meshopt-gltfpack.glb"),
    file!("meshopt-khr.glb"),
    file!("meshopt-real.glb"),
    file!("meshopt-fallback.glb"),
];

const IMAGES: [(&str, &[u8], &[u8]); 4] = [
    ("etc1s", file!("etc1s.ktx2").1, file!("etc1s.png").1),
    ("etc1s-linear", file!("etc1s-linear.ktx2").1, file!("etc1s-linear.png").1),
    ("uastc", file!("uastc.ktx2").1, file!("uastc.png").1),
    ("uastc-zstd", file!("uastc-zstd.ktx2").1, file!("uastc-zstd.png").1),
];

fn read(name: &str, bytes: &[u8]) -> Result<SceneDescription> {
    read_bytes(bytes, Path::new(name), Choice::default()).map(|file| file.scene)
}

/// Random numbers by xorshift, repeatable by seed.
fn xorshift(state: &mut u64) -> usize {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state as usize
}

/// Copy with a few bytes changed, or cut off.
fn damaged(bytes: &[u8], state: &mut u64) -> Vec<u8> {
    let mut damaged = bytes.to_vec();
    for _ in 0..1 + xorshift(state) % 4 {
        let at = xorshift(state) % damaged.len();
        match xorshift(state) % 4 {
            0 => damaged[at] = xorshift(state) as u8,
            1 => damaged[at] ^= 1 << (xorshift(state) % 8),
            2 => damaged[at] = 255,
            _ => damaged[at] = 0,
        }
    }
    if xorshift(state).is_multiple_of(8) {
        damaged.truncate(xorshift(state) % bytes.len());
    }
    damaged
}

#[rstest]
// Steps of 10 bits on the octahedron are 1/511, and half a step along both axes is √6 of it in space, stretched by √3 at
// most where the octahedron is blown up to the sphere.
#[case::draco(0, 4.25 / 1022.0, 1.0)]
#[case::draco_sequential(1, 4.25 / 1022.0, 1.0)]
// 8 bits, and components that are rounded once more.
#[case::meshopt(2, 4.25 / 254.0 + 1.74 * 0.5 / 127.0, 1.0)]
// gltfpack writes 12 of 16 bits of UVs, and leaves it to the transforms of textures, which there are none of here.
#[case::meshopt_of_gltfpack(3, 4.25 / 1022.0, 65535.0 / 4095.0)]
#[case::meshopt_of_khronos(4, 4.25 / 1022.0, 65535.0 / 4095.0)]
#[case::meshopt_of_real_numbers(5, 1e-6, 1.0)]
#[case::meshopt_without_its_fallback(6, 4.25 / 1022.0, 65535.0 / 4095.0)]
fn packed_triangles_are_those_of_the_plain_file(#[case] packed: usize, #[case] turned_by: f32, #[case] uv_scale: f32) {
    let (plain_name, plain) = file!("plain.glb");
    let plain = read(plain_name, plain).expect("plain");
    let (name, bytes) = PACKED[packed];
    let found = read(name, bytes).expect(name);
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);

    // A step of the 14 bits that the longest side of 1 m is cut into, of the 12 of UVs.
    let (moved_by, uv_by) = if turned_by < 1e-5 { (1e-6, 1e-6) } else { (1.0 / 16384.0, 1.0 / 4096.0) };
    let (reference, mesh) = (&plain.meshes[0], &found.meshes[0]);
    let to_world = found.instances[0].to_world;
    let close = |a: f32, b: f32, by: f32| (a - b).abs() <= by + 1e-6;
    let known = |vertex: usize| {
        let place = to_world.transform_point3(mesh.positions[vertex].as_dvec3()).as_vec3();
        let far = |i: &usize| (place - reference.positions[*i]).abs().max_element();
        let i = (0..reference.positions.len()).min_by(|a, b| far(a).total_cmp(&far(b))).expect("vertices");
        assert!(far(&i) <= moved_by + 1e-6, "{name}: vertex {vertex} is {} off", far(&i));
        let normal = to_world.matrix3.inverse().transpose() * mesh.normals[vertex].as_dvec3();
        let angle = normal.as_vec3().angle_between(reference.normals[i]);
        assert!(angle <= turned_by + 5e-4, "{name}: the normal of vertex {vertex} is turned by {angle}");
        let (uv, expected) = (mesh.uvs[0][vertex] * uv_scale, reference.uvs[0][i]);
        assert!(close(uv.x, expected.x, uv_by) && close(uv.y, expected.y, uv_by), "{name}: {uv} for {expected}");
        // Luma and two differences are rounded, each by half a code.
        for (c, expected) in mesh.colours[vertex].to_array().into_iter().zip(reference.colours[i].to_array()) {
            assert!(close(c, expected, 1.5 / 255.0), "{name}: {c} for {expected}");
        }
        i as u32
    };
    // From the corner of the lowest number on.
    let turned = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or_default();
    let mut triangles: Vec<_> = mesh.triangles.iter().map(|t| turned(t.map(|v| known(v as usize)))).collect();
    let mut expected: Vec<_> = reference.triangles.iter().map(|&t| turned(t)).collect();
    triangles.sort_unstable();
    expected.sort_unstable();
    assert_eq!(triangles, expected, "{name}");
}

#[derive(Deserialize)]
struct Stream {
    name: String,
    count: usize,
    stride: usize,
    mode: String,
    filter: String,
    packed: String,
    unpacked: String,
}

impl Stream {
    fn all() -> Vec<Self> {
        serde_json::from_str(include_str!("packed/streams.json")).expect("streams")
    }

    fn bytes(text: &str) -> Vec<u8> {
        base64::engine::general_purpose::STANDARD.decode(text).expect("base64")
    }

    fn view(&self, extension: &str, count: usize) -> buffer::View {
        let table = json!({
            "buffer": 0, "byteLength": 1, "byteStride": self.stride, "count": count,
            "mode": self.mode, "filter": self.filter,
        });
        let view = json!({ "buffer": 0, "byteLength": count * self.stride, "extensions": { extension: table } });
        serde_json::from_value(view).expect("a view")
    }

    fn unpack(&self, extension: &str, count: usize, packed: &[u8]) -> Result<Vec<u8>, Invalid> {
        let view = self.view(extension, count);
        Packed::of_view(&view, "bufferViews[0]")?.expect("packed").unpack(&view, packed)
    }
}

#[test]
fn streams_unpack_to_what_meshoptimizer_makes_of_them() {
    for stream in Stream::all() {
        let (packed, expected) = (Stream::bytes(&stream.packed), Stream::bytes(&stream.unpacked));
        let found = stream.unpack("KHR_meshopt_compression", stream.count, &packed).expect(&stream.name);
        // Filters but that of real numbers may be one step off.
        let number = |bytes: &[u8]| match (stream.filter.as_str(), stream.stride) {
            ("NONE" | "EXPONENTIAL", _) => vec![],
            ("COLOR", 4) => bytes.iter().map(|&b| i32::from(b)).collect(),
            ("COLOR", _) => bytes.as_chunks::<2>().0.iter().map(|&b| i32::from(u16::from_le_bytes(b))).collect(),
            (_, 4) => bytes.iter().map(|&b| i32::from(b as i8)).collect(),
            (_, _) => bytes.as_chunks::<2>().0.iter().map(|&b| i32::from(i16::from_le_bytes(b))).collect::<Vec<_>>(),
        };
        let (a, b) = (number(&found), number(&expected));
        if a.is_empty() {
            assert_eq!(found, expected, "{}", stream.name);
        }
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 1), "{}: {a:?} for {b:?}", stream.name);

        // Version 1 and colours are of the newer extension alone.
        let is_new = stream.name.contains("-v1-") || stream.filter == "COLOR";
        assert_eq!(stream.unpack("EXT_meshopt_compression", stream.count, &packed).is_err(), is_new, "{}", stream.name);
    }
}

#[test]
fn torn_streams_and_wrong_counts_are_errors() {
    for stream in Stream::all() {
        let packed = Stream::bytes(&stream.packed);
        for len in 0..packed.len() {
            let error = stream.unpack(NAMES[0], stream.count, &packed[..len]).expect_err(&stream.name);
            assert!(error.key.starts_with("bufferViews[0].extensions.KHR_meshopt_compression"), "{error}");
        }
        // A multiple of 3, and of more blocks than there are: what fills up the last one is not told from elements.
        for count in [0, stream.count + 3 * 256, 3 * 1024 * 1024] {
            assert!(stream.unpack(NAMES[0], count, &packed).is_err(), "{} of {count}", stream.name);
        }
        let mut state = 1;
        for _ in 0..500 {
            let _ = stream.unpack(NAMES[0], stream.count, &damaged(&packed, &mut state));
        }
    }
}

const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

#[rstest]
#[case::stride("byteStride", json!(6), "byteStride: is 6, which must be a multiple of 4 up to 256")]
#[case::filter("filter", json!("QUATERNION"), "filter: QUATERNION needs attributes of 8 bytes")]
#[case::unknown("filter", json!("BLUE"), "unknown variant `BLUE`")]
#[case::mode("mode", json!("POINTS"), "unknown variant `POINTS`")]
#[case::count("count", json!(48), "count: are 48 of 4 bytes, which is not what the 196 bytes of the view are")]
#[case::buffer("buffer", json!(7), "buffer: refers to buffers[7]")]
#[case::fallback("buffer", json!(1), "buffer: refers to buffers[1], which has no bytes of its own")]
#[case::range("byteLength", json!(1u64 << 40), "reach beyond")]
#[case::triangles("mode", json!("TRIANGLES"), "count: is 49, which is not a multiple of 3")]
fn tables_of_packed_views_are_checked(#[case] key: &str, #[case] value: Value, #[case] message: &str) {
    let (json, chunk) = glb::split(PACKED[2].1).expect("a file");
    let mut json: Value = serde_json::from_slice(json).expect("text");
    // Normals, of four bytes.
    json["bufferViews"][1]["extensions"]["EXT_meshopt_compression"][key] = value;
    let error = read("packed.glb", &joined(&json, chunk.expect("bytes"))).expect_err("to be refused").to_string();
    assert!(error.contains(message) && error.starts_with("packed.glb: bufferViews[1]"), "{error}");
}

#[rstest]
#[case::table("/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression", json!({ "bufferView": 0 }), "missing field `attributes`")]
#[case::view("/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression/bufferView", json!(5), "refers to bufferViews[5]")]
#[case::id("/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression/attributes/POSITION", json!(9), "POSITION: refers to attribute 9 of the stream")]
#[case::width("/accessors/1/type", json!("VEC2"), "has 3 components, accessors[1] says 2")]
#[case::torn("/bufferViews/0/byteLength", json!(300), "is not a Draco stream that can be read")]
fn tables_of_draco_are_checked(#[case] pointer: &str, #[case] value: Value, #[case] message: &str) {
    let (json, chunk) = glb::split(PACKED[0].1).expect("a file");
    let mut json: Value = serde_json::from_slice(json).expect("text");
    *json.pointer_mut(pointer).expect(pointer) = value;
    let error = read("packed.glb", &joined(&json, chunk.expect("bytes"))).expect_err("to be refused").to_string();
    assert!(error.contains(message) && error.contains("meshes[0].primitives[0]"), "{error}");
}

#[test]
fn a_stream_counts_its_vertices_itself() {
    let (json, chunk) = glb::split(PACKED[0].1).expect("a file");
    let mut json: Value = serde_json::from_slice(json).expect("text");
    json["accessors"][1]["count"] = json!(40);
    let scene = read("packed.glb", &joined(&json, chunk.expect("bytes"))).expect("read");
    assert_eq!(scene.meshes[0].positions.len(), 49);
    assert_eq!(
        scene.warnings,
        ["packed.glb: accessors[1] says that it has 40 elements; its Draco stream has 49, which are taken"]
    );
}

/// Binary file of a JSON text and a chunk.
fn joined(json: &Value, bytes: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let body = [chunk(b"JSON", &text), chunk(b"BIN\0", bytes)].concat();
    [b"glTF", &2u32.to_le_bytes()[..], &(12 + body.len() as u32).to_le_bytes(), &body].concat()
}

#[test]
fn damaged_packed_files_are_errors_or_scenes_and_no_panic() {
    let mut state = 1;
    for (name, bytes) in PACKED {
        for len in 0..bytes.len() {
            assert!(read(name, &bytes[..len]).is_err(), "{name} of {len} bytes");
        }
        for _ in 0..3000 {
            if let Ok(mut scene) = read(name, &damaged(bytes, &mut state)) {
                crate::complete(&mut scene, &mut crate::ChangedMeshes::default());
            }
        }
    }
}

fn texels(bitmap: &Bitmap) -> &[[u8; 4]] {
    match &bitmap.texels {
        Texels::Rgba8(texels) => texels,
        Texels::Rgba16(_) | Texels::Rgb32F(_) => panic!("{:?}", bitmap.texels),
    }
}

#[test]
fn images_decode_to_what_basis_universal_makes_of_them() {
    for (name, ktx2, png) in IMAGES {
        let found = ktx2::decode(ktx2, name.to_owned()).expect(name);
        let expected = decode_bitmap(png, name.to_owned()).expect("a PNG");
        assert_eq!((found.bitmap.width, found.bitmap.height), (20, 12), "{name}");
        assert_eq!(texels(&found.bitmap), texels(&expected), "{name}");
        assert_eq!(found.is_srgb, Some(!name.contains("linear")), "{name}");
    }
}

/// A square with an image that a material uses.
fn painted(image: &[u8], material: Value) -> Fixture {
    let mut fixture = Fixture::square();
    let view = fixture.view(image);
    let fixture = fixture.with("/images", json!([{ "bufferView": view, "mimeType": "image/ktx2" }]));
    let texture = json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]);
    let fixture = fixture.with("/textures", texture).with("/extensionsRequired", json!(["KHR_texture_basisu"]));
    fixture.with("/materials", json!([material])).with("/meshes/0/primitives/0/material", json!(0))
}

#[test]
fn what_an_image_says_of_its_colours_must_be_what_they_are_used_for() {
    let [colours, normals] = [
        json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }),
        json!({ "normalTexture": { "index": 0 } }),
    ];
    let (srgb, linear) = (IMAGES[0].1, IMAGES[1].1);
    for (image, material, warns) in
        [(srgb, &colours, false), (linear, &normals, false), (linear, &colours, true), (srgb, &normals, true)]
    {
        let scene = painted(image, material.clone()).scene();
        assert_eq!(scene.images[0].width, 20);
        assert_eq!(scene.warnings.len(), usize::from(warns), "{:?}", scene.warnings);
        assert!(scene.warnings.iter().all(|w| w.contains("materials[0]") && w.contains("which its use demands")));
    }
}

#[test]
fn the_image_for_readers_that_know_no_ktx2_is_left_alone() {
    let mut fixture = painted(IMAGES[2].1, json!({ "emissiveTexture": { "index": 0 }, "emissiveFactor": [1, 1, 1] }));
    let view = fixture.view(b"no image");
    fixture.json["images"].as_array_mut().expect("images").push(json!({ "bufferView": view }));
    fixture.json["textures"][0]["source"] = json!(1);
    fixture.json["extensionsRequired"] = json!([]);
    assert_eq!(fixture.scene().images[0].height, 12);
}

#[rstest]
#[case::torn(|b: &mut Vec<u8>| b.truncate(200), "ends too early")]
#[case::empty(|b: &mut Vec<u8>| b[20..24].fill(0), "it has no pixels")]
#[case::large(|b: &mut Vec<u8>| b[22] = 1, "too large")]
#[case::layers(|b: &mut Vec<u8>| b[32] = 2, "not a plain image")]
#[case::faces(|b: &mut Vec<u8>| b[36] = 6, "not a plain image")]
#[case::size(|b: &mut Vec<u8>| b[96] -= 16, "another size")]
#[case::format(|b: &mut Vec<u8>| b[12] = 37, "not an image of ETC1S or UASTC")]
fn damaged_images_are_named(#[case] damage: fn(&mut Vec<u8>), #[case] message: &str) {
    let mut bytes = IMAGES[3].1.to_vec();
    damage(&mut bytes);
    let material = json!({ "emissiveTexture": { "index": 0 } });
    let error = painted(&bytes, material).error();
    assert!(error.contains("images[0]: cannot decode") && error.contains(message), "{error}");
}

#[test]
fn damaged_images_are_errors_or_images_and_no_panic() {
    let mut state = 1;
    for (name, ktx2, _) in IMAGES {
        // Behind the keys and values, and whatever fills them up, nothing may be missing.
        for len in 0..ktx2.len() {
            assert!(ktx2::decode(&ktx2[..len], name.to_owned()).is_err(), "{name} of {len} bytes");
        }
        for _ in 0..3000 {
            let mut bytes = damaged(ktx2, &mut state);
            // A few pixels, so that it is soon over.
            for high in [21..24, 25..28] {
                bytes.get_mut(high).into_iter().for_each(|high| high.fill(0));
            }
            let _ = ktx2::decode(&bytes, name.to_owned());
        }
    }
}

#[test]
fn mistakes_of_decoders_are_contained() {
    assert_eq!(contained::contained(|| 1), Some(1));
    assert_eq!(contained::contained(|| -> u8 { std::panic::resume_unwind(Box::new(())) }), None);
}

#[test]
fn textures_that_cannot_be_had_get_a_stand_in_where_that_is_allowed() {
    let material = json!([{
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": 0 }, "metallicRoughnessTexture": { "index": 1 },
        },
        "normalTexture": { "index": 2 },
        "extensions": { "KHR_materials_anisotropy": { "anisotropyStrength": 1, "anisotropyTexture": { "index": 3 } } },
    }]);
    let lacking = || {
        let mut fixture = Fixture::square();
        let view = fixture.view(b"no image");
        let images = json!([{ "uri": "gone.png" }, { "bufferView": view }, { "uri": "gone%20too.ktx2" }]);
        let fixture = fixture.with("/images", images).with("/materials", material.clone());
        // The last one is of a kind that nobody knows.
        fixture.with("/textures", json!([{ "source": 0 }, { "source": 1 }, { "source": 2 }, {}]))
    };
    let error = format!("{:?}", lacking().read().expect_err("strict"));
    assert!(error.contains("images[1]") && error.contains("Lenient"), "{error}");

    let choice = Choice { is_lenient: true, ..Choice::default() };
    let scene = read_bytes(lacking().text().as_bytes(), Path::new("scene.gltf"), choice).expect("lenient").scene;
    let found: Vec<_> = scene.images.iter().map(|image| texels(image)[0]).collect();
    assert_eq!(found, [[255; 4], [128, 128, 128, 255], [255, 128, 255, 255], [128, 128, 255, 255]]);
    let expected = [
        ("images[1]: cannot decode", "the surface is left as if there were none"),
        ("images[0].uri: cannot read gone.png", "grey is used instead"),
        ("textures[3]: has no image that can be read", "the surface is left as if there were none"),
        ("images[2].uri: cannot read gone too.ktx2", "the surface is left as if there were none"),
    ];
    assert_eq!(scene.warnings.len(), expected.len(), "{:?}", scene.warnings);
    for (warning, (problem, stand_in)) in scene.warnings.iter().zip(expected) {
        assert!(warning.contains(problem) && warning.ends_with(stand_in), "{warning}");
    }

    // What leads out of the sandbox is no texture that is missing, and what is no texture is as strict as ever.
    let sandbox = Sandbox::new(Path::new(env!("CARGO_MANIFEST_DIR"))).expect("a folder");
    let choice = Choice { sandbox: Some(&sandbox), ..choice };
    let refused = |fixture: Fixture| read_bytes(fixture.text().as_bytes(), Path::new("scene.gltf"), choice).is_err();
    assert!(!refused(lacking()));
    assert!(refused(lacking().with("/images/0/uri", json!("../../../../gone.png"))));
    assert!(refused(lacking().with("/textures/0/source", json!(9))));
    assert!(refused(lacking().with("/accessors/0/count", json!(99))));
}
