//! A capture as tables that can be saved as a capture file, and rendered from wherever that lies.

use std::path::Path;

use serde_json::Value;

use super::super::tree::overrides;
use super::super::tree::source::CaptureSource;
use super::super::{Capture, StoredCapture, initial_capture};
use super::input::is_scene_file;
use super::relocate::{keys_of, relocate};
use photosite_core::{Invalid, Result};

impl Capture {
    /// The tables of the capture file with its changes: what it says is there as it says it, with absolute paths. Of a
    /// scene file those that stand for it.
    ///
    /// # Errors
    ///
    /// A capture of a scene that is in no file; a scene file that is gone.
    pub fn to_table(&self) -> Result<toml::Table> {
        let origin = self.origin()?;
        // The sensor of a report stands beside its values.
        if origin.source.stored_sensor().is_some() {
            return as_table(keys_of(&self.source, &self.sensor.name, None)?, &self.source);
        }
        let folder = origin.path.parent().unwrap_or(Path::new(""));
        let mut source = if is_scene_file(&origin.path) {
            let initial = initial_capture(origin.source.sandbox(), &origin.path, folder)?;
            CaptureSource::parse(&folder.join("capture.toml"), initial.text)?
        } else {
            origin.source.clone()
        };
        for argument in &origin.overrides {
            overrides::set(&mut source, argument)?;
        }
        let mut keys = source.read_whole()?;
        relocate(&mut keys, folder, None);
        as_table(keys, &source)
    }
}

impl StoredCapture {
    /// Table of all values of the capture, the sensor whole, with absolute paths.
    ///
    /// # Errors
    ///
    /// Values that are no values of a capture file.
    pub fn to_table(&self) -> Result<toml::Table> {
        as_table(keys_of(&self.source, &self.sensor.name, None)?, &self.source)
    }
}

/// Values as tables, without those that are null.
fn as_table(mut keys: Value, source: &CaptureSource) -> Result<toml::Table> {
    leave_out_nothing(&mut keys);
    let unwritable = |reason: toml::ser::Error| source.error(Invalid::new("", format!("cannot be saved: {reason}")));
    toml::Table::try_from(&keys).map_err(unwritable)
}

fn leave_out_nothing(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.retain(|_, value| !value.is_null());
            map.values_mut().for_each(leave_out_nothing);
        }
        Value::Array(items) => items.iter_mut().for_each(leave_out_nothing),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_given_is_kept_and_paths_are_absolute() {
        let text = "[scene]\nenvironment = { illuminant = \"D65\", illuminance_lux = 500 }\n[[scene.spheres]]\nposition_m = [0, 0, 0]\nradius_m = 1\nmaterial = \"red\"\n[materials.red]\ntype = \"diffuse\"\n\
                    reflectance = { file = \"red.csv\" }\n[sensor]\npreset = \"sony-imx249-mono\"\n[exposure]\nauto = true\n";
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("red.csv"), "400,0.1\n700,0.5\n").expect("written");
        let overrides = ["exposure.time_s=0.02", "sensor.resolution_px=[32,24]"].map(str::to_owned);
        let capture = Capture::parse(text, folder.path(), &overrides).expect("a capture");
        let table = capture.to_table().expect("tables");
        assert_eq!(table["sensor"]["preset"].as_str(), Some("sony-imx249-mono"));
        // A time that is given is no automatic one.
        assert_eq!(table["exposure"], toml::Value::Table(toml::toml! { time_s = 0.02 }));
        let file = table["materials"]["red"]["reflectance"]["file"].as_str().expect("a path");
        assert!(Path::new(file).is_absolute() && file.ends_with("red.csv"), "{file}");
        let elsewhere = tempfile::tempdir().expect("a folder");
        let again = Capture::parse(&table.to_string(), elsewhere.path(), &[]).expect("the same capture");
        assert_eq!(again.to_json(elsewhere.path()).expect("keys"), capture.to_json(elsewhere.path()).expect("keys"));
    }
}
