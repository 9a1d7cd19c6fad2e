//! Writes the same kind of mosaic with every colour filter array, in even and odd sizes, in every raw format, for
//! programs that nobody here wrote to read back (`tests/judges/raw_files.py`).
//!
//! `cargo run --release --example write_raw_phases -- FOLDER`

use std::path::{Path, PathBuf};

use photosite::io::output::{create_folder, write_whole};
use photosite::raw::{Cfa, RawImage, RawMetadata, write_dng, write_npy, write_pgm, write_tiff};

fn main() -> miette::Result<()> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err(miette::miette!("usage: write_raw_phases FOLDER"));
    };
    for cfa in ["RGGB", "BGGR", "GRBG", "GBRG", "mono"] {
        for (width, height, bits) in [(640, 480, 12), (333, 217, 16), (64, 31, 8)] {
            let name = format!("{}-{width}x{height}-{bits}bit", cfa.to_lowercase());
            write_all(&picture(cfa, width, height, bits)?, &folder.join(name))?;
        }
    }
    Ok(())
}

/// A mosaic in which every pixel differs from its neighbours and the whole range of numbers occurs.
fn picture(cfa: &str, width: usize, height: usize, bits: u32) -> miette::Result<RawImage> {
    let cfa = Cfa::parse(cfa).map_err(|error| miette::miette!("{error}"))?;
    let max_dn = (1u32 << bits) - 1;
    let data =
        (0..width * height).map(|i| ((i as u32).wrapping_mul(2_654_435_761) >> 7) % (max_dn + 1)).map(|dn| dn as u16);
    let colour = !cfa.is_mono();
    Ok(RawImage {
        width,
        height,
        data: data.collect(),
        bits,
        black_level_dn: (1 << (bits - 6)).into(),
        white_level_dn: (max_dn - (1 << (bits - 5))) as u16,
        metadata: RawMetadata {
            camera_model: "test pattern".to_owned(),
            exposure_time_s: 1.0 / 125.0,
            f_number: Some(2.8),
            focal_length_m: Some(0.016),
            colour_matrix_d65: colour.then_some(vec![[0.8, -0.25, -0.1], [-0.4, 1.2, 0.2], [-0.05, 0.15, 0.6]]),
            colour_matrix_a: colour.then_some(vec![[0.9, -0.35, -0.15], [-0.3, 1.1, 0.25], [0.0, 0.1, 0.7]]),
            as_shot_neutral: colour.then_some(vec![0.5, 1.0, 0.7]),
            noise_profile: vec![[1e-4, 2e-7]; cfa.channels().len()],
            ..RawMetadata::default()
        },
        cfa,
        ..RawImage::default()
    })
}

fn write_all(raw: &RawImage, folder: &Path) -> photosite::Result<()> {
    create_folder(folder)?;
    write_whole(&folder.join("raw.dng"), |to| write_dng(raw, to))?;
    write_whole(&folder.join("raw.tiff"), |to| write_tiff(raw, to))?;
    write_whole(&folder.join("raw.pgm"), |to| write_pgm(raw, to))?;
    write_whole(&folder.join("raw.npy"), |to| write_npy(raw, to))
}
