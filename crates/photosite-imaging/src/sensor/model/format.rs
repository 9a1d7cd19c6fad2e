//! Sensor formats by name, after the video tubes whose pictures were of these sizes.

/// Name, width and height in mm. Source: The Imaging Source, "Format", industrial-camera.com/format.htm; sensors that
/// are sold under a name may be a little larger or smaller.
const FORMATS_MM: [(&str, [f64; 2]); 5] =
    [("1", [12.8, 9.6]), ("2/3", [8.8, 6.6]), ("1/2", [6.4, 4.8]), ("1/3", [4.8, 3.6]), ("1/4", [3.2, 2.4])];

/// Width and height of a format, m; its name with or without the sign of inches.
pub(super) fn format_m(name: &str) -> Option<[f64; 2]> {
    let name = name.trim_end_matches(['"', '″']).trim();
    FORMATS_MM.iter().find(|(known, _)| *known == name).map(|(_, size)| size.map(|mm| mm / 1e3))
}

/// The names, for messages.
pub(super) fn names() -> String {
    FORMATS_MM.map(|(name, _)| format!("{name:?}")).join(", ")
}
