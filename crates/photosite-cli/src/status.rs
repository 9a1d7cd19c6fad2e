//! `photosite status`: the status of a data set, by its folder.

use std::path::{Path, PathBuf};

use clap::Args;
use photosite_core::counted;
use serde_json::{Value, json};

use super::exit_status::{DONE, FAILED};
use super::print::{println_out, println_text};
use super::shell_words::{all_quoted, quoted};
use photosite_core::Result;
use photosite_dataset::{ImageState, ImageStatus, Status};

/// Exit status: images are missing, and no process is making any.
const MISSING: u8 = 3;
/// Exit status: images are missing, and some are being made.
const RUNNING: u8 = 4;
/// Number of images named of each kind, unless all are requested with --json.
const MOST_NAMED: usize = 20;

const STATUSES: &str = "\
Example:
  photosite status set

Exit status: 0 all images exist; 1 some have failed or are damaged, or the folder cannot be read; \
2 wrong usage, or the folder does not contain a data set; 3 some are missing, and no process makes any; \
4 some are missing, and processes are making some.

A process that makes an image holds its lock and gives a sign of life every 5 s. Where locks do \
not reach from machine to machine, a process that has been silent for 30 s is taken to be dead. Times are those \
of the file system: the clocks of machines may differ.";

/// Show how far a data set has come, and what to run again.
///
/// Only the folder is read, and nothing in it is changed; the data set file is not needed.
#[derive(Args)]
#[command(after_help = STATUSES)]
pub(super) struct StatusArgs {
    /// The folder that `photosite dataset` fills.
    folder: PathBuf,
    /// Print JSON: a line for each image, and one for the whole at the end.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &StatusArgs) -> Result<u8> {
    let status = Status::read(&args.folder)?;
    let counts = Counts::of(&status);
    if args.json {
        for image in &status.images {
            println_out(&event("picture", json!(image)))?;
        }
        println_out(&event("end", json!(whole(&status, &counts))))?;
    } else {
        println_text(&words(&status, &counts))?;
    }
    Ok(counts.exit_status())
}

/// Number of images in each state.
struct Counts {
    done: usize,
    running: usize,
    failed: usize,
    damaged: usize,
    missing: usize,
}

impl Counts {
    fn of(status: &Status) -> Self {
        Self {
            done: status.count(|state| matches!(state, ImageState::Done)),
            running: status.count(|state| matches!(state, ImageState::Running { .. })),
            failed: status.count(|state| matches!(state, ImageState::Failed(_))),
            damaged: status.count(|state| matches!(state, ImageState::Damaged { .. })),
            missing: status.count(|state| matches!(state, ImageState::Missing)),
        }
    }

    fn exit_status(&self) -> u8 {
        match self {
            Self { failed: 1.., .. } | Self { damaged: 1.., .. } => FAILED,
            Self { running: 1.., .. } => RUNNING,
            Self { missing: 1.., .. } => MISSING,
            Self { .. } => DONE,
        }
    }
}

/// Line of JSON for an event.
fn event(kind: &str, what: Value) -> String {
    let mut line = json!({ "event": kind });
    if let (Value::Object(line), Value::Object(what)) = (&mut line, what) {
        line.extend(what);
    }
    line.to_string()
}

fn whole(status: &Status, counts: &Counts) -> Value {
    let to_make = status.to_make();
    json!({
        "folder": status.folder,
        "frames": status.frames,
        "cameras": status.cameras,
        "pictures": status.images.len(),
        "done": counts.done,
        "running": counts.running,
        "failed": counts.failed,
        "damaged": counts.damaged,
        "missing": counts.missing,
        "complete": counts.done == status.images.len(),
        "to_make": (!to_make.is_empty()).then(|| to_make.in_full()),
        "command": (!to_make.is_empty()).then(|| command(status)),
        "times_known": status.timeless.is_empty(),
    })
}

/// Status in words.
fn words(status: &Status, counts: &Counts) -> String {
    let mut lines = vec![summary(status, counts)];
    for (kind, is_one) in KINDS {
        let of_kind: Vec<String> = status.images.iter().filter(|p| is_one(&p.state)).filter_map(line).collect();
        lines.extend(of_kind.iter().take(MOST_NAMED).map(|what| format!("{kind:8} {what}")));
        if let Some(more @ 1..) = of_kind.len().checked_sub(MOST_NAMED) {
            lines.push(format!("{kind:8} and {more} more, which --json names"));
        }
    }
    if !status.timeless.is_empty() && counts.running > 0 {
        let folders: Vec<String> =
            status.timeless.iter().map(|camera| status.folder.join(camera).display().to_string()).collect();
        lines.push(format!(
            "warning: nothing can be written to {}, so it is not known for how long images have been in the making there, \
             nor whether the processes of other machines that make them are still alive",
            folders.join(", ")
        ));
    }
    let to_make = status.to_make();
    if !to_make.is_empty() {
        lines.push(format!("to make: frames {to_make}"));
        lines.push(format!("  {}", command(status)));
    }
    lines.join("\n")
}

fn summary(status: &Status, counts: &Counts) -> String {
    let Status { folder, frames, cameras, images, .. } = status;
    let what = if status.part.is_some() { "parts of images" } else { "images" };
    let Counts { done, running, failed, damaged, missing } = counts;
    let mut text = format!("{}: {done} of {} {what} done", folder.display(), images.len());
    text += &format!(" ({}, {})", counted(*frames, ["frame", "frames"]), counted(cameras.len(), ["camera", "cameras"]));
    for (count, kind) in [(running, "running"), (failed, "failed"), (damaged, "damaged"), (missing, "missing")] {
        if *count > 0 {
            text += &format!(", {count} {kind}");
        }
    }
    text
}

/// Kinds of states of which each image is named.
type Kind = (&'static str, fn(&ImageState) -> bool);
const KINDS: [Kind; 3] = [
    ("running", |state| matches!(state, ImageState::Running { .. })),
    ("failed", |state| matches!(state, ImageState::Failed(_))),
    ("damaged", |state| matches!(state, ImageState::Damaged { .. })),
];

/// Line about an image that is running, failed or damaged.
fn line(image: &ImageStatus) -> Option<String> {
    let what = match &image.state {
        ImageState::Done | ImageState::Missing => return None,
        ImageState::Running { holder, age_s, silence_s } => {
            let who = holder.as_ref().map_or_else(
                || "by a process that has not identified itself".to_owned(),
                |holder| format!("on {}, process {}", holder.host, holder.process),
            );
            let since = age_s.map_or_else(String::new, |age| format!(", for {}", seconds(age)));
            let heard =
                silence_s.map_or_else(String::new, |silence| format!(", last heard of {} ago", seconds(silence)));
            who + &since + &heard
        }
        ImageState::Failed(failure) => {
            let again = if failure.temporary { "; another try may succeed" } else { "" };
            let help = failure.help.as_ref().map_or_else(String::new, |help| format!("; help: {help}"));
            let words = format!("{}{help}{again}", failure.message);
            format!("on {}: {}", failure.host, words.split_whitespace().collect::<Vec<_>>().join(" "))
        }
        ImageState::Damaged { message } => message.clone(),
    };
    Some(format!("{} {what}", image.folder))
}

fn seconds(seconds: f64) -> String {
    match seconds {
        ..120.0 => format!("{seconds:.0} s"),
        ..7200.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}

/// Command that makes the missing images. The folder of a whole data set does not know the file, so that its name is a
/// placeholder.
fn command(status: &Status) -> String {
    let input = status.part.as_ref().map_or_else(|| "FILE.toml".to_owned(), |(_, path)| word(path));
    let samples = status.part.as_ref().map_or_else(String::new, |([from, to], _)| format!(" --samples {from}..{to}"));
    let set = status.overrides.iter().flat_map(|change| ["--set", change]);
    let set: String = [" ".to_owned(), all_quoted(set)].concat();
    format!(
        "photosite dataset {input} -o {}{samples}{} --frames {}",
        word(&status.folder),
        set.trim_end(),
        status.to_make().in_full()
    )
}

fn word(path: &Path) -> String {
    quoted(&path.to_string_lossy())
}
