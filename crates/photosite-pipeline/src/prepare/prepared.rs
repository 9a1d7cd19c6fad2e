//! Prepared capture: everything that is made once, before light is traced: scene, camera, the sensor's colours,
//! warnings.

use std::sync::{Arc, OnceLock, Weak};

use super::memory_needs;
use crate::camera::film_responses::{filters, importance, responses, seen_through_lens};
use crate::camera::focusing::{FocusedCamera, focus_camera};
use crate::camera::lens_corrections::KnownCorrections;
use crate::expose::chain::{Chain, Optics, SensorColours, SensorSettings, scene_light};
use photosite_calibration::truth::TruthObject;
use photosite_capture::report::{FocusStepReport, TruthReport};
use photosite_capture::{Capture, FlowTarget, OutputSettings};
use photosite_core::spectrum::Spectrum;
use photosite_core::warnings::Warnings;
use photosite_core::{Error, Result};
use photosite_transport::film::Response;
use photosite_transport::integrator::{FilterTile, WavelengthChoice};
use photosite_transport::optics::{AutofocusMethod, BeyondImageCircle, Camera, Focus, LensKind};
use photosite_transport::scene::description::SceneDescription;
use photosite_transport::scene::{self, Scene, spectral_coverage};

/// A capture that is ready to be traced.
#[derive(Clone)]
pub struct Prepared {
    /// The capture. Its scene has become [`scene`](Self::scene).
    pub(crate) capture: Capture,
    pub(crate) scene: Arc<Scene>,
    /// Description that the scene was built of, which may be gone.
    pub(crate) described: Weak<SceneDescription>,
    /// Camera as it stands still; where it moves, [`Capture::recording`] says how.
    pub(crate) camera: Camera,
    /// Places that autofocus by contrast has tried.
    pub(crate) focus_steps: Vec<FocusStepReport>,
    /// Responses that the film is summed for: the sensor's channels first.
    pub(crate) responses: Vec<Response>,
    /// Importance of each wavelength to the scene.
    pub(crate) importance: Spectrum,
    /// Importance of each wavelength to the images, found by the first that is traced.
    pub(crate) importance_for_all: Arc<OnceLock<Spectrum>>,
    pub(crate) filters: Option<FilterTile>,
    /// Spectrum of all light of the scene, the largest value 1.
    pub(crate) light: Spectrum,
    pub(crate) optics: Optics,
    pub(crate) colours: Arc<SensorColours>,
    pub(crate) corrections: Arc<KnownCorrections>,
    /// Fingerprint of the [surfaces](photosite_transport::scene::description::SceneDescription::surfaces) that flow
    /// follows.
    pub(crate) surfaces: u64,
    /// Objects of the first image's scene.
    pub(crate) objects: Arc<Vec<TruthObject>>,
    pub(crate) truth: Option<TruthReport>,
    /// Warnings that hold for its light, whatever that falls on.
    pub(crate) light_warnings: Vec<String>,
    /// All warnings, about light and others, each once.
    pub(crate) warnings: Vec<String>,
    /// Number of the image in its series.
    pub(crate) frame: u32,
}

impl Prepared {
    /// Builds the scene of a capture, puts its camera in place and finds what its sensor takes for white.
    ///
    /// # Errors
    ///
    /// Faults that only the whole scene shows: a lens that cannot focus where autofocus looks, lights too large to
    /// compute with.
    pub fn new(capture: Capture) -> Result<Self> {
        Self::after(None, capture)
    }

    /// Capture made ready, where what it has in common with an earlier one is shared with that. The scene is, where one
    /// capture was made of the other by [`Capture::with`] and their sensors see the same wavelengths.
    ///
    /// # Errors
    ///
    /// Errors of [`new`](Self::new).
    pub fn after(earlier: Option<Self>, mut capture: Capture) -> Result<Self> {
        let mut light_warnings = capture.light_warnings();
        let description = capture.take_scene();
        let responses = responses(&capture);
        let importance = importance(&responses);
        let filters = filters(&capture);
        light_warnings.extend(spectral_coverage::warning(&description, &seen_through_lens(&capture)));
        if capture.lens().kind == LensKind::Bare && !description.lights.is_empty() {
            light_warnings.push(
                "lights of [[lights]] and of glTF files have no surface, and a bare sensor sees what they shine on but not \
                 the lights themselves; give lights that shall shine on the sensor a surface with emission"
                    .to_owned(),
            );
        }
        let wanted = &capture.output().truth;
        let truth = TruthReport::new(
            &wanted.layers,
            wanted.depth_unit_m,
            wanted.next != FlowTarget::None,
            &description,
            capture.recording(),
        );
        let surfaces = description.surfaces();
        let objects = Arc::new(TruthObject::of_scene(&description));
        let described = Arc::downgrade(&description);
        // Another scene's memory is free again before this one is built.
        let earlier = earlier.filter(|earlier| {
            (earlier.is_of(&description) || earlier.scene.has_meshes_of(&description))
                && earlier.importance == importance
        });
        let same_scene = earlier.as_ref().filter(|earlier| earlier.is_of(&description)).cloned();
        let (scene, light) = match &same_scene {
            Some(earlier) => (Arc::clone(&earlier.scene), earlier.light.clone()),
            None => {
                memory_needs::check_scene(&description, capture.source())?;
                let earlier = earlier.as_ref().map(|earlier| &*earlier.scene);
                let scene = scene::build_after(Arc::unwrap_or_clone(description), &importance, earlier);
                let light = scene_light(&capture, &scene)?;
                (Arc::new(scene), light)
            }
        };
        let FocusedCamera { camera, steps: focus_steps, is_nearest } =
            focus_camera(&capture, capture.camera_to_world(), || &scene)?;
        light_warnings.extend(autofocus_warning(&capture, &camera, is_nearest));
        light_warnings.extend(image_circle_warning(&capture, &camera));
        light_warnings.extend(folded_blur_warning(&camera));
        light_warnings.extend(ineffective_settings(&capture, &scene));
        let optics = Optics {
            f_number: camera.makes_image().then_some(capture.lens().f_number),
            focal_length_m: Some(capture.lens().focal_length_m).filter(|f| camera.makes_image() && *f > 0.0),
            transmittance: capture.lens().transmittance.clone(),
        };
        let same_sensor = same_scene.filter(|earlier| {
            earlier.capture.sensor() == capture.sensor() && earlier.capture.lens().transmittance == optics.transmittance
        });
        let colours = match &same_sensor {
            Some(earlier) => Arc::clone(&earlier.colours),
            None => Arc::new(SensorColours::find(SensorSettings::from(&capture), &optics, &light, None)?),
        };
        let kept = |output: &OutputSettings| (output.irradiance, output.ideal);
        let same_responses =
            same_sensor.as_ref().filter(|earlier| kept(earlier.capture.output()) == kept(capture.output()));
        let importance_for_all =
            same_responses.map_or_else(Arc::default, |earlier| Arc::clone(&earlier.importance_for_all));
        let same_lens = same_sensor.filter(|earlier| {
            let focus = |camera: &Camera| [camera.focus_distance_m(), camera.image_distance_m()].map(f64::to_bits);
            earlier.capture.lens() == capture.lens() && focus(&earlier.camera) == focus(&camera)
        });
        let mut prepared = Self {
            capture,
            scene,
            described,
            camera,
            focus_steps,
            responses,
            importance,
            importance_for_all,
            filters,
            light,
            optics,
            colours,
            corrections: same_lens.map_or_else(Arc::default, |earlier| earlier.corrections),
            surfaces,
            objects,
            truth,
            light_warnings,
            warnings: Vec::new(),
            frame: 0,
        };
        prepared.warnings = prepared.all_warnings();
        Ok(prepared)
    }

    /// Warnings about light, sensor, exposure and images, each once.
    pub(crate) fn all_warnings(&self) -> Vec<String> {
        let Self { capture, light_warnings, colours, .. } = self;
        let of_light = light_warnings.iter().chain(capture.sensor_warnings()).chain(capture.exposure_warnings());
        let mut all = Warnings::default();
        of_light.chain(&colours.warning).for_each(|warning| all.once(warning));
        self.image_warnings().into_iter().for_each(|warning| all.once(warning));
        all.into_messages()
    }

    /// The capture prepared for the image of that number of its series, in which camera or scene have moved on; this is
    /// the first. Its light has noise of its own.
    ///
    /// # Errors
    ///
    /// Files of the scene that cannot be read again.
    pub fn at_frame(&self, frame: u32) -> Result<Self> {
        let mut capture = self.capture.at_frame(frame).map_err(Error::since_begun)?;
        let description = capture.take_scene();
        if !capture.scene_moves() {
            return Ok(Self { capture, frame, ..self.clone() });
        }
        let objects = Arc::new(TruthObject::of_scene(&description));
        let scene = scene::build_after(Arc::unwrap_or_clone(description), &self.importance, Some(&self.scene));
        // What matters to its images is found of its own light, as where it is rendered.
        let importance_for_all = Arc::default();
        let (scene, described) = (Arc::new(scene), Weak::new());
        Ok(Self { capture, scene, described, objects, importance_for_all, frame, ..self.clone() })
    }

    /// Number of the image in its series.
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Whether the scene of this capture was built of that one.
    pub(crate) fn is_of(&self, scene: &Arc<SceneDescription>) -> bool {
        self.described.ptr_eq(&Arc::downgrade(scene))
    }

    /// Warnings about the capture, each once.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The capture, whose scene has become [`scene`](Self::scene).
    pub fn capture(&self) -> &Capture {
        &self.capture
    }

    /// The scene, ready for rays.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The camera, taking the first image.
    pub fn camera(&self) -> Camera {
        match self.capture.recording() {
            Some(recording) => self.camera.clone().recording(recording.clone()),
            None => self.camera.clone(),
        }
    }

    /// The steps after light transport.
    pub(crate) fn chain(&self) -> Chain<'_> {
        // Of a bare sensor there is nothing to correct.
        let lens = self.camera.makes_image().then_some((self.capture.lens(), &self.camera, &*self.corrections));
        Chain::new((&self.capture).into(), &self.optics, &self.colours, lens)
    }

    /// Warnings about what images and raw files do not show.
    pub(crate) fn image_warnings(&self) -> Vec<String> {
        self.chain().image_warnings(!self.capture.targets().is_empty())
    }
}

/// A warning where the lens is not focused on what autofocus was told to.
fn autofocus_warning(capture: &Capture, camera: &Camera, is_nearest: bool) -> Option<String> {
    let Focus::Autofocus { pixel: [x, y], method } = capture.lens().focus else { return None };
    let u = camera.focus_distance_m();
    match (method, capture.lens().min_focus_distance_m) {
        (AutofocusMethod::Exact, _) if u.is_infinite() => {
            Some(format!("autofocus: pixel {x}, {y} sees nothing to focus on, so the lens is focused at infinity"))
        }
        (AutofocusMethod::Exact, Some(nearest)) if u == nearest => Some(format!(
            "autofocus: what pixel {x}, {y} sees is nearer than the lens can be focused on, {nearest} m, and is not sharp"
        )),
        (AutofocusMethod::Contrast(_), _) if is_nearest => Some(format!(
            "autofocus: at pixel {x}, {y} the contrast is highest at the nearest focus of the lens, {} m, and what is seen \
             there may be even nearer; lens.min_focus_distance_m says how near the lens goes",
            u as f32
        )),
        (AutofocusMethod::Exact | AutofocusMethod::Contrast(_), _) => None,
    }
}

/// A warning where the lens of a prescription leaves pixels black because they lie beyond its image circle.
fn image_circle_warning(capture: &Capture, camera: &Camera) -> Option<String> {
    let BeyondImageCircle { dark_part, lit_m, corner_m } = camera.beyond_image_circle()?;
    let name = &capture.lens().prescription.as_ref()?.name;
    let percent = 100.0 * dark_part;
    let part = if percent < 1.0 { "less than 1".to_owned() } else { format!("{percent:.0}") };
    Some(format!(
        "lens.prescription: {part} % of the image is black, because it lies beyond the image circle of {name:?}: light \
         comes as far as {:.3} mm from the axis, and the corners of the image are {:.3} mm away; take a sensor of at most \
         {:.3} mm from corner to corner, or another lens",
        lit_m * 1e3,
        corner_m * 1e3,
        2e3 * lit_m
    ))
}

/// Warning where points spread farther than their tabulated images reach.
fn folded_blur_warning(camera: &Camera) -> Option<String> {
    let [far, reach] = camera.folded_blur_m()?.map(|m| m * 1e6);
    Some(format!(
        "lens.psf: light of a point lands as far as {far:.0} µm from the middle of its image, and images by waves reach \
         {reach:.0} µm: what lands farther away is folded back; diffraction makes no difference to such blurs: remove psf, or \
         write a larger f_number"
    ))
}

/// Warnings about settings that change nothing in this scene and with this sensor.
fn ineffective_settings(capture: &Capture, scene: &Scene) -> Vec<String> {
    let render = capture.render();
    let no_paths = render.light_paths() > 0.0 && !scene.lights().has_emitters();
    let own_filter = render.wavelengths == WavelengthChoice::OwnFilter;
    [
        ("light_paths", no_paths, "no surface shines, so that no paths start"),
        (
            "wavelengths",
            own_filter && !capture.sensor().cfa.is_mosaic(),
            "all pixels see the same, so that \"own-filter\" changes nothing",
        ),
    ]
    .into_iter()
    .filter(|(_, is_ineffective, _)| *is_ineffective)
    .map(|(key, _, why)| format!("render.{key}: {why}"))
    .collect()
}
