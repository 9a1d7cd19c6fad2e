//! Reading all tables of a capture file, before anything that they name: a misspelt key is reported at once.

use std::collections::BTreeMap;
use std::path::Path;

use serde::de::DeserializeOwned;

use super::super::settings::sensor::read_sensor;
use super::super::tables::{
    CaptureFile, LightTable, LightType, MaterialTable, MixTable, PlacementTable, SECTIONS, TargetTable,
    TypedMaterialTable,
};
use super::super::tree::nodes::{Node, Value};
use super::super::tree::source::CaptureSource;
use photosite_calibration::targets::TargetKind;
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::{Invalid, Result};

impl CaptureFile {
    /// Reads the tables. `folder` is what their paths are relative to.
    pub(crate) fn read(source: &mut CaptureSource, folder: &Path) -> Result<Self> {
        refuse_unknown_sections(source)?;
        Ok(Self {
            scene: source.read("scene")?.unwrap_or_default(),
            lights: lights(source)?,
            targets: targets(source)?,
            materials: materials(source)?,
            camera: source.read("camera")?.unwrap_or_default(),
            lens: source.read("lens")?.unwrap_or_default(),
            exposure: source.read("exposure")?.unwrap_or_default(),
            render: source.read("render")?.unwrap_or_default(),
            develop: source.read("develop")?.unwrap_or_default(),
            output: source.read("output")?.unwrap_or_default(),
            sensor: read_sensor(source, folder)?,
        })
    }
}

pub(crate) fn refuse_unknown_sections(source: &CaptureSource) -> Result<()> {
    match source.sections().find(|(key, _)| !SECTIONS.contains(key)) {
        Some((key, _)) => {
            let message = format!("unknown key `{key}`{}", did_you_mean(key, SECTIONS));
            let help = format!("the tables of a capture file are {}", list(key, SECTIONS));
            Err(source.error(Invalid::new(key, message).help(help)))
        }
        None => Ok(()),
    }
}

fn materials(source: &CaptureSource) -> Result<BTreeMap<String, MaterialTable>> {
    let Some(node) = source.get("materials") else { return Ok(BTreeMap::new()) };
    let Some(table) = node.as_table() else {
        let help = "for example [materials.wall] with type = \"diffuse\" and reflectance = 0.5";
        return Err(source.error(Invalid::new("materials", "expected a table for every material").help(help)));
    };
    let read = |name: &String, node| material(source, &format!("materials.{name}"), node);
    table.iter().map(|(name, entry)| Ok((name.clone(), read(name, &entry.node)?))).collect()
}

fn material(source: &CaptureSource, path: &str, node: &Node) -> Result<MaterialTable> {
    let (kind, node) = split_type(source, path, node)?;
    let Some(kind) = kind else { return Ok(MaterialTable::Kept(Box::new(source.read_node(path, &node)?))) };
    let mix = |mut node: Node| {
        let mut part = |key: &str| mixed(source, path, key, node.remove(key));
        let (first, second) = (Box::new(part("first")?), Box::new(part("second")?));
        Ok(MixTable { first, second, rest: source.read_node(path, &node)? })
    };
    Ok(MaterialTable::Typed(Box::new(TypedMaterialTable::read(kind, source, path, node, mix)?)))
}

/// A material of a mix.
fn mixed(source: &CaptureSource, path: &str, key: &str, node: Option<Node>) -> Result<TypedMaterialTable> {
    const HELP: &str = "for example first = { type = \"diffuse\", reflectance = 0.5 }";
    let Some(node) = node else {
        return Err(source.error(Invalid::new(path, format!("the key `{key}` is missing")).help(HELP)));
    };
    let path = format!("{path}.{key}");
    if node.as_table().is_none() {
        return Err(source.error(Invalid::new(path, "expected a table").help(HELP)));
    }
    match material(source, &path, &node)? {
        MaterialTable::Typed(table) => Ok(*table),
        MaterialTable::Kept(_) => Err(source.error(Invalid::new(path, "the key `type` is missing").help(HELP))),
    }
}

fn lights(source: &CaptureSource) -> Result<Vec<LightTable>> {
    let Some(node) = source.get("lights") else { return Ok(Vec::new()) };
    let Value::Array(nodes) = &node.value else {
        let invalid = Invalid::new("lights", "expected a list of tables");
        return Err(source.error(invalid.help("begin each light with [[lights]]")));
    };
    nodes.iter().enumerate().map(|(i, node)| light(source, &format!("lights[{i}]"), node)).collect()
}

fn light(source: &CaptureSource, path: &str, node: &Node) -> Result<LightTable> {
    let (kind, node) = split_type(source, path, node)?;
    let Some(kind) = kind else {
        let invalid = Invalid::new(path, "the key `type` is missing");
        let (first, others) = (LightType::NAMES[0], list("", LightType::NAMES[1..].iter().copied()));
        return Err(source.error(invalid.help(format!("write type = \"{first}\", or one of {others}"))));
    };
    LightTable::read(kind, source, path, &node)
}

fn targets(source: &CaptureSource) -> Result<Vec<TargetTable>> {
    let Some(node) = source.get("targets") else { return Ok(Vec::new()) };
    let Value::Array(nodes) = &node.value else {
        let invalid = Invalid::new("targets", "expected a list of tables");
        return Err(source.error(invalid.help("begin each target with [[targets]]")));
    };
    nodes.iter().enumerate().map(|(i, node)| target(source, &format!("targets[{i}]"), node)).collect()
}

/// A target: where it stands, and what it is.
pub(crate) fn target(source: &CaptureSource, path: &str, node: &Node) -> Result<TargetTable> {
    let (kind, mut description) = split_type::<TargetKind>(source, path, node)?;
    let kind = kind.ok_or_else(|| {
        let names = TargetKind::ALL.iter().map(|kind| kind.name());
        let invalid = Invalid::new(path, "the key `type` is missing");
        source.error(invalid.help(format!("write type = \"chessboard\", or one of {}", list("", names))))
    })?;
    let mut placement = description.clone();
    if let (Value::Table(place), Value::Table(own)) = (&mut placement.value, &mut description.value) {
        place.retain(|key, _| PlacementTable::KEYS.contains(&key.as_str()));
        own.retain(|key, _| !PlacementTable::KEYS.contains(&key.as_str()));
    }
    Ok(TargetTable {
        description: source.read_beside(path, &description, kind, &PlacementTable::KEYS)?,
        placement: source.read_node(path, &placement)?,
    })
}

/// Takes the `type` out of a table, so that the rest can be read as that type has it.
fn split_type<T: DeserializeOwned>(source: &CaptureSource, path: &str, node: &Node) -> Result<(Option<T>, Node)> {
    let mut node = node.clone();
    let kind = node.remove("type").map(|kind| source.read_node(&format!("{path}.type"), &kind));
    Ok((kind.transpose()?, node))
}
