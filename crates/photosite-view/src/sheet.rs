//! Contact sheet of a data set: its images small and whole, the overlays drawn over them, and their light.

use std::io::{BufReader, Cursor};
use std::path::Path;
use std::sync::Mutex;

use hyper::StatusCode;
use image::codecs::jpeg::JpegEncoder;
use image::{ImageFormat, ImageReader, Limits};
use serde_json::{Value, json};

use super::answer::Failure;
use super::recent::Recent;
use super::source::{ImageSource, Input};
use photosite_core::input;
use photosite_core::locked::locked;
use photosite_core::{Error, Sandbox};
use photosite_dataset::{Overlays, Sheet};
use photosite_files::formats::{JPEG, PNG};

/// Widths of small images, px.
const WIDTHS: [u32; 3] = [160, 320, 640];
/// Number of images whose light stays in memory: two that are compared.
const OPENED: usize = 2;
/// Most memory that an image takes while it is made small, bytes.
const MOST: u64 = 1 << 30;

/// A data set that is looked at.
pub(super) struct ContactSheet {
    sheet: Sheet,
    sandbox: Sandbox,
    opened: Mutex<Recent<usize, ImageSource>>,
}

/// Image file with its media type.
type Image = (&'static str, Vec<u8>);

impl ContactSheet {
    pub(super) fn new(sheet: Sheet, sandbox: Sandbox) -> Self {
        Self { sheet, sandbox, opened: Mutex::new(Recent::new(OPENED)) }
    }

    /// Names of the images.
    pub(super) fn names(&self) -> impl Iterator<Item = String> {
        (0..self.sheet.images.len()).filter_map(|number| self.sheet.name_of(number))
    }

    /// Cameras, frames and images of the data set, for the page.
    pub(super) fn list(&self) -> Value {
        let Sheet { cameras, frames, images, .. } = &self.sheet;
        json!({ "cameras": cameras, "frames": frames, "pictures": images, "widths": WIDTHS })
    }

    /// Light of an image, or else the file of its folder that can be developed.
    pub(super) fn source(&self, number: usize) -> Result<ImageSource, Failure> {
        let folder = self.sheet.folder_of(number).ok_or_else(no_image)?;
        locked(&self.opened).get_or_make(number, || match Input::open(&self.sandbox, &folder, &[])? {
            Input::Light(light) => Ok(ImageSource::of_light(light)),
            Input::File(file) => Ok(ImageSource::File(file.into())),
            Input::Scene(_) | Input::DataSet(_) => Err(no_image()),
        })
    }

    /// Developed image that `input=NUMBER` asks for; with `width=WIDTH` a small one.
    pub(super) fn image(&self, query: &str) -> Result<Image, Failure> {
        let number = asked(query, "input")?.unwrap_or(0);
        let width = asked(query, "width")?;
        let missing = || {
            let name = self.sheet.name_of(number).unwrap_or_default();
            let failure = Failure::new(StatusCode::NOT_FOUND, format!("{name} has no image.png"));
            failure.help("make the data set with output.image, or open the image in the live view")
        };
        self.sheet.folder_of(number).ok_or_else(no_image)?;
        let path = self.sheet.image_of(number).ok_or_else(missing)?;
        let read = |reason| Failure::from(Error::io(&path, "read", reason));
        match width {
            None => Ok((PNG.media_type, input::read(&path).map_err(read)?)),
            Some(width) if WIDTHS.iter().any(|known| *known as usize == width) => small(&path, width as u32),
            Some(width) => {
                Err(Failure::new(StatusCode::BAD_REQUEST, format!("width: {width} is not one of {WIDTHS:?}")))
            }
        }
    }

    /// Overlays drawn over the image that `input=NUMBER` asks for.
    pub(super) fn overlays(&self, query: &str) -> Result<Value, Failure> {
        let number = asked(query, "input")?.unwrap_or(0);
        Ok(json!(Overlays::read(&self.sheet, number)?.ok_or_else(no_image)?))
    }
}

fn no_image() -> Failure {
    Failure::new(StatusCode::NOT_FOUND, "there is no image with that number")
}

/// A whole number of a query.
fn asked(query: &str, key: &str) -> Result<Option<usize>, Failure> {
    let values = query.split('&').filter_map(|part| part.split_once('='));
    let Some((_, value)) = values.into_iter().find(|(name, _)| *name == key) else { return Ok(None) };
    let wrong = || Failure::new(StatusCode::BAD_REQUEST, format!("{key}: {value:?} is not a whole number"));
    value.parse().map(Some).map_err(|_| wrong())
}

/// Image no wider than `width`, as JPEG.
fn small(path: &Path, width: u32) -> Result<Image, Failure> {
    let unreadable = |reason: &dyn std::fmt::Display| {
        Failure::new(StatusCode::UNPROCESSABLE_ENTITY, format!("{} cannot be read: {reason}", path.display()))
    };
    let file = input::open(path).map_err(|reason| unreadable(&reason))?;
    let mut reader = ImageReader::with_format(BufReader::new(file), ImageFormat::Png);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST);
    reader.limits(limits);
    let image = reader.decode().map_err(|reason| unreadable(&reason))?;
    let image = if image.width() > width { image.thumbnail(width, u32::MAX) } else { image };
    let mut bytes = Cursor::new(Vec::new());
    let encoder = JpegEncoder::new_with_quality(&mut bytes, 88);
    image.into_rgb8().write_with_encoder(encoder).map_err(|reason| unreadable(&reason))?;
    Ok((JPEG.media_type, bytes.into_inner()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_name_numbers_alone() {
        assert_eq!(asked("input=3&width=160", "width").ok(), Some(Some(160)));
        assert_eq!(asked("", "input").ok(), Some(None));
        for wrong in ["input=", "input=-1", "input=../../etc", "input=99999999999999999999999", "input=1.5"] {
            assert!(asked(wrong, "input").is_err(), "{wrong}");
        }
    }

    #[test]
    fn small_images_keep_their_shape() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("image.png");
        image::RgbImage::from_pixel(640, 400, image::Rgb([200, 100, 50])).save(&path).expect("written");
        let (media_type, bytes) = small(&path, 160).expect("an image");
        assert_eq!(media_type, "image/jpeg");
        let image = image::load_from_memory(&bytes).expect("JPEG");
        assert_eq!([image.width(), image.height()], [160, 100]);
        std::fs::write(&path, b"none").expect("written");
        assert!(small(&path, 160).is_err());
    }
}
