//! Spectra as text: rows of wavelength (nm) and values.
//!
//! ```text
//! # outside: hold
//! wavelength_nm,value
//! 400,0.31
//! 405,0.33
//! ```
//!
//! A text is parsed into its columns, or into an error with the line at fault. Comments start with `#`; one of the form
//! `# outside: zero`, `# outside: hold` or `# outside: blackbody 6504 K` says what the values are beyond the first and
//! last row, see [`Outside`]. The line of column names may be missing. Columns are separated by commas, semicolons,
//! tabs or blanks. Reading the file, and checking that a reflectance lies within 0–1, is left to the caller.

use std::fmt;
use std::path::Path;

use super::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, Outside, Spectrum};
use crate::{Error, Invalid};

/// A fault in the text of a spectrum, and its line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CsvError {
    /// Line, counted from 1; `None` where the text as a whole is at fault.
    pub line: Option<usize>,
    /// Fault and remedy.
    pub invalid: Invalid,
}

impl CsvError {
    fn at(line: usize, message: impl Into<String>) -> Self {
        Self { line: Some(line), invalid: Invalid::new("", message) }
    }

    fn whole(message: impl Into<String>) -> Self {
        Self { line: None, invalid: Invalid::new("", message) }
    }

    fn help(mut self, help: impl Into<String>) -> Self {
        self.invalid = self.invalid.help(help.into());
        self
    }

    /// The error with the name of the file.
    pub fn in_file(self, path: &Path) -> Error {
        match self.line {
            Some(line) => self.invalid.at_line(path, line),
            None => self.invalid.in_file(path),
        }
    }
}

impl From<CsvError> for Invalid {
    fn from(error: CsvError) -> Self {
        let message = error.to_string();
        Self { message, ..error.invalid }
    }
}

impl fmt::Display for CsvError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}", self.invalid),
            None => self.invalid.fmt(f),
        }
    }
}

impl std::error::Error for CsvError {}

/// Columns of values against wavelength. Wavelengths are finite, above 0 and strictly increasing; values are finite.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralTable {
    lambda_nm: Vec<f64>,
    columns: Vec<Column>,
    outside: Outside,
}

#[derive(Clone, Debug, PartialEq)]
struct Column {
    name: String,
    values: Vec<f64>,
}

impl SpectralTable {
    /// Parses the text of a file; `outside` holds where no comment says otherwise.
    pub fn parse(text: &str, outside: Outside) -> Result<Self, CsvError> {
        let mut table = Self { lambda_nm: Vec::new(), columns: Vec::new(), outside };
        let lines = text.lines().map(str::trim).enumerate();
        for (line, content) in lines.map(|(i, content)| (i + 1, content)) {
            if content.is_empty() {
                continue;
            }
            if let Some(comment) = content.strip_prefix('#') {
                table.read_comment(line, comment)?;
                continue;
            }
            let fields = split(content);
            if table.columns.is_empty() {
                let has_names = fields[0].parse::<f64>().is_err();
                table.start(line, &fields, has_names)?;
                if has_names {
                    continue;
                }
            }
            table.read_row(line, &fields)?;
        }
        table.check_range()?;
        Ok(table)
    }

    /// Comments of the form `key: value`; of these only `outside` matters here.
    fn read_comment(&mut self, line: usize, comment: &str) -> Result<(), CsvError> {
        if let Some((key, value)) = comment.split_once(':')
            && key.trim() == "outside"
        {
            self.outside = match value.trim() {
                "zero" => Outside::Zero,
                "hold" => Outside::Hold,
                other => blackbody(other).ok_or_else(|| {
                    let message = format!("\"outside: {other}\" is neither zero nor hold");
                    let help =
                        "write `# outside: zero` or `# outside: hold`, or `# outside: blackbody 5003 K` of daylight";
                    CsvError::at(line, message).help(help)
                })?,
            };
        }
        Ok(())
    }

    /// Creates the columns from the first line that is no comment.
    fn start(&mut self, line: usize, fields: &[&str], has_names: bool) -> Result<(), CsvError> {
        if fields.len() < 2 {
            let message = format!("\"{}\" is a single column", fields[0]);
            let help = "write rows of a wavelength in nm and a value, as in `550,0.18`";
            return Err(CsvError::at(line, message).help(help));
        }
        let name = |i: usize| match (has_names, fields.len()) {
            (true, _) => fields[i].trim_matches('"').to_owned(),
            (false, 2) => "value".to_owned(),
            (false, _) => format!("column {}", i + 1),
        };
        self.columns = (1..fields.len()).map(|i| Column { name: name(i), values: Vec::new() }).collect();
        Ok(())
    }

    fn read_row(&mut self, line: usize, fields: &[&str]) -> Result<(), CsvError> {
        let wanted = self.columns.len() + 1;
        if fields.len() != wanted {
            let message = format!("{} columns where the lines before have {wanted}", fields.len());
            return Err(CsvError::at(line, message).help("write decimals with a point and separate columns by commas"));
        }
        let number = |field: &str| match field.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            Ok(_) | Err(_) => Err(CsvError::at(line, format!("\"{field}\" is not a finite number"))
                .help("write rows of a wavelength in nm and values, as in `550,0.18`")),
        };
        let lambda = number(fields[0])?;
        if lambda <= 0.0 {
            return Err(CsvError::at(line, format!("wavelength {lambda} nm is not above 0")));
        }
        if let Some(&before) = self.lambda_nm.last()
            && lambda <= before
        {
            let message = format!("wavelength {lambda} nm does not come after {before} nm");
            return Err(CsvError::at(line, message).help("sort the rows by wavelength and remove repeated ones"));
        }
        self.lambda_nm.push(lambda);
        for (column, field) in self.columns.iter_mut().zip(&fields[1..]) {
            column.values.push(number(field)?);
        }
        Ok(())
    }

    fn check_range(&self) -> Result<(), CsvError> {
        let (Some(&first), Some(&last)) = (self.lambda_nm.first(), self.lambda_nm.last()) else {
            let error = CsvError::whole("holds no rows of numbers");
            return Err(error.help("write rows of a wavelength in nm and a value, as in `550,0.18`"));
        };
        if last < f64::from(LAMBDA_MIN_NM) || first > f64::from(LAMBDA_MAX_NM) {
            let message = format!("wavelengths {first}–{last} nm lie outside {LAMBDA_MIN_NM}–{LAMBDA_MAX_NM} nm");
            let help =
                if last < 30.0 { "these look like µm: multiply them by 1000" } else { "give wavelengths in nm" };
            return Err(CsvError::whole(message).help(help));
        }
        Ok(())
    }

    /// Wavelengths of the rows, nm.
    pub fn lambda_nm(&self) -> &[f64] {
        &self.lambda_nm
    }

    /// Names of the columns after the wavelength.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|column| &column.name[..])
    }

    /// Values beyond the first and last row.
    pub fn outside(&self) -> Outside {
        self.outside
    }

    /// The rows of one column.
    pub fn values(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|column| column.name == name).map(|column| &column.values[..])
    }

    /// One column as a spectrum, by name.
    pub fn column(&self, name: &str) -> Result<Spectrum, CsvError> {
        let Some(values) = self.values(name) else {
            let names: Vec<_> = self.names().collect();
            let message = format!("has no column \"{name}\", only {}", names.join(", "));
            return Err(
                CsvError::whole(message).help(format!("name the columns in a first line: wavelength_nm,{name}"))
            );
        };
        Spectrum::from_samples(&self.lambda_nm, values, self.outside)
            .map_err(|invalid| CsvError { line: None, invalid })
    }

    /// The only column after the wavelength, whatever its name.
    pub fn single(&self) -> Result<Spectrum, CsvError> {
        match &self.columns[..] {
            [only] => self.column(&only.name),
            columns => {
                let message = format!("has {} columns of values where one is expected", columns.len());
                Err(CsvError::whole(message).help("keep two columns: wavelength_nm,value"))
            }
        }
    }
}

/// Text of two columns as a spectrum; see [`SpectralTable::parse`].
pub fn parse_spectrum(text: &str, outside: Outside) -> Result<Spectrum, CsvError> {
    SpectralTable::parse(text, outside)?.single()
}

/// Parses `blackbody 6504 K`, of 1000 to 100,000 K.
fn blackbody(text: &str) -> Option<Outside> {
    let kelvin = text.strip_prefix("blackbody ")?.strip_suffix('K')?.trim().parse().ok()?;
    (1000..=100_000).contains(&kelvin).then_some(Outside::Blackbody(kelvin))
}

/// Fields of a row. The first of comma, semicolon and blank that occurs separates; there is at least one field.
fn split(row: &str) -> Vec<&str> {
    match [',', ';'].into_iter().find(|&separator| row.contains(separator)) {
        Some(separator) => row.split(separator).map(str::trim).collect(),
        None => row.split_whitespace().collect(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn header_comments_names_and_rows_are_read() {
        let text = "# title: gold\r\n# outside: zero\r\nwavelength_nm,n,k\r\n400,1.5,1.9\r\n\r\n500 , 1.0, 1.8\r\n";
        let table = SpectralTable::parse(text, Outside::Hold).expect("valid");
        assert_eq!(table.names().collect::<Vec<_>>(), ["n", "k"]);
        assert_eq!(table.lambda_nm(), [400.0, 500.0]);
        assert_eq!(table.values("k"), Some(&[1.9, 1.8][..]));
        assert_eq!(table.outside(), Outside::Zero);
        let k = table.column("k").expect("present");
        assert_eq!([k.eval(450.0), k.eval(399.0)], [1.85, 0.0]);
        assert!(table.column("q").is_err());
        assert!(table.single().is_err());
    }

    #[test]
    fn plain_rows_need_no_header_whatever_separates_them() {
        for text in ["400,1\n500,2", "400;1\n500;2\n", "400\t1\n500\t2", "  400 1\n# a comment\n  500   2e0  "] {
            let spectrum = parse_spectrum(text, Outside::Hold).expect("valid");
            assert_eq!([spectrum.eval(300.0), spectrum.eval(450.0), spectrum.eval(1100.0)], [1.0, 1.5, 2.0], "{text}");
        }
    }

    #[test]
    fn the_wrong_line_is_named() {
        for (text, line, part) in [
            ("wavelength_nm,value\n400,1\n450,x\n", Some(3), "\"x\" is not a finite number"),
            ("400,1\n450,nan\n", Some(2), "not a finite number"),
            ("400,1\n450\n", Some(2), "1 columns"),
            ("400,1\n450,1,2\n", Some(2), "3 columns"),
            ("400,0,5\n", None, "2 columns of values where one is expected"),
            ("400,1\n\n# c\n400,2\n", Some(4), "does not come after 400 nm"),
            ("# outside: never\n400,1", Some(1), "neither zero nor hold"),
            ("# outside: blackbody hot\n400,1", Some(1), "neither zero nor hold"),
            ("# outside: blackbody 0 K\n400,1", Some(1), "neither zero nor hold"),
            ("lambda\n400", Some(1), "single column"),
            ("-5,1\n400,1", Some(1), "not above 0"),
            ("0.4,1\n0.7,2\n", None, "outside 300–1100 nm"),
            ("", None, "no rows"),
            ("wavelength_nm,value\n", None, "no rows"),
        ] {
            let error = parse_spectrum(text, Outside::Hold).expect_err(text);
            assert_eq!(error.line, line, "{text}");
            assert!(error.invalid.message.contains(part), "{error}");
        }
        let error = parse_spectrum("400,1\n400,2", Outside::Hold).expect_err("repeated");
        assert!(Invalid::from(error).message.starts_with("line 2: "));
    }

    proptest! {
        #[test]
        fn no_text_makes_the_parser_panic(text in "[0-9eE.,;\\-# \t\nabn]{0,80}") {
            let _ = parse_spectrum(&text, Outside::Zero);
        }

        #[test]
        fn no_row_of_numbers_makes_the_parser_panic(rows in prop::collection::vec((any::<f64>(), any::<f64>()), 0..5)) {
            let text: String = rows.iter().map(|(l, v)| format!("{l},{v}\n")).collect();
            let _ = parse_spectrum(&text, Outside::Hold);
        }
    }
}
