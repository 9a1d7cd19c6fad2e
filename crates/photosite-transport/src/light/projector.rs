//! Projectors: a slide in front of a light source, thrown through a lens.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::delta_model::{DeltaExtent, DeltaModel, LightPose};
use super::emission::tint_spectrum;
use super::sample::{LiContext, LiSample};
use crate::texture::{Bitmap, Filter, SamplerSettings, Texture, UvTransform, Wrap};
use photosite_core::math::{Cone, warp};
use photosite_core::spectrum::{SampledSpectrum, SpectrumId, Wavelengths};

/// A projector at the origin of its space. It shines along −z, with the top of the slide towards +y.
///
/// It is a camera run backwards: a point x m to the right and y m up in the plane 1 m away is lit by the slide at
/// (x/w + ½, ½ − y/h), w and h the extent of the image there. The lens is evenly bright over its opening of area A
/// for each point of the slide, so the intensity in a direction at the angle θ from the axis is L·A·cos θ, and the flux
/// of a white slide
///
///   Φ = L·A·∫ cos θ dω = L·A·∫∫ cos⁴θ dx dy.
///
/// What lies in the plane of focus is sharp; elsewhere each point of the opening throws the image to another place.
#[derive(Clone, Debug)]
pub struct Projector {
    slide: Texture,
    /// Extent of the image 1 m away, m.
    extent: [f32; 2],
    /// Shift of the middle of the image 1 m away, m to the right and up.
    shift: [f32; 2],
    /// Radius of the opening, m; 0 for an image that is sharp everywhere.
    radius: f32,
    /// Distance of the plane of focus, m.
    focus_distance: f32,
    /// 1/∫∫ cos⁴θ dx dy.
    per_flux: f32,
}

impl Projector {
    /// Makes a projector of a slide, sRGB-encoded; the width and height of the image 1 m away, and the place of its
    /// middle there, right and up, m; the radius of the opening, m, 0 for an image that is sharp everywhere; and the
    /// distance of the plane of focus.
    pub fn new(slide: Arc<Bitmap>, extent: [f64; 2], shift: [f64; 2], radius_m: f64, focus_distance_m: f64) -> Self {
        let edges = SamplerSettings { wrap: [Wrap::ClampToEdge; 2], filter: Filter::Nearest };
        Self {
            slide: Texture::new(slide, edges, UvTransform::default(), 0),
            extent: extent.map(|m| m as f32),
            shift: shift.map(|m| m as f32),
            radius: radius_m as f32,
            focus_distance: focus_distance_m as f32,
            per_flux: (1.0 / mean_over(extent, shift, |_| 1.0).1) as f32,
        }
    }

    /// Slide, with the way in which it is looked up.
    pub(super) fn slide(&self) -> &Texture {
        &self.slide
    }

    /// Extent of the image 1 m away and the shift of its middle there, m.
    pub(super) fn frame(&self) -> [f32; 4] {
        let Self { extent: [width, height], shift: [x, y], .. } = *self;
        [width, height, x, y]
    }

    /// Radius of the opening and distance of the plane of focus, m.
    pub(super) fn lens(&self) -> [f32; 2] {
        [self.radius, self.focus_distance]
    }

    /// Factor from the flux of a white slide to the intensity on the axis, sr⁻¹.
    pub(super) fn per_flux(&self) -> f32 {
        self.per_flux
    }

    /// Largest angle from the axis at which light leaves, rad.
    fn reach_rad(&self) -> f32 {
        let farthest = |i: usize| 0.5 * self.extent[i].abs() + self.shift[i].abs();
        (farthest(0).hypot(farthest(1)) + self.radius / self.focus_distance).atan()
    }

    /// A point of the opening.
    #[inline]
    fn opening(&self, u: [f32; 2]) -> Vec3 {
        if self.radius == 0.0 { Vec3::ZERO } else { (Vec2::from(warp::concentric_disk(u)) * self.radius).extend(0.0) }
    }

    /// Intensity from a point of the opening towards a unit direction, over the flux of a white slide, sr⁻¹.
    #[inline]
    fn intensity(&self, opening: Vec3, direction: Vec3, wavelengths: &Wavelengths) -> SampledSpectrum {
        let cos = -direction.z;
        if cos <= 0.0 {
            return SampledSpectrum::ZERO;
        }
        // Where the ray passes the plane of focus, seen from the middle of the lens.
        let across = direction.truncate() / cos + opening.truncate() / self.focus_distance;
        let [u, v] =
            [(across.x - self.shift[0]) / self.extent[0] + 0.5, 0.5 - (across.y - self.shift[1]) / self.extent[1]];
        if !((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v)) {
            return SampledSpectrum::ZERO;
        }
        let [r, g, b, _] = self.slide.sample_rgba_srgb(Vec2::new(u, v));
        let level = cos * self.per_flux;
        if [r, g, b] == [1.0; 3] {
            return SampledSpectrum::splat(level);
        }
        tint_spectrum([r, g, b], wavelengths) * level
    }

    /// The flux of the slide over that of a white one.
    pub fn brightness(&self) -> f64 {
        let [extent, shift] = [self.extent, self.shift].map(|pair| pair.map(f64::from));
        let (image, [width, height]) = (self.slide.image(), [self.slide.image().width, self.slide.image().height]);
        let texel = |[u, v]: [f64; 2]| {
            let [column, row] =
                [((u * width as f64) as usize).min(width - 1), ((v * height as f64) as usize).min(height - 1)];
            let [r, g, b, _] = image.srgb_texel(row * width + column).map(f64::from);
            photosite_core::spectrum::rgb::luminance([r, g, b])
        };
        let (sum, all) = mean_over(extent, shift, texel);
        sum / all
    }
}

/// ∫∫ f·cos⁴θ dx dy over the image 1 m away, and the same for f = 1; f is a function of the place on the slide.
fn mean_over(extent: [f64; 2], shift: [f64; 2], f: impl Fn([f64; 2]) -> f64) -> (f64, f64) {
    const CELLS: u16 = 256;
    let mut sums = (0.0, 0.0);
    for row in 0..CELLS {
        for column in 0..CELLS {
            let [u, v] = [column, row].map(|i| (f64::from(i) + 0.5) / f64::from(CELLS));
            let (x, y) = ((u - 0.5) * extent[0] + shift[0], (0.5 - v) * extent[1] + shift[1]);
            let cos2 = 1.0 / (1.0 + x * x + y * y);
            sums.0 += f([u, v]) * cos2 * cos2;
            sums.1 += cos2 * cos2;
        }
    }
    let cell = extent[0] * extent[1] / f64::from(CELLS).powi(2);
    (sums.0 * cell, sums.1 * cell)
}

/// Light of a projector. Its level is the spectral flux of a white slide, W·nm⁻¹.
impl DeltaModel for Projector {
    fn extent(&self, pose: &LightPose) -> Option<DeltaExtent> {
        let directions = Cone::of(pose.world_to_light.inverse() * Vec3::NEG_Z).widened(self.reach_rad());
        Some(DeltaExtent { radius: self.radius, directions })
    }

    fn power_factor(&self, _: f64) -> f64 {
        self.brightness()
    }

    /// Samples the direction to a point of the lens's opening.
    #[inline]
    fn sample_li(&self, pose: &LightPose, level: SpectrumId, u: [f32; 2], li: &LiContext<'_>) -> Option<LiSample> {
        let opening = self.opening(u);
        let from = pose.position + pose.world_to_light.inverse() * opening;
        let direction = pose.world_to_light * (li.point - from).normalize_or_zero();
        let intensity = self.intensity(opening, direction, li.wavelengths);
        if intensity.is_black() {
            return None;
        }
        LiSample::from_point(li.point, from, li.spectra.sample(level, li.wavelengths) * intensity)
    }
}
