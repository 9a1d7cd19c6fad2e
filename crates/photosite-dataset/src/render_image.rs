//! One image of a data set: its capture, rendered into a folder of its own, sharing what it can with the last image.

use std::sync::Mutex;
use std::time::Instant;

use super::DataSet;
use super::folder::NewImage;
use super::warnings_by_kind::WarningsByKind;
use photosite_capture::Capture;
use photosite_capture::report::Timings;
use photosite_core::locked::locked;
use photosite_core::{Error, Result};
use photosite_pipeline::{Event, LightSource, Monitor, OutputFolder, ReadyRender, Rendered, Request};

/// Image of a frame, as the frame's number, the camera's name, and the changes to the capture that make it.
pub(super) type FrameImage<'a> = (u32, &'a str, &'a [String]);

impl DataSet {
    /// Renders one image into the given folder.
    pub(super) fn image(
        &self,
        (number, camera, overrides): FrameImage<'_>,
        light: LightSource<'static>,
        image: &NewImage,
        monitor: &dyn Monitor,
    ) -> Result<Timings> {
        let start = Instant::now();
        // It was read before, with all that it names.
        let capture = self.capture(camera, number, overrides).map_err(Error::since_begun)?;
        let request = Request {
            input: &self.capture_path,
            named: self.file.description.capture.clone(),
            light,
            film_memory: self.film_memory,
            monitor,
            is_timed: false,
        };
        let mut results = OutputFolder::own(image.path());
        let timings = Timings { load_s: start.elapsed().as_secs_f64(), ..Timings::default() };
        let ready = self.make_ready(camera, capture, &request, timings);
        let rendered = ready.and_then(|ready| ready.render_into(&mut results));
        match rendered.map_err(|error| self.error_of_change(error, camera, number, overrides))? {
            Rendered::Image { timings, .. } => Ok(timings),
            Rendered::Part(_) => Ok(timings),
        }
    }

    /// Prepares a capture for rendering. A scene that nothing varies is built for the first image and kept, as is the
    /// geometry of one in which only poses, materials or lights vary.
    pub(super) fn make_ready<'a>(
        &self,
        camera: &str,
        capture: Capture,
        request: &'a Request<'a>,
        timings: Timings,
    ) -> Result<ReadyRender<'a>> {
        if !self.captures.iter().any(|before| before.scene().has_meshes_of(capture.scene())) {
            return ReadyRender::new(capture, None, request, timings);
        }
        let mut kept = locked(&self.kept);
        // Other cameras of a rig see the same scene.
        let Some(earlier) = kept.get(camera).or_else(|| kept.values().next()).cloned() else {
            // Of jobs that begin together one builds the scene, and the others wait for it.
            let ready = ReadyRender::new(capture, None, request, timings)?;
            kept.insert(camera.to_owned(), ready.prepared().clone());
            return Ok(ready);
        };
        drop(kept);
        let ready = ReadyRender::new(capture, Some(earlier), request, timings)?;
        locked(&self.kept).insert(camera.to_owned(), ready.prepared().clone());
        Ok(ready)
    }
}

/// Monitor of one image of a set, which passes on cancellation. Warnings are kept, to be reported for all images at
/// once.
pub(super) struct ImageMonitor<'a> {
    pub(super) monitor: &'a dyn Monitor,
    /// Name of the camera, and number of the frame.
    pub(super) of: (&'a str, u32),
    pub(super) said: &'a Mutex<WarningsByKind>,
    /// Whether the set is given up because of an error of another image.
    pub(super) is_over: &'a (dyn Fn() -> bool + Sync),
}

impl Monitor for ImageMonitor<'_> {
    fn report(&self, event: Event<'_>) {
        match event {
            Event::Warning(words) => locked(self.said).warning(self.of.0, self.of.1, words),
            // While an image is traced it stops by itself and keeps a checkpoint.
            Event::TraceBegins { .. } | Event::TraceEnds => self.monitor.report(event),
            Event::Traced(_)
            | Event::PassEnds { .. }
            | Event::SetBegins { .. }
            | Event::ImageEnds(_)
            | Event::ImageFails { .. }
            | Event::Waiting { .. }
            | Event::SetEnds => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        (self.is_over)() || self.monitor.is_cancelled()
    }
}
