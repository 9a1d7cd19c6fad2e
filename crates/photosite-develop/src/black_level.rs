//! Black level: digital numbers become a signal of 0 for no light and 1 for saturation.

use photosite_core::rows::for_each_row;

use photosite_raw::RawImage;

/// x = (DN − black)/(white − black) for every number; black is 0 where it is not to be subtracted.
/// Noise below black stays negative.
pub(super) fn subtract(raw: &RawImage, subtract: bool) -> Vec<f32> {
    let mut signal = vec![0.0; raw.data.len()];
    let row_length = raw.row_length().max(1);
    let uniform = if subtract { raw.black_level_dn.as_uniform() } else { Some(0.0) };
    // Of the same white level for all, too.
    let uniform = uniform.filter(|_| raw.channel_whites_dn.is_none());
    for_each_row(&mut signal, row_length, |y, signal| match uniform {
        Some(black) => {
            let factor = factor(raw.white_level_dn, black);
            for (signal, &dn) in signal.iter_mut().zip(&raw.data[y * row_length..]) {
                *signal = (f32::from(dn) - black) * factor;
            }
        }
        None => {
            for (x, (signal, &dn)) in signal.iter_mut().zip(&raw.data[y * row_length..]).enumerate() {
                let (black, factor) = scale(raw, subtract, [x, y]);
                *signal = (f32::from(dn) - black) * factor;
            }
        }
    });
    signal
}

/// Black level of the x-th number of row y, DN, and 1/(white − black).
#[inline]
pub(super) fn scale(raw: &RawImage, subtract: bool, [x, y]: [usize; 2]) -> (f32, f32) {
    let black = if subtract { raw.black_level_dn.at(x, y) } else { 0.0 };
    (black, factor(raw.white_of(raw.cfa.channel_at(x, y)), black))
}

/// 1/(white − black), of one step at least.
#[inline]
fn factor(white: u16, black: f32) -> f32 {
    1.0 / (f32::from(white) - black).max(1.0)
}
