//! What can be asked of each pixel.

use schemars::JsonSchema;
use serde::Deserialize;

/// Layer of ground truth, a quantity of the surface that a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TruthLayer {
    /// Depth: distance from the centre of the lens along the optical axis, m.
    Depth,
    /// Distance from the centre of the lens along the ray, m.
    Distance,
    /// Position in the world, m.
    Position,
    /// Unit normal of the surface in the world, on the camera's side.
    Normal,
    /// Unit normal with the smoothing of the geometry's normals and without that of normal maps.
    ShadingNormal,
    /// UV coordinates, first set.
    Uv,
    /// Part of the light that the surface scatters, as linear sRGB under D65.
    Albedo,
    /// Position in the frame of its object without the object's scale, m.
    ObjectPosition,
    /// Normalised object coordinates, the place in the box of its object: 0.5 in the middle, along each axis of the
    /// object, in parts of the box's diagonal ([Nocs](photosite_core::references#nocs)).
    Nocs,
    /// Object, numbered from 1.
    Instance,
    /// Material, numbered from 1.
    Material,
    /// Optical flow, the place of the surface in the next image less its place in this one, px; x right, y down. What
    /// moves is followed. Nothing is visible where there is no next picture.
    Flow,
    /// Disparity, the place of the surface in the left image of a pair less its place in the right one, px; x right, y
    /// down: the same for both cameras, x = fx·b/z of a parallel pair with the baseline b. Of a pair one above the
    /// other, in the upper picture less in the lower one.
    Disparity,
}

impl TruthLayer {
    /// All layers.
    pub const ALL: [Self; 13] = [
        Self::Depth,
        Self::Distance,
        Self::Position,
        Self::Normal,
        Self::ShadingNormal,
        Self::Uv,
        Self::Albedo,
        Self::ObjectPosition,
        Self::Nocs,
        Self::Instance,
        Self::Material,
        Self::Flow,
        Self::Disparity,
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Distance => "distance",
            Self::Position => "position",
            Self::Normal => "normal",
            Self::ShadingNormal => "shading-normal",
            Self::Uv => "uv",
            Self::Albedo => "albedo",
            Self::ObjectPosition => "object-position",
            Self::Nocs => "nocs",
            Self::Instance => "instance",
            Self::Material => "material",
            Self::Flow => "flow",
            Self::Disparity => "disparity",
        }
    }

    /// The names of its planes. That of a layer of one plane is the layer's own.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Depth => &["depth"],
            Self::Distance => &["distance"],
            Self::Position => &["position.X", "position.Y", "position.Z"],
            Self::Normal => &["normal.X", "normal.Y", "normal.Z"],
            Self::ShadingNormal => &["shading-normal.X", "shading-normal.Y", "shading-normal.Z"],
            Self::Uv => &["uv.U", "uv.V"],
            Self::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Self::ObjectPosition => &["object-position.X", "object-position.Y", "object-position.Z"],
            Self::Nocs => &["nocs.X", "nocs.Y", "nocs.Z"],
            Self::Instance => &["instance"],
            Self::Material => &["material"],
            Self::Flow => &["flow.X", "flow.Y", "flow.visible"],
            Self::Disparity => &["disparity.X", "disparity.Y", "disparity.visible"],
        }
    }

    /// What its planes hold where there is no surface.
    pub fn nothing(self) -> f32 {
        match self {
            Self::Depth | Self::Distance => f32::INFINITY,
            Self::Position | Self::Uv | Self::ObjectPosition => f32::NAN,
            Self::Normal
            | Self::ShadingNormal
            | Self::Albedo
            | Self::Nocs
            | Self::Instance
            | Self::Material
            | Self::Flow
            | Self::Disparity => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_bear_the_name_of_their_layer() {
        for layer in TruthLayer::ALL {
            let name = layer.name();
            match layer.channels() {
                [single] => assert_eq!(*single, name),
                several => assert!(several.iter().all(|c| c.split_once('.').is_some_and(|(of, _)| of == name))),
            }
        }
    }
}
