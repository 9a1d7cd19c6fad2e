//! Checks of every mesh, whatever file it came from: values are finite, triangles of zero area and unused vertices are
//! dropped, normals are made unit vectors.

use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

use glam::{DVec3, Vec3, Vec4};

use photosite_core::Invalid;
use photosite_transport::scene::description::{MeshDescription, ShapeDescription};

/// Shading of faces without normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum MissingNormals {
    /// Flat shading.
    // Except within the smoothing groups (`s`) of an OBJ file.
    #[default]
    Flat,
    /// One normal per vertex, smooth over everything.
    Smooth,
}

/// Counts of what [`checked`] mended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Mended {
    /// Triangles of zero area that were dropped.
    pub(crate) zero_area: usize,
    /// Normals of zero length that were computed from the triangles around them.
    pub(crate) normals: usize,
}

/// Checks a mesh and mends harmless faults of real files. Its lists must have equal lengths. An error's key is that of
/// the attribute at fault, as glTF calls it.
pub(crate) fn checked(mut mesh: MeshDescription) -> Result<(MeshDescription, Mended), Invalid> {
    let shapes = || mesh.later_shapes.iter();
    for positions in shapes().map(|s| &s.positions).chain([&mesh.positions]) {
        all_finite("POSITION", positions, |p| p.is_finite())?;
    }
    for normals in shapes().map(|s| &s.normals).chain([&mesh.normals]) {
        all_finite("NORMAL", normals, |n| n.is_finite())?;
    }
    all_finite("TANGENT", &mesh.tangents, |t| t.is_finite())?;
    for (set, uvs) in mesh.uvs.iter().enumerate() {
        all_finite(&format!("TEXCOORD_{set}"), uvs, |uv| uv.is_finite())?;
    }
    all_finite("COLOR_0", &mesh.colours, |c| c.is_finite())?;
    let vertices = mesh.positions.len();
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        if let Some(corner) = triangle.iter().find(|&&corner| corner as usize >= vertices) {
            let message = format!("triangle {i} uses vertex {corner}, but there are {vertices} (counted from 0)");
            let help =
                "the file is damaged, or was put together from parts that do not belong together; export it again";
            return Err(Invalid::new("indices", message).help(help));
        }
    }
    let triangles = mesh.triangles.len();
    let positions = &mesh.positions;
    mesh.triangles.retain(|triangle| area_vector(positions, triangle) != DVec3::ZERO);
    let zero_area = triangles - mesh.triangles.len();
    drop_unused_vertices(&mut mesh);
    let normals = mend_normals(&mut mesh);
    mend_tangents(&mut mesh);
    Ok((mesh, Mended { zero_area, normals }))
}

fn all_finite<T: std::fmt::Display>(key: &str, values: &[T], is_finite: impl Fn(&T) -> bool) -> Result<(), Invalid> {
    match values.iter().position(|v| !is_finite(v)) {
        Some(i) => Err(Invalid::new(key, format!("vertex {i} is not finite: {}", values[i])).help(
            "the file is damaged, or the program that wrote it divided by zero; fix the vertex and export again",
        )),
        None => Ok(()),
    }
}

/// Doubled area times the unit normal, computed in f64, where the differences of neighbouring f32 are exact and their
/// products neither vanish nor overflow.
pub(crate) fn area_vector(positions: &[Vec3], triangle: &[u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|corner| positions[corner as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Drops vertices that no triangle uses, and keeps the order of the others. Primitives of glTF may share one list of
/// vertices, of which each uses a part; bounds by vertices would include the others.
fn drop_unused_vertices(mesh: &mut MeshDescription) {
    let mut is_used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&corner| is_used[corner as usize] = true);
    if !is_used.contains(&false) {
        return;
    }
    let before = is_used.iter().scan(0u32, |count, &is_used| {
        *count += u32::from(is_used);
        Some(*count - u32::from(is_used))
    });
    let places: Vec<u32> = before.collect();
    mesh.triangles.iter_mut().flatten().for_each(|corner| *corner = places[*corner as usize]);
    let MeshDescription { positions, normals, tangents, uvs, colours, later_shapes, .. } = mesh;
    keep(positions, &is_used);
    keep(normals, &is_used);
    keep(tangents, &is_used);
    keep(colours, &is_used);
    uvs.iter_mut().for_each(|uvs| keep(uvs, &is_used));
    for shape in later_shapes {
        keep(&mut shape.positions, &is_used);
        keep(&mut shape.normals, &is_used);
    }
}

/// Keeps the values of vertices that are used, if there are any values.
fn keep<T>(values: &mut Vec<T>, is_used: &[bool]) {
    let mut used = is_used.iter();
    values.retain(|_| used.next().is_none_or(|&is_used| is_used));
    values.shrink_to_fit();
}

/// Gives normals unit length; those without a direction get that of the triangles around them. Returns how many.
fn mend_normals(mesh: &mut MeshDescription) -> usize {
    let MeshDescription { positions, normals, triangles, later_shapes, .. } = mesh;
    for shape in later_shapes {
        mend_normals_of(&shape.positions, &mut shape.normals, triangles);
    }
    mend_normals_of(positions, normals, triangles)
}

fn mend_normals_of(positions: &[Vec3], normals: &mut [Vec3], triangles: &[[u32; 3]]) -> usize {
    let mut missing = Vec::new();
    for (i, normal) in normals.iter_mut().enumerate() {
        match unit(*normal) {
            Some(n) => *normal = n,
            None => missing.push(i),
        }
    }
    if !missing.is_empty() {
        let smooth = smooth_normals(positions, triangles);
        for &i in &missing {
            normals[i] = smooth[i];
        }
    }
    missing.len()
}

/// Makes tangents perpendicular unit vectors; where a single one has no direction, all are left out, to be generated.
fn mend_tangents(mesh: &mut MeshDescription) {
    if mesh.normals.is_empty() {
        mesh.tangents.clear();
    }
    for (tangent, &normal) in mesh.tangents.iter_mut().zip(&mesh.normals) {
        let t = tangent.truncate();
        match unit(t - normal * normal.dot(t)) {
            Some(t) if tangent.w != 0.0 => *tangent = t.extend(tangent.w.signum()),
            Some(_) | None => {
                mesh.tangents = Vec::new();
                return;
            }
        }
    }
}

/// The unit vector, robustly: lengths whose square leaves the range of f32 are no obstacle.
fn unit(v: Vec3) -> Option<Vec3> {
    v.as_dvec3().try_normalize().map(DVec3::as_vec3)
}

/// Normals at the vertices, averaged over the triangles around each, weighted by their angle there
/// ([Thürmer98](photosite_core::references#thuermer98)): the result does not depend on how polygons were cut into
/// triangles. A vertex without triangles gets +Y.
pub(crate) fn smooth_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let Some(normal) = area_vector(positions, triangle).try_normalize() else { continue };
        let corners = triangle.map(|corner| positions[corner as usize].as_dvec3());
        for i in 0..3 {
            let (to_next, to_last) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
            sums[triangle[i] as usize] += normal * to_next.angle_between(to_last);
        }
    }
    sums.into_iter().map(|sum| sum.try_normalize().map_or(Vec3::Y, DVec3::as_vec3)).collect()
}

/// Smooth normals over positions that several vertices share, as they do at the seams of a UV map.
pub(crate) fn seamless_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::new();
    let places: Vec<u32> = (0..).zip(positions).map(|(i, &p)| *first.entry(place(p)).or_insert(i)).collect();
    let joined: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|corner| places[corner as usize])).collect();
    let normals = smooth_normals(positions, &joined);
    places.iter().map(|&place| normals[place as usize]).collect()
}

/// Hash key of a position; 0 and −0 are the same.
pub(crate) fn place(position: Vec3) -> [u32; 3] {
    (position + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// Gives every triangle its own corners with the geometric normal, so that the mesh is flat-shaded with explicit
/// normals.
pub(crate) fn flatten(mesh: &MeshDescription) -> MeshDescription {
    let corners: Vec<usize> = mesh.triangles.iter().flatten().map(|&corner| corner as usize).collect();
    let flat = |positions: &[Vec3]| {
        let normals = mesh.triangles.iter().flat_map(|triangle| {
            let normal = area_vector(positions, triangle).try_normalize().map_or(Vec3::Y, DVec3::as_vec3);
            [normal; 3]
        });
        let positions = corners.iter().map(|&corner| positions[corner]).collect();
        ShapeDescription { positions, normals: normals.collect() }
    };
    let ShapeDescription { positions, normals } = flat(&mesh.positions);
    MeshDescription {
        name: mesh.name.clone(),
        material: mesh.material,
        positions,
        normals,
        later_shapes: mesh.later_shapes.iter().map(|shape| flat(&shape.positions)).collect(),
        tangents: Vec::<Vec4>::new(),
        uvs: mesh.uvs.iter().map(|uvs| corners.iter().map(|&corner| uvs[corner]).collect()).collect(),
        colours: if mesh.colours.is_empty() {
            Vec::new()
        } else {
            corners.iter().map(|&corner| mesh.colours[corner]).collect()
        },
        triangles: (0..mesh.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        quadric: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_triangles() -> MeshDescription {
        MeshDescription {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(2.0, 0.0, 0.0)],
            normals: vec![Vec3::Z * 3.0, Vec3::ZERO, Vec3::Z, Vec3::Z],
            triangles: vec![[0, 1, 2], [0, 1, 3]],
            ..MeshDescription::default()
        }
    }

    #[test]
    fn vertices_that_no_triangle_has_go_in_all_shapes() {
        let far = Vec3::splat(9.0);
        let positions = vec![far, Vec3::ZERO, Vec3::X, far, Vec3::Y];
        let moved: Vec<Vec3> = positions.iter().map(|p| *p + Vec3::Z).collect();
        let shape = ShapeDescription { positions: moved, normals: vec![Vec3::Z; 5] };
        let mesh = MeshDescription {
            normals: vec![Vec3::Z; 5],
            uvs: vec![positions.iter().map(|p| p.truncate()).collect()],
            triangles: vec![[1, 2, 4], [0, 0, 3]],
            later_shapes: vec![shape],
            positions,
            ..MeshDescription::default()
        };
        let (mesh, mended) = checked(mesh).expect("valid");
        assert_eq!(mended, Mended { zero_area: 1, normals: 0 });
        assert_eq!((&mesh.positions[..], &mesh.triangles[..]), (&[Vec3::ZERO, Vec3::X, Vec3::Y][..], &[[0, 1, 2]][..]));
        assert_eq!(mesh.later_shapes[0].positions, [Vec3::Z, Vec3::X + Vec3::Z, Vec3::Y + Vec3::Z]);
        assert_eq!((mesh.normals.len(), mesh.later_shapes[0].normals.len(), mesh.uvs[0][2]), (3, 3, glam::Vec2::Y));
    }

    #[test]
    fn zero_area_triangles_go_and_normals_become_unit_vectors() {
        let (mesh, mended) = checked(two_triangles()).expect("valid");
        assert_eq!(mended, Mended { zero_area: 1, normals: 1 });
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(mesh.normals, [Vec3::Z; 3]);
    }

    #[test]
    fn tiny_and_huge_triangles_are_kept() {
        for size in [1e-30, 1e30] {
            let mut mesh = two_triangles();
            mesh.positions.iter_mut().for_each(|p| *p *= size);
            assert_eq!(checked(mesh).expect("valid").0.triangles.len(), 1, "{size}");
        }
    }

    #[test]
    fn what_is_not_finite_is_refused_with_its_vertex() {
        let mut mesh = two_triangles();
        mesh.positions[2].y = f32::NAN;
        let error = checked(mesh).expect_err("NaN");
        assert_eq!(error.key, "POSITION");
        assert!(error.message.contains("vertex 2"), "{error}");
        let mut mesh = two_triangles();
        mesh.triangles[1][2] = 4;
        assert_eq!(checked(mesh).expect_err("index").key, "indices");
    }

    #[test]
    fn smooth_normals_of_a_cube_corner_do_not_depend_on_the_diagonals() {
        // Three faces of a cube around the origin; the diagonal of the first touches the corner, the others do not.
        let p = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1]];
        let positions: Vec<Vec3> = p.iter().map(|p| Vec3::from_array(p.map(|x| x as f32))).collect();
        let triangles = [[0, 2, 4], [0, 4, 1], [0, 1, 3], [1, 5, 3], [0, 3, 2], [3, 6, 2]];
        let normal = smooth_normals(&positions, &triangles)[0];
        assert!((normal + Vec3::ONE.normalize()).length() < 1e-6, "{normal}");
    }

    #[test]
    fn seams_do_not_show_in_smooth_normals() {
        // A roof whose ridge has its vertices twice.
        let roof =
            [[0., 1., 0.], [-0., 1., 1.], [1., 0., 0.], [0., 1., 0.], [0., 1., 1.], [-1., 0., 1.]].map(Vec3::from);
        let triangles = [[0, 1, 2], [4, 3, 5]];
        assert_eq!(smooth_normals(&roof, &triangles)[..2], [Vec3::new(1.0, 1.0, 0.0).normalize(); 2]);
        let normals = seamless_normals(&roof, &triangles);
        for (ridge, twin) in [(0, 3), (1, 4)] {
            assert_eq!(normals[ridge], normals[twin]);
            assert_eq!(normals[ridge].z, 0.0, "{normals:?}");
        }
    }

    #[test]
    fn a_flattened_mesh_has_the_normals_of_its_triangles() {
        let mut mesh = two_triangles();
        mesh.triangles = vec![[0, 1, 2], [2, 1, 0]];
        let flat = flatten(&mesh);
        assert_eq!(flat.normals, [Vec3::Z, Vec3::Z, Vec3::Z, -Vec3::Z, -Vec3::Z, -Vec3::Z]);
        assert_eq!(flat.positions[3], Vec3::Y);
    }
}
