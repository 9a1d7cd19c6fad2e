//! Writes the same kind of image in every layout that DNG files know, in even and odd sizes, compressed and not, with
//! and without masked pixels, in every raw format, for programs that nobody here wrote to read back
//! (`tests/judges/raw_files.py`).
//!
//! `cargo run --release --example write_raw_layouts -- FOLDER`

use std::path::{Path, PathBuf};

use photosite::io::output::{create_folder, write_whole};
use photosite::projection::{BrownConrady, Intrinsics, Projection};
use photosite::raw::{
    BlackLevel, Cfa, ColourCalibration, Distortion, DngCompression, GainMap, LensModel, LightSource, Opcode, PixelArea,
    RawImage, RawMetadata, write_compressed_dng, write_npy, write_pgm, write_tiff,
};

const LAYOUTS: [&str; 11] =
    ["RGGB", "BGGR", "GRBG", "GBRG", "mono", "x-trans", "full:RGB", "quad-bayer", "rgbw", "ryyb", "cygm"];
const COMPRESSIONS: [(&str, DngCompression); 4] = [
    ("plain", DngCompression::None),
    ("packed", DngCompression::Packed),
    ("jpeg", DngCompression::LosslessJpeg),
    ("deflate", DngCompression::Deflate),
];

fn main() -> miette::Result<()> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err(miette::miette!("usage: write_raw_layouts FOLDER"));
    };
    for layout in LAYOUTS {
        for (compression_name, compression) in COMPRESSIONS {
            // Several whole tiles, odd sides, and a single tile or strip.
            for (width, height, bits) in [(640, 480, 12), (333, 217, 16), (64, 31, 8)] {
                let name = format!("{layout}-{width}x{height}-{bits}bit-{compression_name}").replace(':', "-");
                let raw = image(layout, width, height, bits).map_err(|error| miette::miette!("{error}"))?;
                write_all(&raw, compression, &folder.join(name))?;
            }
        }
        let raw = masked(image(layout, 333, 217, 14).map_err(|error| miette::miette!("{error}"))?);
        let raw = raw.map_err(|error| miette::miette!("{error}"))?;
        write_all(&raw, DngCompression::LosslessJpeg, &folder.join(format!("{layout}-masked").replace(':', "-")))?;
    }
    Ok(())
}

/// An image in which every number differs from its neighbours and the whole range occurs.
fn image(layout: &str, width: usize, height: usize, bits: u32) -> Result<RawImage, photosite::Invalid> {
    let cfa = Cfa::parse(layout)?;
    let max_dn = (1u32 << bits) - 1;
    let number = |i: usize| (((i as u32).wrapping_mul(2_654_435_761) >> 7) % (max_dn + 1)) as u16;
    let channels = cfa.channels().len();
    let colour = !cfa.is_mono();
    let rows = [[0.8, -0.25, -0.1], [-0.4, 1.2, 0.2], [-0.05, 0.15, 0.6], [0.3, 0.5, 0.25]];
    let matrix = |factor: f64| rows[..channels].iter().map(|row| row.map(|entry| entry * factor)).collect();
    let lit = |light, factor| ColourCalibration { light, colour_matrix: matrix(factor), forward_matrix: None };
    Ok(RawImage {
        width,
        height,
        data: (0..width * height * cfa.samples_per_pixel()).map(number).collect(),
        bits,
        black_level_dn: (1 << (bits - 6)).into(),
        white_level_dn: (max_dn - (1 << (bits - 5))) as u16,
        metadata: RawMetadata {
            camera_model: "test pattern".to_owned(),
            pixel_pitch_m: Some([3.45e-6; 2]),
            exposure_time_s: 1.0 / 125.0,
            f_number: Some(2.8),
            focal_length_m: Some(0.016),
            calibrations: if colour { vec![lit(LightSource::A, 1.125), lit(LightSource::D65, 1.0)] } else { vec![] },
            as_shot_neutral: colour.then(|| [0.5, 1.0, 0.7, 0.9][..channels].to_vec()),
            noise_profile: vec![[1e-4, 2e-7]; channels],
            ..RawMetadata::default()
        },
        cfa,
        ..RawImage::default()
    })
}

/// The same with a frame of masked pixels, a black level for each channel, and a lens to correct.
fn masked(raw: RawImage) -> Result<RawImage, photosite::Invalid> {
    let levels: Vec<f32> = (0..raw.cfa.channels().len()).map(|channel| 200.0 + 10.0 * channel as f32).collect();
    let (samples, area) = (raw.cfa.samples_per_pixel(), PixelArea { x: 10, y: 8, width: 316, height: 200 });
    let black_level_dn = BlackLevel::of_channels(&raw.cfa, &levels)?;
    let mut data = raw.data;
    for (i, dn) in data.iter_mut().enumerate() {
        let (x, y) = (i % (raw.width * samples), i / (raw.width * samples));
        let sees_light =
            (area.x..area.x + area.width).contains(&(x / samples)) && (area.y..area.y + area.height).contains(&y);
        if !sees_light {
            *dn = black_level_dn.at(x, y) as u16;
        }
    }
    let intrinsics = Intrinsics { fx: 400.0, fy: 400.0, cx: 160.0, cy: 100.0, skew: 0.0 };
    let projection = if raw.cfa.is_mono() {
        Projection::KannalaBrandt { k: [0.05, -0.01, 0.0, 0.0] }
    } else {
        let k = [-0.1, 0.02, 0.0, 0.0, 0.0, 0.0];
        Projection::BrownConrady(BrownConrady { k, p: [1e-3, 0.0], ..BrownConrady::default() })
    };
    let metadata = RawMetadata {
        opcodes: [
            vec![],
            vec![Opcode::GainMap(GainMap::new(3, 3, vec![1.5, 1.25, 1.5, 1.25, 1.0, 1.25, 1.5, 1.25, 1.5])?)],
            vec![],
        ],
        distortion: Some(Distortion::Lens(LensModel { intrinsics, projection, max_angle_rad: None })),
        ..raw.metadata
    };
    Ok(RawImage { data, active_area: Some(area), black_level_dn, metadata, ..raw })
}

fn write_all(raw: &RawImage, compression: DngCompression, folder: &Path) -> photosite::Result<()> {
    create_folder(folder)?;
    write_whole(&folder.join("raw.dng"), |to| write_compressed_dng(raw, compression, to))?;
    write_whole(&folder.join("raw.tiff"), |to| write_tiff(raw, to))?;
    write_whole(&folder.join("raw.pgm"), |to| write_pgm(raw, to))?;
    write_whole(&folder.join("raw.npy"), |to| write_npy(raw, to))
}
