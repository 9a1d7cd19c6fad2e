//! The ideal picture of a render: the same light, seen by an observer with the eyes of the CIE.

use crate::Result;
use crate::capture::Capture;
use crate::develop::ideal;
use crate::film::Response;
use crate::image::{Channel, Planes};
use crate::sensor::Exposure;
use crate::spectrum::{Spectrum, cie};

/// Planes of the film that are summed for it. No sensor's channel has such a name.
pub(super) const NAMES: [&str; 3] = ["ideal.X", "ideal.Y", "ideal.Z"];

/// The observer's colour-matching functions as responses of the film.
pub(super) fn responses() -> impl Iterator<Item = Response> {
    NAMES.into_iter().zip(cie::observer()).map(|(name, bar)| Response::new(name, bar.clone()))
}

/// Linear planes of the colour space that the capture develops to, from the planes [`NAMES`]. `light` is that of the
/// scene.
pub(super) fn picture(seen: Planes, capture: &Capture, light: &Spectrum, exposure: &Exposure) -> Result<Planes> {
    let named = |channel: Channel| Channel { name: channel.name.replace("ideal.", ""), ..channel };
    let (width, height) = (seen.width(), seen.height());
    let xyz = Planes::new(width, height, seen.into_channels().into_iter().map(named).collect());
    let light = light.product(&capture.lens.transmittance);
    let saturation = capture.sensor.pixel_saturation(exposure).0 / exposure.time.0;
    xyz.and_then(|xyz| ideal(xyz, &light, &capture.sensor.responses(), saturation, &capture.develop))
        .map_err(|invalid| capture.source.error(invalid.within("output")))
}
