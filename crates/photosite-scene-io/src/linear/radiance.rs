//! Radiance HDR files. Their headers are read here; their scanlines by the image library.

use glam::{DMat3, DVec3};
use image::DynamicImage;

use super::colours::to_srgb;
use super::openexr::converted;
use super::{LinearImage, Mapping};
use crate::decoded::decode;
use photosite_core::Invalid;
use photosite_core::colour::ColourSpace;
use photosite_core::image::{Channel, Planes};

/// Largest header, bytes.
const MAX_HEADER: usize = 1 << 20;

/// Whether the bytes are those of such a file: "#?", and the name of the program that wrote it.
pub fn is_radiance(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

/// Linear light of a file: watts of visible light per steradian and square metre, or relative to that.
///
/// # Errors
///
/// A header or scanlines that cannot be read.
pub fn decode_radiance(bytes: &[u8]) -> Result<LinearImage, Invalid> {
    let bad = |message: String| Invalid::new("", format!("cannot read it as Radiance HDR: {message}"));
    let mut header = Header::default();
    let mut lines = Lines { bytes, at: 0 };
    let mut is_first = true;
    loop {
        let line = lines.next().ok_or_else(|| bad("its header does not end".to_owned()))?;
        if line.is_empty() {
            break;
        }
        if !is_first {
            header.take(&line)?;
        }
        is_first = false;
    }
    let size = lines.next().ok_or_else(|| bad("it ends before its size".to_owned()))?;
    let size = Size::parse(&size).ok_or_else(|| {
        bad(format!("{size:?} is not the size of an image")).help("it is -Y, rows, +X and columns: -Y 512 +X 1024")
    })?;
    let start = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", size.lines, size.of_line);
    let plain = [start.as_bytes(), bytes.get(lines.at..).unwrap_or_default()].concat();
    let decoded = decode(&plain, "its scanlines").map_err(|invalid| {
        Invalid { help: None, ..invalid }.help("write it anew as Radiance HDR (.hdr) or OpenEXR (.exr)")
    })?;
    let DynamicImage::ImageRgb32F(decoded) = decoded else { return Err(bad("it holds no floats".to_owned())) };
    let stored = decoded.as_raw().as_chunks::<3>().0;
    let [width, height] = size.upright();
    let mut planes = [(); 3].map(|()| Vec::with_capacity(width * height));
    for i in 0..width * height {
        let texel = stored.get(size.index([i % width, i / width])).copied().unwrap_or_default();
        for (plane, value) in planes.iter_mut().zip(texel) {
            plane.push(value);
        }
    }
    let to_srgb = header.to_srgb()?;
    let planes = planes.into();
    let planes = if to_srgb == DMat3::IDENTITY { planes } else { converted(planes, |rgb| to_srgb * rgb) };
    let channels = ["R", "G", "B"].into_iter().zip(planes).map(|(name, data)| Channel { name: name.to_owned(), data });
    Ok(LinearImage {
        pixel_aspect: 1.0 / header.pixel_aspect,
        mapping: header.view.map_or(Mapping::Unstated, Mapping::View),
        ..LinearImage::plain(Planes::new(width, height, channels.collect())?)
    })
}

/// Iterator over lines that end with LF or CR LF.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Iterator for Lines<'_> {
    type Item = String;

    fn next(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..MAX_HEADER.min(self.bytes.len()))?;
        let line = rest.split(|&byte| byte == b'\n').next().filter(|line| line.len() < rest.len())?;
        self.at += line.len() + 1;
        Some(String::from_utf8_lossy(line.strip_suffix(b"\r").unwrap_or(line)).into_owned())
    }
}

/// Statements of a header about pixel values.
struct Header {
    /// Factors that pixel values were multiplied by.
    factors: DVec3,
    primaries: Option<[[f64; 2]; 4]>,
    is_xyz: bool,
    /// Height of a pixel over its width.
    pixel_aspect: f64,
    view: Option<String>,
}

impl Default for Header {
    fn default() -> Self {
        Self { factors: DVec3::ONE, primaries: None, is_xyz: false, pixel_aspect: 1.0, view: None }
    }
}

impl Header {
    /// Reads a line. Indented lines belong to images that this one was made of.
    fn take(&mut self, line: &str) -> Result<(), Invalid> {
        let Some((key, value)) = line.split_once('=') else { return Ok(()) };
        let value = value.trim();
        match key.trim_end() {
            "EXPOSURE" => self.factors *= positive::<1>("EXPOSURE", value)?[0],
            "COLORCORR" => self.factors *= DVec3::from_array(positive("COLORCORR", value)?),
            "PIXASPECT" => self.pixel_aspect *= positive::<1>("PIXASPECT", value)?[0],
            "PRIMARIES" => {
                let [rx, ry, gx, gy, bx, by, wx, wy] = numbers("PRIMARIES", value)?;
                self.primaries = Some([[rx, ry], [gx, gy], [bx, by], [wx, wy]]);
            }
            "FORMAT" => match value {
                "32-bit_rle_rgbe" => {}
                "32-bit_rle_xyze" => self.is_xyz = true,
                _ => return Err(refused("FORMAT", value, "32-bit_rle_rgbe or 32-bit_rle_xyze")),
            },
            "GAMMA" if positive("GAMMA", value)? != [1.0] => return Err(refused("GAMMA", value, "linear light")),
            "NCOMP" if positive("NCOMP", value)? != [3.0] => return Err(refused("NCOMP", value, "3 components")),
            "VIEW" => self.view = Some(value.to_owned()),
            _ => {}
        }
        Ok(())
    }

    /// Conversion of the file's values to linear sRGB.
    fn to_srgb(&self) -> Result<DMat3, Invalid> {
        let colours = if self.is_xyz {
            ColourSpace::Srgb.to_xyz().inverse()
        } else {
            let primaries = self.primaries.map(to_srgb);
            primaries.transpose().map_err(|e| Invalid { key: "PRIMARIES".to_owned(), ..e })?.unwrap_or(DMat3::IDENTITY)
        };
        Ok(colours * DMat3::from_diagonal(1.0 / self.factors))
    }
}

fn refused(key: &str, value: &str, wanted: &str) -> Invalid {
    Invalid::new(key, format!("{value:?} is not read")).help(format!("write the image anew as {wanted}"))
}

/// Numbers at the start of a text, without regard to what follows.
fn numbers<const N: usize>(key: &str, text: &str) -> Result<[f64; N], Invalid> {
    let parsed: Vec<f64> = text.split_whitespace().map_while(|word| word.parse().ok()).take(N).collect();
    let wanted = if N == 1 { "a number".to_owned() } else { format!("{N} numbers") };
    parsed.try_into().map_err(|_| Invalid::new(key, format!("must be {wanted}, got {text:?}")))
}

fn positive<const N: usize>(key: &str, text: &str) -> Result<[f64; N], Invalid> {
    let numbers: [f64; N] = numbers(key, text)?;
    if numbers.iter().all(|number| number.is_finite() && *number > 0.0) {
        return Ok(numbers);
    }
    Err(Invalid::new(key, format!("must be above 0, got {text:?}")).help("correct the header, or write the file anew"))
}

/// Size of an image, and the order of its scanlines.
struct Size {
    lines: usize,
    of_line: usize,
    lines_are_rows: bool,
    /// Whether lines follow each other from bottom to top, or from right to left.
    lines_turn: bool,
    /// Whether the texels of a line run from right to left, or from bottom to top.
    texels_turn: bool,
}

impl Size {
    fn parse(text: &str) -> Option<Self> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let [axis, lines, other_axis, of_line] = words[..] else { return None };
        let lines_are_rows = axis.ends_with('Y');
        let turns = |axis: &str| match axis {
            "-Y" | "+X" => Some(false),
            "+Y" | "-X" => Some(true),
            _ => None,
        };
        let (lines_turn, texels_turn) = (turns(axis)?, turns(other_axis)?);
        let size = |word: &str| word.parse().ok().filter(|&size: &usize| size > 0);
        let (lines, of_line) = (size(lines)?, size(of_line)?);
        (lines_are_rows != other_axis.ends_with('Y')).then_some(Self {
            lines,
            of_line,
            lines_are_rows,
            lines_turn,
            texels_turn,
        })
    }

    /// Columns and rows of the upright image.
    fn upright(&self) -> [usize; 2] {
        if self.lines_are_rows { [self.of_line, self.lines] } else { [self.lines, self.of_line] }
    }

    /// Storage index of the texel of a column and row.
    fn index(&self, [x, y]: [usize; 2]) -> usize {
        let (line, texel) = if self.lines_are_rows { (y, x) } else { (x, y) };
        let line = if self.lines_turn { self.lines - 1 - line } else { line };
        let texel = if self.texels_turn { self.of_line - 1 - texel } else { texel };
        line * self.of_line + texel
    }
}
