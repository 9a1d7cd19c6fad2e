//! Codes of a file: values are rounded to whole numbers and clipped, and the clipped ones counted.

use serde::Serialize;

use photosite_core::image::Planes;

/// Number of values that were clipped to the ends of a file's range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Clipped {
    /// Below 0.
    pub low: u64,
    /// Above the largest.
    pub high: u64,
    /// Number of all values.
    pub values: u64,
}

/// Rounds all values to whole numbers from 0 to `largest`. Those that would round to another count as clipped.
pub fn round_to_codes(planes: &mut Planes, largest: f64) -> Clipped {
    let mut clipped = Clipped::default();
    for value in planes.channels_mut().iter_mut().flat_map(|channel| &mut channel.data) {
        let rounded = f64::from(*value).round();
        clipped.values += 1;
        clipped.low += u64::from(rounded < 0.0);
        clipped.high += u64::from(rounded > largest);
        *value = rounded.clamp(0.0, largest) as f32;
    }
    clipped
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::image::Channel;

    #[test]
    fn what_rounds_beyond_the_ends_is_counted() {
        let data = vec![-0.6, -0.4, 0.4, 254.6, 255.4, 255.6, f32::INFINITY, f32::NEG_INFINITY];
        let mut planes = Planes::new(8, 1, vec![Channel { name: "Y".to_owned(), data }]).expect("right size");
        assert_eq!(round_to_codes(&mut planes, 255.0), Clipped { low: 2, high: 2, values: 8 });
        assert_eq!(planes.channels()[0].data, [0.0, 0.0, 0.0, 255.0, 255.0, 255.0, 255.0, 0.0]);
    }
}
