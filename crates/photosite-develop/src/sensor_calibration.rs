//! The calibrations of a sensor, each found once: the search takes longer than exposing a small image.
//!
//! In: the spectral responses of the channels. Out: what they mean in A, D65 and D50, with a fingerprint of the
//! responses by which a later exposure knows whether they still hold. Those that were found last are kept, for the next
//! frame of a data set.

use std::sync::{Mutex, PoisonError};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::colour_matrix::calibrations;
use photosite_core::Invalid;
use photosite_core::spectrum::Spectrum;
use photosite_raw::ColourCalibration;

/// The calibrations of a sensor behind a lens, and which sensor that is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensorCalibration {
    /// SHA-256 of the version of photosite and the responses, hexadecimal.
    responses_sha256: String,
    /// One for each of A, D65 and D50.
    lights: Vec<ColourCalibration>,
}

/// Calibrations that were found last, at most [`KEPT`].
static FOUND: Mutex<Vec<SensorCalibration>> = Mutex::new(Vec::new());
/// More than the cameras of most rigs.
const KEPT: usize = 16;

impl SensorCalibration {
    /// Calibration of channels with these responses, as [`camera_colour`](super::camera_colour::camera_colour) takes
    /// them. `stored`, which an earlier run has found, is taken where it is of the same responses; otherwise it is
    /// found anew. `None` for a camera of less than three channels, which sees no colours.
    ///
    /// # Errors
    /// Where the channels do not tell colours apart.
    pub fn of(responses: &[(String, Spectrum)], stored: Option<&Self>) -> Result<Option<Self>, Invalid> {
        if responses.len() < 3 {
            return Ok(None);
        }
        let responses_sha256 = fingerprint(responses);
        let is_same = |found: &&Self| found.responses_sha256 == responses_sha256;
        if let Some(stored) = stored.filter(is_same).filter(|stored| stored.is_complete(responses.len())) {
            return Ok(Some(stored.clone()));
        }
        let found = FOUND.lock().unwrap_or_else(PoisonError::into_inner).iter().find(is_same).cloned();
        if found.is_some() {
            return Ok(found);
        }
        let found = Self { lights: calibrations(responses)?, responses_sha256 };
        let mut all = FOUND.lock().unwrap_or_else(PoisonError::into_inner);
        if all.len() == KEPT {
            all.remove(0);
        }
        all.push(found.clone());
        Ok(Some(found))
    }

    /// Colour calibrations of the channels in each light.
    pub fn lights(&self) -> &[ColourCalibration] {
        &self.lights
    }

    /// Whether a stored calibration has what raw files hold, whatever somebody did to its file.
    fn is_complete(&self, channels: usize) -> bool {
        let is_matrix =
            |matrix: &Vec<[f64; 3]>| matrix.len() == channels && matrix.iter().flatten().all(|v| v.is_finite());
        let is_whole = |light: &ColourCalibration| {
            is_matrix(&light.colour_matrix) && light.forward_matrix.as_ref().is_some_and(is_matrix)
        };
        self.lights.len() == 3 && self.lights.iter().all(is_whole)
    }
}

fn fingerprint(responses: &[(String, Spectrum)]) -> String {
    let mut hash = Sha256::new();
    hash.update(env!("CARGO_PKG_VERSION"));
    for (name, response) in responses {
        hash.update(name);
        response.values().iter().for_each(|value| hash.update(value.to_le_bytes()));
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_sensor::presets;

    fn responses(name: &str) -> Vec<(String, Spectrum)> {
        presets::model(name).expect("a preset").responses()
    }

    #[test]
    fn what_is_stored_holds_for_the_same_sensor_alone() {
        let sensor = responses("generic-cmos-color");
        let found = SensorCalibration::of(&sensor, None).expect("tells colours").expect("of three channels");
        assert_eq!(found.lights(), calibrations(&sensor).expect("tells colours"));
        // Numbers that nobody would find show where they come from.
        let mut stored = found.clone();
        stored.lights[1].colour_matrix[0] = [0.125, 0.25, 0.5];
        assert_eq!(SensorCalibration::of(&sensor, Some(&stored)), Ok(Some(stored.clone())));
        let other = responses("sony-imx249-color");
        let of_other = SensorCalibration::of(&other, Some(&stored)).expect("tells colours").expect("of three channels");
        assert_eq!(of_other.lights(), calibrations(&other).expect("tells colours"));
        // Kept ones are not mixed up with each other.
        assert_eq!(SensorCalibration::of(&sensor, None), Ok(Some(found.clone())));
        stored.lights[0].colour_matrix.pop();
        assert_eq!(SensorCalibration::of(&sensor, Some(&stored)), Ok(Some(found)));
        assert_eq!(SensorCalibration::of(&responses("sony-imx249-mono"), None), Ok(None));
    }

    #[test]
    fn numbers_come_back_from_json_to_the_last_bit() {
        let found = SensorCalibration::of(&responses("generic-cmos-color"), None).expect("tells colours");
        let text = serde_json::to_string(&found).expect("finite");
        assert_eq!(serde_json::from_str::<Option<SensorCalibration>>(&text).expect("read"), found);
    }
}
