//! OpenEXR files of 32-bit float planes with text and number attributes.
//!
//! In and out: [`Planes`], whose channels keep their names. What the names and numbers of a file mean is said by
//! [`electrons`](super::electrons) and [`spectral_exr`](super::spectral_exr).

mod sorted_header;

use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Mutex;

use exr::block::lines::LineRefMut;
use exr::compression::Compression;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use exr::math::RoundingMode;
use exr::meta::attribute::{AttributeValue, Chromaticities, LevelMode, LineOrder, SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::{LayerAttributes, ReadChannels, ReadLayers, Vec2, WritableImage, read};

use crate::image::{Channel, Planes};
use crate::{Error, Invalid, Result};

use super::picture_rows::PictureRows;
use photosite_core::{input, memory};
use sorted_header::SortedHeader;

/// A value in the header of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// Text.
    Text(String),
    /// A number.
    Number(f64),
    /// CIE x and y of red, green, blue and white: the standard attribute `chromaticities`.
    Chromaticities([[f64; 2]; 4]),
    /// Width of a pixel over its height: the standard attribute `pixelAspectRatio`.
    PixelAspect(f64),
}

/// What an EXR file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrPicture {
    /// The planes, sorted by name as EXR wants it.
    pub planes: Planes,
    /// The attributes that are no standard ones, `chromaticities`, and `pixelAspectRatio` of pixels that are not square,
    /// sorted by name.
    pub attributes: Vec<(String, Attribute)>,
}

impl ExrPicture {
    /// The text attribute of that name.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find_map(|(n, value)| match value {
            Attribute::Text(text) if n == name => Some(&text[..]),
            Attribute::Text(_) | Attribute::Number(_) | Attribute::Chromaticities(_) | Attribute::PixelAspect(_) => {
                None
            }
        })
    }

    /// The number attribute of that name.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.attributes.iter().find_map(|(n, value)| match value {
            Attribute::Number(number) if n == name => Some(*number),
            Attribute::Number(_) | Attribute::Text(_) | Attribute::Chromaticities(_) | Attribute::PixelAspect(_) => {
                None
            }
        })
    }
}

/// Pixels of a picture that several threads compress.
const MANY_PIXELS: usize = 1 << 16;
/// Most bytes of pixels that are read: more is a damaged header, or not a picture of ours.
const MAX_BYTES: usize = 16 << 30;
/// Bytes of pixels for each of a file: those of even areas are coded by the wavelets of DWA in next to nothing.
const MOST_INFLATION: usize = 1 << 14;

/// A plane as it is written: what it is called in the file, and where its values are.
#[derive(Clone)]
pub struct NamedPlane<'a> {
    /// Its name.
    pub name: String,
    /// The picture that it is a plane of.
    pub of: &'a dyn PictureRows,
    /// Its index there.
    pub plane: usize,
}

/// What values are like, which decides how they are compressed, always without loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Noise, which does not compress; black areas do even so.
    Noisy,
    /// Surfaces and numbers, of which neighbours are alike: they take a third or less of what noise does.
    Smooth,
}

/// Writes noisy planes under their own names, as [`write_planes`] does.
pub fn write_exr<W: Write + Seek>(planes: &Planes, attributes: &[(&str, Attribute)], to: W) -> io::Result<()> {
    write_exr_of(Values::Noisy, planes, attributes, to)
}

/// Writes planes of such values under their own names, as [`write_planes`] does.
pub fn write_exr_of<W: Write + Seek>(
    values: Values,
    planes: &Planes,
    attributes: &[(&str, Attribute)],
    to: W,
) -> io::Result<()> {
    let named = |(plane, channel): (usize, &Channel)| NamedPlane { name: channel.name.clone(), of: planes, plane };
    write_planes(values, planes.size(), planes.channels().iter().enumerate().map(named), attributes, to)
}

/// Writes planes of `size` columns and rows, of which there must be at least one, with pixels. The same planes give the
/// same bytes.
pub fn write_planes<'a, W: Write + Seek>(
    values: Values,
    size: [usize; 2],
    planes: impl IntoIterator<Item = NamedPlane<'a>>,
    attributes: &[(&str, Attribute)],
    to: W,
) -> io::Result<()> {
    let [width, height] = size;
    let failure = Mutex::new(None);
    let channel = |plane: NamedPlane<'a>| AnyChannel {
        name: ascii(&plane.name),
        sample_data: Rows { of: plane.of, plane: plane.plane, failure: &failure },
        quantize_linearly: false,
        sampling: Vec2(1, 1),
    };
    let channels = AnyChannels::sort(planes.into_iter().map(channel).collect());
    let (mut chromaticities, mut pixel_aspect) = (None, 1.0);
    let mut other = HashMap::new();
    for (name, value) in attributes {
        let value = match value {
            Attribute::Text(text) => AttributeValue::Text(ascii(text)),
            Attribute::Number(number) => AttributeValue::F64(*number),
            Attribute::Chromaticities(points) => {
                let [red, green, blue, white] = points.map(|[x, y]| Vec2(x as f32, y as f32));
                chromaticities = Some(Chromaticities { red, green, blue, white });
                continue;
            }
            Attribute::PixelAspect(aspect) => {
                pixel_aspect = *aspect as f32;
                continue;
            }
        };
        other.insert(ascii(name), value);
    }
    let software_name = Some(ascii(concat!("photosite ", env!("CARGO_PKG_VERSION"))));
    let header = LayerAttributes { software_name, other, ..LayerAttributes::default() };
    let compression = match values {
        Values::Noisy => Compression::RLE,
        Values::Smooth => Compression::ZIP16,
    };
    // Rows in order, since threads finish in any.
    let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let layer = Layer::new(Vec2(width, height), header, encoding, channels);
    let mut to = SortedHeader::new(to);
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = chromaticities;
    image.attributes.pixel_aspect = pixel_aspect;
    // Threads for a small picture take longer to start than to compress it.
    let written = if width * height < MANY_PIXELS {
        image.write().non_parallel().to_buffered(&mut to)
    } else {
        image.write().to_buffered(&mut to)
    };
    let written = written.map_err(io_error);
    let failure = failure.lock().expect("nobody panics while holding it").take();
    failure.map_or(written, Err)?;
    to.flush()
}

/// A plane on its way into a file, row by row.
#[derive(Clone, Copy)]
struct Rows<'a> {
    of: &'a dyn PictureRows,
    plane: usize,
    /// What went wrong when rows were read, which the library has no place for.
    failure: &'a Mutex<Option<io::Error>>,
}

impl WritableSamples<'_> for Rows<'_> {
    type Writer = Self;

    fn sample_type(&self) -> SampleType {
        SampleType::F32
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&self, _header: &Header) -> Self {
        *self
    }
}

impl SamplesWriter for Rows<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let mut row = vec![0.0; line.location.sample_count];
        if let Err(error) = self.of.read_row(self.plane, line.location.position.y(), &mut row) {
            *self.failure.lock().expect("nobody panics while holding it") = Some(error);
        }
        line.write_samples_from_slice(&row).expect("a row fills its line");
    }
}

/// The names of the channels of an OpenEXR file, of which its head alone is read.
pub fn channel_names(path: &Path) -> Result<Vec<String>> {
    let file = input::open(path).map_err(|reason| Error::io(path, "read", reason))?;
    let meta = exr::meta::MetaData::read_from_buffered(BufReader::new(file), false)
        .map_err(|error| Invalid::new("", format!("cannot read it as OpenEXR: {error}")).in_file(path))?;
    Ok(meta.headers.iter().flat_map(|header| &header.channels.list).map(|channel| channel.name.to_string()).collect())
}

/// Reads a file, as [`read_exr`] does.
pub fn read_exr_file(path: &Path) -> Result<ExrPicture> {
    let file = input::open(path).map_err(|reason| Error::io(path, "read", reason))?;
    read_exr(BufReader::new(file)).map_err(|invalid| invalid.in_file(path))
}

/// Reads all channels of the first layer at full resolution, as 32-bit floats.
pub fn read_exr<R: BufRead + Seek>(mut from: R) -> Result<ExrPicture, Invalid> {
    let unreadable = |error: &dyn std::fmt::Display| Invalid::new("", format!("cannot read it as OpenEXR: {error}"));
    let length = from.seek(SeekFrom::End(0)).and_then(|length| from.rewind().map(|()| length));
    let length = usize::try_from(length.map_err(|e| unreadable(&e))?).unwrap_or(usize::MAX);
    let headers = exr::meta::MetaData::read_from_buffered(&mut from, false).map_err(|e| unreadable(&e))?.headers;
    if let Some(header) = headers.first() {
        let pixels = header.layer_size.0.saturating_mul(header.layer_size.1);
        if pixels.saturating_mul(header.channels.bytes_per_pixel.max(4 * header.channels.list.len()))
            > MAX_BYTES.min(length.saturating_mul(MOST_INFLATION))
        {
            let size = format!("{} × {} pixels", header.layer_size.0, header.layer_size.1);
            return Err(unreadable(&format!("its {size} are more than the file can hold, or than fit into memory")));
        }
    }
    if let Some(header) = headers.first() {
        let [width, height] = [header.layer_size.0, header.layer_size.1];
        let of_pixel = header.channels.bytes_per_pixel.max(4 * header.channels.list.len());
        let bytes = width.saturating_mul(height).saturating_mul(of_pixel) as u64;
        memory::check(bytes, &format!("reading its {width} × {height} pixels"), "")?;
    }
    from.rewind().map_err(|e| unreadable(&e))?;
    let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = reader.from_buffered(from).map_err(|e| unreadable(&e))?;
    let (layer, chromaticities) = (image.layer_data, image.attributes.chromaticities);
    let aspect = f64::from(image.attributes.pixel_aspect);
    let channel = |c: AnyChannel<FlatSamples>| Channel { name: c.name.to_string(), data: floats(c.sample_data) };
    let channels = layer.channel_data.list.into_iter().map(channel).collect();
    let mut attributes: Vec<(String, Attribute)> = layer
        .attributes
        .other
        .into_iter()
        .filter_map(|(name, value)| Some((name.to_string(), attribute(value)?)))
        .collect();
    let chromaticities = chromaticities.map(|Chromaticities { red, green, blue, white }| {
        let points = [red, green, blue, white].map(|Vec2(x, y)| [x, y].map(f64::from));
        ("chromaticities".to_owned(), Attribute::Chromaticities(points))
    });
    attributes.extend(chromaticities);
    if aspect != 1.0 {
        attributes.push(("pixelAspectRatio".to_owned(), Attribute::PixelAspect(aspect)));
    }
    attributes.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(ExrPicture { planes: Planes::new(layer.size.0, layer.size.1, channels)?, attributes })
}

/// Text as files hold it; what is not ASCII becomes a question mark.
fn ascii(text: &str) -> Text {
    text.chars().map(|c| if c.is_ascii() && c != '\0' { c } else { '?' }).collect::<String>().as_str().into()
}

fn floats(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(f32::from).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
    }
}

fn attribute(value: AttributeValue) -> Option<Attribute> {
    if let AttributeValue::Text(text) = value {
        return Some(Attribute::Text(text.to_string()));
    }
    if let AttributeValue::F32(number) = value {
        return Some(Attribute::Number(f64::from(number)));
    }
    if let AttributeValue::F64(number) = value { Some(Attribute::Number(number)) } else { None }
}

fn io_error(error: exr::error::Error) -> io::Error {
    let exr::error::Error::Io(error) = error else { return io::Error::other(error) };
    error
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn planes() -> Planes {
        let plane = |name: &str, scale: f32| Channel {
            name: name.to_owned(),
            data: (0..35 * 21).map(|i| scale * (i as f32 - 300.0)).collect(),
        };
        Planes::new(35, 21, vec![plane("R", 1.0), plane("variance.R", 1e-20), plane("S0.550,0nm", f32::MAX / 1e3)])
            .expect("right sizes")
    }

    fn attributes() -> [(&'static str, Attribute); 4] {
        [
            ("unit", Attribute::Text("e⁻ \0".to_owned())),
            ("time", Attribute::Number(0.01)),
            ("camera", Attribute::Text(String::new())),
            ("another", Attribute::Number(-1.0)),
        ]
    }

    #[test]
    fn planes_and_attributes_come_back_bit_by_bit() {
        let mut file = Vec::new();
        write_exr(&planes(), &attributes(), Cursor::new(&mut file)).expect("written");
        let read = read_exr(Cursor::new(&file)).expect("an EXR file");
        assert_eq!(read.planes.channels().len(), 3);
        for channel in planes().channels() {
            assert_eq!(read.planes.plane(&channel.name), Some(&channel.data[..]), "{}", channel.name);
        }
        let names: Vec<_> = read.attributes.iter().map(|(name, _)| &name[..]).collect();
        assert_eq!(names, ["another", "camera", "time", "unit"]);
        assert_eq!(read.text("unit"), Some("e? ?"));
        assert_eq!(read.text("time"), None);
    }

    #[test]
    fn the_same_planes_give_the_same_bytes() {
        let write = || {
            let mut file = Vec::new();
            write_exr(&planes(), &attributes(), Cursor::new(&mut file)).expect("written");
            file
        };
        let first = write();
        // Each hash map has an order of its own: 4! orders, so ten files would hardly agree by chance.
        assert!((0..10).all(|_| write() == first));
    }

    #[test]
    fn chromaticities_are_those_of_the_standard_attribute() {
        let points = [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]];
        let mut file = Vec::new();
        let attributes = [("chromaticities", Attribute::Chromaticities(points))];
        write_exr(&planes(), &attributes, Cursor::new(&mut file)).expect("written");
        // Name, type and length as the layout of the format has them, then eight floats.
        let head = b"chromaticities\0chromaticities\0\x20\0\0\0";
        let at = file.windows(head.len()).position(|bytes| bytes == head).expect("the attribute") + head.len();
        let floats: Vec<f32> =
            file[at..at + 32].chunks(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        assert_eq!(floats, points.as_flattened().iter().map(|&v| v as f32).collect::<Vec<_>>());
        let found = read_exr(Cursor::new(&file)).expect("readable").attributes;
        let expected = points.map(|point| point.map(|v| f64::from(v as f32)));
        assert_eq!(found, [("chromaticities".to_owned(), Attribute::Chromaticities(expected))]);
    }

    #[test]
    fn damaged_files_are_refused() {
        let mut file = Vec::new();
        write_exr(&planes(), &attributes(), Cursor::new(&mut file)).expect("written");
        for length in [0, 3, 8, 60, 200, file.len() / 2, file.len() - 1] {
            assert!(read_exr(Cursor::new(&file[..length])).is_err(), "cut to {length} bytes");
        }
        assert!(read_exr(Cursor::new(b"not an EXR file at all")).is_err());
        // Whatever a flipped bit does, it is an error or a picture.
        for at in 0..file.len().min(1500) {
            file[at] ^= 1 << (at % 8);
            let _ = read_exr(Cursor::new(&file));
            file[at] ^= 1 << (at % 8);
        }
        // A data window of 2³¹ pixels a side.
        let window = file.windows(10).position(|w| w == b"dataWindow").expect("it has one") + 10 + 1 + 6 + 4;
        file[window + 8..window + 16].copy_from_slice(&[0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f]);
        assert!(read_exr(Cursor::new(&file)).is_err());
    }
}
