//! Scaling of a sensor, `sensor.scaled_to_px`: the same sensor with another number of pixels, for an image of the same
//! view at another size.
//!
//! The sensor keeps its size, so that lens, depth of field and blur by motion stay as they are, and each pixel gets as
//! much larger or smaller. Its charge goes with its area: full well and conversion gain follow, so that the same
//! exposure gives as bright an image. Noise in electrons stays, as in pixels of the same make. Where the shape of the
//! image is another one, all of the old view stays in it, and more is seen at two sides.

use super::super::tree::nodes::{Node, Value};
use super::super::tree::source::CaptureSource;
use photosite_core::{Invalid, Result};

const KEY: &str = "sensor.scaled_to_px";

/// Charge that grows with the area of a pixel.
const WITH_AREA: [&[&str]; 2] = [&["charge", "full_well_e"], &["charge", "logarithmic_reference_e_per_s"]];
/// Digital numbers per electron, which go down with the area of a pixel.
const AGAINST_AREA: [&[&str]; 3] = [
    &["adc", "conversion_gain_dn_per_e"],
    &["adc", "dual_gain", "high_gain_dn_per_e"],
    &["adc", "dual_gain", "low_gain_dn_per_e"],
];

/// Gives a whole sensor the number of pixels that `wanted` says; returns warnings.
pub(crate) fn scale_to(source: &CaptureSource, sensor: &mut Node, wanted: &Node) -> Result<Vec<String>> {
    let invalid = |message: &str, help: &str| source.error(Invalid::new(KEY, message).help(help));
    let size: [u32; 2] = source.read_node(KEY, wanted)?;
    if size.iter().any(|side| !(1..=65_535).contains(side)) {
        return Err(invalid("must be 1 to 65535 pixels each way", "for example scaled_to_px = [400, 300]"));
    }
    // A place in the image would be another one; "centre" stays what it is.
    let in_pixels = ["lens.intrinsics", "exposure.region_px", "lens.autofocus_px"];
    let is_place = |key: &&str| source.get(key).is_some_and(|node| !matches!(node.value, Value::String(_)));
    if let Some(key) = in_pixels.into_iter().find(is_place) {
        return Err(invalid(
            &format!("cannot be combined with {key}, which is in pixels of the other size"),
            &format!("remove {key}, or write resolution_px and pixel_pitch_um yourself"),
        ));
    }
    if sensor.at(&["frame_grabber"]).is_some() {
        let help = "write resolution_px, pixel_pitch_um and frame_grabber.size_px yourself";
        return Err(invalid("cannot be combined with a frame grabber, whose samples are not pixels", help));
    }
    // Measured maps are refused by their own size; a table of pixels has none.
    if sensor.at(&["defects", "pixels"]).is_some() {
        let help = "write the table of the other size, resolution_px and pixel_pitch_um yourself";
        return Err(invalid("cannot be combined with defects.pixels, which are places on the sensor as it is", help));
    }
    let numbers = |key: &str| Some([number(sensor, key, 0)?, number(sensor, key, 1)?]);
    let (Some(old), Some(pitch)) = (numbers("resolution_px"), numbers("pixel_pitch_um")) else {
        let help = "write pixel_pitch_um in place of a format, and resolution_px";
        return Err(invalid("needs to know how many pixels of what size the sensor has", help));
    };
    let [across, down] = [0, 1].map(|i| old[i] / f64::from(size[i]));
    let growth = across.max(down);
    let span = wanted.span.clone();
    let float = |value: f64| Node { span: span.clone(), value: Value::Float(value) };
    let whole = |value: u32| Node { span: span.clone(), value: Value::Integer(value.into()) };
    let mut put = |key: &str, nodes: Vec<Node>| {
        sensor.remove(key);
        sensor.insert_new(key, Node { span: span.clone(), value: Value::Array(nodes) });
    };
    put("resolution_px", size.map(whole).to_vec());
    put("pixel_pitch_um", pitch.map(|pitch| float(pitch * growth)).to_vec());
    let area = growth * growth;
    let mut warnings = Vec::new();
    let full_well_e = sensor.at(&["charge", "full_well_e"]).and_then(Node::as_number);
    if sensor.at(&["kind"]).and_then(Node::as_str) == Some("spad") {
        warnings.push(format!(
            "{KEY}: each pixel counts {area:.3} times as many photons of the same light, up to as many as before"
        ));
    } else {
        WITH_AREA.iter().for_each(|key| multiply(sensor, key, area));
        AGAINST_AREA.iter().for_each(|key| multiply(sensor, key, 1.0 / area));
        warnings.extend(full_well_e.and_then(|before| noise_lost([before, before * area], growth)));
    }
    // All rows together take as long as before.
    multiply(sensor, &["shutter", "row_time_us"], down);
    Ok(warnings)
}

/// Charge of a full pixel, e⁻, above which no 8-bit image shows its noise. At mid-grey, a reflectance g of 0.18, n full
/// electrons make a shot noise of √(g/n) of white; there sRGB has 255·(1.055/2.4)·g^(1/2.4 − 1) = 305 codes for white,
/// and rounding to a code has a standard deviation of 1/√12: n = 12·305²·g.
const NOISELESS_E: f64 = 12.0 * 305.0 * 305.0 * 0.18;

/// A warning where pixels have become so much larger that an image shows none of the noise which the sensor's own have.
fn noise_lost([before_e, after_e]: [f64; 2], growth: f64) -> Option<String> {
    (before_e < NOISELESS_E && after_e >= NOISELESS_E).then(|| {
        format!(
            "{KEY}: pixels {growth:.1} times as wide as the sensor's own hold {after_e:.0} e⁻ instead of {before_e:.0} e⁻: \
             their noise is {growth:.1} times less beside the light, and less than an 8-bit image rounds; for the noise of \
             the sensor's own pixels, write sensor.resolution_px, which takes part of them, or bin or resize its images"
        )
    })
}

fn number(sensor: &Node, key: &str, index: usize) -> Option<f64> {
    let Value::Array(numbers) = &sensor.at(&[key])?.value else { return None };
    numbers.get(index)?.as_number().filter(|number| *number > 0.0)
}

fn multiply(sensor: &mut Node, key: &[&str], factor: f64) {
    let Some(node) = sensor.at_mut(key) else { return };
    if let Some(number) = node.as_number() {
        node.value = Value::Float(number * factor);
    }
}

#[cfg(test)]
mod tests {
    use crate::{NamedSensor, read_named_sensor};
    use photosite_core::Sandbox;
    use photosite_core::units::Seconds;
    use photosite_sensor::{Exposure, presets};

    /// Case: sides of the sensor, saturation by light and time of all rows stay, whatever the preset; an image of
    /// another shape shows no less.
    #[test]
    fn every_preset_keeps_its_size_and_the_light_that_it_holds() {
        let exposure = Exposure::of(Seconds(0.01));
        for name in presets::names() {
            let preset = presets::model(name).expect("listed");
            let [columns, rows] = preset.resolution;
            let scaled = |size: [usize; 2]| {
                let set = [format!("scaled_to_px=[{}, {}]", size[0], size[1])];
                read_named_sensor(&Sandbox::default(), name, &set).expect(name)
            };
            let NamedSensor { model, warnings, .. } = scaled([columns * 2, rows * 2]);
            assert_eq!(model.resolution, [columns * 2, rows * 2]);
            for i in 0..2 {
                assert!((model.pixel_pitch_m[i] * 2.0 / preset.pixel_pitch_m[i] - 1.0).abs() < 1e-12, "{name}");
            }
            let held = |sensor: &photosite_sensor::SensorModel| sensor.saturation_capacity(&exposure).0;
            let is_counter = preset.architecture.spad().is_some();
            let expected = if is_counter { 1.0 } else { 4.0 };
            assert!((held(&preset) / held(&model) / expected - 1.0).abs() < 1e-9, "{name}");
            assert_eq!(warnings.len(), usize::from(is_counter), "{name}: {warnings:?}");
            let time =
                |sensor: &photosite_sensor::SensorModel| sensor.shutter.row_time().0 * sensor.resolution[1] as f64;
            assert!((time(&model) - time(&preset)).abs() <= 1e-12 * time(&preset), "{name}");

            let wide = scaled([columns * 3, rows]).model;
            assert_eq!(wide.pixel_pitch_m, preset.pixel_pitch_m, "{name}: as high as before, and wider");
        }
    }
}
