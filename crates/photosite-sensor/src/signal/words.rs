//! Words: numbers of 32 bits, by which stages tell a graphics card what they need. A struct of words is declared once,
//! for Rust and for WGSL; lists that differ in length stand in [`Tables`], at the place that a word names.

/// Word that stands for no list.
pub(crate) const NONE: u32 = u32::MAX;

/// Value that is one word or several.
pub(crate) trait Words {
    /// Appends the words.
    fn append_to(&self, words: &mut Vec<u32>);
}

impl Words for u32 {
    fn append_to(&self, words: &mut Vec<u32>) {
        words.push(*self);
    }
}

impl Words for i32 {
    fn append_to(&self, words: &mut Vec<u32>) {
        words.push(*self as u32);
    }
}

impl Words for f32 {
    fn append_to(&self, words: &mut Vec<u32>) {
        words.push(self.to_bits());
    }
}

/// Declares structs of words: in Rust, and as WGSL under the same names.
macro_rules! words {
    ($($(#[$doc:meta])* $name:ident { $($(#[$of_field:meta])* $field:ident: $kind:ident,)+ })+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default)]
        pub(crate) struct $name {
            $($(#[$of_field])* pub(crate) $field: $kind,)+
        }

        impl $name {
            /// Declaration of the struct in WGSL.
            pub(crate) const WGSL: &str = concat!(
                "struct ", stringify!($name), " {\n",
                $("    ", stringify!($field), ": ", stringify!($kind), ",\n",)+
                "}\n"
            );
        }

        impl $crate::signal::words::Words for $name {
            fn append_to(&self, words: &mut Vec<u32>) {
                $($crate::signal::words::Words::append_to(&self.$field, words);)+
            }
        }
    )+};
}
pub(crate) use words;

words! {
    /// Number of 0 or more with 64 significant bits: (high·2³² + low)·2^(exponent − 64), whose highest bit is set
    /// unless it is 0.
    Wide {
        high: u32,
        low: u32,
        exponent: i32,
    }

    /// Streams of random numbers of the pixels.
    StreamWords {
        /// 1 where a stage draws from them, else 0.
        is_there: u32,
        key_low: u32,
        key_high: u32,
        row_mask: u32,
    }

    /// Noise that is normally distributed, new in each pixel.
    NormalWords {
        streams: StreamWords,
        standard_deviation_e: f32,
    }

    /// Factors of pixels that are distributed log-normally, exp(scale·n − shift) with n standard normal.
    LogNormalWords {
        streams: StreamWords,
        scale: Wide,
        shift: Wide,
    }
}

impl Wide {
    /// The number that an f64 holds: finite, 0 or more. What is below its normal range is 0.
    pub(crate) fn new(number: f64) -> Self {
        const FRACTION: u32 = f64::MANTISSA_DIGITS - 1;
        let bits = number.to_bits();
        let exponent = (bits >> FRACTION) as i32;
        if exponent == 0 {
            return Self::default();
        }
        let significand = (bits | 1 << FRACTION) << (63 - FRACTION);
        // A fraction of 1/2 and more, and below 1
        let exponent = exponent - (f64::MAX_EXP - 2);
        Self { high: (significand >> 32) as u32, low: significand as u32, exponent }
    }
}

/// Lists of words, one after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tables(Vec<u32>);

impl Tables {
    /// Adds a list, and returns the place of its first word.
    pub(crate) fn add(&mut self, list: impl IntoIterator<Item = u32>) -> u32 {
        let place = self.0.len() as u32;
        self.0.extend(list);
        place
    }

    /// Adds numbers, and returns the place of the first; [`NONE`] without any.
    pub(crate) fn add_numbers(&mut self, numbers: &[f32]) -> u32 {
        if numbers.is_empty() { NONE } else { self.add(numbers.iter().map(|number| number.to_bits())) }
    }

    /// Adds what `of_row` has for some pixels of each row, by rising columns: for each row and the end the place of
    /// its first pixel, then column and word of each pixel. [`NONE`] where no row has any.
    pub(crate) fn add_pixels<I>(&mut self, rows: usize, of_row: impl Fn(usize) -> I) -> u32
    where
        I: Iterator<Item = (usize, u32)>,
    {
        let place = self.0.len();
        let first = place + rows + 1;
        let (mut starts, mut pixels) = (Vec::with_capacity(rows + 1), Vec::new());
        for y in 0..rows {
            starts.push((first + pixels.len()) as u32);
            pixels.extend(of_row(y).flat_map(|(x, word)| [x as u32, word]));
        }
        starts.push((first + pixels.len()) as u32);
        if pixels.is_empty() {
            return NONE;
        }
        self.add(starts.into_iter().chain(pixels))
    }

    /// The words of all lists.
    pub(crate) fn into_words(self) -> Vec<u32> {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_numbers_are_those_of_f64() {
        for number in [1.0, 0.5, 12.0, 0.1, 1e-300, 1.8e19, f64::MAX, f64::MIN_POSITIVE] {
            let Wide { high, low, exponent } = Wide::new(number);
            assert!(high >> 31 == 1, "{number}");
            let significand = (f64::from(high) * 4_294_967_296.0 + f64::from(low)) / 2f64.powi(64);
            // In two steps, since 2^1024 is no f64
            assert_eq!(significand * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2), number);
        }
        assert_eq!(Wide::new(0.0).high, 0);
    }

    #[test]
    fn pixels_of_a_row_lie_between_its_places() {
        let mut tables = Tables::default();
        assert_eq!(tables.add([7]), 0);
        assert_eq!(tables.add_pixels(2, |_| std::iter::empty()), NONE);
        let place = tables.add_pixels(3, |y| (0..y).map(move |x| (x, (10 * y) as u32)));
        assert_eq!((place, tables.into_words()), (1, vec![7, 5, 5, 7, 11, 0, 10, 0, 20, 1, 20]));
    }
}
