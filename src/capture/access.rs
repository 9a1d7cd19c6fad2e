//! Read access to what a capture says. Its values are changed by [`Capture::with`] alone, so that its text, from which
//! `capture.json` and fingerprints are made, and its settings never differ.

use std::sync::Arc;

use glam::DAffine3;

use super::{
    Capture, CaptureSource, DevelopSettings, ExposureSettings, LensDescription, OutputSettings, PlacedTarget,
    Recording, RenderSettings, SceneDescription, SensorModel,
};

impl Capture {
    /// What is in front of the camera. Captures that differ in other tables alone share it.
    pub fn scene(&self) -> &Arc<SceneDescription> {
        &self.scene
    }

    /// Calibration targets in it.
    pub fn targets(&self) -> &[PlacedTarget] {
        &self.targets
    }

    /// Camera → world; the camera looks along −Z.
    pub fn camera_to_world(&self) -> DAffine3 {
        self.camera_to_world
    }

    /// The picture of a camera or a scene that moves; `None` where all stands still.
    pub fn recording(&self) -> Option<&Recording> {
        self.recording.as_ref()
    }

    /// Whether the scene is that of one picture only, so that others need [`Capture::at_frame`].
    pub fn scene_moves(&self) -> bool {
        self.scene_moves
    }

    /// The lens.
    pub fn lens(&self) -> &LensDescription {
        &self.lens
    }

    /// The sensor.
    pub fn sensor(&self) -> &SensorModel {
        &self.sensor
    }

    /// How it is exposed.
    pub fn exposure(&self) -> &ExposureSettings {
        &self.exposure
    }

    /// How light is traced.
    pub fn render(&self) -> &RenderSettings {
        &self.render
    }

    /// How the raw picture is developed.
    pub fn develop(&self) -> &DevelopSettings {
        &self.develop
    }

    /// What is written.
    pub fn output(&self) -> &OutputSettings {
        &self.output
    }

    /// Where all this stands: for errors that show up later.
    pub fn source(&self) -> &CaptureSource {
        &self.source
    }
}
