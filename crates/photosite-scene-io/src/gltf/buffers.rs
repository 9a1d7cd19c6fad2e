//! Buffers of a document: the binary chunk, files beside the document, data URIs, packed buffer views.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use base64::Engine;
use base64::engine::general_purpose::GeneralPurposeConfig;
use base64::engine::{DecodePaddingMode, GeneralPurpose};
use gltf::json::{Root, buffer};
use percent_encoding::percent_decode_str;

use super::meshopt::{self, Packed};
use photosite_core::input;
use photosite_core::{Invalid, Sandbox};

/// Bytes of all buffers of a document.
#[derive(Debug)]
pub(super) struct Buffers {
    /// Bytes by buffer; `None` for fallbacks of packed buffers, for readers that cannot unpack them.
    data: Vec<Option<Vec<u8>>>,
    /// Unpacked bytes of each packed buffer view that was used.
    unpacked: Vec<OnceLock<Result<Vec<u8>, Invalid>>>,
}

impl Buffers {
    /// Loads every buffer. `chunk` is the binary chunk of a GLB file; URIs are relative to `place`.
    pub(super) fn load(root: &Root, chunk: Option<&[u8]>, place: FileLocation<'_>) -> Result<Self, Invalid> {
        let mut data = Vec::with_capacity(root.buffers.len());
        for (i, buffer) in root.buffers.iter().enumerate() {
            let key = format!("buffers[{i}]");
            let has_bytes = buffer.uri.is_some() || i == 0 && chunk.is_some();
            if meshopt::is_fallback(buffer) || !has_bytes && is_packed_elsewhere(root, i) {
                data.push(None);
                continue;
            }
            let mut bytes = match (&buffer.uri, chunk) {
                (Some(uri), _) => read_uri(uri, place).map_err(|e| e.within(&format!("{key}.uri")))?,
                (None, Some(chunk)) if i == 0 => chunk.to_vec(),
                (None, _) => {
                    return Err(Invalid::new(key, "has no uri, and there is no binary chunk that could stand for it")
                        .help("the file is damaged; export it again"));
                }
            };
            let expected = usize::try_from(buffer.byte_length.0).unwrap_or(usize::MAX);
            if bytes.len() < expected {
                let message = format!("should be {expected} bytes long, but only {} are there", bytes.len());
                return Err(Invalid::new(format!("{key}.byteLength"), message).help(
                    "the file that holds the buffer is truncated or belongs to another scene; export both again",
                ));
            }
            // A binary chunk is padded to a multiple of four bytes.
            bytes.truncate(expected);
            data.push(Some(bytes));
        }
        let unpacked = root.buffer_views.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { data, unpacked })
    }

    /// The bytes of a buffer view, checked. `key` names what refers to the view.
    pub(super) fn view<'a>(
        &'a self,
        root: &'a Root,
        index: usize,
        key: &str,
    ) -> Result<(&'a [u8], &'a buffer::View), Invalid> {
        let view = root
            .buffer_views
            .get(index)
            .ok_or_else(|| out_of_range(key, "bufferViews", index, root.buffer_views.len()))?;
        let view_key = format!("bufferViews[{index}]");
        let bytes = match Packed::of_view(view, &view_key)? {
            Some(packed) => self.unpacked[index]
                .get_or_init(|| {
                    let table = &packed.table;
                    packed.unpack(view, self.bytes(table.buffer, table.byte_offset, table.byte_length, &packed.key)?)
                })
                .as_deref()
                .map_err(Invalid::clone)?,
            None => {
                let offset = view.byte_offset.map_or(0, |o| o.0);
                self.bytes(view.buffer.value(), offset, view.byte_length.0, &view_key)?
            }
        };
        Ok((bytes, view))
    }

    /// Slice of a buffer. `key` names what refers to it.
    fn bytes(&self, index: usize, offset: u64, length: u64, key: &str) -> Result<&[u8], Invalid> {
        let buffer_key = format!("{key}.buffer");
        let buffer =
            self.data.get(index).ok_or_else(|| out_of_range(&buffer_key, "buffers", index, self.data.len()))?;
        let buffer = buffer.as_deref().ok_or_else(|| {
            Invalid::new(buffer_key, format!("refers to buffers[{index}], which has no bytes of its own"))
                .help("the file is damaged; export or compress it again")
        })?;
        let range =
            offset.checked_add(length).and_then(|end| Some(usize::try_from(offset).ok()?..usize::try_from(end).ok()?));
        range.and_then(|range| buffer.get(range)).ok_or_else(|| {
            let message = format!(
                "{length} bytes from byte {offset} reach beyond the {} bytes of buffers[{index}]",
                buffer.len()
            );
            Invalid::new(key, message)
        })
    }
}

/// Whether all views of a buffer are packed, with their bytes in other buffers.
fn is_packed_elsewhere(root: &Root, buffer: usize) -> bool {
    let mut views = root.buffer_views.iter().filter(|view| view.buffer.value() == buffer).peekable();
    views.peek().is_some() && views.all(meshopt::is_packed)
}

/// Error of an index that is out of range.
pub(super) fn out_of_range(key: &str, array: &str, index: usize, len: usize) -> Invalid {
    Invalid::new(key, format!("refers to {array}[{index}], but the file has {len} of them (counted from 0)"))
        .help("the file is damaged; correct the number, or export it again")
}

/// Location of the files that a document names.
#[derive(Clone, Copy, Debug)]
pub(super) struct FileLocation<'a> {
    /// Folder that URIs are relative to.
    pub(super) folder: &'a Path,
    /// Sandbox that URIs may not lead out of.
    pub(super) sandbox: Option<&'a Sandbox>,
}

/// Refuses a URI that leads out of the sandbox.
pub(super) fn check_uri(uri: Option<&str>, place: FileLocation<'_>) -> Result<(), Invalid> {
    let path = uri.and_then(|uri| path_of(uri, place.folder));
    path.map_or(Ok(()), |path| place.sandbox.map_or(Ok(()), |sandbox| sandbox.check(&path)))
}

/// Reads the content of a URI: a data URI, or a percent-encoded relative path.
pub(super) fn read_uri(uri: &str, place: FileLocation<'_>) -> Result<Vec<u8>, Invalid> {
    if let Some(rest) = uri.strip_prefix("data:") {
        return decode_data_uri(rest);
    }
    let path = place.folder.join(&*decoded_path(uri)?);
    place.sandbox.map_or(Ok(()), |sandbox| sandbox.check(&path))?;
    input::read(&path).map_err(|source| {
        Invalid::new("", format!("cannot read {}: {source}", path.display()))
            .help("put the file there, or export the scene with its data embedded (.glb)")
    })
}

/// File that a URI names; `None` for a data URI.
pub(super) fn path_of(uri: &str, folder: &Path) -> Option<PathBuf> {
    if uri.starts_with("data:") { None } else { decoded_path(uri).ok().map(|path| folder.join(&*path)) }
}

/// Relative path that a URI names.
fn decoded_path(uri: &str) -> Result<Cow<'_, str>, Invalid> {
    // A single letter before the colon is a drive, not a scheme.
    if let Some((scheme, _)) = uri.split_once(':')
        && scheme.len() > 1
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    {
        return Err(Invalid::new("", format!("has the scheme {scheme:?}"))
            .help("only relative file names and data URIs can be read; download the file and refer to it by name"));
    }
    percent_decode_str(uri).decode_utf8().map_err(|_| Invalid::new("", format!("{uri:?} is not percent-encoded UTF-8")))
}

/// Decodes what follows `data:`, `[media type][;base64],payload`.
fn decode_data_uri(rest: &str) -> Result<Vec<u8>, Invalid> {
    // Real files come with and without padding.
    const BASE64: GeneralPurpose = GeneralPurpose::new(
        &base64::alphabet::STANDARD,
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
    );
    let (header, payload) =
        rest.split_once(',').ok_or_else(|| Invalid::new("", "is a data URI without a comma, so without data"))?;
    let bytes: Cow<'_, [u8]> = percent_decode_str(payload).into();
    if header.ends_with(";base64") {
        BASE64.decode(&bytes).map_err(|source| Invalid::new("", format!("is a data URI of invalid base64: {source}")))
    } else {
        Ok(bytes.into_owned())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn place(folder: &Path) -> FileLocation<'_> {
        FileLocation { folder, sandbox: None }
    }

    #[test]
    fn data_uris_are_decoded_with_and_without_padding() {
        let here = Path::new(".");
        for uri in ["data:application/octet-stream;base64,AAEC/w==", "data:;base64,AAEC/w", "data:,%00%01%02%FF"] {
            assert_eq!(read_uri(uri, place(here)).expect(uri), [0, 1, 2, 255], "{uri}");
        }
        for uri in ["data:;base64", "data:;base64,A", "data:;base64,?!", "http://example.org/a.bin", "file:///a.bin"] {
            assert!(read_uri(uri, place(here)).is_err(), "{uri}");
        }
    }

    #[test]
    fn file_names_are_percent_decoded() {
        let folder = tempfile::tempdir().expect("temporary folder");
        fs::write(folder.path().join("a b é.bin"), [7]).expect("written");
        assert_eq!(read_uri("a%20b%20%C3%A9.bin", place(folder.path())).expect("found"), [7]);
        let missing = read_uri("absent.bin", place(folder.path())).expect_err("there is none");
        assert!(missing.message.contains("absent.bin"), "{missing}");
    }
}
