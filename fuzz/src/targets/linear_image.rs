//! Images that are measured, compared and developed, with what they say of their colours. The first byte says which
//! kind the file's name says.

use photosite::develop::{DevelopSettings, develop_image};
use photosite::io::developable::{Developable, read_developable};
use photosite::io::linear_image::read_linear_image;
use photosite::raw::Pixels;
use crate::written;

const KINDS: [&str; 7] = ["png", "tiff", "jpg", "exr", "ppm", "dng", "hdr"];

pub(crate) fn target(data: &[u8]) {
    if let [kind, file @ ..] = data {
        let kind = KINDS[usize::from(*kind) % KINDS.len()];
        let path = written(&format!("picture.{kind}"), file);
        let _ = read_linear_image(&path, false, Pixels::Active);
        // Large images take their time.
        if let Ok(Developable::Light(light)) = read_developable(&path)
            && light.planes.width() * light.planes.height() <= 4096
        {
            let _ = develop_image(light.planes, light.pixel_aspect, &DevelopSettings::default());
        }
    }
}
