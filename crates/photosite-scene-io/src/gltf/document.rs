//! The JSON of a document, in the types of the `gltf` crate.
//!
//! These types require fields that the specification leaves open, such as the node of an animation's channel and the
//! nodes of a scene; missing ones are filled in before a document is refused. Channels of KHR_animation_pointer that
//! move a node become channels of that node.

use std::path::Path;

use gltf::json::Root;
use gltf::json::animation::VALID_PROPERTIES;
use serde_json::{Value, json};

use photosite_core::{Invalid, Result};

/// Extension for animation channels that name their target by a pointer.
pub(super) const POINTER: &str = "KHR_animation_pointer";

/// Node of a channel that moves none.
pub(super) const NO_NODE: usize = u32::MAX as usize;

/// Help for files of the first version.
pub(super) const CONVERT: &str =
    "only version 2.0 is supported; export the scene again, or convert it: gltf-pipeline -i old.gltf -o new.gltf";

/// A document.
pub(super) struct Document {
    pub(super) root: Root,
    /// Animation channels that move no node.
    pub(super) still: Vec<StillChannel>,
}

/// A channel of an animation that moves no node.
pub(super) struct StillChannel {
    key: String,
    /// Pointer to its target instead.
    pointer: Option<String>,
}

impl Document {
    /// Parses the text of a document; `is_text` tells whether its lines are of use in messages.
    pub(super) fn parse(json: &[u8], path: &Path, is_text: bool) -> Result<Self> {
        let refused = |error: serde_json::Error| {
            let text = if error.is_eof() { "it ends too early".to_owned() } else { error.to_string() };
            let problem = text.rsplit_once(" at line ").map_or(&*text, |(problem, _)| problem);
            let invalid =
                Invalid::new("", format!("is not a glTF document: {problem}")).help("export the scene as glTF 2.0");
            if is_text && error.line() > 0 { invalid.at_line(path, error.line()) } else { invalid.in_file(path) }
        };
        let first = match serde_json::from_slice::<Root>(json) {
            Ok(root) if !root.extensions_used.iter().any(|name| name == POINTER) => {
                return Ok(Self { root, still: Vec::new() });
            }
            Ok(_) => None,
            Err(error) if error.is_data() => Some(error),
            Err(error) => return Err(refused(error)),
        };
        let mut value: Value = serde_json::from_slice(json).map_err(refused)?;
        if let Some(version) = first_version(&value) {
            let message = format!("is glTF {version}, whose documents are built in another way");
            return Err(Invalid::new("asset.version", message).help(CONVERT).in_file(path));
        }
        let (still, is_changed) = complete(&mut value);
        match serde_json::from_value(value) {
            Ok(root) => Ok(Self { root, still }),
            // The first error is of the file as it is, with its line.
            Err(error) => Err(refused(first.filter(|_| !is_changed).unwrap_or(error))),
        }
    }

    /// Reports channels that move nothing.
    ///
    /// # Errors
    ///
    /// A pointer that is not followed, where the document requires that.
    pub(super) fn say_what_stands_still(&self, mut say: impl FnMut(String)) -> Result<(), Invalid> {
        let is_required = self.root.extensions_required.iter().any(|name| name == POINTER);
        let (pointers, nothing): (Vec<_>, Vec<_>) = self.still.iter().partition(|channel| channel.pointer.is_some());
        for (channels, what) in [(pointers, "moves"), (nothing, "has no node")] {
            let Some(channel) = channels.first() else { continue };
            let (key, pointer) = (&channel.key, channel.pointer.as_deref().unwrap_or_default());
            if is_required && !pointer.is_empty() {
                let message = format!("moves {pointer}, which the file requires and {POINTER} is not followed for");
                let help = "translation, rotation, scale and weights of nodes are; export the scene without the others";
                return Err(Invalid::new(format!("{key}.target"), message).help(help));
            }
            let more = match channels.len() - 1 {
                0 => String::new(),
                n => format!(" (as {n} more)"),
            };
            let result = if pointer.is_empty() { "and is left out" } else { ", which stands still" };
            say(format!("the channel {key} {what} {pointer}{result}{more}"));
        }
        Ok(())
    }
}

/// Version of a document before 2.0, whose lists were tables by name.
fn first_version(document: &Value) -> Option<String> {
    let version = document.pointer("/asset/version");
    let version = version.and_then(|version| {
        let text = version.as_str().map(str::to_owned);
        text.or_else(|| version.as_f64().map(|number| format!("{number:.1}")))
    });
    match version {
        Some(version) => Some(version).filter(|version| version.starts_with("1.") || version.starts_with("0.")),
        // Version 1.0 let the asset be left out.
        None => {
            ["nodes", "meshes", "accessors"].iter().any(|list| document[list].is_object()).then(|| "1.0".to_owned())
        }
    }
}

/// Fills in fields that the specification leaves open. Returns the channels that move no node, and whether anything was
/// missing.
fn complete(document: &mut Value) -> (Vec<StillChannel>, bool) {
    let (mut still, mut is_changed) = (Vec::new(), false);
    for scene in elements(document, "scenes").filter_map(Value::as_object_mut) {
        is_changed |= !scene.contains_key("nodes");
        scene.entry("nodes").or_insert_with(|| json!([]));
    }
    for (a, animation) in elements(document, "animations").enumerate() {
        for (c, channel) in elements(animation, "channels").enumerate() {
            let Some(target) = channel.get_mut("target").and_then(Value::as_object_mut) else { continue };
            let pointer = target
                .get("extensions")
                .and_then(|extensions| extensions.get(POINTER)?.get("pointer")?.as_str())
                .map(str::to_owned);
            if let Some((node, property)) = pointer.as_deref().and_then(moved_node) {
                target.insert("node".to_owned(), node.into());
                target.insert("path".to_owned(), property.into());
            } else if pointer.is_some() || !target.contains_key("node") {
                target.insert("node".to_owned(), NO_NODE.into());
                still.push(StillChannel { key: format!("animations[{a}].channels[{c}]"), pointer });
            } else {
                continue;
            }
            is_changed = true;
        }
    }
    (still, is_changed)
}

fn elements<'a>(of: &'a mut Value, list: &str) -> impl Iterator<Item = &'a mut Value> {
    of.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Node and property that a pointer names, `/nodes/3/rotation`.
fn moved_node(pointer: &str) -> Option<(u32, &str)> {
    let (node, property) = pointer.strip_prefix("/nodes/")?.split_once('/')?;
    let property = Some(property).filter(|name| VALID_PROPERTIES.contains(name));
    Some((node.parse().ok()?, property?))
}
