//! Omission of every property that the schemas leave open.

use std::collections::BTreeSet;

use super::*;

/// The objects of glTF 2.0 (Appendix "JSON Schema Reference") and of the supported extensions: name, required
/// properties, optional properties. `nodes:node` are objects of that name, or a list of them.
const SCHEMAS: &[(&str, &str, &str)] = &[
    (
        "glTF",
        "asset:asset",
        "extensionsUsed extensionsRequired accessors:accessor animations:animation buffers:buffer \
         bufferViews:bufferView cameras:camera images:image materials:material meshes:mesh nodes:node \
         samplers:sampler scene scenes:scene skins:skin textures:texture extensions:root-extensions extras",
    ),
    ("asset", "version", "copyright generator minVersion extensions extras"),
    (
        "accessor",
        "componentType count type",
        "bufferView byteOffset normalized max min sparse:sparse name extensions extras",
    ),
    ("sparse", "count indices:sparse-indices values:sparse-values", "extensions extras"),
    ("sparse-indices", "bufferView componentType", "byteOffset extensions extras"),
    ("sparse-values", "bufferView", "byteOffset extensions extras"),
    ("animation", "channels:channel samplers:animation-sampler", "name extensions extras"),
    ("channel", "sampler target:target", "extensions extras"),
    ("target", "path", "node extensions extras"),
    ("animation-sampler", "input output", "interpolation extensions extras"),
    ("buffer", "byteLength", "uri name extensions extras"),
    ("bufferView", "buffer byteLength", "byteOffset byteStride target name extensions extras"),
    ("camera", "type", "orthographic:orthographic perspective:perspective name extensions extras"),
    ("orthographic", "xmag ymag zfar znear", "extensions extras"),
    ("perspective", "yfov znear", "aspectRatio zfar extensions extras"),
    ("image", "", "uri mimeType bufferView name extensions extras"),
    (
        "material",
        "",
        "name extensions:material-extensions extras pbrMetallicRoughness:pbr normalTexture:normal-texture \
         occlusionTexture:occlusion-texture emissiveTexture:texture-info emissiveFactor alphaMode alphaCutoff \
         doubleSided",
    ),
    (
        "pbr",
        "",
        "baseColorFactor baseColorTexture:texture-info metallicFactor roughnessFactor \
         metallicRoughnessTexture:texture-info extensions extras",
    ),
    ("texture-info", "index", "texCoord extensions:texture-info-extensions extras"),
    ("normal-texture", "index", "texCoord scale extensions extras"),
    ("occlusion-texture", "index", "texCoord strength extensions extras"),
    ("mesh", "primitives:primitive", "weights name extensions extras"),
    ("primitive", "attributes", "indices material mode targets extensions:primitive-extensions extras"),
    (
        "node",
        "",
        "camera children skin matrix mesh rotation scale translation weights name extensions:node-extensions extras",
    ),
    ("sampler", "", "magFilter minFilter wrapS wrapT name extensions extras"),
    ("scene", "", "nodes name extensions extras"),
    ("skin", "joints", "inverseBindMatrices skeleton name extensions extras"),
    ("texture", "", "sampler source name extensions extras"),
    ("root-extensions", "", "KHR_lights_punctual:lights KHR_materials_variants:variants"),
    ("lights", "lights:light", "extensions extras"),
    ("light", "type", "name color intensity range spot:spot extensions extras"),
    ("spot", "", "innerConeAngle outerConeAngle extensions extras"),
    ("variants", "variants:variant", "extensions extras"),
    ("variant", "name", "extensions extras"),
    ("primitive-extensions", "", "KHR_materials_variants:mappings"),
    ("mappings", "mappings:mapping", "extensions extras"),
    ("mapping", "variants material", "name extensions extras"),
    (
        "node-extensions",
        "",
        "KHR_lights_punctual:node-light KHR_node_visibility:visibility EXT_mesh_gpu_instancing:instancing",
    ),
    ("node-light", "light", "extensions extras"),
    ("visibility", "", "visible extensions extras"),
    ("instancing", "attributes", "extensions extras"),
    ("texture-info-extensions", "", "KHR_texture_transform:transform"),
    ("transform", "", "offset rotation scale texCoord extensions extras"),
    (
        "material-extensions",
        "",
        "KHR_materials_anisotropy:anisotropy KHR_materials_clearcoat:clearcoat \
         KHR_materials_diffuse_transmission:diffuse-transmission KHR_materials_dispersion:dispersion \
         KHR_materials_emissive_strength:strength KHR_materials_ior:ior KHR_materials_iridescence:iridescence \
         KHR_materials_pbrSpecularGlossiness:glossiness KHR_materials_sheen:sheen KHR_materials_specular:specular \
         KHR_materials_transmission:transmission KHR_materials_unlit:unlit KHR_materials_volume:volume",
    ),
    ("anisotropy", "", "anisotropyStrength anisotropyRotation anisotropyTexture:texture-info"),
    (
        "clearcoat",
        "",
        "clearcoatFactor clearcoatTexture:texture-info clearcoatRoughnessFactor \
         clearcoatRoughnessTexture:texture-info clearcoatNormalTexture:normal-texture",
    ),
    (
        "diffuse-transmission",
        "",
        "diffuseTransmissionFactor diffuseTransmissionTexture:texture-info diffuseTransmissionColorFactor \
         diffuseTransmissionColorTexture:texture-info",
    ),
    ("dispersion", "", "dispersion"),
    ("strength", "", "emissiveStrength"),
    ("ior", "", "ior"),
    (
        "iridescence",
        "",
        "iridescenceFactor iridescenceTexture:texture-info iridescenceIor iridescenceThicknessMinimum \
         iridescenceThicknessMaximum iridescenceThicknessTexture:texture-info",
    ),
    (
        "glossiness",
        "",
        "diffuseFactor diffuseTexture:texture-info specularFactor glossinessFactor \
         specularGlossinessTexture:texture-info",
    ),
    (
        "sheen",
        "",
        "sheenColorFactor sheenColorTexture:texture-info sheenRoughnessFactor sheenRoughnessTexture:texture-info",
    ),
    (
        "specular",
        "",
        "specularFactor specularTexture:texture-info specularColorFactor specularColorTexture:texture-info",
    ),
    ("transmission", "", "transmissionFactor transmissionTexture:texture-info"),
    ("unlit", "", "extras"),
    ("volume", "", "thicknessFactor thicknessTexture:texture-info attenuationDistance attenuationColor"),
];

/// Properties that the schemas leave open but other rules require: the end of the path and the message. Where a whole
/// list is missing, the reference to it is at fault.
const NEEDED: &[(&str, &str)] = &[
    ("/accessors", "refers to accessors["),
    ("/buffers", "refers to buffers["),
    ("/bufferViews", "refers to bufferViews["),
    ("/cameras", "refers to cameras["),
    ("/images", "refers to images["),
    ("/materials", "refers to materials["),
    ("/meshes", "refers to meshes["),
    ("/nodes", "refers to nodes["),
    ("/samplers", "refers to samplers["),
    ("/scenes", "refers to scenes["),
    ("/skins", "refers to skins["),
    ("/textures", "refers to textures["),
    ("/extensions/KHR_lights_punctual", "refers to lights["),
    ("/extensions", "refers to lights["),
    // "When undefined", a binary chunk stands for the first buffer alone.
    ("/buffers/0/uri", "has no uri"),
    // One of the two has to be there.
    ("/images/0/uri", "has neither a uri nor a bufferView"),
    ("/images/1/bufferView", "has neither a uri nor a bufferView"),
    // "When undefined, an extension or other mechanism SHOULD supply an alternate texture source".
    ("/textures/0/source", "has no image"),
    ("/textures/1/source", "has no image"),
    // Zeros, or the bytes of another view, are no times and no image.
    ("/accessors/7/bufferView", "times that do not rise"),
    ("/bufferViews/7/byteOffset", "times that do not rise"),
    ("/bufferViews/13/byteOffset", "cannot decode images[1]"),
    // The properties that `type` asks for.
    ("/cameras/0/perspective", "has no perspective"),
];

/// Paths of all optional properties, and `object.property` of those present.
fn open_properties(schema: &str, value: &Value, path: &str, paths: &mut BTreeSet<String>, seen: &mut BTreeSet<String>) {
    if let Some(list) = value.as_array() {
        list.iter().enumerate().for_each(|(i, v)| open_properties(schema, v, &format!("{path}/{i}"), paths, seen));
        return;
    }
    let &(_, required, optional) = SCHEMAS.iter().find(|(name, ..)| *name == schema).expect(schema);
    let object = value.as_object().unwrap_or_else(|| panic!("{path} is no {schema}"));
    let mut known = BTreeSet::new();
    for (is_open, property) in
        required.split_whitespace().map(|p| (false, p)).chain(optional.split_whitespace().map(|p| (true, p)))
    {
        let (name, inner) = property.split_once(':').unwrap_or((property, ""));
        known.insert(name);
        let Some(value) = object.get(name) else { continue };
        seen.insert(format!("{schema}.{name}"));
        let path = format!("{path}/{name}");
        if is_open {
            paths.insert(path.clone());
        }
        if !inner.is_empty() {
            open_properties(inner, value, &path, paths, seen);
        }
    }
    let unknown: Vec<_> = object.keys().filter(|key| !known.contains(key.as_str())).collect();
    assert!(unknown.is_empty(), "{path}: {unknown:?}");
}

/// A document that has every property of every object.
fn everything() -> Value {
    let mut f = Fixture { json: json!({ "bufferViews": [], "accessors": [] }), bytes: Vec::new() };
    let positions: [f32; 18] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 0., 0., 1., 1., 0., 0., 1., 0.];
    let positions = f.floats("VEC3", &positions);
    let normals = f.floats("VEC3", &[0., 0., 1.].repeat(6));
    let uvs = f.accessor("VEC2", 5121, 6, &[0, 255].repeat(12));
    let indices = f.accessor("SCALAR", 5121, 6, &[0, 1, 2, 3, 4, 5]);
    let raised = f.floats("VEC3", &[0., 0., 1.].repeat(6));
    let joints = f.accessor("VEC4", 5121, 6, &[0; 24]);
    let weights = f.floats("VEC4", &[1., 0., 0., 0.].repeat(6));
    let times = f.floats("SCALAR", &[0.0, 1.0]);
    let ways = f.floats("VEC3", &[0., 0., 0., 2., 0., 0.]);
    let amounts = f.floats("SCALAR", &[0.0, 1.0]);
    let binds = f.floats("MAT4", &glam::Mat4::IDENTITY.to_cols_array());
    let (sparse_indices, sparse_values) = (f.view(&[0]), f.view(&0.5f32.to_le_bytes().repeat(3)));
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_pixel(1, 1, image::Luma([77])).write_to(&mut png, image::ImageFormat::Png).expect("encoded");
    let image = f.view(png.get_ref());
    for accessor in f.json["accessors"].as_array_mut().expect("accessors") {
        accessor["byteOffset"] = json!(0);
    }
    // UV that lie 4 bytes apart.
    let accessors = f.json["accessors"].as_array_mut().expect("accessors");
    accessors[uvs]["normalized"] = json!(true);
    accessors[positions]["min"] = json!([0, 0, 0]);
    accessors[positions]["max"] = json!([1, 1, 0]);
    accessors[raised]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": sparse_indices, "componentType": 5121, "byteOffset": 0 },
        "values": { "bufferView": sparse_values, "byteOffset": 0 },
    });
    f.json["bufferViews"][uvs]["byteStride"] = json!(4);
    f.json["bufferViews"][positions]["target"] = json!(34962);
    let transform = json!({ "offset": [0, 0], "rotation": 0, "scale": [1, 1], "texCoord": 0 });
    let info = json!({ "index": 0, "texCoord": 0, "extensions": { "KHR_texture_transform": transform } });
    let normal = json!({ "index": 1, "texCoord": 0, "scale": 1 });
    let mut json = json!({
        "asset": { "version": "2.0", "minVersion": "2.0", "copyright": "none", "generator": "a test" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensionsRequired": ["KHR_lights_punctual"],
        "scene": 0,
        "scenes": [{ "nodes": [0, 2, 3, 4, 5], "name": "all" }],
        "nodes": [
            { "name": "a", "mesh": 0, "children": [1], "translation": [0, 0, 0], "rotation": [0, 0, 0, 1],
              "scale": [1, 1, 1], "weights": [0.5],
              "extensions": { "KHR_node_visibility": { "visible": true }, "KHR_lights_punctual": { "light": 0 } } },
            { "camera": 0, "matrix": glam::Mat4::IDENTITY.to_cols_array() },
            { "mesh": 0, "skin": 0 },
            { "camera": 1, "extensions": { "KHR_lights_punctual": { "light": 1 } } },
            { "mesh": 1, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": ways } } } },
            { "mesh": 1 },
        ],
        "meshes": [
            { "name": "m", "weights": [0.5], "primitives": [{
                "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs,
                    "JOINTS_0": joints, "WEIGHTS_0": weights },
                "indices": indices, "material": 0, "mode": 4, "targets": [{ "POSITION": raised }],
                "extensions": { "KHR_materials_variants": {
                    "mappings": [{ "variants": [0], "material": 1, "name": "other" }] } },
            }] },
            { "primitives": [{ "attributes": { "POSITION": positions, "TEXCOORD_0": uvs }, "material": 1 }] },
        ],
        "materials": [
            { "name": "first", "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
              "emissiveFactor": [1, 1, 1], "emissiveTexture": info, "normalTexture": normal,
              "occlusionTexture": { "index": 0, "texCoord": 0, "strength": 1 },
              "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 1], "baseColorTexture": info,
                  "metallicFactor": 0.5, "roughnessFactor": 0.5, "metallicRoughnessTexture": info },
              "extensions": {
                  "KHR_materials_anisotropy":
                      { "anisotropyStrength": 0.5, "anisotropyRotation": 0.1, "anisotropyTexture": info },
                  "KHR_materials_clearcoat": { "clearcoatFactor": 0.5, "clearcoatTexture": info,
                      "clearcoatRoughnessFactor": 0.5, "clearcoatRoughnessTexture": info,
                      "clearcoatNormalTexture": normal },
                  "KHR_materials_diffuse_transmission": { "diffuseTransmissionFactor": 0.5,
                      "diffuseTransmissionTexture": info, "diffuseTransmissionColorFactor": [1, 1, 1],
                      "diffuseTransmissionColorTexture": info },
                  "KHR_materials_dispersion": { "dispersion": 0.1 },
                  "KHR_materials_emissive_strength": { "emissiveStrength": 2 },
                  "KHR_materials_ior": { "ior": 1.4 },
                  "KHR_materials_iridescence": { "iridescenceFactor": 0.5, "iridescenceTexture": info,
                      "iridescenceIor": 1.2, "iridescenceThicknessMinimum": 100,
                      "iridescenceThicknessMaximum": 200, "iridescenceThicknessTexture": info },
                  "KHR_materials_sheen": { "sheenColorFactor": [1, 1, 1], "sheenColorTexture": info,
                      "sheenRoughnessFactor": 0.5, "sheenRoughnessTexture": info },
                  "KHR_materials_specular": { "specularFactor": 0.5, "specularTexture": info,
                      "specularColorFactor": [1, 1, 1], "specularColorTexture": info },
                  "KHR_materials_transmission": { "transmissionFactor": 0.5, "transmissionTexture": info },
                  "KHR_materials_volume": { "thicknessFactor": 1, "thicknessTexture": info,
                      "attenuationDistance": 1, "attenuationColor": [1, 1, 1] },
              } },
            { "extensions": {
                "KHR_materials_unlit": {},
                "KHR_materials_pbrSpecularGlossiness": { "diffuseFactor": [1, 1, 1, 1], "diffuseTexture": info,
                    "specularFactor": [1, 1, 1], "glossinessFactor": 0.5, "specularGlossinessTexture": info },
            } },
        ],
        "textures": [{ "source": 0, "sampler": 0, "name": "t" }, { "source": 1 }],
        "samplers": [{ "magFilter": 9728, "minFilter": 9728, "wrapS": 10497, "wrapT": 10497, "name": "s" }],
        "images": [
            { "uri": data_uri(png.get_ref()), "name": "i", "mimeType": "image/png" },
            { "bufferView": image, "mimeType": "image/png" },
        ],
        "cameras": [
            { "type": "perspective", "name": "c",
              "perspective": { "yfov": 0.5, "znear": 0.1, "zfar": 10, "aspectRatio": 1 } },
            { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 10, "znear": 0.1 } },
        ],
        "skins": [{ "joints": [3], "inverseBindMatrices": binds, "skeleton": 3, "name": "bones" }],
        "animations": [{ "name": "go",
            "samplers": [{ "input": times, "output": ways, "interpolation": "STEP" },
                { "input": times, "output": amounts }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } },
                { "sampler": 1, "target": { "node": 0, "path": "weights" } }] }],
        "extensions": {
            "KHR_lights_punctual": { "lights": [
                { "type": "spot", "name": "l", "color": [1, 1, 1], "intensity": 2, "range": 9,
                  "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.5 } },
                { "type": "point" },
            ] },
            "KHR_materials_variants": { "variants": [{ "name": "v" }] },
        },
        "buffers": [{ "byteLength": f.bytes.len(), "uri": data_uri(&f.bytes), "name": "b" }],
    });
    json["accessors"] = f.json["accessors"].take();
    json["bufferViews"] = f.json["bufferViews"].take();
    json["accessors"][0]["name"] = json!("x");
    json["bufferViews"][0]["name"] = json!("y");
    add_open_objects("glTF", &mut json);
    json
}

fn data_uri(bytes: &[u8]) -> String {
    use base64::Engine;
    format!("data:application/octet-stream;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

/// Gives every object extras, and an unknown extension where it may have them.
fn add_open_objects(schema: &str, value: &mut Value) {
    if let Some(list) = value.as_array_mut() {
        list.iter_mut().for_each(|value| add_open_objects(schema, value));
        return;
    }
    let &(_, required, optional) = SCHEMAS.iter().find(|(name, ..)| *name == schema).expect(schema);
    for property in required.split_whitespace().chain(optional.split_whitespace()) {
        match property.split_once(':') {
            Some((name, inner)) if value.get(name).is_some() => add_open_objects(inner, &mut value[name]),
            None if property == "extras" => value["extras"] = json!({ "anything": [1] }),
            None if property == "extensions" => value["extensions"] = json!({ "EXT_nobody_knows": { "a": 1 } }),
            Some(_) | None => {}
        }
    }
}

#[test]
fn whatever_the_schemas_leave_open_may_be_left_out() {
    let whole = everything();
    let (mut paths, mut seen) = (BTreeSet::new(), BTreeSet::new());
    open_properties("glTF", &whole, "", &mut paths, &mut seen);
    for (schema, required, optional) in SCHEMAS {
        for property in required.split_whitespace().chain(optional.split_whitespace()) {
            let name = property.split(':').next().unwrap_or_default();
            assert!(seen.contains(&format!("{schema}.{name}")), "the document has no {schema}.{name}");
        }
    }
    let moment = Moment { animation: "go".into(), start_s: 0.2, duration_s: 0.4 };
    let read = |json: &Value| {
        let choice = Choice { moment: Some(&moment), variant: Some("v"), ..Choice::default() };
        read_bytes(json.to_string().as_bytes(), Path::new("scene.gltf"), choice)
    };
    read(&whole).expect("valid");
    let mut wrong = Vec::new();
    for path in &paths {
        let (parent, name) = path.rsplit_once('/').expect("a pointer");
        let mut json = whole.clone();
        json.pointer_mut(parent).and_then(Value::as_object_mut).expect("an object").shift_remove(name);
        let needed = NEEDED.iter().find(|(needed, _)| needed == path).map(|(_, message)| *message);
        match (read(&json).map_err(|error| error.to_string()), needed) {
            (Ok(_), None) => {}
            (Err(error), Some(message)) if error.contains(message) => {}
            (found, _) => wrong.push(format!("{path}: {:?}", found.map(|_| "read"))),
        }
    }
    assert!(wrong.is_empty(), "of {}:\n{}", paths.len(), wrong.join("\n"));
}
