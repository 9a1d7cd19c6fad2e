//! Buffers that strips of an image are developed in.

use photosite_develop::packed::{Demosaicking, PackedDevelopment};
use wgpu::BufferUsages as Usage;

use super::params;
use super::strips::Strip;

/// Strips on a card at once: one is developed while another goes to and fro.
pub(crate) const SLOTS: usize = 2;
/// Bytes of a buffer that is not used, since none may be empty.
const SMALLEST: u64 = 16;

/// Bytes of each buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sizes {
    numbers: u64,
    mosaic: u64,
    planes: u64,
    differences: u64,
    along_row: u64,
    codes: u64,
}

/// Buffers of strips of some size, at most 240 MB: those of a mosaic of colours whose codes have 16 bits.
pub(crate) struct Room {
    sizes: Sizes,
    pub(crate) slots: [Slot; SLOTS],
    pub(crate) mosaic: wgpu::Buffer,
    pub(crate) planes: wgpu::Buffer,
    pub(crate) differences: wgpu::Buffer,
    pub(crate) along_row: wgpu::Buffer,
}

/// Buffers of what goes to and fro.
pub(crate) struct Slot {
    pub(crate) params: wgpu::Buffer,
    /// Raw numbers of a strip, where not all are on the card.
    pub(crate) numbers: wgpu::Buffer,
    pub(crate) codes: wgpu::Buffer,
    /// Codes that come back.
    pub(crate) returned: wgpu::Buffer,
}

/// Bytes of the codes of a strip, in whole words for every four pixels.
pub(crate) fn code_bytes(of: &PackedDevelopment, strip: &Strip) -> u64 {
    let quads = (strip.turned[0] * strip.turned[1]).div_ceil(4);
    (quads * 4 * of.components() * usize::from(of.bits / 8)) as u64
}

impl Sizes {
    /// Bytes that the largest strip needs.
    fn new(of: &PackedDevelopment, strips: &[Strip]) -> Self {
        let most = |bytes: &dyn Fn(&Strip) -> u64| strips.iter().map(bytes).max().unwrap_or(0).max(SMALLEST);
        let pixels = |bytes: usize| most(&|strip: &Strip| (strip.padded[0] * strip.padded[1] * bytes) as u64);
        let [of_mosaic, of_differences, of_directions] = match of.demosaicking {
            Demosaicking::Apart => [0; 3],
            Demosaicking::Bilinear(_) | Demosaicking::Malvar => [4, 0, 0],
            Demosaicking::Menon { .. } => [4, 8, 4],
        };
        Self {
            numbers: most(&|strip| (strip.numbers.len().div_ceil(2) * 4) as u64),
            mosaic: pixels(of_mosaic),
            planes: pixels(4 * of.channels),
            differences: pixels(of_differences),
            along_row: pixels(of_directions),
            codes: most(&|strip| code_bytes(of, strip)),
        }
    }
}

impl Room {
    /// Room for the strips of an image: this one where it has the right size.
    pub(crate) fn fitting(kept: Option<Self>, device: &wgpu::Device, of: &PackedDevelopment, strips: &[Strip]) -> Self {
        let sizes = Sizes::new(of, strips);
        if let Some(room) = kept.filter(|room| room.sizes == sizes) {
            return room;
        }
        let buffer = |size: u64, usage: Usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
        };
        let params = (params::FIELDS.len().next_multiple_of(4) * 4) as u64;
        let slot = |_| Slot {
            params: buffer(params, Usage::UNIFORM | Usage::COPY_DST),
            numbers: buffer(sizes.numbers, Usage::STORAGE | Usage::COPY_DST),
            codes: buffer(sizes.codes, Usage::STORAGE | Usage::COPY_SRC),
            returned: buffer(sizes.codes, Usage::MAP_READ | Usage::COPY_DST),
        };
        Self {
            sizes,
            slots: [0; SLOTS].map(slot),
            mosaic: buffer(sizes.mosaic, Usage::STORAGE),
            planes: buffer(sizes.planes, Usage::STORAGE),
            differences: buffer(sizes.differences, Usage::STORAGE),
            along_row: buffer(sizes.along_row, Usage::STORAGE),
        }
    }
}
