//! The names of the files in the folder of a render.

/// The file whose presence says that a part of a render was finished here, as
/// [`REPORT`](photosite_capture::report::REPORT) does of a whole one.
pub const PART: &str = "part.json";

/// File name, numbered or not: `raw.dng`, or with a number `raw-0007.dng`.
pub(crate) fn named(stem: &str, number: Option<u32>, extension: &str) -> String {
    number.map_or_else(|| format!("{stem}.{extension}"), |number| format!("{stem}-{number:04}.{extension}"))
}
