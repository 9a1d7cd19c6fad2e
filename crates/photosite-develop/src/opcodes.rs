//! Opcodes of DNG files, each list in its place: on stored values, on the linear signal, on the demosaicked image.

use std::borrow::Cow;

use photosite_core::image::Planes;
use photosite_raw::{Frame, Opcode, PixelArea, RawImage};

use super::defects;

/// Opcodes of a list, without those that correct the lens's falloff where it is to stay.
pub(super) fn opcodes(raw: &RawImage, list: usize, falloff: bool) -> impl Iterator<Item = &Opcode> {
    raw.metadata.opcodes[list].iter().filter(move |opcode| falloff || !opcode.is_of_falloff())
}

/// Layout of the linear signal.
pub(super) fn frame(raw: &RawImage) -> Frame {
    Frame {
        size: [raw.width, raw.height],
        samples: raw.cfa.samples_per_pixel(),
        plane: 0,
        aspect: raw.metadata.pixel_aspect(),
        is_stored: false,
    }
}

/// OpcodeList1: stored values, masked pixels included, rounded to whole ones after all of them.
pub(super) fn on_stored(raw: &RawImage, falloff: bool) -> Cow<'_, RawImage> {
    if opcodes(raw, 0, falloff).next().is_none() {
        return Cow::Borrowed(raw);
    }
    let mut values: Vec<f32> = raw.data.iter().map(|&dn| dn.into()).collect();
    let frame = Frame { is_stored: true, ..frame(raw) };
    for opcode in opcodes(raw, 0, falloff) {
        let is_bad: Vec<bool> = match opcode {
            Opcode::FixBadPixelsConstant(constant) => {
                values.iter().map(|value| f64::from(*value) == f64::from(*constant)).collect()
            }
            Opcode::FixBadPixelsList(areas) => are_in(areas, frame.size),
            Opcode::FixVignetteRadial { .. }
            | Opcode::MapTable(..)
            | Opcode::MapPolynomial(..)
            | Opcode::GainMap(_)
            | Opcode::PerLine(..) => {
                opcode.apply(&mut values, &frame);
                continue;
            }
        };
        defects::replace(&mut values, frame.size, &raw.cfa, &is_bad);
    }
    Cow::Owned(raw.with_data(values.into_iter().map(|value| value.round() as u16).collect()))
}

/// Mask of the pixels that lie in one of these areas.
fn are_in(areas: &[PixelArea], [width, height]: [usize; 2]) -> Vec<bool> {
    let mut found = vec![false; width * height];
    for area in areas {
        for y in area.y.min(height)..(area.y + area.height).min(height) {
            found[y * width..][area.x.min(width)..(area.x + area.width).min(width)].fill(true);
        }
    }
    found
}

/// OpcodeList2: a signal of 0 for no light and 1 for saturation. What a gain brightens may go beyond 1, so that
/// highlights are clipped alike over the image.
pub(super) fn on_signal(signal: &mut [f32], raw: &RawImage, falloff: bool) {
    opcodes(raw, 1, falloff).for_each(|opcode| opcode.apply(signal, &frame(raw)));
}

/// OpcodeList3: the planes of the camera's channels, which the white balance has divided by `neutral`.
pub(super) fn on_planes(image: &mut Planes, raw: &RawImage, neutral: &[f64], falloff: bool) {
    if opcodes(raw, 2, falloff).next().is_none() {
        return;
    }
    for (plane, channel) in image.channels_mut().iter_mut().enumerate() {
        let frame = Frame { samples: 1, plane, ..frame(raw) };
        let balance = neutral.get(plane).copied().unwrap_or(1.0) as f32;
        channel.data.iter_mut().for_each(|value| *value *= balance);
        opcodes(raw, 2, falloff).for_each(|opcode| opcode.apply(&mut channel.data, &frame));
        channel.data.iter_mut().for_each(|value| *value /= balance);
    }
}
