//! Objects as models: their own frames without scale, their triangles in them.

use std::fmt::Write;

use glam::DVec3;
use serde_json::{Value, json};

use super::SceneObject;
use photosite_transport::scene::description::{SceneDescription, rigid};

/// Model: the triangles of an object in a frame that is only rotated and translated against the world.
#[derive(Clone, Debug)]
pub(super) struct Model {
    /// Triangles, three corners each, m.
    triangles: Vec<[DVec3; 3]>,
}

impl Model {
    /// Model of an object, whose instances must be those of the scene.
    pub(super) fn new(object: &SceneObject, scene: &SceneDescription) -> Self {
        let from_world = rigid(&object.to_world).inverse();
        let mut triangles = Vec::new();
        for instance in object.instances(scene) {
            let to_model = from_world * instance.to_world;
            for mesh in &scene.meshes[instance.meshes.clone()] {
                let corner = |i: u32| to_model.transform_point3(mesh.positions[i as usize].as_dvec3());
                triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(corner)));
            }
        }
        Self { triangles }
    }

    /// Whether two models are the same within 1 µm.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let near = |(a, b): (&[DVec3; 3], &[DVec3; 3])| (0..3).all(|i| a[i].abs_diff_eq(b[i], 1e-6));
        self.triangles.len() == other.triangles.len() && self.triangles.iter().zip(&other.triangles).all(near)
    }

    fn corners(&self) -> impl Iterator<Item = DVec3> {
        self.triangles.iter().flatten().copied()
    }

    /// Smallest and largest coordinates, m.
    fn bounds(&self) -> [DVec3; 2] {
        let low = self.corners().fold(DVec3::INFINITY, DVec3::min);
        [low, self.corners().fold(DVec3::NEG_INFINITY, DVec3::max)]
    }

    /// Eight corners of a box that encloses the model, m.
    pub(super) fn box_corners(&self) -> [DVec3; 8] {
        let [low, high] = self.bounds();
        std::array::from_fn(|i| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        })
    }

    /// Diameter: the largest distance between any two corners, m.
    fn diameter(&self) -> f64 {
        let corners: Vec<DVec3> = self.corners().collect();
        let middle = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
        let mut by_radius: Vec<(f64, DVec3)> = corners.into_iter().map(|c| (c.distance(middle), c)).collect();
        by_radius.sort_by(|a, b| b.0.total_cmp(&a.0));
        by_radius.dedup();
        let mut largest = 0.0f64;
        for (i, (outer, a)) in by_radius.iter().enumerate() {
            if 2.0 * outer <= largest {
                break;
            }
            for (inner, b) in &by_radius[i + 1..] {
                // No two corners are farther apart than by the way through the middle.
                if outer + inner <= largest {
                    break;
                }
                largest = largest.max(a.distance(*b));
            }
        }
        largest
    }

    /// Entry of the model in `models_info.json`, mm.
    pub(super) fn info(&self) -> Value {
        let [low, high] = self.bounds().map(|corner| corner * 1e3);
        let size = high - low;
        json!({
            "diameter": self.diameter() * 1e3,
            "min_x": low.x, "min_y": low.y, "min_z": low.z,
            "size_x": size.x, "size_y": size.y, "size_z": size.z,
        })
    }

    /// PLY file as text, mm, each triangle with its normal.
    pub(super) fn ply(&self) -> String {
        let (vertices, faces) = (3 * self.triangles.len(), self.triangles.len());
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             property float nx\nproperty float ny\nproperty float nz\nelement face {faces}\n\
             property list uchar int vertex_indices\nend_header\n"
        );
        for [a, b, c] in &self.triangles {
            let normal = (*b - *a).cross(*c - *a).normalize_or_zero().as_vec3();
            for corner in [a, b, c] {
                let p = (*corner * 1e3).as_vec3();
                let _ = writeln!(text, "{} {} {} {} {} {}", p.x, p.y, p.z, normal.x, normal.y, normal.z);
            }
        }
        for first in (0..vertices).step_by(3) {
            let _ = writeln!(text, "3 {first} {} {}", first + 1, first + 2);
        }
        text
    }
}
