//! Mesh of a solid, whose corners at the same place are one vertex.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use crate::mesh::{area_vector, place};
use photosite_core::Invalid;

/// Largest memory of a facet with its share of the corners, parsed and kept, bytes.
pub(super) const FACET: u64 = 250;

/// A solid, as far as it has been read.
#[derive(Default)]
pub(super) struct Solid {
    /// Name; empty where the file has none.
    pub(super) name: String,
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Number of facets whose normals point to the back.
    pub(super) contrary: usize,
    vertices: HashMap<[u32; 3], u32>,
}

impl Solid {
    pub(super) fn named(name: String) -> Self {
        Self { name, ..Self::default() }
    }

    /// Adds a facet. A normal without direction is ignored.
    pub(super) fn add(&mut self, normal: Vec3, corners: [Vec3; 3]) -> Result<(), Invalid> {
        if let Some(corner) = corners.iter().find(|corner| !corner.is_finite()) {
            let invalid = Invalid::new("vertex", format!("is not finite: {corner}"));
            return Err(
                invalid.help("the file is damaged, or the program that wrote it divided by zero; export it again")
            );
        }
        let mut triangle = [0; 3];
        for (index, corner) in triangle.iter_mut().zip(corners) {
            let Ok(next) = u32::try_from(self.positions.len()) else {
                let invalid = Invalid::new("", format!("has more than {} vertices", u32::MAX));
                return Err(invalid.help("split the mesh"));
            };
            *index = *self.vertices.entry(place(corner)).or_insert_with(|| {
                self.positions.push(corner);
                next
            });
        }
        // A normal of NaN is not below 0.
        self.contrary += usize::from(area_vector(&self.positions, &triangle).dot(DVec3::from(normal)) < 0.0);
        self.triangles.push(triangle);
        Ok(())
    }

    /// Frees the data that only reading needs.
    pub(super) fn finished(mut self) -> Self {
        self.vertices = HashMap::new();
        self
    }
}
