//! Settings of an image as they are, by the keys that change them: the values of the page's controls.

use serde_json::{Map, Value, json};

use super::query::F_NUMBER;
use photosite_capture::ExposureTime;
use photosite_develop::DevelopSettings;
use photosite_pipeline::{Light, SensorSettings};
use photosite_sensor::{Exposure, Stage};

/// Settings of lens, sensor and exposure.
pub(super) fn of_exposure(light: &Light, exposure: &Exposure) -> Map<String, Value> {
    let SensorSettings { sensor, exposure: wanted, seed, .. } = light.settings();
    let is_automatic = matches!(wanted.time, ExposureTime::Auto(_));
    let off: Vec<Stage> = Stage::ALL.into_iter().filter(|&stage| !wanted.stages.has(stage)).collect();
    let all = [
        ("exposure.auto", json!(is_automatic)),
        ("exposure.time_s", json!(exposure.time.0)),
        ("exposure.gain_db", json!(exposure.gain.0)),
        ("exposure.digital_gain_db", json!(exposure.digital_gain.0)),
        ("exposure.temperature_c", json!(exposure.temperature.0)),
        ("exposure.stages_off", json!(off)),
        ("render.seed", json!(seed)),
        ("sensor.preset", json!(sensor.name)),
    ];
    let f_number = light.f_number().map(|n| (F_NUMBER, json!(n)));
    all.into_iter().chain(f_number).map(|(key, value)| (key.to_owned(), value)).collect()
}

/// Settings of development.
pub(super) fn of_development(settings: &DevelopSettings) -> Map<String, Value> {
    let all = serde_json::to_value(settings).ok();
    let all = all.and_then(|value| value.as_object().cloned()).unwrap_or_default();
    all.into_iter().map(|(key, value)| (format!("develop.{key}"), value)).collect()
}
