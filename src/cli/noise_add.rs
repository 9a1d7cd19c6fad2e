//! `photosite noise add`: a picture of any program with synthetic noise.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::log::{say, warning};
use super::print::{print_json, refuse_existing, rounded, write_result};
use crate::capture::read_synthetic_noise;
use crate::io::noisy_picture::{NoisyPicture, make_noisy};
use crate::io::number_picture::{NumberFormat, write_numbers};
use crate::synthetic_noise::{Clipped, SyntheticNoise};
use crate::{Error, Invalid, Result};

const EXAMPLES: &str = "\
Example:
  photosite noise add photo.png -o noisy.png --set gaussian.sigma=4 --seed 2";

/// Add noise to a picture by any program.
///
/// Kinds of noise: --set gaussian.sigma=4, laplacian.sigma, uniform.sigma (each with multiplicative=true for g =
/// f·(1 + n)), speckle.contrast=0.5, film_grain.factor with exponent and correlation_px (g = f + c·f^γ·n),
/// sigma_map.file=FILE, salt_and_pepper.part=0.05; they can be combined. Levels are in the numbers of the picture
/// (0 to 255 for 8 bits), or with levels=full-scale in parts of white. channels=common gives all channels the same
/// noise. `photosite schema noise` describes all keys. Whole numbers are rounded and clipped, and the command says
/// how many were clipped; others stay as they are.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct NoiseAddArgs {
    /// A picture: PNG, TIFF, JPEG, EXR, HDR, PGM, PPM, NPY.
    picture: PathBuf,
    /// The picture with noise: .png, .tiff, .pgm, .ppm, .npy or .exr.
    #[arg(short, long, value_name = "FILE")]
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
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Print what was done as JSON on standard output.
    #[arg(long)]
    json: bool,
    /// Overwrite the picture if it exists.
    #[arg(long)]
    force: bool,
}

/// The object that `--json` prints.
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
    /// What the noise was added to.
    added_to: &'a str,
    /// Value of white, where it is known.
    full_scale: Option<f64>,
    /// `null` where numbers are neither rounded nor clipped.
    clipped: Option<Clipped>,
    warnings: &'a [String],
}

pub(super) fn run(args: &NoiseAddArgs) -> Result<()> {
    let format = NumberFormat::of(&args.output)?;
    refuse_existing(&args.output, args.force)?;
    let noise = read_synthetic_noise(&args.overrides)?;
    let noisy = make_noisy(&args.picture, &noise, args.linear, args.seed, format)?;
    let unfit = |Invalid { message, help, .. }| Error::Usage { message, help };
    format.check(&noisy.picture).map_err(unfit)?;
    write_result(&args.output, args.force, |to| write_numbers(&noisy.picture, format, to))?;
    let NoisyPicture { picture, clipped, added_to, white, warnings } = &noisy;
    let planes = &picture.planes;
    if args.json {
        return print_json(&Report {
            photosite_version: env!("CARGO_PKG_VERSION"),
            picture: args.picture.display().to_string(),
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
    if !args.quiet {
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
