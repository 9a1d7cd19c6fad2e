//! `photosite compare`: how far two pictures lie apart, and whether noise explains it.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use photosite::develop::EncodedPicture;
use photosite::io::developed::write_png;
use photosite::io::output::write_whole;
use photosite::io::picture_file::read_picture_file;
use photosite::raw::Pixels;
use photosite::validation::{Comparison, FalseColour, Limits, Picture, Settings, compare, failures, false_colour};
use photosite::{Error, Invalid, Result};
use serde::Serialize;

use super::compare_text::text;
use super::{print_json, println_out, refuse_existing};

/// Compare two pictures: errors per channel, and where variances are known whether noise explains them.
///
/// A and B are EXR, PNG, TIFF or raw files (DNG, PGM, NPY); B counts as the reference. Exit status 1: noise does not
/// explain the differences, a limit is passed, or pixels are not finite.
#[derive(Args)]
pub(super) struct CompareArgs {
    /// A picture. In an EXR file the channel variance.X is the variance of X.
    a: PathBuf,
    /// The reference, of the same size and unit.
    b: PathBuf,
    /// Compare the masked pixels of raw files, too, not only those that see light.
    #[arg(long)]
    masked: bool,
    /// Compare these channels only, for example R,G; of a mosaic raw, R, G or B.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    channels: Option<Vec<String>>,
    /// Probability of saying "differ" of pictures that agree.
    #[arg(long, value_name = "ALPHA", default_value_t = 0.01, value_parser = probability)]
    alpha: f64,
    /// Most that the mean of a channel may differ, in percent of that of B.
    #[arg(long, value_name = "PERCENT", value_parser = not_negative)]
    max_mean_difference: Option<f64>,
    /// Most that the root mean squared error of a channel may be, in the unit of the pictures.
    #[arg(long, value_name = "X", value_parser = not_negative)]
    max_rmse: Option<f64>,
    /// Most that the relative mean squared error of a channel may be.
    #[arg(long, value_name = "X", value_parser = not_negative)]
    max_relative_mse: Option<f64>,
    /// The ε of the relative MSE, the mean of (a − b)²/(b² + ε·mean(b)²).
    #[arg(long, value_name = "X", default_value_t = 0.01, value_parser = not_negative)]
    epsilon: f64,
    /// White for the PSNR [default: the largest number that the file can hold, of EXR the largest of B].
    #[arg(long, value_name = "X", value_parser = positive)]
    peak: Option<f64>,
    /// How many of the pixels that differ most to list.
    #[arg(long, value_name = "N", default_value_t = 5)]
    worst: usize,
    /// Write a PNG picture of the differences: blue where A is below B, red where it is above.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// The difference at the ends of the picture's colours [default: 4 for z-scores; of relative differences, what nearly
    /// all pixels stay within].
    #[arg(long, value_name = "X", requires = "picture", value_parser = positive)]
    range: Option<f64>,
    /// Overwrite the picture if it exists.
    #[arg(long)]
    force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors: the exit status tells.
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

/// The object that `--json` prints.
#[derive(Serialize)]
pub(super) struct Report {
    pub(super) a: FileReport,
    pub(super) b: FileReport,
    #[serde(flatten)]
    pub(super) comparison: Comparison,
    /// "agree", "differ", or "not judged" without variances and limits.
    pub(super) outcome: &'static str,
    /// Why the pictures differ.
    pub(super) failures: Vec<String>,
    pub(super) picture: Option<PictureReport>,
}

/// A picture that was compared.
#[derive(Serialize)]
pub(super) struct FileReport {
    pub(super) file: String,
    /// `null` where the file does not say.
    pub(super) unit: Option<String>,
    pub(super) channels: Vec<String>,
    pub(super) variances: bool,
}

/// The picture that was written.
#[derive(Serialize)]
pub(super) struct PictureReport {
    pub(super) file: String,
    pub(super) shows: &'static str,
    /// The ends of its colours lie at ± this.
    pub(super) range: f64,
}

pub(super) fn run(args: &CompareArgs) -> Result<ExitCode> {
    if let Some(path) = &args.picture {
        refuse_picture(path, args.force)?;
    }
    let pixels = if args.masked { Pixels::All } else { Pixels::Active };
    let (a, b) = (read_picture_file(&args.a, pixels)?, read_picture_file(&args.b, pixels)?);
    let settings = Settings {
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
    let unfit = |Invalid { message, help, .. }| Error::Usage { message, help };
    let comparison = compare(&a, &b, &settings).map_err(unfit)?;
    let picture = match &args.picture {
        Some(path) => Some(write_picture(path, false_colour(&a, &b, &settings, args.range).map_err(unfit)?)?),
        None => None,
    };
    let failures = failures(&comparison, &limits);
    let judged = comparison.verdict.is_some() || !limits.is_empty() || !failures.is_empty();
    let report = Report {
        a: file_report(&a),
        b: file_report(&b),
        comparison,
        outcome: if !judged {
            "not judged"
        } else if failures.is_empty() {
            "agree"
        } else {
            "differ"
        },
        failures,
        picture,
    };
    if args.json {
        print_json(&report)?;
    } else if !args.quiet {
        println_out(&text(&report))?;
    }
    Ok(if report.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn file_report(picture: &Picture) -> FileReport {
    FileReport {
        file: picture.name.clone(),
        unit: picture.unit.clone(),
        channels: picture.mean.channels().iter().map(|c| c.name.clone()).collect(),
        variances: !picture.variance.channels().is_empty(),
    }
}

/// Whether the picture can be written shows before anything is read.
fn refuse_picture(path: &Path, force: bool) -> Result<()> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        let message = format!("{} is no name of a PNG file", path.display());
        return Err(Error::Usage { message, help: Some("give a name that ends with .png".to_owned()) });
    }
    refuse_existing(path, force)
}

fn write_picture(path: &Path, picture: FalseColour) -> Result<PictureReport> {
    let FalseColour { width, height, pixels, shown, range } = picture;
    let picture = EncodedPicture::srgb8(width, height, 3, pixels.into_flattened());
    write_whole(path, |to| write_png(&picture, to))?;
    Ok(PictureReport { file: path.display().to_string(), shows: shown.name(), range })
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
