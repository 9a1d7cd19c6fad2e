//! `frames.csv`: a table beside images that says what each was taken of.

use std::path::{Path, PathBuf};

use photosite_core::suggest::did_you_mean;
use photosite_core::{Error, Invalid, Result, input};

/// Name of the table in a folder of images.
pub const FRAME_TABLE: &str = "frames.csv";

/// Columns of the table, of which `file` must be there.
const COLUMNS: [&str; 6] = ["file", "kind", "exposure_s", "photons", "gain", "temperature_c"];

/// Kind of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Dark and as short as can be.
    Bias,
    Dark,
    Flat,
}

impl Kind {
    /// Kind of a word, which may end in digits.
    pub(super) fn named(word: &str) -> Option<Self> {
        let lower = word.to_lowercase();
        match lower.trim_end_matches(|c: char| c.is_ascii_digit()) {
            "bias" | "biases" | "offset" | "offsets" | "zero" => Some(Self::Bias),
            "dark" | "darks" | "black" => Some(Self::Dark),
            "flat" | "flats" | "bright" | "light" | "white" => Some(Self::Flat),
            _ => None,
        }
    }
}

/// Row of the table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TableRow {
    pub(super) path: PathBuf,
    pub(super) kind: Option<Kind>,
    pub(super) exposure_s: Option<f64>,
    pub(super) photons: Option<f64>,
    pub(super) gain: Option<String>,
    pub(super) temperature_c: Option<f64>,
}

/// Reads the table of a folder; `None` where there is none. Empty cells say nothing.
pub(super) fn read_table(folder: &Path) -> Result<Option<Vec<TableRow>>> {
    let path = folder.join(FRAME_TABLE);
    if !path.exists() {
        return Ok(None);
    }
    let text = input::read_text(&path, input::TABLE_BYTES).map_err(|reason| Error::io(&path, "read", reason))?;
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let wrong = |line: usize, invalid: Invalid| invalid.at_line(&path, line + 1);
    let Some((head_line, head)) = lines.next() else {
        let help = "its first line names the columns: file,kind,exposure_s";
        return Err(Invalid::new("", "is empty").help(help).in_file(&path));
    };
    let separator = if head.contains(';') { ';' } else { ',' };
    let columns: Vec<&str> = head.split(separator).map(str::trim).collect();
    if let Some(unknown) = columns.iter().find(|column| !COLUMNS.contains(column)) {
        let message = format!("there is no column {unknown:?}{}", did_you_mean(unknown, COLUMNS));
        let invalid = Invalid::new("", message).help(format!("the columns are {}", COLUMNS.join(", ")));
        return Err(wrong(head_line, invalid));
    }
    if !columns.contains(&"file") {
        let invalid =
            Invalid::new("", "has no column \"file\"").help("the first line is, for example, file,kind,exposure_s");
        return Err(wrong(head_line, invalid));
    }
    let row = |(number, line): (usize, &str)| {
        let cells: Vec<&str> = line.split(separator).map(str::trim).collect();
        if cells.len() != columns.len() {
            let message = format!("{} cells in a table of {} columns", cells.len(), columns.len());
            return Err(wrong(number, Invalid::new("", message).help("leave a cell empty where nothing is known")));
        }
        row_of(folder, &columns, &cells).map_err(|invalid| wrong(number, invalid))
    };
    lines.map(row).collect::<Result<_>>().map(Some)
}

fn row_of(folder: &Path, columns: &[&str], cells: &[&str]) -> Result<TableRow, Invalid> {
    let cell = |name: &str| {
        let place = columns.iter().position(|column| *column == name);
        place.map(|i| cells[i]).filter(|text| !text.is_empty())
    };
    let number = |name: &'static str, least: f64, example: &str| {
        let read = |text: &str| {
            text.parse().ok().filter(|x: &f64| x.is_finite() && *x >= least).ok_or_else(|| {
                Invalid::new(name, format!("cannot read {text:?}"))
                    .help(format!("write a number, for example {example}"))
            })
        };
        cell(name).map(read).transpose()
    };
    let file = cell("file").ok_or_else(|| Invalid::new("file", "is empty").help("name an image beside the table"))?;
    let path = folder.join(file.replace('\\', "/"));
    if !path.is_file() {
        let help = "names are relative to the folder of the table";
        return Err(Invalid::new("file", format!("there is no file {file:?}")).help(help));
    }
    let kind = |text: &str| {
        Kind::named(text).ok_or_else(|| {
            Invalid::new("kind", format!("{text:?} is no kind of image")).help("write bias, dark or flat")
        })
    };
    Ok(TableRow {
        kind: cell("kind").map(kind).transpose()?,
        exposure_s: number("exposure_s", 0.0, "0.02")?,
        photons: number("photons", 0.0, "1500.0")?,
        gain: cell("gain").map(str::to_owned),
        temperature_c: number("temperature_c", -273.15, "25.0")?,
        path,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_and_slips_named_with_their_lines() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("a.png"), b"").expect("written");
        let read = |text: &str| {
            std::fs::write(folder.path().join(FRAME_TABLE), text).expect("written");
            read_table(folder.path())
        };
        let rows = read("# camera 7\nfile; kind; exposure_s\na.png; Dark; 0.02\n").expect("read").expect("there");
        assert_eq!((rows[0].kind, rows[0].exposure_s, rows[0].photons), (Some(Kind::Dark), Some(0.02), None));
        for (text, said) in [
            ("", "is empty"),
            ("file,exposure\na.png,1\n", ":1: there is no column \"exposure\""),
            ("kind\nflat\n", ":1: has no column \"file\""),
            ("file,kind\na.png\n", ":2: 1 cells"),
            ("file,kind\na.png,holiday\n", ":2: kind: \"holiday\""),
            ("file,exposure_s\na.png,-1\n", ":2: exposure_s: cannot read"),
            ("file\nb.png\n", ":2: file: there is no file"),
        ] {
            let error = read(text).expect_err(text).to_string();
            assert!(error.contains(said), "{error}");
        }
    }
}
