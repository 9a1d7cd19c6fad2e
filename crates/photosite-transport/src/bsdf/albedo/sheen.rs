//! The directional albedo of sheen.

use std::sync::OnceLock;

use glam::Vec2;

use super::grid::{Grid, GridRow};
use super::reflection::NODES;
use crate::bsdf::sheen::{self, SMALLEST_ALPHA};

/// The albedo of sheen of one roughness α, for a colour of 1. No interpolation lies below what the lobe gives back.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct SheenRow(GridRow<Vec2>);

/// That albedo for one direction or on average.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct SheenAlbedo(Vec2);

impl SheenRow {
    #[inline]
    pub(in crate::bsdf) fn of(alpha: f32) -> Self {
        Self(sheen_grid().row(position(alpha)))
    }

    #[inline]
    pub(in crate::bsdf) fn directional(&self, mu: f32) -> SheenAlbedo {
        SheenAlbedo(self.0.directional(mu))
    }

    #[inline]
    pub(in crate::bsdf) fn mean(&self) -> SheenAlbedo {
        SheenAlbedo(self.0.mean())
    }
}

impl SheenAlbedo {
    /// What the published lobe is divided by, at least.
    #[inline]
    pub(in crate::bsdf) fn excess(self) -> f32 {
        self.0.x.max(1.0)
    }

    /// Albedo of the lobe so divided.
    #[inline]
    pub(in crate::bsdf) fn albedo(self) -> f32 {
        self.0.y
    }
}

/// Place of a roughness in the grid, whose nodes are even in √α from that of the narrowest lobe on.
#[inline]
pub(super) fn position(alpha: f32) -> f32 {
    let smallest = SMALLEST_ALPHA.sqrt();
    ((alpha.sqrt() - smallest) / (1.0 - smallest)).max(0.0).powi(2)
}

/// Both albedos, of the published lobe and of the one in use, at [`position`] and cosine.
pub(super) fn sheen_grid() -> &'static Grid<Vec2> {
    static TABLE: OnceLock<Grid<Vec2>> = OnceLock::new();
    TABLE.get_or_init(|| {
        Grid::from_above(NODES, NODES, |position, nodes| {
            let smallest = SMALLEST_ALPHA.sqrt();
            sheen::albedos((smallest + (1.0 - smallest) * position.sqrt()).powi(2), nodes)
        })
    })
}
