//! What encoders of all crates make of a disk that is full.

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Write};

use super::developed::{write_linear, write_png};
use super::output::{Remembering, Sink};
use super::raw_exr::write_raw_exr;
use crate::colour::ColourSpace;
use crate::image::{Channel, Planes};
use crate::raw::{RawImage, write_compressed_dng, write_npy, write_pgm, write_tiff};

/// Every write to `/dev/full` fails as on a full disk. Encoders must not hide that.
#[test]
fn a_full_disk_is_told_as_such_by_every_encoder() {
    let raw = RawImage { width: 64, height: 64, bits: 12, data: vec![7; 64 * 64], ..Default::default() };
    let picture = crate::develop::EncodedPicture::srgb8(64, 64, 3, vec![9; 64 * 64 * 3]);
    let plane = Channel { name: "Y".to_owned(), data: vec![1.0; 64 * 64] };
    let planes = Planes::new(64, 64, vec![plane]).expect("a picture");
    type Encoder<'a> = (&'a str, Box<dyn Fn(&mut dyn Sink) -> io::Result<()> + 'a>);
    let encoders: [Encoder<'_>; 7] = [
        ("dng", Box::new(|to| write_compressed_dng(&raw, Default::default(), to))),
        ("tiff", Box::new(|to| write_tiff(&raw, to))),
        ("pgm", Box::new(|to| write_pgm(&raw, to))),
        ("npy", Box::new(|to| write_npy(&raw, to))),
        ("raw exr", Box::new(|to| write_raw_exr(&raw, to))),
        ("png", Box::new(|to| write_png(&picture, to))),
        ("exr", Box::new(|to| write_linear(&planes, ColourSpace::Srgb, 1.0, to))),
    ];
    for (name, encode) in encoders {
        let full = File::options().write(true).open("/dev/full").expect("a full device");
        let mut to = BufWriter::with_capacity(16, Remembering::new(full));
        let failed = encode(&mut to).and_then(|()| to.flush()).is_err();
        let (remembering, _) = to.into_parts();
        let kind = remembering.into_failure().map(|reason| reason.kind());
        assert!(failed && kind == Some(ErrorKind::StorageFull), "{name}: {kind:?}");
    }
}
