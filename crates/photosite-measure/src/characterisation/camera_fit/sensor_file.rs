//! The sensor file of a fitted camera: TOML with the standard error beside each figure.

use std::fmt::Write;

use photosite_core::math::float::rounded;

use super::fit::CameraFit;
use super::measured::Measured;
use super::parameters::{Assumption, Parameter};
use super::sheet::NONLINEARITY;

/// Tables of a sensor file, with the keys of each in the order of its reference.
const TABLES: [&str; 5] = ["", "noise", "defects", "charge", "adc"];
const EFFICIENCY: &str = "quantum_efficiency";

/// Mosaic that the fitted pixels are part of.
#[derive(Clone, Debug, PartialEq)]
pub struct Mosaic {
    /// Colour filter array, as sensor files state it.
    pub cfa: String,
    /// Columns and rows of the sensor.
    pub size: [usize; 2],
    /// Channels with their responses to the light of the flats over that of the fitted pixels.
    pub responses: Vec<(String, f64)>,
}

/// Names of the files of measured patterns, relative to the sensor file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapNames {
    /// Responses, `noise.prnu_map`.
    pub prnu: Option<String>,
    /// Offsets, `noise.dsnu_map`.
    pub dsnu: Option<String>,
    /// Defective pixels, `defects.pixels`.
    pub defects: Option<String>,
}

impl MapNames {
    /// Names of files beside the sensor file of this name without its ending.
    pub fn beside(stem: &str) -> Self {
        Self {
            prnu: Some(format!("{stem}.prnu.npy")),
            dsnu: Some(format!("{stem}.dsnu.npy")),
            defects: Some(format!("{stem}.defects.csv")),
        }
    }

    /// Whether a key stands beside the patterns.
    fn leave(&self, key: &str) -> bool {
        let is_of = |map: &Option<String>, name: &str| map.is_some() && key.starts_with(name);
        !is_of(&self.prnu, "noise.prnu") && !is_of(&self.dsnu, "noise.dsnu") && !is_of(&self.defects, "defects.")
    }

    /// Lines of a table that name files.
    fn lines(&self, table: &str) -> impl Iterator<Item = String> {
        let files = [
            ("noise", "prnu_map", &self.prnu),
            ("noise", "dsnu_map", &self.dsnu),
            ("defects", "pixels", &self.defects),
        ];
        let of_table = files.into_iter().filter(move |(of, ..)| *of == table);
        of_table.filter_map(|(_, key, file)| Some(format!("{key} = {{ file = {:?} }}", file.as_ref()?)))
    }

    /// Names of all files.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        [&self.prnu, &self.dsnu, &self.defects].into_iter().filter_map(|name| name.as_deref())
    }
}

impl CameraFit {
    /// Parameter of a key.
    pub fn parameter(&self, key: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| parameter.key == key)
    }

    /// Text of the sensor file. `source` says where the images come from; `maps` are the names of the files of measured
    /// patterns, which take the place of their standard deviations.
    pub fn sensor_file(&self, source: &str, mosaic: &Mosaic, maps: &MapNames) -> String {
        let [width, height] = mosaic.size;
        let source = escaped(source);
        let mut text = format!("description = \"Twin of a camera, fitted to {source}\"\nsource = \"\"\"\n");
        let _ = writeln!(text, "photosite fit of {source}. After each figure stands its standard error.");
        for not in &self.left_out {
            let _ = writeln!(text, "left out: {}; {}.", not.figure, escaped(&not.reason));
        }
        for note in &self.notes {
            let _ = writeln!(text, "note: {}.", escaped(note));
        }
        let _ =
            writeln!(text, "\"\"\"\nkind = \"cmos\"\nresolution_px = [{width}, {height}]\ncfa = \"{}\"", mosaic.cfa);
        for table in TABLES {
            let lines = self.lines(table, maps);
            if !table.is_empty() && !lines.is_empty() {
                let _ = writeln!(text, "\n[{table}]");
            }
            lines.iter().for_each(|line| {
                let _ = writeln!(text, "{line}");
            });
            if table == "noise" {
                text += &self.text_of_gain_steps(|key| maps.leave(key));
            }
        }
        for (name, response) in &mosaic.responses {
            let _ = writeln!(text, "\n[channels.{name}]\n{}", self.efficiency(mosaic, *response));
        }
        text
    }

    /// Line of a channel's quantum efficiency.
    fn efficiency(&self, mosaic: &Mosaic, response: f64) -> String {
        let is_mosaic = mosaic.responses.len() > 1;
        let of_light = if is_mosaic { ", in the light of the flats" } else { "" };
        if let Some(Parameter { measured, .. }) = self.parameter(EFFICIENCY) {
            let value = measured.times(response);
            let error = rounded(value.standard_error, 2);
            return format!("quantum_efficiency = {:?}  # ± {error}{of_light}", rounded(value.value, 6));
        }
        let greatest = mosaic.responses.iter().map(|(_, r)| *r).fold(f64::MIN_POSITIVE, f64::max);
        let value = rounded(response / greatest, 4);
        let reason = self.assumed.iter().find(|a| a.key == EFFICIENCY).map_or("", |a| &a.reason);
        format!("quantum_efficiency = {value:?}  # assumed{of_light}: {reason}")
    }

    /// Lines of a table but those of channels: what is measured, then what is assumed.
    fn lines(&self, table: &str, maps: &MapNames) -> Vec<String> {
        let mut lines = Vec::new();
        if table == "adc" {
            lines.push(format!("bits = {}", self.bits));
        }
        let of_table = |key: &'static str| match key.rsplit_once('.') {
            Some((of, name)) => (of == table).then_some(name),
            None => (table.is_empty() && key != EFFICIENCY).then_some(key),
        };
        for parameter in self.parameters.iter().filter(|parameter| maps.leave(parameter.key)) {
            let Some(name) = of_table(parameter.key) else { continue };
            let Parameter { unit, measured, .. } = parameter;
            let error = rounded(measured.standard_error, 2);
            if name == "black_level_dn" {
                lines.push(whole_number(name, measured, unit));
                continue;
            }
            // More digits than the error has say nothing.
            let value = rounded(measured.value, 6);
            let value = if parameter.key == NONLINEARITY { format!("[{value:?}]") } else { format!("{value:?}") };
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            lines.push(format!("{name} = {value}  # ± {error}{unit}"));
        }
        lines.extend(maps.lines(table));
        for Assumption { key, value, is_stated, reason } in &self.assumed {
            if let Some(name) = of_table(key) {
                let word = if *is_stated { "" } else { "assumed: " };
                lines.push(format!("{name} = {value}  # {word}{reason}"));
            }
        }
        lines
    }
}

/// Text that TOML reads as it is.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '"' => out += "\\\"",
            '\\' => out += "\\\\",
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Line of a figure that a sensor file has as a whole number, with what was measured beside it.
pub(super) fn whole_number(key: &str, measured: &Measured, unit: &str) -> String {
    let error = rounded(measured.standard_error, 2);
    format!("{key} = {}  # {} ± {error} {unit}", measured.value.round().max(0.0), rounded(measured.value, 7))
}
