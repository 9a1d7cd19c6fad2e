//! Reuse of light: whether light that was traced for one sensor and exposure is what another would have seen.

use photosite_capture::ExposureSettings;
use photosite_core::Invalid;
use photosite_sensor::SensorModel;

/// Refuses times at which other light would have been seen. Where nothing moves, light is a rate, and every time and
/// row time is exact; what a moving camera saw is known for the rendered ones alone. A scanning sensor sees all lines
/// from one row in any case.
pub(crate) fn same_times(
    recorded_and_wanted: [(&SensorModel, &ExposureSettings); 2],
    moves: bool,
) -> Result<(), Invalid> {
    let [was, is] = recorded_and_wanted.map(|(sensor, exposure)| (sensor.shutter, exposure));
    if was.0.scans() != is.0.scans() || moves && was.0 != is.0 {
        let message = "the rows of this sensor see light at other times than those of the rendered one";
        return Err(
            Invalid::new("sensor.shutter", message).help("keep its shutter as it was rendered, or render again")
        );
    }
    let help = "leave it as it was rendered, or render again";
    if moves && (was.1.time, was.1.frame_interval) != (is.1.time, is.1.frame_interval) {
        let key = if was.1.time == is.1.time { "exposure.frame_interval_s" } else { "exposure.time_s" };
        let message = "the camera moves, and what it sees at other times is not stored";
        return Err(Invalid::new(key, message).help(help));
    }
    if moves && is.1.bracket.is_some() {
        let message = "the camera moves, and the images of a bracket would differ";
        return Err(Invalid::new("exposure", message).help("remove the bracket"));
    }
    if moves && is.1.frames > was.1.frames {
        let message = format!("the camera moves, and the light of {} images is stored", was.1.frames);
        return Err(Invalid::new("exposure.frames", message).help("ask for as many or fewer, or render again"));
    }
    Ok(())
}

/// Refuses cells that would have collected light at other places, or where none was traced.
pub(crate) fn same_cells(recorded: &SensorModel, sensor: &SensorModel) -> Result<(), Invalid> {
    let help = "keep it as it was rendered, or render again";
    if recorded.cells.shape != sensor.cells.shape {
        let message = "cells of this shape collect light at other places than those of the rendered sensor";
        return Err(Invalid::new("sensor.cells", message).help(help));
    }
    let [was, is] = [recorded, sensor].map(|sensor| sensor.cells.image_circle);
    let is_wider = was.is_some_and(|was| is.is_none_or(|is| is.radii_px.cmpgt(was.radii_px).any()));
    if is_wider {
        let message = "the image was rendered for a smaller circle, and no light was traced beyond";
        return Err(Invalid::new("sensor.image_circle_mm", message).help(help));
    }
    Ok(())
}
