//! What a caller hears of work that takes long, and how it stops it.

use std::path::Path;

use crate::Error;
use crate::film::Film;
use crate::report::Timings;

/// Watches work under way. One method takes everything that is reported, the other is asked whether to stop.
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

/// What is reported of work under way.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// What the user should know of the result. Each is said once, and stands in the report, too.
    Warning(&'a str),
    /// Tracing begins: of so many camera paths these are traced already.
    TraceBegins {
        /// Paths from before a checkpoint.
        traced: u64,
        /// Paths of the whole picture, as far as is known.
        expected: u64,
        /// The checkpoint that it goes on from.
        resumed: Option<&'a Path>,
        /// Samples a pixel in that checkpoint.
        samples_per_pixel: u64,
    },
    /// So many more camera paths are traced.
    Traced(u64),
    /// Another pass over the image is done.
    PassEnds {
        /// Samples that each pixel has on average.
        samples_per_pixel: f64,
        /// Paths that are expected in all.
        expected: u64,
        /// What is traced so far: [light](super::Prepared::light_so_far) that can be exposed already. Of a picture that
        /// is traced in strips it is the strip under way.
        film: &'a Film,
    },
    /// Tracing is over, or broken off.
    TraceEnds,
    /// So many pictures of a data set are to be made.
    SetBegins {
        /// Their number.
        pictures: u64,
    },
    /// A picture of it cannot be made, and is left out.
    PictureFails {
        /// Whose; empty where no camera of the rig gets one.
        camera: &'a str,
        /// The frame's number.
        frame: u32,
        /// Why.
        error: &'a Error,
    },
    /// Another picture is there, or was given up.
    PictureEnds(Option<PictureOfFrame<'a>>),
    /// Other processes are making so many of its pictures, which are waited for.
    Waiting {
        /// Their number.
        pictures: usize,
    },
    /// All pictures of it are there, or the work is broken off.
    SetEnds,
}

/// Which picture of a data set it is that is there.
#[derive(Clone, Copy, Debug)]
pub struct PictureOfFrame<'a> {
    /// The camera's name.
    pub camera: &'a str,
    /// The frame's number.
    pub frame: u32,
    /// What it has taken this process; `None` where it was there already, or another made it.
    pub made: Option<MadeIn>,
}

/// Wall-clock seconds that a picture has taken.
#[derive(Clone, Copy, Debug)]
pub struct MadeIn {
    /// From its begin until it was on the disk under its number.
    pub seconds: f64,
    /// The steps until its files were written.
    pub steps: Timings,
}

/// Hears nothing and never stops anything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Monitor for Silent {
    fn report(&self, _: Event<'_>) {}
}

/// Reports the end of tracing whichever way it ends.
pub(super) struct UntilTraceEnds<'a>(pub(super) &'a dyn Monitor);

impl Drop for UntilTraceEnds<'_> {
    fn drop(&mut self) {
        self.0.report(Event::TraceEnds);
    }
}

/// Whether the work may go on; the error says that nothing is lost but what is under way.
pub(crate) fn go_on(monitor: &dyn Monitor) -> crate::Result<()> {
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
