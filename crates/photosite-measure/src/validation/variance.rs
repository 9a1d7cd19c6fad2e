//! Variances that an image's file does not hold as such.

use super::compared_image::ComparedImage;
use photosite_core::Invalid;
use photosite_core::image::{Channel, Planes};

/// Channels of variances are called `variance.X` in files.
const VARIANCE: &str = "variance.";
/// Prefix of channels of second moments, as Mitsuba 3 writes them.
const SECOND_MOMENT: &str = "m2_";
/// Bits of a 32-bit float that one made of 16 bits leaves 0.
const BEYOND_HALF: u32 = 0x1fff;

impl ComparedImage {
    /// Sets one variance for every pixel value: 0 for an exact image.
    #[must_use]
    pub fn with_constant_variance(mut self, variance: f64) -> Self {
        self.variance = self.mean.clone();
        self.variance.channels_mut().iter_mut().for_each(|channel| channel.data.fill(variance as f32));
        self
    }

    /// Takes the variances that another image holds: of channel `X` those of its channel `variance.X`, or else `X`.
    pub fn with_variances_from(mut self, other: &Self) -> Result<Self, Invalid> {
        let size = |p: &Self| [p.mean.width(), p.mean.height()];
        if size(&self) != size(other) {
            let ([w, h], [width, height]) = (size(other), size(&self));
            let message = format!("{} has {w} × {h} pixels, {} has {width} × {height}", other.name, self.name);
            return Err(Invalid::new("", message).help("give the variances of the same pixels"));
        }
        let found = |channel: &Channel| {
            let Channel { name, .. } = channel;
            let plane = other.variance.plane(name).or_else(|| other.mean.plane(&format!("{VARIANCE}{name}")));
            Some(Channel { name: name.clone(), data: plane.or_else(|| other.mean.plane(name))?.to_vec() })
        };
        let found: Vec<Channel> = self.mean.channels().iter().filter_map(found).collect();
        if found.is_empty() {
            let names: Vec<&str> = self.mean.channels().iter().map(|c| &c.name[..]).collect();
            let message = format!("{} holds no variances for the channels of {}", other.name, self.name);
            return Err(Invalid::new("", message)
                .help(format!("name its channels {VARIANCE}X or X, with X one of {}", names.join(", "))));
        }
        self.variance = Planes::new(self.mean.width(), self.mean.height(), found)?;
        Ok(self)
    }

    /// Whether a second moment stands beside the channel `name`.
    pub fn has_second_moment(&self, name: &str) -> bool {
        self.mean.plane(&format!("{SECOND_MOMENT}{name}")).is_some()
    }

    /// Makes variances of the second moments of n independent samples a pixel, at least two, that channels `m2_X` hold
    /// beside means `X`, as Mitsuba's integrator `moment` writes them with a box filter:
    ///
    /// variance of the mean = (m2 − m²)/(n − 1)
    ///
    /// where m2 − m² is at least 2⁻²³·m2, what 32-bit floats can tell.
    pub fn with_second_moments(mut self, samples: u64) -> Result<Self, Invalid> {
        let mut variances = Vec::new();
        for channel in self.mean.channels() {
            let Some(squares) = self.mean.plane(&format!("{SECOND_MOMENT}{}", channel.name)) else { continue };
            if squares.iter().any(|m2| *m2 != 0.0) && squares.iter().all(|m2| m2.to_bits() & BEYOND_HALF == 0) {
                let message = format!("the second moments of {} are 16-bit floats, too coarse for m2 − m²", self.name);
                return Err(Invalid::new("", message).help("write 32-bit floats: component_format = \"float32\""));
            }
            let variance = |(m, m2): (&f32, &f32)| {
                let (m, m2) = (f64::from(*m), f64::from(*m2));
                ((m2 - m * m).max(m2 * f64::from(f32::EPSILON)) / (samples - 1) as f64) as f32
            };
            let data = channel.data.iter().zip(squares).map(variance).collect();
            variances.push(Channel { name: channel.name.clone(), data });
        }
        if variances.is_empty() {
            let message = format!("{} holds no second moments", self.name);
            return Err(
                Invalid::new("", message).help("they are channels m2_X beside X, as of Mitsuba's integrator moment")
            );
        }
        let (width, height) = (self.mean.width(), self.mean.height());
        let is_moment = |c: &Channel| variances.iter().any(|v| c.name.strip_prefix(SECOND_MOMENT) == Some(&v.name));
        let mean = self.mean.channels().iter().filter(|c| !is_moment(c)).cloned().collect();
        self.mean = Planes::new(width, height, mean)?;
        self.variance = Planes::new(width, height, variances)?;
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_distr::StandardNormal;

    use crate::validation::compared_image::tests::image;
    use crate::validation::{ComparisonSettings, compare};
    use photosite_core::math::philox::Philox;

    #[test]
    fn second_moments_give_calibrated_z_scores() {
        const PIXELS: usize = 2000;
        const SAMPLES: usize = 200;
        let mut random = Philox::new(5, 0);
        let mut estimate = |deviation: f64| {
            let (mut mean, mut squares) = (Vec::new(), Vec::new());
            for _ in 0..PIXELS {
                let samples = (0..SAMPLES).map(|_| 3.0 + deviation * random.sample::<f64, _>(StandardNormal));
                let (sum, square) = samples.fold((0.0, 0.0), |(s, q), x| (s + x, q + x * x));
                mean.push((sum / SAMPLES as f64) as f32);
                squares.push((square / SAMPLES as f64) as f32);
            }
            let both = image(50, 40, &[("nested.Y", &mean), ("m2_nested.Y", &squares)]);
            assert!(both.has_second_moment("nested.Y") && !both.has_second_moment("m2_nested.Y"));
            both.with_second_moments(SAMPLES as u64).expect("moments")
        };
        let (a, b) = (estimate(1.0), estimate(2.0));
        assert_eq!(a.mean.channels().len(), 1);
        let found = compare(&a, &b, &ComparisonSettings::default()).expect("comparable");
        assert!(found.verdict.expect("both variances are known").agree);
        let z = found.channels[0].z_scores.as_ref().expect("both variances are known");
        // Of samples of two variances, z follows Student's t of at least 199 degrees of freedom, whose variance is
        // 199/197; a spread of n numbers errs by 1/√(2n), 4 of that.
        assert!((z.spread - 1.0).abs() < 1.0 / 197.0 + 4.0 / (2.0 * PIXELS as f64).sqrt(), "{z:?}");
        assert!(z.of_mean.abs() < 4.0, "{z:?}");
    }

    #[test]
    fn second_moments_by_hand() {
        // Samples 1.1 and 3.1: mean 2.1, mean square 5.41, so that the variance of the mean is 1.
        let moments = image(1, 1, &[("Y", &[2.1]), ("m2_Y", &[5.41]), ("m2_Z", &[1.0])]);
        let found = moments.with_second_moments(2).expect("moments");
        let variance = found.variance.plane("Y").expect("a variance")[0];
        assert!((variance - 1.0).abs() < 1e-5, "{variance}");
        assert_eq!(found.mean.channels().iter().map(|c| &c.name[..]).collect::<Vec<_>>(), ["Y", "m2_Z"]);
        // Equal samples: what rounding hides, and never below nothing.
        let equal = image(1, 1, &[("Y", &[0.1]), ("m2_Y", &[0.1f32 * 0.1 - 1e-9])]).with_second_moments(5);
        assert!(equal.expect("moments").variance.plane("Y").expect("a variance")[0] > 0.0);
        assert!(image(1, 1, &[("Y", &[2.0])]).with_second_moments(2).is_err());
        let half = image(1, 1, &[("Y", &[2.0]), ("m2_Y", &[4.25])]).with_second_moments(2);
        assert!(half.expect_err("too coarse").message.contains("16-bit floats"));
    }

    #[test]
    fn variances_of_another_file() {
        let a = image(1, 1, &[("R", &[1.0]), ("G", &[2.0]), ("B", &[3.0])]);
        let file = image(1, 1, &[("R", &[9.0]), ("variance.R", &[4.0]), ("G", &[5.0])]);
        let found = a.clone().with_variances_from(&file).expect("variances");
        assert_eq!([found.variance.plane("R"), found.variance.plane("G")], [Some(&[4.0][..]), Some(&[5.0])]);
        assert_eq!(found.variance.plane("B"), None);
        let own = image(1, 1, &[("R", &[9.0])]).with_variances(&[("R", &[6.0])]);
        assert_eq!(a.clone().with_variances_from(&own).expect("variances").variance.plane("R"), Some(&[6.0][..]));
        for (other, complaint) in [(image(1, 1, &[("Y", &[1.0])]), "no variances"), (image(2, 1, &[]), "2 × 1 pixels")]
        {
            assert!(a.clone().with_variances_from(&other).expect_err("refused").message.contains(complaint));
        }
    }
}
