//! What files of pictures say beside their numbers and colours: how they are to be turned, and what nobody follows.
//!
//! | file | followed | a warning names | of no effect |
//! |---|---|---|---|
//! | JPEG | EXIF's Orientation (`develop`); ICC profiles; components of SOF | EXIF's ColorSpace without a profile; CMYK and YCCK (APP14); gain maps and further pictures (MPF, Ultra HDR, ISO 21496-1); JFIF's density of pixels that are not square | previews, texts, Photoshop's APP13 |
//! | PNG | Orientation in eXIf (`develop`); cICP, iCCP, sRGB, gAMA, cHRM; pHYs (`develop`); tRNS | acTL: the pictures of an animation behind the first; gain maps (gmAP, gdAT) | sBIT, bKGD, mDCV, cLLI, texts |
//! | TIFF | Orientation (`develop`); ICC profiles | what the table of `raw` has | the same |

use std::path::Path;

use crate::raw::{Exif, Orientation, TiffNotes, tiff_notes};
use crate::{Error, Invalid, Result};
use photosite_core::input;

/// Statements of a picture's file beside its numbers and colours.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PictureNotes {
    /// How the picture is to be turned so that it stands upright.
    pub orientation: Orientation,
    /// What nobody follows, each as a warning has it.
    pub left_out: Vec<String>,
}

impl PictureNotes {
    /// Notes of a file by the kind that its name says; none of kinds that say nothing.
    pub fn read(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let of: fn(&[u8]) -> Result<Self, Invalid> = match extension.as_str() {
            "jpg" | "jpeg" => |bytes| Ok(of_jpeg(bytes)),
            "png" => |bytes| Ok(of_png(bytes)),
            "tif" | "tiff" => of_tiff,
            _ => return Ok(Self::default()),
        };
        let bytes = input::read(path).map_err(|source| Error::io(path, "read", source))?;
        let mut notes = of(&bytes).map_err(|invalid| invalid.in_file(path))?;
        for what in &mut notes.left_out {
            *what = format!("{}: {what}", path.display());
        }
        Ok(notes)
    }

    /// What is left out where the numbers are taken as they lie in the file.
    pub fn of_numbers(self, path: &Path) -> Vec<String> {
        let turned = (!self.orientation.is_upright()).then(|| {
            let number = self.orientation.number();
            format!("{}: Orientation {number} is left out: columns and rows are those of the file", path.display())
        });
        self.left_out.into_iter().chain(turned).collect()
    }
}

fn of_tiff(bytes: &[u8]) -> Result<PictureNotes, Invalid> {
    let TiffNotes { left_out, orientation, .. } = tiff_notes(std::io::Cursor::new(bytes))?;
    Ok(PictureNotes { orientation, left_out })
}

fn of_jpeg(bytes: &[u8]) -> PictureNotes {
    let mut notes = PictureNotes::default();
    let (mut exif, mut has_profile, mut has_gain_map, mut has_more) = (Exif::default(), false, false, false);
    for (marker, body) in segments(bytes) {
        match marker {
            // APP0: units, then the density across and down, or their ratio.
            0xe0 => {
                if let Some(&[x1, x2, y1, y2]) = body.strip_prefix(b"JFIF\0").and_then(|jfif| jfif.get(3..7))
                    && [x1, x2] != [y1, y2]
                {
                    let [x, y] = [[x1, x2], [y1, y2]].map(u16::from_be_bytes);
                    let what = format!("JFIF's density {x} × {y} is left out: its pixels are taken for square");
                    notes.left_out.push(what);
                }
            }
            0xe1 => {
                if let Some(block) = body.strip_prefix(b"Exif\0\0") {
                    exif = Exif::read(block);
                }
                has_gain_map |= contains(body, b"hdrgm:") || contains(body, b"HDRGainMap");
            }
            0xe2 => {
                has_profile |= body.starts_with(b"ICC_PROFILE\0");
                has_more |= body.starts_with(b"MPF\0");
                has_gain_map |= body.starts_with(b"urn:iso:std:iso:ts:21496:-1\0");
            }
            // A frame: precision, height, width, components.
            0xc0..=0xcf if ![0xc4, 0xc8, 0xcc].contains(&marker) && body.get(5) == Some(&4) => notes.left_out.push(
                "its four inks (CMYK) become R, G and B without their profile: colours are off; convert it to RGB"
                    .to_owned(),
            ),
            _ => {}
        }
    }
    notes.orientation = exif.orientation;
    if let Some(space) = exif.colour_space.filter(|space| *space != 1 && !has_profile) {
        let name = if space == 2 { "Adobe RGB".to_owned() } else { format!("number {space}") };
        notes.left_out.push(format!("EXIF's ColorSpace, {name}, is left out: its colours are taken for sRGB"));
    }
    if has_gain_map {
        notes.left_out.push("its gain map (Ultra HDR) is left out: the picture is that for usual displays".to_owned());
    } else if has_more {
        notes
            .left_out
            .push("the further pictures that it holds (MPF) are left out: the first alone is read".to_owned());
    }
    notes
}

/// Markers of a JPEG file and what they hold, up to the picture itself.
fn segments(mut bytes: &[u8]) -> Vec<(u8, &[u8])> {
    let mut found = Vec::new();
    bytes = bytes.get(2..).unwrap_or_default();
    while let Some((&[0xff, marker, high, low], _)) = bytes.split_first_chunk::<4>() {
        // Bytes may fill the space before a marker; a scan ends what is told.
        if marker == 0xff {
            bytes = bytes.get(1..).unwrap_or_default();
            continue;
        }
        let length = usize::from(u16::from_be_bytes([high, low]));
        let Some(body) = bytes.get(4..2 + length) else { break };
        if marker == 0xda {
            break;
        }
        found.push((marker, body));
        bytes = bytes.get(2 + length..).unwrap_or_default();
    }
    found
}

fn of_png(bytes: &[u8]) -> PictureNotes {
    let mut notes = PictureNotes::default();
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let Some((&[a, b, c, d, kind @ ..], body)) = rest.split_first_chunk::<8>() {
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        let Some(data) = body.get(..length) else { break };
        match &kind {
            b"eXIf" => notes.orientation = Exif::read(data).orientation,
            b"acTL" => {
                let frames = data.first_chunk().map_or(0, |&count| u32::from_be_bytes(count));
                if frames > 1 {
                    let what = format!("it is an animation of {frames} pictures (acTL): the first alone is read");
                    notes.left_out.push(what);
                }
            }
            b"gmAP" | b"gdAT" => {
                notes.left_out.push("its gain map is left out: the picture is that for usual displays".to_owned());
            }
            _ => {}
        }
        rest = body.get(length + 4..).unwrap_or_default();
    }
    notes.left_out.dedup();
    notes
}

fn contains(bytes: &[u8], word: &[u8]) -> bool {
    bytes.windows(word.len()).any(|part| part == word)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An EXIF block with an orientation and, in the directory of EXIF, a colour space, byte by byte.
    fn exif(orientation: u8, colour_space: u8) -> Vec<u8> {
        let short = |tag: u16, x: u8| [&tag.to_be_bytes()[..], &[0, 3, 0, 0, 0, 1, 0, x, 0, 0]].concat();
        let pointer = [&0x8769u16.to_be_bytes()[..], &[0, 4, 0, 0, 0, 1, 0, 0, 0, 38]].concat();
        let main = [&b"MM\0*\0\0\0\x08\0\x02"[..], &short(0x0112, orientation), &pointer, &[0; 4]].concat();
        [&main[..], &[0, 1], &short(0xa001, colour_space), &[0; 4]].concat()
    }

    fn jpeg(segments: &[(u8, Vec<u8>)]) -> Vec<u8> {
        let mut bytes = vec![0xff, 0xd8];
        for (marker, body) in segments {
            bytes.extend([0xff, *marker]);
            bytes.extend((body.len() as u16 + 2).to_be_bytes());
            bytes.extend(body);
        }
        [&bytes[..], &[0xff, 0xda, 0, 2, 0x3f]].concat()
    }

    fn png(chunks: &[(&[u8; 4], Vec<u8>)]) -> Vec<u8> {
        let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
        for (kind, data) in chunks {
            bytes.extend((data.len() as u32).to_be_bytes());
            bytes.extend([&kind[..], data, &[0; 4]].concat());
        }
        bytes
    }

    fn frame(components: u8) -> Vec<u8> {
        vec![8, 0, 1, 0, 1, components]
    }

    /// Every row of the table.
    #[test]
    fn what_is_not_followed_is_named() {
        let of_exif = |orientation, space| [&b"Exif\0\0"[..], &exif(orientation, space)].concat();
        let marked = |word: &[u8]| word.to_vec();
        for (segments, orientation, words) in [
            (vec![(0xe1, of_exif(1, 1)), (0xc0, frame(3))], 1, None),
            (vec![(0xe1, of_exif(6, 1)), (0xc2, frame(1))], 6, None),
            (vec![(0xe1, of_exif(1, 2))], 1, Some("ColorSpace, Adobe RGB, is left out")),
            (vec![(0xe1, of_exif(8, 77))], 8, Some("ColorSpace, number 77, is left out")),
            (vec![(0xe1, of_exif(1, 2)), (0xe2, marked(b"ICC_PROFILE\0\x01\x01"))], 1, None),
            (vec![(0xc0, frame(4)), (0xc4, frame(4))], 1, Some("four inks (CMYK)")),
            (vec![(0xe2, marked(b"MPF\0MM"))], 1, Some("further pictures that it holds (MPF)")),
            (vec![(0xe1, marked(b"http://ns.adobe.com/xap/1.0/\0 hdrgm:Version='1.0'"))], 1, Some("gain map")),
            (vec![(0xe2, marked(b"urn:iso:std:iso:ts:21496:-1\0")), (0xe2, marked(b"MPF\0"))], 1, Some("gain map")),
            (vec![(0xe0, marked(b"JFIF\0\x01\x02\x01\0\x48\0\x48\0\0"))], 1, None),
            (vec![(0xe0, marked(b"JFIF\0\x01\x02\0\0\x01\0\x02\0\0"))], 1, Some("density 1 × 2 is left out")),
            (vec![(0xee, marked(b"Adobe\0\x64\0\0\0\0\x01")), (0xc0, frame(3))], 1, None),
        ] {
            let file = jpeg(&segments);
            let notes = of_jpeg(&file);
            assert_eq!(notes.orientation.number(), orientation);
            assert_eq!(notes.left_out.len(), usize::from(words.is_some()), "{notes:?}");
            assert!(words.is_none_or(|words| notes.left_out[0].contains(words)), "{notes:?}");
            for length in 0..file.len() {
                of_jpeg(&file[..length]);
            }
        }
        let frames = |count: u32| [count.to_be_bytes(), [0; 4]].concat();
        for (chunks, orientation, words) in [
            (vec![(b"eXIf", exif(3, 1)), (b"sBIT", vec![5]), (b"tEXt", vec![])], 3, None),
            (vec![(b"acTL", frames(12))], 1, Some("an animation of 12 pictures (acTL)")),
            (vec![(b"acTL", frames(1))], 1, None),
            (vec![(b"gmAP", vec![]), (b"gdAT", vec![])], 1, Some("gain map")),
        ] {
            let file = png(&chunks);
            let notes = of_png(&file);
            assert_eq!(notes.orientation.number(), orientation);
            assert_eq!(notes.left_out.len(), usize::from(words.is_some()), "{notes:?}");
            assert!(words.is_none_or(|words| notes.left_out[0].contains(words)), "{notes:?}");
            for length in 0..file.len() {
                of_png(&file[..length]);
            }
        }
    }

    #[test]
    fn numbers_that_are_taken_as_they_lie_are_not_turned() {
        let notes = of_jpeg(&jpeg(&[(0xe1, [&b"Exif\0\0"[..], &exif(6, 1)].concat())]));
        assert_eq!(
            notes.of_numbers(Path::new("a.jpg")),
            ["a.jpg: Orientation 6 is left out: columns and rows are those of the file"]
        );
    }
}
