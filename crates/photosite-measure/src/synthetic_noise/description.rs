//! Description of noise that is to be added: the keys of `photosite noise add`, and their checks.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::image::Planes;
use photosite_core::schema_range::{above, within};

/// Name of the channel of transparency, which gets no noise.
pub(super) const ALPHA: &str = "A";

/// Noise to add to an image. What is left out is not there.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SyntheticNoise {
    /// Unit of σ and other levels. Left out: "picture".
    pub levels: Levels,
    /// Whether the channels of a colour image get noise of their own. Left out: "independent".
    pub channels: Channels,
    /// Value of white: what levels are parts of where they are of full scale, and what salt is. Left out: the largest
    /// number that the file can hold; floating-point numbers have no such.
    #[schemars(transform = above(0.0..))]
    pub full_scale: Option<f64>,
    /// Speckle of coherent light, multiplicative.
    pub speckle: Speckle,
    /// Grain of photographic film, g = f + c·f^γ·n.
    pub film_grain: FilmGrain,
    /// Normally distributed noise.
    pub gaussian: SymmetricNoise,
    /// Noise of a Laplace distribution (two-sided exponential), which has heavier tails.
    pub laplacian: SymmetricNoise,
    /// Noise that is uniform from −√3·σ to √3·σ.
    pub uniform: SymmetricNoise,
    /// Normally distributed noise with a standard deviation of its own at every pixel.
    pub sigma_map: SigmaMapFile,
    /// Impulses.
    pub salt_and_pepper: SaltAndPepper,
}

/// Unit of levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Levels {
    /// The pixel values of the image: codes from 0 to 255 of 8 bits, and what an EXR file holds.
    #[default]
    Picture,
    /// Parts of white: 0.02 is 5.1 of 255.
    FullScale,
}

/// Noise of the channels of a colour image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Channels {
    /// Each channel has noise of its own: coloured noise.
    #[default]
    Independent,
    /// All channels have the same noise: grey noise.
    Common,
}

/// Noise with a symmetric distribution of mean 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SymmetricNoise {
    /// Standard deviation σ; of multiplicative noise a part of the value, 0.1 for 10 %.
    #[schemars(transform = within(0.0..))]
    pub sigma: f64,
    /// Whether the noise is multiplicative: g = f·(1 + σ·n), not g = f + σ·n.
    pub multiplicative: bool,
}

/// Speckle: g = f·s, with s gamma-distributed of mean 1 and standard deviation C
/// ([Goodman07](photosite_core::references#goodman07)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Speckle {
    /// Contrast C, σ over mean, from 0 to 1: 1 is fully developed speckle, 1/√L the mean of L independent ones.
    #[schemars(transform = within(0.0..=1.0))]
    pub contrast: f64,
}

/// Grain of photographic film, noise that depends on the signal: g = f + c·f^γ·n with n normally distributed, of
/// variance 1 and the correlation exp(−d²/(2ℓ²)) of pixels d apart ([Jain89](photosite_core::references#jain89)).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FilmGrain {
    /// Factor c: the standard deviation at a value of 1 in the unit of the levels.
    #[schemars(transform = within(0.0..))]
    pub factor: f64,
    /// Exponent γ, from 0 to 4; 1/3 to 1/2 is usual.
    #[schemars(transform = within(0.0..=4.0))]
    pub exponent: f64,
    /// Correlation length ℓ, from 0 (none) to 100 pixels.
    #[schemars(transform = within(0.0..=100.0))]
    pub correlation_px: f64,
}

impl Default for FilmGrain {
    fn default() -> Self {
        Self { factor: 0.0, exponent: 0.5, correlation_px: 1.0 }
    }
}

/// A standard deviation for every pixel.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SigmaMapFile {
    /// An image of the same size that holds them, of one channel or the same ones, in the unit of the levels: EXR, NPY,
    /// TIFF, PNG, PGM.
    pub file: Option<PathBuf>,
}

/// Pixels that become white (salt) or black (pepper).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SaltAndPepper {
    /// Part of the pixels that do, from 0 to 1.
    #[schemars(transform = within(0.0..=1.0))]
    pub part: f64,
    /// Part of these that become white, from 0 to 1.
    #[schemars(transform = within(0.0..=1.0))]
    pub salt: f64,
}

impl Default for SaltAndPepper {
    fn default() -> Self {
        Self { part: 0.0, salt: 0.5 }
    }
}

impl SyntheticNoise {
    /// Refuses what is out of range, and a description of no noise at all. Keys of errors are those of the table.
    pub fn validate(&self) -> Result<(), Invalid> {
        let within = |key: &str, value: f64, most: f64| {
            if (0.0..=most).contains(&value) {
                return Ok(());
            }
            let range = if most == f64::MAX {
                "be a finite number of at least 0".to_owned()
            } else {
                format!("lie from 0 to {most}")
            };
            Err(Invalid::new(key, format!("must {range}, got {value}")).help("write 0 for none"))
        };
        if let Some(full_scale) = self.full_scale.filter(|&white| !(white > 0.0 && white.is_finite())) {
            let invalid = Invalid::new("full_scale", format!("must be above 0, got {full_scale}"));
            return Err(invalid.help("for example full_scale = 1.0"));
        }
        within("speckle.contrast", self.speckle.contrast, 1.0)?;
        within("film_grain.factor", self.film_grain.factor, f64::MAX)?;
        within("film_grain.exponent", self.film_grain.exponent, 4.0)?;
        within("film_grain.correlation_px", self.film_grain.correlation_px, 100.0)?;
        within("gaussian.sigma", self.gaussian.sigma, f64::MAX)?;
        within("laplacian.sigma", self.laplacian.sigma, f64::MAX)?;
        within("uniform.sigma", self.uniform.sigma, f64::MAX)?;
        within("salt_and_pepper.part", self.salt_and_pepper.part, 1.0)?;
        within("salt_and_pepper.salt", self.salt_and_pepper.salt, 1.0)?;
        let levels = [
            self.speckle.contrast,
            self.film_grain.factor,
            self.gaussian.sigma,
            self.laplacian.sigma,
            self.uniform.sigma,
            self.salt_and_pepper.part,
        ];
        if self.sigma_map.file.is_none() && levels.iter().all(|&level| level == 0.0) {
            let help = "set a level: gaussian.sigma, laplacian.sigma, uniform.sigma, speckle.contrast, \
                        film_grain.factor, sigma_map.file or salt_and_pepper.part";
            return Err(Invalid::new("", "there is no noise to add").help(help));
        }
        Ok(())
    }

    /// Tells of values that get no film grain, whose c·f^γ has no value below 0.
    pub fn without_grain(&self, planes: &Planes) -> Option<String> {
        let FilmGrain { factor, exponent, .. } = self.film_grain;
        if factor == 0.0 || exponent == 0.0 {
            return None;
        }
        let values = || planes.channels().iter().filter(|channel| channel.name != ALPHA).flat_map(|c| &c.data);
        let below = values().filter(|value| **value < 0.0).count();
        (below > 0).then(|| {
            format!(
                "film_grain: {below} of {} values lie below 0, where there is no light, and get no grain; \
                 film_grain.exponent = 0 gives all values the same",
                values().count()
            )
        })
    }

    /// Keys that are given and change nothing, with what they would need.
    pub fn without_effect(&self) -> Vec<String> {
        let symmetric = [("gaussian", self.gaussian), ("laplacian", self.laplacian), ("uniform", self.uniform)];
        let idle = symmetric.iter().filter(|(_, noise)| noise.multiplicative && noise.sigma == 0.0);
        let mut idle: Vec<String> =
            idle.map(|(name, _)| format!("{name}.multiplicative changes nothing without {name}.sigma")).collect();
        let grain = FilmGrain { factor: 0.0, ..self.film_grain };
        if self.film_grain.factor == 0.0 && grain != FilmGrain::default() {
            idle.push("film_grain changes nothing without film_grain.factor".to_owned());
        }
        if self.salt_and_pepper.part == 0.0 && self.salt_and_pepper != SaltAndPepper::default() {
            idle.push("salt_and_pepper.salt changes nothing without salt_and_pepper.part".to_owned());
        }
        idle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::image::Channel;

    #[test]
    fn values_below_0_without_grain_are_told() {
        let planes = |data: [f32; 4]| {
            let alpha = Channel { name: "A".to_owned(), data: vec![-1.0; 4] };
            Planes::new(2, 2, vec![Channel { name: "Y".to_owned(), data: data.to_vec() }, alpha]).expect("right sizes")
        };
        let noise = |factor, exponent| {
            let film_grain = FilmGrain { factor, exponent, correlation_px: 1.0 };
            SyntheticNoise { film_grain, ..SyntheticNoise::default() }
        };
        let dark = planes([0.5, -0.1, 0.0, -2.0]);
        let told = noise(0.1, 0.5).without_grain(&dark).expect("a warning");
        assert!(told.contains("2 of 4 values"), "{told}");
        assert_eq!(noise(0.1, 0.5).without_grain(&planes([0.5, 0.0, -0.0, 1.0])), None);
        assert_eq!(noise(0.1, 0.0).without_grain(&dark), None);
        assert_eq!(noise(0.0, 0.5).without_grain(&dark), None);
    }

    #[test]
    fn levels_out_of_range_are_refused_by_their_key() {
        let read = |key: &str, value: &str| -> Result<(), Invalid> {
            toml::from_str::<SyntheticNoise>(&format!("{key} = {value}\n")).expect("a table").validate()
        };
        for key in ["gaussian.sigma", "laplacian.sigma", "uniform.sigma", "film_grain.factor", "speckle.contrast"] {
            for value in ["-1.0", "nan", "inf", "-inf"] {
                assert_eq!(read(key, value).expect_err("refused").key, key, "{value}");
            }
            assert_eq!(read(key, "0.5"), Ok(()));
            assert!(read(key, "0").expect_err("no noise").message.contains("no noise"));
        }
        for (key, value) in [
            ("full_scale", "0"),
            ("full_scale", "nan"),
            ("speckle.contrast", "1.5"),
            ("film_grain.exponent", "4.5"),
            ("film_grain.correlation_px", "101"),
            ("salt_and_pepper.part", "1.01"),
            ("salt_and_pepper.salt", "-0.1"),
        ] {
            assert_eq!(read(key, value).expect_err("refused").key, key);
        }
    }

    #[test]
    fn keys_without_their_level_are_named() {
        let idle = |text: &str| toml::from_str::<SyntheticNoise>(text).expect("a table").without_effect();
        assert_eq!(idle("gaussian.sigma = 1\ngaussian.multiplicative = true\n"), [""; 0]);
        assert!(idle("uniform.multiplicative = true\n")[0].contains("uniform.sigma"));
        assert!(idle("film_grain.correlation_px = 3\n")[0].contains("film_grain.factor"));
        assert!(idle("salt_and_pepper.salt = 1\n")[0].contains("salt_and_pepper.part"));
    }
}
