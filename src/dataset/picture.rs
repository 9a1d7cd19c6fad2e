//! One picture of a data set: its capture, rendered into a folder of its own, with what it has in common with the last.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::DataSet;
use super::folder::NewPicture;
use crate::capture::Capture;
use crate::pipeline::{Event, LightSource, Monitor, OutputFolder, ReadyRender, Request};
use crate::report::Timings;
use crate::{Error, Result};

/// A picture of a frame, with the changes to the capture that make it.
pub(super) type Picture<'a> = (u32, &'a str, &'a [String]);

impl DataSet {
    /// Renders one picture into the folder that it is given.
    pub(super) fn picture(
        &self,
        (number, camera, overrides): Picture<'_>,
        light: LightSource<'static>,
        picture: &NewPicture,
        monitor: &dyn Monitor,
    ) -> Result<()> {
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
        let mut results = OutputFolder::own(picture.path());
        let rendered = self.make_ready(camera, capture, &request).and_then(|ready| ready.render_into(&mut results));
        rendered.map_err(|error| self.error_of_change(error, camera, number, overrides)).map(drop)
    }

    /// Makes a capture ready to be rendered. A scene that nothing varies is built for the first picture and kept.
    fn make_ready<'a>(&self, camera: &str, capture: Capture, request: &'a Request<'a>) -> Result<ReadyRender<'a>> {
        if !self.captures.iter().any(|before| Arc::ptr_eq(&before.scene, &capture.scene)) {
            return ReadyRender::new(capture, None, request, Timings::default());
        }
        let mut kept = locked(&self.kept);
        // Other cameras of a rig see the same scene.
        let Some(earlier) = kept.get(camera).or_else(|| kept.values().next()).cloned() else {
            // Of jobs that begin together one builds the scene, and the others wait for it.
            let ready = ReadyRender::new(capture, None, request, Timings::default())?;
            kept.insert(camera.to_owned(), ready.prepared().clone());
            return Ok(ready);
        };
        drop(kept);
        let ready = ReadyRender::new(capture, Some(earlier), request, Timings::default())?;
        locked(&self.kept).insert(camera.to_owned(), ready.prepared().clone());
        Ok(ready)
    }
}

pub(super) fn locked<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What is heard of one picture of a set: that it was cancelled, and warnings of the first alone.
pub(super) struct OfOnePicture<'a> {
    pub(super) monitor: &'a dyn Monitor,
    pub(super) warns: bool,
    /// Whether the set is given up, for an error of another picture.
    pub(super) is_over: &'a (dyn Fn() -> bool + Sync),
}

impl Monitor for OfOnePicture<'_> {
    fn report(&self, event: Event<'_>) {
        match event {
            Event::Warning(_) if self.warns => self.monitor.report(event),
            // While a picture is traced it stops by itself and keeps a checkpoint.
            Event::TraceBegins { .. } | Event::TraceEnds => self.monitor.report(event),
            Event::Warning(_)
            | Event::Traced(_)
            | Event::PassEnds { .. }
            | Event::SetBegins { .. }
            | Event::PictureEnds(_)
            | Event::PictureFails { .. }
            | Event::Waiting { .. }
            | Event::SetEnds => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        (self.is_over)() || self.monitor.is_cancelled()
    }
}
