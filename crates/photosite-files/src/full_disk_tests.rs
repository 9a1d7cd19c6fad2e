//! Tests of all encoders on a full disk.

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Write};

use super::formats::{FORMATS, FileImage};
use photosite_core::image::{Channel, Planes};
use photosite_core::output::{Remembering, Sink};
use photosite_raw::{DngCompression, RawImage};

/// Test on `/dev/full`, where every write fails as on a full disk. Encoders must not hide that.
#[test]
fn a_full_disk_is_told_as_such_by_every_encoder() {
    let raw = RawImage { width: 64, height: 64, bits: 12, data: vec![7; 64 * 64], ..Default::default() };
    let image = photosite_develop::EncodedImage::srgb8(64, 64, 1, vec![9; 64 * 64]);
    let plane = Channel { name: "Y".to_owned(), data: vec![1.0; 64 * 64] };
    let planes = Planes::new(64, 64, vec![plane]).expect("an image");
    type Encoder<'a> = Box<dyn Fn(&mut dyn Sink) -> io::Result<()> + 'a>;
    let mut encoders: Vec<(&str, Encoder<'_>)> = Vec::new();
    for format in FORMATS {
        if format.writes_raw() {
            encoders.push((format.name, Box::new(|to| format.write_raw(&raw, DngCompression::default(), to))));
        }
        if format.image_writer.is_some() {
            let image = if format.floats { FileImage::of_planes(&planes) } else { FileImage::of_codes(&image) };
            encoders.push((format.name, Box::new(move |to| format.write(&image, to))));
        }
    }
    for (name, encode) in encoders {
        let full = File::options().write(true).open("/dev/full").expect("a full device");
        let mut to = BufWriter::with_capacity(16, Remembering::new(full));
        let failed = encode(&mut to).and_then(|()| to.flush()).is_err();
        let (remembering, _) = to.into_parts();
        let kind = remembering.into_failure().map(|reason| reason.kind());
        assert!(failed && kind == Some(ErrorKind::StorageFull), "{name}: {kind:?}");
    }
}
