//! Disks, sampled evenly by area.

use std::f32::consts::PI;

use super::{EmitterPoint, EmitterShape};
use crate::geometry::Disk;
use photosite_core::math::{Cone, warp};

impl EmitterShape for Disk {
    #[inline]
    fn area(&self) -> f32 {
        PI * self.radius * self.radius
    }

    #[inline]
    fn sample_area(&self, u: [f32; 2]) -> EmitterPoint {
        let parameters = warp::concentric_disk(u);
        EmitterPoint::of_quadric(self.point(parameters), parameters)
    }

    fn normals(&self) -> Cone {
        Cone::of(self.normal)
    }
}
