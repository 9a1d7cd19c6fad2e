//! Captures that can be read are rendered: 8 × 8 pixels, one sample each.

use crate::{Captures, render};

pub(crate) fn target(data: &[u8]) {
    if let Some(capture) = Captures::of(data) {
        render(&capture);
    }
}
