//! KHR_materials_variants: materials by the name of a variant.

use gltf::json::Root;
use gltf::json::mesh::Primitive;
use serde::Deserialize;

use photosite_core::Invalid;

const NAME: &str = "KHR_materials_variants";

#[derive(Deserialize)]
struct Variants {
    variants: Vec<Variant>,
}

#[derive(Deserialize)]
struct Variant {
    name: String,
}

#[derive(Deserialize)]
struct Mappings {
    mappings: Vec<Mapping>,
}

#[derive(Deserialize)]
struct Mapping {
    variants: Vec<usize>,
    material: usize,
}

/// The names of a document's variants, in order.
pub(super) fn names(root: &Root) -> Result<Vec<String>, Invalid> {
    let Some(value) = root.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(Vec::new()) };
    let table: Variants = serde_json::from_value(value.clone())
        .map_err(|source| Invalid::new(format!("extensions.{NAME}"), source.to_string()))?;
    Ok(table.variants.into_iter().map(|variant| variant.name).collect())
}

/// Material of a primitive in a variant, if the primitive has one for it.
pub(super) fn material(primitive: &Primitive, variant: usize, key: &str) -> Result<Option<usize>, Invalid> {
    let Some(value) = primitive.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(None) };
    let table: Mappings = serde_json::from_value(value.clone())
        .map_err(|source| Invalid::new(format!("{key}.extensions.{NAME}"), source.to_string()))?;
    Ok(table.mappings.iter().find(|mapping| mapping.variants.contains(&variant)).map(|mapping| mapping.material))
}
