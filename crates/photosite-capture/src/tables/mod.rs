//! The tables of a capture file: their keys, types and documentation. The JSON Schema is made of the doc comments here,
//! so they speak to who writes a capture file.
//!
//! What values mean, and which of them go together, is settled in the modules beside this folder.

pub(crate) mod camera;
pub(crate) mod colour;
pub(crate) mod file_kind;
pub(crate) mod geometry_kind;
pub(crate) mod lens_elements;
pub(crate) mod lights;
pub(crate) mod material;
pub(crate) mod motion;
pub(crate) mod object;
pub(crate) mod scene;
pub(crate) mod schema;
pub(crate) mod settings;
pub(crate) mod spectra;
pub(crate) mod surroundings;
pub(crate) mod target;

use std::collections::BTreeMap;

use schemars::JsonSchema;

use photosite_core::keys::Keys;
use photosite_core::schema_range::within;
use photosite_develop::DevelopSettings;
use photosite_sensor::SensorDescription;
use photosite_transport::integrator::RenderSettings;

pub(crate) use camera::{
    AutofocusTable, CameraTable, DistortionTable, FocusDistance, IntrinsicsTable, LensTable, LensType,
};
pub(crate) use camera::{
    DistortionModel, KernelOrigin, LateralColourTable, PointSpreadTable, ProjectionKind, StopTable,
};
pub(crate) use colour::{LightColour, ReflectanceSource, TextureFile};
pub(crate) use lens_elements::{AutofocusKind, AutofocusSearchTable, LensmakerTable, Radius, SupplementaryTable};
pub(crate) use lights::{
    DirectionalTable, GaussianBeamTable, LightTable, LightType, PointTable, ProfileTable, ProjectorTable, SpotTable,
};
pub(crate) use material::*;
pub(crate) use motion::{CameraMotionTable, ObjectMotionTable, ObjectPoseTable, PoseTable, TurntableTable};
pub(crate) use object::{MaterialChoice, ObjectTable, ScaleSource, UpAxis};
pub(crate) use scene::{EnvironmentSource, EnvironmentTable, SceneTable, SkyTable};
pub use settings::RawFormat;
pub(crate) use settings::{
    ExposureTable, IrradianceSource, LONGEST_STEP_EV, NextSource, NoiseSource, OutputTable, PartnerSource,
    PartnerTable, TruthSource,
};
pub(crate) use surroundings::{BackdropTable, GroundSource, GroundTable};
pub(crate) use target::{PlacementTable, TargetTable};

/// A capture: a scene, the camera that looks at it, and what to make of it. All quantities are in the unit that their
/// key names; lengths in metres, angles in degrees.
#[derive(Debug, JsonSchema, Keys)]
#[schemars(deny_unknown_fields, title = "photosite capture")]
pub(crate) struct CaptureFile {
    /// Scene: geometry and surroundings.
    #[schemars(with = "Option<SceneTable>")]
    pub(crate) scene: SceneTable,
    /// Lights without a surface, besides those of the geometry's files.
    #[schemars(with = "Option<Vec<LightTable>>")]
    pub(crate) lights: Vec<LightTable>,
    /// Calibration targets, flat sheets of exact patterns whose points `capture.json` lists.
    #[schemars(with = "Option<Vec<TargetTable>>")]
    pub(crate) targets: Vec<TargetTable>,
    /// Materials by the names that the geometry uses; each replaces what the geometry's file says.
    #[schemars(with = "Option<BTreeMap<String, MaterialTable>>")]
    pub(crate) materials: BTreeMap<String, MaterialTable>,
    /// Where the camera stands. Without it, the first camera of the geometry's files is used, or one that frames all of
    /// it.
    #[schemars(with = "Option<CameraTable>")]
    pub(crate) camera: CameraTable,
    /// The lens.
    #[schemars(with = "Option<LensTable>")]
    pub(crate) lens: LensTable,
    /// The sensor: a preset, and any keys that shall differ from it. That of `capture.json` is whole, without a preset.
    #[schemars(with = "Option<SensorTable>")]
    pub(crate) sensor: MergedSensor,
    /// How long, at what gain and temperature. Without it, the time is chosen automatically.
    #[schemars(with = "Option<ExposureTable>")]
    pub(crate) exposure: ExposureTable,
    /// How light is traced.
    #[schemars(with = "Option<RenderSettings>")]
    pub(crate) render: RenderSettings,
    /// How the raw image is developed.
    #[schemars(with = "Option<DevelopSettings>")]
    pub(crate) develop: DevelopSettings,
    /// Files that are written.
    #[schemars(with = "Option<OutputTable>")]
    pub(crate) output: OutputTable,
}

/// Names of the tables of a capture file.
pub(crate) const SECTIONS: [&str; 11] =
    ["scene", "lights", "targets", "materials", "camera", "lens", "sensor", "exposure", "render", "develop", "output"];

/// A preset or sensor file with the changes of `[sensor]` laid over it.
#[derive(Debug)]
pub(crate) struct MergedSensor {
    /// Name of the preset or file.
    pub(crate) name: String,
    pub(crate) description: SensorDescription,
    /// Warnings about the changes.
    pub(crate) warnings: Vec<String>,
}

/// A preset with changes.
#[derive(Debug, JsonSchema, Keys)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "the shape of a table, for the JSON Schema; it is merged before it is read")]
struct SensorTable {
    /// Name of a sensor that ships with photosite (`photosite sensors` lists them), or the path of a sensor file,
    /// relative to this file; "none" begins from nothing. Left out: "generic-cmos-color".
    preset: Option<String>,
    /// Keys and tables of the preset that this sensor does not have, such as ["filter", "channels.G",
    /// "noise.prnu_percent"]. They are taken away before the keys here are laid over the preset.
    without: Option<Vec<String>>,
    /// The same sensor with these columns and rows of pixels in place of its own, for an image of the same view at
    /// another size. The sensor keeps its size (with another shape of the image, it grows at two sides); pixels get
    /// larger or smaller, full well and conversion gain with their area, so that the same exposure gives as bright an
    /// image. Left out: its own pixels.
    #[schemars(transform = within(1.0..=65_535.0))]
    scaled_to_px: Option<[u32; 2]>,
    #[schemars(flatten)]
    changes: SensorDescription,
}
