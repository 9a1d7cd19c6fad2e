//! Neighbours of the same channel: for every place of a filter array's tile, where the nearest pixels of each channel
//! lie. Steps that work on any filter array are written in terms of these.

use photosite_raw::Cfa;

/// A step to a neighbour, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Step {
    pub(super) dx: isize,
    pub(super) dy: isize,
}

impl Step {
    /// Squared distance.
    fn square(self) -> isize {
        self.dx * self.dx + self.dy * self.dy
    }

    /// The pixel that the step leads to, where it lies in the image.
    #[inline]
    pub(super) fn from(self, x: usize, y: usize, [width, height]: [usize; 2]) -> Option<(usize, usize)> {
        let (x, y) = (x.checked_add_signed(self.dx)?, y.checked_add_signed(self.dy)?);
        (x < width && y < height).then_some((x, y))
    }
}

/// Steps from a place of the tile to the pixels of a channel, the pixel itself included, within a square of this
/// radius, nearest first; among equally near ones from the top, then from the left.
pub(super) fn steps(cfa: &Cfa, [x, y]: [usize; 2], channel: usize, radius: usize) -> Vec<Step> {
    let (columns, rows) = cfa.tile_size();
    let r = radius as isize;
    let all = (-r..=r).flat_map(|dy| (-r..=r).map(move |dx| Step { dx, dy }));
    let sees = |step: &Step| {
        let column = (x as isize + step.dx).rem_euclid(columns as isize) as usize;
        let row = (y as isize + step.dy).rem_euclid(rows as isize) as usize;
        cfa.channel_at(column, row) == channel
    };
    let mut steps: Vec<Step> = all.filter(sees).collect();
    steps.sort_by_key(|step| step.square());
    steps
}

/// The smallest radius at which a square around every pixel holds at least one pixel of every channel.
pub(super) fn radius_for_all(cfa: &Cfa) -> usize {
    let (columns, rows) = cfa.tile_size();
    let complete = |radius: usize| {
        let sees_all = |i: usize| {
            let place = [i % columns, i / columns];
            (0..cfa.channels().len()).all(|channel| !steps(cfa, place, channel, radius).is_empty())
        };
        (0..columns * rows).all(sees_all)
    };
    // A whole tile holds every channel.
    (0..columns.max(rows)).find(|&radius| complete(radius)).unwrap_or(columns.max(rows))
}

/// The channel that most pixels see; the second of two equals, which is green among R, G and B.
pub(super) fn densest(cfa: &Cfa) -> usize {
    let (columns, rows) = cfa.tile_size();
    let count =
        |channel: usize| (0..columns * rows).filter(|i| cfa.channel_at(i % columns, i / columns) == channel).count();
    let counts: Vec<usize> = (0..cfa.channels().len()).map(count).collect();
    let most = counts.iter().copied().max().unwrap_or(0);
    let green = cfa.channels().iter().position(|name| name == "G").filter(|&green| counts[green] == most);
    green.or_else(|| counts.iter().position(|&count| count == most)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bayer_and_x_trans() {
        let bayer = Cfa::parse("RGGB").expect("known");
        assert_eq!((radius_for_all(&bayer), densest(&bayer)), (1, 1));
        let reds = steps(&bayer, [1, 1], 0, 1);
        assert_eq!(reds.len(), 4);
        assert_eq!(reds[0], Step { dx: -1, dy: -1 });
        let x_trans = Cfa::parse("x-trans").expect("known");
        assert_eq!((radius_for_all(&x_trans), densest(&x_trans)), (1, 1), "every 3 × 3 pixels have all three");
        assert_eq!(steps(&x_trans, [0, 0], 1, 0), [Step { dx: 0, dy: 0 }], "its top left is green");
        assert_eq!(Step { dx: -1, dy: 0 }.from(0, 3, [4, 4]), None);
        assert_eq!(Step { dx: 1, dy: -3 }.from(0, 3, [4, 4]), Some((1, 0)));
    }
}
