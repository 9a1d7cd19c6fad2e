//! Layers as seen from one direction: what each lobe takes, what is left, and which lobe to sample.

mod energy_split;
mod reflectance;
mod scatter;
mod state;

use glam::Vec3;

use crate::bsdf::albedo::{FILM_NODES, FilmGlassRow, FilmRow, GlassRow, Hidden, Row, SheenRow};
use crate::bsdf::layered::layers::{Layered, Volume};
use state::{EnergySplit, Lobes, ONE, Spread, Tables, ZERO};

pub(super) use state::View;

impl<'a> View<'a> {
    /// Prepares the layers for `wo`; `None` where no light is scattered.
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
