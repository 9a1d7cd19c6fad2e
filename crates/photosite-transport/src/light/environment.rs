//! Light from infinitely far: a constant, or an equirectangular image sampled by its luminance.
//!
//! Scattered rays find what shines evenly from all sides as well as anything could, so that only what exceeds the mean
//! is sampled: its density is that of max(L − mean, 0) ([Karlik19](photosite_core::references#karlik19)).

use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::above_mean::above_mean;
use super::emission::tint_spectrum;
use super::sample::{LiContext, LiSample};
use super::sky::Sky;
use crate::texture::{Bitmap, Filter, SamplerSettings, Texture, UvTransform, Wrap};
use photosite_core::math::distribution::PiecewiseConstant2D;
use photosite_core::math::{Pdf, SolidAngle};
use photosite_core::spectrum::{SampledSpectrum, SpectrumId, SpectrumTable, Wavelengths, rgb};

/// Radiance from all directions.
#[derive(Clone, Debug)]
pub enum Environment {
    /// Constant radiance in all directions.
    Constant {
        /// Radiance, W·m⁻²·sr⁻¹·nm⁻¹.
        radiance: SpectrumId,
    },
    /// Image of the radiance; see [`EnvironmentImage`].
    Image(EnvironmentImage),
    /// The sky by day; see [`Sky`].
    Sky(Box<Sky>),
}

/// Equirectangular environment image of linear sRGB. Its top row is +Y, its centre lies along −Z before the rotation.
#[derive(Clone, Debug)]
pub struct EnvironmentImage {
    pub(super) texture: Texture,
    /// Radiance of a white pixel of value 1, W·m⁻²·sr⁻¹·nm⁻¹.
    pub(super) radiance: SpectrumId,
    /// Cosine and sine of the rotation about +Y.
    pub(super) rotation: [f32; 2],
    pub(super) distribution: PiecewiseConstant2D,
    excess: f64,
}

impl Environment {
    /// Part of the environment's light that exceeds the mean of all directions, 0–1: the part that is worth sampling.
    pub fn excess(&self) -> f64 {
        match self {
            Self::Constant { .. } => 0.0,
            Self::Image(image) => image.excess,
            Self::Sky(sky) => sky.excess(),
        }
    }

    /// Radiance from the unit direction `towards`.
    #[inline]
    pub fn radiance(&self, spectra: &SpectrumTable, towards: Vec3, wavelengths: &Wavelengths) -> SampledSpectrum {
        match self {
            Self::Constant { radiance } => spectra.sample(*radiance, wavelengths),
            Self::Image(image) => {
                let [r, g, b, _] = image.texture.sample_rgba_srgb(Vec2::from_array(image.uv(towards)));
                spectra.sample(image.radiance, wavelengths) * tint_spectrum([r, g, b], wavelengths)
            }
            Self::Sky(sky) => sky.radiance(spectra, towards, wavelengths),
        }
    }

    /// A direction towards the environment with its density; `None` where the density vanishes (the poles, and
    /// everywhere where there is no excess).
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<(Vec3, Pdf<SolidAngle>)> {
        match self {
            Self::Constant { .. } => None,
            Self::Image(image) => {
                let (uv, density) = image.distribution.sample(u);
                let (sin, cos) = (PI * uv[1]).sin_cos();
                let direction = image.direction(uv, sin, cos);
                (sin > 0.0 && density > 0.0).then(|| (direction, Pdf::new(density / (TAU * PI * sin))))
            }
            Self::Sky(sky) => sky.sample(u),
        }
    }

    /// A direction from where it is bright.
    #[inline]
    pub(super) fn sample_li(&self, u: [f32; 2], li: &LiContext<'_>) -> Option<LiSample> {
        let (wi, pdf) = self.sample(u)?;
        let radiance = self.radiance(li.spectra, wi, li.wavelengths);
        Some(LiSample { radiance, wi, position: None, pdf, is_delta: false })
    }

    /// Density with which [`Self::sample`] chooses the unit direction `towards`.
    #[inline]
    pub fn pdf(&self, towards: Vec3) -> Pdf<SolidAngle> {
        match self {
            Self::Constant { .. } => Pdf::new(0.0),
            Self::Image(image) => {
                let sin = towards.x.hypot(towards.z);
                if sin == 0.0 {
                    return Pdf::new(0.0);
                }
                Pdf::new(image.distribution.pdf(image.uv(towards)) / (TAU * PI * sin))
            }
            Self::Sky(sky) => sky.pdf(towards),
        }
    }
}

impl EnvironmentImage {
    /// Makes an environment image. `radiance` is that of a white pixel of value 1; the rotation is counter-clockwise
    /// seen from above, degrees.
    pub fn new(image: Arc<Bitmap>, radiance: SpectrumId, rotation_deg: f64) -> Self {
        let image = panorama(image);
        let (width, height) = (image.image().width, image.image().height);
        let luminance = luminances(&image);
        // Bilinear interpolation spreads a texel over its neighbours, so the density must not vanish there: it follows
        // the mean of a texel and those around it.
        let around = |x: usize, y: usize| {
            let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
            let columns = [(x + width - 1) % width, x, (x + 1) % width];
            rows.into_iter().flat_map(|y| columns.map(|x| luminance[y * width + x])).sum::<f64>() / 9.0
        };
        let sines: Vec<f64> = (0..height).map(|y| polar_angle(y, height).sin()).collect();
        let smooth: Vec<f64> =
            (0..width * height).map(|i| 0.5 * (luminance[i] + around(i % width, i / width))).collect();
        let (weights, excess) = above_mean(&smooth, &sines);
        let (sin, cos) = rotation_deg.to_radians().sin_cos();
        let distribution = PiecewiseConstant2D::new(&weights, width);
        Self { texture: image, radiance, rotation: [cos as f32, sin as f32], distribution, excess }
    }

    /// Luminous integrals (∫ Y dω, ∫ Y·cos⁺θ dω with θ from +Y) of an image's luminance in image units, by the
    /// midpoint rule.
    pub fn luminous_integrals(image: &Arc<Bitmap>) -> (f64, f64) {
        let texture = panorama(Arc::clone(image));
        let (width, height) = (image.width, image.height);
        let mut sums = (0.0, 0.0);
        for (y, row) in luminances(&texture).chunks(width).enumerate() {
            let (sin, cos) = polar_angle(y, height).sin_cos();
            let solid_angle = 2.0 * std::f64::consts::PI.powi(2) * sin / (width * height) as f64;
            let light = row.iter().sum::<f64>() * solid_angle;
            sums.0 += light;
            sums.1 += light * cos.max(0.0);
        }
        sums
    }

    #[inline]
    fn uv(&self, towards: Vec3) -> [f32; 2] {
        let [cos, sin] = self.rotation;
        let (x, z) = (cos * towards.x - sin * towards.z, sin * towards.x + cos * towards.z);
        let u = 0.5 + x.atan2(-z) / TAU;
        [u.clamp(0.0, 1.0 - f32::EPSILON), (towards.y.clamp(-1.0, 1.0).acos() * FRAC_1_PI).min(1.0 - f32::EPSILON)]
    }

    #[inline]
    fn direction(&self, uv: [f32; 2], sin_theta: f32, cos_theta: f32) -> Vec3 {
        let (sin_phi, cos_phi) = (TAU * (uv[0] - 0.5)).sin_cos();
        let (x, z) = (sin_theta * sin_phi, -sin_theta * cos_phi);
        let [cos, sin] = self.rotation;
        Vec3::new(cos * x + sin * z, cos_theta, cos * z - sin * x)
    }
}

/// The image as a texture that wraps around horizontally and stops at the poles.
fn panorama(image: Arc<Bitmap>) -> Texture {
    let sampler = SamplerSettings { wrap: [Wrap::Repeat, Wrap::ClampToEdge], filter: Filter::Linear };
    Texture::new(image, sampler, UvTransform::default(), 0)
}

/// Angle from +Y of the middle of a row, rad.
fn polar_angle(row: usize, height: usize) -> f64 {
    std::f64::consts::PI * (row as f64 + 0.5) / height as f64
}

/// Luminance of every texel in image units.
fn luminances(image: &Texture) -> Vec<f64> {
    let (width, height) = (image.image().width, image.image().height);
    let centre = |i: usize, n: usize| (i as f32 + 0.5) / n as f32;
    (0..width * height)
        .map(|i| {
            let uv = Vec2::new(centre(i % width, width), centre(i / width, height));
            let [r, g, b, _] = image.sample_rgba_srgb(uv).map(f64::from);
            rgb::luminance([r, g, b]).max(0.0)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Texels;
    use photosite_core::math::warp;
    use photosite_core::spectrum::Spectrum;

    /// A dim image with one bright texel.
    fn image(bright: (usize, usize)) -> Arc<Bitmap> {
        let (width, height) = (16, 8);
        let mut texels = vec![[0.1f32; 3]; width * height];
        texels[bright.1 * width + bright.0] = [100.0; 3];
        Arc::new(Bitmap { name: "test".into(), width, height, texels: Texels::Rgb32F(texels) })
    }

    fn environment(bright: (usize, usize), rotation_deg: f64) -> (SpectrumTable, Environment) {
        let mut spectra = SpectrumTable::default();
        let radiance = spectra.add(&Spectrum::constant(1.0));
        (spectra, Environment::Image(EnvironmentImage::new(image(bright), radiance, rotation_deg)))
    }

    fn brightness((spectra, environment): &(SpectrumTable, Environment), towards: Vec3) -> f32 {
        let wavelengths = Wavelengths::new([450.0, 550.0, 600.0, 650.0], [1.0; 4]);
        environment.radiance(spectra, towards.normalize(), &wavelengths).mean()
    }

    #[test]
    fn the_centre_of_the_image_is_ahead_and_its_right_is_right() {
        // Texel 8 of 16 begins at the centre; row 4 of 8 begins at the horizon.
        let ahead = Vec3::new(0.2, -0.2, -1.0);
        assert!(brightness(&environment((8, 4), 0.0), ahead) > 50.0);
        assert!(brightness(&environment((8, 0), 0.0), Vec3::new(0.01, 1.0, -0.05)) > 50.0);
        // Turned by 90° counter-clockwise seen from above, what was ahead (−Z) is on the left (−X).
        let left = Vec3::new(-1.0, -0.2, -0.2);
        assert!(brightness(&environment((8, 4), 90.0), left) > 50.0);
        assert!(brightness(&environment((8, 4), 90.0), ahead) < 1.0);
    }

    #[test]
    fn sampling_estimates_the_integral_over_the_sphere() {
        let (spectra, environment) = environment((3, 2), 30.0);
        let wavelengths = Wavelengths::new([550.0; 4], [1.0; 4]);
        let n = 128;
        let (mut both, mut uniform, mut misjudged) = (0.0, 0.0, 0);
        // Both kinds of samples together, by the balance heuristic, against uniform ones alone.
        let of_both = |direction: Vec3| {
            let density = environment.pdf(direction).0 + 0.5 / TAU;
            environment.radiance(&spectra, direction, &wavelengths)[0] / density
        };
        for i in 0..n * n {
            let u = [((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32];
            if let Some((direction, pdf)) = environment.sample(u) {
                // sin θ from the direction, at 0.012 rad from the pole: 6e-8/0.012² = 4e-4.
                misjudged += u32::from((environment.pdf(direction).0 / pdf.0 - 1.0).abs() > 1e-3);
                both += of_both(direction);
            }
            let direction = warp::uniform_sphere(u);
            both += of_both(direction);
            uniform += environment.radiance(&spectra, direction, &wavelengths)[0] * 2.0 * TAU;
        }
        // Rounding takes a direction across the edge of a texel: 6e-8 rad of 16 + 8 edges in 2π, below one sample of
        // 128².
        assert!(misjudged <= 1, "{misjudged} densities are not those of their directions");
        // Stratified grids: the piecewise bilinear peak is resolved by about 8 cells per texel with uniform sampling.
        assert!((both / uniform - 1.0).abs() < 0.02, "{both} {uniform}");
    }

    #[test]
    fn only_what_exceeds_the_mean_of_the_sky_is_sampled() {
        let mut spectra = SpectrumTable::default();
        let radiance = spectra.add(&Spectrum::constant(1.0));
        assert_eq!(Environment::Constant { radiance }.excess(), 0.0);
        let grey =
            |texels| Arc::new(Bitmap { name: "grey".into(), width: 8, height: 4, texels: Texels::Rgb32F(texels) });
        let of = |texels| EnvironmentImage::new(grey(texels), radiance, 0.0).excess;
        assert_eq!(of(vec![[0.3; 3]; 32]), 0.0);
        assert_eq!(of(vec![[0.0; 3]; 32]), 0.0);
        // Half of the sphere twice as bright as the mean, 1/2. A texel counts with the mean of those around it in equal
        // parts: of each row's eight two have 1 and two (1 + 2/3)/2. Their excess over all light, (2·1/2 + 2·1/3)/4.
        let half: Vec<[f32; 3]> = (0..32).map(|i| [f32::from(u8::from(i % 8 < 4)); 3]).collect();
        assert!((of(half) - 5.0 / 12.0).abs() < 1e-6);
        // A texel of 100 among such of 0.1, in row 2 of 8: the same for it and the eight around it.
        let (_, sunny) = environment((3, 2), 0.0);
        let sine = |row: usize| polar_angle(row, 8).sin();
        let around = (100.0 + 8.0 * 0.1) / 9.0;
        let (sun, edge) = (0.5 * (100.0 + around), 0.5 * (0.1 + around));
        let at_edge = 2.0 * sine(2) + 3.0 * (sine(1) + sine(3));
        let texels = 16.0 * (0..8).map(sine).sum::<f64>();
        let all = 0.1 * texels + (sun - 0.1) * sine(2) + (edge - 0.1) * at_edge;
        let mean = all / texels;
        let expected = ((sun - mean) * sine(2) + (edge - mean) * at_edge) / all;
        assert!((sunny.excess() - expected).abs() < 1e-6, "{} is not {expected}", sunny.excess());
    }

    #[test]
    fn luminous_integrals_of_a_grey_sky() {
        let texels = Texels::Rgb32F(vec![[1.0; 3]; 2048]);
        let grey = Arc::new(Bitmap { name: "grey".into(), width: 64, height: 32, texels });
        let (sphere, horizontal) = EnvironmentImage::luminous_integrals(&grey);
        // Midpoint rule with 32 rows: error of order (π/32)²/24.
        assert!((sphere / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3);
        assert!((horizontal / std::f64::consts::PI - 1.0).abs() < 2e-3);
    }
}
