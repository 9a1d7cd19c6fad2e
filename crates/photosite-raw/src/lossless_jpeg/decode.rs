//! Reading lossless JPEG.

use super::huffman::{Reader, Table};
use super::{DHT, EOI, SOF3, SOI, SOS};

/// Header of a frame.
struct Frame {
    precision: u32,
    rows: usize,
    columns: usize,
    /// Identifiers of the components.
    components: Vec<u8>,
}

/// Decodes exactly `count` numbers, row by row, those of the components beside each other. Takes no more memory than
/// they need, and that only where there are bytes enough for them.
pub(crate) fn decode(coded: &[u8], count: usize) -> Result<Vec<u16>, String> {
    let mut from = coded;
    if take(&mut from, 2)? != [0xff, SOI] {
        return Err("it does not begin like a JPEG file".to_owned());
    }
    let mut frame = None;
    let mut tables = [const { None }; 4];
    loop {
        let marker = take(&mut from, 2)?;
        if marker[0] != 0xff {
            return Err("a marker is missing".to_owned());
        }
        let length = usize::from(short(take(&mut from, 2)?)).checked_sub(2).ok_or("a segment has no length")?;
        let parameters = take(&mut from, length)?;
        match marker[1] {
            SOF3 => frame = Some(read_frame(parameters)?),
            DHT => read_tables(parameters, &mut tables)?,
            SOS => {
                let frame = frame.ok_or("a scan has no frame before it")?;
                return read_scan(&frame, &tables, parameters, from, count);
            }
            EOI => return Err("it has no scan".to_owned()),
            0xc0..=0xcf => return Err(format!("process {:#x} of JPEG is not the lossless one", marker[1])),
            0xdd => return Err("restart intervals are not supported".to_owned()),
            // Comments and what applications add.
            _ => {}
        }
    }
}

fn take<'a>(from: &mut &'a [u8], count: usize) -> Result<&'a [u8], String> {
    from.split_off(..count).ok_or_else(|| "it is truncated".to_owned())
}

fn short(bytes: &[u8]) -> u16 {
    bytes.first_chunk().map_or(0, |&pair| u16::from_be_bytes(pair))
}

fn read_frame(mut from: &[u8]) -> Result<Frame, String> {
    let precision = u32::from(take(&mut from, 1)?[0]);
    let rows = usize::from(short(take(&mut from, 2)?));
    let columns = usize::from(short(take(&mut from, 2)?));
    let count = usize::from(take(&mut from, 1)?[0]);
    if !(2..=16).contains(&precision) || rows == 0 || columns == 0 || !(1..=4).contains(&count) {
        return Err(format!("{columns} × {rows} pixels of {count} components of {precision} bits are impossible"));
    }
    let mut components = Vec::new();
    for component in take(&mut from, 3 * count)?.as_chunks::<3>().0 {
        if component[1] != 0x11 {
            return Err("its components differ in size".to_owned());
        }
        components.push(component[0]);
    }
    Ok(Frame { precision, rows, columns, components })
}

fn read_tables(mut from: &[u8], tables: &mut [Option<Reader>; 4]) -> Result<(), String> {
    while !from.is_empty() {
        let id = usize::from(take(&mut from, 1)?[0]);
        let counts: [u8; 16] = take(&mut from, 16)?.try_into().unwrap_or_default();
        let symbols = take(&mut from, counts.iter().map(|&count| usize::from(count)).sum())?.to_vec();
        let table = Reader::new(Table { counts, symbols }).ok_or("a Huffman table is invalid")?;
        *tables.get_mut(id).ok_or("a Huffman table has an invalid number")? = Some(table);
    }
    Ok(())
}

fn read_scan(
    frame: &Frame,
    tables: &[Option<Reader>; 4],
    mut parameters: &[u8],
    coded: &[u8],
    count: usize,
) -> Result<Vec<u16>, String> {
    let components = frame.components.len();
    let row_length = frame.columns * components;
    if row_length * frame.rows != count {
        return Err(format!("it holds {} numbers instead of {count}", row_length * frame.rows));
    }
    // Each takes a bit at least.
    if coded.len() < count / 8 {
        return Err("it is truncated".to_owned());
    }
    if usize::from(take(&mut parameters, 1)?[0]) != components {
        return Err("its components come one after the other".to_owned());
    }
    let mut selected = Vec::new();
    for (selector, id) in take(&mut parameters, 2 * components)?.as_chunks::<2>().0.iter().zip(&frame.components) {
        if selector[0] != *id {
            return Err("its components come in another order".to_owned());
        }
        let table = tables.get(usize::from(selector[1] >> 4)).and_then(Option::as_ref);
        selected.push(table.ok_or("a Huffman table is missing")?);
    }
    let &[predictor, _, transform] = take(&mut parameters, 3)? else { return Err("it is truncated".to_owned()) };
    if transform != 0 {
        return Err("a point transform is not supported".to_owned());
    }
    let predict = predictor_of(predictor).ok_or("its predictor is unknown")?;

    let mut bits = Bits { from: coded, waiting: 0, count: 0, missing: 0 };
    let mut numbers = vec![0u16; count];
    for start in (0..count).step_by(row_length) {
        let (above, rest) = numbers.split_at_mut(start);
        let above = start.checked_sub(row_length).map(|first| &above[first..]);
        let row = &mut rest[..row_length];
        for x in 0..row_length {
            let difference = bits.difference(selected[x % components])?;
            let predicted = match (x.checked_sub(components), above) {
                (Some(left), Some(above)) => predict(row[left].into(), above[x].into(), above[left].into()) as u16,
                (Some(left), None) => row[left],
                (None, Some(above)) => above[x],
                (None, None) => 1 << (frame.precision - 1),
            };
            row[x] = predicted.wrapping_add(difference);
        }
    }
    // Fewer bits are missing than one byte is filled up with, or else numbers were read from beyond the end.
    if bits.missing > bits.count { Err("it is truncated".to_owned()) } else { Ok(numbers) }
}

/// Predictor of a value from those on the left, above, and above on the left (table H.1).
fn predictor_of(predictor: u8) -> Option<fn(i32, i32, i32) -> i32> {
    Some(match predictor {
        1 => |left, _, _| left,
        2 => |_, above, _| above,
        3 => |_, _, corner| corner,
        4 => |left, above, corner| left + above - corner,
        5 => |left, above, corner| left + ((above - corner) >> 1),
        6 => |left, above, corner| above + ((left - corner) >> 1),
        7 => |left, above, _| (left + above) >> 1,
        _ => return None,
    })
}

/// The bits of a scan, up to its end or a marker, and zeros beyond.
struct Bits<'a> {
    from: &'a [u8],
    waiting: u64,
    count: u32,
    /// Number of the waiting and read bits that lie beyond the end of the scan.
    missing: u32,
}

impl Bits<'_> {
    /// Has at least 32 bits waiting.
    #[inline]
    fn fill(&mut self) -> Result<(), String> {
        while self.count <= 56 {
            let byte = match *self.from {
                [0xff, 0x00, ref rest @ ..] => {
                    self.from = rest;
                    0xff
                }
                [] | [0xff, ..] => {
                    self.missing += 8;
                    0
                }
                [byte, ref rest @ ..] => {
                    self.from = rest;
                    byte
                }
            };
            self.waiting = self.waiting << 8 | u64::from(byte);
            self.count += 8;
        }
        if self.missing > 128 { Err("it is truncated".to_owned()) } else { Ok(()) }
    }

    /// The next difference, modulo 2¹⁶.
    #[inline]
    fn difference(&mut self, table: &Reader) -> Result<u16, String> {
        if self.count < 32 {
            self.fill()?;
        }
        let next = (self.waiting >> (self.count - 16)) as u32 & 0xffff;
        let (category, length) = table.find(next).ok_or("a code has no meaning")?;
        self.count -= length;
        if category == 0 || category == 16 {
            return Ok((category << 11) as u16);
        }
        self.count -= category;
        let value = (self.waiting >> self.count) as u32 & ((1 << category) - 1);
        // A first bit of 0 says that it is negative.
        let negative = value >> (category - 1) == 0;
        Ok((value as u16).wrapping_sub(if negative { ((1u32 << category) - 1) as u16 } else { 0 }))
    }
}
