//! Albedos as plain data: numbers one after another, table by table, for devices that interpolate them.
//!
//! A grid is its rows, one for each roughness: values at all nodes of √μ and, twice, their mean, so that it is read as a
//! node behind the last. Tables of anisotropic roughness have entries of all azimuths and cosines, then their mean.

use glam::Vec2;

use super::film::{self, FILM_NODES, FilmWeights};
use super::grid::{Grid, Value};
use super::reflection::{self, Azimuthal, NODES};
use super::sheen::sheen_grid;
use super::{Hidden, glass, thin_film_glass};
use crate::bsdf::sheen::SMALLEST_ALPHA;
use crate::scene::packed::layers::flag;

/// Numbers of nodes by their names in kernels.
pub const NODE_COUNTS: [(&str, usize); 12] = [
    ("ALBEDO_NODES", NODES),
    ("HIDDEN_NODES", Hidden::NODES),
    ("FILM_NODES", FILM_NODES),
    ("FILM_ALPHAS", film::ALPHAS),
    ("GLASS_INDICES", glass::INDICES),
    ("GLASS_ALPHAS", glass::ALPHAS),
    ("GLASS_MUS", glass::MUS),
    ("GROOVED_ALPHAS", reflection::ALPHAS),
    ("GROOVED_GLASS_INDICES", glass::ANISOTROPIC_INDICES),
    ("GROOVED_GLASS_ALPHAS", glass::ANISOTROPIC_ALPHAS),
    ("AZIMUTHAL_PHIS", reflection::PHIS),
    ("AZIMUTHAL_MUS", reflection::MUS),
];

/// Ends of tables by their names in kernels: the largest index of glass, and the smallest roughness of sheen.
pub const TABLE_ENDS: [(&str, f32); 2] =
    [("LARGEST_INDEX", glass::LARGEST_INDEX), ("SHEEN_SMALLEST_ALPHA", SMALLEST_ALPHA)];

/// Places of the tables among the numbers of a scene; those that it does not need are empty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AlbedoSections {
    /// Facets, and facets with grooves.
    pub facets: [u32; 2],
    /// Film on facets.
    pub film: u32,
    /// Part of facets that a coat hides, and that sheen hides.
    pub hidden: [u32; 2],
    /// Sheen.
    pub sheen: u32,
    /// Refracting facets, and those with grooves.
    pub glass: [u32; 2],
    /// Film on refracting facets.
    pub film_glass: u32,
}

impl AlbedoSections {
    /// Lays out the tables that scenes of these features need ([`flag`]); `section` adds numbers and returns their place.
    pub(crate) fn of(features: u32, mut section: impl FnMut(Vec<f32>) -> u32) -> Self {
        let has = |all: u32| features & all == all;
        let mut table =
            |is_needed: bool, numbers: fn() -> Vec<f32>| section(if is_needed { numbers() } else { Vec::new() });
        let has_grooves = has(flag::GROOVES);
        let has_glass = has(flag::TRANSMISSION | flag::VOLUME) || has(flag::GLASS_BOUNCES);
        Self {
            facets: [
                table(has(flag::ANY) || has(flag::METAL_BOUNCES), || of_grids([reflection::isotropic()])),
                table(has_grooves, || of_azimuthal(reflection::anisotropic())),
            ],
            film: table(has(flag::FILM), || of_grids([film::table()])),
            hidden: [
                table(has(flag::COAT), || of_grids(Hidden::of_coats())),
                table(has(flag::SHEEN), || of_grids(Hidden::of_sheens())),
            ],
            sheen: table(has(flag::SHEEN), || of_grids([sheen_grid()])),
            glass: [
                table(has_glass, || of_grids(glass::isotropic())),
                table(has_glass && has_grooves, || of_azimuthal(glass::anisotropic())),
            ],
            film_glass: table(has_glass && has(flag::FILM), || of_grids(thin_film_glass::table().iter().flatten())),
        }
    }
}

/// Value that is some numbers.
trait Numbers: Value + 'static {
    fn numbers(self) -> Vec<f32>;
}

impl Numbers for Vec2 {
    fn numbers(self) -> Vec<f32> {
        self.to_array().to_vec()
    }
}

impl Numbers for FilmWeights {
    fn numbers(self) -> Vec<f32> {
        (0..FILM_NODES).map(|j| self.at(j)).collect()
    }
}

fn of_grids<'a, T: Numbers>(grids: impl IntoIterator<Item = &'a Grid<T>>) -> Vec<f32> {
    let rows = grids.into_iter().flat_map(Grid::rows);
    rows.flat_map(|(row, mean)| row.iter().copied().chain([mean; 2]).flat_map(T::numbers)).collect()
}

fn of_azimuthal(entries: &[Azimuthal]) -> Vec<f32> {
    let values =
        |entry: &Azimuthal| entry.directional.into_iter().flatten().chain([entry.mean]).flat_map(Vec2::numbers);
    entries.iter().flat_map(values).collect()
}
