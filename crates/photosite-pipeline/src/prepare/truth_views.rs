//! Views that ground truth leads to: the next image for flow, the partner's for disparity.

use glam::DAffine3;
use photosite_calibration::truth::{Needs, NotFound, TruthJob, TruthLayer, TruthObject, View, truth};
use photosite_capture::{Capture, FlowTarget};
use photosite_core::image::Planes;
use photosite_core::spectrum::Spectrum;
use photosite_core::{Invalid, Result};
use photosite_transport::optics::{Camera, Focus, Recording};
use photosite_transport::scene::{self, Scene};
use std::sync::Arc;

use super::prepared::Prepared;
use crate::camera::capture_camera::camera_of;
use crate::camera::focusing::{focus_camera, place_camera};
use crate::camera::lens_corrections::image_grid;
use crate::monitor::{Event, Monitor};
use photosite_core::image_grid::ImageGrid;

/// Views that ground truth needs besides that of its own image.
pub(crate) struct TruthViews<'a> {
    /// Facts common to both images, where flow is asked for.
    pub(crate) common: Option<Common<'a>>,
    /// Next image, if it is that of a changed capture and flow is asked for.
    changed: Option<ChangedImage>,
    /// The camera of the partner where this one stands, and partner → camera, if disparity is asked for.
    pub(crate) partner: Option<(Camera, DAffine3)>,
}

impl<'a> TruthViews<'a> {
    pub(crate) fn new(prepared: &'a Prepared, layers: &[TruthLayer]) -> Result<Self> {
        let Prepared { capture, scene, camera, .. } = prepared;
        let common = TruthLayer::any_needs(layers, Needs::NextImage).then_some(Common {
            surfaces: prepared.surfaces,
            importance: &prepared.importance,
            scene,
        });
        let changed = common.as_ref().map(|common| ChangedImage::read(capture, scene, common)).transpose()?.flatten();
        let place = capture.output().truth.partner.filter(|_| TruthLayer::any_needs(layers, Needs::Partner));
        let partner = place.map(|place| Ok((partner_camera(capture, camera, place, scene)?, place))).transpose()?;
        Ok(Self { common, changed, partner })
    }

    /// View that flow leads to from an image of `scene`, after which `of_series` comes.
    pub(crate) fn next<'b>(&'b self, capture: &Capture, scene: &'b Scene, of_series: View<'b>) -> Option<View<'b>> {
        match &capture.output().truth.next {
            FlowTarget::OfSeries => Some(of_series),
            FlowTarget::Changed(_) => self.changed.as_ref().map(|changed| changed.view(scene)),
            FlowTarget::None => None,
        }
    }

    /// Camera of the partner beside one that takes an image, and partner → camera.
    pub(crate) fn partner_of(&self, camera: &Camera) -> Option<(Camera, DAffine3)> {
        self.partner.as_ref().map(|(partner, place)| (partner.clone().moving_as(camera), *place))
    }
}

impl Prepared {
    /// Layers of ground truth of the image, in the order in which they are asked for. The monitor hears how many points
    /// were not found.
    ///
    /// # Errors
    ///
    /// `disparity` where the capture has no partner; flow to an image that shows other surfaces.
    pub fn truth(&self, layers: &[TruthLayer], monitor: &dyn Monitor) -> Result<Planes> {
        let Self { capture, scene, .. } = self;
        let of_pair = layers.iter().find(|layer| layer.needs() == Needs::Partner);
        if let (Some(layer), None) = (of_pair, capture.output().truth.partner) {
            let message = format!("{:?} is that between two cameras, and there is one", layer.name());
            let invalid = Invalid::new("output.truth", message);
            return Err(capture.source().error(invalid.help("say where the other one is with output.truth_partner")));
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

/// Views of the first image and the one after it, of a series that may move.
pub(crate) struct FirstViews {
    pub(crate) camera: Camera,
    next_camera: Camera,
    /// Scene of the next image; `None`: the first one's.
    next_scene: Option<Scene>,
}

impl FirstViews {
    pub(crate) fn new(prepared: &Prepared, views: &TruthViews<'_>) -> Result<Self> {
        let Prepared { capture, camera: still, .. } = prepared;
        let Some(recording) = capture.recording() else {
            return Ok(Self { camera: still.clone(), next_camera: still.clone(), next_scene: None });
        };
        let mut next_recording = recording.later(1);
        let mut next_scene = None;
        // Only flow looks ahead.
        if let Some(common) = views.common.as_ref().filter(|_| capture.scene_moves()) {
            let mut next = capture.at_frame(prepared.frame + 1)?;
            next_scene = Some(common.build(&mut next)?);
            next_recording = next.recording().cloned().unwrap_or(next_recording);
        }
        let [camera, next_camera] = [recording.clone(), next_recording].map(|taken| still.clone().recording(taken));
        Ok(Self { camera, next_camera, next_scene })
    }

    pub(crate) fn next<'b>(&'b self, prepared: &'b Prepared) -> View<'b> {
        let scene = self.next_scene.as_ref().unwrap_or(&prepared.scene);
        View::of(scene, &self.next_camera, prepared.chain().image_grid())
    }
}

/// Facts that the scene of an image must have in common with that of the next, and what it is built with.
#[derive(Clone, Copy)]
pub(crate) struct Common<'a> {
    /// Fingerprint of the [surfaces](photosite_transport::scene::description::SceneDescription::surfaces).
    pub(crate) surfaces: u64,
    pub(crate) importance: &'a Spectrum,
    /// Scene of the image that flow begins in.
    pub(crate) scene: &'a Scene,
}

impl Common<'_> {
    /// Builds the scene of a next image.
    pub(crate) fn build(&self, next: &mut Capture) -> Result<Scene> {
        let description = next.take_scene();
        if description.surfaces() != self.surfaces {
            let message = "\"flow\" follows surfaces, and the next image has others than this one";
            let help = "leave \"flow\" out, or let the geometry stay: what is placed may move and change its shape";
            return Err(next.source().error(Invalid::new("output.truth", message).help(help)));
        }
        Ok(scene::build_after(Arc::unwrap_or_clone(description), self.importance, Some(self.scene)))
    }
}

/// Next image where it is that of a changed capture.
struct ChangedImage {
    /// Scene of the next image; `None`: that of this one.
    scene: Option<Scene>,
    camera: Camera,
    grid: ImageGrid,
}

impl ChangedImage {
    /// Reads the next image of a capture, changed by overrides; `scene` is built of the capture as it is.
    fn read(capture: &Capture, scene: &Scene, common: &Common<'_>) -> Result<Option<Self>> {
        let FlowTarget::Changed(changes) = &capture.output().truth.next else { return Ok(None) };
        let mut next = capture.with(changes)?;
        let builds = capture.scene_moves() || changes.iter().any(|change| is_of_scene(change));
        let built = if builds { Some(common.build(&mut next)?) } else { None };
        let placed = place_camera(&next, || built.as_ref().unwrap_or(scene))?;
        let camera = match next.recording() {
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

/// Moment of an image of a series in whose time something moves.
pub(crate) struct Moment {
    pub(crate) recording: Recording,
    /// Scene with its objects. `None`: as in the first image.
    pub(crate) scene: Option<(Scene, Vec<TruthObject>)>,
}

/// The camera of a stereo partner as if it stood where `camera` does, whose capture it has. Its lens is that of
/// `camera` but for what its own autofocus finds.
fn partner_camera(capture: &Capture, camera: &Camera, place: DAffine3, scene: &Scene) -> Result<Camera> {
    let Focus::Autofocus { .. } = capture.lens().focus else { return Ok(camera.clone()) };
    let focused = focus_camera(capture, camera.to_world() * place, || scene)?;
    let partner = camera_of(capture.lens(), capture.sensor(), camera.to_world(), focused.camera.focus_distance_m());
    partner.map_err(|invalid| capture.source().error(invalid.within("lens")))
}
