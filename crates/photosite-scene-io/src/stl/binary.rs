//! Binary STL: a header of 80 bytes, the number of facets, and 50 bytes for each of them.

use std::path::Path;

use glam::Vec3;

use super::solid::{FACET, Solid};
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, Result, memory};

/// Number of bytes before the first facet, and of a facet.
const HEAD: usize = 84;
const SIZE: usize = 50;

/// Whether a file is binary. Many binary files begin with "solid" as text files do: then their length decides, and
/// where it does not match the number of facets, the presence of zero bytes, of which that number has at least some.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    let begins_as_text = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    !begins_as_text || is_whole(bytes) || bytes[..bytes.len().min(HEAD)].contains(&0)
}

/// Whether a file has exactly the length that its number of facets demands.
pub(super) fn is_whole(bytes: &[u8]) -> bool {
    announced(bytes).map(|count| HEAD as u64 + count * SIZE as u64) == Some(bytes.len() as u64)
}

/// Number of facets by the header.
fn announced(bytes: &[u8]) -> Option<u64> {
    let number = bytes.get(HEAD - 4..HEAD)?.as_chunks().0;
    Some(u32::from_le_bytes(*number.first()?).into())
}

/// Reads a binary file.
pub(super) fn read(bytes: &[u8], path: &Path, warnings: &mut Warnings) -> Result<Solid> {
    let Some(count) = announced(bytes) else {
        let message =
            format!("is not an STL file: it neither begins with \"solid\" nor has the {HEAD} bytes of a head");
        let help = "the file is damaged, or of another kind; copy or export it again";
        return Err(Invalid::new("", message).help(help).in_file(path));
    };
    let facets = &bytes[HEAD..];
    let there = facets.len() as u64 / SIZE as u64;
    if there < count {
        let message = format!("is truncated: {count} facets are announced, but only {there} follow");
        return Err(Invalid::new("", message).help("the file is damaged; copy or export it again").in_file(path));
    }
    let behind = facets.len() as u64 - count * SIZE as u64;
    if behind > 0 {
        warnings.once(format!("{behind} bytes behind the {count} facets that are announced are left out"));
    }
    memory::check(count * FACET, &format!("its geometry of {count} facets"), "simplify it")
        .map_err(|invalid| invalid.in_file(path))?;
    let mut solid = Solid::default();
    let mut attributes = 0;
    for (i, facet) in facets.as_chunks::<SIZE>().0.iter().take(count as usize).enumerate() {
        let numbers: [f32; 12] = std::array::from_fn(|n| f32::from_le_bytes(std::array::from_fn(|b| facet[4 * n + b])));
        let [normal, a, b, c] = std::array::from_fn(|v| Vec3::from_slice(&numbers[3 * v..]));
        solid.add(normal, [a, b, c]).map_err(|invalid| {
            let at = HEAD + i * SIZE;
            let key = format!("facet {i} (from byte {at})");
            invalid.within(&key).in_file(path)
        })?;
        attributes += usize::from(facet[SIZE - 2..] != [0, 0]);
    }
    if attributes > 0 {
        warnings
            .once(format!("the attributes of {attributes} facets, in which some programs keep colours, are left out"));
    }
    Ok(solid.finished())
}
