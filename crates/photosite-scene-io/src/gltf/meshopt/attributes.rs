//! Attribute streams of meshopt (mode 0): the bytes of an element are differences to those of the one before, stored
//! byte by byte in groups of 16.

use super::stream::{Fault, Stream, TOO_SHORT, unzigzag};

/// Number of elements of a group.
const GROUP: usize = 16;

/// Encoding of the deltas of four bytes.
#[derive(Clone, Copy)]
enum Channel {
    /// Differences of bytes.
    Bytes,
    /// Differences of 16-bit numbers.
    Words,
    /// Exclusive or of 32 bits, rotated left by this number of bits.
    Bits(u32),
}

impl Channel {
    fn of_byte(byte: u8) -> Result<Self, Fault> {
        match (byte & 15, byte >> 4) {
            (0, 0) => Ok(Self::Bytes),
            (1, 0) => Ok(Self::Words),
            (2, turn) => Ok(Self::Bits(u32::from(turn))),
            (_, _) => Err("have a channel of an unknown kind"),
        }
    }

    /// Decodes four bytes of an element from those of the one before and their delta.
    fn next(self, previous: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
        match self {
            Self::Bytes => std::array::from_fn(|i| previous[i].wrapping_add(unzigzag(u32::from(delta[i])) as u8)),
            Self::Words => {
                let word = |[low, high]: [u8; 2]| u16::from_le_bytes([low, high]);
                let next = |i: usize| {
                    let delta = unzigzag(u32::from(word([delta[i], delta[i + 1]]))) as u16;
                    word([previous[i], previous[i + 1]]).wrapping_add(delta).to_le_bytes()
                };
                let ([a, b], [c, d]) = (next(0), next(2));
                [a, b, c, d]
            }
            Self::Bits(turn) => {
                (u32::from_le_bytes(previous) ^ u32::from_le_bytes(delta).rotate_right(turn)).to_le_bytes()
            }
        }
    }
}

/// Unpacks `count` elements of `stride` bytes, a multiple of four up to 256.
pub(super) fn decode(packed: &[u8], count: usize, stride: usize, allows_version_1: bool) -> Result<Vec<u8>, Fault> {
    let is_version_1 = match packed.first() {
        Some(0xa0) => false,
        Some(0xa1) if allows_version_1 => true,
        Some(0xa1) => return Err("are of version 1, which KHR_meshopt_compression alone has"),
        Some(_) => return Err("are not attributes"),
        None => return Err(TOO_SHORT),
    };
    // At the end: the element before the first one, and the channels.
    let (tail, least) = if is_version_1 { (stride + stride / 4, 24) } else { (stride, 32) };
    let body = packed.len().checked_sub(1 + tail.max(least)).ok_or(TOO_SHORT)?;
    let (mut previous, channels) = {
        let (element, channels) = packed[packed.len() - tail..].split_at(stride);
        (element.to_vec(), channels.iter().map(|&byte| Channel::of_byte(byte)).collect::<Result<Vec<_>, _>>()?)
    };
    let channels = if is_version_1 { channels } else { vec![Channel::Bytes; stride / 4] };

    let mut stream = Stream(&packed[1..1 + body]);
    let block = (8192 / stride / GROUP * GROUP).min(256);
    // The deltas of each byte of the elements of a block, one byte after the other.
    let mut deltas = vec![0; stride * block];
    let mut unpacked = Vec::with_capacity(count * stride);
    let mut left = count;
    while left > 0 {
        let elements = left.min(block);
        let controls = if is_version_1 { Some(stream.take(stride / 4)?) } else { None };
        for (byte, column) in deltas.chunks_exact_mut(block).enumerate() {
            let widths = match controls.map(|controls| controls[byte / 4] >> (2 * (byte % 4)) & 3) {
                None => [0, 2, 4, 8],
                Some(0) => [0, 1, 2, 4],
                Some(1) => [1, 2, 4, 8],
                Some(2) => {
                    column.fill(0);
                    continue;
                }
                Some(_) => {
                    column[..elements].copy_from_slice(stream.take(elements)?);
                    continue;
                }
            };
            let groups = elements.div_ceil(GROUP);
            let headers = stream.take(groups.div_ceil(4))?;
            for (g, group) in column.as_chunks_mut::<GROUP>().0.iter_mut().take(groups).enumerate() {
                let width = widths[usize::from(headers[g / 4] >> (2 * (g % 4)) & 3)];
                read_group(&mut stream, width, group)?;
            }
        }
        for element in 0..elements {
            for (c, (bytes, channel)) in previous.as_chunks_mut::<4>().0.iter_mut().zip(&channels).enumerate() {
                *bytes = channel.next(*bytes, std::array::from_fn(|i| deltas[(4 * c + i) * block + element]));
            }
            unpacked.extend_from_slice(&previous);
        }
        left -= elements;
    }
    stream.end()?;
    Ok(unpacked)
}

/// Reads deltas of `width` bits. A delta of all ones stands for a byte that follows them all.
fn read_group(stream: &mut Stream<'_>, width: usize, group: &mut [u8; GROUP]) -> Result<(), Fault> {
    match width {
        0 => group.fill(0),
        8 => group.copy_from_slice(stream.take(GROUP)?),
        _ => {
            let bits = stream.take(GROUP * width / 8)?;
            let ones = (1 << width) - 1;
            for (i, delta) in group.iter_mut().enumerate() {
                let place = i * width % 8;
                // Single bits lie from the lowest on, others from the highest.
                let shift = if width == 1 { place } else { 8 - width - place };
                let value = bits[i * width / 8] >> shift & ones;
                *delta = if value == ones { stream.byte()? } else { value };
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_group_of_the_specification_is_read() {
        let packed = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut stream = Stream(&packed);
        let mut group = [0; GROUP];
        read_group(&mut stream, 4, &mut group).expect("whole");
        stream.end().expect("nothing is left");
        let deltas = group.map(|delta| unzigzag(u32::from(delta)) as u8 as i8);
        assert_eq!(deltas, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
    }

    #[test]
    fn channels_undo_what_the_specification_does() {
        let apply =
            |byte, previous: [u8; 4], delta| Channel::of_byte(byte).map(|channel| channel.next(previous, delta));
        // Around the end of a byte, of a word; an exclusive or that was turned left by 8 bits.
        assert_eq!(apply(0, [0, 255, 7, 7], [1, 2, 0, 5]), Ok([255, 0, 7, 4]));
        assert_eq!(apply(1, [0, 0, 255, 255], [1, 0, 2, 0]), Ok([255, 255, 0, 0]));
        assert_eq!(apply(0x82, [1, 2, 3, 4], [0, 0xf0, 0, 0]), Ok([0xf1, 2, 3, 4]));
        assert!(apply(0x10, [0; 4], [0; 4]).is_err() && apply(3, [0; 4], [0; 4]).is_err());
    }
}
