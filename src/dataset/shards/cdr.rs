//! CDR, the binary form of ROS 2's messages, little endian: each value is aligned to its size, counted from the end of
//! the header of four bytes.

/// A message that is being written.
pub(super) struct Cdr(Vec<u8>);

/// Representation identifier of plain CDR, little endian, and two bytes of options.
const HEADER: [u8; 4] = [0, 1, 0, 0];

impl Cdr {
    pub(super) fn new() -> Self {
        Self(HEADER.to_vec())
    }

    pub(super) fn finish(self) -> Vec<u8> {
        self.0
    }

    fn aligned<const N: usize>(&mut self, bytes: [u8; N]) -> &mut Self {
        let length = (self.0.len() - HEADER.len()).next_multiple_of(N) + HEADER.len();
        self.0.resize(length, 0);
        self.0.extend(bytes);
        self
    }

    pub(super) fn u8(&mut self, value: u8) -> &mut Self {
        self.aligned([value])
    }

    pub(super) fn u32(&mut self, value: u32) -> &mut Self {
        self.aligned(value.to_le_bytes())
    }

    pub(super) fn f64(&mut self, value: f64) -> &mut Self {
        self.aligned(value.to_le_bytes())
    }

    /// Values one after the other, as arrays of a fixed length are.
    pub(super) fn f64s(&mut self, values: &[f64]) -> &mut Self {
        values.iter().fold(self, |cdr, &value| cdr.f64(value))
    }

    /// With its length.
    pub(super) fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.u32(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
        self.0.extend(bytes);
        self
    }

    pub(super) fn text(&mut self, text: &str) -> &mut Self {
        self.u32(u32::try_from(text.len() + 1).unwrap_or(u32::MAX));
        self.0.extend(text.as_bytes());
        self.0.push(0);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_aligned_after_the_header() {
        let mut cdr = Cdr::new();
        cdr.text("ab").u8(7).f64(1.0).u32(2);
        let bytes = cdr.finish();
        assert_eq!(bytes[..12], [0, 1, 0, 0, 3, 0, 0, 0, b'a', b'b', 0, 7]);
        // The header and 8 bytes are before, which needs no gap.
        assert_eq!(bytes[12..20], 1.0_f64.to_le_bytes());
        assert_eq!(bytes[20..], [2, 0, 0, 0]);
    }

    #[test]
    fn gaps_are_zeros() {
        let mut cdr = Cdr::new();
        cdr.u8(7).f64(1.0);
        assert_eq!(cdr.finish()[4..12], [7, 0, 0, 0, 0, 0, 0, 0]);
    }
}
