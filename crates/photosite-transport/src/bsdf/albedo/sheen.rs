//! The directional albedo of sheen.

use std::sync::OnceLock;

use glam::Vec2;

use super::grid::{Grid, GridRow};
use super::reflection::NODES;
use crate::bsdf::sheen::{self, SMALLEST_ALPHA};

/// The albedo of sheen of one roughness α, for a colour of 1. No interpolation lies below what the lobe gives back.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct SheenRow(GridRow<Vec2>);

/// Albedo of sheen, published and in use, for one direction or on average.
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
    /// Divisor of the published lobe, at least 1.
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

/// Table of both albedos, of the published lobe and of the one in use, at [`position`] and cosine.
pub(super) fn sheen_grid() -> &'static Grid<Vec2> {
    static TABLE: OnceLock<Grid<Vec2>> = OnceLock::new();
    TABLE.get_or_init(|| {
        Grid::from_above(NODES, NODES, |position, nodes| {
            let smallest = SMALLEST_ALPHA.sqrt();
            sheen::albedos((smallest + (1.0 - smallest) * position.sqrt()).powi(2), nodes)
        })
    })
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use glam::Vec3;

    use super::*;

    /// Albedo of the lobe in use, ∫ f/max(1, E(wo), E(wi))·cos θᵢ dωᵢ with the E of the table, by the midpoint rule in
    /// √z and azimuth.
    fn in_use(alpha: f32, row: SheenRow, mu: f32) -> f32 {
        const STEPS: usize = 192;
        let at = |i: usize| (i as f32 + 0.5) / STEPS as f32;
        let direction = |z: f32, turn: f32| {
            let (sin, cos) = (0.5 * TAU * turn).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            Vec3::new(radius * cos, radius * sin, z)
        };
        let own = row.directional(mu).excess();
        let ring = |i: usize| {
            let (z, width) = (at(i) * at(i), 2.0 * at(i) / STEPS as f32);
            let values = (0..STEPS).map(|j| sheen::published(alpha, direction(mu, 0.0), direction(z, at(j))));
            values.sum::<f32>() * z * width / own.max(row.directional(z).excess())
        };
        (0..STEPS).map(ring).sum::<f32>() * TAU / STEPS as f32
    }

    #[test]
    fn the_lobe_gives_back_no_more_than_arrives_nor_than_the_table_says() {
        // The table's own rule is right to 7e-4. A bend of the albedo, where E is 1, lies between the nodes at which the
        // corners are raised: they lack up to a quarter of what they are raised by elsewhere, 0.026.
        const LACKING: f32 = 0.026 / 4.0 + 7e-4;
        for alpha in [0.0f32, 0.01, 0.013, 0.02, 0.037, 0.05, 0.11, 0.3, 0.77, 1.0] {
            let row = SheenRow::of(alpha);
            for mu in [1e-4f32, 7e-4, 0.004, 0.02, 0.05, 0.09, 0.2, 0.5, 0.9] {
                let (found, table) = (in_use(alpha, row, mu), row.directional(mu).albedo());
                assert!(found < table + LACKING, "α {alpha} μ {mu}: {found} is more than {table}");
                assert!(found < 1.0 + 7e-4 && table < 1.0 + 0.026, "α {alpha} μ {mu}: {found}, {table}");
            }
        }
    }
}
