//! Numbers as 16-bit grey PNG in memory, which readers of pictures give back as they are.

use std::io;

use crate::image::Planes;
use crate::io::plain_png::write_grey16;
use crate::raw::RawImage;

/// Smallest step of depth, m.
const FINEST_M: f64 = 1e-4;
/// The largest number of 16 bits.
const LARGEST: f64 = u16::MAX as f64;

/// A mosaic, or the numbers of a monochrome sensor. `None` where each pixel has several.
pub(super) fn raw_png(raw: &RawImage) -> io::Result<Option<Vec<u8>>> {
    (raw.cfa.samples_per_pixel() == 1).then(|| png([raw.width, raw.height], &raw.data)).transpose()
}

/// Depth in whole steps, of which 0 is nothing, and the step, m: 0.1 mm or the smallest power of ten times that which 16
/// bits can hold.
pub(super) fn depth_png(depth: &Planes) -> io::Result<(Vec<u8>, f64)> {
    let values = depth.plane("depth").unwrap_or_default();
    let largest = values.iter().filter(|m| m.is_finite()).fold(0.0_f64, |largest, &m| largest.max(f64::from(m)));
    let mut power = 0;
    while (largest / step(power)).round() > LARGEST {
        power += 1;
    }
    let step = step(power);
    // What is there is never nothing.
    let code = |&m: &f32| if m.is_finite() { (f64::from(m) / step).round().max(1.0) as u16 } else { 0 };
    let codes: Vec<u16> = values.iter().map(code).collect();
    Ok((png([depth.width(), depth.height()], &codes)?, step))
}

/// 10^power times the smallest step, as the number that is written so.
fn step(power: u32) -> f64 {
    10_f64.powi(power as i32) / (1.0 / FINEST_M)
}

/// Numbers of things; `None` where there are more of them than 16 bits tell apart.
pub(super) fn numbers_png(planes: &Planes, name: &str) -> io::Result<Option<Vec<u8>>> {
    let values = planes.plane(name).unwrap_or_default();
    if values.iter().any(|&value| f64::from(value) > LARGEST) {
        return Ok(None);
    }
    let codes: Vec<u16> = values.iter().map(|&value| value as u16).collect();
    png([planes.width(), planes.height()], &codes).map(Some)
}

fn png([width, height]: [usize; 2], values: &[u16]) -> io::Result<Vec<u8>> {
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let mut bytes = Vec::new();
    write_grey16([side(width)?, side(height)?], values, &mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Channel;

    fn depth(values: &[f32]) -> (Vec<u16>, f64) {
        let channel = Channel { name: "depth".to_owned(), data: values.to_vec() };
        let planes = Planes::new(values.len(), 1, vec![channel]).expect("planes");
        let (png, step) = depth_png(&planes).expect("written");
        let picture = image::load_from_memory(&png).expect("a picture");
        (picture.into_luma16().into_raw(), step)
    }

    #[test]
    fn depth_is_in_the_finest_steps_that_hold_it() {
        assert_eq!(depth(&[1.5, f32::INFINITY, 1e-6]), (vec![15_000, 0, 1], 1e-4));
        assert_eq!(depth(&[6.5535, 0.0]), (vec![65_535, 1], 1e-4));
        assert_eq!(depth(&[6.6]), (vec![6_600], 1e-3));
        assert_eq!(depth(&[f32::INFINITY]), (vec![0], 1e-4));
        assert_eq!(depth(&[4000.0]), (vec![40_000], 1e-1));
    }
}
