//! What the film of a capture is summed for: the sensor's channels, spectral bands, the CIE observer.

use super::ideal;
use crate::capture::Capture;
use crate::film::{Response, band_response};
use crate::integrator::FilterTile;
use crate::spectrum::Spectrum;

/// The sensor's channels, then the bands of `irradiance.exr` and the ideal observer where they are asked for.
pub(super) fn responses(capture: &Capture) -> Vec<Response> {
    let channels = capture.sensor.responses().into_iter().map(|(name, spectrum)| Response::new(name, spectrum));
    let bands = capture.output.irradiance.iter().flat_map(|bands| (0..bands.count).map(|band| bands.edges_nm(band)));
    let observer = capture.output.ideal.then(ideal::responses);
    channels.chain(bands.map(band_response)).chain(observer.into_iter().flatten()).collect()
}

/// What the sensor makes of light before the lens.
pub(super) fn seen_through_lens(capture: &Capture) -> Vec<Spectrum> {
    let responses = capture.sensor.responses().into_iter();
    responses.map(|(_, response)| response.product(&capture.lens.transmittance)).collect()
}

/// How much each wavelength matters: the sum of all responses, each scaled to a peak of 1.
pub(super) fn importance(responses: &[Response]) -> Spectrum {
    let scaled = responses.iter().filter(|r| r.spectrum.max() > 0.0).map(|r| (r, 1.0 / r.spectrum.max()));
    let scaled: Vec<_> = scaled.collect();
    Spectrum::from_fn(|lambda| scaled.iter().map(|(r, scale)| f64::from(r.spectrum.eval(lambda as f32) * scale)).sum())
}

/// The filters of the sensor, where pixels have different ones.
pub(super) fn filters(capture: &Capture) -> Option<FilterTile> {
    let cfa = &capture.sensor.cfa;
    let (width, height) = cfa.tile_size();
    let tile = || FilterTile {
        responses: capture.sensor.responses().into_iter().map(|(_, spectrum)| spectrum).collect(),
        filters: (0..width * height).map(|i| cfa.channel_at(i % width, i / width)).collect(),
        width,
    };
    cfa.is_mosaic().then(tile)
}
