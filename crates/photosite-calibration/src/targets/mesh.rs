//! A target as triangles.
//!
//! The edges of all shapes become edges of one constrained Delaunay triangulation of the sheet, so that inks meet
//! exactly, without gaps and overlaps; each triangle then has the ink of the last shape that holds its middle.

use std::collections::HashMap;

use glam::{DVec2, Vec2, Vec3};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::Target;
use photosite_transport::scene::description::{
    Colour, Diffuse, MaterialDescription, MaterialModel, MeshDescription, TexturedColour,
};

/// Corners nearer than this become one, m: what is computed twice may differ in its last bits.
const GRID_M: f64 = 1e-9;

impl Target {
    /// A mesh and a matt material for every ink that is seen, both named NAME-INK, in the frame of the target with the
    /// front towards −z. UVs run over the sheet from its top left.
    pub fn meshes(&self, name: &str) -> Vec<(MaterialDescription, MeshDescription)> {
        let Triangles { corners, triangles } = self.triangles();
        let inks = self.inks.iter().enumerate().map(|(index, ink)| {
            let name = format!("{name}-{}", ink.name);
            let reflectance = TexturedColour::plain(Colour::Spectrum(ink.reflectance.clone()));
            let material = MaterialDescription::new(name.clone(), MaterialModel::Diffuse(Diffuse { reflectance }));
            let mut mesh = MeshDescription { name, uvs: vec![Vec::new()], ..MeshDescription::default() };
            let mut places = HashMap::new();
            for (triangle, _) in triangles.iter().filter(|(_, ink)| *ink == index) {
                mesh.triangles.push(triangle.map(|corner| {
                    *places.entry(corner).or_insert_with(|| {
                        let position = corners[corner];
                        let uv: Vec2 = ((position - self.sheet[0]) / self.size_m()).as_vec2();
                        mesh.positions.push(Vec3::new(position.x as f32, position.y as f32, 0.0));
                        mesh.uvs[0].push(uv);
                        (mesh.positions.len() - 1) as u32
                    })
                }));
            }
            (material, mesh)
        });
        inks.filter(|(_, mesh)| !mesh.triangles.is_empty()).collect()
    }

    /// Triangles, clockwise in the image as y points down, with their inks.
    fn triangles(&self) -> Triangles {
        let [low, high] = self.sheet;
        let sheet = vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let shapes: Vec<Vec<DVec2>> = self.shapes.iter().map(|shape| shape.outline.corners()).collect();
        let mut corners: Vec<DVec2> = Vec::new();
        let mut known = HashMap::new();
        let mut edges = Vec::new();
        for outline in std::iter::once(&sheet).chain(&shapes) {
            let indices: Vec<usize> = outline
                .iter()
                .map(|corner| {
                    let key = [corner.x, corner.y].map(|x| (x / GRID_M).round() as i64);
                    *known.entry(key).or_insert_with(|| {
                        corners.push(DVec2::new(key[0] as f64, key[1] as f64));
                        corners.len() - 1
                    })
                })
                .collect();
            let next = indices.iter().cycle().skip(1);
            edges.extend(indices.iter().zip(next).filter(|(a, b)| a != b).map(|(a, b)| [*a, *b]));
        }
        let points = corners.iter().map(|corner| Point2::new(corner.x, corner.y)).collect();
        let net = ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(points, edges);
        let net = net.expect("sizes are limited and outlines do not cross");
        let corners: Vec<DVec2> =
            net.vertices().map(|vertex| DVec2::new(vertex.position().x, vertex.position().y) * GRID_M).collect();
        let index = ShapeIndex::new(self.sheet, &shapes);
        let triangles = net.inner_faces().map(|face| {
            let [a, b, c] = face.vertices().map(|vertex| vertex.fix().index());
            let middle = (corners[a] + corners[b] + corners[c]) / 3.0;
            // Counter-clockwise where y points up is clockwise in the image; the front is towards −z.
            ([a, c, b], index.topmost(&shapes, middle).map_or(0, |shape| self.shapes[shape].ink))
        });
        let triangles = triangles.collect();
        Triangles { corners, triangles }
    }
}

struct Triangles {
    corners: Vec<DVec2>,
    triangles: Vec<([usize; 3], usize)>,
}

/// Which shapes come near which part of the sheet.
struct ShapeIndex {
    low: DVec2,
    cell: DVec2,
    cells: usize,
    /// Shapes whose boxes meet a cell, in order, row by row.
    lists: Vec<Vec<usize>>,
}

impl ShapeIndex {
    fn new([low, high]: [DVec2; 2], shapes: &[Vec<DVec2>]) -> Self {
        // A few shapes a cell.
        let cells = ((shapes.len() as f64).sqrt() as usize).clamp(1, 256);
        let cell = (high - low) / cells as f64;
        let mut index = Self { low, cell, cells, lists: vec![Vec::new(); cells * cells] };
        for (number, shape) in shapes.iter().enumerate() {
            let from = index.place(shape.iter().copied().fold(DVec2::INFINITY, DVec2::min));
            let to = index.place(shape.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max));
            for row in from[1]..=to[1] {
                for column in from[0]..=to[0] {
                    index.lists[row * cells + column].push(number);
                }
            }
        }
        index
    }

    fn place(&self, point: DVec2) -> [usize; 2] {
        let place = ((point - self.low) / self.cell).floor();
        [place.x, place.y].map(|i| (i.max(0.0) as usize).min(self.cells - 1))
    }

    /// The last shape that holds a point.
    fn topmost(&self, shapes: &[Vec<DVec2>], point: DVec2) -> Option<usize> {
        let [column, row] = self.place(point);
        self.lists[row * self.cells + column].iter().copied().rev().find(|&shape| holds(&shapes[shape], point))
    }
}

/// Whether a polygon holds a point: a ray from there crosses it an odd number of times.
fn holds(corners: &[DVec2], point: DVec2) -> bool {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let crossed = edges.filter(|(a, b)| {
        (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossed.count() % 2 == 1
}
