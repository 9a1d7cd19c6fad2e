//! A whole render into a folder: prepare, trace, expose, develop, write, the report last.

use std::time::Instant;

use serde_json::{Map, Value};

use super::monitor::{Event, go_on};
use super::output_folder::OutputFolder;
use super::parts::check_samples;
use super::picture_report::{Made, picture_report};
use super::prepare::Prepared;
use super::provenance::{FINGERPRINT, provenance};
use super::request::{LightSource, Request};
use super::series::{Recorded, Series};
use super::strips::Strips;
use super::truth_views::TruthViews;
use crate::Result;
use crate::calibration::truth::NotFound;
use crate::capture::{Capture, real_path};
use crate::film::Response;
use crate::report::{PartReport, Report, Timings};

/// A render that is done and written.
pub enum Rendered {
    /// Its report, and the wall-clock time of its steps.
    Picture {
        /// What `capture.json` holds.
        report: Box<Report>,
        /// Wall-clock seconds, also where the report leaves them out.
        timings: Timings,
    },
    /// A part of it: what `part.json` holds.
    Part(PartReport),
}

/// Renders a capture into a folder, the report last. `timings` holds what has passed before.
///
/// # Errors
///
/// Whatever is wrong with the capture, with the folder, or with parts that are merged; that the monitor cancelled it.
pub fn render_into(
    capture: Capture,
    request: &Request<'_>,
    folder: &mut OutputFolder,
    timings: Timings,
) -> Result<Rendered> {
    ReadyRender::new(capture, None, request, timings)?.render_into(folder)
}

/// A render whose scene is built and whose camera stands in place.
pub struct ReadyRender<'a> {
    request: &'a Request<'a>,
    prepared: Prepared,
    strips: Strips,
    timings: Timings,
}

impl<'a> ReadyRender<'a> {
    /// Makes a capture ready, with what it has in common with an `earlier` one ([`Prepared::after`]). `timings` holds
    /// what has passed before.
    ///
    /// # Errors
    ///
    /// Whatever is wrong with the capture, or with parts that are merged; that the monitor cancelled it.
    pub fn new(
        capture: Capture,
        earlier: Option<Prepared>,
        request: &'a Request<'a>,
        mut timings: Timings,
    ) -> Result<Self> {
        match &request.light {
            LightSource::Traced | LightSource::Given { .. } => {}
            LightSource::Part(samples) => check_samples(samples, &capture)?,
            LightSource::Merged(parts) => parts.check(&capture)?,
        }
        let start = Instant::now();
        let is_exposed = !matches!(request.light, LightSource::Part(_));
        let strips_of = |capture: &Capture| {
            let channels = super::responses::responses(capture).len();
            request.film_memory.strips(capture, channels, [is_exposed, true])
        };
        // A scene that is there already takes no more memory.
        let has_scene = earlier.as_ref().is_some_and(|earlier| earlier.is_of(&capture.scene));
        let before = if has_scene { None } else { Some(strips_of(&capture)?) };
        go_on(request.monitor)?;
        let prepared = Prepared::after(earlier, capture)?;
        let strips = before.map_or_else(|| strips_of(&prepared.capture), Ok)?;
        timings.build_s = start.elapsed().as_secs_f64();
        Ok(Self { request, prepared, strips, timings })
    }

    /// What the next render may have in common with this one.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// Renders into a folder, the report last.
    ///
    /// # Errors
    ///
    /// As [`render_into`].
    pub fn render_into(self, folder: &mut OutputFolder) -> Result<Rendered> {
        record_into(&self.prepared, self.request, &self.strips, folder, self.timings)
    }
}

impl Prepared {
    /// Writes a picture of light that was traced before into a folder, the report last, as [`render_into`] does.
    /// `request` gives that light; for one that is shared, this is what [`for_light`](Self::for_light) has made for it.
    ///
    /// # Errors
    ///
    /// As [`render_into`].
    pub fn expose_into(&self, request: &Request<'_>, folder: &mut OutputFolder) -> Result<Rendered> {
        let strips = request.film_memory.strips(&self.capture, self.responses.len(), [true, false])?;
        record_into(self, request, &strips, folder, Timings::default())
    }
}

/// Records what is prepared into a folder.
fn record_into(
    prepared: &Prepared,
    request: &Request<'_>,
    strips: &Strips,
    folder: &mut OutputFolder,
    mut timings: Timings,
) -> Result<Rendered> {
    let capture = &prepared.capture;
    prepared.warnings().iter().for_each(|warning| request.monitor.report(Event::Warning(warning)));
    let views = TruthViews::new(prepared, &capture.output.truth.layers)?;
    let provenance = provenance(capture)?;
    let not_found = NotFound::default();
    let all = Series { request, provenance: &provenance, prepared, strips, views, not_found: &not_found };
    let recorded = all.record(folder, &mut timings).map_err(|error| folder.since_claimed(error))?;
    let Recorded { exposed, paths, warnings } = recorded;
    let Some(series) = exposed else {
        let part = part_report(request, prepared, provenance, folder, timings.trace_s);
        folder.write_part(&part)?;
        return Ok(Rendered::Part(part));
    };
    match &request.light {
        LightSource::Merged(parts) => timings.trace_s = parts.trace_s().unwrap_or(0.0),
        LightSource::Given { light, .. } => timings.trace_s = light.trace_s,
        LightSource::Traced | LightSource::Part(_) => {}
    }

    let report = picture_report(
        prepared,
        Made {
            named: request.named.clone(),
            folder: folder.path(),
            frame: request.light.frame(),
            series,
            paths,
            warnings: &warnings,
            not_found: &not_found,
            fingerprint: provenance.get(FINGERPRINT).and_then(Value::as_str),
            files: folder.files(),
            sums: folder.sums().clone(),
            timings: request.is_timed.then_some(timings),
        },
    )?;
    not_found.warning().iter().for_each(|warning| request.monitor.report(Event::Warning(warning)));
    folder.write_report(&report)?;
    Ok(Rendered::Picture { report: Box::new(report), timings })
}

/// What `part.json` says; `trace_s` is kept where the request is timed.
fn part_report(
    request: &Request<'_>,
    prepared: &Prepared,
    provenance: Map<String, Value>,
    folder: &OutputFolder,
    trace_s: f64,
) -> PartReport {
    let samples_per_pixel = prepared.capture.render.samples_per_pixel;
    let samples = match &request.light {
        LightSource::Part(samples) => [samples.start, samples.end],
        LightSource::Traced | LightSource::Merged(_) | LightSource::Given { .. } => [0, samples_per_pixel],
    };
    PartReport {
        samples,
        samples_per_pixel,
        input: request.named.clone(),
        path: real_path(request.input),
        overrides: prepared.capture.overrides().to_vec(),
        trace_s: request.is_timed.then_some(trace_s),
        files: folder.files(),
        sums: folder.sums().clone(),
        channels: prepared.responses.iter().map(|response: &Response| response.name.clone()).collect(),
        provenance,
    }
}
