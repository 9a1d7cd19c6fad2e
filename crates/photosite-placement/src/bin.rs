//! A bin: a box that is open above.

use std::sync::Arc;

use glam::DVec3;
use photosite_core::Invalid;

use crate::pose::Pose;
use crate::request::{Fixed, Region};
use crate::shape::Shape;

/// A box that is open above, with walls and a floor outside of its inner size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Inner width, height and depth, m.
    pub size: DVec3,
    /// Middle of the floor, inside, m.
    pub position: DVec3,
    /// Thickness of walls and floor, m.
    pub wall: f64,
}

/// Triangles of a cuboid, facing outwards; the bits of a corner's number are x, y, z.
const CUBOID: [[u32; 3]; 12] = [
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
];

/// Corners of a cuboid in the order of their numbers.
fn corners(low: DVec3, high: DVec3) -> Vec<DVec3> {
    let corner =
        |i: u32| DVec3::from_array([0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] }));
    (0..8).map(corner).collect()
}

/// Corners and triangles of a cuboid.
pub fn cuboid(low: DVec3, high: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    (corners(low, high), CUBOID.to_vec())
}

impl Bin {
    /// Colliders of the bin: floor and walls, each a cuboid.
    pub fn fixed(&self) -> Result<Vec<Fixed>, Invalid> {
        self.check()?;
        let (low, high) = self.inner();
        let w = self.wall;
        let floor = (low - DVec3::new(w, w, w), DVec3::new(high.x + w, low.y, high.z + w));
        let walls = [
            (DVec3::new(low.x - w, low.y, low.z - w), DVec3::new(low.x, high.y, high.z + w)),
            (DVec3::new(high.x, low.y, low.z - w), DVec3::new(high.x + w, high.y, high.z + w)),
            (DVec3::new(low.x, low.y, low.z - w), DVec3::new(high.x, high.y, low.z)),
            (DVec3::new(low.x, low.y, high.z), DVec3::new(high.x, high.y, high.z + w)),
        ];
        let fixed = |(low, high)| {
            let (positions, triangles) = cuboid(low, high);
            let shape = Arc::new(Shape::new(&positions, &triangles)?);
            Ok(Fixed { shape, scale: 1.0, pose: Pose::IDENTITY })
        };
        std::iter::once(floor).chain(walls).map(fixed).collect()
    }

    /// Visible mesh, closed.
    pub fn mesh(&self) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let (low, high) = self.inner();
        let out = DVec3::new(self.wall, 0.0, self.wall);
        let mut positions = corners(low - out - DVec3::Y * self.wall, high + out);
        positions.extend(corners(low, high));
        let is_top = |t: &&[u32; 3]| t.iter().all(|v| v >> 1 & 1 == 1);
        let mut triangles: Vec<[u32; 3]> = CUBOID.iter().filter(|t| !is_top(t)).copied().collect();
        triangles.extend(CUBOID.iter().filter(|t| !is_top(t)).map(|&[a, b, c]| [a + 8, c + 8, b + 8]));
        // The rim, along the four edges above.
        for (a, b) in [(2, 6), (6, 7), (7, 3), (3, 2)] {
            triangles.extend([[a, b, b + 8], [a, b + 8, a + 8]]);
        }
        (positions, triangles)
    }

    /// Region inside the bin and above it, in which objects must come to rest.
    pub fn inside(&self) -> Region {
        let (low, high) = self.inner();
        Region { min: low, max: DVec3::new(high.x, f64::INFINITY, high.z) }
    }

    /// Region inside the bin, in which objects start.
    pub fn region(&self) -> Region {
        let (min, max) = self.inner();
        Region { min, max }
    }

    fn inner(&self) -> (DVec3, DVec3) {
        let half = DVec3::new(self.size.x / 2.0, 0.0, self.size.z / 2.0);
        (self.position - half, self.position + half + DVec3::Y * self.size.y)
    }

    fn check(&self) -> Result<(), Invalid> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        if !self.size.to_array().into_iter().all(positive) {
            return Err(Invalid::new("size_m", format!("must be three numbers above 0, got {}", self.size)));
        }
        if !positive(self.wall) {
            return Err(Invalid::new("wall_m", format!("must be above 0, got {}", self.wall)));
        }
        if !self.position.is_finite() {
            return Err(Invalid::new("position_m", "must be three numbers"));
        }
        Ok(())
    }
}
