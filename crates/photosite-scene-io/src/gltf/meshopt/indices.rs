//! Index streams of meshopt (modes 1 and 2): triangles share edges and corners with the last few; other indices are
//! differences to the one before.

use super::stream::{Fault, Stream, TOO_SHORT, unzigzag};

/// Number of entries of both queues of triangles.
const QUEUE: usize = 16;

/// Ring buffer of the last pushed entries.
struct Queue<T> {
    entries: [T; QUEUE],
    pushed: usize,
}

impl<T: Copy + Default> Queue<T> {
    fn new() -> Self {
        Self { entries: [T::default(); QUEUE], pushed: 0 }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.pushed % QUEUE] = entry;
        self.pushed += 1;
    }

    /// Entry by its age; the last pushed is number 0.
    fn get(&self, number: u8) -> Result<T, Fault> {
        let number = usize::from(number);
        if number >= self.pushed {
            return Err("refer to a corner that does not exist yet");
        }
        Ok(self.entries[(self.pushed - 1 - number) % QUEUE])
    }
}

/// State of the decoder of triangles.
struct Corners<'a> {
    /// Numbers that do not fit into the code of a triangle.
    data: Stream<'a>,
    edges: Queue<[u32; 2]>,
    vertices: Queue<u32>,
    /// Next vertex that is new.
    next: u32,
    /// Last vertex that was given by a number.
    last: u32,
}

impl Corners<'_> {
    /// Takes the next new vertex.
    fn fresh(&mut self) -> u32 {
        let vertex = self.next;
        self.next = self.next.wrapping_add(1);
        vertex
    }

    fn moved(&mut self, by: u32) -> u32 {
        self.last = self.last.wrapping_add(by);
        self.last
    }

    fn numbered(&mut self) -> Result<u32, Fault> {
        let by = unzigzag(self.data.number()?);
        Ok(self.moved(by))
    }

    /// Triangle on an edge of an earlier triangle.
    fn on_edge(&mut self, edge: u8, corner: u8) -> Result<[u32; 3], Fault> {
        let [a, b] = self.edges.get(edge)?;
        let c = match corner {
            0 => self.fresh(),
            1..=12 => self.vertices.get(corner)?,
            13 => self.moved(1u32.wrapping_neg()),
            14 => self.moved(1),
            _ => self.numbered()?,
        };
        if !(1..=12).contains(&corner) {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// Triangle whose second and third corner are coded by four bits each.
    fn on_corners(&mut self, a: u32, corners: u8) -> Result<[u32; 3], Fault> {
        let mut corner = |code: u8| match code {
            0 => Ok(self.fresh()),
            15 => self.numbered(),
            _ => self.vertices.get(code - 1),
        };
        let (second, third) = (corners >> 4, corners & 15);
        let (b, c) = (corner(second)?, corner(third)?);
        self.vertices.push(a);
        for (code, vertex) in [(second, b), (third, c)] {
            if matches!(code, 0 | 15) {
                self.vertices.push(vertex);
            }
        }
        [[b, a], [c, b], [a, c]].into_iter().for_each(|edge| self.edges.push(edge));
        Ok([a, b, c])
    }
}

/// Unpacks the indices of triangles; `count` is a multiple of 3.
pub(super) fn decode_triangles(packed: &[u8], count: usize) -> Result<Vec<u32>, Fault> {
    let mut stream = Stream(packed);
    if stream.byte()? != 0xe1 {
        return Err("are not triangles");
    }
    let codes = stream.take(count / 3)?;
    let (data, table) = stream.0.split_last_chunk::<16>().ok_or(TOO_SHORT)?;
    if table[14..] != [0, 0] || table.iter().any(|entry| entry >> 4 == 15 || entry & 15 == 15) {
        return Err("end with a table that is invalid");
    }
    let mut corners = Corners { data: Stream(data), edges: Queue::new(), vertices: Queue::new(), next: 0, last: 0 };
    let mut indices = Vec::with_capacity(count);
    for code in codes {
        indices.extend(match (code >> 4, code & 15) {
            (15, entry @ ..=13) => {
                let a = corners.fresh();
                corners.on_corners(a, table[usize::from(entry)])?
            }
            (15, entry) => {
                let codes = corners.data.byte()?;
                if codes == 0 {
                    corners.next = 0;
                }
                let a = if entry == 14 { corners.fresh() } else { corners.numbered()? };
                corners.on_corners(a, codes)?
            }
            (edge, corner) => corners.on_edge(edge, corner)?,
        });
    }
    corners.data.end()?;
    Ok(indices)
}

/// Unpacks indices of any kind.
pub(super) fn decode_sequence(packed: &[u8], count: usize) -> Result<Vec<u32>, Fault> {
    let (body, _) = packed.split_last_chunk::<4>().ok_or(TOO_SHORT)?;
    let mut stream = Stream(body);
    if stream.byte()? != 0xd1 {
        return Err("are not indices");
    }
    let mut last = [0u32; 2];
    // A byte at least for each.
    let mut indices = Vec::with_capacity(count.min(body.len()));
    for _ in 0..count {
        let number = stream.number()?;
        let last = &mut last[(number & 1) as usize];
        *last = last.wrapping_add(unzigzag(number >> 1));
        indices.push(*last);
    }
    stream.end()?;
    Ok(indices)
}

/// Bytes of indices, 2 or 4 each.
pub(super) fn bytes(indices: &[u32], stride: usize) -> Vec<u8> {
    indices.iter().flat_map(|index| index.to_le_bytes().into_iter().take(stride)).collect()
}
