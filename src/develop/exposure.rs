//! Exposure: brightens or darkens a developed picture.

use crate::image::Planes;

/// Every value times 2^`ev`; nothing is clipped here.
pub(super) fn apply(picture: Planes, ev: f64) -> Planes {
    if ev == 0.0 { picture } else { picture.scaled(ev.exp2()) }
}
