//! The elements of a PLY file that make geometry: vertices and faces.

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3, Vec4};

use super::header::{Element, Header, Number};
use super::values::Values;
use crate::mesh::{MissingNormals, seamless_normals};
use crate::polygon::{MOST_CORNERS, triangulate};
use photosite_core::spectrum::rgb;
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, Result, memory};
use photosite_transport::scene::description::MeshDescription;

/// Vertices and polygons of the file, checked to be in range.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// UV coordinates, v downwards as in glTF; in PLY files v grows upwards.
    uvs: Vec<Vec2>,
    colours: Vec<Vec4>,
    /// The corners of all polygons, one after the other.
    corners: Vec<u32>,
    /// UV of the corners, where faces have them.
    corner_uvs: Vec<Vec2>,
    /// Number of corners of each polygon.
    sizes: Vec<u32>,
}

/// Columns of the vertex properties that are used.
struct Columns {
    position: [usize; 3],
    normal: Option<[usize; 3]>,
    uv: Option<[usize; 2]>,
    colour: Option<[usize; 3]>,
    alpha: Option<usize>,
}

impl Columns {
    fn of(vertex: &Element, path: &Path, warnings: &mut Warnings) -> Result<Self> {
        let Some(position) = all_of(vertex, ["x", "y", "z"]) else {
            let invalid = Invalid::new("vertex", "needs the properties x, y and z");
            return Err(invalid.help("export the mesh with its positions").in_file(path));
        };
        let colours = [["red", "green", "blue"], ["r", "g", "b"], ["diffuse_red", "diffuse_green", "diffuse_blue"]];
        let uvs = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["s0", "t0"]];
        let mut colour = colours.into_iter().find_map(|names| all_of(vertex, names));
        let odd = |&column: &usize| encoding(vertex.type_of(column)).is_none();
        if let Some(column) = colour.iter().flatten().find(|column| odd(column)) {
            let name = vertex.type_of(*column).name();
            warnings.once(format!(
                "the colours of the vertices are left out: their type {name} does not define what white is"
            ));
            colour = None;
        }
        let alpha = ["alpha", "a", "diffuse_alpha"].iter().find_map(|name| vertex.number(name));
        Ok(Self {
            position,
            normal: all_of(vertex, ["nx", "ny", "nz"]),
            uv: uvs.into_iter().find_map(|names| all_of(vertex, names)),
            colour,
            alpha: alpha.filter(|alpha| colour.is_some() && !odd(alpha)),
        })
    }

    /// Columns that are used.
    fn all(&self) -> impl Iterator<Item = usize> {
        let Self { position, normal, uv, colour, alpha } = *self;
        let others = normal.into_iter().chain(colour).flatten().chain(uv.into_iter().flatten()).chain(alpha);
        position.into_iter().chain(others)
    }
}

/// Columns of properties, if all are present.
fn all_of<const N: usize>(element: &Element, names: [&str; N]) -> Option<[usize; N]> {
    let found = names.map(|name| element.number(name));
    found.iter().all(Option::is_some).then(|| found.map(Option::unwrap_or_default))
}

/// Value of white, and whether colours are sRGB-encoded; `None` for types that are not used for colours.
fn encoding(number: Number) -> Option<(f64, bool)> {
    match number {
        Number::U8 => Some((255.0, true)),
        Number::U16 => Some((65535.0, true)),
        Number::F32 | Number::F64 => Some((1.0, false)),
        Number::I8 | Number::I16 | Number::I32 | Number::U32 => None,
    }
}

impl Geometry {
    /// Reads all elements of a file.
    pub(super) fn read(bytes: &[u8], header: &Header, path: &Path, warnings: &mut Warnings) -> Result<Self> {
        let vertices = header.element("vertex").map_or(0, |vertex| vertex.count);
        if header.element("face").is_none_or(|face| face.count == 0) {
            return Err(without_faces(header, vertices).in_file(path));
        }
        // Also that of a corner that none has.
        if vertices > u64::from(u32::MAX) {
            let message = format!("has {vertices} vertices, more than {}", u32::MAX);
            return Err(Invalid::new("vertex", message).help("split the mesh").in_file(path));
        }
        let mut geometry = Self::default();
        let mut values = Values::new(bytes, header, path);
        for element in &header.elements {
            values.check(element)?;
            match &*element.name {
                "vertex" => geometry.read_vertices(element, &mut values, path, warnings)?,
                "face" => geometry.read_faces(element, vertices, &mut values, path, warnings)?,
                name => {
                    // Where the scanner stood is no surface.
                    if element.count > 0 && name != "camera" {
                        warnings.once(format!("the element {name:?} is not supported and is left out"));
                    }
                    values.skip(element)?;
                }
            }
        }
        match values.left_over() {
            0 => {}
            bytes => warnings.once(format!("{bytes} bytes behind the last element are left out")),
        }
        Ok(geometry)
    }

    fn read_vertices(
        &mut self,
        vertex: &Element,
        values: &mut Values<'_>,
        path: &Path,
        warnings: &mut Warnings,
    ) -> Result<()> {
        let columns = Columns::of(vertex, path, warnings)?;
        let Columns { position, normal, uv, colour, alpha } = columns;
        let count = vertex.count as usize;
        let sizes = [(true, 12), (normal.is_some(), 12), (uv.is_some(), 8), (colour.is_some(), 16)];
        let size: u64 = sizes.iter().map(|(is_there, size)| if *is_there { *size } else { 0 }).sum();
        memory::check(vertex.count * size, &format!("its {count} vertices"), "simplify the mesh")
            .map_err(|invalid| invalid.in_file(path))?;
        self.positions.reserve_exact(count);
        let mut row = Vec::new();
        let mut beyond = false;
        for i in 0..vertex.count {
            values.row(vertex, i, &mut row, &mut |_, _| {})?;
            let single = |column: usize| row[column] as f32;
            if let Some(column) = columns.all().find(|&column| !single(column).is_finite()) {
                let name = &vertex.properties[column].name;
                return Err(values.fault(vertex, i, format!("{name} is not finite: {}", row[column])));
            }
            self.positions.push(position.map(single).into());
            self.normals.extend(normal.map(|normal| Vec3::from(normal.map(single))));
            self.uvs.extend(uv.map(|uv| upright(uv.map(single))));
            let channel = |column: usize| {
                let (white, is_encoded) = encoding(vertex.type_of(column)).unwrap_or((1.0, false));
                ((row[column] / white) as f32, is_encoded)
            };
            let linear = |column: usize| match channel(column) {
                (value, true) => rgb::decode(value),
                (value, false) => value,
            };
            if let Some(colour) = colour {
                let alpha = alpha.map_or(1.0, |alpha| channel(alpha).0);
                let colour = Vec3::from(colour.map(linear)).extend(alpha);
                let within = colour.clamp(Vec4::ZERO, Vec4::ONE);
                beyond |= within != colour;
                self.colours.push(within);
            }
        }
        if beyond {
            warnings.once("colours of vertices beyond 0–1 are cut off there");
        }
        if !self.colours.is_empty() && self.colours.iter().all(|colour| colour.w == 0.0) {
            warnings.once("the alpha of all vertices is 0, which would make everything invisible: it is ignored");
            self.colours.iter_mut().for_each(|colour| colour.w = 1.0);
        }
        Ok(())
    }

    fn read_faces(
        &mut self,
        face: &Element,
        vertices: u64,
        values: &mut Values<'_>,
        path: &Path,
        warnings: &mut Warnings,
    ) -> Result<()> {
        let Some(corners) = face.list("vertex_indices").or_else(|| face.list("vertex_index")) else {
            let invalid = Invalid::new("face", "has no list vertex_indices");
            return Err(invalid.help("export the mesh with its faces").in_file(path));
        };
        let uvs = face.list("texcoord");
        if face.properties.iter().any(|property| matches!(&*property.name, "red" | "diffuse_red")) {
            warnings.once("colours of faces are left out; give them to the vertices");
        }
        self.check_memory(face, corners, uvs.is_some(), values).map_err(|invalid| invalid.in_file(path))?;
        let (mut row, mut polygon, mut coordinates) = (Vec::new(), Vec::new(), Vec::new());
        let mut degenerate = 0;
        for i in 0..face.count {
            polygon.clear();
            coordinates.clear();
            values.row(face, i, &mut row, &mut |property, item| match property {
                _ if property == corners => polygon.push(item),
                _ if Some(property) == uvs => coordinates.push(item as f32),
                _ => {}
            })?;
            if let Some(corner) = polygon.iter().find(|&&c| c.fract() != 0.0 || !(0.0..vertices as f64).contains(&c)) {
                let message = format!("refers to vertex {corner}, but there are {vertices}, counted from 0");
                return Err(values.fault(face, i, message));
            }
            let n = polygon.len();
            if n > MOST_CORNERS {
                return Err(values.fault(
                    face,
                    i,
                    format!("has {n} corners, more than {MOST_CORNERS}: triangulate it"),
                ));
            }
            if uvs.is_some() && !coordinates.is_empty() && coordinates.len() != 2 * n {
                let message = format!("has {} numbers in texcoord for {n} corners, not {}", coordinates.len(), 2 * n);
                return Err(values.fault(face, i, message));
            }
            if let Some(number) = coordinates.iter().find(|number| !number.is_finite()) {
                return Err(values.fault(face, i, format!("texcoord is not finite: {number}")));
            }
            if n < 3 {
                degenerate += 1;
                continue;
            }
            self.sizes.push(n as u32);
            self.corners.extend(polygon.iter().map(|&corner| corner as u32));
            if uvs.is_some() {
                // A face may have none.
                let pairs = coordinates.as_chunks().0.iter().copied().chain(std::iter::repeat([0.0, 1.0]));
                self.corner_uvs.extend(pairs.take(n).map(upright));
            }
        }
        if degenerate > 0 {
            warnings.once(format!("faces of fewer than 3 corners are left out: {degenerate}"));
        }
        Ok(())
    }

    /// Refuses faces that take more memory than there is, estimated from the bytes that are left for them.
    fn check_memory(&self, face: &Element, corners: usize, has_uvs: bool, values: &Values<'_>) -> Result<(), Invalid> {
        /// Largest memory of a corner, bytes: its index, in a list that grows, and its share of a triangle; with UV,
        /// also those, and the corner as a vertex of its own.
        const CORNER: u64 = 20;
        const CORNER_WITH_UV: u64 = 120;
        let most = values.most(face.type_of(corners).size());
        let bytes = most.saturating_mul(if has_uvs { CORNER_WITH_UV } else { CORNER });
        memory::check(bytes, &format!("its {} faces", face.count), "simplify the mesh")
    }

    /// The mesh, of material 0.
    pub(super) fn into_mesh(self, name: String, missing_normals: MissingNormals) -> MeshDescription {
        let Self { positions, mut normals, uvs, colours, corners, sizes, .. } = self.without_strays();
        let mut triangles = Vec::with_capacity(corners.len() - 2 * sizes.len());
        let (mut rest, mut polygon) = (&corners[..], Vec::new());
        for size in sizes {
            let (of_face, others) = rest.split_at(size as usize);
            rest = others;
            polygon.clear();
            polygon.extend(of_face.iter().map(|&corner| positions[corner as usize]));
            triangulate(&polygon, |triangle| triangles.push(triangle.map(|i| of_face[i])));
        }
        if normals.is_empty() && missing_normals == MissingNormals::Smooth {
            normals = seamless_normals(&positions, &triangles);
        }
        let uvs = if uvs.is_empty() { Vec::new() } else { vec![uvs] };
        MeshDescription { name, positions, normals, uvs, colours, triangles, ..MeshDescription::default() }
    }

    /// Geometry without unused vertices, which would enlarge the mesh unseen: each once, or once for each UV of its
    /// corners.
    fn without_strays(mut self) -> Self {
        let mut is_used = vec![false; self.positions.len()];
        self.corners.iter().for_each(|&corner| is_used[corner as usize] = true);
        let has_own_uvs = !self.corner_uvs.is_empty();
        if !has_own_uvs && is_used.iter().all(|&is_used| is_used) {
            return self;
        }
        let mut known: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        let (mut vertices, mut uvs) = (Vec::new(), Vec::new());
        for (i, corner) in self.corners.iter_mut().enumerate() {
            let uv = self.corner_uvs.get(i).copied();
            let key = (*corner, uv.unwrap_or_default().to_array().map(f32::to_bits));
            *corner = *known.entry(key).or_insert_with(|| {
                vertices.push(*corner);
                uvs.extend(uv);
                vertices.len() as u32 - 1
            });
        }
        let uvs = if has_own_uvs { uvs } else { picked(&self.uvs, &vertices) };
        let [positions, normals] = [&self.positions, &self.normals].map(|values| picked(values, &vertices));
        Self { positions, normals, uvs, colours: picked(&self.colours, &vertices), ..self }
    }
}

/// Values of these vertices, if there are any.
fn picked<T: Copy>(values: &[T], vertices: &[u32]) -> Vec<T> {
    if values.is_empty() { Vec::new() } else { vertices.iter().map(|&vertex| values[vertex as usize]).collect() }
}

/// UV with v downwards.
fn upright([u, v]: [f32; 2]) -> Vec2 {
    Vec2::new(u, 1.0 - v)
}

/// The error of a file that has no faces.
fn without_faces(header: &Header, vertices: u64) -> Invalid {
    let strips = header.elements.iter().find(|e| e.count > 0 && matches!(&*e.name, "tristrips" | "trifan"));
    if let Some(Element { name, .. }) = strips {
        let invalid = Invalid::new(name, "triangle strips and fans are not supported");
        return invalid.help("convert the file to faces, for example with MeshLab");
    }
    let message = match vertices {
        0 => "has no faces".to_owned(),
        _ => format!("is a cloud of {vertices} points without faces, so there is no surface to be seen"),
    };
    Invalid::new("", message).help(
        "export the mesh with its faces, or make one of the points, for example by Poisson reconstruction in MeshLab",
    )
}
