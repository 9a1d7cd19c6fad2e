//! Monitor of work that takes long: events that a caller hears of, and a way to stop it.

use std::path::Path;

use photosite_capture::report::Timings;
use photosite_core::Error;
use photosite_transport::film::Film;

/// Monitor that watches work under way. One method takes everything that is reported, the other is asked whether to
/// stop.
///
/// Both are called from several threads. Tracing asks [`is_cancelled`](Self::is_cancelled) some hundred times a second
/// on each thread; when it says yes, the work keeps what is done in its checkpoint, if it has one, and fails with
/// [`Error::Cancelled`]. It is asked before and after a scene is built and before each frame is exposed, too; these
/// steps themselves are not broken off.
pub trait Monitor: Sync {
    /// Takes a report.
    fn report(&self, event: Event<'_>);

    /// Whether the work shall stop.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Event of work under way.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// Warning about the result for the user. Each comes once, and stands in the report, too.
    Warning(&'a str),
    /// Begin of tracing, with the number of camera paths that are traced already.
    TraceBegins {
        /// Paths from before a checkpoint.
        traced: u64,
        /// Paths of the whole image, as far as is known.
        expected: u64,
        /// Path of the checkpoint that the render goes on from.
        resumed: Option<&'a Path>,
        /// Samples a pixel in that checkpoint.
        samples_per_pixel: u64,
    },
    /// Number of camera paths that were traced since the last event.
    Traced(u64),
    /// End of a pass over the image.
    PassEnds {
        /// Samples that each pixel has on average.
        samples_per_pixel: f64,
        /// Paths that are expected in all.
        expected: u64,
        /// Film traced so far: [light](super::Prepared::light_so_far) that can be exposed already. Of an image that is
        /// traced in strips it is the strip under way.
        film: &'a Film,
    },
    /// End of tracing, or its breaking off.
    TraceEnds,
    /// Begin of a data set.
    SetBegins {
        /// Number of images that are to be made.
        images: u64,
    },
    /// Failure of an image of a data set, which is left out.
    ImageFails {
        /// Name of the image's camera; empty where no camera of the rig gets an image.
        camera: &'a str,
        /// The frame's number.
        frame: u32,
        /// Reason of the failure.
        error: &'a Error,
    },
    /// End of an image of a data set: it is there, or was given up.
    ImageEnds(Option<ImageOfFrame<'a>>),
    /// Wait for images of a data set that other processes are making.
    Waiting {
        /// Number of images that are waited for.
        images: usize,
    },
    /// End of a data set: all images are there, or the work is broken off.
    SetEnds,
}

/// Image of a data set that is there, by its frame and camera.
#[derive(Clone, Copy, Debug)]
pub struct ImageOfFrame<'a> {
    /// The camera's name.
    pub camera: &'a str,
    /// The frame's number.
    pub frame: u32,
    /// Time that it has taken this process; `None` where the image was there already, or another process made it.
    pub made: Option<MadeIn>,
}

/// Times that an image has taken.
#[derive(Clone, Copy, Debug)]
pub struct MadeIn {
    /// Wall-clock seconds from its begin until it was on the disk under its number.
    pub seconds: f64,
    /// Times of the steps until its files were written.
    pub steps: Timings,
}

/// Monitor that hears nothing and never stops anything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Monitor for Silent {
    fn report(&self, _: Event<'_>) {}
}

/// Guard that reports the end of tracing whichever way it ends.
pub(super) struct UntilTraceEnds<'a>(pub(super) &'a dyn Monitor);

impl Drop for UntilTraceEnds<'_> {
    fn drop(&mut self) {
        self.0.report(Event::TraceEnds);
    }
}

/// Whether the work may go on; the error says that nothing is lost but what is under way.
pub fn go_on(monitor: &dyn Monitor) -> photosite_core::Result<()> {
    if monitor.is_cancelled() {
        return Err(cancelled(
            "run the same command again, and it starts again, or continues from its checkpoint".to_owned(),
        ));
    }
    Ok(())
}

/// The error of work that its monitor has stopped; `help` says how it goes on.
pub(super) fn cancelled(help: String) -> Error {
    Error::Cancelled { message: "the work was cancelled".to_owned(), help: Some(help.into()) }
}
