//! `photosite measure`: figures of pictures.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use glam::DVec3;
use serde::Serialize;

use super::log::warning;
use super::picture_warnings::warn_of;
use super::print::{print_json, println_text};
use crate::colour::{ColourSpace, cielab, difference};
use crate::image::{Channel, Planes};
use crate::io::linear_picture::read_linear_picture;
use crate::io::picture_file::read_picture_file;
use crate::io::raw_file::refuse_staggered_rows;
use crate::measure::{CheckerReport, EdgeResponse, Histogram, histogram, slanted_edge, ssim};
use crate::pipeline::measure_checker;
use crate::raw::Pixels;
use crate::validation::Picture;
use crate::{Error, Invalid, Result, Sandbox};

const EXAMPLES: &str = "\
Example:
  photosite measure mtf out/image.png --region 100,80,40,60";

/// Measure pictures: sharpness, colours, likeness, histograms.
///
/// Lengths are in pixels, even if the file states another shape for them.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct MeasureArgs {
    #[command(subcommand)]
    measure: Measure,
}

#[derive(Subcommand)]
enum Measure {
    /// Transfer function (MTF, SFR) from a slanted edge after ISO 12233.
    Mtf {
        #[command(flatten)]
        picture: PictureArgs,
        /// The part of the picture with the edge: column, row, columns, rows [default: all].
        #[arg(long, value_name = "X,Y,W,H", value_delimiter = ',', num_args = 1)]
        region: Option<Vec<usize>>,
        /// The channel to measure [default: G, or the only one].
        #[arg(long, value_name = "NAME")]
        channel: Option<String>,
    },
    /// How often values occur in each channel.
    Histogram {
        #[command(flatten)]
        picture: PictureArgs,
        /// Bins of equal width.
        #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65_536))]
        bins: u32,
    },
    /// Colour differences of a colour checker, which is located by the capture.
    Checker {
        #[command(flatten)]
        picture: PictureArgs,
        /// The capture of the picture, or the capture.json beside it: materials with reflectances
        /// colour-checker/… are the patches.
        #[arg(long, value_name = "FILE")]
        capture: PathBuf,
    },
    /// PSNR, SSIM and colour differences of two pictures; B is the reference.
    Similarity {
        #[command(flatten)]
        picture: PictureArgs,
        /// The reference.
        b: PathBuf,
    },
}

#[derive(Args)]
struct PictureArgs {
    /// A picture: .png, .tiff, .jpg, .ppm or .exr; or the numbers of a raw file: .dng, .pgm, .pbm or .npy.
    picture: PathBuf,
    /// Codes are proportional to light, whatever the file says [default: what its profile says, else sRGB].
    #[arg(long)]
    linear: bool,
    /// Use the masked pixels of raw files, too. Without, those that see light alone count (DNG, raw EXR), and
    /// columns and rows are counted from their corner.
    #[arg(long)]
    masked: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

impl PictureArgs {
    fn read(&self) -> Result<Picture> {
        self.read_other(&self.picture)
    }

    fn read_other(&self, path: &Path) -> Result<Picture> {
        warn_of([path])?;
        let picture = read_picture_file(path, self.pixels())?;
        picture.warnings.iter().for_each(|what| warning!("{}: {what}", path.display()));
        Ok(picture)
    }

    fn pixels(&self) -> Pixels {
        if self.masked { Pixels::All } else { Pixels::Active }
    }

    /// Planes of linear light, white at 1 where the file has codes; colours are sRGB.
    fn read_linear(&self, path: &Path) -> Result<Planes> {
        warn_of([path])?;
        let light = read_linear_picture(path, self.linear, self.pixels())?;
        light.warnings.iter().for_each(|what| warning!("{}: {what}", path.display()));
        Ok(light.planes)
    }

    fn print<T: Serialize>(&self, report: &T, text: impl FnOnce(&T) -> String) -> Result<()> {
        if self.json { print_json(report) } else { println_text(&text(report)) }
    }
}

pub(super) fn run(args: &MeasureArgs, sandbox: &Sandbox) -> Result<()> {
    match &args.measure {
        Measure::Mtf { picture, region, channel } => {
            refuse_staggered_rows(&picture.picture)?;
            let planes = picture.read_linear(&picture.picture)?;
            let plane = chosen(&planes, channel.as_deref()).map_err(usage)?;
            let size = [planes.width(), planes.height()];
            let region = region.as_deref().map_or(Ok([0, 0, size[0], size[1]]), |given| {
                <[usize; 4]>::try_from(given).map_err(|_| {
                    usage(
                        Invalid::new("region", format!("{} numbers instead of 4", given.len()))
                            .help("for example --region 100,80,40,60"),
                    )
                })
            })?;
            picture.print(&slanted_edge(&plane.data, size, region).map_err(usage)?, mtf_text)
        }
        Measure::Histogram { picture, bins } => {
            let read = picture.read()?;
            let range = read.full_scale.map(|full_scale| [0.0, full_scale]);
            let of = |channel| histogram(channel, *bins as usize, range);
            picture.print(&read.mean.channels().iter().map(of).collect::<Vec<_>>(), |all| histogram_text(all))
        }
        Measure::Checker { picture, capture } => {
            let planes = picture.read_linear(&picture.picture)?;
            picture.print(&measure_checker(&planes, &picture.picture, capture, sandbox)?, checker_text)
        }
        Measure::Similarity { picture, b } => picture.print(&similarity(picture, b)?, similarity_text),
    }
}

/// What does not fit together is the command line.
fn usage(Invalid { key, message, help }: Invalid) -> Error {
    let message = if key.is_empty() { message } else { format!("{key}: {message}") };
    Error::Usage { message, help }
}

fn chosen<'a>(planes: &'a Planes, name: Option<&str>) -> std::result::Result<&'a Channel, Invalid> {
    let channels = planes.channels();
    let wanted = name.or(if channels.len() == 1 { None } else { Some("G") });
    let found = channels.iter().find(|channel| wanted.is_none_or(|name| channel.name == name));
    found.ok_or_else(|| {
        let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
        Invalid::new("channel", format!("the picture has no channel {}", wanted.unwrap_or_default()))
            .help(format!("it has {}; choose one by --channel", names.join(", ")))
    })
}

fn mtf_text(edge: &EdgeResponse) -> String {
    let frequency = |f: Option<f64>| f.map_or("not reached".to_owned(), |f| format!("{f:.4} cycles per pixel"));
    let run = if edge.is_vertical { "columns" } else { "rows" };
    let mut text = format!(
        "edge {:.2}° off the {run}\nMTF50  {}\nMTF10  {}\nat half a cycle per pixel  {:.4}\n\ncycles per pixel  MTF",
        edge.angle_deg,
        frequency(edge.mtf50_cy_per_px),
        frequency(edge.mtf10_cy_per_px),
        edge.at_nyquist
    );
    for (f, m) in edge.frequency_cy_per_px.iter().zip(&edge.mtf).step_by(5).filter(|(f, _)| **f <= 0.5) {
        text += &format!("\n{f:>16.2}  {m:.4}");
    }
    text
}

fn histogram_text(histograms: &[Histogram]) -> String {
    let mut text = "channel  mean  standard deviation  1 %  5 %  25 %  50 %  75 %  95 %  99 %  at the top".to_owned();
    for h in histograms {
        let percentiles: Vec<String> = h.percentiles.iter().map(|p| format!("{p:.5}")).collect();
        let full = h.above + h.counts.last().copied().unwrap_or(0);
        text +=
            &format!("\n{}  {:.5}  {:.5}  {}  {full}", h.channel, h.mean, h.standard_deviation, percentiles.join("  "));
    }
    text
}

fn checker_text(report: &CheckerReport) -> String {
    let mut text = "patch  pixels  L* a* b*  expected  ΔE00".to_owned();
    let lab = |lab: &[f64; 3]| lab.map(|v| format!("{v:.2}")).join(" ");
    for patch in &report.patches {
        text += &format!(
            "\n{}  {}  {}  {}  {:.2}",
            patch.name,
            patch.pixels,
            lab(&patch.lab),
            lab(&patch.expected_lab),
            patch.delta_e_2000
        );
    }
    text + &format!(
        "\n\nΔE00 mean {:.3}, median {:.3}, largest {:.3}; ΔE*ab mean {:.3}; brightness brought to the chart's by {:.4}",
        report.mean_delta_e_2000,
        report.median_delta_e_2000,
        report.largest_delta_e_2000,
        report.mean_delta_e_76,
        report.scale
    )
}

/// Likeness of two pictures.
#[derive(Serialize)]
struct Similarity {
    channels: Vec<ChannelSimilarity>,
    /// Of pictures with R, G and B: colour differences of their pixels, in the colours that the files say.
    mean_delta_e_2000: Option<f64>,
    largest_delta_e_2000: Option<f64>,
}

#[derive(Serialize)]
struct ChannelSimilarity {
    channel: String,
    /// Of the values as the files hold them; `null` where they are the same.
    psnr_db: Option<f64>,
    ssim: Option<f64>,
}

fn similarity(args: &PictureArgs, b_path: &Path) -> Result<Similarity> {
    let (a, b) = (args.read()?, args.read_other(b_path)?);
    let size = [b.mean.width(), b.mean.height()];
    if [a.mean.width(), a.mean.height()] != size || a.full_scale != b.full_scale {
        let [of_a, of_b] = [&a, &b].map(|p| {
            let full_scale = p.full_scale.map_or_else(String::new, |top| format!(" up to {top}"));
            format!("{} × {} numbers{full_scale}", p.mean.width(), p.mean.height())
        });
        let message = format!("the two pictures have different sizes or bits: {of_a}, {of_b}");
        return Err(Error::Usage { message, help: Some("compare pictures of one size and kind".into()) });
    }
    let mut channels = Vec::new();
    for theirs in b.mean.channels() {
        let Some(ours) = a.mean.plane(&theirs.name) else {
            let message = format!("{} has no channel {}", args.picture.display(), theirs.name);
            return Err(Error::Usage { message, help: None });
        };
        let largest = || theirs.data.iter().copied().fold(0.0, f32::max).into();
        let peak: f64 = b.full_scale.unwrap_or_else(largest);
        let squares: f64 = ours.iter().zip(&theirs.data).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        let mean = squares / theirs.data.len() as f64;
        channels.push(ChannelSimilarity {
            channel: theirs.name.clone(),
            psnr_db: (mean > 0.0).then(|| 10.0 * (peak * peak / mean).log10()),
            ssim: ssim(ours, &theirs.data, size, peak),
        });
    }
    // What is counted or measured has no colour.
    let is_shown =
        [&a, &b].iter().all(|p| p.unit.is_none() || p.full_scale.is_some() && p.unit.as_deref() != Some("DN"));
    let linear = || Ok::<_, Error>((args.read_linear(&args.picture)?, args.read_linear(b_path)?));
    let differences = if is_shown { linear().map(|(a, b)| colour_differences(&a, &b))? } else { None };
    Ok(Similarity {
        channels,
        mean_delta_e_2000: differences.as_ref().map(|all| all.iter().sum::<f64>() / all.len() as f64),
        largest_delta_e_2000: differences.as_ref().map(|all| all.iter().copied().fold(0.0, f64::max)),
    })
}

/// ΔE₀₀ of every pixel of two linear sRGB pictures.
fn colour_differences(a: &Planes, b: &Planes) -> Option<Vec<f64>> {
    let planes = |picture: &Planes| -> Option<[Vec<f32>; 3]> {
        let [r, g, b] = ["R", "G", "B"].map(|name| picture.plane(name).map(<[f32]>::to_vec));
        Some([r?, g?, b?])
    };
    let (a, b) = (planes(a)?, planes(b)?);
    let (white, to_xyz) = (ColourSpace::Srgb.white(), ColourSpace::Srgb.to_xyz());
    let lab = |planes: &[Vec<f32>; 3], i: usize| {
        let rgb = DVec3::from_array([0, 1, 2].map(|c| f64::from(planes[c][i])));
        cielab::from_xyz(to_xyz * rgb, white)
    };
    Some((0..a[0].len()).map(|i| difference::delta_e_2000(lab(&b, i), lab(&a, i))).collect())
}

fn similarity_text(report: &Similarity) -> String {
    let number = |value: Option<f64>, digits: usize| value.map_or("–".to_owned(), |v| format!("{v:.digits$}"));
    let mut text = "channel  PSNR dB  SSIM".to_owned();
    for c in &report.channels {
        text += &format!("\n{}  {}  {}", c.channel, number(c.psnr_db, 3), number(c.ssim, 5));
    }
    if let (Some(mean), Some(largest)) = (report.mean_delta_e_2000, report.largest_delta_e_2000) {
        text += &format!("\n\nΔE00 of pixels: mean {mean:.3}, largest {largest:.3}");
    }
    text
}
