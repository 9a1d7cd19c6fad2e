//! Whole documents, made here: their meaning, and errors of damaged ones.

mod damage;
mod materials;
mod meshes;
mod nodes;
mod optional;
mod packed;

use std::path::Path;

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use rstest::rstest;
use serde_json::{Value, json};

use super::*;
use photosite_transport::light::SpotLight;
use photosite_transport::scene::description::{AlphaMode, Colour, LightKind, MaterialModel};
use photosite_transport::texture::{Filter, Texels, Wrap};

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

    /// Sets the value at a JSON pointer, creating missing parents.
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

    /// Text of the document, with the buffer as a data URI.
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
        read_bytes(self.text().as_bytes(), Path::new("scene.gltf"), Choice { variant, ..Choice::default() })
    }

    fn scene(self) -> SceneDescription {
        self.read().expect("a valid document")
    }

    fn error(self) -> String {
        self.read().expect_err("to be refused").to_string()
    }
}
