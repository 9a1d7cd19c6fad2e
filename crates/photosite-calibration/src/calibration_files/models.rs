//! Parts that the formats have in common: matrices and coefficients.

use photosite_core::projection::{BrownConrady, Intrinsics, Projection};

use super::tree::{Fault, Item, Table};

/// Matrix whose centre of the first pixel is 0, 0, as OpenCV, ROS, Kalibr and EuRoC count.
pub(super) fn at_centres(item: &Item<'_>, [fx, fy, cx, cy]: [f64; 4], skew: f64) -> Result<Intrinsics, Fault> {
    at_corners(item, [fx, fy, cx + 0.5, cy + 0.5], skew)
}

/// Matrix whose corner of the first pixel is 0, 0, as photosite and COLMAP count.
pub(super) fn at_corners(item: &Item<'_>, [fx, fy, cx, cy]: [f64; 4], skew: f64) -> Result<Intrinsics, Fault> {
    for (name, f) in [("fx", fx), ("fy", fy)] {
        if f <= 0.0 {
            return Err(item.fault(format!("{name} must be above 0 px, found {f}")));
        }
    }
    Ok(Intrinsics { fx, fy, cx, cy, skew })
}

/// Intrinsics of a 3 × 3 camera matrix, with the skew that it states.
pub(super) fn of_matrix(item: &Item<'_>) -> Result<Intrinsics, Fault> {
    let [fx, skew, cx, a, fy, cy, b, c, d] = item.array::<9>("the 3 × 3 camera matrix row by row")?;
    if [a, b, c, d] != [0.0, 0.0, 0.0, 1.0] {
        return Err(item
            .fault(format!("is no camera matrix: its lower left is {a}, {b}, {c} and its last number {d}"))
            .help("row by row it is fx, 0, cx, 0, fy, cy, 0, 0, 1"));
    }
    at_centres(item, [fx, fy, cx, cy], skew)
}

/// Refuses a skew for a model that does not know it.
pub(super) fn without_skew(item: &Item<'_>, intrinsics: &Intrinsics, model: &str) -> Result<(), Fault> {
    if intrinsics.skew == 0.0 {
        return Ok(());
    }
    let message = format!("states a skew of {} px, which {model} does not project with", intrinsics.skew);
    Err(item.fault(message).help("write 0 there, or the matrix as lens.intrinsics with skew"))
}

/// Columns and rows under some names.
pub(super) fn resolution(table: &Table<'_>, names: [&[&str]; 2]) -> Result<Option<[u32; 2]>, Fault> {
    match names.map(|names| table.get_any(names)) {
        [Some(width), Some(height)] => Ok(Some([width.count()?, height.count()?])),
        [None, None] => Ok(None),
        [Some(_), None] => Err(table.missing(names[1][0], &format!("{}: 480", names[1][0]))),
        [None, Some(_)] => Err(table.missing(names[0][0], &format!("{}: 640", names[0][0]))),
    }
}

/// OpenCV's standard model of k₁ k₂ p₁ p₂ k₃ k₄ k₅ k₆ s₁ s₂ s₃ s₄ τ_x τ_y, of which 0, 4, 5, 8, 12 or 14 are given.
pub(super) fn brown_conrady(item: &Item<'_>, c: &[f64]) -> Result<Projection, Fault> {
    if ![0, 4, 5, 8, 12, 14].contains(&c.len()) {
        let message = format!("expected 4, 5, 8, 12 or 14 coefficients k1, k2, p1, p2, k3 …, found {}", c.len());
        return Err(item.fault(message));
    }
    if c.iter().skip(12).any(|tilt| *tilt != 0.0) {
        let message = format!("the tilted sensor model (τx, τy = {}, {}) is not rendered by photosite", c[12], c[13]);
        return Err(item.fault(message).help("calibrate without CALIB_TILTED_MODEL"));
    }
    if c.iter().all(|c| *c == 0.0) {
        return Ok(Projection::Perspective);
    }
    let c = |i: usize| c.get(i).copied().unwrap_or(0.0);
    let k = [0, 1, 4, 5, 6, 7].map(c);
    Ok(Projection::BrownConrady(BrownConrady { k, p: [c(2), c(3)], s: [8, 9, 10, 11].map(c) }))
}

/// Fisheye of k₁ … k₄.
pub(super) fn kannala_brandt(item: &Item<'_>) -> Result<Projection, Fault> {
    Ok(Projection::KannalaBrandt { k: item.array::<4>("k1, k2, k3, k4")? })
}

/// Unified model of ξ with k₁ k₂ p₁ p₂; `item` is that of ξ.
pub(super) fn omnidirectional(item: &Item<'_>, xi: f64, [k1, k2, p1, p2]: [f64; 4]) -> Result<Projection, Fault> {
    if xi < 0.0 {
        return Err(item.fault(format!("ξ must be 0 or more, found {xi}")));
    }
    let distortion = BrownConrady { k: [k1, k2, 0.0, 0.0, 0.0, 0.0], p: [p1, p2], s: [0.0; 4] };
    Ok(Projection::Omnidirectional { xi, distortion })
}
