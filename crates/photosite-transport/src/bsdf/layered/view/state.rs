//! State of layers that are seen from one direction.

use glam::{Vec3, Vec4};

use crate::bsdf::albedo::{
    Albedo, FILM_NODES, FilmGlassRow, FilmRow, FilmWeights, GlassRow, Hidden, HiddenPart, Row, SheenAlbedo, SheenRow,
};
use crate::bsdf::layered::layers::{Layered, Volume};
use photosite_core::spectrum::SampledSpectrum;

pub(super) const ZERO: SampledSpectrum = SampledSpectrum::ZERO;
pub(super) const ONE: SampledSpectrum = SampledSpectrum::ONE;

/// Mean of Schlick's weight over the hemisphere, ∫2μ(1 − μ)⁵ dμ.
pub(super) const MEAN_WEIGHT: f32 = 1.0 / 21.0;

/// The lobes that samples are drawn from, with their probabilities.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lobes {
    pub(super) coat: f32,
    pub(super) sheen: f32,
    pub(super) facets: f32,
    /// Probability of the lobe that goes straight on or is refracted.
    pub(super) through: f32,
    /// Probability of the base lobe, of the light that is left, on the side of `wo`.
    pub(super) base: f32,
    /// Probability of the base lobe, of the light that is left, on the other side.
    pub(super) base_behind: f32,
}

/// A layer's albedo and what it hides of the facets, for one direction or on average.
#[derive(Clone, Copy)]
pub(super) struct Under {
    /// Albedo of the facets, by Schlick's parameters.
    pub(super) facets: Albedo,
    /// Albedo of the facets with a film, by its nodes.
    pub(super) film: Option<FilmWeights>,
    /// c·E of the coat, and what it hides.
    pub(super) coat: (f32, Option<HiddenPart>),
    /// Albedo E of sheen of colour 1, and the part of the facets that it hides.
    pub(super) sheen: Option<(SheenAlbedo, HiddenPart)>,
    /// Albedos of one bounce at a refracting interface: from the side of `wo`, and from the other.
    pub(super) glass: [f32; 2],
    /// The change of that by a film, by its nodes.
    pub(super) thin_film_glass: Option<[FilmWeights; 2]>,
}

/// Tables for the layers of a point.
pub(super) struct Tables {
    pub(super) facets: Row,
    pub(super) film: Option<FilmRow>,
    pub(super) coat: Option<(Row, Hidden)>,
    pub(super) sheen: Option<(SheenRow, Hidden)>,
    pub(super) glass: Option<GlassRow>,
    pub(super) thin_film_glass: Option<FilmGlassRow>,
}

/// Light from one direction that the layers take, and light that they leave, or the means of both over the hemisphere.
#[derive(Clone, Copy)]
pub(super) struct EnergySplit {
    /// c·E(w) of the coat.
    pub(super) coat: f32,
    /// s·E(w) of the sheen.
    pub(super) sheen: SampledSpectrum,
    /// Divisor of the published sheen for this direction, at least 1.
    pub(super) sheen_excess: f32,
    /// Albedo E(w) of the facets over the coloured or clear base, under the layers.
    pub(super) dielectric: SampledSpectrum,
    /// Albedo E(w) of white facets under the layers.
    pub(super) white: SampledSpectrum,
    /// Light that is left under coat, sheen and the facets of the coloured base.
    pub(super) left: SampledSpectrum,
    /// Light that is left under white facets: light that bounces more than once between them.
    pub(super) left_by_white: SampledSpectrum,
    /// Light that one bounce at a refracting interface leaves, on the side of `wo` and on the other.
    pub(super) left_by_glass: [SampledSpectrum; 2],
}

/// The weights of a lobe that is spread like Lambert's over what is left: for light that the coloured base, facets in
/// general, and a refracting interface leave.
#[derive(Clone, Copy)]
pub(super) struct Spread {
    pub(super) coloured: SampledSpectrum,
    pub(super) white: SampledSpectrum,
    pub(super) glass: SampledSpectrum,
}

/// Layers seen from one direction.
pub(in crate::bsdf::layered) struct View<'a> {
    pub(super) layers: &'a Layered,
    /// Direction from which the layers are seen, above the surface.
    pub(super) wo: Vec3,
    /// Index of the other side over that of the side of `wo`, where light is refracted.
    pub(super) refracting: Option<Volume>,
    pub(super) is_inside: bool,
    pub(super) tables: Tables,
    /// Reflectances of the film on the dielectric and on the metal at the nodes.
    pub(super) film: Option<[[SampledSpectrum; FILM_NODES]; 2]>,
    pub(super) seen: EnergySplit,
    pub(super) mean: EnergySplit,
    /// Spread on the side of `wo` and on the other.
    pub(super) spread: [Spread; 2],
    pub(super) lobes: Lobes,
}

#[inline]
pub(super) fn at_least_zero(s: SampledSpectrum) -> SampledSpectrum {
    SampledSpectrum(s.0.max(Vec4::ZERO))
}
