//! Making the pictures of a data set that are not there, beside other processes that do the same.

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;
use std::thread::sleep;
use std::time::Duration;

use super::DataSet;
use super::folder::{DatasetFolder, NewPicture, Turn};
use super::frames::Frames;
use super::presence::name;
use super::selection::{FrameList, in_order};
use crate::pipeline::{Event, LightSource, Monitor, OutputFolder, Request, go_on, render_into};
use crate::report::Timings;
use crate::{Error, Invalid, Result};

/// Between two looks at what other processes make, at first and after a while.
const SHORTEST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);

/// What a run has made of a data set.
#[derive(Debug, Default)]
pub struct Made {
    /// How many pictures, by this process.
    pub pictures: usize,
    /// The frames that could not be made, in order.
    pub failed: Vec<u32>,
}

impl Made {
    /// Refuses to call it done where frames are bad.
    pub fn check(&self, folder: &DatasetFolder) -> Result<()> {
        if self.failed.is_empty() {
            return Ok(());
        }
        let frames = FrameList::of(&self.failed);
        let message = format!("is without frames that could not be made: {frames}");
        let help = format!("see what was said of each, and then give the same command with --frames {frames}");
        Err(Invalid::new("", message).help(help).in_file(folder.path()))
    }
}

/// A picture of a frame, with the changes to the capture that make it.
type Picture<'a> = (u32, &'a str, &'a [String]);

impl DataSet {
    /// Makes all pictures of the frames that are not there, with the light that a camera has in a frame. With
    /// `keeps_going` a picture that cannot be made is reported and left out.
    pub fn make(
        &self,
        frames: &Frames,
        folder: &DatasetFolder,
        monitor: &dyn Monitor,
        keeps_going: bool,
        light: impl Fn(&str, u32) -> Result<LightSource<'static>>,
    ) -> Result<Made> {
        self.warn(folder, monitor);
        folder.record_failures(frames, self.plan.cameras().iter().map(|camera| &*camera.place.name));
        let mut todo: Vec<Picture<'_>> = self.pictures(frames).filter(|&(n, c, _)| !folder.is_done(c, n)).collect();
        if !folder.knows_locks() && !todo.is_empty() {
            // Each process begins somewhere else, so that few make the same.
            let somewhere = RandomState::new().hash_one(()) as usize % todo.len();
            todo.rotate_left(somewhere);
        }
        monitor.report(Event::SetBegins { pictures: todo.len() as u64 });
        let _until_end = UntilSetEnds(monitor);
        let mut made = Made { pictures: 0, failed: frames.failed.clone() };
        let mut is_first = true;
        let mut pause = SHORTEST_PAUSE;
        while !todo.is_empty() {
            // What other processes make is looked at again in the end: they may die.
            let mut theirs = Vec::new();
            for picture in todo {
                let (number, camera, _) = picture;
                let turn = match folder.begin(camera, number)? {
                    Turn::Theirs => {
                        theirs.push(picture);
                        continue;
                    }
                    Turn::Done => None,
                    Turn::Ours(turn) => Some(turn),
                };
                if let Some(turn) = turn {
                    // Warnings about the scene are given once.
                    let of_one = OfOnePicture { monitor, warns: std::mem::take(&mut is_first) };
                    let outcome = self.picture(picture, &light, turn, &of_one);
                    match outcome.inspect_err(|error| folder.record_failure(camera, number, error)) {
                        Ok(is_ours) => made.pictures += usize::from(is_ours),
                        Err(error @ Error::Cancelled { .. }) => return Err(error),
                        Err(error) if keeps_going => {
                            go_on(monitor)?;
                            monitor.report(Event::PictureFails { camera, frame: number, error: &error });
                            made.failed.push(number);
                        }
                        Err(error) => return Err(error),
                    }
                }
                monitor.report(Event::PictureEnds);
            }
            todo = theirs;
            if !todo.is_empty() {
                if pause == SHORTEST_PAUSE {
                    monitor.report(Event::Waiting { pictures: todo.len() });
                }
                go_on(monitor)?;
                sleep(pause);
                pause = LONGEST_PAUSE.min(pause * 2);
            }
        }
        made.failed = in_order(made.failed);
        Ok(made)
    }

    /// Says what of the captures does not hold in a data set, and what of the folder cannot be relied on.
    fn warn(&self, folder: &DatasetFolder, monitor: &dyn Monitor) {
        if self.captures.iter().any(|capture| capture.sensor.image_lag.is_some()) {
            monitor.report(Event::Warning(
                "the pictures of a data set are made one by one, maybe by several processes: each starts without the \
                 charge that sensor.charge.image_lag keeps from the frame before",
            ));
        }
        if !folder.knows_locks() {
            monitor.report(Event::Warning(
                "the file system of the data set knows no locks: of processes that fill the folder together two may make \
                 the same picture, of which one is dropped",
            ));
        }
    }

    /// Makes one picture, and returns whether it got its number, or another process's did.
    fn picture(
        &self,
        (number, camera, overrides): Picture<'_>,
        light: impl Fn(&str, u32) -> Result<LightSource<'static>>,
        picture: NewPicture,
        monitor: &dyn Monitor,
    ) -> Result<bool> {
        if let Some(lost) = picture.lost() {
            monitor.report(Event::Warning(&format!("{} is made again: {lost}", name(camera, number))));
        }
        let light = light(camera, number)?;
        // It was read before, with all that it names.
        let capture = self.capture(camera, number, overrides).map_err(Error::since_begun)?;
        let mut results = OutputFolder::own(picture.path());
        let request = Request {
            input: &self.capture_path,
            named: self.file.description.capture.clone(),
            light,
            film_memory: self.film_memory,
            monitor,
            is_timed: false,
        };
        let rendered = render_into(capture, &request, &mut results, Timings::default());
        rendered.map_err(|error| self.error_of_change(error, camera, number, overrides))?;
        picture.finish()
    }
}

/// What is heard of one picture of a set: that it was cancelled, and warnings of the first alone.
struct OfOnePicture<'a> {
    monitor: &'a dyn Monitor,
    warns: bool,
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
            | Event::PictureEnds
            | Event::PictureFails { .. }
            | Event::Waiting { .. }
            | Event::SetEnds => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        self.monitor.is_cancelled()
    }
}

/// Reports the end of a set whichever way it ends.
struct UntilSetEnds<'a>(&'a dyn Monitor);

impl Drop for UntilSetEnds<'_> {
    fn drop(&mut self) {
        self.0.report(Event::SetEnds);
    }
}
