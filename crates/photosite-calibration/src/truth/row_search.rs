//! Search for the row of an image that sees a point while one of both moves: rows see at times of their own, so that
//! where the point appears depends on the row, and the row on where it appears.
//!
//! In: how far the point is from a row, and where it appears, at the time of the row. Out: the place at which it is in
//! the row of that time. What is asked of must be smooth to double precision; where it is not quite, halving intervals
//! still ends at the place to which it can be told.

use glam::DVec2;

/// Sighting of a point that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sighting {
    /// Place of the point, continuous pixel coordinates.
    At(DVec2),
    /// No place: the lens shows the point at the time of no row.
    Unseen,
    /// No row: the lens shows the point, but no row at its own time was found: the point runs ahead of the rows, or
    /// comes into sight between them.
    InNoRow,
}

/// Miss of a row at its time: the number of rows that the point is too far below, and the pixel coordinates of its
/// place.
pub(super) type Miss = (f64, DVec2);

/// Largest miss that ends a search, px: coordinates of some 10⁴ px have roundings of 1e-12.
const NEAR: f64 = 1e-9;

/// Steps of secants. Where a point moves by a small part of a row in a row's time, three or four are enough.
const SECANTS: usize = 12;

/// Number of rows of the image that are looked at where secants lead nowhere.
const LOOKS: u32 = 128;

/// Doublings of the distance beyond the image: rows are looked at up to 2 to this power of its height away.
const DOUBLINGS: i32 = 20;

/// Finds the row, from a step of secants whose second row is `second` of the first one's [`Miss`].
pub(super) fn row_that_sees(
    rows: f64,
    second: impl Fn(f64, f64) -> f64,
    miss_at: impl Fn(f64) -> Option<Miss>,
) -> Sighting {
    match by_secants(rows / 2.0, second, &miss_at) {
        Some(place) => Sighting::At(place),
        None => by_halving(rows, miss_at),
    }
}

fn by_secants(first: f64, second: impl Fn(f64, f64) -> f64, miss_at: &impl Fn(f64) -> Option<Miss>) -> Option<DVec2> {
    let (mut before, (mut missed_before, place)) = (first, miss_at(first)?);
    if missed_before.abs() <= NEAR {
        return Some(place);
    }
    let mut row = second(before, missed_before);
    for _ in 0..SECANTS {
        let (missed, place) = miss_at(row)?;
        if missed.abs() <= NEAR {
            return Some(place);
        }
        let next = row - missed * (row - before) / (missed - missed_before);
        if !next.is_finite() {
            return None;
        }
        (before, missed_before, row) = (row, missed, next);
    }
    None
}

/// Finds two rows of which one is above the point and the other below, the nearest to the middle of the image.
fn by_halving(rows: f64, miss_at: impl Fn(f64) -> Option<Miss>) -> Sighting {
    let missed = |row: f64| miss_at(row).map(|(missed, _)| missed);
    let beyond = |power: i32| rows * 2f64.powi(power);
    let above = (0..=DOUBLINGS).rev().map(|power| -beyond(power));
    let within = (0..=LOOKS).map(|look| rows * f64::from(look) / f64::from(LOOKS));
    let below = (0..=DOUBLINGS).map(|power| rows + beyond(power));
    let looks: Vec<(f64, Option<f64>)> = above.chain(within).chain(below).map(|row| (row, missed(row))).collect();
    let brackets = looks.windows(2).filter_map(|pair| bracket([pair[0], pair[1]], missed));
    let off = |[a, b]: &[f64; 2]| (a + b - rows).abs();
    match brackets.min_by(|a, b| off(a).total_cmp(&off(b))).and_then(|rows| halved(rows, &miss_at)) {
        Some(place) => Sighting::At(place),
        None if looks.iter().all(|(_, missed)| missed.is_none()) => Sighting::Unseen,
        None => Sighting::InNoRow,
    }
}

/// Two rows that see the point, and between which it passes from below to above, or the other way.
fn bracket([(a, at_a), (b, at_b)]: [(f64, Option<f64>); 2], missed: impl Fn(f64) -> Option<f64>) -> Option<[f64; 2]> {
    let (seen, unseen) = match (at_a, at_b) {
        (Some(at_a), Some(at_b)) => return (at_a.signum() != at_b.signum()).then_some([a, b]),
        (Some(_), None) => (a, b),
        (None, Some(_)) => (b, a),
        (None, None) => return None,
    };
    // Up to where it comes into sight.
    let is_seen = |row: f64| missed(row).is_some();
    let [edge, _] = narrowed([seen, unseen], is_seen);
    (missed(seen)?.signum() != missed(edge)?.signum()).then_some([seen, edge])
}

fn halved([a, b]: [f64; 2], miss_at: &impl Fn(f64) -> Option<Miss>) -> Option<DVec2> {
    let sign = miss_at(a)?.0.signum();
    let [row, _] = narrowed([a, b], |row| miss_at(row).is_some_and(|(missed, _)| missed.signum() == sign));
    miss_at(row).map(|(_, place)| place)
}

/// Narrows two rows until they are neighbouring numbers, of which the first is like `a` and the second like `b`.
fn narrowed([mut a, mut b]: [f64; 2], is_like_a: impl Fn(f64) -> bool) -> [f64; 2] {
    loop {
        let middle = a + (b - a) / 2.0;
        if middle == a || middle == b {
            return [a, b];
        }
        if is_like_a(middle) { a = middle } else { b = middle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: f64 = 100.0;

    fn sought(y_at_row: impl Fn(f64) -> Option<f64>) -> Sighting {
        let miss_at = |row: f64| y_at_row(row).map(|y| (y - 0.5 - row, DVec2::new(3.0, y)));
        row_that_sees(ROWS, |row, missed| row + missed, miss_at)
    }

    /// Case: y = a + s·row, and y = row + ½: row = (a − ½)/(1 − s).
    #[test]
    fn what_moves_evenly_is_where_the_equation_says() {
        for speed in [-3.0, -0.9, -0.1, 0.0, 0.3, 0.99, 2.0] {
            for start in [-40.0, 10.5, 70.0, 300.0] {
                let expected = (start - 0.5) / (1.0 - speed) + 0.5;
                let Sighting::At(found) = sought(|row| Some(start + speed * row)) else { panic!("{speed} {start}") };
                assert!((found.y - expected).abs() < 1e-8, "{speed} {start}: {found}, not {expected}");
            }
        }
    }

    /// Case: single precision, in which an iteration towards 1e-9 px goes round in circles.
    #[test]
    fn roundings_do_not_hide_a_point() {
        for i in 0..200 {
            let start = 10.0 + 0.4 * f64::from(i);
            let rounded = |row: f64| Some(f64::from((start + 0.2 * row) as f32));
            let Sighting::At(found) = sought(rounded) else { panic!("{start}") };
            let expected = (start - 0.5) / 0.8 + 0.5;
            assert!((found.y - expected).abs() < 128.0 * f64::from(f32::EPSILON), "{start}: {found}, not {expected}");
        }
    }

    #[test]
    fn what_comes_into_sight_is_found_and_what_does_not_is_told_apart() {
        // Out of sight at the time of the middle row, and not at that of its own.
        let late = sought(|row| (row > 80.0).then_some(90.0 + 0.1 * row));
        assert!(matches!(late, Sighting::At(found) if (found.y - (89.5 / 0.9 + 0.5)).abs() < 1e-8), "{late:?}");
        assert_eq!(sought(|_| None), Sighting::Unseen);
        // As fast as the rows, and always below.
        assert_eq!(sought(|row| Some(row + 20.0)), Sighting::InNoRow);
    }
}
