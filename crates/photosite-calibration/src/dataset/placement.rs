//! `[[place]]` of a data set file.

use photosite_core::schema_range::{above, within};
use schemars::JsonSchema;
use serde::Deserialize;

/// Objects with places of their own in each frame. No object meets another, or anything else of the scene, by any of
/// its triangles.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaceDescription {
    /// Files of geometry, relative to this file, or patterns such as "models/*.glb": which of them is drawn for each
    /// object.
    pub objects: Vec<String>,
    /// Number of objects, or the least and the largest number, of which one is drawn. Left out: 1.
    pub count: Option<CountDescription>,
    /// Class of the objects, for ground truth. Left out: the name of the file without its extension.
    pub category: Option<String>,
    /// Method of placement.
    pub method: PlaceMethod,
    /// Box in which their centres of mass lie, or from which they fall. Left out: above the surface, or in the bin.
    pub region: Option<RegionDescription>,
    /// Name of an object of the capture that they lie or stand on, such as a table or a tray. Those that fall off it
    /// are dropped again.
    pub surface: Option<String>,
    /// Box without a lid that objects are dropped into, which is not rendered.
    pub bin: Option<BinDescription>,
    /// Height of the ground that they lie or stand on, m. Left out: that of the capture's ground, if it states one;
    /// otherwise there is none.
    pub ground_height_m: Option<f64>,
    /// Orientation in a box or on a surface. Left out: any way round in a box, about the vertical on a surface.
    pub rotation: Option<PlaceRotation>,
    /// Scale, drawn evenly between these two factors. Left out: [1, 1].
    #[schemars(transform = above(0.0..))]
    pub scale: Option<[f64; 2]>,
    /// Size of an object, the longest side of the box around it in its own axes, m: a number, or two between which it
    /// is drawn evenly. It makes objects of any unit equally large; instead of scale. Left out: as the files have them.
    pub size_m: Option<SizeDescription>,
    /// Gap to each other and to all that they do not stand on, m; it does not apply to objects that fall. Left out: 0.
    #[schemars(transform = within(0.0..))]
    pub min_distance_m: Option<f64>,
    /// Names of materials of the capture's `[materials]` or of geometry files: one is drawn for each object.
    /// Left out: those of the files.
    #[serde(default)]
    pub materials: Vec<String>,
    /// Whether the files have z up in place of y. Left out: true of STL files, which come from CAD, and false of
    /// others.
    pub z_up: Option<bool>,
    /// Length of the unit of the files, m. Left out: 1.
    #[schemars(transform = above(0.0..))]
    pub meters_per_unit: Option<f64>,
    /// Coulomb's coefficient of friction between objects that fall and all else. Left out: 0.5.
    #[schemars(transform = within(0.0..))]
    pub friction: Option<f64>,
    /// Restitution, the part of their speed with which objects that fall bounce, 0–1. Left out: 0.1.
    #[schemars(transform = within(0.0..=1.0))]
    pub restitution: Option<f64>,
    /// Number of frames in a row that have the same places: all of the set, seen from a camera that moves, or 10. Left
    /// out: 1.
    #[schemars(transform = within(1.0..))]
    pub frames: Option<u32>,
}

/// Method of placement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlaceMethod {
    /// Anywhere in the region; nothing holds them.
    Box,
    /// Placed on points of the surface, spread evenly over its upward faces, turned as `rotation` has it.
    Surface,
    /// Standing or lying as they do by themselves, on the ground or the surface, turned about the vertical: how
    /// probable each way is follows from the convex hull.
    Rest,
    /// Dropped any way round, one over the other, until all are at rest: heaps, and objects in bins.
    Drop,
    /// Stacked one upon the other in the middle of the region, in the order in which they are drawn.
    Stack,
}

/// Orientation of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlaceRotation {
    /// Any way round, evenly.
    Any,
    /// About the vertical, evenly.
    Vertical,
    /// Orientation as in the files.
    None,
}

/// Number of objects, or a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a number of objects, or the least and the largest such as [3, 8]")]
pub enum CountDescription {
    /// Exact number.
    Exact(u32),
    /// Least and largest number.
    Range([u32; 2]),
}

/// Length, or a range of lengths, m.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a length in metres, or the least and the largest such as [0.1, 0.2]")]
pub enum SizeDescription {
    /// Exact length.
    Exact(#[schemars(transform = above(0.0..))] f64),
    /// Least and largest length.
    Range(#[schemars(transform = above(0.0..))] [f64; 2]),
}

impl SizeDescription {
    /// Least and largest length, m.
    pub fn range(self) -> [f64; 2] {
        match self {
            Self::Exact(size) => [size; 2],
            Self::Range(range) => range,
        }
    }
}

/// Box along the axes of the world.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegionDescription {
    /// Lowest coordinates of the box, m.
    pub min_m: [f64; 3],
    /// Highest coordinates of the box, m.
    pub max_m: [f64; 3],
}

/// Box without a lid.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BinDescription {
    /// Inner width, height and depth of the bin, m.
    #[schemars(transform = above(0.0..))]
    pub size_m: [f64; 3],
    /// Middle of its floor, m. Left out: [0, 0, 0].
    pub position_m: Option<[f64; 3]>,
    /// Thickness of its walls, m. Left out: 0.01.
    #[schemars(transform = above(0.0..))]
    pub wall_m: Option<f64>,
}

impl CountDescription {
    /// Least and largest number of objects.
    pub fn range(self) -> [u32; 2] {
        match self {
            Self::Exact(count) => [count; 2],
            Self::Range(range) => range,
        }
    }
}
