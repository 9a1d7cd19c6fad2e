//! Scene in front of the camera: `[scene]`, `[[lights]]`, `[materials.NAME]` and `[[targets]]`.

pub(crate) mod backdrop;
pub(crate) mod default_light;
pub(crate) mod environment;
pub(crate) mod extent;
pub(crate) mod floor_surface;
pub(crate) mod geometry;
pub(crate) mod ground;
pub(crate) mod kept_material;
pub(crate) mod lights;
pub(crate) mod materials;
pub(crate) mod models;
pub(crate) mod moments;
pub(crate) mod motion;
pub(crate) mod object_pose;
pub(crate) mod object_track;
pub(crate) mod objects;
pub(crate) mod quadrics;
pub(crate) mod surroundings;
pub(crate) mod targets;
pub(crate) mod warnings;
