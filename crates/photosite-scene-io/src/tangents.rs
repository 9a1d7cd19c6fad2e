//! Generation of tangents where a normal map needs them and the file has none, by MikkTSpace
//! ([Mikkelsen08](photosite_core::references#mikkelsen08)), which normal maps are baked for and glTF 2.0 (§3.7.2.1)
//! names as the default.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};

use photosite_transport::scene::description::{MeshDescription, ShapeDescription};
use photosite_transport::texture::UvTransform;

/// Gives a mesh tangents along the u axis of a UV set, w the handedness. The mesh must have normals and that UV set.
/// Vertices whose triangles disagree on the tangent, as at the seam of a mirrored texture, are split.
pub(crate) fn with_tangents(mesh: &MeshDescription, uv_set: usize, transform: &UvTransform) -> MeshDescription {
    let mut surface = Surface {
        mesh,
        uvs: mesh.uvs[uv_set].iter().map(|&uv| turned(uv, transform)).collect(),
        corners: vec![[Vec4::ZERO; 3]; mesh.triangles.len()],
    };
    // It fails only where nothing could be written at all, and then every corner gets a tangent of its own below.
    let _ = generate_tangents(&mut surface);
    split(mesh, &surface.corners)
}

/// Direction of a UV: rotated and scaled, but not moved.
fn turned(uv: Vec2, transform: &UvTransform) -> Vec2 {
    let (sin, cos) = transform.rotation_rad.sin_cos();
    let scaled = uv * transform.scale;
    Vec2::new(cos * scaled.x + sin * scaled.y, -sin * scaled.x + cos * scaled.y)
}

/// A mesh in the interface of MikkTSpace.
struct Surface<'a> {
    mesh: &'a MeshDescription,
    uvs: Vec<Vec2>,
    /// Tangents of the corners of each triangle; zero where there is none yet.
    corners: Vec<[Vec4; 3]>,
}

impl Surface<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry for Surface<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, corner)].to_array()
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        if let Some(tangent) = tangent {
            self.corners[face][corner] = Vec4::from_array(tangent.tangent_encoded());
        }
    }
}

/// A mesh whose vertices have one tangent each.
fn split(mesh: &MeshDescription, corners: &[[Vec4; 3]]) -> MeshDescription {
    let mut result = MeshDescription {
        name: mesh.name.clone(),
        material: mesh.material,
        uvs: vec![Vec::new(); mesh.uvs.len()],
        ..MeshDescription::default()
    };
    let mut sources = Vec::new();
    let mut known: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    for (triangle, tangents) in mesh.triangles.iter().zip(corners) {
        let mut split = [0; 3];
        for i in 0..3 {
            let vertex = triangle[i] as usize;
            let tangent = orthonormal(tangents[i], mesh.normals[vertex]);
            let key = (triangle[i], tangent.to_array().map(f32::to_bits));
            split[i] = *known.entry(key).or_insert_with(|| {
                sources.push(vertex);
                result.positions.push(mesh.positions[vertex]);
                result.normals.push(mesh.normals[vertex]);
                result.tangents.push(tangent);
                for (set, uvs) in result.uvs.iter_mut().enumerate() {
                    uvs.push(mesh.uvs[set][vertex]);
                }
                if let Some(&colour) = mesh.colours.get(vertex) {
                    result.colours.push(colour);
                }
                result.positions.len() as u32 - 1
            });
        }
        result.triangles.push(split);
    }
    let all = |values: &[Vec3]| sources.iter().filter_map(|&vertex| values.get(vertex)).copied().collect();
    let shape =
        |shape: &ShapeDescription| ShapeDescription { positions: all(&shape.positions), normals: all(&shape.normals) };
    result.later_shapes = mesh.later_shapes.iter().map(shape).collect();
    result
}

/// Tangent perpendicular to the normal; an arbitrary perpendicular one where there is none.
fn orthonormal(tangent: Vec4, normal: Vec3) -> Vec4 {
    let t = tangent.truncate();
    let t = (t - normal * normal.dot(t)).try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
    // glTF's bitangent points up the image while v grows downwards.
    t.extend(if tangent.w > 0.0 { -1.0 } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square in the xy plane facing +z, u to the right; v runs down as in an image.
    fn square() -> MeshDescription {
        MeshDescription {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            normals: vec![Vec3::Z; 4],
            uvs: vec![vec![Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshDescription::default()
        }
    }

    #[test]
    fn an_upright_image_has_its_tangent_to_the_right_and_its_bitangent_up() {
        let mesh = with_tangents(&square(), 0, &UvTransform::default());
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 2));
        for (tangent, normal) in mesh.tangents.iter().zip(&mesh.normals) {
            assert!((tangent.truncate() - Vec3::X).length() < 1e-6, "{tangent}");
            // glTF §3.7.2.1: bitangent = cross(normal, tangent) · w.
            assert!((normal.cross(tangent.truncate()) * tangent.w - Vec3::Y).length() < 1e-6, "{tangent}");
        }
    }

    #[test]
    fn a_mirrored_image_is_left_handed_and_a_turned_one_turns_its_tangent() {
        let mut mirrored = square();
        mirrored.uvs[0].iter_mut().for_each(|uv| uv.x = 1.0 - uv.x);
        let mesh = with_tangents(&mirrored, 0, &UvTransform::default());
        assert!(
            mesh.tangents.iter().all(|t| (*t - Vec4::new(-1.0, 0.0, 0.0, -1.0)).length() < 1e-6),
            "{:?}",
            mesh.tangents
        );
        // Rotating UVs by 90°: u' = v, which grows towards −y.
        let turn = UvTransform { rotation_rad: std::f32::consts::FRAC_PI_2, ..UvTransform::default() };
        let mesh = with_tangents(&square(), 0, &turn);
        assert!(mesh.tangents.iter().all(|t| (t.truncate() + Vec3::Y).length() < 1e-6), "{:?}", mesh.tangents);
    }

    #[test]
    fn without_any_uv_area_tangents_are_still_unit_and_perpendicular() {
        let mut flat = square();
        flat.uvs[0] = vec![Vec2::ZERO; 4];
        for (tangent, normal) in with_tangents(&flat, 0, &UvTransform::default()).tangents.iter().zip(&flat.normals) {
            assert!((tangent.truncate().length() - 1.0).abs() < 1e-6 && tangent.truncate().dot(*normal).abs() < 1e-6);
        }
    }
}
