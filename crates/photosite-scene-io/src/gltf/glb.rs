//! The binary container: a header of 12 bytes, a JSON chunk, at most one chunk of binary data.

use super::document::CONVERT;
use photosite_core::Invalid;

/// First bytes of every binary glTF file.
const MAGIC: &[u8] = b"glTF";
const HEADER_LEN: usize = 12;
const CHUNK_HEADER_LEN: usize = 8;

/// Whether the bytes begin like a binary glTF file.
pub(super) fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Splits a binary glTF file into its JSON text and its binary chunk. Chunks of unknown type are skipped, as the
/// specification (§4.4.3) requires.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Invalid> {
    if bytes.len() < HEADER_LEN {
        return Err(truncated(HEADER_LEN, bytes.len()));
    }
    let version = read_u32(bytes, 4);
    if version != 2 {
        return Err(Invalid::new("", format!("is binary glTF of version {version}")).help(CONVERT));
    }
    let length = read_u32(bytes, 8) as usize;
    if length > bytes.len() {
        return Err(truncated(length, bytes.len()));
    }
    let (mut json, mut binary) = (None, None);
    let mut rest = bytes.get(HEADER_LEN..length).unwrap_or_default();
    while rest.len() >= CHUNK_HEADER_LEN {
        let chunk_length = read_u32(rest, 0) as usize;
        let kind = &rest[4..CHUNK_HEADER_LEN];
        let Some(chunk) = rest[CHUNK_HEADER_LEN..].get(..chunk_length) else {
            let name = String::from_utf8_lossy(kind);
            let found = rest.len() - CHUNK_HEADER_LEN;
            return Err(Invalid::new(
                "",
                format!("the chunk {name:?} should hold {chunk_length} bytes, but only {found} follow"),
            )
            .help("the file is damaged; export or copy it again"));
        };
        if kind == b"JSON" && json.is_none() {
            json = Some(chunk);
        } else if kind == b"BIN\0" && binary.is_none() {
            binary = Some(chunk);
        }
        rest = &rest[CHUNK_HEADER_LEN + chunk_length..];
    }
    match json {
        Some(json) => Ok((json, binary)),
        None => {
            Err(Invalid::new("", "is binary glTF without a JSON chunk").help("the file is damaged; export it again"))
        }
    }
}

fn truncated(expected: usize, found: usize) -> Invalid {
    Invalid::new("", format!("is truncated: it should hold {expected} bytes, but there are {found}"))
        .help("the file is damaged; export or copy it again")
}

/// Little-endian number; the caller has checked that the bytes are there.
fn read_u32(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
