//! Variances that an image's file does not hold as such.

use super::compared_image::ComparedImage;
use photosite_core::Invalid;
use photosite_core::image::{Channel, Planes};
use photosite_raw::RawImage;

/// Channels of variances are called `variance.X` in files.
const VARIANCE: &str = "variance.";
/// Prefix of channels of second moments, as Mitsuba 3 writes them.
const SECOND_MOMENT: &str = "m2_";
/// Bits of a 32-bit float that one made of 16 bits leaves 0.
const BEYOND_HALF: u32 = 0x1fff;

/// Fixed pattern of a camera, of which the other camera of a comparison has another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NonUniformity {
    /// Photo response non-uniformity: standard deviation of the pixels' responses over their mean.
    pub prnu: f64,
    /// Dark signal non-uniformity: standard deviation of the pixels' offsets, DN.
    pub dsnu_dn: f64,
}

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

    /// Takes the variances that the noise profile of the raw image states which this image was made of: with a black
    /// level b and a white level w, both in DN, a pixel value y has
    ///
    /// variance (w − b)²·(S·x + O) + (p·(w − b)·x)² + d², x = (y − b)/(w − b), at least 0
    ///
    /// The first term is that of temporal noise (DNG 1.6 specification, NoiseProfile). The others are those of a fixed
    /// pattern that the other image does not have, with the PRNU p (a ratio) and the DSNU d in DN.
    pub fn with_noise_profile(mut self, raw: &RawImage, pattern: NonUniformity) -> Result<Self, Invalid> {
        let profile = &raw.metadata.noise_profile;
        let refused = |message: String| Err(Invalid::new("", message).help("state its variances in another way"));
        if profile.is_empty() {
            return refused(format!("{} states no noise profile", self.name));
        }
        if raw.linearisation.is_some() {
            return refused(format!("the noise profile of {} is that of linear values, which its are not", self.name));
        }
        let samples = raw.cfa.samples_per_pixel();
        let [left, top] = self.active_area.map_or([0, 0], |area| [area.x, area.y]);
        let width = self.mean.width();
        self.variance = self.mean.clone();
        for (sample, plane) in self.variance.channels_mut().iter_mut().enumerate() {
            for (i, value) in plane.data.iter_mut().enumerate() {
                let (x, y) = ((left + i % width) * samples + sample, top + i / width);
                let channel = raw.cfa.channel_at(x, y);
                let [s, o] = *profile.get(channel).unwrap_or(&profile[0]);
                let black = f64::from(raw.black_level_dn.at(x, y));
                let range = f64::from(raw.white_of(channel)) - black;
                let signal = ((f64::from(*value) - black) / range).max(0.0);
                let fixed = (pattern.prnu * range * signal).powi(2) + pattern.dsnu_dn.powi(2);
                *value = (range * range * (s * signal + o) + fixed) as f32;
            }
        }
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

    use super::*;
    use crate::validation::compared_image::tests::image;
    use crate::validation::{ComparisonSettings, MOSAIC, compare};
    use photosite_core::math::philox::Philox;
    use photosite_raw::{Cfa, PixelArea, Pixels, RawMetadata};

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
    fn variances_of_a_noise_profile_by_hand() {
        let metadata = RawMetadata { noise_profile: vec![[0.01, 1e-4], [0.02, 4e-4]], ..RawMetadata::default() };
        let cfa = Cfa::parse("GRBG").expect("a layout");
        let data = vec![100, 600, 1100, 50];
        let bare = RawImage { metadata, black_level_dn: 100.into(), ..RawImage::bare(2, 2, data, cfa, 1100) };
        let image = |raw: &RawImage, pixels| ComparedImage::from_raw("a".to_owned(), raw.clone(), pixels);
        let found = image(&bare, Pixels::All).with_noise_profile(&bare, NonUniformity::default()).expect("variances");
        // 10⁶ · (S·x + O): channels in the order G, R, B, the last with the profile of the first; below black O alone.
        let order: Vec<usize> = (0..4).map(|i| bare.cfa.channel_at(i % 2, i / 2)).collect();
        let wanted: Vec<f32> = order
            .iter()
            .zip([0.0, 0.5, 1.0, 0.0])
            .map(|(&channel, x)| {
                let [s, o] = if channel == 1 { [0.02, 4e-4] } else { [0.01, 1e-4] };
                (1e6 * (s * x + o)) as f32
            })
            .collect();
        assert_eq!(found.variance.plane(MOSAIC), Some(&wanted[..]));
        // 1 % of 0, 500, 1000 and nothing below black, and 2 DN.
        let pattern = NonUniformity { prnu: 0.01, dsnu_dn: 2.0 };
        let found = image(&bare, Pixels::All).with_noise_profile(&bare, pattern).expect("variances");
        let with_pattern: Vec<f32> =
            wanted.iter().zip([0.0, 5.0, 10.0, 0.0f32]).map(|(wanted, p)| wanted + p * p + 4.0).collect();
        assert_eq!(found.variance.plane(MOSAIC), Some(&with_pattern[..]));
        // Of the active area alone, the channels are those of its places.
        let masked = RawImage { active_area: Some(PixelArea { x: 1, y: 1, width: 1, height: 1 }), ..bare.clone() };
        let found =
            image(&masked, Pixels::Active).with_noise_profile(&masked, NonUniformity::default()).expect("variances");
        assert_eq!(found.variance.plane(MOSAIC), Some(&wanted[3..]));
        for (raw, complaint) in [
            (RawImage { metadata: RawMetadata::default(), ..bare.clone() }, "states no noise profile"),
            (RawImage { linearisation: Some(vec![0, 9]), ..bare }, "linear values"),
        ] {
            let error =
                image(&raw, Pixels::All).with_noise_profile(&raw, NonUniformity::default()).expect_err("refused");
            assert!(error.message.contains(complaint), "{error}");
        }
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
