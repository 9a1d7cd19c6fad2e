//! Shards of WebDataset ([WebDataset](photosite_core::references#webdataset)): tar files of which each sample is several
//! members one after the other, with one name up to the first dot.
//!
//! | member | holds |
//! |---|---|
//! | `CAMERA-000000.png` | the developed picture |
//! | `.raw.npy` | digital numbers, `uint16`, (rows, columns), or with a third axis where each pixel has all channels |
//! | `.depth.npy`, `.normal.npy` … | a layer of ground truth as `truth-LAYER.npy` has it: `float32`, `uint32` of numbers of things |
//! | `.camera.json` | camera, frame, time, pose, matrix, lens |
//! | `.json` | `capture.json` |

use std::io;

use tar::{Builder, Header};

use super::container::Container;
use super::sample::Sample;
use crate::calibration::truth::TruthLayer;
use crate::io::npy::write_planes;
use crate::io::output::Sink;
use crate::io::truth::write_truth_npy;
use crate::raw::write_npy;
use crate::{Error, Result};

/// A tar file is made of blocks.
const BLOCK: u64 = 512;

/// Tar files.
pub(super) struct TarFile;

/// A member: its name and its bytes.
type Member = (String, Vec<u8>);

impl Container for TarFile {
    type Item = Vec<Member>;

    fn item(sample: Sample, _: &dyn Fn(&str)) -> Result<Self::Item> {
        let key = sample.key();
        let facts = sample.facts().to_string().into_bytes();
        let mut members = Vec::new();
        let mut add = |field: &str, bytes| members.push((format!("{key}.{field}"), bytes));
        if let Some(image) = sample.image {
            add("png", image);
        }
        let array = |write: &dyn Fn(&mut Vec<u8>) -> io::Result<()>| {
            let mut bytes = Vec::new();
            write(&mut bytes).map_err(|reason| Error::io(key.as_ref(), "write", reason))?;
            Ok::<_, Error>(bytes)
        };
        if let Some(raw) = &sample.raw {
            add("raw.npy", array(&|to| write_npy(raw, to))?);
        }
        for (name, planes) in &sample.truth {
            let bytes = match TruthLayer::ALL.into_iter().find(|layer| layer.name() == name) {
                Some(layer) => array(&|to| write_truth_npy(planes, layer, to))?,
                None => {
                    let values: Vec<&[f32]> = planes.channels().iter().map(|channel| &*channel.data).collect();
                    let size = [planes.width(), planes.height()];
                    array(&|to| write_planes(size, &values, |value| value, to))?
                }
            };
            // A field ends at the next dot.
            add(&format!("{}.npy", name.replace('.', "-")), bytes);
        }
        add("camera.json", facts);
        add("json", sample.report);
        Ok(members)
    }

    fn bytes(members: &Self::Item) -> u64 {
        members.iter().map(|(_, bytes)| BLOCK + (bytes.len() as u64).next_multiple_of(BLOCK)).sum()
    }

    fn write(items: &mut dyn Iterator<Item = io::Result<Self::Item>>, to: &mut dyn Sink) -> io::Result<()> {
        let mut tar = Builder::new(to);
        for members in items {
            for (name, bytes) in members? {
                let mut header = Header::new_ustar();
                header.set_size(bytes.len() as u64);
                header.set_mode(0o644);
                header.set_mtime(0);
                tar.append_data(&mut header, name, &*bytes)?;
            }
        }
        tar.into_inner().map(drop)
    }
}
