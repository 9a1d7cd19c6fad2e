//! Basis Universal images in KTX2 files (KHR_texture_basisu): ETC1S and UASTC, at full resolution.
//!
//! Offsets and sizes of a file are checked here before the decoder sees them.

use basisu::{DecodeFlags, SourceFormat, TargetFormat, Transcoder};

use super::contained::contained;
use crate::decoded::MAX_SIDE;
use photosite_core::{Invalid, memory};
use photosite_transport::texture::{Bitmap, Texels};

const MAGIC: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
const HEADER: usize = 80;
const LEVEL: usize = 24;
/// Number of mip levels of an image of the largest side.
const MOST_LEVELS: u32 = 16;
/// Supercompression scheme Zstandard.
const ZSTANDARD: u32 = 2;
/// Bytes of a block of UASTC.
const BLOCK: u64 = 16;

/// Whether bytes begin like a KTX2 file.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// A decoded image.
pub(super) struct Decoded {
    pub(super) bitmap: Bitmap,
    /// Whether the file declares its colours as sRGB-encoded; `None` where it states nothing.
    pub(super) is_srgb: Option<bool>,
}

/// Decodes a file. `name` is for messages.
pub(super) fn decode(bytes: &[u8], name: String) -> Result<Decoded, Invalid> {
    let bad = |problem: &str| {
        Invalid::new("", format!("cannot decode {name}: {problem}"))
            .help("the image is damaged, or not one of ETC1S and UASTC of Basis Universal; make it again")
    };
    let file = File::check(bytes).map_err(bad)?;
    let [width, height] = file.size;
    memory::check(
        // Decoded, and in the form that it is kept in; unpacked before, a byte a pixel.
        u64::from(width) * u64::from(height) * 9,
        &format!("decoding the {width} × {height} pixels of {name}"),
        "make the image smaller",
    )?;
    if let Some(orientation) = file.text("KTXorientation").filter(|text| !text.starts_with("rd")) {
        return Err(bad(&format!("its rows and columns run as {orientation:?} says, which must be \"rd\"")));
    }
    if let Some(swizzle) = file.text("KTXswizzle").filter(|text| !text.starts_with("rgba")) {
        return Err(bad(&format!("its channels are exchanged as {swizzle:?} says, which must be \"rgba\"")));
    }
    // Nothing of the keys and values is of use to the decoder, which reads beyond damaged ones.
    let mut keyless = bytes.to_vec();
    keyless[56..64].fill(0);
    let decoded = contained(|| {
        let transcoder = Transcoder::new(&keyless).ok()?;
        let is_known = matches!(transcoder.source_format(), SourceFormat::Etc1s | SourceFormat::UastcLdr);
        is_known.then(|| transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).ok()).flatten()
    });
    let decoded = decoded.flatten().ok_or_else(|| bad("it is not an image of ETC1S or UASTC, or damaged"))?;
    let mut texels = decoded.as_chunks::<4>().0.to_vec();
    if file.has_green_for_alpha() {
        texels.iter_mut().for_each(|[_, g, b, a]| (*g, *b, *a) = (*a, 0, u8::MAX));
    }
    let bitmap = Bitmap { name, width: width as usize, height: height as usize, texels: Texels::Rgba8(texels) };
    Ok(Decoded { bitmap, is_srgb: file.is_srgb() })
}

/// A file whose parts are checked to lie within it.
struct File<'a> {
    size: [u32; 2],
    /// Data format descriptor.
    descriptor: &'a [u8],
    /// Key/value data.
    values: &'a [u8],
}

impl<'a> File<'a> {
    fn check(bytes: &'a [u8]) -> Result<Self, &'static str> {
        const SHORT: &str = "the file ends too early";
        if bytes.len() < HEADER + LEVEL {
            return Err(SHORT);
        }
        let [width, height, depth, layers, faces, levels, scheme] =
            [20, 24, 28, 32, 36, 40, 44].map(|at| u32_at(bytes, at));
        if width == 0 || height == 0 {
            return Err("it has no pixels");
        }
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err("it is too large to be decoded");
        }
        if depth != 0 || layers != 0 || faces != 1 {
            return Err("it is not a plain image, but has layers, faces or depth");
        }
        if levels > MOST_LEVELS || bytes.len() < HEADER + LEVEL * levels.max(1) as usize {
            return Err(SHORT);
        }
        let part = |offset: u64, length: u64| {
            let end = usize::try_from(offset.checked_add(length)?).ok()?;
            bytes.get(usize::try_from(offset).ok()?..end)
        };
        let short = |at| u64::from(u32_at(bytes, at));
        let descriptor = part(short(48), short(52)).ok_or(SHORT)?;
        let values = part(short(56), short(60)).ok_or(SHORT)?;
        part(u64_at(bytes, 64), u64_at(bytes, 72)).ok_or(SHORT)?;
        for at in (0..levels.max(1) as usize).map(|level| HEADER + LEVEL * level) {
            part(u64_at(bytes, at), u64_at(bytes, at + 8)).ok_or(SHORT)?;
        }
        let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
        if scheme == ZSTANDARD && u64_at(bytes, HEADER + 16) != blocks * BLOCK {
            return Err("it unpacks to another size than that of its pixels");
        }
        Ok(Self { size: [width, height], descriptor, values })
    }

    /// The value of a key.
    fn text(&self, key: &str) -> Option<String> {
        let mut rest = self.values;
        while let Some((length, after)) = rest.split_first_chunk::<4>() {
            let length = u32::from_le_bytes(*length) as usize;
            let entry = after.get(..length)?;
            if let Some(value) = entry.strip_prefix(key.as_bytes()).and_then(|value| value.strip_prefix(b"\0")) {
                return Some(String::from_utf8_lossy(value).trim_end_matches('\0').to_owned());
            }
            rest = after.get(length.next_multiple_of(4)..)?;
        }
        None
    }

    fn is_srgb(&self) -> Option<bool> {
        // The transfer function: 1 linear, 2 that of sRGB.
        match self.descriptor.get(14)? {
            1 => Some(false),
            2 => Some(true),
            _ => None,
        }
    }

    /// Whether the file has two channels, red and green, the second of which the decoder takes for alpha.
    fn has_green_for_alpha(&self) -> bool {
        const ETC1S: u8 = 163;
        const UASTC: u8 = 166;
        let channel = |sample: usize| self.descriptor.get(31 + 16 * sample).map(|kind| kind & 15);
        match self.descriptor.get(12) {
            Some(&ETC1S) => channel(1) == Some(4),
            Some(&UASTC) => channel(0) == Some(5),
            _ => false,
        }
    }
}

/// Little-endian number; the caller has checked that the bytes are there.
fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}
