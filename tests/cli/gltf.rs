//! Small glTF documents.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// A document and its binary data.
pub(crate) struct Document {
    pub(crate) json: Value,
    pub(crate) data: Vec<u8>,
}

/// One upright triangle that faces +Z, lit from both sides by nothing.
pub(crate) fn triangle() -> Document {
    with_vertices([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0]], [0, 1, 2])
}

pub(crate) fn with_vertices(positions: [[f32; 3]; 3], indices: [u16; 3]) -> Document {
    let floats = positions.as_flattened().iter().flat_map(|x| x.to_le_bytes());
    let data: Vec<u8> = floats.chain(indices.iter().flat_map(|i| i.to_le_bytes())).chain([0, 0]).collect();
    let json = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "sail", "mesh": 0 }],
        "meshes": [{ "name": "triangle", "primitives": [
            { "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }
        ] }],
        "materials": [{ "name": "cloth", "doubleSided": true }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 6 }
        ],
        "buffers": [{ "byteLength": 44 }]
    });
    Document { json, data }
}

impl Document {
    /// Sets the value at a JSON pointer; the last step may be a new key.
    pub(crate) fn with(mut self, pointer: &str, value: Value) -> Self {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let parent = self.json.pointer_mut(parent).expect(pointer);
        match parent.as_array_mut() {
            Some(array) => array[key.parse::<usize>().expect("an index")] = value,
            None => parent[key] = value,
        }
        self
    }

    /// A `.gltf` file with its data inside, a key a line.
    pub(crate) fn text(self) -> Vec<u8> {
        let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.data));
        serde_json::to_vec_pretty(&self.with("/buffers/0/uri", json!(uri)).json).expect("JSON")
    }

    /// A `.glb` file.
    pub(crate) fn binary(self) -> Vec<u8> {
        let mut json = self.json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
        let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &self.data)].concat();
        let length = 12 + chunks.len() as u32;
        [b"glTF", &2u32.to_le_bytes()[..], &length.to_le_bytes(), &chunks].concat()
    }
}
