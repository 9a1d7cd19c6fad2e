//! A folder for a render, or what an earlier run of the same render has left there.

use std::path::Path;

use serde_json::Value;

use super::file_names::PART;
use super::monitor::{Event, Monitor};
use super::output_folder::OutputFolder;
use super::parts::read_part;
use super::provenance::{FINGERPRINT, provenance};
use super::render::Rendered;
use super::request::LightSource;
use crate::Result;
use crate::capture::Capture;
use crate::report::{Listing, Look, REPORT, Report};

/// Where a render goes.
pub enum Place {
    /// A folder for it.
    Free(OutputFolder),
    /// All of it is there already.
    Done(Rendered),
}

impl Place {
    /// Claims a folder as [`OutputFolder::claim`] does. One that holds the results of this very render, of the same
    /// version, keys and input files, is left as it is; one that has lost a file of it is filled again.
    ///
    /// # Errors
    ///
    /// Those of [`OutputFolder::claim`]; files that the capture names and that cannot be read.
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

/// The results of this render in a folder, and what is wrong with them.
fn earlier(folder: &Path, capture: &Capture, light: &LightSource<'_>) -> Result<Option<(Rendered, Option<String>)>> {
    let is_part = matches!(light, LightSource::Part(_));
    let path = folder.join(if is_part { PART } else { REPORT });
    // Of what cannot be read nothing is known, and it stays somebody's.
    let Some(listing) = Some(&path).filter(|path| path.is_file()).and_then(|path| Listing::read(path).ok()) else {
        return Ok(None);
    };
    if listing.fingerprint.is_none()
        || listing.fingerprint.as_deref() != provenance(capture)?.get(FINGERPRINT).and_then(Value::as_str)
    {
        return Ok(None);
    }
    let damage = listing.damage(folder, Look::Sizes);
    let done = match light {
        LightSource::Part(samples) => {
            read_part(folder).ok().filter(|part| part.range() == *samples).map(Rendered::Part)
        }
        LightSource::Traced | LightSource::Merged(_) | LightSource::Given { .. } => {
            Report::read(&path).ok().map(|report| {
                let timings = report.timings.unwrap_or_default();
                Rendered::Picture { report: Box::new(report), timings }
            })
        }
    };
    Ok(done.map(|done| (done, damage)))
}
