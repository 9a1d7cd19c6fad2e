//! Byte stream that is read from the front.

/// Fault of a stream, as the end of a sentence: "the packed bytes …".
pub(super) type Fault = &'static str;

pub(super) const TOO_SHORT: Fault = "end too early";

pub(super) struct Stream<'a>(pub(super) &'a [u8]);

impl<'a> Stream<'a> {
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(TOO_SHORT)?;
        self.0 = rest;
        Ok(taken)
    }

    pub(super) fn byte(&mut self) -> Result<u8, Fault> {
        Ok(self.take(1)?[0])
    }

    /// Reads a number of one to five bytes, seven bits in each, the lowest first; a set bit above them says that more
    /// follow.
    pub(super) fn number(&mut self) -> Result<u32, Fault> {
        let mut number = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err("hold a number of more than five bytes")
    }

    /// Refuses left-over bytes.
    pub(super) fn end(&self) -> Result<(), Fault> {
        if self.0.is_empty() { Ok(()) } else { Err("are more than what they are said to hold") }
    }
}

/// A signed number whose lowest bit is its sign.
pub(super) fn unzigzag(number: u32) -> u32 {
    (number >> 1) ^ (number & 1).wrapping_neg()
}
