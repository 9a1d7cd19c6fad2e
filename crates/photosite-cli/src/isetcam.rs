//! `photosite noise model --isetcam`: a sensor as the fields of ISETCam's sensor and pixel structures.
//!
//! ISETCam counts in volts and divides by its gain: v_out = (v + offset)/gain, in steps of voltageSwing/2^bits
//! (github.com/ISET/isetcam: sensorSet.m, pixelSet.m, sensorIMX363V2.m). With a swing of 1 V a number of the converter is
//! 2^−bits V, and K DN/e⁻ at 0 dB is a conversion gain of K·2^−bits V/e⁻.

use serde_json::{Value, json};

use photosite_core::cells::CellShape;
use photosite_core::math::float::rounded;
use photosite_core::spectrum::Spectrum;
use photosite_core::units::Decibels;
use photosite_core::{Error, Result};
use photosite_raw::Cfa;
use photosite_sensor::{Exposure, MaskedPixels, SensorModel, Shutter, Stage};

/// Wavelengths, nm.
const WAVE: std::ops::RangeInclusive<u32> = 380..=780;
const STEP: usize = 10;
/// Voltage at the end of the converter's range at 0 dB, V.
const SWING: f64 = 1.0;

/// Stages of the chain that its structures have figures for.
const HELD: [Stage; 6] =
    [Stage::PhotoResponse, Stage::ShotNoise, Stage::DarkCurrent, Stage::FullWell, Stage::DarkOffset, Stage::ReadNoise];

/// Fields at the gain, exposure time and temperature of an exposure.
pub(super) fn fields(sensor: &SensorModel, exposure: &Exposure) -> Result<Value> {
    if sensor.cfa.is_full() {
        let message = "ISETCam's sensors have one colour filter a pixel, and this one has all".to_owned();
        return Err(Error::Usage { message, help: Some("--json prints its noise in fields of photosite".into()) });
    }
    let converter = &sensor.converter;
    let volts_per_dn = SWING / 2f64.powi(converter.bits as i32);
    let conversion_gain = converter.conversion_gain_dn_per_e * volts_per_dn;
    let gain = 1.0 / exposure.gain.factor();
    let volts = |electrons: f64| rounded(electrons * conversion_gain, 6);
    let noise = sensor.noise.read_out.at(exposure.gain);
    let [width, height] = sensor.pixel_pitch_m;
    let side = sensor.fill_factor.sqrt();
    let wave: Vec<u32> = WAVE.step_by(STEP).collect();
    let efficiencies = sensor.efficiencies();
    let spectra: Vec<Vec<f64>> =
        wave.iter().map(|&nm| efficiencies.iter().map(|qe| rounded(qe.eval(nm as f32).into(), 6)).collect()).collect();
    let ones = vec![1; wave.len()];
    let [columns, rows] = sensor.resolution;
    Ok(json!({
        "type": "sensor",
        "name": sensor.name,
        "rows": rows,
        "cols": columns,
        "integrationTime": exposure.time.0,
        "analogGain": rounded(gain, 9),
        "analogOffset": rounded(f64::from(converter.black_level_dn(exposure.gain)) * volts_per_dn * gain, 9),
        "sigmaOffsetFPN": volts(noise.dsnu.pixel),
        "sigmaGainFPN": rounded(100.0 * sensor.noise.prnu.pixel, 6),
        "quantization": { "bits": converter.bits, "method": "linear" },
        "spectrum": { "wave": wave },
        "color": {
            "filterNames": sensor.cfa.channels().iter().map(|name| filter_name(&sensor.cfa, name)).collect::<Vec<_>>(),
            "filterSpectra": spectra,
            "irFilter": ones,
        },
        "cfa": { "pattern": pattern(sensor) },
        "pixel": {
            "width": width,
            "height": height,
            "widthGap": 0,
            "heightGap": 0,
            "pdWidth": rounded(width * side, 9),
            "pdHeight": rounded(height * side, 9),
            "conversionGain": rounded(conversion_gain, 9),
            "voltageSwing": SWING,
            "darkVoltage": volts(sensor.noise.dark_current(exposure.temperature)),
            "readNoise": volts(noise.read.0),
            "spectrum": { "wave": wave },
            "spectralQE": ones,
        },
    }))
}

/// Numbers of filters, from 1 on, row by row.
fn pattern(sensor: &SensorModel) -> Vec<Vec<usize>> {
    let (columns, rows) = sensor.cfa.tile_size();
    (0..rows).map(|y| (0..columns).map(|x| 1 + sensor.cfa.channel_at(x, y)).collect()).collect()
}

/// Letters of the colours that ISETCam knows: red, green, blue, cyan, magenta, yellow and white.
const COLOURS: &str = "rgbcmyw";

/// Name of a filter, whose first letter is its colour.
fn filter_name(cfa: &Cfa, channel: &str) -> String {
    let has = |other: &str| cfa.channels().iter().any(|name| name == other);
    match channel {
        "Y" if cfa.is_mono() => "w".to_owned(),
        // Clear beside red, cyan beside magenta.
        "C" if !has("M") && !has("Y") => "w".to_owned(),
        other => other.to_lowercase(),
    }
}

/// What the fields do not hold of a sensor.
pub(super) fn left_out(sensor: &SensorModel, exposure: &Exposure) -> Vec<String> {
    let stages = Stage::ALL.iter().filter(|stage| sensor.has_stage(**stage) && !HELD.contains(stage));
    let mut names: Vec<String> = stages.map(|stage| name_of(*stage)).collect();
    let noise = &sensor.noise;
    let pattern = noise.read_out.at(exposure.gain).dsnu;
    let mut also = |name: &str, is_there: bool| names.extend(is_there.then(|| name.to_owned()));
    also("DSNU of rows and columns", pattern.row != 0.0 || pattern.column != 0.0);
    also("PRNU of rows and columns", noise.prnu.row != 0.0 || noise.prnu.column != 0.0);
    also("maps of DSNU and PRNU", noise.dsnu_map.is_some() || noise.prnu_map.is_some());
    also("the shape of the read noise", noise.read_degrees_of_freedom.is_some() || noise.read_spread != 0.0);
    also("hexagonal cells", sensor.cells.shape != CellShape::Rectangular);
    also("an image circle", sensor.cells.image_circle.is_some());
    also("masked pixels", sensor.masked != MaskedPixels::default());
    also("a frame grabber", sensor.frame_grabber.is_some());
    also("the times of rows", sensor.shutter != Shutter::default());
    also("companding", sensor.converter.companding.is_some());
    also("a video curve", sensor.video.curve.is_some());
    also("logarithmic pixels", sensor.logarithmic.is_some());
    also("two converters", sensor.converter.dual_gain.is_some());
    let beyond = |qe: &Spectrum| qe.iter().any(|(nm, qe)| qe > 1e-3 && !(380.0..=780.0).contains(&nm));
    also("light below 380 and beyond 780 nm", sensor.efficiencies().iter().any(beyond));
    let unknown = |name: &&String| !filter_name(&sensor.cfa, name).starts_with(|letter| COLOURS.contains(letter));
    let unknown: Vec<&str> = sensor.cfa.channels().iter().filter(unknown).map(|name| &name[..]).collect();
    also(&format!("the colours of the filters {}", unknown.join(", ")), !unknown.is_empty());
    let mut told = Vec::new();
    if !names.is_empty() {
        told.push(format!("ISETCam's fields have no place for: {}", names.join(", ")));
    }
    let end = sensor.saturation_capacity(&Exposure { gain: Decibels(0.0), ..*exposure }).0;
    let range = (2f64.powi(sensor.converter.bits as i32)) / sensor.converter.conversion_gain_dn_per_e;
    if end < 0.98 * range {
        told.push(format!(
            "ISETCam's pixels saturate where the converter ends, at {range:.0} e-, and those of this sensor at {end:.0} e-"
        ));
    }
    told
}

/// Name of a stage, as a capture file has it.
fn name_of(stage: Stage) -> String {
    json!(stage).as_str().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use photosite_core::units::{Celsius, Seconds};
    use photosite_sensor::presets;

    use super::*;

    /// Test of ISETCam's formulas: what its fields say in volts becomes the numbers and electrons of the sensor.
    #[test]
    fn volts_stand_for_the_numbers_of_the_sensor() {
        let sensor = presets::model("generic-cmos-color").expect("a preset");
        let exposure = Exposure { gain: Decibels(6.0), temperature: Celsius(25.0), ..Exposure::of(Seconds(0.02)) };
        let found = fields(&sensor, &exposure).expect("a mosaic");
        let of = |path: &str| found.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"));
        let volts_per_e = of("/pixel/conversionGain");
        let step = of("/pixel/voltageSwing") / 2f64.powf(of("/quantization/bits"));
        let number = |electrons: f64| (electrons * volts_per_e + of("/analogOffset")) / of("/analogGain") / step;
        for electrons in [0.0, 100.0] {
            let wanted = f64::from(sensor.converter.black_level_dn(exposure.gain))
                + electrons * sensor.converter.system_gain(exposure.gain);
            assert!((number(electrons) / wanted - 1.0).abs() < 1e-6, "{electrons} e-: {} {wanted}", number(electrons));
        }
        let read = sensor.noise.read_out.at(exposure.gain).read.0;
        assert!((of("/pixel/readNoise") / volts_per_e / read - 1.0).abs() < 1e-5);
        assert_eq!(found["cfa"]["pattern"], json!([[1, 2], [2, 3]]));
        assert_eq!(found["color"]["filterNames"], json!(["r", "g", "b"]));
        let area = of("/pixel/pdWidth") * of("/pixel/pdHeight") / (of("/pixel/width") * of("/pixel/height"));
        assert!((area - sensor.fill_factor).abs() < 1e-6);
    }

    #[test]
    fn filters_begin_with_their_colour() {
        for (layout, wanted) in
            [("mono", "w"), ("RGGB", "r g b"), ("ryyb", "r b y"), ("rccb", "r b w"), ("cygm", "g c y m")]
        {
            let cfa = Cfa::parse(layout).expect("a layout");
            let names: Vec<String> = cfa.channels().iter().map(|name| filter_name(&cfa, name)).collect();
            assert_eq!(names.join(" "), wanted, "{layout}");
        }
    }

    /// Property: whatever stage a sensor has beyond the ones that are held is told by its name.
    #[test]
    fn every_stage_is_held_or_told() {
        for name in presets::names() {
            let sensor = presets::model(name).expect("listed");
            let exposure = Exposure::of(Seconds(0.02));
            let told = left_out(&sensor, &exposure).join("\n");
            for stage in Stage::ALL.into_iter().filter(|stage| sensor.has_stage(*stage)) {
                assert!(HELD.contains(&stage) || told.contains(&name_of(stage)), "{name}: {stage:?}");
            }
        }
    }
}
