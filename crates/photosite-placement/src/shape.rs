//! Shapes of rigid objects, with the derived data that placement needs.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use parry3d_f64::mass_properties::MassProperties;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::TriMesh;
use photosite_core::Invalid;

use crate::hull::{HALF_SHEET_M, Hull, volume};
use crate::parts::parts;
use crate::pose::{point, vector};
use crate::resting::{RestingPose, resting_poses};

/// Shape of a rigid object: triangles in metres, +Y up, before scale and pose.
#[derive(Debug)]
pub struct Shape {
    /// Triangles, as given except for those without area.
    pub(crate) mesh: Arc<TriMesh>,
    /// Whether the triangles enclose a volume.
    pub(crate) is_closed: bool,
    /// One point of each connected piece.
    pub(crate) pieces: Vec<DVec3>,
    /// Convex hull; for flat shapes, one as thick as a foil.
    pub(crate) hull: Hull,
    /// Mass, centre and inertia at a density of 1 kg/m³.
    pub(crate) mass: MassProperties,
    parts: OnceLock<Vec<Hull>>,
    resting: OnceLock<Vec<RestingPose>>,
}

impl Shape {
    /// The shape of a mesh. The mesh need not be closed or in one piece; without a closed mesh, mass and centre are
    /// those of the convex hull.
    pub fn new(positions: &[DVec3], triangles: &[[u32; 3]]) -> Result<Self, Invalid> {
        if let Some(i) = positions.iter().position(|p| !p.is_finite()) {
            return Err(Invalid::new("", format!("position {i} of the mesh is not finite")));
        }
        let count = positions.len();
        if let Some(i) = triangles.iter().position(|t| t.iter().any(|&v| v as usize >= count)) {
            return Err(Invalid::new("", format!("triangle {i} of the mesh names a vertex beyond its {count}")));
        }
        let (points, mut triangles) = joined(positions, triangles);
        if triangles.is_empty() {
            let help = "only meshes with triangles that have an area can be placed";
            return Err(Invalid::new("", "the mesh has no surface").help(help));
        }
        let is_closed = is_closed(&triangles);
        if is_closed && volume(&points, &triangles) < 0.0 {
            // Inside out.
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let hull = Hull::around(&points, &triangles)?;
        let is_solid = is_closed && volume(&points, &triangles) > 1e-3 * volume(&hull.points, &hull.triangles);
        let mass = if is_solid {
            MassProperties::from_trimesh(1.0, &points, &triangles)
        } else {
            MassProperties::from_trimesh(1.0, &hull.points, &hull.triangles)
        };
        let pieces = pieces(&points, &triangles);
        let mesh = TriMesh::new(points, triangles)
            .map_err(|error| Invalid::new("", format!("the mesh cannot be used: {error}")))?;
        Ok(Self {
            mesh: Arc::new(mesh),
            is_closed: is_solid,
            pieces,
            hull,
            mass,
            parts: OnceLock::new(),
            resting: OnceLock::new(),
        })
    }

    /// Resting poses on a plane, the most probable first.
    pub fn resting_poses(&self) -> &[RestingPose] {
        self.resting.get_or_init(|| resting_poses(&self.hull, self.centre_of_mass()))
    }

    /// Centre of mass, m.
    pub fn centre_of_mass(&self) -> DVec3 {
        point(self.mass.local_com)
    }

    /// Longest side of the bounding box along the shape's own axes, m.
    pub fn longest_side(&self) -> f64 {
        let corners = |fold: fn(DVec3, DVec3) -> DVec3| self.hull.points.iter().map(|p| point(*p)).reduce(fold);
        let (low, high) = (corners(DVec3::min), corners(DVec3::max));
        low.zip(high).map_or(0.0, |(low, high)| (high - low).max_element())
    }

    /// Distance of the farthest point from the centre of mass, m.
    pub fn radius(&self) -> f64 {
        let centre = self.centre_of_mass();
        self.hull.points.iter().map(|p| point(*p).distance(centre)).fold(0.0, f64::max)
    }

    /// Convex solids that together contain the mesh.
    pub(crate) fn parts(&self) -> &[Hull] {
        self.parts
            .get_or_init(|| if self.is_convex() { vec![self.hull.clone()] } else { parts(&self.mesh, &self.hull) })
    }

    /// Whether the shape equals its convex hull.
    pub(crate) fn is_convex(&self) -> bool {
        let hull = volume(&self.hull.points, &self.hull.triangles);
        let is_flat = hull <= 4.0 * HALF_SHEET_M * self.area();
        let own = volume(self.mesh.vertices(), self.mesh.indices());
        is_flat || self.is_closed && hull - own <= 1e-6 * hull
    }

    fn area(&self) -> f64 {
        self.mesh.triangles().map(|t| t.area()).sum()
    }
}

/// Mesh with one vertex for each place, and without triangles that have no area.
fn joined(positions: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<Vector>, Vec<[u32; 3]>) {
    let mut numbers: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let mut points = Vec::new();
    let mut number = |i: u32| {
        // −0 is 0.
        let p = positions[i as usize] + DVec3::ZERO;
        *numbers.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
            points.push(vector(p));
            points.len() as u32 - 1
        })
    };
    let triangles: Vec<[u32; 3]> = triangles
        .iter()
        .filter(|t| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            (b - a).cross(c - a).length_squared() > 0.0
        })
        .map(|t| t.map(&mut number))
        .collect();
    (points, triangles)
}

/// Whether every edge occurs once in each direction.
fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let mut edges: Vec<(u32, u32)> = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    edges.sort_unstable();
    let is_once = edges.windows(2).all(|pair| pair[0] != pair[1]);
    is_once && edges.iter().all(|&(a, b)| edges.binary_search(&(b, a)).is_ok())
}

/// One point of each connected piece of a mesh.
fn pieces(points: &[Vector], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut leader: Vec<u32> = (0..points.len() as u32).collect();
    fn find(leader: &mut [u32], mut i: u32) -> u32 {
        while leader[i as usize] != i {
            leader[i as usize] = leader[leader[i as usize] as usize];
            i = leader[i as usize];
        }
        i
    }
    for &[a, b, c] in triangles {
        for (a, b) in [(a, b), (b, c)] {
            let (a, b) = (find(&mut leader, a), find(&mut leader, b));
            leader[a.max(b) as usize] = a.min(b);
        }
    }
    (0..points.len()).filter(|&i| leader[i] == i as u32).map(|i| point(points[i])).collect()
}
