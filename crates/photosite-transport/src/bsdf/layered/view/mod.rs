//! Layers as seen from one direction: what each lobe takes, what is left, and which lobe to sample.

mod energy_split;
mod reflectance;
mod scatter;

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{Vec3, Vec4};

use super::{Layered, Volume, sheen};
use crate::bsdf::albedo::{
    Albedo, COAT_F0, FILM_NODES, FilmGlassRow, FilmRow, FilmWeights, GlassRow, Hidden, HiddenPart, Row, SheenRow, node,
};
use crate::bsdf::dielectric::{self, Refraction};
use crate::bsdf::fresnel::{self, schlick_weight};
use crate::bsdf::microfacet::ReflectionKernel;
use crate::bsdf::{BsdfEval, BsdfSample, GRAZING, is_above};
use photosite_core::math::{Frame, Pdf, warp};
use photosite_core::spectrum::SampledSpectrum;
use reflectance::{at_nodes, coat_fresnel, coat_reflectance, mean_dielectric};

const ZERO: SampledSpectrum = SampledSpectrum::ZERO;
const ONE: SampledSpectrum = SampledSpectrum::ONE;

/// Mean of Schlick's weight over the hemisphere, ∫2μ(1 − μ)⁵ dμ.
const MEAN_WEIGHT: f32 = 1.0 / 21.0;

/// Remainders with a smaller mean are no more than rounding of the tables.
const NOTHING_LEFT: f32 = 1e-5;

/// The lobes that samples are drawn from, with their probabilities.
#[derive(Clone, Copy, Debug, Default)]
struct Lobes {
    coat: f32,
    sheen: f32,
    facets: f32,
    /// Straight on or refracted.
    through: f32,
    /// What is left, on the side of `wo`.
    base: f32,
    /// What is left, on the other.
    base_behind: f32,
}

/// A layer's albedo and what it hides of the facets, for one direction or on average.
#[derive(Clone, Copy)]
struct Under {
    /// Of the facets, by Schlick's parameters.
    facets: Albedo,
    /// Of the facets with a film, by its nodes.
    film: Option<FilmWeights>,
    /// c·E of the coat, and what it hides.
    coat: (f32, Option<HiddenPart>),
    /// E of sheen of colour 1, and what it hides.
    sheen: (f32, Option<HiddenPart>),
    /// One bounce at a refracting interface: from the side of `wo`, and from the other.
    glass: [f32; 2],
    /// The change of that by a film, by its nodes.
    thin_film_glass: Option<[FilmWeights; 2]>,
}

/// Tables for the layers of a point.
struct Tables {
    facets: Row,
    film: Option<FilmRow>,
    coat: Option<(Row, Hidden)>,
    sheen: Option<(SheenRow, Hidden)>,
    glass: Option<GlassRow>,
    thin_film_glass: Option<FilmGlassRow>,
}

/// What the layers take of light from one direction, and what they leave, or the mean of that over the hemisphere.
#[derive(Clone, Copy)]
struct EnergySplit {
    /// c·E(w) of the coat.
    coat: f32,
    /// s·E(w) of the sheen.
    sheen: SampledSpectrum,
    /// E(w) of the facets over the coloured or clear base, under the layers.
    dielectric: SampledSpectrum,
    /// E(w) of white facets under the layers.
    white: SampledSpectrum,
    /// What is left under coat, sheen and the facets of the coloured base.
    left: SampledSpectrum,
    /// The same where the facets are white: what bounces more than once between them.
    left_by_white: SampledSpectrum,
    /// What one bounce at a refracting interface leaves, on the side of `wo` and on the other.
    left_by_glass: [SampledSpectrum; 2],
}

/// The weights of a lobe that is spread like Lambert's over what is left: for light that the coloured base, facets in
/// general, and a refracting interface leave.
#[derive(Clone, Copy)]
struct Spread {
    coloured: SampledSpectrum,
    white: SampledSpectrum,
    glass: SampledSpectrum,
}

pub(super) struct View<'a> {
    layers: &'a Layered,
    /// Above the surface.
    wo: Vec3,
    /// Index of the other side over that of the side of `wo`, where light is refracted.
    refracting: Option<Volume>,
    is_inside: bool,
    tables: Tables,
    /// Reflectances of the film on the dielectric and on the metal at the nodes.
    film: Option<[[SampledSpectrum; FILM_NODES]; 2]>,
    seen: EnergySplit,
    mean: EnergySplit,
    /// On the side of `wo` and on the other.
    spread: [Spread; 2],
    lobes: Lobes,
}

impl<'a> View<'a> {
    /// None where nothing at all is scattered.
    #[inline]
    pub(super) fn new(layers: &'a Layered, wo: Vec3, is_inside: bool) -> Option<Self> {
        let refracting = layers.refracting().map(|v| Volume { eta: if is_inside { ONE / v.eta } else { v.eta }, ..v });
        let base = layers.distribution;
        let tables = Tables {
            facets: Row::of(base),
            film: layers.film.map(|_| FilmRow::of(base)),
            coat: layers.coat.map(|c| (Row::of(c.distribution), Hidden::by_coat(c.distribution, base))),
            sheen: layers.sheen.map(|s| (SheenRow::of(s.alpha), Hidden::by_sheen(s.alpha, base))),
            glass: refracting.map(|v| GlassRow::of(v.eta[0], base)),
            thin_film_glass: refracting.filter(|_| layers.film.is_some()).map(|v| FilmGlassRow::of(v.eta[0], base)),
        };
        let film = layers.film.map(|film| {
            let nodes = |f0| std::array::from_fn(|j| film.reflectance(j as f32 / (FILM_NODES - 1) as f32, f0));
            [nodes(layers.f0), nodes(layers.base_colour)]
        });
        let nothing = Spread { coloured: ZERO, white: ZERO, glass: ZERO };
        let mut view = Self {
            layers,
            wo,
            refracting,
            is_inside,
            film,
            seen: EnergySplit::NOTHING,
            mean: EnergySplit::NOTHING,
            spread: [nothing; 2],
            lobes: Lobes::default(),
            tables,
        };
        view.seen = view.energy_split(&view.under(wo));
        view.mean = view.energy_split(&view.under_on_average());
        view.spread = view.spread();
        view.lobes = view.choose()?;
        Some(view)
    }
}

#[inline]
fn at_least_zero(s: SampledSpectrum) -> SampledSpectrum {
    SampledSpectrum(s.0.max(Vec4::ZERO))
}
