//! The directional albedo of sheen.

use std::sync::OnceLock;

use super::grid::{Grid, GridRow};
use super::reflection::NODES;
use crate::bsdf::sheen;

/// The albedo of sheen of one roughness α, for a colour of 1.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct SheenRow(GridRow<f32>);

impl SheenRow {
    #[inline]
    pub(in crate::bsdf) fn of(alpha: f32) -> Self {
        Self(sheen_grid().row(alpha))
    }

    #[inline]
    pub(in crate::bsdf) fn directional(&self, mu: f32) -> f32 {
        self.0.directional(mu)
    }

    #[inline]
    pub(in crate::bsdf) fn mean(&self) -> f32 {
        self.0.mean()
    }
}

pub(super) fn sheen_grid() -> &'static Grid<f32> {
    static TABLE: OnceLock<Grid<f32>> = OnceLock::new();
    TABLE.get_or_init(|| Grid::new(NODES, NODES, sheen::albedo))
}
