//! The pictures that ground truth leads to: the next one for flow, that of the partner for disparity.

use std::path::Path;

use crate::calibration::truth::View;
use crate::capture::{Capture, NextPicture};
use crate::optics::{Camera, Focus, Recording};
use crate::scene::{self, Scene};
use crate::spectrum::Spectrum;
use crate::{Invalid, Result};
use glam::DAffine3;

use super::camera::{camera_of, pixels};
use super::focusing::{focus_camera, place_camera};

/// What the scene of a picture must have in common with that of the next, and what it is built with.
#[derive(Clone, Copy)]
pub(super) struct Common<'a> {
    /// Of the [surfaces](crate::scene::description::SceneDescription::surfaces).
    pub(super) surfaces: u64,
    pub(super) importance: &'a Spectrum,
}

impl Common<'_> {
    /// Builds the scene of a next picture.
    pub(super) fn build(&self, next: &mut Capture) -> Result<Scene> {
        let description = std::mem::take(&mut next.scene);
        if description.surfaces() != self.surfaces {
            let message = "\"flow\" follows surfaces, and the next picture has others than this one";
            let help = "leave \"flow\" out, or let the geometry stay: what is placed may move and change its shape";
            return Err(next.source.error(Invalid::new("output.truth", message).help(help)));
        }
        Ok(scene::build(description, self.importance))
    }
}

/// The next picture where it is that of a changed capture.
pub(super) struct ChangedPicture {
    /// `None`: as in this one.
    scene: Option<Scene>,
    camera: Camera,
    resolution: [u32; 2],
}

impl ChangedPicture {
    /// The next picture of a capture, changed by overrides. It was read from `input` with `overrides`, and `scene` is
    /// built of it.
    pub(super) fn read(
        input: &Path,
        overrides: &[String],
        capture: &Capture,
        scene: &Scene,
        common: &Common<'_>,
    ) -> Result<Option<Self>> {
        let NextPicture::Changed(changes) = &capture.output.truth.next else { return Ok(None) };
        let all: Vec<String> = overrides.iter().chain(changes).cloned().collect();
        let mut next = Capture::load_within(capture.source.sandbox(), input, &all)?;
        let builds = capture.scene_moves || changes.iter().any(|change| is_of_scene(change));
        let built = if builds { Some(common.build(&mut next)?) } else { None };
        let placed = place_camera(&next, || built.as_ref().unwrap_or(scene))?;
        let camera = match &next.recording {
            Some(recording) => placed.recording(recording.clone()),
            None => placed,
        };
        Ok(Some(Self { scene: built, camera, resolution: pixels(&next) }))
    }

    pub(super) fn view<'a>(&'a self, scene: &'a Scene) -> View<'a> {
        View::of(self.scene.as_ref().unwrap_or(scene), &self.camera, self.resolution)
    }
}

/// Whether a change may touch what is in front of the camera.
fn is_of_scene(change: &str) -> bool {
    let other_tables = ["camera", "lens", "sensor", "exposure", "render", "develop", "output"];
    let table = change.split(['.', '=']).next().unwrap_or_default().trim();
    !other_tables.contains(&table)
}

/// A picture in whose time something moves, of a series.
pub(super) struct Moment {
    pub(super) recording: Recording,
    /// `None`: as in the first.
    pub(super) scene: Option<Scene>,
}

/// The camera of a stereo partner as if it stood where `camera` does, whose capture it has. Its lens is that of
/// `camera` but for what its own autofocus finds.
pub(super) fn partner_camera(capture: &Capture, camera: &Camera, place: DAffine3, scene: &Scene) -> Result<Camera> {
    let Focus::Autofocus { .. } = capture.lens.focus else { return Ok(camera.clone()) };
    let focused = focus_camera(capture, camera.to_world() * place, || scene)?;
    let partner = camera_of(&capture.lens, &capture.sensor, camera.to_world(), focused.camera.focus_distance_m());
    partner.map_err(|invalid| capture.source.error(invalid.within("lens")))
}
