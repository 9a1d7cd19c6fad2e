//! `[[scene.objects]]`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ObjectMotionTable;
use photosite_core::keys::Keys;
use photosite_core::schema_range::above;
use photosite_scene_io::MissingNormals;

/// Object: a file of geometry with a pose. Objects of the same file share its memory.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectTable {
    /// File of geometry, relative to this file.
    pub(crate) file: String,
    /// Name, for messages and for ground truth. Left out: that of the file, and of further objects of the same name
    /// "NAME-1" …
    pub(crate) name: Option<String>,
    /// Class of the object, for ground truth. Left out: the name of the file without its extension.
    pub(crate) category: Option<String>,
    /// Origin of the object, m. Left out: [0, 0, 0].
    pub(crate) position_m: Option<[f64; 3]>,
    /// Rotation about the world's x axis, then y, then z, degrees, counter-clockwise seen against the axis.
    /// Left out, as are the next two: [0, 0, 0].
    pub(crate) rotation_deg: Option<[f64; 3]>,
    /// Rotation as a quaternion w, x, y, z, of any length; instead of rotation_deg.
    pub(crate) quaternion_wxyz: Option<[f64; 4]>,
    /// Point that the object's +z axis, the front of glTF's models, faces, with its y axis up; instead of
    /// rotation_deg.
    pub(crate) look_at_m: Option<[f64; 3]>,
    /// Scale, one factor or one along each axis of the object. Left out: 1.
    pub(crate) scale: Option<ScaleSource>,
    /// Axis of the file that points up. The object's own axes are those after it was turned to y. Left out: "z" of STL
    /// files, which come from CAD, and "y" of others.
    pub(crate) up: Option<UpAxis>,
    /// Length of the unit of the file, m. Left out: 1. OBJ, PLY and STL files state none.
    #[schemars(transform = above(0.0..))]
    pub(crate) meters_per_unit: Option<f64>,
    /// Name of a material of `[materials]` or of the geometry's files, for all of it, or by the names that the file
    /// uses: { paint = "red", "*" = "grey" }.
    pub(crate) material: Option<MaterialChoice>,
    /// Name of a material variant of the file (KHR_materials_variants). Left out: its basic materials.
    pub(crate) variant: Option<String>,
    /// Name of an animation of the file, or "animation-0" … Left out: the static pose of the file.
    pub(crate) animation: Option<String>,
    /// Time of the animation at scene.time_s = 0, s. Left out: 0.
    pub(crate) animation_time_s: Option<f64>,
    /// Motion, during the exposure as well. Left out: none.
    pub(crate) motion: Option<ObjectMotionTable>,
    /// Shading of faces without normals. Left out: "flat".
    pub(crate) generate_normals: Option<MissingNormals>,
    /// Key points of ground truth, by name: in the object's own axes, m before `scale`.
    #[serde(default)]
    pub(crate) keypoints: BTreeMap<String, [f64; 3]>,
    /// Whether the object is in the scene. Left out: true.
    pub(crate) visible: Option<bool>,
}

/// A factor, or one along each axis.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Keys)]
#[serde(untagged, expecting = "expected a factor, or one for each axis such as [1, 2, 1]")]
pub(crate) enum ScaleSource {
    /// One factor for all axes.
    All(#[schemars(transform = above(0.0..))] f64),
    /// Factors along x, y and z.
    Each(#[schemars(transform = above(0.0..))] [f64; 3]),
}

/// Axis.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, JsonSchema, PartialEq, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum UpAxis {
    /// y, as in glTF.
    Y,
    /// z, as in CAD, robotics and Blender: −y becomes the front.
    Z,
}

/// One material, or one for each name.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(untagged, expecting = "expected the name of a material, or a table of names such as { paint = \"red\" }")]
pub(crate) enum MaterialChoice {
    /// For all of the object.
    All(String),
    /// By the names that the file uses; "*" is all others.
    ByName(BTreeMap<String, String>),
}
