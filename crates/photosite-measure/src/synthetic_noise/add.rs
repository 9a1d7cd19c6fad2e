//! All kinds of noise on the planes of an image.

use rand::RngExt;
use rayon::prelude::*;

use photosite_core::image::{Channel, Planes};
use photosite_core::{Invalid, Remedy};

use super::description::{ALPHA, Channels, Levels, SymmetricNoise, SyntheticNoise};
use super::distributions::{Symmetric, speckle};
use super::film_grain::correlated_field;
use super::streams::{Kind, Streams};

/// Scale of an image's pixel values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Value of white; `None` where nobody says.
    pub white: Option<f64>,
}

/// Adds noise to all channels but transparency (`A`). `sigma_map` holds a σ for every pixel, of one channel or of the
/// same ones. Nothing is rounded or clipped.
pub fn add_noise(
    planes: &mut Planes,
    noise: &SyntheticNoise,
    scale: Scale,
    sigma_map: Option<&Planes>,
    seed: u64,
) -> Result<(), Invalid> {
    noise.validate()?;
    let white = || {
        scale.white.ok_or_else(|| {
            let message = "is not given, and floating-point numbers do not say what white is";
            Invalid::new("full_scale", message).help(Remedy::Example("full_scale=1".to_owned()))
        })
    };
    let unit = match noise.levels {
        Levels::Picture => 1.0,
        Levels::FullScale => white()?,
    };
    // Salt and pepper need to know white.
    let impulse = if noise.salt_and_pepper.part > 0.0 { white()? as f32 } else { 0.0 };
    let size = [planes.width(), planes.height()];
    for (number, channel) in planes.channels_mut().iter_mut().enumerate() {
        if channel.name == ALPHA {
            continue;
        }
        let number = match noise.channels {
            Channels::Independent => number,
            Channels::Common => 0,
        };
        let sigmas = sigma_map.map(|map| sigmas_of(map, &channel.name, size)).transpose()?;
        let of_channel = OneChannel { noise, unit, seed, number, size };
        of_channel.add_to(&mut channel.data, sigmas, impulse);
    }
    Ok(())
}

/// The σ of a channel, in the unit of the levels: finite and not negative.
fn sigmas_of<'a>(map: &'a Planes, name: &str, size: [usize; 2]) -> Result<&'a [f32], Invalid> {
    let refuse = |message: String| Err(Invalid::new("sigma_map.file", message));
    if [map.width(), map.height()] != size {
        let [width, height] = size;
        return refuse(format!("has {} × {} pixels, the image {width} × {height}", map.width(), map.height()));
    }
    let sigmas = match (map.channels(), map.plane(name)) {
        (_, Some(plane)) => plane,
        ([Channel { data, .. }], None) => data,
        (channels, None) => {
            let names: Vec<&str> = channels.iter().map(|channel| &channel.name[..]).collect();
            return refuse(format!("has the channels {}, but none for {name}", names.join(", ")));
        }
    };
    match sigmas.iter().position(|s| !(0.0..f32::INFINITY).contains(s)) {
        Some(i) => refuse(format!("holds {} at column {}, row {}", sigmas[i], i % size[0], i / size[0])),
        None => Ok(sigmas),
    }
}

/// The noise of one channel.
#[derive(Clone, Copy)]
struct OneChannel<'a> {
    noise: &'a SyntheticNoise,
    /// Pixel value of a level of 1.
    unit: f64,
    seed: u64,
    /// Number of the channel, as far as random numbers go.
    number: usize,
    size: [usize; 2],
}

impl OneChannel<'_> {
    fn streams(&self, kind: Kind) -> Streams {
        Streams::new(self.seed, kind, self.number)
    }

    fn add_to(&self, values: &mut [f32], sigmas: Option<&[f32]>, white: f32) {
        let SyntheticNoise { speckle: coherent, film_grain, salt_and_pepper, .. } = self.noise;
        if let Some(distribution) = speckle(coherent.contrast) {
            let streams = self.streams(Kind::Speckle);
            let factor = |x: usize, y: usize| streams.pixel(x as i32, y as i32).sample(distribution);
            self.change(values, |x, y, f| f * factor(x, y));
        }
        if film_grain.factor > 0.0 {
            let field = correlated_field(self.streams(Kind::FilmGrain), self.size, film_grain.correlation_px);
            // c·f^γ in the unit of the levels, which has no value below 0.
            let sigma = |f: f64| self.unit * film_grain.factor * (f.max(0.0) / self.unit).powf(film_grain.exponent);
            self.change(values, |x, y, f| f + sigma(f) * f64::from(field[y * self.size[0] + x]));
        }
        self.add_symmetric(values, self.noise.gaussian, Symmetric::Normal, Kind::Gaussian);
        self.add_symmetric(values, self.noise.laplacian, Symmetric::Laplace, Kind::Laplacian);
        self.add_symmetric(values, self.noise.uniform, Symmetric::Uniform, Kind::Uniform);
        if let Some(sigmas) = sigmas {
            let sigma = |x: usize, y: usize| self.unit * f64::from(sigmas[y * self.size[0] + x]);
            let streams = self.streams(Kind::SigmaMap);
            let normal = |x: usize, y: usize| Symmetric::Normal.sample(&mut streams.pixel(x as i32, y as i32));
            self.change(values, |x, y, f| f + sigma(x, y) * normal(x, y));
        }
        if salt_and_pepper.part > 0.0 {
            let streams = self.streams(Kind::SaltAndPepper);
            let white = f64::from(white);
            let impulse = |x, y| salt_and_pepper.at(streams, x, y).map(|salt| if salt { white } else { 0.0 });
            self.change(values, |x, y, f| impulse(x, y).unwrap_or(f));
        }
    }

    fn add_symmetric(&self, values: &mut [f32], noise: SymmetricNoise, distribution: Symmetric, kind: Kind) {
        if noise.sigma == 0.0 {
            return;
        }
        let streams = self.streams(kind);
        let number = |x: usize, y: usize| distribution.sample(&mut streams.pixel(x as i32, y as i32));
        if noise.multiplicative {
            self.change(values, |x, y, f| f * (1.0 + noise.sigma * number(x, y)));
        } else {
            self.change(values, |x, y, f| f + self.unit * noise.sigma * number(x, y));
        }
    }

    /// Changes each value, given its column and row.
    fn change(&self, values: &mut [f32], change: impl Fn(usize, usize, f64) -> f64 + Sync) {
        values.par_chunks_mut(self.size[0].max(1)).enumerate().for_each(|(y, row)| {
            row.iter_mut().enumerate().for_each(|(x, value)| *value = change(x, y, f64::from(*value)) as f32);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::math::statistics::Moments;

    const SIZE: [usize; 2] = [256, 192];
    const PIXELS: f64 = 256.0 * 192.0;

    fn even(names: &[&str], value: f32) -> Planes {
        let channel = |name: &&str| Channel { name: (*name).to_owned(), data: vec![value; SIZE[0] * SIZE[1]] };
        Planes::new(SIZE[0], SIZE[1], names.iter().map(channel).collect()).expect("right sizes")
    }

    fn noise(text: &str) -> SyntheticNoise {
        toml::from_str(text).expect("a table")
    }

    /// Even planes of a value with noise, white at 255.
    fn noisy(names: &[&str], value: f32, text: &str) -> Planes {
        let mut planes = even(names, value);
        add_noise(&mut planes, &noise(text), Scale { white: Some(255.0) }, None, 7).expect("noise");
        planes
    }

    fn moments(plane: &[f32]) -> Moments {
        plane.iter().map(|&v| f64::from(v)).collect()
    }

    /// Whether a plane has this mean and standard deviation, within 5 standard errors for numbers of this kurtosis that
    /// count as `independent` ones.
    fn check(plane: &[f32], mean: f64, sigma: f64, kurtosis: f64, independent: f64) {
        let found = moments(plane);
        assert!((found.mean() - mean).abs() < 5.0 * sigma / independent.sqrt(), "mean {} for {mean}", found.mean());
        let error = sigma * sigma * ((kurtosis - 1.0) / independent).sqrt();
        let variance = found.variance();
        assert!((variance - sigma * sigma).abs() < 5.0 * error, "σ² {variance} for {}", sigma * sigma);
    }

    #[test]
    fn additive_noise_has_its_sigma_in_either_unit() {
        for (kind, kurtosis) in [("gaussian", 3.0), ("laplacian", 6.0), ("uniform", 1.8)] {
            check(
                noisy(&["Y"], 100.0, &format!("{kind}.sigma = 4\n")).channels()[0].data.as_slice(),
                100.0,
                4.0,
                kurtosis,
                PIXELS,
            );
            let parts = noisy(&["Y"], 100.0, &format!("levels = 'full-scale'\n{kind}.sigma = 0.02\n"));
            check(&parts.channels()[0].data, 100.0, 5.1, kurtosis, PIXELS);
        }
        // Kinds that come together are independent: variances add.
        let both = noisy(&["Y"], 100.0, "gaussian.sigma = 3\nuniform.sigma = 4\n");
        check(&both.channels()[0].data, 100.0, 5.0, 3.0, PIXELS);
    }

    #[test]
    fn multiplicative_noise_rises_with_the_value() {
        for value in [20.0, 200.0] {
            for (kind, kurtosis) in [("gaussian", 3.0), ("laplacian", 6.0), ("uniform", 1.8)] {
                let found = noisy(&["Y"], value, &format!("{kind} = {{ sigma = 0.1, multiplicative = true }}\n"));
                check(&found.channels()[0].data, value.into(), 0.1 * f64::from(value), kurtosis, PIXELS);
            }
            let speckle = noisy(&["Y"], value, "speckle.contrast = 0.5\n");
            check(&speckle.channels()[0].data, value.into(), 0.5 * f64::from(value), 4.5, PIXELS);
        }
    }

    #[test]
    fn grain_has_the_variance_of_its_law() {
        for (value, levels, unit) in [(0.25f32, "picture", 1.0), (100.0, "picture", 1.0), (100.0, "full-scale", 255.0)]
        {
            let text =
                format!("levels = '{levels}'\nfilm_grain = {{ factor = 0.05, exponent = 0.4, correlation_px = 2 }}\n");
            let found = noisy(&["Y"], value, &text);
            let sigma = unit * 0.05 * (f64::from(value) / unit).powf(0.4);
            // Σ of ρ over all lags is 2π·ℓ² for the mean, of ρ² π·ℓ² for the variance: the larger.
            check(&found.channels()[0].data, value.into(), sigma, 3.0, PIXELS / (2.0 * std::f64::consts::PI * 4.0));
        }
        // There is no grain where there is nothing.
        assert_eq!(noisy(&["Y"], -1.0, "film_grain.factor = 1\n"), even(&["Y"], -1.0));
    }

    #[test]
    fn every_pixel_has_the_sigma_of_the_map() {
        let mut map = even(&["sigma"], 1.0);
        map.channels_mut()[0].data[..SIZE[0] * SIZE[1] / 2].fill(5.0);
        let mut planes = even(&["R", "G"], 50.0);
        let file = "sigma_map.file = 'sigma.exr'\n";
        add_noise(&mut planes, &noise(file), Scale { white: None }, Some(&map), 7).expect("noise");
        for channel in planes.channels() {
            let (upper, lower) = channel.data.split_at(SIZE[0] * SIZE[1] / 2);
            check(upper, 50.0, 5.0, 3.0, 0.5 * PIXELS);
            check(lower, 50.0, 1.0, 3.0, 0.5 * PIXELS);
        }
        for (map, message) in [
            (Planes::zeros(3, 2, ["Y"]), "3 × 2 pixels"),
            (even(&["X", "Z"], 1.0), "none for R"),
            (even(&["Y"], f32::NAN), "NaN at column 0, row 0"),
            (even(&["Y"], -1.0), "-1 at column"),
        ] {
            let refused =
                add_noise(&mut planes, &noise(file), Scale { white: None }, Some(&map), 7).expect_err("refused");
            assert!(refused.key == "sigma_map.file" && refused.message.contains(message), "{refused}");
        }
    }

    #[test]
    fn channels_have_noise_of_their_own_or_in_common_and_transparency_none() {
        let names = ["R", "G", "B", "A"];
        let own = noisy(&names, 100.0, "gaussian.sigma = 4\n");
        let common = noisy(&names, 100.0, "channels = 'common'\ngaussian.sigma = 4\n");
        let [r, g, _, a] = own.channels() else { panic!("four channels") };
        let product: f64 = r.data.iter().zip(&g.data).map(|(r, g)| f64::from((r - 100.0) * (g - 100.0))).sum();
        assert!((product / PIXELS).abs() < 5.0 * 16.0 / PIXELS.sqrt());
        assert!(common.channels()[..3].iter().all(|c| c.data == r.data));
        assert!(a.data.iter().all(|&alpha| alpha == 100.0));
    }

    #[test]
    fn a_kind_more_leaves_the_numbers_of_the_others() {
        let noisy = |text: &str| noisy(&["Y"], 100.0, text).into_channels().remove(0).data;
        let [gaussian, uniform, both] =
            ["gaussian.sigma = 4", "uniform.sigma = 2", "gaussian.sigma = 4\nuniform.sigma = 2"].map(noisy);
        for i in 0..1000 {
            assert!((gaussian[i] + uniform[i] - 100.0 - both[i]).abs() < 1e-4);
        }
        let mut other = even(&["Y"], 100.0);
        add_noise(&mut other, &noise("gaussian.sigma = 4"), Scale { white: None }, None, 8).expect("noise");
        assert_ne!(other.channels()[0].data, gaussian);
    }

    #[test]
    fn white_has_to_be_known_for_what_needs_it() {
        for text in ["salt_and_pepper.part = 0.1\n", "levels = 'full-scale'\ngaussian.sigma = 0.1\n"] {
            let refused = add_noise(&mut even(&["Y"], 1.0), &noise(text), Scale { white: None }, None, 7);
            assert_eq!(refused.expect_err("refused").key, "full_scale");
        }
        let found =
            noisy(&["Y"], 100.0, "salt_and_pepper = { part = 0.2, salt = 0.75 }\n").into_channels().remove(0).data;
        let share = |value: f32| found.iter().filter(|&&v| v == value).count() as f64 / PIXELS;
        assert!(
            (share(255.0) - 0.15).abs() < 0.01 && (share(0.0) - 0.05).abs() < 0.01 && (share(100.0) - 0.8).abs() < 0.01
        );
    }
}
