//! `photosite compare`: the difference between two images, and whether noise explains it.

use std::path::{Path, PathBuf};

use clap::Args;

use super::compare_report::text;
use super::log::warning;
use super::print::{print_json, println_text, refuse_existing};
use super::remedies::in_options;
use photosite_capture::report::{ComparisonReport, DifferenceImage};
use photosite_core::image::NotFinite;
use photosite_core::output::write_whole;
use photosite_core::sandbox::trust;
use photosite_core::{Error, Invalid, Result};
use photosite_develop::EncodedImage;
use photosite_files::developed::write_png;
use photosite_files::image_file::{ImageFile, read_image_file};
use photosite_files::raw_file::read_raw;
use photosite_measure::validation::{
    ComparedImage, ComparisonSettings, FalseColour, Limits, NonUniformity, compare, false_colour,
};
use photosite_raw::Pixels;

const EXAMPLES: &str = "\
Examples:
  photosite compare out/electrons.exr mitsuba.exr --picture differences.png
  photosite compare photograph.dng twin/raw.dng --noise-profile --prnu 0.8";

/// Compare two images: is it noise, or do they differ?
///
/// A and B are EXR, HDR, PNG, TIFF, JPEG or raw files (DNG, PGM, NPY); B is the reference. The exit status is 1 if
/// noise does not explain the differences, a limit is exceeded, or pixels are not finite.
///
/// The test needs the variances of both images: channels without them are not tested, and are named. photosite writes
/// the variance of the mean of X as channel variance.X of electrons.exr. For an image by Mitsuba 3 there are three ways
/// to get them: render.py, which `photosite export-mitsuba` writes beside scene.xml, renders batches with different
/// seeds and writes their mean and its variance; --variance-b takes variances from elsewhere, such as the spread of
/// several runs of any program; and --samples-b computes them from the second moments m2_X of Mitsuba's integrator
/// moment. Raw files state that of their temporal noise in their noise profile: --noise-profile takes it. Write
/// --variance-b 0 if B is exact. A variance from fewer than 64 batches or samples is too uncertain for a verdict.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct CompareArgs {
    /// An image. In an EXR file the channel variance.X is the variance of X.
    a: PathBuf,
    /// The reference, of the same size and unit.
    b: PathBuf,
    /// Variance of A, of the mean of each pixel: a number for all, 0 if A is exact, or an EXR file whose channel
    /// variance.X, or else X, is that of X [default: what its file says].
    #[arg(long, value_name = "X|FILE", allow_hyphen_values = true)]
    variance_a: Option<String>,
    /// Variance of B, likewise.
    #[arg(long, value_name = "X|FILE", allow_hyphen_values = true)]
    variance_b: Option<String>,
    /// Samples per pixel whose second moments m2_X stand beside X in A, as of Mitsuba's integrator moment with a box
    /// filter and 32-bit floats: variance (m2 − m²)/(N − 1).
    #[arg(long, value_name = "N", conflicts_with = "variance_a", value_parser = clap::value_parser!(u64).range(2..))]
    samples_a: Option<u64>,
    /// Samples per pixel of B, as --samples-a for A.
    #[arg(long, value_name = "N", conflicts_with = "variance_b", value_parser = clap::value_parser!(u64).range(2..))]
    samples_b: Option<u64>,
    /// Take the variances of raw files from their noise profiles (DNG NoiseProfile), which are those of temporal noise. A
    /// variance that is stated beside it is taken as it is.
    #[arg(long)]
    noise_profile: bool,
    /// Photo response non-uniformity in percent, where A and B are of two cameras, each with a pattern of its own; 0 of
    /// one and the same.
    #[arg(long, value_name = "PERCENT", requires = "noise_profile", value_parser = not_negative, default_value_t = 0.0)]
    prnu: f64,
    /// Dark signal non-uniformity of each of two cameras, DN.
    #[arg(long, value_name = "DN", requires = "noise_profile", value_parser = not_negative, default_value_t = 0.0)]
    dsnu: f64,
    /// Compare the masked pixels of raw files, too, not only those that see light.
    #[arg(long)]
    masked: bool,
    /// Compare only these channels, for example R,G; for a mosaic raw, R, G or B.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    channels: Option<Vec<String>>,
    /// Probability of reporting a difference between images that agree.
    #[arg(long, value_name = "ALPHA", default_value_t = 0.01, value_parser = probability)]
    alpha: f64,
    /// Largest difference allowed in the mean of a channel, in percent of that of B.
    #[arg(long, value_name = "PERCENT", value_parser = not_negative)]
    max_mean_difference: Option<f64>,
    /// Largest root mean squared error allowed for a channel, in the unit of the images.
    #[arg(long, value_name = "X", value_parser = not_negative)]
    max_rmse: Option<f64>,
    /// Largest relative mean squared error allowed for a channel.
    #[arg(long, value_name = "X", value_parser = not_negative)]
    max_relative_mse: Option<f64>,
    /// The ε of the relative MSE, the mean of (a − b)²/(b² + ε·mean(b)²).
    #[arg(long, value_name = "X", default_value_t = 0.01, value_parser = not_negative)]
    epsilon: f64,
    /// White for the PSNR [default: the largest number that the file can hold; for EXR the largest of B].
    #[arg(long, value_name = "X", value_parser = positive)]
    peak: Option<f64>,
    /// Number of the most different pixels to list.
    #[arg(long, value_name = "N", default_value_t = 5)]
    worst: usize,
    /// Write a PNG image of the differences: blue where A is below B, red where it is above.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Difference at the ends of the colour scale [default: 4 for z-scores; for relative differences, what nearly all
    /// pixels stay within].
    #[arg(long, value_name = "X", requires = "picture", value_parser = positive)]
    range: Option<f64>,
    /// Overwrite the image if it exists.
    #[arg(long)]
    force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors; the exit status tells the result.
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

/// Compares the images; returns whether noise explains their differences and no limit is exceeded.
pub(super) fn run(args: &CompareArgs) -> Result<bool> {
    if let Some(path) = &args.picture {
        refuse_image(path, args.force)?;
    }
    let is_stated = |variance: &Option<String>, samples: &Option<u64>| variance.is_some() || samples.is_some();
    if args.noise_profile
        && is_stated(&args.variance_a, &args.samples_a)
        && is_stated(&args.variance_b, &args.samples_b)
    {
        let message = "--noise-profile has no effect where the variances of both images are stated".to_owned();
        return Err(Error::Usage { message, help: Some("leave out one or the other".into()) });
    }
    let a = read(args, &args.a, args.variance_a.as_deref(), args.samples_a)?;
    let b = read(args, &args.b, args.variance_b.as_deref(), args.samples_b)?;
    if !args.quiet {
        warn(&a, &b);
    }
    let settings = ComparisonSettings {
        channels: args.channels.clone(),
        alpha: args.alpha,
        epsilon: args.epsilon,
        peak: args.peak,
        worst: args.worst,
    };
    let limits = Limits {
        mean_difference_percent: args.max_mean_difference,
        rmse: args.max_rmse,
        relative_mse: args.max_relative_mse,
    };
    // What can be wrong from here on is that the two files, or the channels asked for, do not fit together.
    let comparison = compare(&a, &b, &settings).map_err(unfit)?;
    let picture = match &args.picture {
        Some(path) => Some(write_image(path, false_colour(&a, &b, &settings, args.range).map_err(unfit)?)?),
        None => None,
    };
    let report = ComparisonReport { picture, ..ComparisonReport::new(comparison, [&a, &b], &limits, in_options) };
    if args.json {
        print_json(&report)?;
    } else if !args.quiet {
        println_text(&text(&report))?;
    }
    Ok(report.failures.is_empty())
}

/// Warns of statements of the files that are left out, and of statements about pixel values that only one file makes;
/// the values are compared as they are.
fn warn(a: &ComparedImage, b: &ComparedImage) {
    // A file that is compared with itself is told of once.
    let files = if a.name == b.name { 1 } else { 2 };
    for (image, other) in [(a, b), (b, a)].into_iter().take(files) {
        image.said().for_each(|what| warning!("{what}"));
        if let Some(found) = NotFinite::of(&image.mean) {
            warning!("{}: {found}", image.name);
        }
        for stated in image.stated.iter().filter(|stated| !other.stated.contains(stated)) {
            warning!(
                "{} states {stated}, {} does not; their pixel values are compared as they are",
                image.name,
                other.name
            );
        }
    }
}

/// Usage error of two files that do not fit together.
fn unfit(Invalid { message, help, .. }: Invalid) -> Error {
    Error::Usage { message, help }
}

/// Image with the variances that its file or the command line states.
fn read(args: &CompareArgs, path: &Path, variance: Option<&str>, samples: Option<u64>) -> Result<ComparedImage> {
    let pixels = if args.masked { Pixels::All } else { Pixels::Active };
    if args.noise_profile && variance.is_none() && samples.is_none() {
        let raw = read_raw(path)?;
        let image = ImageFile::of_raw(path.display().to_string(), raw.linear().into_owned(), pixels).as_it_lies();
        let pattern = NonUniformity { prnu: args.prnu / 100.0, dsnu_dn: args.dsnu };
        return image.with_noise_profile(&raw, pattern).map_err(unfit);
    }
    let image = read_image_file(path, pixels)?;
    if let Some(samples) = samples {
        return image.with_second_moments(samples).map_err(unfit);
    }
    let Some(text) = variance else { return Ok(image) };
    trust(text.as_ref());
    match text.parse::<f64>() {
        Ok(variance) if variance.is_finite() && variance >= 0.0 => Ok(image.with_constant_variance(variance)),
        Ok(_) => Err(Error::Usage {
            message: format!("{text} is not a variance"),
            help: Some("write a number of at least 0, or the name of an EXR file".into()),
        }),
        Err(_) => {
            let variances = read_image_file(Path::new(text), pixels)?;
            let notes = image.notes.iter().cloned().chain(variances.said()).collect();
            ComparedImage { notes, ..image }.with_variances_from(&variances).map_err(unfit)
        }
    }
}

/// Refuses an output image that cannot be written, before anything is read.
fn refuse_image(path: &Path, force: bool) -> Result<()> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        let message = format!("{} is not the name of a PNG file", path.display());
        return Err(Error::Usage { message, help: Some("give a name that ends with .png".into()) });
    }
    refuse_existing(path, force)
}

fn write_image(path: &Path, image: FalseColour) -> Result<DifferenceImage> {
    let FalseColour { width, height, pixels, shown, range } = image;
    let image = EncodedImage::srgb8(width, height, 3, pixels.into_flattened());
    write_whole(path, |to| write_png(&image, to))?;
    Ok(DifferenceImage { file: path.display().to_string(), shows: shown.name(), range })
}

fn number(text: &str, is_fit: fn(f64) -> bool, wanted: &str) -> Result<f64, String> {
    text.parse().ok().filter(|&x: &f64| x.is_finite() && is_fit(x)).ok_or_else(|| format!("write a number {wanted}"))
}

fn probability(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0 && x < 1.0, "between 0 and 1")
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |x| x >= 0.0, "of at least 0")
}

fn positive(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0, "above 0")
}
