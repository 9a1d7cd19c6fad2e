//! `photosite noise add`: an image of any program with synthetic noise.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::file_args::FileArgs;
use super::log::{say, warning};
use super::print::{print_json, rounded};
use photosite_capture::read_synthetic_noise;
use photosite_core::{Error, Invalid, Result};
use photosite_files::formats::{
    Format,
    lists::{endings, names},
};
use photosite_files::noisy_image::{NoisyImage, make_noisy};
use photosite_files::plain_image::write_plain_image;
use photosite_measure::synthetic_noise::{Clipped, SyntheticNoise};

const EXAMPLES: &str = "\
Example:
  photosite noise add photo.png -o noisy.png --set gaussian.sigma=4 --seed 2";

/// Add noise to an image by any program.
///
/// Kinds of noise: --set gaussian.sigma=4, laplacian.sigma, uniform.sigma (each with multiplicative=true for g = f·(1 +
/// n)), speckle.contrast=0.5, film_grain.factor with exponent and correlation_px (g = f + c·f^γ·n),
/// sigma_map.file=FILE, salt_and_pepper.part=0.05; they can be combined. Levels are in pixel values (0 to 255 for 8
/// bits), or with levels=full-scale in parts of white. channels=common gives all channels the same noise. `photosite
/// schema noise` describes all keys. Integers are rounded and clipped, and the command says how many were clipped;
/// floating-point values stay as they are.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct NoiseAddArgs {
    #[arg(help = format!("An image: {}", names(Format::reads_images)))]
    image: PathBuf,
    #[arg(short, long, value_name = "FILE", help = format!("The image with noise: {}", endings(Format::keeps_numbers)))]
    output: PathBuf,
    /// A key of the noise, for example --set gaussian.sigma=4.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Add the noise to linear light: codes are decoded before, as the file says or else as sRGB, and encoded after.
    #[arg(long)]
    linear: bool,
    /// Seed of the noise; another seed is another take.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,
    #[command(flatten)]
    file: FileArgs,
}

/// Object that `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    photosite_version: &'static str,
    picture: String,
    output: String,
    resolution_px: [usize; 2],
    channels: Vec<&'a str>,
    seed: u64,
    linear: bool,
    noise: &'a SyntheticNoise,
    /// Sentence that says what the noise was added to.
    added_to: &'a str,
    /// Value of white, where it is known.
    full_scale: Option<f64>,
    /// Counts of clipped values; `null` where values are neither rounded nor clipped.
    clipped: Option<Clipped>,
    warnings: &'a [String],
}

pub(super) fn run(args: &NoiseAddArgs) -> Result<()> {
    let format = Format::of_numbers(&args.output)?;
    args.file.check(&args.output)?;
    let noise = read_synthetic_noise(&args.overrides)?;
    let noisy = make_noisy(&args.image, &noise, args.linear, args.seed, format)?;
    let unfit = |Invalid { message, help, .. }| Error::Usage { message, help };
    format.check_numbers(&noisy.image).map_err(unfit)?;
    args.file.write(&args.output, |to| write_plain_image(&noisy.image, format, to))?;
    let NoisyImage { image, clipped, added_to, white, warnings } = &noisy;
    let planes = &image.planes;
    if args.file.json {
        return print_json(&Report {
            photosite_version: env!("CARGO_PKG_VERSION"),
            picture: args.image.display().to_string(),
            output: args.output.display().to_string(),
            resolution_px: [planes.width(), planes.height()],
            channels: planes.channels().iter().map(|channel| &channel.name[..]).collect(),
            seed: args.seed,
            linear: args.linear,
            noise: &noise,
            added_to,
            full_scale: *white,
            clipped: *clipped,
            warnings,
        });
    }
    if !args.file.quiet {
        warnings.iter().for_each(|what| warning!("{what}"));
        say!("added noise to {added_to}; {}; wrote {}", ends(*clipped), args.output.display());
    }
    Ok(())
}

fn ends(clipped: Option<Clipped>) -> String {
    let Some(Clipped { low, high, values }) = clipped else { return "nothing was rounded or clipped".to_owned() };
    let percent = rounded(100.0 * (low + high) as f64 / values.max(1) as f64, 2);
    format!("clipped {low} values at black and {high} at white ({percent} % of {values})")
}
