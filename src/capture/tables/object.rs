//! `[[scene.objects]]`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::ObjectMotionTable;
use photosite_core::schema_range::above;

/// What a file of geometry holds, somewhere in the world. Objects of the same file share its memory.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectTable {
    /// A file of geometry, relative to this file.
    pub(crate) file: String,
    /// Name, for messages and for ground truth. Left out: that of the file, and of further objects of the same name
    /// "NAME-1" …
    pub(crate) name: Option<String>,
    /// What kind of object it is, for ground truth. Left out: the name of the file without its extension.
    pub(crate) category: Option<String>,
    /// Where the origin of the object is, m. Left out: [0, 0, 0].
    pub(crate) position_m: Option<[f64; 3]>,
    /// Turns about the world's x axis, then y, then z, degrees, counter-clockwise seen against the axis.
    /// Left out, as are the next two: [0, 0, 0].
    pub(crate) rotation_deg: Option<[f64; 3]>,
    /// The turn as a quaternion w, x, y, z, of any length; instead of rotation_deg.
    pub(crate) quaternion_wxyz: Option<[f64; 4]>,
    /// A point that the object's +z axis, the front of glTF's models, faces, with its y axis up; instead of
    /// rotation_deg.
    pub(crate) look_at_m: Option<[f64; 3]>,
    /// Makes it larger by this factor, or by one along each of its axes. Left out: 1.
    pub(crate) scale: Option<ScaleSource>,
    /// Which axis of the file points up. The object's own axes are those after it was turned to y. Left out: "z" of STL files,
    /// which come from CAD, and "y" of others.
    pub(crate) up: Option<UpAxis>,
    /// Length of the unit of the file, m. Left out: 1. OBJ, PLY and STL files state none.
    #[schemars(transform = above(0.0..))]
    pub(crate) meters_per_unit: Option<f64>,
    /// Name of a material of `[materials]` or of the geometry's files, for all of it, or by the names that the file uses:
    /// { paint = "red", "*" = "grey" }.
    pub(crate) material: Option<MaterialChoice>,
    /// Name of a material variant of the file (KHR_materials_variants). Left out: its basic materials.
    pub(crate) variant: Option<String>,
    /// Name of an animation of the file, or "animation-0" … Left out: everything stands as the file has it.
    pub(crate) animation: Option<String>,
    /// When scene.time_s is 0, s of the animation. Left out: 0.
    pub(crate) animation_time_s: Option<f64>,
    /// How it moves, in the time of a picture as well. Left out: not at all.
    pub(crate) motion: Option<ObjectMotionTable>,
    /// What faces without normals get. Left out: "flat".
    pub(crate) generate_normals: Option<NormalsName>,
    /// Points of it that ground truth tells of, by name: in its own axes, m before `scale`.
    #[serde(default)]
    pub(crate) keypoints: BTreeMap<String, [f64; 3]>,
    /// Whether it is there. Left out: true.
    pub(crate) visible: Option<bool>,
}

/// What faces without normals get.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum NormalsName {
    /// Flat shading.
    Flat,
    /// One normal per vertex, smooth over everything.
    Smooth,
}

/// A factor, or one along each axis.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a factor, or one for each axis such as [1, 2, 1]")]
pub(crate) enum ScaleSource {
    /// Of all axes.
    All(#[schemars(transform = above(0.0..))] f64),
    /// Of x, y and z.
    Each(#[schemars(transform = above(0.0..))] [f64; 3]),
}

/// An axis.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum UpAxis {
    /// As in glTF.
    Y,
    /// As in CAD, robotics and Blender: −y becomes the front.
    Z,
}

/// A material for all, or one for each name.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected the name of a material, or a table of names such as { paint = \"red\" }")]
pub(crate) enum MaterialChoice {
    /// For all of the object.
    All(String),
    /// By the names that the file uses; "*" is all others.
    ByName(BTreeMap<String, String>),
}
