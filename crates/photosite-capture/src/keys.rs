//! Builders of all tables of a capture, one for each, with a setter for each key.
//!
//! They are made of the declarations of the tables, whose documentation they have, and what they say goes the way of a
//! capture file's text: [`CaptureKeys`] holds them all, and dereferences to the changes, `key=value`, that
//! [`Capture::with`](super::Capture::with) and others take.

pub use super::tables::camera::{
    AutofocusValue, CameraKeys, DistortionKeys, DistortionModel, FocusDistanceValue, IntrinsicsKeys, KernelKeys,
    KernelOrigin, LateralColourKeys, LensKeys, LensType, PointSpreadKeys, ProjectionKind, StopKeys,
};
pub use super::tables::colour::{LinearRgbKeys, ReflectanceValue, TextureKeys};
pub use super::tables::lens_elements::{
    AutofocusKind, AutofocusSearchKeys, LensmakerKeys, RadiusValue, SupplementaryKeys,
};
pub use super::tables::lights::{
    DirectionalKeys, GaussianBeamKeys, LightKeys, PointKeys, ProfileKeys, ProjectorKeys, SpotKeys,
};
pub use super::tables::material::{
    CauchyKeys, ConductorKeys, DielectricKeys, DiffuseKeys, EmissionKeys, IndexPartsKeys, IndexValue, KeptKeys,
    MaterialKeys, MetalValue, MetallicRoughnessKeys, MixRestKeys, MixTableKeys, OrenNayarKeys, PhongKeys, PlasticKeys,
    RetroreflectiveKeys, SellmeierKeys, ThinDielectricKeys, TranslucentKeys,
};
pub use super::tables::motion::{CameraMotionKeys, ObjectMotionKeys, ObjectPoseKeys, PoseKeys, TurntableKeys};
pub use super::tables::object::{MaterialChoiceValue, ObjectKeys, ScaleValue, UpAxis};
pub use super::tables::scene::{
    CylinderKeys, DiskKeys, EnvironmentKeys, EnvironmentValue, SceneKeys, SkyKeys, SphereKeys,
};
pub use super::tables::settings::{
    BandsKeys, ExposureKeys, GainControlKeys, IrradianceValue, NextValue, NoiseValue, OutputKeys, PartnerKeys,
    PartnerValue, RawFormat, TruthValue,
};
pub use super::tables::surroundings::{BackdropKeys, GroundKeys, GroundValue};
pub use super::tables::target::PlacementTableKeys;
pub use super::tables::{CaptureKeys, SensorTableKeys};

pub use photosite_calibration::targets::keys::*;
pub use photosite_develop::{DevelopKeys, RawKeys};
pub use photosite_scene_io::MissingNormals;
pub use photosite_sensor::keys::*;
pub use photosite_transport::integrator::{RenderKeys, WavelengthChoice};
pub use photosite_transport::optics::{Falloff, Sharpness};
pub use photosite_transport::sampler::SamplerKind;
pub use photosite_transport::texture::{Filter, Wrap};
