//! Statements of image files beside their pixel values: colours, orientation, pixel aspect ratio, and statements that
//! are left out.
//!
//! | file | followed | a warning names | of no effect |
//! |---|---|---|---|
//! | JPEG | EXIF's Orientation (`develop`); ICC profiles; components of SOF | EXIF's ColorSpace without a profile; CMYK and YCCK (APP14); gain maps and further images (MPF, Ultra HDR, ISO 21496-1); JFIF's density of pixels that are not square | previews, texts, Photoshop's APP13 |
//! | PNG | Orientation in eXIf (`develop`); cICP, iCCP, sRGB, gAMA, cHRM; pHYs (`develop`); tRNS | acTL: the images of an animation behind the first; gain maps (gmAP, gdAT) | sBIT, bKGD, mDCV, cLLI, texts |
//! | TIFF | Orientation (`develop`); ICC profiles | what the table of `raw` has | the same |

use std::io::{Cursor, Read, Seek};

use super::stated_colours::StatedColours;
use photosite_core::Invalid;
use photosite_raw::{Exif, Orientation, TiffNotes, tiff_notes};

/// Statements of an image file beside its pixel values, read with them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageNotes {
    /// Turn that brings the image upright.
    pub orientation: Orientation,
    /// Width of a pixel over its height, where the file states it.
    pub pixel_aspect: Option<f64>,
    /// Statements of colours.
    pub colours: StatedColours,
    /// Statements that are left out, each as a warning words it.
    pub left_out: Vec<String>,
}

impl ImageNotes {
    /// Notes with the name of the file before each statement that is left out.
    #[must_use]
    pub fn of_file(mut self, name: &str) -> Self {
        self.left_out.iter_mut().for_each(|what| *what = format!("{name}: {what}"));
        self
    }

    /// Warnings of what is left out where pixels are taken as they lie in the file of that name.
    pub fn of_pixels_as_they_lie(self, name: &str) -> Vec<String> {
        let turned = (!self.orientation.is_upright()).then(|| {
            let number = self.orientation.number();
            format!("{name}: Orientation {number} is left out: columns and rows are those of the file")
        });
        let shape = self.pixel_aspect.filter(|aspect| *aspect != 1.0).map(|aspect| {
            format!("{name}: pixels {aspect:.4} times as wide as high are left out: they are taken for square")
        });
        self.left_out.into_iter().chain(turned).chain(shape).collect()
    }
}

/// Notes of a TIFF file.
pub(super) fn of_tiff<R: Read + Seek>(from: R) -> Result<ImageNotes, Invalid> {
    let TiffNotes { left_out, orientation, profile } = tiff_notes(from)?;
    let colours = StatedColours { profile, ..StatedColours::default() };
    Ok(ImageNotes { orientation, colours, left_out, ..ImageNotes::default() })
}

/// Notes of a PNG file: pHYs gives the pixel aspect ratio, whatever its unit.
pub(super) fn of_png(bytes: &[u8]) -> Result<ImageNotes, Invalid> {
    let unreadable = |error| Invalid::new("", format!("cannot read it as PNG: {error}"));
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info().map_err(unreadable)?;
    let info = reader.info();
    let stated = info.pixel_dims.filter(|stated| stated.xppu > 0 && stated.yppu > 0);
    let pixel_aspect = stated.map(|stated| f64::from(stated.yppu) / f64::from(stated.xppu));
    Ok(ImageNotes { pixel_aspect, colours: StatedColours::of_png(info), ..of_chunks(bytes) })
}

/// Notes of a JPEG file.
pub(super) fn of_jpeg(bytes: &[u8]) -> ImageNotes {
    let mut notes = ImageNotes::default();
    let (mut exif, mut has_gain_map, mut has_more) = (Exif::default(), false, false);
    let mut profile: Vec<(u8, &[u8])> = Vec::new();
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
                // Its number and that of all parts, then the part.
                if let Some(&[number, _, ref part @ ..]) = body.strip_prefix(b"ICC_PROFILE\0") {
                    profile.push((number, part));
                }
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
    profile.sort_by_key(|(number, _)| *number);
    let parts: Vec<&[u8]> = profile.iter().map(|(_, part)| *part).collect();
    notes.colours.profile = (!parts.is_empty()).then(|| parts.concat());
    if let Some(space) = exif.colour_space.filter(|space| *space != 1 && parts.is_empty()) {
        let name = if space == 2 { "Adobe RGB".to_owned() } else { format!("number {space}") };
        notes.left_out.push(format!("EXIF's ColorSpace, {name}, is left out: its colours are taken for sRGB"));
    }
    if has_gain_map {
        notes.left_out.push("its gain map (Ultra HDR) is left out: the image is that for usual displays".to_owned());
    } else if has_more {
        notes.left_out.push("the further images that it holds (MPF) are left out: the first alone is read".to_owned());
    }
    notes
}

/// Markers of a JPEG file with their content, up to the image itself.
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

fn of_chunks(bytes: &[u8]) -> ImageNotes {
    let mut notes = ImageNotes::default();
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let Some((&[a, b, c, d, kind @ ..], body)) = rest.split_first_chunk::<8>() {
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        let Some(data) = body.get(..length) else { break };
        match &kind {
            b"eXIf" => notes.orientation = Exif::read(data).orientation,
            b"acTL" => {
                let frames = data.first_chunk().map_or(0, |&count| u32::from_be_bytes(count));
                if frames > 1 {
                    let what = format!("it is an animation of {frames} images (acTL): the first alone is read");
                    notes.left_out.push(what);
                }
            }
            b"gmAP" | b"gdAT" => {
                notes.left_out.push("its gain map is left out: the image is that for usual displays".to_owned());
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

    /// Test data: an EXIF block with an orientation and, in the EXIF directory, a colour space, byte by byte.
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

    /// Test of every row of the module's table.
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
            (vec![(0xe2, marked(b"MPF\0MM"))], 1, Some("further images that it holds (MPF)")),
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
            (vec![(b"acTL", frames(12))], 1, Some("an animation of 12 images (acTL)")),
            (vec![(b"acTL", frames(1))], 1, None),
            (vec![(b"gmAP", vec![]), (b"gdAT", vec![])], 1, Some("gain map")),
        ] {
            let file = png(&chunks);
            let notes = of_chunks(&file);
            assert_eq!(notes.orientation.number(), orientation);
            assert_eq!(notes.left_out.len(), usize::from(words.is_some()), "{notes:?}");
            assert!(words.is_none_or(|words| notes.left_out[0].contains(words)), "{notes:?}");
            for length in 0..file.len() {
                of_chunks(&file[..length]);
            }
        }
    }

    #[test]
    fn numbers_that_are_taken_as_they_lie_are_not_turned() {
        let notes = of_jpeg(&jpeg(&[(0xe1, [&b"Exif\0\0"[..], &exif(6, 1)].concat())]));
        let shaped = ImageNotes { pixel_aspect: Some(1.5), ..notes };
        assert_eq!(
            shaped.of_pixels_as_they_lie("a.jpg"),
            [
                "a.jpg: Orientation 6 is left out: columns and rows are those of the file",
                "a.jpg: pixels 1.5000 times as wide as high are left out: they are taken for square"
            ]
        );
    }
}
