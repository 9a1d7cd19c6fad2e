//! Node hierarchy: nodes of the scene and their transforms to the world.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::json::Root;
use gltf::json::scene::Node;

use super::buffers::out_of_range;
use photosite_core::Invalid;

/// A node of the scene with its transform to the world.
pub(super) struct PlacedNode<'a> {
    pub(super) index: usize,
    pub(super) node: &'a Node,
    pub(super) name: String,
    pub(super) to_world: DAffine3,
    /// Whether neither the node nor one above it is hidden (KHR_node_visibility).
    pub(super) is_visible: bool,
}

/// Nodes of the default scene, parents before children. `nodes` are those of the document at some time.
pub(super) fn placed_nodes<'a>(root: &Root, nodes: &'a [Node]) -> Result<Vec<PlacedNode<'a>>, Invalid> {
    let mut placed = Vec::new();
    let mut parents: Vec<Visit> = vec![Visit::Never; nodes.len()];
    let mut stack: Vec<Pending> = roots(root)?;
    stack.reverse();
    while let Some(Pending { index, parent, to_world, is_visible, key }) = stack.pop() {
        let node = nodes.get(index).ok_or_else(|| out_of_range(&key, "nodes", index, nodes.len()))?;
        if parents[index] != Visit::Never {
            return Err(visited_twice(&parents, index, parent, &key));
        }
        parents[index] = parent.map_or(Visit::Root, Visit::ChildOf);
        let name = node.name.clone().unwrap_or_else(|| format!("node-{index}"));
        let local = local_transform(node, index, &name)?;
        let to_world = to_world * local;
        let is_visible = is_visible && says_visible(node, index)?;
        if !is_invertible(&to_world) {
            let message = format!("the transform of the node {name:?} and its parents leaves the range of numbers");
            return Err(Invalid::new(format!("nodes[{index}]"), message));
        }
        for (c, child) in node.children.as_deref().unwrap_or_default().iter().enumerate().rev() {
            let key = format!("nodes[{index}].children[{c}]");
            stack.push(Pending { index: child.value(), parent: Some(index), to_world, is_visible, key });
        }
        placed.push(PlacedNode { index, node, name, to_world, is_visible });
    }
    Ok(placed)
}

/// A node that is still to be placed.
struct Pending {
    index: usize,
    parent: Option<usize>,
    /// Transform parent → world.
    to_world: DAffine3,
    /// Whether all nodes above it are visible.
    is_visible: bool,
    /// Path of the reference to the node, for messages.
    key: String,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Visit {
    Never,
    Root,
    ChildOf(usize),
}

/// Roots of the default scene; without scenes, all nodes that are nobody's children.
fn roots(root: &Root) -> Result<Vec<Pending>, Invalid> {
    let pending = |index, key| Pending { index, parent: None, to_world: DAffine3::IDENTITY, is_visible: true, key };
    let scene = root.scene.map_or(0, |scene| scene.value());
    if let Some(description) = root.scenes.get(scene) {
        let key = |i| format!("scenes[{scene}].nodes[{i}]");
        return Ok(description.nodes.iter().enumerate().map(|(i, node)| pending(node.value(), key(i))).collect());
    }
    if root.scene.is_some() {
        return Err(out_of_range("scene", "scenes", scene, root.scenes.len()));
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(flag) = is_child.get_mut(child.value()) {
            *flag = true;
        }
    }
    let roots: Vec<Pending> =
        (0..is_child.len()).filter(|&i| !is_child[i]).map(|i| pending(i, format!("nodes[{i}]"))).collect();
    if roots.is_empty() && !root.nodes.is_empty() {
        return Err(
            Invalid::new("nodes", "form a cycle: each is the child of another").help("a node cannot contain itself")
        );
    }
    Ok(roots)
}

/// Error of a node that is reached a second time, from `parent`.
fn visited_twice(parents: &[Visit], index: usize, parent: Option<usize>, key: &str) -> Invalid {
    let mut ancestor = parent;
    while let Some(node) = ancestor {
        if node == index {
            return Invalid::new(key, format!("the nodes form a cycle: nodes[{index}] contains itself"))
                .help("a node cannot be among its own descendants; remove the entry");
        }
        ancestor = match parents[node] {
            Visit::ChildOf(parent) => Some(parent),
            Visit::Root | Visit::Never => None,
        };
    }
    Invalid::new(key, format!("nodes[{index}] appears in the hierarchy twice"))
        .help("every node has at most one parent; to place a mesh twice, make two nodes that refer to it")
}

/// Visibility of a node by KHR_node_visibility, true by default.
fn says_visible(node: &Node, index: usize) -> Result<bool, Invalid> {
    const NAME: &str = "KHR_node_visibility";
    let Some(table) = node.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(true) };
    match table.get("visible") {
        None => Ok(true),
        Some(value) => value.as_bool().ok_or_else(|| {
            let key = format!("nodes[{index}].extensions.{NAME}.visible");
            Invalid::new(key, format!("must be true or false, got {value}"))
        }),
    }
}

/// Transform node → parent.
fn local_transform(node: &Node, index: usize, name: &str) -> Result<DAffine3, Invalid> {
    let key = format!("nodes[{index}]");
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let (local, key) = if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        let last_row = matrix.row(3).to_array();
        if last_row != [0.0, 0.0, 0.0, 1.0] {
            let message =
                format!("the last row of the matrix of {name:?} is {last_row:?}, so it is not an affine transform");
            return Err(Invalid::new(format!("{key}.matrix"), message).help("the last row must be 0, 0, 0, 1"));
        }
        (DAffine3::from_mat4(matrix), format!("{key}.matrix"))
    } else {
        let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
        let quaternion = DQuat::from_array(rotation);
        let length = quaternion.length();
        if !(length.is_finite() && length > 0.0) {
            let message = format!("{rotation:?} of the node {name:?} is not a rotation");
            return Err(Invalid::new(format!("{key}.rotation"), message).help("write a unit quaternion x, y, z, w"));
        }
        let scale = wide(node.scale.unwrap_or([1.0; 3]));
        let translation = wide(node.translation.unwrap_or_default());
        let local = DAffine3::from_scale_rotation_translation(scale, quaternion / length, translation);
        (local, if node.scale.is_some() { format!("{key}.scale") } else { key })
    };
    if !is_invertible(&local) {
        let message =
            format!("the transform of the node {name:?} is singular: it flattens its contents, or is not finite");
        return Err(Invalid::new(key, message).help("give every axis a scale other than 0, or remove the node"));
    }
    Ok(local)
}

/// Whether a transform is finite and keeps three dimensions. The determinant is compared with the lengths of the axes,
/// so that tiny scales pass and parallel axes do not: rounding to f32 leaves at least about 1e-7 of their product.
pub(super) fn is_invertible(transform: &DAffine3) -> bool {
    let m = transform.matrix3;
    let volume = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    transform.is_finite() && volume > 0.0 && m.determinant().abs() > 1e-12 * volume && transform.inverse().is_finite()
}

/// Rotation and translation of a transform, without scale, shear or mirroring, for cameras and lights. The direction of
/// −Z is kept exactly.
pub(super) fn rigid(transform: &DAffine3) -> DAffine3 {
    let m = transform.matrix3;
    let z = m.z_axis.normalize();
    let y = (m.y_axis - z * z.dot(m.y_axis)).normalize();
    DAffine3::from_cols(y.cross(z), y, z, transform.translation)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(nodes: serde_json::Value, scenes: serde_json::Value) -> Root {
        let document = serde_json::json!({ "asset": { "version": "2.0" }, "nodes": nodes, "scenes": scenes });
        serde_json::from_value(document).expect("a glTF document")
    }

    fn names(root: &Root) -> Vec<String> {
        placed_nodes(root, &root.nodes).expect("valid").into_iter().map(|placed| placed.name).collect()
    }

    #[test]
    fn transforms_multiply_from_the_root_down() {
        let root = parse(
            serde_json::json!([
                { "name": "child", "translation": [1.0, 0.0, 0.0] },
                { "name": "parent", "children": [0], "scale": [2.0, 2.0, 2.0],
                  "rotation": [0.0, 0.0, 1.0, 1.0], "translation": [0.0, 0.0, 5.0] },
            ]),
            serde_json::json!([{ "nodes": [1] }]),
        );
        let placed = placed_nodes(&root, &root.nodes).expect("valid");
        assert_eq!(placed[1].name, "child");
        // Scaled by 2, turned by 90° about z (x → y; the quaternion is made a unit one), moved by 5 along z.
        let origin = placed[1].to_world.transform_point3(DVec3::ZERO);
        assert!((origin - DVec3::new(0.0, 2.0, 5.0)).length() < 1e-7, "{origin}");
    }

    #[test]
    fn without_scenes_every_root_counts() {
        let root = parse(
            serde_json::json!([{ "name": "a" }, { "name": "b", "children": [2] }, { "name": "c" }]),
            serde_json::json!([]),
        );
        assert_eq!(names(&root), ["a", "b", "c"]);
    }

    #[test]
    fn cycles_and_second_parents_are_refused() {
        let scene = serde_json::json!([{ "nodes": [0] }]);
        for (nodes, scenes, word) in [
            (serde_json::json!([{ "children": [1] }, { "children": [0] }]), scene.clone(), "cycle"),
            (serde_json::json!([{ "children": [0] }]), scene.clone(), "cycle"),
            (serde_json::json!([{ "children": [1] }, { "children": [0] }]), serde_json::json!([]), "cycle"),
            (serde_json::json!([{ "children": [1, 1] }, {}]), scene.clone(), "twice"),
            (serde_json::json!([{ "children": [7] }]), scene.clone(), "nodes[7]"),
            (serde_json::json!([{}]), serde_json::json!([{ "nodes": [3] }]), "nodes[3]"),
        ] {
            let root = parse(nodes, scenes);
            let error = placed_nodes(&root, &root.nodes).err().expect("refused");
            assert!(error.message.contains(word), "{error}");
        }
    }

    #[test]
    fn singular_transforms_are_refused_by_the_name_of_their_node() {
        let flat = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        for node in [
            serde_json::json!({ "name": "bad", "scale": [1.0, 0.0, 1.0] }),
            serde_json::json!({ "name": "bad", "rotation": [0.0, 0.0, 0.0, 0.0] }),
            serde_json::json!({ "name": "bad", "matrix": flat }),
            serde_json::json!({ "name": "bad", "matrix": vec![1.0; 16] }),
            serde_json::json!({ "name": "bad", "translation": [1e39, 0.0, 0.0] }),
        ] {
            let root = parse(serde_json::json!([node]), serde_json::json!([{ "nodes": [0] }]));
            let error = placed_nodes(&root, &root.nodes).err().expect("refused");
            assert!(error.message.contains("\"bad\"") && error.key.starts_with("nodes[0]"), "{error}");
        }
        let tiny =
            parse(serde_json::json!([{ "scale": [1e-20, 1e-20, -1e-20] }]), serde_json::json!([{ "nodes": [0] }]));
        assert_eq!(names(&tiny), ["node-0"]);
    }

    #[test]
    fn a_rigid_transform_keeps_the_viewing_direction() {
        let skewed = DAffine3::from_cols(
            DVec3::new(-2.0, 0.3, 0.0),
            DVec3::new(0.1, 3.0, 0.0),
            DVec3::new(0.0, 1.0, 4.0),
            DVec3::new(1.0, 2.0, 3.0),
        );
        let rigid = rigid(&skewed);
        assert!((rigid.matrix3.determinant() - 1.0).abs() < 1e-12);
        assert!((rigid.matrix3.z_axis - DVec3::new(0.0, 1.0, 4.0).normalize()).length() < 1e-12);
        assert!(rigid.matrix3.x_axis.dot(rigid.matrix3.y_axis).abs() < 1e-12);
    }
}
