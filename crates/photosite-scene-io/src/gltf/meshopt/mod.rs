//! Packed buffer views of EXT_meshopt_compression and KHR_meshopt_compression.
//!
//! The table of the extension and the packed bytes give the bytes of the buffer view. The streams are those of appendix
//! A of the specifications, the filters those of appendix B. Both extensions are the same but for what the KHR one
//! adds: version 1 of attributes, and the filter of colours.
//!
//! The decoders are our own: they are short, and the format is settled. The libraries that have them hold all of
//! meshoptimizer, which takes half a minute to compile.

mod attributes;
mod filters;
mod indices;
mod stream;

use gltf::json::buffer;
use serde::Deserialize;

use photosite_core::{Invalid, memory};

/// Names of the extension, of which a view may have one.
pub(super) const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// Largest ratio of unpacked to packed bytes: a block of 256 identical attributes takes a quarter of a byte for each of
/// their bytes.
const MOST_INFLATION: u64 = 1024;

/// Packing of a buffer view.
pub(super) struct Packed {
    /// Path of the extension in the document.
    pub(super) key: String,
    pub(super) table: Table,
    is_khr: bool,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Table {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    byte_stride: usize,
    count: usize,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct BufferTable {
    fallback: bool,
}

/// Whether a buffer is for readers that do not know the extension.
pub(super) fn is_fallback(buffer: &buffer::Buffer) -> bool {
    let table = |name: &str| buffer.extensions.as_ref().and_then(|e| e.others.get(name));
    NAMES.into_iter().filter_map(table).any(|table| BufferTable::deserialize(table).is_ok_and(|table| table.fallback))
}

/// Whether a view is packed.
pub(super) fn is_packed(view: &buffer::View) -> bool {
    view.extensions.as_ref().is_some_and(|e| NAMES.iter().any(|name| e.others.contains_key(*name)))
}

impl Packed {
    /// Packing of a view, if it is packed. `key` names the view.
    pub(super) fn of_view(view: &buffer::View, key: &str) -> Result<Option<Self>, Invalid> {
        let find = |name| Some((name, view.extensions.as_ref()?.others.get(name)?));
        let Some((name, value)) = NAMES.into_iter().find_map(find) else { return Ok(None) };
        let key = format!("{key}.extensions.{name}");
        let table = Table::deserialize(value).map_err(|source| Invalid::new(&*key, source.to_string()))?;
        Ok(Some(Self { key, table, is_khr: name == NAMES[0] }))
    }

    /// Unpacks the bytes of the view from those that the table names.
    pub(super) fn unpack(&self, view: &buffer::View, packed: &[u8]) -> Result<Vec<u8>, Invalid> {
        let Table { byte_stride: stride, count, mode, filter, .. } = self.table;
        let invalid = |name: &str, message: String| {
            Err(Invalid::new(format!("{}.{name}", self.key), message)
                .help("the file is damaged; export or compress it again"))
        };
        let (strides, is_stride) = match mode {
            Mode::Attributes => ("a multiple of 4 up to 256", stride.is_multiple_of(4) && (4..=256).contains(&stride)),
            Mode::Triangles | Mode::Indices => ("2 or 4", stride == 2 || stride == 4),
        };
        if !is_stride {
            return invalid("byteStride", format!("is {stride}, which must be {strides}"));
        }
        if matches!(mode, Mode::Triangles) && !count.is_multiple_of(3) {
            return invalid("count", format!("is {count}, which is not a multiple of 3"));
        }
        let (known, is_known) = match filter {
            Filter::None => ("", true),
            Filter::Octahedral => ("OCTAHEDRAL needs attributes of 4 or 8 bytes", stride == 4 || stride == 8),
            Filter::Quaternion => ("QUATERNION needs attributes of 8 bytes", stride == 8),
            Filter::Exponential => ("EXPONENTIAL needs attributes", true),
            Filter::Color => {
                ("COLOR needs attributes of 4 or 8 bytes of KHR_meshopt_compression", self.is_khr && stride <= 8)
            }
        };
        if !is_known || filter != Filter::None && !matches!(mode, Mode::Attributes) {
            return invalid("filter", known.to_owned());
        }
        let size = (count as u64).checked_mul(stride as u64);
        if size != Some(view.byte_length.0) || view.byte_stride.is_some_and(|own| own.0 != stride) {
            let message = format!(
                "are {count} of {stride} bytes, which is not what the {} bytes of the view are",
                view.byte_length.0
            );
            return invalid("count", message);
        }
        let size = view.byte_length.0;
        if size > (packed.len() as u64).saturating_mul(MOST_INFLATION) {
            return invalid("byteLength", format!("is {}, which cannot hold {size} bytes", packed.len()));
        }
        memory::check(size, &format!("unpacking {}", self.key), "simplify the scene")?;
        let unpacked = match mode {
            Mode::Attributes => attributes::decode(packed, count, stride, self.is_khr),
            Mode::Triangles => indices::decode_triangles(packed, count).map(|indices| indices::bytes(&indices, stride)),
            Mode::Indices => indices::decode_sequence(packed, count).map(|indices| indices::bytes(&indices, stride)),
        };
        let mut unpacked = unpacked.or_else(|fault| invalid("byteLength", format!("the packed bytes {fault}")))?;
        match (filter, stride) {
            (Filter::None, _) => {}
            (Filter::Octahedral, 4) => filters::octahedral::<i8>(&mut unpacked),
            (Filter::Octahedral, _) => filters::octahedral::<i16>(&mut unpacked),
            (Filter::Quaternion, _) => filters::quaternion(&mut unpacked),
            (Filter::Exponential, _) => filters::exponential(&mut unpacked),
            (Filter::Color, 4) => filters::colour::<u8>(&mut unpacked),
            (Filter::Color, _) => filters::colour::<u16>(&mut unpacked),
        }
        Ok(unpacked)
    }
}
