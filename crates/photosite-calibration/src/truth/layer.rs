//! Layers of ground truth: the table of what can be asked of each pixel, which all that writes, shows or hands out a
//! layer reads.

use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of the values of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Measured values, between which there are others.
    Real,
    /// Indices of things from 1 on, which have no mean.
    Index,
}

/// Rule by which a layer becomes 16-bit numbers of a PNG file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PngRule {
    /// No PNG files: the layer's values have no range.
    None,
    /// Lengths in a unit of choice, at least 1; 0 for nothing.
    Length,
    /// Indices as they are, 0 for nothing.
    Index,
    /// Components of directions: 0 for −1 and 65535 for 1, zeros for nothing.
    Direction,
    /// Parts of 1: 65535 for 1, kept within.
    Part,
    /// Flow in KITTI's encoding: 64·x + 2¹⁵, 64·y + 2¹⁵, visible; zeros beyond ±512 px.
    Flow,
    /// Disparity in KITTI's encoding: 256·x where it is visible, at least 1; 0 elsewhere.
    Disparity,
}

/// Needs of a layer, beside the surface that a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// No more than the surface.
    Surface,
    /// The next image.
    NextImage,
    /// The image of another camera.
    Partner,
}

/// Declares [`TruthLayer`] by its table: description of a layer, its name in files, its planes (one has the layer's
/// name), its unit, the value of its planes where there is no surface, its kind of number, its rule for PNG files and
/// its needs.
macro_rules! layers {
    (@planes $name:literal) => { &[$name] };
    (@planes $name:literal $($plane:literal)+) => { &[$(concat!($name, ".", $plane)),+] };
    ($(
        $(#[$doc:meta])*
        $layer:ident = $name:literal [$($plane:literal)*] $unit:literal,
        nothing: $nothing:expr, values: $values:ident, png: $png:ident, needs: $needs:ident;
    )+) => {
        /// Layer of ground truth, a quantity of the surface that a pixel sees.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
        pub enum TruthLayer {
            $($(#[$doc])* #[serde(rename = $name)] $layer,)+
        }

        impl TruthLayer {
            /// All layers.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$layer),+];

            /// Name of the layer in files.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$layer => $name,)+ }
            }

            /// The names of its planes. That of a layer of one plane is the layer's own.
            pub const fn channels(self) -> &'static [&'static str] {
                match self { $(Self::$layer => layers!(@planes $name $($plane)*),)+ }
            }

            /// Unit of its values; empty for numbers without one.
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$layer => $unit,)+ }
            }

            /// Value of its planes where there is no surface.
            pub const fn nothing(self) -> f32 {
                match self { $(Self::$layer => $nothing,)+ }
            }

            /// Kind of its values.
            pub const fn values(self) -> Values {
                match self { $(Self::$layer => Values::$values,)+ }
            }

            /// Rule for PNG files.
            pub const fn png(self) -> PngRule {
                match self { $(Self::$layer => PngRule::$png,)+ }
            }

            /// Needs of the layer, beside the surface that a pixel sees.
            pub const fn needs(self) -> Needs {
                match self { $(Self::$layer => Needs::$needs,)+ }
            }
        }
    };
}

layers! {
    /// Depth: distance from the centre of the lens along the optical axis, m.
    Depth = "depth" [] "m", nothing: f32::INFINITY, values: Real, png: Length, needs: Surface;
    /// Distance from the centre of the lens along the ray, m.
    Distance = "distance" [] "m", nothing: f32::INFINITY, values: Real, png: Length, needs: Surface;
    /// Position in the world, m.
    Position = "position" ["X" "Y" "Z"] "m", nothing: f32::NAN, values: Real, png: None, needs: Surface;
    /// Unit normal of the surface in the world, on the camera's side.
    Normal = "normal" ["X" "Y" "Z"] "", nothing: 0.0, values: Real, png: Direction, needs: Surface;
    /// Unit normal with the smoothing of the geometry's normals and without that of normal maps.
    ShadingNormal = "shading-normal" ["X" "Y" "Z"] "", nothing: 0.0, values: Real, png: Direction, needs: Surface;
    /// UV coordinates, first set.
    Uv = "uv" ["U" "V"] "", nothing: f32::NAN, values: Real, png: None, needs: Surface;
    /// Part of the light that the surface scatters, as linear sRGB under D65.
    Albedo = "albedo" ["R" "G" "B"] "", nothing: 0.0, values: Real, png: Part, needs: Surface;
    /// Position in the frame of its object without the object's scale, m.
    ObjectPosition = "object-position" ["X" "Y" "Z"] "m", nothing: f32::NAN, values: Real, png: None, needs: Surface;
    /// Normalised object coordinates, the place in the box of its object: 0.5 in the middle, along each axis of the
    /// object, in parts of the box's diagonal ([Nocs](photosite_core::references#nocs)).
    Nocs = "nocs" ["X" "Y" "Z"] "", nothing: 0.0, values: Real, png: Part, needs: Surface;
    /// Object, numbered from 1.
    Instance = "instance" [] "", nothing: 0.0, values: Index, png: Index, needs: Surface;
    /// Material, numbered from 1.
    Material = "material" [] "", nothing: 0.0, values: Index, png: Index, needs: Surface;
    /// Optical flow, the place of the surface in the next image less its place in this one, px; x right, y down. What
    /// moves is followed. Nothing is visible where there is no next image.
    Flow = "flow" ["X" "Y" "visible"] "px", nothing: 0.0, values: Real, png: Flow, needs: NextImage;
    /// Disparity, the place of the surface in the left image of a pair less its place in the right one, px; x right, y
    /// down: the same for both cameras, x = fx·b/z of a parallel pair with the baseline b. Of a pair one above the
    /// other, in the upper image less in the lower one.
    Disparity = "disparity" ["X" "Y" "visible"] "px", nothing: 0.0, values: Real, png: Disparity, needs: Partner;
}

impl TruthLayer {
    /// The layer of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layer| layer.name() == name)
    }

    /// Whether one of some layers needs `needs`, such as the next image.
    pub fn any_needs(layers: &[Self], needs: Needs) -> bool {
        layers.iter().any(|layer| layer.needs() == needs)
    }
}

impl PngRule {
    /// Whether the rule has bounds that values of a scene may exceed.
    pub const fn is_bounded(self) -> bool {
        matches!(self, Self::Length | Self::Flow | Self::Disparity)
    }
}
