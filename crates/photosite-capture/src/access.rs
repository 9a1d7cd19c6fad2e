//! Read access to what a capture says. Its values are changed by [`Capture::with`] alone, so that its text, from which
//! `capture.json` and fingerprints are made, and its settings never differ.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DAffine3;

use super::{
    Capture, CaptureSource, DevelopSettings, ExposureSettings, LensDescription, OutputSettings, PlacedTarget,
    Recording, RenderSettings, SceneDescription, SensorModel,
};

impl Capture {
    /// The scene in front of the camera. Captures that differ in other tables alone share it.
    pub fn scene(&self) -> &Arc<SceneDescription> {
        &self.scene
    }

    /// Calibration targets in the scene.
    pub fn targets(&self) -> &[PlacedTarget] {
        &self.targets
    }

    /// Camera → world; the camera looks along −Z.
    pub fn camera_to_world(&self) -> DAffine3 {
        self.camera_to_world
    }

    /// Files that its camera was read from, besides those that it names.
    pub fn calibration_files(&self) -> &[PathBuf] {
        self.calibrated.as_ref().map_or(&[], |calibrated| &calibrated.files)
    }

    /// Whether the calibration of the lens has placed the camera, whose world is the frame of the calibration then.
    pub fn is_placed_by_calibration(&self) -> bool {
        self.calibrated.as_ref().is_some_and(|calibrated| calibrated.pose.is_some())
    }

    /// Recording of an image in whose time camera or scene move; `None` where all stands still.
    pub fn recording(&self) -> Option<&Recording> {
        self.recording.as_ref()
    }

    /// Whether the scene is that of one image only, so that others need [`Capture::at_frame`].
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

    /// Settings of the exposure.
    pub fn exposure(&self) -> &ExposureSettings {
        &self.exposure
    }

    /// Settings of light transport.
    pub fn render(&self) -> &RenderSettings {
        &self.render
    }

    /// Settings of the development of the raw image.
    pub fn develop(&self) -> &DevelopSettings {
        &self.develop
    }

    /// Settings of the files to write.
    pub fn output(&self) -> &OutputSettings {
        &self.output
    }

    /// Source of all values, for errors that show up later.
    pub fn source(&self) -> &CaptureSource {
        &self.source
    }

    /// Warnings of keys that the sensor was made of, and which its values no longer show.
    pub fn sensor_warnings(&self) -> &[String] {
        &self.sensor_warnings
    }

    /// Warnings of the values of sensor and exposure.
    pub fn exposure_warnings(&self) -> &[String] {
        &self.exposure_warnings
    }
}
