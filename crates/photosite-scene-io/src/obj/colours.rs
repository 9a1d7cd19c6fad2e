//! Colours of the vertices of an OBJ file: `v x y z r g b`, as MeshLab, Blender and Open3D write them, and the comments
//! `#MRGB` of ZBrush. Either is encoded as sRGB.
//!
//! | the material of the surface | colours |
//! |---|---|
//! | none that a library describes | are its reflectance |
//! | has an image of its colour | are left out, with a warning |
//! | has a colour `Kd` | are multiplied by it, as glTF has it; alone where it is black, with a warning |
//! | glass, or a mix with a filter | are left out, with a warning |

use std::collections::BTreeSet;

use glam::{Vec3, Vec4};

use crate::assemble::{DEFAULT_REFLECTANCE, coloured};
use photosite_core::spectrum::rgb;
use photosite_core::warnings::Warnings;
use photosite_transport::scene::description::{
    Colour, Diffuse, LayeredDescription, MaterialDescription, MaterialModel, MeshDescription, TexturedColour,
    TexturedFactor,
};

/// Marker of a vertex without a colour: no component of a reflectance is below 0.
const NONE: Vec3 = Vec3::NEG_ONE;

/// Colours of the vertices of a file.
#[derive(Debug, Default)]
pub(super) struct VertexColours {
    /// Colours written behind the positions; shorter than the list of positions where the last have none.
    of_positions: Vec<Vec3>,
    /// Colours of `#MRGB` comments, 0–1.
    of_comments: Vec<Vec3>,
}

impl VertexColours {
    /// Sets the colour of a position.
    pub(super) fn set(&mut self, position: usize, colour: [f32; 3]) {
        self.of_positions.resize(position, NONE);
        self.of_positions.push(colour.into());
    }

    /// Reads what follows `#MRGB`: a mask, red, green and blue of each vertex, in two hexadecimal digits each. `None`
    /// where the digits are none of that.
    pub(super) fn add_comment(&mut self, digits: &str) -> Option<()> {
        let colour = |digits: &[u8; 8]| {
            let number = u32::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
            let [_, r, g, b] = number.to_be_bytes();
            Some(Vec3::new(r.into(), g.into(), b.into()) / 255.0)
        };
        let (groups, rest) = digits.as_bytes().as_chunks::<8>();
        let colours: Option<Vec<Vec3>> = groups.iter().map(colour).collect();
        self.of_comments.extend(colours.filter(|_| rest.is_empty())?);
        Some(())
    }

    /// Linear colours of `positions` positions, `None` for those without; empty where none has one.
    pub(super) fn linear(self, positions: usize, warnings: &mut Warnings) -> Vec<Option<Vec3>> {
        let Self { of_positions, of_comments } = self;
        let mut colours = if of_positions.is_empty() { of_comments } else { of_positions };
        if colours.is_empty() {
            return Vec::new();
        }
        if colours.len() > positions {
            warnings.once(format!("there are colours of {} vertices, but {positions} vertices", colours.len()));
        }
        colours.resize(positions, NONE);
        let given = || colours.iter().filter(|colour| **colour != NONE);
        let largest = given().map(|colour| colour.max_element()).fold(0.0, f32::max);
        let is_whole = given().all(|colour| colour.fract() == Vec3::ZERO);
        let white = if largest > 1.0 && largest <= 255.0 && is_whole { 255.0 } else { 1.0 };
        if white > 1.0 {
            warnings.once("the colours of the vertices are whole numbers up to 255, which is taken for white");
        } else if given().any(|colour| colour.clamp(Vec3::ZERO, Vec3::ONE) != *colour) {
            warnings.once("colours of vertices beyond 0–1 are cut off there");
        }
        let linear = |colour: Vec3| (colour / white).clamp(Vec3::ZERO, Vec3::ONE).to_array().map(rgb::decode).into();
        colours.into_iter().map(|colour| (colour != NONE).then(|| linear(colour))).collect()
    }
}

/// Lets materials use the colours of their meshes' vertices, or drops the colours where they cannot. Missing colours
/// are filled in. `is_described` tells which materials a library describes. Returns the undescribed materials that use
/// colours.
pub(super) fn settle(
    meshes: &mut [MeshDescription],
    materials: &mut [MaterialDescription],
    is_described: &[bool],
    warnings: &mut Warnings,
) -> BTreeSet<usize> {
    let has_colours: BTreeSet<usize> =
        meshes.iter().filter(|mesh| !mesh.colours.is_empty()).map(|mesh| mesh.material).collect();
    let mut found = BTreeSet::new();
    let mut missing = 0;
    for &index in &has_colours {
        let Some(material) = materials.get_mut(index) else { continue };
        let is_described = is_described.get(index).copied().unwrap_or(false);
        let keeps = if is_described { make_room(material, warnings) } else { true };
        if !is_described {
            *material = coloured("OBJ", &material.name, false);
            found.insert(index);
        }
        // Of a surface that nothing describes, as of others like it
        let otherwise = if is_described { Vec3::ONE } else { Vec3::splat(DEFAULT_REFLECTANCE) };
        for mesh in meshes.iter_mut().filter(|mesh| mesh.material == index) {
            if !keeps {
                mesh.colours = Vec::new();
                continue;
            }
            let of_mesh = mesh.colours.len();
            mesh.colours.resize(mesh.positions.len(), NONE.extend(1.0));
            for colour in mesh.colours.iter_mut().filter(|colour| colour.truncate() == NONE) {
                *colour = otherwise.extend(1.0);
                missing += usize::from(of_mesh > 0);
            }
        }
    }
    if missing > 0 {
        warnings
            .once(format!("{missing} corners have no colour beside others that have one; the material's stands there"));
    }
    found
}

/// Colour attribute of a mesh vertex.
pub(super) fn of_vertex(colour: Option<Vec3>) -> Vec4 {
    colour.unwrap_or(NONE).extend(1.0)
}

/// Makes a material multiply its colour by that of the vertices. Returns whether it can.
fn make_room(material: &mut MaterialDescription, warnings: &mut Warnings) -> bool {
    let name = &material.name;
    if let MaterialModel::Diffuse(Diffuse { reflectance }) = &material.model {
        material.model = MaterialModel::Layered(Box::new(LayeredDescription {
            kind: "MTL",
            base_colour: reflectance.clone(),
            specular: TexturedFactor::plain(0.0),
            ..LayeredDescription::default()
        }));
    }
    let MaterialModel::Layered(layers) = &mut material.model else {
        warnings
            .once(format!("material {name:?}: the colours of the vertices are left out, as it has none of its own"));
        return false;
    };
    if layers.base_colour.texture.is_some() {
        warnings.once(format!(
            "material {name:?}: the colours of the vertices are left out, as its image has those of the surface"
        ));
        return false;
    }
    if matches!(layers.base_colour.colour, Colour::Rgb([0.0, 0.0, 0.0])) {
        warnings.once(format!("material {name:?}: Kd is black, and the colours of the vertices are taken instead"));
        layers.base_colour = TexturedColour::white();
    }
    true
}
