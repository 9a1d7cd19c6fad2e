//! Sensor formats by name: those in inches after the video tubes whose images were of these sizes, others after the
//! film or the cameras that they are known from.

use photosite_core::Invalid;
use photosite_core::suggest::{did_you_mean, list};

/// A sensor format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Format {
    /// The name that is listed first, then others of the same size; fractions are inches.
    pub names: &'static [&'static str],
    /// Width and height, mm.
    pub size_mm: [f64; 2],
}

/// Sorted by size. Sources: The Imaging Source, "Format", industrial-camera.com/format.htm (1/4 to 1 inch); Wikipedia,
/// "Image sensor format", table of common image sensor formats (others). Sensors that are sold under a name may be a
/// little larger or smaller.
pub const FORMATS: &[Format] = &[
    Format { names: &["1/10"], size_mm: [1.28, 0.96] },
    Format { names: &["1/8"], size_mm: [1.60, 1.20] },
    Format { names: &["1/6"], size_mm: [2.40, 1.80] },
    Format { names: &["1/4"], size_mm: [3.20, 2.40] },
    Format { names: &["1/3.6"], size_mm: [4.00, 3.00] },
    Format { names: &["1/3.2"], size_mm: [4.54, 3.42] },
    Format { names: &["1/3"], size_mm: [4.80, 3.60] },
    Format { names: &["1/2.7"], size_mm: [5.37, 4.04] },
    Format { names: &["1/2.5"], size_mm: [5.76, 4.29] },
    Format { names: &["1/2.3"], size_mm: [6.17, 4.55] },
    Format { names: &["1/2"], size_mm: [6.40, 4.80] },
    Format { names: &["1/1.8"], size_mm: [7.18, 5.32] },
    Format { names: &["1/1.7"], size_mm: [7.60, 5.70] },
    Format { names: &["2/3"], size_mm: [8.80, 6.60] },
    Format { names: &["1/1.2"], size_mm: [10.67, 8.00] },
    Format { names: &["1"], size_mm: [12.80, 9.60] },
    Format { names: &["1-compact", "nikon-cx"], size_mm: [13.20, 8.80] },
    Format { names: &["4/3", "four-thirds", "micro-four-thirds"], size_mm: [17.30, 13.00] },
    Format { names: &["aps-c-canon"], size_mm: [22.30, 14.90] },
    Format { names: &["aps-c", "nikon-dx"], size_mm: [23.60, 15.60] },
    Format { names: &["aps-h"], size_mm: [27.90, 18.60] },
    Format { names: &["full-frame", "35mm", "nikon-fx"], size_mm: [36.00, 24.00] },
    Format { names: &["medium-format-44x33", "44x33"], size_mm: [44.00, 33.00] },
    Format { names: &["medium-format-54x40", "54x40", "645"], size_mm: [54.00, 40.00] },
];

impl Format {
    /// The format of a name, however its inches and spaces are written. The key of errors is `format`.
    pub fn named(name: &str) -> Result<&'static Self, Invalid> {
        let plain = plain(name);
        FORMATS.iter().find(|format| format.names.contains(&&*plain)).ok_or_else(|| {
            let message = format!("there is no sensor format {name:?}{}", did_you_mean(&plain, all_names()));
            let help =
                format!("the known formats are {}; give any other size with pixel_pitch_um", list(&plain, all_names()));
            Invalid::new("format", message).help(help)
        })
    }

    /// Pixel pitch of a sensor with these columns and rows, m.
    pub fn pitch_m(&self, resolution: [u32; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.size_mm[axis] / 1e3 / f64::from(resolution[axis]))
    }

    /// The format whose diagonal is nearest to that of a sensor of this size, m, if it is within a tenth of it.
    pub fn nearest(size_m: [f64; 2]) -> Option<&'static Self> {
        let diagonal = |[width, height]: [f64; 2]| width.hypot(height);
        let ratio = |format: &&Self| (diagonal(format.size_mm) / diagonal(size_m) / 1e3).ln().abs();
        let nearest = FORMATS.iter().min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        nearest.filter(|format| ratio(format) < 1.1f64.ln())
    }
}

fn all_names() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|format| format.names.iter().copied())
}

/// The name without signs of inches, capitals and spaces: "1/3.2″", "1/3.2 inch", "Full Frame", "APS-C (Canon)".
fn plain(name: &str) -> String {
    let lower = name.to_lowercase().replace('×', "x");
    let words = lower.split([' ', '_', '-', '(', ')', '"', '″', '”', '\'']).filter(|word| !word.is_empty());
    words.filter(|word| !["inch", "inches", "in", "type", "mm"].contains(word)).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_however_they_are_written() {
        for (written, size_mm) in [
            ("1/3.2″", [4.54, 3.42]),
            ("1/3.2\"", [4.54, 3.42]),
            ("1/2.3 inch", [6.17, 4.55]),
            ("1/2\'\'", [6.4, 4.8]),
            (" 1 ", [12.8, 9.6]),
            ("4/3\"", [17.3, 13.0]),
            ("Four Thirds", [17.3, 13.0]),
            ("Full Frame", [36.0, 24.0]),
            ("APS-C (Canon)", [22.3, 14.9]),
            ("aps-c", [23.6, 15.6]),
            ("medium_format 44×33 mm", [44.0, 33.0]),
        ] {
            assert_eq!(Format::named(written).expect(written).size_mm, size_mm);
        }
        let Invalid { message, help, .. } = Format::named("full-fram").expect_err("misspelt");
        let help = help.expect("names").to_string();
        assert!(message.contains("did you mean `full-frame`?") && help.contains("1/3.2"), "{message} {help}");
        assert!(Format::named("").is_err());
    }

    #[test]
    fn names_are_plain_and_none_comes_twice() {
        let names: Vec<&str> = all_names().collect();
        for (i, name) in names.iter().enumerate() {
            assert_eq!(plain(name), *name);
            assert!(!names[..i].contains(name), "{name}");
        }
    }

    /// Sony states 13.4 mm and "1/1.2" for the IMX249, 11.0 mm and "2/3" for the IMX250.
    #[test]
    fn sensors_have_the_format_that_their_makers_say() {
        let format =
            |pitch_um: f64, size: [f64; 2]| Format::nearest(size.map(|n| n * pitch_um * 1e-6)).map(|f| f.names[0]);
        assert_eq!(format(5.86, [1936.0, 1216.0]), Some("1/1.2"));
        assert_eq!(format(3.45, [2464.0, 2056.0]), Some("2/3"));
        assert_eq!(format(1.0, [10.0, 10.0]), None);
    }
}
