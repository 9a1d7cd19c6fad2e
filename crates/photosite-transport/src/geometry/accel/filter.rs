//! Filters that decide which of the primitives that a ray meets are there.

use crate::geometry::{Primitive, Ray};

/// Decides whether a primitive that a ray meets is there at that point: alpha masks.
pub trait HitFilter {
    /// Whether the filter accepts every hit.
    const ACCEPTS_ALL: bool = false;

    /// Whether the filter accepts the hit.
    fn accept(&self, primitive: Primitive, uv: [f32; 2], ray: &Ray) -> bool;
}

/// The filter that accepts every hit.
#[derive(Clone, Copy, Debug)]
pub struct AcceptAll;

impl HitFilter for AcceptAll {
    const ACCEPTS_ALL: bool = true;

    #[inline(always)]
    fn accept(&self, _: Primitive, _: [f32; 2], _: &Ray) -> bool {
        true
    }
}
