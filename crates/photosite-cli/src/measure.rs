//! `photosite measure`: figures of images.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use glam::DVec3;
use serde::Serialize;

use super::log::warning;
use super::measured_edges::{MeasuredEdge, PlotFormat, edges_text, noise_warning};
use super::print::{print_json, println_text, refuse_existing, write_result};
use super::sensitivities::{self, SensitivitiesArgs};
use photosite_capture::report::{pixel_pitch_m, stated_pitch_m};
use photosite_core::colour::{ColourSpace, cielab, difference};
use photosite_core::image::{Channel, NotFinite, Planes};
use photosite_core::{Error, Invalid, Result, Sandbox};
use photosite_files::formats::{Format, lists::names};
use photosite_files::image_file::read_image_file;
use photosite_files::linear_image::{LinearFile, read_linear_image};
use photosite_files::raw_file::refuse_staggered_rows;
use photosite_measure::measures::{CheckerReport, Histogram, histogram, slanted_edge, slanted_edges, ssim};
use photosite_measure::validation::ComparedImage;
use photosite_pipeline::measure_checker;
use photosite_raw::Pixels;

const EXAMPLES: &str = "\
Examples:
  photosite measure mtf out/image.png --region 100,80,40,60
  photosite measure mtf out/image.png --all --plot mtf.svg";

/// Measure images: sharpness, colours, likeness, histograms.
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
    /// Transfer function (MTF, SFR) from slanted edges after ISO 12233.
    ///
    /// Frequencies are in cycles per pixel and, where the pixel pitch is known, in cycles (line pairs) per mm on the
    /// sensor: from --pitch-um, a DNG file, or the capture.json beside the image. The standard error is what the noise
    /// of the pixels leaves.
    Mtf(MtfArgs),
    /// Histogram of each channel.
    Histogram {
        #[command(flatten)]
        image: ImageArgs,
        /// Bins of equal width.
        #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65_536))]
        bins: u32,
    },
    /// Colour differences of a colour checker, which is located by the capture.
    Checker {
        #[command(flatten)]
        image: ImageArgs,
        /// The capture of the image, or the capture.json beside it: materials with reflectances
        /// colour-checker/… are the patches.
        #[arg(long, value_name = "FILE")]
        capture: PathBuf,
    },
    /// Spectral sensitivities of a camera from photographs of a chart.
    ///
    /// The patches are sampled about their centres. Each channel gets the most probable curve of a positive prior, with its
    /// standard errors; images in further lights make it sharper. Light beyond 380 to 780 nm must not reach the sensor.
    Sensitivities(SensitivitiesArgs),
    /// PSNR, SSIM and colour differences of two images; B is the reference.
    Similarity {
        #[command(flatten)]
        image: ImageArgs,
        /// The reference.
        b: PathBuf,
    },
}

#[derive(Args)]
struct MtfArgs {
    #[command(flatten)]
    image: ImageArgs,
    /// The part of the image with the edge: column, row, columns, rows [default: all].
    #[arg(long, value_name = "X,Y,W,H", value_delimiter = ',', num_args = 1)]
    region: Option<Vec<usize>>,
    /// Find and measure every slanted edge of the image.
    #[arg(long, conflicts_with = "region")]
    all: bool,
    /// The channel to measure [default: G, or the only one].
    #[arg(long, value_name = "NAME")]
    channel: Option<String>,
    /// Pixel pitch, µm: one number, or width and height [default: what the files say].
    #[arg(long, value_name = "UM[,UM]", value_delimiter = ',', num_args = 1)]
    pitch_um: Option<Vec<f64>>,
    /// Plot the modulation over frequency: a .svg or .png file.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Overwrite the plot if it exists.
    #[arg(long, requires = "plot")]
    force: bool,
}

#[derive(Args)]
struct ImageArgs {
    #[arg(help = format!("An image or a raw file: {}", names(Format::reads_images)))]
    image: PathBuf,
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

impl ImageArgs {
    fn read(&self) -> Result<ComparedImage> {
        self.read_other(&self.image)
    }

    fn read_other(&self, path: &Path) -> Result<ComparedImage> {
        let image = read_image_file(path, self.pixels())?;
        image.said().for_each(|what| warning!("{what}"));
        Ok(image)
    }

    fn pixels(&self) -> Pixels {
        if self.masked { Pixels::All } else { Pixels::Active }
    }

    /// Reads planes of linear light, white at 1 where the file has codes; colours are sRGB.
    fn read_linear(&self, path: &Path) -> Result<Planes> {
        let LinearFile { light, notes } = read_linear_image(path, self.linear, self.pixels())?;
        let said = notes.of_pixels_as_they_lie(&path.display().to_string());
        said.iter().for_each(|what| warning!("{what}"));
        Ok(light.planes)
    }

    fn print<T: Serialize>(&self, report: &T, text: impl FnOnce(&T) -> String) -> Result<()> {
        if self.json { print_json(report) } else { println_text(&text(report)) }
    }
}

pub(super) fn run(args: &MeasureArgs, sandbox: &Sandbox) -> Result<()> {
    match &args.measure {
        Measure::Mtf(args) => mtf(args),
        Measure::Histogram { image, bins } => {
            let read = image.read()?;
            if let Some(found) = NotFinite::of(&read.mean) {
                warning!("{}: {found}; they are left out", read.name);
            }
            let range = read.full_scale.map(|full_scale| [0.0, full_scale]);
            let of = |channel| histogram(channel, *bins as usize, range);
            image.print(&read.mean.channels().iter().map(of).collect::<Vec<_>>(), |all| histogram_text(all))
        }
        Measure::Checker { image, capture } => {
            let planes = image.read_linear(&image.image)?;
            NotFinite::refuse(&planes).map_err(|invalid| invalid.in_file(&image.image))?;
            image.print(&measure_checker(&planes, &image.image, capture, sandbox)?, checker_text)
        }
        Measure::Sensitivities(args) => sensitivities::run(args),
        Measure::Similarity { image, b } => image.print(&similarity(image, b)?, similarity_text),
    }
}

/// Measures one edge, or all of them.
fn mtf(args: &MtfArgs) -> Result<()> {
    let path = &args.image.image;
    let plot = args.plot.as_deref().map(|plot| Ok::<_, Error>((plot, PlotFormat::of(plot)?))).transpose()?;
    plot.iter().try_for_each(|(plot, _)| refuse_existing(plot, args.force))?;
    let stated = args.pitch_um.as_deref().map(stated_pitch_m).transpose().map_err(usage)?;
    refuse_staggered_rows(path)?;
    let planes = args.image.read_linear(path)?;
    let plane = chosen(&planes, args.channel.as_deref()).map_err(usage)?;
    let size = [planes.width(), planes.height()];
    let found = if args.all {
        slanted_edges(&plane.data, size)
    } else {
        let region = args.region.as_deref().map_or(Ok([0, 0, size[0], size[1]]), region).map_err(usage)?;
        vec![(region, slanted_edge(&plane.data, size, region).map_err(usage)?)]
    };
    if found.is_empty() {
        return Err(Error::Usage {
            message: format!("{}: no slanted edge is found", path.display()),
            help: Some(
                "an edge is found where it is straight, at least 24 pixels long, 1° to 40° off the pixels, and 8 pixels from others; --region measures the one that it holds"
                    .into(),
            ),
        });
    }
    let pitch_m = stated.map_or_else(|| pixel_pitch_m(path, size), |pitch| Ok(Some(pitch)))?;
    let edges: Vec<MeasuredEdge> = found.into_iter().map(|found| MeasuredEdge::new(found, pitch_m)).collect();
    noise_warning(&edges).iter().for_each(|what| warning!("{}: {what}", path.display()));
    if let Some((plot, format)) = plot {
        write_result(plot, args.force, |to| to.write_all(&format.file(&edges)))?;
    }
    match &edges[..] {
        [edge] if !args.all => args.image.print(edge, |_| edges_text(&edges)),
        _ => args.image.print(&edges, |all| edges_text(all)),
    }
}

/// Column, row, width and height of a region.
fn region(given: &[usize]) -> std::result::Result<[usize; 4], Invalid> {
    <[usize; 4]>::try_from(given).map_err(|_| {
        Invalid::new("region", format!("{} numbers instead of 4", given.len()))
            .help("for example --region 100,80,40,60")
    })
}

/// Usage error from values of the command line.
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
        Invalid::new("channel", format!("the image has no channel {}", wanted.unwrap_or_default()))
            .help(format!("it has {}; choose one by --channel", names.join(", ")))
    })
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

/// Similarity of two images.
#[derive(Serialize)]
struct Similarity {
    channels: Vec<ChannelSimilarity>,
    /// Mean CIEDE2000 difference of the pixels of images with R, G and B, in the colours that the files state.
    mean_delta_e_2000: Option<f64>,
    largest_delta_e_2000: Option<f64>,
}

#[derive(Serialize)]
struct ChannelSimilarity {
    channel: String,
    /// PSNR of the values as the files hold them, dB; `null` where they are equal.
    psnr_db: Option<f64>,
    ssim: Option<f64>,
}

fn similarity(args: &ImageArgs, b_path: &Path) -> Result<Similarity> {
    let a = args.read()?;
    // A file that is measured against itself is told of once.
    let b = if *b_path == args.image { a.clone() } else { args.read_other(b_path)? };
    for (image, path) in [(&a, args.image.as_path()), (&b, b_path)] {
        NotFinite::refuse(&image.mean).map_err(|invalid| invalid.in_file(path))?;
    }
    let size = [b.mean.width(), b.mean.height()];
    if [a.mean.width(), a.mean.height()] != size || a.full_scale != b.full_scale {
        let [of_a, of_b] = [&a, &b].map(|p| {
            let full_scale = p.full_scale.map_or_else(String::new, |top| format!(" up to {top}"));
            format!("{} × {} numbers{full_scale}", p.mean.width(), p.mean.height())
        });
        let message = format!("the two images have different sizes or bits: {of_a}, {of_b}");
        return Err(Error::Usage { message, help: Some("compare images of one size and kind".into()) });
    }
    let mut channels = Vec::new();
    for theirs in b.mean.channels() {
        let Some(ours) = a.mean.plane(&theirs.name) else {
            let message = format!("{} has no channel {}", args.image.display(), theirs.name);
            return Err(Error::Usage { message, help: None });
        };
        let largest = || theirs.data.iter().copied().fold(0.0, f32::max).into();
        let peak: f64 = b.full_scale.unwrap_or_else(largest);
        let squares: f64 = ours.iter().zip(&theirs.data).map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2)).sum();
        let mean = squares / theirs.data.len() as f64;
        if mean > 0.0 && peak <= 0.0 {
            let message = "has no value above 0, which would be white";
            let invalid = Invalid::new("", format!("channel {} {message}", theirs.name));
            return Err(invalid.help("give the brighter image as reference, or compare the two").in_file(b_path));
        }
        channels.push(ChannelSimilarity {
            channel: theirs.name.clone(),
            psnr_db: (mean > 0.0).then(|| 10.0 * (peak * peak / mean).log10()),
            ssim: ssim(ours, &theirs.data, size, peak).map(|found| if mean > 0.0 { found } else { 1.0 }),
        });
    }
    // What is counted or measured has no colour.
    let is_shown =
        [&a, &b].iter().all(|p| p.unit.is_none() || p.full_scale.is_some() && p.unit.as_deref() != Some("DN"));
    // What is to be said of the files was said.
    let light = |path| Ok(read_linear_image(path, args.linear, args.pixels())?.light.planes);
    let linear = || Ok::<_, Error>((light(&args.image)?, light(b_path)?));
    let differences = if is_shown { linear().map(|(a, b)| colour_differences(&a, &b))? } else { None };
    Ok(Similarity {
        channels,
        mean_delta_e_2000: differences.as_ref().map(|all| all.iter().sum::<f64>() / all.len() as f64),
        largest_delta_e_2000: differences.as_ref().map(|all| all.iter().copied().fold(0.0, f64::max)),
    })
}

/// CIEDE2000 difference ΔE₀₀ of every pixel of two linear sRGB images.
fn colour_differences(a: &Planes, b: &Planes) -> Option<Vec<f64>> {
    let planes = |image: &Planes| -> Option<[Vec<f32>; 3]> {
        let [r, g, b] = ["R", "G", "B"].map(|name| image.plane(name).map(<[f32]>::to_vec));
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
