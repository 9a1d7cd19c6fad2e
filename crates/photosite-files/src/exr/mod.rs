//! OpenEXR files of 32-bit float planes with text and number attributes.
//!
//! In and out: [`Planes`], whose channels keep their names. The meaning of names and values is defined by
//! [`electrons`](super::electrons) and [`spectral_exr`](super::spectral_exr), and for images by
//! [`linear`](photosite_scene_io::linear).

mod sorted_header;

use std::collections::HashMap;
use std::io::{self, Seek, Write};
use std::sync::Mutex;

use exr::block::lines::LineRefMut;
use exr::compression::Compression;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, Image, Layer};
use exr::math::RoundingMode;
use exr::meta::attribute::{AttributeValue, Chromaticities, LevelMode, LineOrder, SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::{LayerAttributes, Vec2, WritableImage};

use photosite_core::image::{Channel, Planes};
use photosite_core::output::Sink;

use super::formats::{FileImage, Samples};
use super::image_rows::ImageRows;
use sorted_header::SortedHeader;

pub use photosite_scene_io::exr::{Attribute, ExrImage, channel_names, read_exr, read_exr_file};

/// Pixels of an image from which on several threads compress it.
const MANY_PIXELS: usize = 1 << 16;
/// Plane to be written: its name in the file, and its source of values.
#[derive(Clone)]
pub struct NamedPlane<'a> {
    /// Name of the channel.
    pub name: String,
    /// Image that the channel is a plane of.
    pub of: &'a dyn ImageRows,
    /// Index of the plane in the image.
    pub plane: usize,
}

/// Character of the values, which decides how they are compressed, always without loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Noise, which does not compress; black areas do nevertheless.
    Noisy,
    /// Surfaces and integers, of which neighbours are alike: they take a third or less of the bytes of noise.
    Smooth,
}

/// Writes noisy planes under their own names, as [`write_planes`] does.
pub fn write_exr<W: Write + Seek>(planes: &Planes, attributes: &[(&str, Attribute)], to: W) -> io::Result<()> {
    write_exr_of(Values::Noisy, planes, attributes, to)
}

/// Writes an image of floats with its attributes.
pub(super) fn write_image(image: &FileImage<'_>, to: &mut dyn Sink) -> io::Result<()> {
    let Samples::F32(planes) = &image.samples else { return Err(io::Error::other("EXR files hold floats")) };
    let attributes: Vec<_> = image.colours.attributes.iter().map(|(name, value)| (&name[..], value.clone())).collect();
    write_exr(planes, &attributes, to)
}

/// Writes planes of that character under their own names, as [`write_planes`] does.
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
            Attribute::Other(value) => (**value).clone(),
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
    // Threads for a small image take longer to start than to compress it.
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

/// Plane on its way into a file, row by row.
#[derive(Clone, Copy)]
struct Rows<'a> {
    of: &'a dyn ImageRows,
    plane: usize,
    /// Error of reading rows, which the library has no place for.
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

/// Text as files hold it; a character that is not ASCII becomes a question mark.
fn ascii(text: &str) -> Text {
    text.chars().map(|c| if c.is_ascii() && c != '\0' { c } else { '?' }).collect::<String>().as_str().into()
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
        // Whatever a flipped bit does, it is an error or an image.
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
