//! A slide in front of a lamp, thrown through a lens.

use std::sync::Arc;

use glam::{Quat, Vec2, Vec3};

use super::LightTables;
use super::emission::tint_spectrum;
use super::lights::{LiContext, LiSample};
use crate::texture::{Bitmap, Filter, SamplerSettings, Texture, UvTransform, Wrap};
use photosite_core::math::warp;
use photosite_core::spectrum::{SampledSpectrum, SpectrumId, Wavelengths};

/// A projector at the origin of its space. It shines along −z, with the top of the slide towards +y.
///
/// It is a camera run backwards: a point x m to the right and y m up in the plane 1 m away is lit by the slide at
/// (x/w + ½, ½ − y/h), w and h the extent of the picture there. The lens is evenly bright over its opening of area A
/// for each point of the slide, so the intensity in a direction at the angle θ from the axis is L·A·cos θ, and the flux
/// of a white slide
///
///   Φ = L·A·∫ cos θ dω = L·A·∫∫ cos⁴θ dx dy.
///
/// What lies in the plane of focus is sharp; elsewhere each point of the opening throws the picture to another place.
#[derive(Clone, Debug)]
pub struct Projector {
    slide: Texture,
    /// Extent of the picture 1 m away, m.
    extent: [f32; 2],
    /// Shift of the middle of the picture 1 m away, m to the right and up.
    shift: [f32; 2],
    /// Radius of the opening, m; 0 for a picture that is sharp everywhere.
    radius: f32,
    /// Distance of the plane of focus, m.
    focus_distance: f32,
    /// 1/∫∫ cos⁴θ dx dy.
    per_flux: f32,
}

impl Projector {
    /// From the extent and the shift of the picture 1 m away.
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

    /// Radius of the opening, m.
    pub(super) fn radius(&self) -> f32 {
        self.radius
    }

    /// Largest angle from the axis at which light leaves, rad.
    pub(super) fn reach_rad(&self) -> f32 {
        let farthest = |i: usize| 0.5 * self.extent[i].abs() + self.shift[i].abs();
        (farthest(0).hypot(farthest(1)) + self.radius / self.focus_distance).atan()
    }

    /// A point of the opening.
    #[inline]
    pub(super) fn opening(&self, u: [f32; 2]) -> Vec3 {
        if self.radius == 0.0 { Vec3::ZERO } else { (Vec2::from(warp::concentric_disk(u)) * self.radius).extend(0.0) }
    }

    /// Intensity from a point of the opening towards a unit direction, over the flux of a white slide, sr⁻¹.
    #[inline]
    pub(super) fn intensity(&self, opening: Vec3, direction: Vec3, wavelengths: &Wavelengths) -> SampledSpectrum {
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

/// ∫∫ f·cos⁴θ dx dy over the picture 1 m away, and the same for f = 1; f is a function of the place on the slide.
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

/// A slide thrown through a lens.
#[derive(Clone, Copy, Debug)]
pub struct ProjectorLight {
    /// Metres.
    pub position: Vec3,
    /// World → projector, which shines along −z.
    pub world_to_light: Quat,
    /// Handle in [`LightTables::projectors`].
    pub projector: u32,
    /// Spectral flux of a white slide, W·nm⁻¹.
    pub flux: SpectrumId,
}

impl ProjectorLight {
    /// A point of the lens's opening.
    #[inline]
    pub(super) fn sample_li(&self, tables: &LightTables, u: [f32; 2], li: &LiContext<'_>) -> Option<LiSample> {
        let projector = &tables.projectors[self.projector as usize];
        let opening = projector.opening(u);
        let from = self.position + self.world_to_light.inverse() * opening;
        let direction = self.world_to_light * (li.point - from).normalize_or_zero();
        let intensity = projector.intensity(opening, direction, li.wavelengths);
        if intensity.is_black() {
            return None;
        }
        LiSample::from_point(li.point, from, li.spectra.sample(self.flux, li.wavelengths) * intensity)
    }
}
