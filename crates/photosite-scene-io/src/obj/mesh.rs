//! Meshes from faces: one for each material of each object.

use std::collections::{BTreeMap, HashMap};

use glam::{DVec3, Vec2, Vec3};

use super::colours::of_vertex;
use super::geometry::{Corner, Face, Geometry};
use crate::mesh::MissingNormals;
use crate::polygon::triangulate;
use photosite_transport::scene::description::MeshDescription;

/// Makes the meshes. Their materials are indices into [`Geometry::materials`], or its length for faces without one.
pub(super) fn meshes(geometry: &Geometry, missing: MissingNormals) -> Vec<MeshDescription> {
    let mut groups: BTreeMap<(usize, usize), Vec<&Face>> = BTreeMap::new();
    for face in &geometry.faces {
        let material = face.material.unwrap_or(geometry.materials.len());
        groups.entry((face.object, material)).or_default().push(face);
    }
    let normals = GroupNormals::new(geometry, missing);
    groups.into_iter().map(|((object, material), faces)| build(geometry, object, material, &faces, &normals)).collect()
}

fn build(
    geometry: &Geometry,
    object: usize,
    material: usize,
    faces: &[&Face],
    group_normals: &GroupNormals,
) -> MeshDescription {
    let corners = || faces.iter().flat_map(|face| geometry.corners_of(face));
    let has_uvs = corners().any(|corner| corner.uv.is_some());
    let has_normals = corners().any(|c| c.normal.is_some()) || faces.iter().any(|f| group_normals.group(f) != 0);
    let mut mesh = MeshDescription {
        name: mesh_name(geometry, object, material),
        material,
        uvs: if has_uvs { vec![Vec::new()] } else { Vec::new() },
        ..MeshDescription::default()
    };
    let colour_of = |corner: &Corner| geometry.colours.get(corner.position as usize).copied().flatten();
    let has_colours = corners().any(|corner| colour_of(corner).is_some());
    let mut vertices: HashMap<(Corner, [u32; 3]), u32> = HashMap::new();
    let (mut polygon, mut indices) = (Vec::new(), Vec::new());
    for face in faces {
        let corners = geometry.corners_of(face);
        polygon.clear();
        polygon.extend(corners.iter().map(|corner| geometry.positions[corner.position as usize]));
        let flat = polygon_normal(&polygon).as_vec3();
        indices.clear();
        for (&corner, &position) in corners.iter().zip(&polygon) {
            let normal = match corner.normal {
                _ if !has_normals => Vec3::ZERO,
                Some(normal) => geometry.normals[normal as usize],
                None => group_normals.at(face, corner.position).unwrap_or(flat),
            };
            let index = *vertices.entry((corner, normal.to_array().map(f32::to_bits))).or_insert_with(|| {
                mesh.positions.push(position);
                if has_colours {
                    mesh.colours.push(of_vertex(colour_of(&corner)));
                }
                if has_normals {
                    mesh.normals.push(normal);
                }
                for uvs in &mut mesh.uvs {
                    uvs.push(corner.uv.map_or(Vec2::ZERO, |uv| geometry.uvs[uv as usize]));
                }
                mesh.positions.len() as u32 - 1
            });
            indices.push(index);
        }
        triangulate(&polygon, |triangle| mesh.triangles.push(triangle.map(|i| indices[i])));
    }
    mesh
}

/// The object's name, the material's, or both, for messages.
fn mesh_name(geometry: &Geometry, object: usize, material: usize) -> String {
    let names = [Some(&geometry.objects[object]), geometry.materials.get(material)];
    let names: Vec<&str> = names.into_iter().flatten().map(String::as_str).filter(|name| !name.is_empty()).collect();
    if names.is_empty() { "mesh".to_owned() } else { names.join("/") }
}

/// Smooth normals of faces without normals in the file.
struct GroupNormals {
    missing: MissingNormals,
    /// Sum of the normals around each (smoothing group, position), weighted by their angles as in
    /// [`smooth_normals`](crate::mesh::smooth_normals).
    sums: HashMap<(u32, u32), DVec3>,
}

impl GroupNormals {
    fn new(geometry: &Geometry, missing: MissingNormals) -> Self {
        let mut normals = Self { missing, sums: HashMap::new() };
        for face in &geometry.faces {
            let corners = geometry.corners_of(face);
            let group = normals.group(face);
            if group == 0 || corners.iter().all(|corner| corner.normal.is_some()) {
                continue;
            }
            let polygon: Vec<Vec3> = corners.iter().map(|c| geometry.positions[c.position as usize]).collect();
            let normal = polygon_normal(&polygon);
            let n = corners.len();
            for (i, corner) in corners.iter().enumerate() {
                let [last, here, next] = [i + n - 1, i, i + 1].map(|i| polygon[i % n].as_dvec3());
                let angle = (next - here).angle_between(last - here);
                if angle.is_finite() {
                    *normals.sums.entry((group, corner.position)).or_default() += normal * angle;
                }
            }
        }
        normals
    }

    /// Smoothing group in effect; 0 for none.
    fn group(&self, face: &Face) -> u32 {
        match self.missing {
            MissingNormals::Flat => face.smoothing_group,
            MissingNormals::Smooth => 1,
        }
    }

    fn at(&self, face: &Face, position: u32) -> Option<Vec3> {
        self.sums.get(&(self.group(face), position))?.try_normalize().map(DVec3::as_vec3)
    }
}

/// Unit normal of a polygon, zero if it has no area.
fn polygon_normal(corners: &[Vec3]) -> DVec3 {
    let Some(origin) = corners.first().map(|c| c.as_dvec3()) else { return DVec3::ZERO };
    let edges = corners.windows(2);
    let sum: DVec3 = edges.map(|edge| (edge[0].as_dvec3() - origin).cross(edge[1].as_dvec3() - origin)).sum();
    sum.normalize_or_zero()
}
