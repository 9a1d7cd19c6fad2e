//! Checksums of files that a later run reads again: CRC-32 (ISO 3309), which finds every damage of up to 32 bits in a
//! row, and of others all but one in 4·10⁹.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};

use crc32fast::Hasher;

/// Bytes of the last line of a file that ends with its checksum: "crc32 ", eight digits, line feed.
const LAST_LINE: u64 = 15;

/// Writer that computes the checksum of all bytes written through it.
pub struct Summing<W> {
    to: W,
    sum: Hasher,
}

impl<W: Write> Summing<W> {
    /// Writer to `to` with an empty checksum.
    pub fn new(to: W) -> Self {
        Self { to, sum: Hasher::new() }
    }

    /// Writes a last line with the checksum of all before it, which [`check_last_line`] reads.
    pub fn write_last_line(mut self) -> io::Result<()> {
        let line = last_line(self.sum);
        self.to.write_all(line.as_bytes())
    }
}

impl<W: Write> Write for Summing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.to.write(bytes)?;
        self.sum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

fn digits(sum: Hasher) -> String {
    format!("{:08x}", sum.finalize())
}

fn last_line(sum: Hasher) -> String {
    format!("crc32 {}\n", digits(sum))
}

/// Whether a file ends with the checksum of all bytes before it. Rewinds the file.
pub fn check_last_line(file: &mut File) -> io::Result<bool> {
    let Some(length) = file.seek(SeekFrom::End(0))?.checked_sub(LAST_LINE) else { return Ok(false) };
    file.rewind()?;
    let mut sum = Summing::new(io::sink());
    io::copy(&mut Read::take(&mut *file, length), &mut sum)?;
    let mut line = String::new();
    // A line that is no text is not the right one either.
    let is_text = file.read_to_string(&mut line).is_ok();
    file.rewind()?;
    Ok(is_text && line == last_line(sum.sum))
}

/// Checksum of a file's first bytes, extended as the file grows.
#[derive(Clone, Debug, Default)]
pub struct GrowingSum {
    sum: Hasher,
    length: u64,
}

impl GrowingSum {
    /// Reads on up to that length, which is no less than before; returns the checksum so far.
    pub fn up_to(&mut self, length: u64, file: &mut File) -> io::Result<String> {
        file.seek(SeekFrom::Start(self.length))?;
        let more = length - self.length;
        let mut sum = Summing { to: io::sink(), sum: std::mem::take(&mut self.sum) };
        let read = io::copy(&mut file.take(more), &mut sum)?;
        (self.sum, self.length) = (sum.sum, self.length + read);
        if read < more {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(digits(self.sum.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(bytes: &[u8]) -> File {
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(bytes).expect("written");
        file
    }

    fn checksum(bytes: &[u8]) -> String {
        let mut sum = Hasher::new();
        sum.update(bytes);
        digits(sum)
    }

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        // The check value of CRC-32/ISO-HDLC in R. Williams's catalogue: of the digits 1 to 9.
        assert_eq!(checksum(b"123456789"), "cbf43926");
    }

    #[test]
    fn every_flipped_bit_is_found() {
        let mut whole = Vec::new();
        let mut to = Summing::new(&mut whole);
        to.write_all(b"{\"rows\": 3}\n\x00\x01\x02").expect("written");
        to.write_last_line().expect("written");
        assert!(check_last_line(&mut file(&whole)).expect("read"));
        for bit in 0..whole.len() * 8 {
            let mut damaged = whole.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(!check_last_line(&mut file(&damaged)).expect("read"), "bit {bit}");
        }
        for length in 0..whole.len() {
            assert!(!check_last_line(&mut file(&whole[..length])).expect("read"), "cut to {length}");
        }
    }

    #[test]
    fn the_sum_of_a_file_that_grows_is_that_of_the_whole() {
        let mut growing = GrowingSum::default();
        let mut file = file(b"123456789 and more");
        for length in [0, 4, 4, 9] {
            let found = growing.up_to(length, &mut file).expect("read");
            assert_eq!(found, checksum(&b"123456789"[..length as usize]), "{length}");
        }
        assert!(growing.up_to(99, &mut file).is_err());
    }
}
