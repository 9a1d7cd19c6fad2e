//! Query of the page for an image.

use hyper::StatusCode;
use percent_encoding::percent_decode_str;

use super::answer::Failure;
use super::controls::Control;
use super::window::Window;

/// Most frames: to read out one, those before it may have to be read out, too.
pub(super) const MOST_FRAMES: u32 = 1000;
/// The key of the f-number.
pub(super) const F_NUMBER: &str = "lens.f_number";
/// Longest query. Settings of all controls take less.
const LONGEST: usize = 4096;

/// Query for an image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Query {
    pub(super) plane: String,
    /// The number of the frame, where one is asked for.
    pub(super) frame: Option<u32>,
    pub(super) input: usize,
    /// The f-number, where it is changed.
    pub(super) f_number: Option<f64>,
    /// Changes to keys, `key=value`: those of the sensor, of what else light leaves open, and of development.
    pub(super) sensor: Vec<String>,
    pub(super) exposure: Vec<String>,
    pub(super) develop: Vec<String>,
    /// Pixel of the sensor that is asked about.
    pub(super) pixel: [usize; 2],
    /// Pixels that are sent.
    pub(super) window: Window,
}

impl Query {
    /// Changes to the sensor: another one has the pixels that light was traced for.
    pub(super) fn sensor_of(&self, resolution: [usize; 2]) -> Vec<String> {
        let pixels = (!self.sensor.is_empty()).then(|| format!("sensor.resolution_px={resolution:?}"));
        self.sensor.iter().cloned().chain(pixels).collect()
    }

    /// All changes to keys, for light of `resolution`, columns and rows.
    pub(super) fn changes(&self, resolution: Option<[usize; 2]>) -> Vec<String> {
        let lens: Vec<String> = self.f_number.iter().map(|n| format!("{F_NUMBER}={n:?}")).collect();
        let sensor = resolution.map_or_else(|| self.sensor.clone(), |resolution| self.sensor_of(resolution));
        [&lens[..], &sensor, &self.exposure, &self.develop].concat()
    }

    /// Reads `key=value&key=value`, of which keys of captures are those of controls alone.
    pub(super) fn parse(text: &str, controls: &[Control]) -> Result<Self, Failure> {
        let bad = |words: String| Failure::new(StatusCode::BAD_REQUEST, words);
        if text.len() > LONGEST {
            return Err(Failure::new(StatusCode::URI_TOO_LONG, format!("the query has more than {LONGEST} bytes")));
        }
        let mut query = Self {
            plane: "developed".to_owned(),
            frame: None,
            input: 0,
            f_number: None,
            sensor: Vec::new(),
            exposure: Vec::new(),
            develop: Vec::new(),
            pixel: [0, 0],
            window: Window::default(),
        };
        for part in text.split('&').filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').ok_or_else(|| bad(format!("{part:?} has no value")))?;
            let decode = |part: &str| match percent_decode_str(part).decode_utf8() {
                Ok(text) => Ok(text.into_owned()),
                Err(_) => Err(bad(format!("{part:?} is not valid UTF-8"))),
            };
            let (key, value) = (decode(key)?, decode(value)?);
            let whole = || value.parse::<u32>().map_err(|_| bad(format!("{key}: {value:?} is not a whole number")));
            match key.as_str() {
                "plane" => query.plane = value,
                "frame" => {
                    let frame = whole()?;
                    if frame >= MOST_FRAMES {
                        return Err(bad(format!("frame: {value} is not below {MOST_FRAMES}")));
                    }
                    query.frame = Some(frame);
                }
                "view" => query.window.view = Some(wholes(&key, &value)?),
                "screen" => query.window.screen = Some(wholes(&key, &value)?),
                "step" => query.window.step = Some(whole()?.max(1) as usize),
                "input" => query.input = whole()? as usize,
                "x" => query.pixel[0] = whole()? as usize,
                "y" => query.pixel[1] = whole()? as usize,
                _ => {
                    let control = controls.iter().find(|control| control.key == key);
                    let control = control.ok_or_else(|| {
                        let keys: Vec<&str> = controls.iter().map(|control| control.key).collect();
                        bad(format!("{key:?} cannot be set here")).help(format!("there are {}", keys.join(", ")))
                    })?;
                    let change = control.change(&value)?;
                    match key.split_once('.') {
                        Some(("lens", _)) => query.f_number = value.parse().ok(),
                        Some(("sensor", _)) => query.sensor.push(change),
                        Some(("develop", _)) => query.develop.push(change),
                        Some(_) | None => query.exposure.push(change),
                    }
                }
            }
        }
        Ok(query)
    }
}

/// Integers between commas.
fn wholes<const N: usize>(key: &str, value: &str) -> Result<[usize; N], Failure> {
    let all: Option<Vec<usize>> = value.split(',').map(|part| part.parse::<u32>().ok().map(|n| n as usize)).collect();
    all.and_then(|all| all.try_into().ok()).ok_or_else(|| {
        let words = format!("{key}: {value:?} is not {N} whole numbers with commas between them");
        Failure::new(StatusCode::BAD_REQUEST, words)
    })
}

#[cfg(test)]
mod tests {
    use super::super::controls;
    use super::*;

    fn parse(text: &str) -> Result<Query, String> {
        Query::parse(text, &controls::all()).map_err(|failure| failure.message)
    }

    #[test]
    fn keys_are_those_of_controls() {
        let query =
            parse("plane=raw&frame=3&exposure.time_s=0.02&develop.tone_curve=filmic&sensor.preset=textbook-ccd");
        let query = query.expect("a query");
        assert_eq!((query.plane.as_str(), query.frame, query.input), ("raw", Some(3), 0));
        assert_eq!(query.exposure, ["exposure.time_s=0.02"]);
        assert_eq!(query.develop, ["develop.tone_curve=\"filmic\""]);
        assert_eq!(query.sensor, ["sensor.preset=\"textbook-ccd\""]);
        let stages = parse("exposure.stages_off=read-noise%2Cdark-current").expect("a query");
        assert_eq!(stages.exposure, ["exposure.stages_off=[\"read-noise\", \"dark-current\"]"]);
    }

    #[test]
    fn nothing_else_can_be_set_and_no_file_be_named() {
        for text in [
            "scene.geometry=x",
            "sensor.preset=%2Fetc%2Fpasswd",
            "sensor.preset=..%2Fsensor.toml",
            "output.raw=dng",
            "exposure.time_s=nan",
            "exposure.time_s=1%0A%5Bscene%5D",
            "render.seed=-1",
            "frame=x",
            "exposure.stages_off=read-noise%22%5D",
            "lens.f_number=0%0A",
            "view=0,0,1",
            "view=0,0,1,-1",
            "screen=",
            "plane",
            "%ff=1",
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
        assert!(parse(&"a".repeat(LONGEST + 1)).is_err());
    }
}
