//! The sensors that ship with the program, by name: the files of `assets/sensors`, whose spectra are those of
//! [`library`].

use toml::{Table, Value};

use photosite_core::Invalid;
use photosite_core::spectrum::{Spectrum, library};

use super::{SensorDescription, SensorModel, SpectrumSource};

/// The preset of captures that name no sensor.
pub const DEFAULT: &str = "generic-cmos-color";

/// Every preset, sorted by name.
const PRESETS: &[(&str, &str)] = &[
    ("andor-zyla-55", include_str!("../assets/sensors/andor-zyla-55.toml")),
    ("automotive-hdr-color", include_str!("../assets/sensors/automotive-hdr-color.toml")),
    ("generic-cmos-color", include_str!("../assets/sensors/generic-cmos-color.toml")),
    ("generic-line-scan", include_str!("../assets/sensors/generic-line-scan.toml")),
    ("generic-stacked-color", include_str!("../assets/sensors/generic-stacked-color.toml")),
    ("generic-three-chip-ccd", include_str!("../assets/sensors/generic-three-chip-ccd.toml")),
    ("onsemi-kai-02170-mono", include_str!("../assets/sensors/onsemi-kai-02170-mono.toml")),
    ("sony-imx249-color", include_str!("../assets/sensors/sony-imx249-color.toml")),
    ("sony-imx249-mono", include_str!("../assets/sensors/sony-imx249-mono.toml")),
    ("sony-imx250-mono", include_str!("../assets/sensors/sony-imx250-mono.toml")),
    ("sony-imx363-color", include_str!("../assets/sensors/sony-imx363-color.toml")),
    ("swissspad2", include_str!("../assets/sensors/swissspad2.toml")),
    ("textbook-ccd", include_str!("../assets/sensors/textbook-ccd.toml")),
];

/// Names of all presets.
pub fn names() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|(name, _)| *name)
}

/// The keys of a preset, so that others can be laid over them before they are read as a [`SensorDescription`]. Its
/// spectra are named as in [`library`], not by file, and so mean the same wherever the table is used.
pub fn table(name: &str) -> Option<Table> {
    let (name, text) = PRESETS.iter().find(|(n, _)| *n == name)?;
    let mut table: Table = text.parse().unwrap_or_else(|error| panic!("assets/sensors/{name}.toml: {error}"));
    table.iter_mut().for_each(|(_, value)| name_library_spectra(value));
    Some(table)
}

/// Sensor model of a preset; `None` for an unknown name.
pub fn model(name: &str) -> Option<SensorModel> {
    // A preset is part of the program, and a test reads every one: what is wrong with it is our own mistake.
    let description: SensorDescription =
        table(name)?.try_into().unwrap_or_else(|error| panic!("assets/sensors/{name}.toml: {error}"));
    let model = SensorModel::new(name, &description, library_spectrum);
    Some(model.unwrap_or_else(|error| panic!("assets/sensors/{name}.toml: {error}")))
}

/// Spectra that need no file: numbers, and names of [`library`].
pub fn library_spectrum(source: &SpectrumSource) -> Result<Spectrum, Invalid> {
    match source {
        SpectrumSource::Number(value) => Ok(Spectrum::constant(*value as f32)),
        SpectrumSource::Name(name) => library::spectrum(name)
            .ok_or_else(|| Invalid::new("", format!("photosite has no spectrum called {name:?}"))),
        SpectrumSource::File(curve) => {
            Err(Invalid::new("file", format!("{:?} does not ship with photosite", curve.file)))
        }
    }
}

/// Folder of the spectra that sensor files name, which is that of the crate below.
const SPECTRA: &str = "../../../photosite-core/assets/spectra/";

/// Turns the path of a file in [`SPECTRA`], `{ file = "…/NAME.csv" }`, into `"NAME"`.
fn name_library_spectra(value: &mut Value) {
    let Some(table) = value.as_table_mut() else { return };
    let name = match table.get("file") {
        Some(Value::String(file)) => file.strip_prefix(SPECTRA).and_then(|file| file.strip_suffix(".csv")),
        Some(_) | None => None,
    };
    match name.map(str::to_owned) {
        Some(name) => *value = Value::String(name),
        None => table.iter_mut().for_each(|(_, value)| name_library_spectra(value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sensor_file_is_a_preset() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sensors");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .expect("the assets are part of the repository")
            .map(|entry| entry.expect("readable").file_name().into_string().expect("plain names"))
            .collect();
        files.sort();
        assert_eq!(files, names().map(|name| format!("{name}.toml")).collect::<Vec<_>>());
    }

    #[test]
    fn every_preset_is_valid_and_says_where_its_numbers_come_from() {
        for name in names() {
            let sensor = model(name).expect("listed");
            assert!(!sensor.description.is_empty() && !sensor.source.is_empty(), "{name}");
            for (channel, response) in sensor.responses() {
                assert!(response.max() > 0.0, "{name}: channel {channel} sees nothing");
            }
        }
        assert!(model(DEFAULT).is_some());
        assert!(model("generic").is_none());
    }

    #[test]
    fn keys_can_be_laid_over_a_preset() {
        let mut table = table(DEFAULT).expect("listed");
        table.insert("resolution_px".to_owned(), Value::Array(vec![Value::Integer(32), Value::Integer(16)]));
        let description: SensorDescription = table.try_into().expect("valid");
        let sensor = SensorModel::new("small", &description, library_spectrum).expect("valid");
        assert_eq!(sensor.resolution, [32, 16]);
        assert_eq!(sensor.responses(), model(DEFAULT).expect("listed").responses());
    }
}
