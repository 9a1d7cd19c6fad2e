//! Development of 24 megapixels, all threads.

use divan::{Bencher, black_box};
use photosite::develop::{Demosaic, DevelopSettings, develop};
use photosite::raw::{Cfa, ColourCalibration, LightSource, RawImage, RawMetadata};

/// A Bayer mosaic of 6000 × 4000 pixels with detail everywhere.
fn raw() -> RawImage {
    let (width, height) = (6000, 4000);
    let value = |i: usize| {
        let (x, y) = ((i % width) as f32, (i / width) as f32);
        (2000.0 + 1500.0 * (0.013 * x).sin() * (0.017 * y + 0.003 * x).cos() + (i * 2_654_435_761 % 97) as f32) as u16
    };
    let metadata = RawMetadata {
        calibrations: vec![ColourCalibration {
            light: LightSource::D65,
            colour_matrix: vec![[0.8, -0.25, -0.1], [-0.4, 1.2, 0.2], [-0.05, 0.15, 0.6]],
            forward_matrix: None,
        }],
        as_shot_neutral: Some(vec![0.5, 1.0, 0.7]),
        ..RawMetadata::default()
    };
    RawImage {
        width,
        height,
        data: (0..width * height).map(value).collect(),
        cfa: Cfa::parse("RGGB").expect("a Bayer phase"),
        bits: 12,
        black_level_dn: 64.into(),
        white_level_dn: 4095,
        metadata,
        ..RawImage::default()
    }
}

#[divan::bench(args = [Demosaic::Bilinear, Demosaic::Malvar, Demosaic::Menon], sample_count = 5)]
fn bayer_24_megapixels(bencher: Bencher<'_, '_>, demosaic: Demosaic) {
    let raw = raw();
    let settings = DevelopSettings { demosaic, ..DevelopSettings::default() };
    bencher.bench_local(|| black_box(develop(&raw, &settings)));
}
