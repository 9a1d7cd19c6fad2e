//! Counts of rays, and the cost of paths by them.

use std::sync::atomic::{AtomicU64, Ordering};

/// Cost of a ray to a light, in rays to surfaces.
const SHADOW_COST: f64 = 0.6;

/// Counts of the rays that all threads have traced to surfaces and to lights.
#[derive(Default)]
pub(super) struct RayCounts([AtomicU64; 2]);

impl RayCounts {
    /// Adds rays to surfaces and to lights.
    pub(super) fn add(&self, rays: [u64; 2]) {
        self.0.iter().zip(rays).for_each(|(sum, rays)| {
            sum.fetch_add(rays, Ordering::Relaxed);
        });
    }

    /// Cost of these rays and the surfaces that they have led to, in rays to surfaces: constants times rays, so that it
    /// is the same on every machine.
    pub(super) fn cost(&self) -> f64 {
        self.number(0) + SHADOW_COST * self.shadow_rays()
    }

    /// Number of rays to lights, or from paths of lights to the lens.
    pub(super) fn shadow_rays(&self) -> f64 {
        self.number(1)
    }

    fn number(&self, kind: usize) -> f64 {
        self.0[kind].load(Ordering::Relaxed) as f64
    }
}
