//! Writes charts as a Bayer sensor would record them, with the whole truth beside, for programs that nobody here wrote
//! to demosaic (`tests/judges/demosaicing.py`): charts made for it, and images from the electrons.exr files of
//! renders.
//!
//! `cargo run --release --example write_demosaic_charts -- FOLDER [ELECTRONS.EXR…]`

use std::f64::consts::PI;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use photosite::develop::{
    Codes, Demosaic, DevelopSettings, EncodedImage, Highlights, ToneCurve, WhiteBalance, develop,
};
use photosite::io::developed::write_encoded;
use photosite::io::electrons::read_electrons;
use photosite::io::formats::TIFF;
use photosite::io::output::{create_folder, write_whole};
use photosite::raw::{Cfa, RawImage, write_tiff};

const SIZE: usize = 192;
const WHITE: f64 = 65_535.0;
const METHODS: [(&str, Demosaic); 6] = [
    ("nearest", Demosaic::Nearest),
    ("bilinear", Demosaic::Bilinear),
    ("guided", Demosaic::Guided),
    ("malvar", Demosaic::Malvar),
    ("menon", Demosaic::Menon),
    ("lmmse", Demosaic::Lmmse),
];

/// An image with all channels at every pixel, interleaved.
struct Chart {
    name: String,
    width: usize,
    height: usize,
    rgb: Vec<u16>,
}

fn main() -> miette::Result<()> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let Some(folder) = arguments.next() else {
        return Err(miette::miette!("usage: write_demosaic_charts FOLDER [ELECTRONS.EXR…]"));
    };
    let mut charts = vec![
        chart("zone-plate", |_, x, y| 0.5 + 0.45 * (PI * 0.9 / SIZE as f64 * (x * x + y * y) * 0.5).cos()),
        chart("coloured-zone-plate", |c, x, y| {
            let level = [0.6, 0.5, 0.35][c];
            level + [0.3, 0.4, 0.25][c] * (PI * 0.7 / SIZE as f64 * (x * x + y * y) * 0.5).cos()
        }),
        chart("star", |c, x, y| {
            let bright = (18.0 * (y - 4.0).atan2(x + 7.0)).sin();
            // Smooth over about a pixel, as a lens leaves it.
            let edge = 1.0 / (1.0 + (-bright * x.hypot(y) / 12.0).exp());
            [0.1, 0.2, 0.15][c] + [0.8, 0.6, 0.5][c] * edge
        }),
        chart("patches", |c, x, y| {
            let cell = ((x / 17.0).floor() as i64 * 7 + (y / 13.0).floor() as i64 * 11 + c as i64 * 5).rem_euclid(16);
            0.05 + 0.055 * cell as f64
        }),
    ];
    for path in arguments {
        charts.push(of_render(&path)?);
    }
    for chart in &charts {
        for phase in ["RGGB", "GBRG"] {
            let folder = folder.join(format!("{}-{phase}", chart.name));
            create_folder(&folder)?;
            write(chart, phase, &folder).map_err(|error| miette::miette!("{error}"))?;
        }
    }
    Ok(())
}

fn chart(name: &str, colour: impl Fn(usize, f64, f64) -> f64) -> Chart {
    let half = SIZE as f64 / 2.0;
    let value = |i: usize| {
        let (x, y) = ((i / 3 % SIZE) as f64 - half, (i / 3 / SIZE) as f64 - half);
        (colour(i % 3, x, y).clamp(0.0, 1.0) * WHITE).round() as u16
    };
    Chart { name: name.to_owned(), width: SIZE, height: SIZE, rgb: (0..3 * SIZE * SIZE).map(value).collect() }
}

/// The mean electrons of a render, scaled so that its brightest part is white.
fn of_render(path: &PathBuf) -> miette::Result<Chart> {
    let file = File::open(path).map_err(|error| miette::miette!("{}: {error}", path.display()))?;
    let (electrons, _) = read_electrons(BufReader::new(file)).map_err(|error| miette::miette!("{error}"))?;
    let mut sorted = electrons.mean.plane("G").unwrap_or_default().to_vec();
    sorted.sort_by(f32::total_cmp);
    let white = f64::from(sorted.get(sorted.len() * 99 / 100).copied().unwrap_or(1.0));
    let planes: Vec<&[f32]> = ["R", "G", "B"].iter().filter_map(|name| electrons.mean.plane(name)).collect();
    let value = |i: usize| (f64::from(planes[i % 3][i / 3]) / white).clamp(0.0, 1.0) * WHITE;
    let (width, height) = (electrons.mean.width(), electrons.mean.height());
    let name = path.parent().and_then(|p| p.file_name()).map_or("render".into(), |n| n.to_string_lossy().into_owned());
    Ok(Chart { name, width, height, rgb: (0..3 * width * height).map(|i| value(i).round() as u16).collect() })
}

fn write(chart: &Chart, phase: &str, folder: &std::path::Path) -> photosite::Result<()> {
    let cfa = Cfa::parse(phase).expect("a Bayer phase");
    let Chart { width, height, rgb, .. } = chart;
    let seen = |i: usize| rgb[3 * i + cfa.channel_at(i % width, i / width)];
    let (data, bits) = ((0..width * height).map(seen).collect(), 16);
    let raw = RawImage { width: *width, height: *height, data, cfa, bits, ..RawImage::default() };
    write_whole(&folder.join("raw.tiff"), |to| write_tiff(&raw, to))?;
    let image = |name: &str, image: &EncodedImage| {
        let path = folder.join(format!("{name}.tiff"));
        write_whole(&path, |to| write_encoded(image, &TIFF, to))
    };
    let settings = DevelopSettings {
        white_balance: WhiteBalance::None,
        highlights: Highlights::None,
        colour_matrix: false,
        tone_curve: ToneCurve::Linear,
        bits: 16,
        ..DevelopSettings::default()
    };
    let encoding = settings.encoding();
    let codes = Codes::U16(rgb.clone());
    let (colour_space, transfer) = (encoding.colour_space, encoding.transfer);
    let (width, height) = (*width, *height);
    let truth = EncodedImage { width, height, components: 3, codes, colour_space, transfer, pixel_aspect: 1.0 };
    image("truth", &truth)?;
    for (name, demosaic) in METHODS {
        let developed = develop(&raw, &DevelopSettings { demosaic, ..settings.clone() });
        image(name, &developed.map_err(|invalid| invalid.in_file(folder))?)?;
    }
    Ok(())
}
