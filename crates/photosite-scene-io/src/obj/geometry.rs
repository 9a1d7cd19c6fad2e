//! Geometry statements of an OBJ file, as lists of numbers and faces.

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3};

use super::colours::VertexColours;
use super::lines::{Statement, statements};
use crate::polygon::MOST_CORNERS;
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, Result};

/// Geometry of an OBJ file, with indices counted from 0 and checked.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub(super) positions: Vec<Vec3>,
    /// Linear colours of the positions, `None` for those without; empty where none has one.
    pub(super) colours: Vec<Option<Vec3>>,
    /// UV coordinates, v downwards as in glTF; in OBJ files v grows upwards.
    pub(super) uvs: Vec<Vec2>,
    pub(super) normals: Vec<Vec3>,
    pub(super) corners: Vec<Corner>,
    pub(super) faces: Vec<Face>,
    /// Names of objects (`o`); the first is for faces before any.
    pub(super) objects: Vec<String>,
    /// Names of materials (`usemtl`) in the order of their first use.
    pub(super) materials: Vec<String>,
    /// Material libraries (`mtllib`), with their lines.
    pub(super) libraries: Vec<(usize, String)>,
}

/// A corner of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: Option<u32>,
    pub(super) normal: Option<u32>,
}

/// A polygon: a run of corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub(super) first_corner: usize,
    pub(super) corners: usize,
    pub(super) object: usize,
    /// Index into the material names; `None` before any `usemtl`.
    pub(super) material: Option<usize>,
    /// Smoothing group; 0 is off.
    pub(super) smoothing_group: u32,
    line: usize,
}

impl Geometry {
    /// The corners of a face.
    pub(super) fn corners_of(&self, face: &Face) -> &[Corner] {
        &self.corners[face.first_corner..][..face.corners]
    }

    /// Reads the text of an OBJ file.
    pub(super) fn parse(text: &str, path: &Path, warnings: &mut Warnings) -> Result<Self> {
        let mut geometry = Self { objects: vec![String::new()], ..Self::default() };
        let mut state = State::default();
        for statement in statements(text) {
            geometry.add(&statement, &mut state, warnings).map_err(|invalid| statement.at(invalid, path))?;
        }
        geometry.check(path)?;
        geometry.colours = state.colours.linear(geometry.positions.len(), warnings);
        Ok(geometry)
    }

    fn add(&mut self, statement: &Statement<'_>, state: &mut State, warnings: &mut Warnings) -> Result<(), Invalid> {
        match statement.keyword() {
            "v" => {
                let ([x, y, z, r, g, b, _], count) = statement.numbers::<7>(3)?;
                match count {
                    3 => {}
                    // A weight, which surfaces of polygons have no use for
                    4 if r == 1.0 => {}
                    6 => state.colours.set(self.positions.len(), [r, g, b]),
                    _ => warnings.once(format!(
                        "line {}: what follows the position of a vertex is left out: it is neither red, green and blue \
                         nor a weight of 1",
                        statement.line
                    )),
                }
                self.positions.push(Vec3::new(x, y, z));
            }
            "#MRGB" => {
                if state.colours.add_comment(statement.rest()).is_none() {
                    warnings
                        .once(format!("line {}: #MRGB holds no colours of vertices and is left out", statement.line));
                }
            }
            "vt" => {
                let [u, v] = statement.numbers::<2>(1)?.0;
                self.uvs.push(Vec2::new(u, 1.0 - v));
            }
            "vn" => self.normals.push(Vec3::from_array(statement.numbers::<3>(3)?.0)),
            "f" | "fo" => self.add_face(statement, state)?,
            "o" => {
                state.object = self.objects.len();
                self.objects.push(statement.rest().to_owned());
            }
            "usemtl" => state.material = Some(self.material(statement.rest(), state)),
            "mtllib" => self.libraries.push((statement.line, statement.rest().to_owned())),
            "s" => {
                state.smoothing_group = match statement.words().next() {
                    Some("off") | None => 0,
                    Some(word) => word.parse().map_err(|_| {
                        Invalid::new("", format!("{word:?} is not a smoothing group"))
                            .help("write a number, or \"off\"")
                    })?,
                };
            }
            "p" | "l" => warnings.once("points and lines have no surface and are left out"),
            // Names of groups, and what concerns display only.
            "g" | "lod" | "shadow_obj" | "trace_obj" | "bevel" | "c_interp" | "d_interp" | "maplib" | "usemap"
            | "mg" => {}
            "curv" | "curv2" | "surf" | "cstype" | "vp" | "deg" | "parm" | "trim" | "hole" | "end" | "bmat"
            | "step" | "scrv" | "sp" | "con" | "ctech" | "stech" => {
                warnings.once("curves and free-form surfaces are not supported and are left out");
            }
            other => warnings.once(format!("line {}: unknown statement {other:?} is left out", statement.line)),
        }
        Ok(())
    }

    /// The index of a material by name.
    fn material(&mut self, name: &str, state: &mut State) -> usize {
        *state.material_indices.entry(name.to_owned()).or_insert_with(|| {
            self.materials.push(name.to_owned());
            self.materials.len() - 1
        })
    }

    fn add_face(&mut self, statement: &Statement<'_>, state: &State) -> Result<(), Invalid> {
        let first_corner = self.corners.len();
        for word in statement.words() {
            let corner = self.corner(word)?;
            self.corners.push(corner);
        }
        let corners = self.corners.len() - first_corner;
        if corners < 3 {
            return Err(Invalid::new("", format!("a face needs 3 corners, found {corners}")));
        }
        if corners > MOST_CORNERS {
            let message = format!("a face has {corners} corners, more than {MOST_CORNERS}");
            return Err(Invalid::new("", message).help("triangulate the mesh"));
        }
        let State { object, material, smoothing_group, .. } = *state;
        self.faces.push(Face { first_corner, corners, object, material, smoothing_group, line: statement.line });
        Ok(())
    }

    /// Parses `position`, `position/uv`, `position//normal` or `position/uv/normal`.
    fn corner(&self, word: &str) -> Result<Corner, Invalid> {
        let mut parts = word.split('/');
        let mut index = |len: usize, what: &str| match parts.next() {
            None | Some("") => Ok(None),
            Some(part) => match part.parse::<i64>() {
                // Counted from 1; checked when the whole file is read, since a face may come before its vertices.
                Ok(i) if i > 0 && i <= i64::from(u32::MAX) => Ok(Some((i - 1) as u32)),
                // Counted backwards from the last one so far.
                Ok(i) if i < 0 && i.unsigned_abs() <= len as u64 => Ok(Some((len as i64 + i) as u32)),
                Ok(i) => Err(Invalid::new("", format!("{word:?} refers to {what} {i}, but there are {len} so far"))
                    .help("indices count from 1, or backwards from −1")),
                Err(_) => {
                    Err(Invalid::new("", format!("{word:?} is not a corner")).help("for example f 1/1/1 2/2/2 3/3/3"))
                }
            },
        };
        let position = index(self.positions.len(), "vertex")?;
        let uv = index(self.uvs.len(), "texture vertex")?;
        let normal = index(self.normals.len(), "normal")?;
        match (position, parts.next()) {
            (Some(position), None) => Ok(Corner { position, uv, normal }),
            (None, _) | (Some(_), Some(_)) => {
                Err(Invalid::new("", format!("{word:?} is not a corner")).help("for example f 1/1/1 2/2/2 3/3/3"))
            }
        }
    }

    /// Refuses indices beyond what the file has.
    fn check(&self, path: &Path) -> Result<()> {
        for face in &self.faces {
            for corner in self.corners_of(face) {
                for (index, len, what) in [
                    (Some(corner.position), self.positions.len(), "vertex"),
                    (corner.uv, self.uvs.len(), "texture vertex"),
                    (corner.normal, self.normals.len(), "normal"),
                ] {
                    if let Some(index) = index.filter(|&i| i as usize >= len) {
                        let message = format!("refers to {what} {}, but the file has {len}", u64::from(index) + 1);
                        let help = "indices count from 1, or backwards from −1; is a part of the file missing?";
                        return Err(Invalid::new("f", message).help(help).at_line(path, face.line));
                    }
                }
            }
        }
        Ok(())
    }
}

/// State that holds until another statement changes it.
#[derive(Default)]
struct State {
    object: usize,
    material: Option<usize>,
    smoothing_group: u32,
    material_indices: HashMap<String, usize>,
    colours: VertexColours,
}
