//! Comparison of images that were developed on a card with the processor's.
//!
//! A code is right where it is that of a value within e of the processor's linear one. With u = 2⁻²⁴, the rounding of a
//! sum or product in single precision, and values of up to M, that bound follows from the steps: a step of the signal
//! has 10 operations, so that it is within s = 10uM. Values of methods whose weights have sums w of magnitudes, with n
//! operations on values of up to M, are within w·s + n·uM:
//!
//! | method | w | n |
//! |---|---|---|
//! | none | 1 | 0 |
//! | bilinear | 1 | 8 |
//! | Malvar | 2.5 | 20 |
//! | Menon | 9 | 55 |
//!
//! For Menon's these are found step by step: green is within 10uM + 2s after the first pass, chroma beside it within
//! 15uM + 3s, the other colour within 35uM + 7s; green after the second within 21uM + 3.5s, chroma within 26uM + 4.5s
//! and the other colour within 55uM + 9s. The matrix multiplies that by the largest sum S of magnitudes in a row and
//! adds 5uS·M, filmic's curve by its slope, which is below 2, and grey adds 3u. The processor's own value has as much.
//!
//! Menon's method goes along rows where differences of colour change no more along them than along columns. Each sum of
//! changes has 12 with weights up to 3, 18 in all, of differences within 10uM + 2s: it is within 18·2·30uM and some
//! 170uM of its own. Where both sums are nearer than that on both machines, the other direction may be chosen, which
//! changes pixels up to 5 away.

use photosite_core::Invalid;
use photosite_develop::packed::{Demosaicking, Line, PackedDevelopment};
use photosite_develop::{Codes, DevelopSettings, EncodedImage, develop, develop_linear};
use photosite_gpu::Card;
use photosite_raw::RawImage;

/// Rounding of an operation.
const U: f64 = 1.0 / 16_777_216.0;
/// Pixels around one that its direction changes.
const REACH: usize = 5;

/// Codes of an image that are not the processor's.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    /// All codes.
    pub(crate) codes: usize,
    /// Codes that are others.
    pub(crate) differing: usize,
    /// Codes of values that lie within the bound of a level, and may differ.
    pub(crate) near_levels: usize,
    /// Codes that differ by more, near pixels whose direction is a tie.
    pub(crate) by_ties: usize,
}

impl Tally {
    pub(crate) fn add(&mut self, other: Self) {
        self.codes += other.codes;
        self.differing += other.differing;
        self.near_levels += other.near_levels;
        self.by_ties += other.by_ties;
    }
}

fn codes(image: &EncodedImage) -> Vec<usize> {
    match &image.codes {
        Codes::U8(codes) => codes.iter().map(|code| usize::from(*code)).collect(),
        Codes::U16(codes) => codes.iter().map(|code| usize::from(*code)).collect(),
    }
}

/// Develops an image on a card, twice, and compares it with the processor's; the refusal of what a card does not have.
pub(crate) fn compare(card: &Card, name: &str, raw: &RawImage, settings: &DevelopSettings) -> Result<Tally, Invalid> {
    let packed = PackedDevelopment::new(raw, settings)?;
    let [found, again] = [0, 1].map(|_| card.develop(raw, &packed).unwrap_or_else(|error| panic!("{name}: {error}")));
    assert!(found == again, "{name}: another time other bytes");
    Ok(check(name, raw, settings, &packed, &found))
}

/// Compares an image with the processor's.
pub(crate) fn check(
    name: &str,
    raw: &RawImage,
    settings: &DevelopSettings,
    packed: &PackedDevelopment,
    found: &EncodedImage,
) -> Tally {
    let expected = develop(raw, settings).unwrap_or_else(|error| panic!("{name}: {error}"));
    let facts = |image: &EncodedImage| {
        (image.width, image.height, image.components, image.colour_space, image.transfer, image.pixel_aspect)
    };
    assert_eq!(facts(found), facts(&expected), "{name}");
    let (linear, _) = develop_linear(raw, settings).unwrap_or_else(|error| panic!("{name}: {error}"));
    let signal = signal(raw, packed);
    let bound = bound(packed, signal.iter().fold(1.0, |most, value| value.abs().max(most)));
    let code = |value: f64| packed.levels.partition_point(|level| f64::from(*level) <= value);
    let (found, expected) = (codes(found), codes(&expected));
    assert_eq!(found.len(), expected.len(), "{name}");

    let mut tally = Tally { codes: found.len(), ..Tally::default() };
    let mut ties = None;
    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let (pixel, component) = (i / packed.components(), i % packed.components());
        let value = f64::from(linear.channels()[component].data[pixel]);
        let within = code(value - bound)..=code(value + bound);
        assert!(within.contains(expected), "{name}: {value} is {expected}, not in {within:?}");
        tally.near_levels += usize::from(within.start() != within.end());
        tally.differing += usize::from(found != expected);
        if !within.contains(found) {
            let ties = ties.get_or_insert_with(|| ties_near(packed, &signal));
            let place = [pixel % linear.width(), pixel / linear.width()];
            let [x, y] = packed.orientation.source(place, [packed.shown.width, packed.shown.height]);
            let at = (y + packed.shown.y) * packed.active.width + x + packed.shown.x;
            assert!(ties[at], "{name}: {found} for {expected} of {value} ± {bound} at {x}, {y}, component {component}");
            tally.by_ties += 1;
        }
    }
    tally
}

/// Bound of the differences of linear values; see the module.
fn bound(packed: &PackedDevelopment, largest: f64) -> f64 {
    let [weights, operations] = match packed.demosaicking {
        Demosaicking::Apart => [1.0, 0.0],
        Demosaicking::Bilinear(_) => [1.0, 8.0],
        Demosaicking::Malvar => [2.5, 20.0],
        Demosaicking::Menon { .. } => [9.0, 55.0],
    };
    let camera = (weights * 10.0 + operations) * U * largest;
    let row = |component: usize| packed.colour.iter().map(|column| f64::from(column[component].abs())).sum::<f64>();
    let sum = [0, 1, 2].map(row).into_iter().fold(0.0, f64::max);
    let light = sum * (camera + 5.0 * U * largest);
    let shown = if packed.is_filmic { 2.0 * light + 5.0 * U } else { light };
    2.0 * (shown + 3.0 * U)
}

/// White-balanced values of the active area in double precision.
fn signal(raw: &RawImage, packed: &PackedDevelopment) -> Vec<f64> {
    let row_length = packed.active.width * packed.samples;
    let tile_rows = packed.places.len() / packed.tile_columns;
    let value = |i: usize| {
        let [number, row] = [i % row_length, i / row_length];
        let stored = (packed.active.y + row) * raw.row_length() + packed.active.x * packed.samples + number;
        let stored = usize::from(raw.data[stored]);
        let dn = match &packed.linearisation[..] {
            [] => stored as f64,
            table => f64::from(table[stored.min(table.len() - 1)]),
        };
        let place = &packed.places[row % tile_rows * packed.tile_columns + number % packed.tile_columns];
        let mut value = (dn - f64::from(place.black)) * f64::from(place.factor);
        for map in &packed.gain_maps {
            if let (Some(across), Some(down)) = (&map.across[number], &map.down[row]) {
                let mix = |line: &Line, of: &dyn Fn(usize) -> f64| {
                    let [a, b] = line.indices.map(of);
                    a + (b - a) * f64::from(line.part)
                };
                value *= mix(down, &|below| mix(across, &|right| f64::from(map.gains[below + right])));
            }
        }
        (value * f64::from(place.balance)).min(packed.ceiling.into())
    };
    (0..row_length * packed.active.height).map(value).collect()
}

/// Whether each pixel of the active area lies near one for which both directions are equally smooth but for rounding.
fn ties_near(packed: &PackedDevelopment, signal: &[f64]) -> Vec<bool> {
    let (width, height) = (packed.active.width, packed.active.height);
    let mut near = vec![false; width * height];
    let Demosaicking::Menon { red } = packed.demosaicking else { return near };
    let ties = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    // A pixel is coloured where both parities are red's, or neither is
    let ties = ties.filter(|&[x, y]| (y % 2 == red[0]) == (x % 2 == red[1]) && is_tie(signal, [width, height], [x, y]));
    for [x, y] in ties.collect::<Vec<_>>() {
        for row in y.saturating_sub(REACH)..(y + REACH + 1).min(height) {
            near[row * width..][x.saturating_sub(REACH)..(x + REACH + 1).min(width)].fill(true);
        }
    }
    near
}

/// The pixel of a line of `n` after reflection at its ends.
fn mirrored(i: isize, n: usize) -> usize {
    let period = (2 * (n as isize - 1)).max(1);
    let i = i.rem_euclid(period);
    if n == 1 { 0 } else { i.min(period - i) as usize }
}

/// Whether the sums of changes along the row and the column of a coloured pixel are equal but for rounding.
fn is_tie(signal: &[f64], [width, height]: [usize; 2], [x, y]: [usize; 2]) -> bool {
    let mut largest: f64 = 0.0;
    let mut roughness = |across: bool| {
        let mut at = |along: isize, beside: isize| {
            let [dx, dy] = if across { [along, beside] } else { [beside, along] };
            let value = signal[mirrored(y as isize + dy, height) * width + mirrored(x as isize + dx, width)];
            largest = largest.max(value.abs());
            value
        };
        let mut difference = |along: isize, beside: isize| {
            let mut at = |step: isize| at(along + step, beside);
            at(0) - (0.5 * (at(-1) + at(1)) + 0.25 * (2.0 * at(0) - at(-2) - at(2)))
        };
        let mut change = |from: isize, beside: isize| (difference(from, beside) - difference(from + 2, beside)).abs();
        3.0 * (change(-2, 0) + change(0, 0))
            + change(-2, -2)
            + change(0, -2)
            + change(-2, 2)
            + change(0, 2)
            + change(-1, -1)
            + change(-1, 1)
    };
    let [along_row, along_column] = [true, false].map(&mut roughness);
    let error = (18.0 * 2.0 * 30.0 + 170.0) * U * largest;
    (along_row - along_column).abs() <= 2.0 * error
}
