//! OpenEXR files: channels as 32-bit floats, placed by the windows of the header, and the header's attributes.
//!
//! Order of lines, tiles, compression and resolution levels never change pixel values. Deep pixels and subsampled
//! channels are refused. Of several parts the first with an image is read; the others are named in a warning.

mod attribute;
#[cfg(test)]
pub(crate) mod made_for_tests;
#[cfg(test)]
mod tests;
mod window;

use std::fmt::Display;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::Path;

use exr::error::Error as ExrError;
use exr::image::{AnyChannel, AnyChannels, FlatSamples, Layer};
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, read};

use crate::linear::colours::are_alike;
use photosite_core::colour::ColourSpace;
use photosite_core::image::{Channel, Planes};
use photosite_core::{Error, Invalid, Result, input, memory};

pub use attribute::{Attribute, not_square};
use window::Window;

/// Largest size of pixels that are read, bytes: a larger one comes from a damaged header, or is no image of ours.
const MAX_BYTES: usize = 16 << 30;
/// Largest ratio of pixel bytes to file bytes: uniform areas are coded by the wavelets of DWA in next to nothing.
const MOST_INFLATION: usize = 1 << 14;
/// Largest number of pixels of a display window that is not stored as a whole.
const MAX_DISPLAYED: usize = 1 << 27;

/// Contents of an EXR file.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrImage {
    /// Channels in the display window, sorted by name as EXR requires.
    pub planes: Planes,
    /// Attributes that are not standard, and standard ones that give pixel values their meaning, sorted by name.
    pub attributes: Vec<(String, Attribute)>,
    /// Warnings of omitted and filled-in parts.
    pub warnings: Vec<String>,
}

impl ExrImage {
    /// The attribute of that name.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find_map(|(n, value)| (n == name).then_some(value))
    }

    /// The text attribute of that name.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.attribute(name).and_then(Attribute::text)
    }

    /// The number attribute of that name.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.attribute(name).and_then(Attribute::number)
    }

    /// Statements of the header about the image's colours, where they are not linear sRGB.
    pub fn stated_of_colours(&self) -> Vec<String> {
        of_colours(&self.attributes).map(|(name, value)| format!("{name} {value}")).collect()
    }

    /// Pixel aspect ratio: width of a pixel over its height.
    pub fn pixel_aspect(&self) -> f64 {
        if let Some(Attribute::PixelAspect(aspect)) = self.attribute("pixelAspectRatio") { *aspect } else { 1.0 }
    }

    /// Image that holds a quantity; an error if any part of it was omitted or filled in.
    pub fn whole(self) -> Result<Self, Invalid> {
        match self.warnings.first() {
            None => Ok(self),
            Some(warning) => Err(Invalid::new("", format!("is not as photosite wrote it: {warning}"))
                .help("give the file as it was written, in one part of which every pixel is stored")),
        }
    }
}

/// Attributes about colours, but for those that say what a file without them says: linear sRGB.
pub fn of_colours(attributes: &[(String, Attribute)]) -> impl Iterator<Item = (&'static str, &Attribute)> {
    let srgb = ColourSpace::Srgb.chromaticities();
    let is_srgb =
        move |value: &Attribute| if let Attribute::Chromaticities(p) = value { are_alike(*p, srgb) } else { false };
    let stated = move |name| attributes.iter().find_map(|(other, value)| (other == name).then_some((name, value)));
    let names = ["chromaticities", "colorInteropID", "acesImageContainerFlag", "whiteLuminance"];
    names.into_iter().filter_map(stated).filter(move |(_, value)| !is_srgb(value))
}

/// Names of the channels of an OpenEXR file, from its header alone.
pub fn channel_names(path: &Path) -> Result<Vec<String>> {
    let file = input::open(path).map_err(|reason| Error::io(path, "read", reason))?;
    let meta =
        MetaData::read_from_buffered(BufReader::new(file), false).map_err(|error| unreadable(&error).in_file(path))?;
    Ok(meta.headers.iter().flat_map(|header| &header.channels.list).map(|channel| channel.name.to_string()).collect())
}

/// Reads a file, as [`read_exr`] does.
pub fn read_exr_file(path: &Path) -> Result<ExrImage> {
    let file = input::open(path).map_err(|reason| Error::io(path, "read", reason))?;
    read_exr(BufReader::new(file)).map_err(|invalid| invalid.in_file(path))
}

/// Reads all channels of a part at full resolution, as 32-bit floats.
pub fn read_exr<R: BufRead + Seek>(mut from: R) -> Result<ExrImage, Invalid> {
    let length = from.seek(SeekFrom::End(0)).and_then(|length| from.rewind().map(|()| length));
    let length = usize::try_from(length.map_err(|e| unreadable(&e))?).unwrap_or(usize::MAX);
    // The sizes in the headers decide how much is allocated, so they are looked at first.
    let headers = MetaData::read_from_buffered(&mut from, false).map_err(|e| refused(&e))?.headers;
    check_sizes(&headers, length)?;
    from.rewind().map_err(|e| unreadable(&e))?;
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let image = reader.from_buffered(from).map_err(|e| refused(&e))?;
    let (mut layers, shared) = (image.layer_data.into_vec(), image.attributes);
    let chosen = layers.iter().position(has_image).unwrap_or(0);
    if chosen >= layers.len() {
        return Err(unreadable(&"it has no parts"));
    }
    let layer = layers.remove(chosen);
    let mut warnings = Vec::new();
    if !layers.is_empty() {
        let of_one = |layer: &PartOfFile| {
            let name = layer.attributes.layer_name.as_ref().map_or("without a name".to_owned(), ToString::to_string);
            let view = layer.attributes.view_name.as_ref().map_or(String::new(), |view| format!(" (view {view})"));
            name + &view
        };
        let others = layers.iter().map(of_one).collect::<Vec<_>>().join(", ");
        warnings.push(format!("of its parts, {} is read, and left out are {others}", of_one(&layer)));
    }
    let attributes = attribute::of_headers(&shared, &layer.attributes);
    let data = Window::of(layer.attributes.layer_position, layer.size);
    // Maps of surroundings fill their data window, whatever is displayed of it.
    let is_map = layer.attributes.environment_map.is_some();
    let display = if is_map { data } else { Window::of(shared.display_window.position, shared.display_window.size) };
    if display != data {
        if display.pixels() > MAX_DISPLAYED {
            return Err(unreadable(&format!("its display window has more than {MAX_DISPLAYED} pixels")));
        }
        let bytes = (display.pixels() * 4 * layer.channel_data.list.len()) as u64;
        memory::check(bytes, "making its display window", "")?;
        warnings.extend(data.compared_with(display).map_err(|problem| Invalid::new("dataWindow", problem))?);
    }
    let mut channels = Vec::new();
    for channel in layer.channel_data.list {
        let name = channel.name.to_string();
        let (values, rounded) = floats(channel.sample_data);
        if rounded > 0 {
            warnings.push(format!(
                "{rounded} whole numbers of its channel {name} are rounded, as 32-bit floats hold those up to 16777216"
            ));
        }
        channels.push(Channel { name, data: data.placed_in(display, values) });
    }
    let planes = Planes::new(display.width, display.height, channels)?;
    Ok(ExrImage { planes, attributes, warnings })
}

type PartOfFile = Layer<AnyChannels<FlatSamples>>;

/// Whether a part has colours or grey.
fn has_image(layer: &PartOfFile) -> bool {
    let is_of_image = |channel: &AnyChannel<FlatSamples>| {
        let name = channel.name.to_string();
        ["R", "X", "Y"].contains(&name.rsplit('.').next().unwrap_or_default())
    };
    layer.channel_data.list.iter().any(is_of_image)
}

fn check_sizes(headers: &[Header], length: usize) -> Result<(), Invalid> {
    let bytes = |header: &Header| {
        let of_pixel = header.channels.bytes_per_pixel.max(4 * header.channels.list.len());
        header.layer_size.0.saturating_mul(header.layer_size.1).saturating_mul(of_pixel)
    };
    let all = headers.iter().map(bytes).fold(0, usize::saturating_add);
    let largest = headers.iter().max_by_key(|header| bytes(header));
    let [width, height] = largest.map_or([0; 2], |header| [header.layer_size.0, header.layer_size.1]);
    if all > MAX_BYTES.min(length.saturating_mul(MOST_INFLATION)) {
        let size = format!("{width} × {height} pixels");
        return Err(unreadable(&format!("its {size} are more than the file can hold, or than fit into memory")));
    }
    memory::check(all as u64, &format!("reading its {width} × {height} pixels"), "make the image smaller")
}

fn unreadable(error: &dyn Display) -> Invalid {
    Invalid::new("", format!("cannot read it as OpenEXR: {error}"))
}

/// Error of the library, with a remedy for files that it does not read.
fn refused(error: &ExrError) -> Invalid {
    let invalid = unreadable(error);
    if let ExrError::NotSupported(_) = error {
        return invalid
            .help("write it anew with one value for each pixel and channel, compressed by ZIP or not at all");
    }
    invalid
}

/// Pixel values as f32, and the number of rounded ones.
fn floats(samples: FlatSamples) -> (Vec<f32>, usize) {
    match samples {
        FlatSamples::F32(values) => (values, 0),
        FlatSamples::F16(values) => (values.into_iter().map(f32::from).collect(), 0),
        FlatSamples::U32(values) => {
            let rounded = values.iter().filter(|&&value| f64::from(value as f32) != f64::from(value)).count();
            (values.into_iter().map(|value| value as f32).collect(), rounded)
        }
    }
}
