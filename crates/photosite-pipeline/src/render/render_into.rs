//! A whole render into a folder: prepare, trace, expose, develop, write, the report last.

use std::time::Instant;

use serde_json::{Map, Value};

use super::image_report::Taken;
use super::image_series::{ExposedSeries, ImageSeries, Recorded};
use super::request::{LightSource, Request};
use crate::monitor::{Event, go_on};
use crate::prepare::prepared::Prepared;
use crate::prepare::strips::Strips;
use crate::prepare::truth_views::TruthViews;
use crate::trace::parts::check_samples;
use crate::write::output_folder::OutputFolder;
use crate::write::provenance::{FINGERPRINT, provenance};
use photosite_calibration::truth::NotFound;
use photosite_capture::report::{PartReport, Report, Timings};
use photosite_capture::{Capture, real_path};
use photosite_core::Result;
use photosite_transport::film::Response;

/// A render that is done and written.
pub enum Rendered {
    /// Image with its report, and the wall-clock time of its steps.
    Image {
        /// Contents of `capture.json`.
        report: Box<Report>,
        /// Wall-clock seconds, also where the report leaves them out.
        timings: Timings,
    },
    /// Part of a render: the contents of `part.json`.
    Part(Box<PartReport>),
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
            LightSource::Traced | LightSource::Given(_) => {}
            LightSource::Part(samples) => check_samples(samples, &capture)?,
            LightSource::Merged(parts) => parts.check(&capture)?,
        }
        let start = Instant::now();
        let is_exposed = !matches!(request.light, LightSource::Part(_));
        let strips_of = |capture: &Capture| {
            let channels = crate::camera::film_responses::responses(capture).len();
            request.film_memory.strips(capture, channels, [is_exposed, true])
        };
        // A scene that is there already takes no more memory.
        let has_scene = earlier.as_ref().is_some_and(|earlier| earlier.is_of(capture.scene()));
        let before = if has_scene { None } else { Some(strips_of(&capture)?) };
        go_on(request.monitor)?;
        let prepared = Prepared::after(earlier, capture)?;
        let strips = before.map_or_else(|| strips_of(&prepared.capture), Ok)?;
        timings.build_s = start.elapsed().as_secs_f64();
        Ok(Self { request, prepared, strips, timings })
    }

    /// Prepared capture, of which the next render may use what is common to both.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// Renders into a folder, the report last.
    ///
    /// # Errors
    ///
    /// Errors of [`render_into`].
    pub fn render_into(self, folder: &mut OutputFolder) -> Result<Rendered> {
        let Self { request, prepared, strips, mut timings } = self;
        let (prepared, capture) = (&prepared, &prepared.capture);
        prepared.warnings().iter().for_each(|warning| request.monitor.report(Event::Warning(warning)));
        let views = TruthViews::new(prepared, &capture.output().truth.layers)?;
        let not_found = NotFound::default();
        let (strips, provenance) = (&strips, provenance(capture)?);
        let all = ImageSeries { request, provenance: &provenance, prepared, strips, views, not_found: &not_found };
        let recorded = all.record(folder, &mut timings).map_err(|error| folder.since_claimed(error))?;
        let Recorded { exposed, paths, plan, mut warnings } = recorded;
        let Some(series) = exposed else {
            let part = PartReport { plan, ..part_report(request, prepared, provenance, folder, timings.trace_s) };
            folder.write_part(&part)?;
            return Ok(Rendered::Part(Box::new(part)));
        };
        match &request.light {
            LightSource::Merged(parts) => timings.trace_s = parts.trace_s().unwrap_or(0.0),
            LightSource::Given(given) => timings.trace_s = given.light.trace_s,
            LightSource::Traced | LightSource::Part(_) => {}
        }

        let ExposedSeries { exposure, gains, first, reached, device } = series;
        let device = device.and_then(|device| device.map_err(|warning| warnings.push(warning)).ok());
        let (frame, _) = request.light.begin();
        let taken = Taken { exposure: &exposure, raw: &first, gains: &gains, frame };
        let mut report = prepared.report_of(&taken, (reached, paths), (&warnings, &not_found), folder.path())?;
        report.input.clone_from(&request.named);
        report.exposure.device = device;
        // Of a later frame alone, its capture is not all that decides it.
        report.fingerprint =
            provenance.get(FINGERPRINT).and_then(Value::as_str).filter(|_| frame == 0).map(str::to_owned);
        (report.files, report.sums) = (folder.files(), folder.sums().clone());
        report.timings = request.is_timed.then_some(timings);
        report.traced.paths_per_s = report.timings.map(|timings| paths as f64 / timings.trace_s);
        not_found.warning().iter().for_each(|warning| request.monitor.report(Event::Warning(warning)));
        folder.write_report(&report)?;
        Ok(Rendered::Image { report: Box::new(report), timings })
    }
}

impl Prepared {
    /// Writes an image of light that was traced before into a folder, the report last, as [`render_into`] does.
    pub(crate) fn expose_into(&self, request: &Request<'_>, folder: &mut OutputFolder) -> Result<Rendered> {
        let strips = request.film_memory.strips(&self.capture, self.responses.len(), [true, false])?;
        ReadyRender { request, prepared: self.clone(), strips, timings: Timings::default() }.render_into(folder)
    }
}

/// Contents of `part.json`; `trace_s` is kept where the request is timed.
fn part_report(
    request: &Request<'_>,
    prepared: &Prepared,
    provenance: Map<String, Value>,
    folder: &OutputFolder,
    trace_s: f64,
) -> PartReport {
    let samples_per_pixel = prepared.capture.render().samples_per_pixel;
    let samples = match &request.light {
        LightSource::Part(samples) => [samples.start, samples.end],
        LightSource::Traced | LightSource::Merged(_) | LightSource::Given(_) => [0, samples_per_pixel],
    };
    PartReport {
        samples,
        samples_per_pixel,
        input: request.named.clone(),
        path: real_path(request.input),
        overrides: prepared.capture.overrides().to_vec(),
        trace_s: request.is_timed.then_some(trace_s),
        plan: None,
        files: folder.files(),
        sums: folder.sums().clone(),
        channels: prepared.responses.iter().map(|response: &Response| response.name.clone()).collect(),
        provenance,
    }
}
