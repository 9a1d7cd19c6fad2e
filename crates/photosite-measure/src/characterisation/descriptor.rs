//! The text file that tells which image of a set was taken of what, as programs that evaluate EMVA 1288 read it.
//!
//! ```text
//! v 4.0                    version of the standard
//! n 12 512 512             bits, columns, rows
//! b 20000000 1234.5        bright images follow: exposure time in ns, photons per pixel
//! i images\bright-01-0.tiff
//! i images\bright-01-1.tiff
//! d 20000000               dark images follow: exposure time in ns
//! ```
//!
//! Lines that begin with `#` and empty lines say nothing, and lines may end as Windows ends them. An exposure time of 0
//! stands for one that is not known, as in sets of one exposure time and light that varies: `b 000.00 000.35`. Two
//! images after a `b` or `d` are a pair for temporal noise, more are a stack for spatial non-uniformity.

use std::fmt;

use photosite_core::Invalid;
use photosite_core::units::Seconds;

/// Descriptor: the statements of a file of image names.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptor {
    /// Bits of the converter.
    pub bits: u32,
    /// Columns of every image.
    pub width: usize,
    /// Rows of every image.
    pub height: usize,
    /// Images taken of the same light, in the order of the file.
    pub series: Vec<Series>,
}

/// Images taken with the same exposure time of the same light.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Exposure time, ns; 0 where it is not known.
    pub exposure_ns: f64,
    /// Light on the pixels.
    pub light: Light,
    /// Paths relative to the descriptor, with `/` between their parts. At least two.
    pub images: Vec<String>,
}

/// The light of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Darkness.
    Dark,
    /// Number of photons on the area of each pixel during the exposure, not negative.
    Bright {
        /// μ_p.
        photons: f64,
    },
}

impl Light {
    /// μ_p, 0 in the dark.
    pub fn photons(self) -> f64 {
        match self {
            Light::Dark => 0.0,
            Light::Bright { photons } => photons,
        }
    }
}

impl Series {
    /// The exposure time.
    pub fn time(&self) -> Seconds {
        Seconds(self.exposure_ns * 1e-9)
    }

    /// Whether the series is a stack of images for spatial non-uniformity.
    pub fn is_stack(&self) -> bool {
        self.images.len() > 2
    }
}

impl Descriptor {
    /// Reads the text. On failure also tells the number of the line, counted from 1.
    pub fn parse(text: &str) -> Result<Self, (usize, Invalid)> {
        let mut found = Self { bits: 0, width: 0, height: 0, series: Vec::new() };
        let mut last_line = 1;
        for (i, line) in text.lines().enumerate().map(|(i, line)| (i, line.trim())) {
            if !line.is_empty() && !line.starts_with('#') {
                last_line = i + 1;
                found.read_line(line).map_err(|invalid| (last_line, invalid))?;
            }
        }
        let too_few = found.series.iter().find(|series| series.images.len() < 2);
        let invalid = match (too_few, found.series.is_empty() || found.bits == 0) {
            (Some(series), _) => {
                let count = series.images.len();
                Invalid::new("i", format!("the exposure time of {} ns has {count} images", series.exposure_ns))
                    .help("list two images after each b or d, or more for spatial non-uniformity")
            }
            (None, true) => Invalid::new("", "the file describes no images").help(
                "it holds lines such as \"n 12 512 512\" (bits, width, height), \"b 1000000 250.0\" (exposure time in \
                 ns, photons) or \"d 1000000\" and \"i image.tiff\"",
            ),
            (None, false) => return Ok(found),
        };
        Err((last_line, invalid))
    }

    fn read_line(&mut self, line: &str) -> Result<(), Invalid> {
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        let is_binary = |c: char| c == char::REPLACEMENT_CHARACTER || c.is_control() && c != '\t';
        if line.contains(is_binary) {
            return Err(Invalid::new("", "is no text, and a descriptor of images is expected here")
                .help("lines begin with v, n, b, d or i, or # for a comment"));
        }
        let wrong = |help: &str| Err(Invalid::new(key, format!("cannot read {line:?}")).help(help));
        // Some programs write decimal commas.
        let numbers: Option<Vec<f64>> =
            rest.split_whitespace().map(|word| word.replace(',', ".").parse().ok()).collect();
        let is_amount = |x: f64| x.is_finite() && x >= 0.0;
        match (key, numbers.as_deref()) {
            ("v", _) => {}
            ("n", Some(&[bits, width, height])) if [bits, width, height].iter().all(|n| (1.0..=1e6).contains(n)) => {
                (self.bits, self.width, self.height) = (bits as u32, width as usize, height as usize);
            }
            ("n", _) => return wrong("write bits, columns and rows: n 12 512 512"),
            ("b", Some(&[exposure_ns, photons])) if is_amount(exposure_ns) && is_amount(photons) => {
                self.series.push(Series { exposure_ns, light: Light::Bright { photons }, images: Vec::new() });
            }
            ("b", _) => {
                return wrong("write exposure time in ns, 0 where it is not known, and photons: b 1000000 250.0");
            }
            ("d", Some(&[exposure_ns])) if is_amount(exposure_ns) => {
                self.series.push(Series { exposure_ns, light: Light::Dark, images: Vec::new() });
            }
            ("d", _) => return wrong("write the exposure time in ns, 0 where it is not known: d 1000000"),
            ("i", _) if !rest.is_empty() => match self.series.last_mut() {
                Some(series) => series.images.push(rest.replace('\\', "/")),
                None => return wrong("first state what it was taken of: b 1000000 250.0 or d 1000000"),
            },
            _ => return wrong("lines begin with v, n, b, d or i, or # for a comment"),
        }
        Ok(())
    }
}

impl fmt::Display for Descriptor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "v 4.0\nn {} {} {}", self.bits, self.width, self.height)?;
        for Series { exposure_ns, light, images } in &self.series {
            match light {
                Light::Dark => writeln!(f, "d {exposure_ns}")?,
                Light::Bright { photons } => writeln!(f, "b {exposure_ns} {photons}")?,
            }
            for image in images {
                // Readers of these files split paths at backslashes.
                writeln!(f, "i {}", image.replace('/', "\\"))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_descriptor_comes_back_as_it_went() {
        let images = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let descriptor = Descriptor {
            bits: 12,
            width: 640,
            height: 480,
            series: vec![
                Series {
                    exposure_ns: 1.5e6,
                    light: Light::Bright { photons: 1234.0625 },
                    images: images(&["images/a 1.tiff", "b.tiff"]),
                },
                Series { exposure_ns: 1.5e6, light: Light::Dark, images: images(&["c.tiff", "d.tiff", "e.tiff"]) },
            ],
        };
        let text = descriptor.to_string();
        assert!(text.contains("\nb 1500000 1234.0625\ni images\\a 1.tiff\n"), "{text}");
        assert_eq!(Descriptor::parse(&text), Ok(descriptor));
    }

    #[test]
    fn descriptors_of_other_programs_are_read() {
        // As Windows writes it, with exposure times that nobody noted.
        let text = "# \u{b5}m of µ\r\n\r\nv 3.0\r\n  \r\nn  12\t640 480\r\nb 000.00 000.35\r\ni images\\a 1.tif\r\ni                     images\\sub\\b.tif \r\n\r\n#d 5\r\nd 0\r\ni c.tif\r\ni d.tif";
        let images = |names: [&str; 2]| names.map(str::to_owned).to_vec();
        let bright = Light::Bright { photons: 0.35 };
        let series = vec![
            Series { exposure_ns: 0.0, light: bright, images: images(["images/a 1.tif", "images/sub/b.tif"]) },
            Series { exposure_ns: 0.0, light: Light::Dark, images: images(["c.tif", "d.tif"]) },
        ];
        assert_eq!(Descriptor::parse(text), Ok(Descriptor { bits: 12, width: 640, height: 480, series }));
    }

    #[test]
    fn what_cannot_be_read_is_refused_with_its_line() {
        let good = "# camera 7\nv 4.0\nn 8 4 4\nb 100 2,5\ni a\ni b\nd 100\ni c\ni d\n";
        assert_eq!(Descriptor::parse(good).expect("good").series[0].light, Light::Bright { photons: 2.5 });
        for (from, to, line, key) in [
            ("n 8 4 4", "n 8 4", 3, "n"),
            ("b 100 2,5", "b 100", 4, "b"),
            ("b 100 2,5", "b 100 -1", 4, "b"),
            ("b 100 2,5", "i a", 4, "i"),
            ("d 100", "d -1", 7, "d"),
            ("d 100", "d inf", 7, "d"),
            ("i c", "x c", 8, "x"),
            ("i d\n", "", 8, "i"),
            ("n 8 4 4", "", 9, ""),
        ] {
            let (found, invalid) = Descriptor::parse(&good.replacen(from, to, 1)).expect_err(to);
            assert_eq!((found, invalid.key.as_str()), (line, key), "{to}: {invalid}");
        }
        assert!(Descriptor::parse("").is_err());
    }
}
