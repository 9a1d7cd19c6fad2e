//! Destination of a render: a free folder, or the results that an earlier run of the same render has left there.

use std::path::Path;

use serde_json::Value;

use super::render_into::Rendered;
use super::request::LightSource;
use crate::monitor::{Event, Monitor};
use crate::trace::parts::read_part;
use crate::write::file_names::PART;
use crate::write::output_folder::OutputFolder;
use crate::write::provenance::{FINGERPRINT, provenance};
use photosite_capture::Capture;
use photosite_capture::report::{CheckDepth, REPORT, Report, ReportFiles};
use photosite_core::Result;

/// Destination of a render's results.
pub enum Destination {
    /// Folder that is free for the render.
    Free(OutputFolder),
    /// Folder that holds all results already.
    Done(Rendered),
}

impl Destination {
    /// Claims a folder as [`OutputFolder::claim`] does. One that holds the results of this very render, of the same
    /// version, keys and input files, is left as it is; one that has lost a file of it is filled again.
    ///
    /// # Errors
    ///
    /// Errors of [`OutputFolder::claim`]; files that the capture names and that cannot be read.
    pub fn claim(
        path: &Path,
        force: bool,
        capture: &Capture,
        light: &LightSource<'_>,
        monitor: &dyn Monitor,
    ) -> Result<Self> {
        let earlier = if force { None } else { earlier(path, capture, light)? };
        let is_damaged = match earlier {
            Some((done, None)) => return Ok(Self::Done(done)),
            Some((_, Some(what))) => {
                monitor.report(Event::Warning(&format!("{} is made again: {what}", path.display())));
                true
            }
            None => false,
        };
        OutputFolder::claim(path, force || is_damaged).map(Self::Free)
    }
}

/// Results of this render in a folder, and the reason why they cannot be used.
fn earlier(folder: &Path, capture: &Capture, light: &LightSource<'_>) -> Result<Option<(Rendered, Option<String>)>> {
    let is_part = matches!(light, LightSource::Part(_));
    let path = folder.join(if is_part { PART } else { REPORT });
    // Of what cannot be read nothing is known, and it stays somebody's.
    let Some(listing) = Some(&path).filter(|path| path.is_file()).and_then(|path| ReportFiles::read(path).ok()) else {
        return Ok(None);
    };
    if listing.fingerprint.is_none()
        || listing.fingerprint.as_deref() != provenance(capture)?.get(FINGERPRINT).and_then(Value::as_str)
    {
        return Ok(None);
    }
    let damage = listing.damage(folder, CheckDepth::Sizes);
    let done = match light {
        LightSource::Part(samples) => {
            read_part(folder).ok().filter(|part| part.range() == *samples).map(|part| Rendered::Part(Box::new(part)))
        }
        LightSource::Traced | LightSource::Merged(_) | LightSource::Given(_) => {
            Report::read(&path).ok().map(|report| {
                let timings = report.timings.unwrap_or_default();
                Rendered::Image { report: Box::new(report), timings }
            })
        }
    };
    Ok(done.map(|done| (done, damage)))
}
