//! Impulses: pixels that arrive as white (salt) or black (pepper), whatever they were.

use rand::RngExt;

use super::description::SaltAndPepper;
use super::streams::Streams;

impl SaltAndPepper {
    /// Impulse at a pixel: `Some(true)` for white, `Some(false)` for black, `None` where it keeps its value.
    pub(super) fn at(&self, streams: Streams, x: usize, y: usize) -> Option<bool> {
        let random = streams.pixel(x as i32, y as i32).random::<f64>();
        (random < self.part).then_some(random < self.part * self.salt)
    }
}

#[cfg(test)]
mod tests {
    use super::super::streams::Kind;
    use super::*;

    #[test]
    fn shares_are_those_asked_for() {
        let noise = SaltAndPepper { part: 0.08, salt: 0.25 };
        let streams = Streams::new(1, Kind::SaltAndPepper, 0);
        let n = 400 * 300;
        let mut counts = [0.0; 2];
        for i in 0..n {
            if let Some(salt) = noise.at(streams, i % 400, i / 400) {
                counts[usize::from(salt)] += 1.0;
            }
        }
        for (count, part) in counts.into_iter().zip([0.06, 0.02]) {
            // Binomial; 5 standard deviations.
            let (n, within) = (n as f64, 5.0 * (n as f64 * part * (1.0 - part)).sqrt());
            assert!((count - n * part).abs() < within, "{count} for {part}");
        }
        let all = SaltAndPepper { part: 1.0, salt: 1.0 };
        assert!((0..1000).all(|x| all.at(streams, x, 0) == Some(true)));
    }
}
