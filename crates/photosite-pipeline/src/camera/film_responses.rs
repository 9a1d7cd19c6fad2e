//! Responses that the film of a capture is summed for: the sensor's channels, spectral bands, the CIE observer.

use photosite_capture::Capture;
use photosite_core::spectrum::{Spectrum, cie};
use photosite_transport::film::{Response, band_response};
use photosite_transport::integrator::FilterTile;

/// Planes of the film that are summed for the image of an ideal observer. No sensor's channel has such a name.
pub(crate) const IDEAL: [&str; 3] = ["ideal.X", "ideal.Y", "ideal.Z"];

/// The sensor's channels, then the bands of `irradiance.exr` and the ideal observer where they are asked for.
pub(crate) fn responses(capture: &Capture) -> Vec<Response> {
    let channels = capture.sensor().responses().into_iter().map(|(name, spectrum)| Response::new(name, spectrum));
    let bands = capture.output().irradiance.iter().flat_map(|bands| (0..bands.count).map(|band| bands.edges_nm(band)));
    let observer = || IDEAL.into_iter().zip(cie::observer()).map(|(name, bar)| Response::new(name, bar.clone()));
    let observer = capture.output().ideal.then(observer);
    channels.chain(bands.map(band_response)).chain(observer.into_iter().flatten()).collect()
}

/// Spectral responses of the sensor's channels to light before the lens.
pub(crate) fn seen_through_lens(capture: &Capture) -> Vec<Spectrum> {
    let responses = capture.sensor().responses().into_iter();
    responses.map(|(_, response)| response.product(&capture.lens().transmittance)).collect()
}

/// Importance of each wavelength: the sum of all responses, each scaled to a peak of 1.
pub(crate) fn importance(responses: &[Response]) -> Spectrum {
    let scaled = responses.iter().filter(|r| r.spectrum.max() > 0.0).map(|r| (r, 1.0 / r.spectrum.max()));
    let scaled: Vec<_> = scaled.collect();
    Spectrum::from_fn(|lambda| scaled.iter().map(|(r, scale)| f64::from(r.spectrum.eval(lambda as f32) * scale)).sum())
}

/// The filters of the sensor, where pixels have different ones.
pub(crate) fn filters(capture: &Capture) -> Option<FilterTile> {
    let cfa = &capture.sensor().cfa;
    let (width, height) = cfa.tile_size();
    let tile = || FilterTile {
        responses: capture.sensor().responses().into_iter().map(|(_, spectrum)| spectrum).collect(),
        filters: (0..width * height).map(|i| cfa.channel_at(i % width, i / width)).collect(),
        width,
    };
    cfa.is_mosaic().then(tile)
}
