//! Light from one direction that the layers take, and light that they leave.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::reflectance::at_nodes;
use super::state::{EnergySplit, ONE, Spread, Under, View, ZERO, at_least_zero};
use crate::bsdf::albedo::{COAT_F0, FILM_NODES, FilmGlassRow, FilmRow, GlassRow, node};
use crate::bsdf::compensation::{NOTHING_LEFT, further_bounces, shared_out};
use crate::bsdf::fresnel;
use photosite_core::spectrum::SampledSpectrum;

impl View<'_> {
    /// The tables at one direction above the surface.
    #[inline]
    pub(super) fn under(&self, w: Vec3) -> Under {
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
            sheen: tables.sheen.as_ref().map(|(row, hidden)| (row.directional(w.z), hidden.directional(w.z))),
            glass: tables.glass.as_ref().map_or([1.0; 2], |row| row.directional(w)),
            thin_film_glass: tables.thin_film_glass.as_ref().map(|row| row.directional(w.z)),
        }
    }

    #[inline]
    pub(super) fn under_on_average(&self) -> Under {
        let tables = &self.tables;
        let weight = self.layers.coat.map_or(0.0, |coat| coat.weight);
        Under {
            facets: tables.facets.mean(),
            film: tables.film.as_ref().map(FilmRow::mean),
            coat: tables
                .coat
                .as_ref()
                .map_or((0.0, None), |(row, hidden)| (weight * row.mean().at(COAT_F0), Some(hidden.mean()))),
            sheen: tables.sheen.as_ref().map(|(row, hidden)| (row.mean(), hidden.mean())),
            glass: tables.glass.as_ref().map_or([1.0; 2], GlassRow::mean),
            thin_film_glass: tables.thin_film_glass.as_ref().map(FilmGlassRow::mean),
        }
    }

    #[inline]
    pub(super) fn energy_split(&self, under: &Under) -> EnergySplit {
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
        let left_by_glass = self.left_by_glass(under);
        if layers.coat.is_none() && layers.sheen.is_none() {
            let (left, left_by_white) = (at_least_zero(ONE - bare), at_least_zero(ONE - bare_white));
            let (dielectric, white) = (bare, bare_white);
            return EnergySplit { dielectric, white, left, left_by_white, left_by_glass, ..EnergySplit::NOTHING };
        }
        let (coat, hidden_by_coat) = under.coat;
        let weight = layers.coat.map_or(0.0, |coat| coat.weight);
        let colour = layers.sheen.map_or(ZERO, |s| s.colour);
        // The part of the facets' light that the layers let through.
        let let_through = |f0: f32| {
            let by_coat = hidden_by_coat.map_or(0.0, |hidden| weight * hidden.at(f0));
            let by_sheen = under.sheen.map_or(0.0, |(_, hidden)| hidden.at(f0));
            (ONE - colour * by_sheen) * (1.0 - by_coat)
        };
        let (dielectric, white) = (bare * let_through(layers.f0.mean()), bare_white * let_through(1.0));
        let (sheen, sheen_excess) = under.sheen.map_or((ZERO, 1.0), |(s, _)| (colour * s.albedo(), s.excess()));
        let below = (ONE - sheen) * (1.0 - coat);
        EnergySplit {
            coat,
            sheen,
            sheen_excess,
            dielectric,
            white,
            left: at_least_zero(below - dielectric),
            left_by_white: at_least_zero(below - white),
            left_by_glass,
        }
    }

    /// Light that one bounce at a refracting interface leaves, on the side of `wo` and on the other.
    #[inline]
    fn left_by_glass(&self, under: &Under) -> [SampledSpectrum; 2] {
        let bare = under.glass.map(|bounced| SampledSpectrum::splat(1.0 - bounced));
        let (Some(film), Some([nodes, _]), Some(weights), Some(volume)) =
            (self.layers.film, &self.film, under.thin_film_glass, self.refracting)
        else {
            return bare.map(at_least_zero);
        };
        let outside = volume.eta[0].max(1.0 / volume.eta[0]);
        let change = std::array::from_fn(|j| {
            let cos = node(j, FILM_NODES);
            nodes[j] - SampledSpectrum::splat(fresnel::dielectric(cos, outside).reflectance)
        });
        [0, 1].map(|side| at_least_zero(bare[side] - at_nodes(&change, &weights[side]) * film.weight))
    }

    /// The colours of the lobes that share out what is left, see the module.
    #[inline]
    pub(super) fn spread(&self) -> [Spread; 2] {
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
            bounced += further_bounces(metal, f, e);
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
                for lane in 0..4 {
                    if let Some(shared) = shared_out(clear, volume.eta[0], [here[lane], there[lane]]) {
                        glass[0].0[lane] = shared.scales[0];
                        glass[1].0[lane] = layers.base_colour[lane] * shared.scales[1];
                    }
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

    /// Value f of the base lobe, between `wo` and a direction that sees `other`; `behind` says on which side.
    #[inline]
    pub(super) fn base(&self, other: &EnergySplit, behind: bool) -> SampledSpectrum {
        let (seen, spread) = (&self.seen, &self.spread[usize::from(behind)]);
        let mut f = spread.coloured * seen.left * other.left + spread.white * seen.left_by_white * other.left_by_white;
        if self.refracting.is_some() {
            f += spread.glass * (seen.left_by_glass[0] * other.left_by_glass[usize::from(behind)]);
        }
        f
    }

    /// Albedo of the base lobe, integrated over directions.
    #[inline]
    pub(super) fn base_albedo(&self, behind: bool) -> SampledSpectrum {
        let (seen, mean, spread) = (&self.seen, &self.mean, &self.spread[usize::from(behind)]);
        let glass = spread.glass * (seen.left_by_glass[0] * mean.left_by_glass[usize::from(behind)]);
        (spread.coloured * seen.left * mean.left + spread.white * seen.left_by_white * mean.left_by_white + glass) * PI
    }

    /// Part of the light that passes coat and sheen to the facets and back.
    #[inline]
    pub(super) fn cover(&self, other: &EnergySplit) -> SampledSpectrum {
        let sheen = SampledSpectrum(self.seen.sheen.0.max(other.sheen.0));
        (ONE - sheen) * (1.0 - self.seen.coat.max(other.coat))
    }
}

impl EnergySplit {
    pub(super) const NOTHING: Self = Self {
        coat: 0.0,
        sheen: ZERO,
        sheen_excess: 1.0,
        dielectric: ZERO,
        white: ZERO,
        left: ZERO,
        left_by_white: ZERO,
        left_by_glass: [ZERO; 2],
    };
}
