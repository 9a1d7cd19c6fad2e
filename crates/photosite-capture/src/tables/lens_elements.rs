//! Elements of a lens, and its search for focus: tables within `[lens]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::material::IndexSource;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_transport::optics::Sharpness;

/// The glass of a lens in one piece, whose focal length follows by the lensmaker's equation at each wavelength:
/// 1/f = (n − 1)·(1/R₁ − 1/R₂ + (n − 1)·d/(n·R₁·R₂)).
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct LensmakerTable {
    /// Radii of curvature of the front and the back surface, mm, or "flat": above 0 where the centre lies on the side
    /// of the sensor. [50, -50] is biconvex.
    pub(crate) radii_mm: [Radius; 2],
    /// Thickness on the axis, mm. Left out: 0.
    #[schemars(transform = within(0.0..))]
    pub(crate) thickness_mm: Option<f64>,
    /// Name of a glass that ships with photosite: "BK7", "SF11" … Or give its index.
    pub(crate) glass: Option<String>,
    /// Refractive index.
    pub(crate) index: Option<IndexSource>,
    /// Abbe number, with an index that is a number. Left out: the index is the same at all wavelengths.
    #[schemars(transform = above(0.0..))]
    pub(crate) abbe_number: Option<f64>,
}

/// A radius of curvature in mm, or "flat".
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(untagged, expecting = "expected a radius in mm, or \"flat\"")]
pub(crate) enum Radius {
    /// mm.
    Mm(f64),
    /// "flat".
    Name(#[schemars(extend("const" = "flat"))] String),
}

/// A thin lens before the main one: its power, its focal length, or the glass that it is ground of.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct SupplementaryTable {
    /// Distance before the main lens, mm. Left out: 0.
    #[schemars(transform = within(0.0..))]
    pub(crate) distance_mm: Option<f64>,
    /// Power, dioptres: 2 is a close-up lens, -2 a diverging one.
    pub(crate) power_dpt: Option<f64>,
    /// Focal length, mm; below 0 for a diverging lens.
    pub(crate) focal_length_mm: Option<f64>,
    /// Radii of curvature of the front and the back surface, mm, or "flat", as of lens.lensmaker.
    pub(crate) radii_mm: Option<[Radius; 2]>,
    /// Thickness on the axis, mm, with radii. Left out: 0.
    #[schemars(transform = within(0.0..))]
    pub(crate) thickness_mm: Option<f64>,
    /// Name of a glass, with radii.
    pub(crate) glass: Option<String>,
    /// Refractive index, with radii.
    pub(crate) index: Option<IndexSource>,
    /// Abbe number, with an index that is a number.
    #[schemars(transform = above(0.0..))]
    pub(crate) abbe_number: Option<f64>,
}

/// How autofocus finds the distance of what is seen at autofocus_px.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct AutofocusSearchTable {
    /// Left out: "exact".
    pub(crate) method: Option<AutofocusKind>,
    /// Width and height of the part of the image whose contrast counts, px. Left out: 64.
    #[schemars(transform = within(8.0..=1024.0))]
    pub(crate) window_px: Option<u32>,
    /// Positions of the focus that are tried in each round, at even distances of the sensor; the next round looks
    /// between the neighbours of the best. The first tries more where a blur of 3 px would lie between two. Left out:
    /// 12.
    #[schemars(transform = within(5.0..=200.0))]
    pub(crate) steps: Option<u32>,
    /// Measure of contrast. Left out: "gradient".
    pub(crate) measure: Option<Sharpness>,
}

/// Ways to focus.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum AutofocusKind {
    /// On the distance of what the ray of the pixel meets.
    Exact,
    /// On the distance at which the image has the most contrast, as cameras do: the part of the image is traced at
    /// one position of the focus after the other, as the sensor sees it without noise.
    Contrast,
}
