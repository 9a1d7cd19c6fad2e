//! Layers as seen from one direction: what each lobe takes, what is left, and which lobe to sample.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{Vec3, Vec4};

use super::{Layered, Volume, sheen};
use crate::bsdf::albedo::{
    Albedo, COAT_F0, FILM_NODES, FilmRow, FilmWeights, GlassRow, Hidden, HiddenPart, Row, SheenRow,
};
use crate::bsdf::dielectric::{self, Refraction};
use crate::bsdf::fresnel::{self, schlick_weight};
use crate::bsdf::microfacet::ReflectionKernel;
use crate::bsdf::{BsdfEval, BsdfSample, GRAZING, is_above};
use crate::math::{Frame, Pdf, warp};
use crate::spectrum::SampledSpectrum;

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
}

/// Tables for the layers of a point.
struct Tables {
    facets: Row,
    film: Option<FilmRow>,
    coat: Option<(Row, Hidden)>,
    sheen: Option<(SheenRow, Hidden)>,
    glass: Option<GlassRow>,
}

/// What the layers take of light from one direction, and what they leave, or the mean of that over the hemisphere.
#[derive(Clone, Copy)]
struct Share {
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
    left_by_glass: [f32; 2],
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
    seen: Share,
    mean: Share,
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
            seen: Share::NOTHING,
            mean: Share::NOTHING,
            spread: [nothing; 2],
            lobes: Lobes::default(),
            tables,
        };
        view.seen = view.share(&view.under(wo));
        view.mean = view.share(&view.under_on_average());
        view.spread = view.spread();
        view.lobes = view.choose()?;
        Some(view)
    }

    /// The tables at one direction above the surface.
    #[inline]
    fn under(&self, w: Vec3) -> Under {
        let tables = &self.tables;
        Under {
            facets: tables.facets.directional(w),
            film: tables.film.as_ref().map(|row| row.directional(w.z)),
            coat: match (&tables.coat, self.layers.coat) {
                (Some((row, hidden)), Some(coat)) => {
                    let in_coat = Vec3::new(0.0, 0.0, w.dot(coat.normal).clamp(0.0, 1.0));
                    (coat.weight * row.directional(in_coat).at(COAT_F0), Some(hidden.directional(w.z)))
                }
                (None, _) | (Some(_), None) => (0.0, None),
            },
            sheen: tables
                .sheen
                .as_ref()
                .map_or((0.0, None), |(row, hidden)| (row.directional(w.z), Some(hidden.directional(w.z)))),
            glass: tables.glass.as_ref().map_or([1.0; 2], |row| row.directional(w)),
        }
    }

    #[inline]
    fn under_on_average(&self) -> Under {
        let tables = &self.tables;
        let weight = self.layers.coat.map_or(0.0, |coat| coat.weight);
        Under {
            facets: tables.facets.mean(),
            film: tables.film.as_ref().map(FilmRow::mean),
            coat: tables
                .coat
                .as_ref()
                .map_or((0.0, None), |(row, hidden)| (weight * row.mean().at(COAT_F0), Some(hidden.mean()))),
            sheen: tables.sheen.as_ref().map_or((0.0, None), |(row, hidden)| (row.mean(), Some(hidden.mean()))),
            glass: tables.glass.as_ref().map_or([1.0; 2], GlassRow::mean),
        }
    }

    #[inline]
    fn share(&self, under: &Under) -> Share {
        let layers = self.layers;
        let [scale, bias] = under.facets.parts();
        let schlick = layers.f0 * scale + SampledSpectrum::splat(bias);
        let bare = match (layers.film, &self.film, under.film) {
            (Some(film), Some([nodes, _]), Some(weights)) => {
                // The weights are those of isotropic facets; their sum is known better.
                let norm = film.weight * (scale + bias) / weights.sum().max(f32::MIN_POSITIVE);
                schlick * (1.0 - film.weight) + at_nodes(nodes, &weights) * norm
            }
            (_, _, _) => schlick,
        };
        let (bare, bare_white) = (bare * layers.specular, SampledSpectrum::splat(scale + bias));
        // The table is for the exact reflectance alone; with a film, what bounces twice is lost rather than gained.
        let left_by_glass =
            if layers.film.is_some() { [0.0; 2] } else { under.glass.map(|bounced| (1.0 - bounced).max(0.0)) };
        if layers.coat.is_none() && layers.sheen.is_none() {
            let (left, left_by_white) = (at_least_zero(ONE - bare), at_least_zero(ONE - bare_white));
            let (dielectric, white) = (bare, bare_white);
            return Share { coat: 0.0, sheen: ZERO, dielectric, white, left, left_by_white, left_by_glass };
        }
        let (coat, hidden_by_coat) = under.coat;
        let (sheen_albedo, hidden_by_sheen) = under.sheen;
        let weight = layers.coat.map_or(0.0, |coat| coat.weight);
        let colour = layers.sheen.map_or(ZERO, |s| s.colour);
        // The part of the facets' light that the layers let through.
        let let_through = |f0: f32| {
            let by_coat = hidden_by_coat.map_or(0.0, |hidden| weight * hidden.at(f0));
            let by_sheen = hidden_by_sheen.map_or(0.0, |hidden| hidden.at(f0));
            (ONE - colour * by_sheen) * (1.0 - by_coat)
        };
        let (dielectric, white) = (bare * let_through(layers.f0.mean()), bare_white * let_through(1.0));
        let sheen = colour * sheen_albedo;
        let below = (ONE - sheen) * (1.0 - coat);
        Share {
            coat,
            sheen,
            dielectric,
            white,
            left: at_least_zero(below - dielectric),
            left_by_white: at_least_zero(below - white),
            left_by_glass,
        }
    }

    /// The colours of the lobes that share out what is left, see the module.
    #[inline]
    fn spread(&self) -> [Spread; 2] {
        let layers = self.layers;
        let [metal, coloured, clear] = layers.parts();
        let dt = layers.diffuse_transmission;
        let per_mean = |mean: SampledSpectrum| mean.map(|m| if m > NOTHING_LEFT { FRAC_1_PI / m } else { 0.0 });
        let by_coloured = per_mean(self.mean.left) * coloured;
        let by_white = per_mean(self.mean.left_by_white);
        let mut bounced = ZERO;
        if metal > 0.0 {
            let f = self.mean_reflectance(1, layers.base_colour);
            let e = self.tables.facets.mean().at(1.0);
            bounced += f * f * (metal * e) / (ONE - f * (1.0 - e));
        }
        let (mut passed, mut glass) = (ZERO, [ZERO; 2]);
        match self.refracting {
            None if clear > 0.0 => {
                let f = self.mean_reflectance(0, layers.f0) * layers.specular;
                bounced += f * clear;
                passed = (ONE - f) * layers.base_colour * clear;
            }
            Some(volume) => {
                let [here, there] = self.mean.left_by_glass;
                let most = here.max(there);
                if most > NOTHING_LEFT {
                    let let_in = 1.0 - mean_dielectric(volume.eta[0]);
                    // What crosses is let_in·there/most of what is left here, and reciprocally.
                    let crossing = let_in * there / most;
                    glass[0] = SampledSpectrum::splat(clear * FRAC_1_PI * (1.0 - crossing) / here.max(NOTHING_LEFT));
                    let over_squared_index = FRAC_1_PI * let_in / (most * volume.eta[0] * volume.eta[0]);
                    glass[1] = layers.base_colour * (clear * over_squared_index);
                }
            }
            None => {}
        }
        [
            Spread {
                coloured: layers.base_colour * by_coloured * (1.0 - dt),
                white: bounced * by_white,
                glass: glass[0],
            },
            Spread {
                coloured: layers.diffuse_transmission_colour * by_coloured * dt,
                white: passed * by_white,
                glass: glass[1],
            },
        ]
    }

    /// f of what is left, between `wo` and a direction that sees `other`; `behind` says on which side.
    #[inline]
    fn base(&self, other: &Share, behind: bool) -> SampledSpectrum {
        let (seen, spread) = (&self.seen, &self.spread[usize::from(behind)]);
        let mut f = spread.coloured * seen.left * other.left + spread.white * seen.left_by_white * other.left_by_white;
        if self.refracting.is_some() {
            f += spread.glass * (seen.left_by_glass[0] * other.left_by_glass[usize::from(behind)]);
        }
        f
    }

    /// The same integrated over directions: the albedo of that lobe.
    #[inline]
    fn base_albedo(&self, behind: bool) -> SampledSpectrum {
        let (seen, mean, spread) = (&self.seen, &self.mean, &self.spread[usize::from(behind)]);
        let glass = spread.glass * (seen.left_by_glass[0] * mean.left_by_glass[usize::from(behind)]);
        (spread.coloured * seen.left * mean.left + spread.white * seen.left_by_white * mean.left_by_white + glass) * PI
    }

    /// What coat and sheen let through to the facets and back.
    #[inline]
    fn cover(&self, other: &Share) -> SampledSpectrum {
        let sheen = SampledSpectrum(self.seen.sheen.0.max(other.sheen.0));
        (ONE - sheen) * (1.0 - self.seen.coat.max(other.coat))
    }

    /// The facets' reflectance at the cosine `cos`, with Schlick's weight and the film if there is one.
    #[inline]
    fn reflectance(&self, f0: SampledSpectrum, cos: f32) -> SampledSpectrum {
        let white = schlick_weight(cos);
        let bare = f0 * (1.0 - white) + SampledSpectrum::splat(white);
        self.with_film(bare, f0, cos)
    }

    #[inline]
    fn with_film(&self, bare: SampledSpectrum, f0: SampledSpectrum, cos: f32) -> SampledSpectrum {
        match self.layers.film {
            Some(film) => bare * (1.0 - film.weight) + film.reflectance(cos, f0) * film.weight,
            None => bare,
        }
    }

    /// ∫2μ·R(μ) dμ; `base` is 0 for the dielectric, 1 for the metal.
    #[inline]
    fn mean_reflectance(&self, base: usize, f0: SampledSpectrum) -> SampledSpectrum {
        let bare = f0 * (1.0 - MEAN_WEIGHT) + SampledSpectrum::splat(MEAN_WEIGHT);
        match (self.layers.film, &self.film) {
            (Some(film), Some(nodes)) => {
                let weights = FilmWeights::cosine_mean();
                bare * (1.0 - film.weight) + at_nodes(&nodes[base], &weights) * film.weight
            }
            (_, _) => bare,
        }
    }

    /// The reflectance of a refracting facet whose index (that of the far side over the near one) is `eta` and whose
    /// exact reflectance is `exact`: Schlick's form with the exact weight. `cos_outside` is for the film.
    #[inline]
    fn refracting_reflectance(
        &self,
        exact: SampledSpectrum,
        eta: SampledSpectrum,
        cos_outside: f32,
    ) -> SampledSpectrum {
        let root = (eta - ONE) / (eta + ONE);
        let normal = root * root;
        let weight = SampledSpectrum(((exact - normal) / (ONE - normal)).0.clamp(Vec4::ZERO, Vec4::ONE));
        let f0 = self.layers.f0;
        let partial = self.with_film(f0 * (ONE - weight) + weight, f0, cos_outside) * self.layers.specular;
        // Nothing is let through where reflection is total.
        SampledSpectrum(Vec4::select(exact.0.cmpge(Vec4::ONE), Vec4::ONE, partial.0))
    }

    /// The same for light that meets a facet at `cos` on the side of `wo`.
    #[inline]
    fn clear_reflectance(&self, volume: Volume, cos: f32) -> SampledSpectrum {
        let exact = |eta| fresnel::dielectric(cos, eta).reflectance;
        let exact =
            if volume.dispersive { volume.eta.map(exact) } else { SampledSpectrum::splat(exact(volume.eta[0])) };
        self.refracting_reflectance(exact, volume.eta, self.cos_outside(cos, volume.eta[0]))
    }

    /// The cosine outside of light that meets a facet at `cos` on the side of `wo`.
    #[inline]
    fn cos_outside(&self, cos: f32, eta: f32) -> f32 {
        if self.is_inside { fresnel::dielectric(cos, eta).cos_transmitted } else { cos }
    }

    /// Probabilities in proportion to what each lobe gives back of light from `wo`.
    #[inline]
    fn choose(&self) -> Option<Lobes> {
        let (layers, seen) = (self.layers, &self.seen);
        let [metal, coloured, clear] = layers.parts();
        let layered = self.layered_part();
        let mut lobes = Lobes {
            coat: layered * seen.coat,
            sheen: layered * seen.sheen.mean() * (1.0 - seen.coat),
            facets: coloured * seen.dielectric.mean(),
            through: 0.0,
            base: self.base_albedo(false).mean(),
            base_behind: self.base_albedo(true).mean(),
        };
        if metal > 0.0 {
            lobes.facets += metal * (seen.white * self.reflectance(layers.base_colour, self.wo.z)).mean();
        }
        if let Some(volume) = self.refracting {
            let mut reflected = self.clear_reflectance(volume, self.wo.z.min(1.0));
            if !self.passes_undisturbed() {
                // Where the surface as a whole reflects all or nothing, some of its facets do not.
                reflected = SampledSpectrum(reflected.0.clamp(Vec4::splat(0.1), Vec4::splat(0.9)));
            }
            lobes.facets += clear * reflected.mean();
            lobes.through = clear * ((ONE - reflected) * layers.base_colour).mean();
        } else if clear > 0.0 {
            lobes.facets += clear * seen.dielectric.mean();
            lobes.through = clear * (at_least_zero(seen.white - seen.dielectric) * layers.base_colour).mean();
        }
        lobes.normalised()
    }

    /// How much of what is left is sampled evenly over the hemisphere rather than by the cosine: what facets leave comes
    /// mostly from near the surface, where the cosine seldom looks.
    #[inline]
    fn even_part(&self) -> f32 {
        let [_, coloured, _] = self.layers.parts();
        if coloured < 1.0 { 0.5 } else { 0.0 }
    }

    /// Density of what [`Self::sample_base`] draws, at the cosine `z`.
    #[inline]
    fn base_density(&self, z: f32) -> f32 {
        let even = self.even_part();
        FRAC_1_PI * ((1.0 - even) * z + even * 0.5)
    }

    #[inline]
    fn sample_base(&self, u_part: f32, u: [f32; 2]) -> Vec3 {
        if u_part < self.even_part() { warp::uniform_cone(u, 0.0) } else { warp::cosine_hemisphere(u) }
    }

    /// Whether light passes in one direction only.
    #[inline]
    fn passes_undisturbed(&self) -> bool {
        let distribution = self.layers.distribution;
        self.refracting.map_or(distribution.is_smooth(), |v| dielectric::is_delta(v.eta, distribution))
    }

    /// The part of the surface that layers lie on: all but the refracting one.
    #[inline]
    fn layered_part(&self) -> f32 {
        let [_, _, clear] = self.layers.parts();
        if self.refracting.is_some() { 1.0 - clear } else { 1.0 }
    }

    /// The facets' reflectance, all parts of the base together, under the layers between `wo` and what sees `other`.
    #[inline]
    fn facets(&self, cos: f32, other: &Share) -> SampledSpectrum {
        let layers = self.layers;
        let [metal, coloured, clear] = layers.parts();
        let mut sum = ZERO;
        if metal > 0.0 {
            sum += self.reflectance(layers.base_colour, cos) * metal;
        }
        let schlick = if self.refracting.is_some() { coloured } else { coloured + clear };
        if schlick > 0.0 {
            sum += self.reflectance(layers.f0, cos) * (layers.specular * schlick);
        }
        sum *= self.cover(other);
        if let Some(volume) = self.refracting {
            sum += self.clear_reflectance(volume, cos) * clear;
        }
        sum
    }

    /// Value and density of all lobes of some width.
    #[inline]
    pub(super) fn eval(&self, wi: Vec3) -> BsdfEval {
        if wi.z > 0.0 { self.eval_reflection(wi) } else { self.eval_transmission(wi) }
    }

    #[inline]
    fn eval_reflection(&self, wi: Vec3) -> BsdfEval {
        let layers = self.layers;
        let other = self.share(&self.under(wi));
        let mut f = self.base(&other, false);
        let mut pdf = self.lobes.base * self.base_density(wi.z);
        if !layers.distribution.is_smooth() && self.lobes.facets > 0.0 {
            let kernel = layers.distribution.reflection(self.wo, wi);
            f += self.facets(kernel.cos_facet, &other) * kernel.value;
            pdf += self.lobes.facets * kernel.pdf;
        }
        if let Some(sheen) = layers.sheen {
            let below_coat = 1.0 - self.seen.coat.max(other.coat);
            f += sheen.colour * (sheen::value(sheen.alpha, self.wo, wi) * below_coat * self.layered_part());
            pdf += self.lobes.sheen / TAU;
        }
        if let Some(coat) = layers.coat.filter(|coat| !coat.distribution.is_smooth()) {
            let frame = Frame::from_normal(coat.normal);
            let (wo, wi_coat) = (frame.to_local(self.wo), frame.to_local(wi));
            if is_above(wo) && is_above(wi_coat) {
                let kernel = coat.distribution.reflection(wo, wi_coat);
                let value = self.layered_part() * coat_reflectance(coat.weight, &kernel);
                f += SampledSpectrum::splat(value * wi_coat.z / wi.z);
                pdf += self.lobes.coat * kernel.pdf;
            }
        }
        BsdfEval { f, pdf: Pdf::new(pdf) }
    }

    #[inline]
    fn eval_transmission(&self, wi: Vec3) -> BsdfEval {
        let layers = self.layers;
        let [_, _, clear] = layers.parts();
        let mirror = dielectric::mirrored(wi);
        let other = self.share(&self.under(mirror));
        let mut f = self.base(&other, true);
        let mut pdf = self.lobes.base_behind * self.base_density(mirror.z);
        if clear > 0.0 && !self.passes_undisturbed() {
            let tint = layers.base_colour * clear;
            match self.refracting {
                None => {
                    let kernel = layers.distribution.reflection(self.wo, mirror);
                    let let_in = ONE - self.reflectance(layers.f0, kernel.cos_facet) * layers.specular;
                    f += let_in * tint * self.cover(&other) * kernel.value;
                    pdf += self.lobes.through * kernel.pdf;
                }
                Some(volume) => {
                    if let Some(facet) = Refraction::between(volume.eta[0], self.wo, wi) {
                        let (cos_o, cos_i) = (facet.cos_o.min(1.0), facet.cos_i.min(1.0));
                        let exact = fresnel::between(cos_o, cos_i, facet.eta).reflectance.min(1.0);
                        let cos_outside = if self.is_inside { cos_i } else { cos_o };
                        let reflected =
                            self.refracting_reflectance(SampledSpectrum::splat(exact), volume.eta, cos_outside);
                        let (value, density) = dielectric::refraction(layers.distribution, self.wo, wi, &facet);
                        f += at_least_zero(ONE - reflected) * tint * value;
                        pdf += self.lobes.through * density;
                    }
                }
            }
        }
        BsdfEval { f, pdf: Pdf::new(pdf) }
    }

    #[inline]
    pub(super) fn sample(&self, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let layers = self.layers;
        let Lobes { coat, sheen, facets, through, base, base_behind } = self.lobes;
        // Where u_lobe lies among the probabilities laid end to end.
        let [to_coat, to_sheen] = [coat, coat + sheen];
        let to_facets = to_sheen + facets;
        let to_through = to_facets + through;
        let to_base = to_through + base;
        let wi = if u_lobe < to_coat {
            let layer = layers.coat?;
            let frame = Frame::from_normal(layer.normal);
            let wo = frame.to_local(self.wo);
            if !is_above(wo) {
                return None;
            }
            if layer.distribution.is_smooth() {
                let wi = frame.to_world(Vec3::new(-wo.x, -wo.y, wo.z));
                let part = self.layered_part() * layer.weight * coat_fresnel(wo.z.min(1.0));
                return is_above(wi).then(|| BsdfSample::mirrored(SampledSpectrum::splat(part), wi, coat));
            }
            frame.to_world(layer.distribution.sample_reflection(wo, u)?.0)
        } else if u_lobe < to_sheen {
            warp::uniform_cone(u, 0.0)
        } else if u_lobe < to_facets {
            if layers.distribution.is_smooth() {
                let wi = Vec3::new(-self.wo.x, -self.wo.y, self.wo.z);
                let other = self.share(&self.under(wi));
                return Some(BsdfSample::mirrored(self.facets(self.wo.z.min(1.0), &other), wi, facets));
            }
            layers.distribution.sample_reflection(self.wo, u)?.0
        } else if u_lobe < to_through {
            if self.passes_undisturbed() {
                return self.pass_undisturbed();
            }
            self.sample_through(u)?
        } else if u_lobe < to_base {
            self.sample_base((u_lobe - to_through) / base, u)
        } else if base_behind > 0.0 {
            dielectric::mirrored(self.sample_base((u_lobe - to_base) / base_behind, u))
        } else {
            // Rounding of the sum.
            return None;
        };
        if wi.z.abs() <= GRAZING {
            return None;
        }
        let BsdfEval { f, pdf } = self.eval(wi);
        let sample = BsdfSample::reflected(f, wi, pdf);
        (pdf.0 > 0.0).then(|| {
            if wi.z > 0.0 {
                sample
            } else {
                BsdfSample { is_transmission: true, eta: self.refracting.map_or(1.0, |v| v.eta[0]), ..sample }
            }
        })
    }

    /// Straight on, or refracted by a polished surface.
    #[inline]
    fn pass_undisturbed(&self) -> Option<BsdfSample> {
        let layers = self.layers;
        let [_, _, clear] = layers.parts();
        let cos = self.wo.z.min(1.0);
        let (eta, cos_through, let_in, dispersive) = match self.refracting {
            None => (1.0, cos, ONE - self.reflectance(layers.f0, cos) * layers.specular, false),
            Some(volume) => {
                let through = fresnel::dielectric(cos, volume.eta[0]).cos_transmitted;
                (volume.eta[0], through, ONE - self.clear_reflectance(volume, self.wo.z.min(1.0)), volume.dispersive)
            }
        };
        if cos_through <= GRAZING {
            return None;
        }
        let wi = Vec3::new(-self.wo.x / eta, -self.wo.y / eta, -cos_through);
        let cover = match self.refracting {
            None => self.cover(&self.share(&self.under(dielectric::mirrored(wi)))),
            Some(_) => ONE,
        };
        let part = at_least_zero(let_in) * layers.base_colour * cover * clear;
        Some(BsdfSample {
            f: part * dielectric::lanes(1.0 / (eta * eta * cos_through), dispersive),
            is_transmission: true,
            terminates_secondary: dispersive,
            eta,
            ..BsdfSample::mirrored(ONE, wi, self.lobes.through)
        })
    }

    /// Through a facet.
    #[inline]
    fn sample_through(&self, u: [f32; 2]) -> Option<Vec3> {
        let distribution = self.layers.distribution;
        match self.refracting {
            None => distribution.sample_reflection(self.wo, u).map(|(wi, _)| dielectric::mirrored(wi)),
            Some(volume) => {
                let m = distribution.sample_visible(self.wo, u);
                let cos_o = self.wo.dot(m).clamp(0.0, 1.0);
                let eta = volume.eta[0];
                let cos_transmitted = fresnel::dielectric(cos_o, eta).cos_transmitted;
                Refraction::by(eta, self.wo, m, cos_o, cos_transmitted).map(|(_, wi)| wi)
            }
        }
    }
}

impl Lobes {
    #[inline]
    fn normalised(self) -> Option<Self> {
        let Self { coat, sheen, facets, through, base, base_behind } = self;
        let sum = coat + sheen + facets + through + base + base_behind;
        (sum > 0.0).then(|| Self {
            coat: coat / sum,
            sheen: sheen / sum,
            facets: facets / sum,
            through: through / sum,
            base: base / sum,
            base_behind: base_behind / sum,
        })
    }
}

impl Share {
    const NOTHING: Self = Self {
        coat: 0.0,
        sheen: ZERO,
        dielectric: ZERO,
        white: ZERO,
        left: ZERO,
        left_by_white: ZERO,
        left_by_glass: [0.0; 2],
    };
}

#[inline]
fn at_least_zero(s: SampledSpectrum) -> SampledSpectrum {
    SampledSpectrum(s.0.max(Vec4::ZERO))
}

/// Σ R(cⱼ)·Wⱼ.
#[inline]
fn at_nodes(reflectances: &[SampledSpectrum; FILM_NODES], weights: &FilmWeights) -> SampledSpectrum {
    let mut sum = ZERO;
    for (j, &reflectance) in reflectances.iter().enumerate() {
        sum += reflectance * weights.at(j);
    }
    sum
}

#[inline]
fn coat_fresnel(cos: f32) -> f32 {
    let white = schlick_weight(cos);
    COAT_F0 + (1.0 - COAT_F0) * white
}

#[inline]
fn coat_reflectance(weight: f32, kernel: &ReflectionKernel) -> f32 {
    weight * coat_fresnel(kernel.cos_facet) * kernel.value
}

/// Mean over the hemisphere of the reflectance of an interface, F̄ ([KullaConty17](crate::references#kullaconty17)): for
/// η > 1 a fit; for η < 1 by 1 − F̄(1/η) = η²(1 − F̄(η)), what goes in being what comes out.
#[inline]
fn mean_dielectric(eta: f32) -> f32 {
    let denser = |eta: f32| (eta - 1.0) / (4.085_67 + 1.000_71 * eta);
    if eta >= 1.0 { denser(eta) } else { 1.0 - eta * eta * (1.0 - denser(1.0 / eta)) }
}
