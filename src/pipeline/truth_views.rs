//! The pictures that ground truth leads to: the next one for flow, that of the partner for disparity.

use crate::calibration::truth::{NotFound, TruthJob, TruthLayer, TruthObject, View, truth};
use crate::capture::{Capture, NextPicture};
use crate::image::Planes;
use crate::optics::{Camera, Focus, Recording};
use crate::scene::{self, Scene};
use crate::spectrum::Spectrum;
use crate::{Invalid, Result};
use glam::DAffine3;
use std::sync::Arc;

use super::camera::camera_of;
use super::focusing::{focus_camera, place_camera};
use super::lens_corrections::image_grid;
use super::monitor::{Event, Monitor};
use super::prepare::Prepared;
use photosite_core::image_grid::ImageGrid;

/// What ground truth needs besides the picture that it is of.
pub(super) struct TruthViews<'a> {
    /// Where flow is asked for.
    pub(super) common: Option<Common<'a>>,
    /// The next picture, if it is that of a changed capture and flow is asked for.
    changed: Option<ChangedPicture>,
    /// The camera of the partner where this one stands, and partner → camera, if disparity is asked for.
    pub(super) partner: Option<(Camera, DAffine3)>,
}

impl<'a> TruthViews<'a> {
    pub(super) fn new(prepared: &'a Prepared, layers: &[TruthLayer]) -> Result<Self> {
        let Prepared { capture, scene, camera, .. } = prepared;
        let common = layers.contains(&TruthLayer::Flow).then_some(Common {
            surfaces: prepared.surfaces,
            importance: &prepared.importance,
            scene,
        });
        let changed = common.as_ref().map(|common| ChangedPicture::read(capture, scene, common)).transpose()?.flatten();
        let place = capture.output.truth.partner.filter(|_| layers.contains(&TruthLayer::Disparity));
        let partner = place.map(|place| Ok((partner_camera(capture, camera, place, scene)?, place))).transpose()?;
        Ok(Self { common, changed, partner })
    }

    /// The picture that flow leads to from one of `scene`, after which `of_series` comes.
    pub(super) fn next<'b>(&'b self, capture: &Capture, scene: &'b Scene, of_series: View<'b>) -> Option<View<'b>> {
        match &capture.output.truth.next {
            NextPicture::OfSeries => Some(of_series),
            NextPicture::Changed(_) => self.changed.as_ref().map(|changed| changed.view(scene)),
            NextPicture::None => None,
        }
    }

    /// The camera of the partner beside one that takes a picture, and partner → camera.
    pub(super) fn partner_of(&self, camera: &Camera) -> Option<(Camera, DAffine3)> {
        self.partner.as_ref().map(|(partner, place)| (partner.clone().moving_as(camera), *place))
    }
}

impl Prepared {
    /// Layers of ground truth of its picture, in the order in which they are asked for. The monitor hears how many points
    /// were not found.
    ///
    /// # Errors
    ///
    /// `disparity` where the capture has no partner; flow to a picture that shows other surfaces.
    pub fn truth(&self, layers: &[TruthLayer], monitor: &dyn Monitor) -> Result<Planes> {
        let Self { capture, scene, .. } = self;
        if layers.contains(&TruthLayer::Disparity) && capture.output.truth.partner.is_none() {
            let invalid = Invalid::new("output.truth", "\"disparity\" is that between two cameras, and there is one");
            return Err(capture.source.error(invalid.help("say where the other one is with output.truth_partner")));
        }
        let views = TruthViews::new(self, layers)?;
        let first = FirstViews::new(self, &views)?;
        let grid = self.chain().image_grid();
        let partner = views.partner_of(&first.camera);
        let partner =
            partner.as_ref().map(|(camera, place)| View { scene, camera, place: *place, grid, not_found: None });
        let next = views.next(capture, scene, first.next(self));
        let view = View::of(scene, &first.camera, grid);
        let not_found = NotFound::default();
        let job = TruthJob { view, objects: &self.objects, next, partner }.counting(&not_found);
        let planes = truth(&job, layers);
        not_found.warning().iter().for_each(|warning| monitor.report(Event::Warning(warning)));
        Ok(planes)
    }
}

/// The first picture and the one after it, of a series that may move.
pub(super) struct FirstViews {
    pub(super) camera: Camera,
    next_camera: Camera,
    /// `None`: as in the first.
    next_scene: Option<Scene>,
}

impl FirstViews {
    pub(super) fn new(prepared: &Prepared, views: &TruthViews<'_>) -> Result<Self> {
        let Prepared { capture, camera: still, .. } = prepared;
        let Some(recording) = &capture.recording else {
            return Ok(Self { camera: still.clone(), next_camera: still.clone(), next_scene: None });
        };
        let mut next_recording = recording.later(1);
        let mut next_scene = None;
        // Only flow looks ahead.
        if let Some(common) = views.common.as_ref().filter(|_| capture.scene_moves) {
            let mut next = capture.at_frame(prepared.frame + 1)?;
            next_scene = Some(common.build(&mut next)?);
            next_recording = next.recording.unwrap_or(next_recording);
        }
        let [camera, next_camera] = [recording.clone(), next_recording].map(|taken| still.clone().recording(taken));
        Ok(Self { camera, next_camera, next_scene })
    }

    pub(super) fn next<'b>(&'b self, prepared: &'b Prepared) -> View<'b> {
        let scene = self.next_scene.as_ref().unwrap_or(&prepared.scene);
        View::of(scene, &self.next_camera, prepared.chain().image_grid())
    }
}

/// What the scene of a picture must have in common with that of the next, and what it is built with.
#[derive(Clone, Copy)]
pub(super) struct Common<'a> {
    /// Of the [surfaces](crate::scene::description::SceneDescription::surfaces).
    pub(super) surfaces: u64,
    pub(super) importance: &'a Spectrum,
    /// That of this picture.
    pub(super) scene: &'a Scene,
}

impl Common<'_> {
    /// Builds the scene of a next picture.
    pub(super) fn build(&self, next: &mut Capture) -> Result<Scene> {
        let description = next.take_scene();
        if description.surfaces() != self.surfaces {
            let message = "\"flow\" follows surfaces, and the next picture has others than this one";
            let help = "leave \"flow\" out, or let the geometry stay: what is placed may move and change its shape";
            return Err(next.source.error(Invalid::new("output.truth", message).help(help)));
        }
        Ok(scene::build_after(Arc::unwrap_or_clone(description), self.importance, Some(self.scene)))
    }
}

/// The next picture where it is that of a changed capture.
struct ChangedPicture {
    /// `None`: as in this one.
    scene: Option<Scene>,
    camera: Camera,
    grid: ImageGrid,
}

impl ChangedPicture {
    /// The next picture of a capture, changed by overrides; `scene` is built of this one.
    fn read(capture: &Capture, scene: &Scene, common: &Common<'_>) -> Result<Option<Self>> {
        let NextPicture::Changed(changes) = &capture.output.truth.next else { return Ok(None) };
        let mut next = capture.with(changes)?;
        let builds = capture.scene_moves || changes.iter().any(|change| is_of_scene(change));
        let built = if builds { Some(common.build(&mut next)?) } else { None };
        let placed = place_camera(&next, || built.as_ref().unwrap_or(scene))?;
        let camera = match &next.recording {
            Some(recording) => placed.recording(recording.clone()),
            None => placed,
        };
        let grid = image_grid(&next, &camera);
        Ok(Some(Self { scene: built, camera, grid }))
    }

    fn view<'a>(&'a self, scene: &'a Scene) -> View<'a> {
        View::of(self.scene.as_ref().unwrap_or(scene), &self.camera, self.grid)
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
    /// With its objects. `None`: as in the first.
    pub(super) scene: Option<(Scene, Vec<TruthObject>)>,
}

/// The camera of a stereo partner as if it stood where `camera` does, whose capture it has. Its lens is that of
/// `camera` but for what its own autofocus finds.
fn partner_camera(capture: &Capture, camera: &Camera, place: DAffine3, scene: &Scene) -> Result<Camera> {
    let Focus::Autofocus { .. } = capture.lens.focus else { return Ok(camera.clone()) };
    let focused = focus_camera(capture, camera.to_world() * place, || scene)?;
    let partner = camera_of(&capture.lens, &capture.sensor, camera.to_world(), focused.camera.focus_distance_m());
    partner.map_err(|invalid| capture.source.error(invalid.within("lens")))
}
