//! Calibration targets: flat sheets with a pattern of exact edges, inks of known reflectance, and points whose places
//! are known.
//!
//! In: a [`TargetDescription`], which is what `[[targets]]` of a capture file says. Out: a [`Target`], a drawing of
//! shapes in metres. [`mesh`](Target::meshes) makes triangles of it, [`print`](mod@print) SVG and PDF in true size.
//!
//! # The frame of a target
//!
//! That of OpenCV: x to the right and y down along the front of the sheet, z = x × y into the sheet, metres. The origin
//! is where OpenCV puts that of the same pattern's object points: the first inner corner of a chessboard, the top-left
//! corner of a ChArUco or marker board, the first circle of a grid. Charts without such a custom have it in their
//! middle. Points stand in the order in which OpenCV lists them.

mod april_grid;
mod charts;
mod charuco;
mod chessboard;
mod circles;
mod colour_checker;
mod drawing;
mod edges;
mod limits;
mod marker_grid;
pub mod markers;
mod mesh;
mod placed;
pub mod print;
mod siemens_star;
#[cfg(test)]
mod tests;

use schemars::JsonSchema;
use serde::de::{DeserializeSeed, Deserializer};
use serde::{Deserialize, Serialize};

pub use april_grid::AprilGrid;
pub use charts::{Flat, GreyWedge};
pub use charuco::Charuco;
pub use chessboard::Chessboard;
pub use circles::{AsymmetricCircleGrid, CircleGrid, DotChart};
pub use colour_checker::ColourChecker;
pub use drawing::{Ink, Marker, Outline, Point, Shape, Target};
pub use edges::{EsfrChart, SlantedEdge};
pub use marker_grid::MarkerGrid;
pub use placed::PlacedTarget;
pub use siemens_star::SiemensStar;

use photosite_core::Invalid;

/// Builders of the tables of targets.
pub mod keys {
    pub use super::TargetKeys;
    pub use super::april_grid::AprilGridKeys;
    pub use super::charts::{FlatKeys, GreyWedgeKeys};
    pub use super::charuco::CharucoKeys;
    pub use super::chessboard::ChessboardKeys;
    pub use super::circles::{AsymmetricCircleGridKeys, CircleGridKeys, DotChartKeys};
    pub use super::colour_checker::ColourCheckerKeys;
    pub use super::edges::{EsfrChartKeys, SlantedEdgeKeys};
    pub use super::marker_grid::MarkerGridKeys;
    pub use super::siemens_star::SiemensStarKeys;
}
use photosite_core::keys::Keys;

/// Declares the kinds of targets: variant, name, description.
macro_rules! kinds {
    ($($(#[doc = $doc:literal])* $variant:ident = $name:literal,)*) => {
        /// A calibration target: what it is and how large.
        #[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
        #[serde(tag = "type")]
        pub enum TargetDescription {
            $($(#[doc = $doc])* #[serde(rename = $name)] $variant($variant),)*
        }

        /// The kinds of targets.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
        #[allow(missing_docs, reason = "those of TargetDescription")]
        pub enum TargetKind {
            $(#[serde(rename = $name)] $variant,)*
        }

        impl TargetKind {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Name of the kind in files.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// What it is, in a line.
            pub fn summary(self) -> &'static str {
                match self { $(Self::$variant => concat!($($doc),*).trim_start(),)* }
            }

            /// With every key left out.
            pub fn default_description(self) -> TargetDescription {
                match self { $(Self::$variant => TargetDescription::$variant($variant::default()),)* }
            }
        }

        impl TargetDescription {
            /// Kind of the target.
            pub fn kind(&self) -> TargetKind {
                match self { $(Self::$variant(_) => TargetKind::$variant,)* }
            }

            /// Draws it, or says which of its sizes are impossible.
            pub fn draw(&self) -> Result<Target, Invalid> {
                match self { $(Self::$variant(description) => description.draw(),)* }
            }
        }

        impl<'de> DeserializeSeed<'de> for TargetKind {
            type Value = TargetDescription;

            /// Reads the keys of a target of this kind, without `type`.
            fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<TargetDescription, D::Error> {
                match self {
                    $(Self::$variant => $variant::deserialize(deserializer).map(TargetDescription::$variant),)*
                }
            }
        }
    };
}

kinds! {
    /// Chessboard.
    Chessboard = "chessboard",
    /// ChArUco board: a chessboard with ArUco markers in its white squares.
    Charuco = "charuco",
    /// Grid of ArUco or AprilTag markers, as OpenCV's GridBoard.
    MarkerGrid = "marker-grid",
    /// Grid of AprilTags with squares at their corners, as Kalibr's aprilgrid.
    AprilGrid = "aprilgrid",
    /// Circles in rows and columns.
    CircleGrid = "circle-grid",
    /// Circles in rows that are shifted by turns.
    AsymmetricCircleGrid = "asymmetric-circle-grid",
    /// Many small dots in rows and columns, for distortion; the origin is the one in the middle.
    DotChart = "dot-chart",
    /// A dark square, turned a little: four slanted edges.
    SlantedEdge = "slanted-edge",
    /// Slanted edges all over the image with grey steps above and below, in the manner of ISO 12233's e-SFR chart.
    EsfrChart = "esfr-chart",
    /// Siemens star.
    SiemensStar = "siemens-star",
    /// The 24 patches of the ColorChecker with their measured spectra.
    ColourChecker = "colour-checker",
    /// Grey steps of even distances in optical density.
    GreyWedge = "grey-wedge",
    /// An even sheet.
    Flat = "flat",
}
