//! The tables of a capture file: their keys, types and documentation. The JSON Schema is made of the doc comments here,
//! so they speak to who writes a capture file.
//!
//! What values mean, and which of them go together, is settled in the modules beside this folder.

mod camera;
mod colour;
mod light;
mod material;
mod scene;
mod settings;

use std::collections::BTreeMap;

use schemars::JsonSchema;

use crate::sensor::SensorDescription;

pub(super) use camera::{
    AutofocusTable, CameraTable, DistortionTable, FocusDistance, IntrinsicsTable, LensTable, LensType,
};
pub(super) use camera::{DistortionModel, FalloffName};
pub(super) use colour::{FilterName, LightColour, ReflectanceSource, TextureFile, WrapName};
pub(super) use light::{DirectionalTable, LightTable, LightType, PointTable, SpotTable};
pub(super) use material::{
    ConductorTable, DielectricTable, DiffuseTable, EmissionTable, IndexSource, KeptTable, MaterialTable, MaterialType,
    MetalSource, MetallicRoughnessTable, TypedMaterialTable,
};
pub(super) use scene::{EnvironmentSource, EnvironmentTable, NormalsName, SceneTable};
pub(super) use settings::{ExposureTable, IrradianceSource, OutputTable, RenderTable, SamplerName};

/// A capture: a scene, the camera that looks at it, and what to make of it. All quantities are in the unit that their
/// key names; lengths in metres, angles in degrees.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields, title = "photosite capture")]
#[expect(dead_code, reason = "the shape of a file, for the JSON Schema; its tables are read one by one")]
pub(super) struct CaptureFile {
    /// What is there: geometry and surroundings.
    scene: Option<SceneTable>,
    /// Lights without a surface, besides those of the geometry's files.
    lights: Option<Vec<LightTable>>,
    /// Materials by the names that the geometry uses; each replaces what the geometry's file says.
    materials: Option<BTreeMap<String, MaterialTable>>,
    /// Where the camera stands. Without it, the first camera of the geometry's files is used, or one that frames all of
    /// it.
    camera: Option<CameraTable>,
    /// The lens.
    lens: Option<LensTable>,
    /// The sensor: a preset, and any keys that shall differ from it.
    sensor: Option<SensorTable>,
    /// How long, at what gain and temperature. Without it, the time is chosen automatically.
    exposure: Option<ExposureTable>,
    /// How light is traced.
    render: Option<RenderTable>,
    /// What is written.
    output: Option<OutputTable>,
}

/// Names of the tables of a capture file.
pub(super) const SECTIONS: [&str; 9] =
    ["scene", "lights", "materials", "camera", "lens", "sensor", "exposure", "render", "output"];

/// A preset with changes.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "the shape of a table, for the JSON Schema; it is merged before it is read")]
struct SensorTable {
    /// Name of a sensor that ships with photosite (`photosite sensors` lists them), or the path of a sensor file,
    /// relative to this file. Left out: "generic-cmos-color".
    preset: Option<String>,
    #[schemars(flatten)]
    changes: SensorDescription,
}
