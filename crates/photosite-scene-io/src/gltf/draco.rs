//! Primitives whose geometry is a Draco stream (KHR_draco_mesh_compression).
//!
//! The stream of a primitive is decoded into its triangles, and into values for the accessors of its attributes, which
//! only describe their kind. Morph targets are never in a stream.

use std::collections::{BTreeMap, HashMap};

use draco_core::{DecodeLimits, DecoderBuffer, FaceIndex, Mesh, MeshDecoder};
use gltf::json::mesh::Primitive;
use gltf::json::validation::Checked;
use serde::Deserialize;

use super::accessor::{Accessors, Kind, MAX_ZEROS};
use super::contained::contained;
use super::unpacked::Unpacked;
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, memory};

pub(super) const NAME: &str = "KHR_draco_mesh_compression";

/// Largest number of vertices per byte of a stream, except in small ones: those of scanned and modelled shapes take a
/// byte or more each. Only identical vertices take fewer.
const MOST_VERTICES: u64 = 64;
/// Largest number of triangles per vertex; a mesh has about two.
const MOST_TRIANGLES: u64 = 8;
/// Bytes of a vertex that is decoded, mapped and read out, with its triangles.
const VERTEX: u64 = 160;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Table {
    buffer_view: usize,
    /// Semantic → number of the attribute in the stream.
    attributes: BTreeMap<String, u32>,
}

/// Unpacks a primitive, if it is packed. `key` names it.
pub(super) fn unpack(
    accessors: Accessors<'_>,
    primitive: &Primitive,
    key: &str,
    warnings: &mut Warnings,
) -> Result<Option<Unpacked>, Invalid> {
    let Some(value) = primitive.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(None) };
    let key = format!("{key}.extensions.{NAME}");
    let table = Table::deserialize(value).map_err(|source| Invalid::new(&*key, source.to_string()))?;
    let view_key = format!("{key}.bufferView");
    let (bytes, _) = accessors.buffers.view(accessors.root, table.buffer_view, &view_key)?;
    let mesh = decode(bytes, &view_key)?;

    let mut values = HashMap::new();
    for (semantic, accessor) in &primitive.attributes {
        let Checked::Valid(semantic) = semantic else { continue };
        let name = semantic.to_string();
        let Some(&id) = table.attributes.get(&name) else { continue };
        let key = format!("{key}.attributes.{name}");
        let invalid = |message: String| {
            Err(Invalid::new(&*key, message).help("the file is damaged; export or compress it again"))
        };
        let Some(attribute) = mesh.attribute_by_unique_id(id) else {
            return invalid(format!("refers to attribute {id} of the stream, which has none of that number"));
        };
        let Kind { width, largest, count } = accessors.kind(accessor.value(), &key)?;
        if usize::from(attribute.num_components()) != width {
            let message = format!(
                "attribute {id} of the stream has {} components, accessors[{}] says {width}",
                attribute.num_components(),
                accessor.value()
            );
            return invalid(message);
        }
        if count != mesh.num_points() as u64 {
            let (points, accessor) = (mesh.num_points(), accessor.value());
            warnings.once(format!(
                "accessors[{accessor}] says that it has {count} elements; its Draco stream has {points}, which are taken"
            ));
        }
        let mut read = attribute.read_f32s(mesh.num_points(), width);
        if let Some(largest) = largest {
            read.iter_mut().for_each(|value| *value = (*value / largest).max(-1.0));
        }
        values.insert(accessor.value(), read);
    }
    let corners = |face: usize| mesh.face(FaceIndex(face as u32)).map(|point| point.0);
    Ok(Some(Unpacked { values, triangles: (0..mesh.num_faces()).map(corners).collect() }))
}

fn decode(bytes: &[u8], key: &str) -> Result<Mesh, Invalid> {
    let invalid = |message: String| Invalid::new(key, message).help("the file is damaged; export or compress it again");
    let vertices = (bytes.len() as u64 * MOST_VERTICES).max(MAX_ZEROS as u64);
    let left = memory::left().map_or(u64::MAX, |left| left.bytes());
    let most = vertices.min(left / VERTEX);
    let limits = DecodeLimits::default()
        .with_max_points(most)
        .with_max_faces(most.saturating_mul(MOST_TRIANGLES))
        .with_max_decoded_bytes(left / 4);
    let decoded = contained(|| {
        let mut mesh = Mesh::new();
        MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh).map(|()| mesh)
    });
    match decoded {
        Some(Ok(mesh)) => Ok(mesh),
        Some(Err(error)) => Err(invalid(format!("is not a Draco stream that can be read: {}", error.message()))),
        None => Err(invalid("is not a Draco stream that can be read".to_owned())),
    }
}
