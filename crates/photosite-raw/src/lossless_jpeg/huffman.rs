//! Huffman codes of the 17 categories of differences.

/// Differences have 0 to 16 bits.
pub(super) const CATEGORIES: usize = 17;
/// Most bits of a code.
const LONGEST: usize = 16;

/// A code as files state it: how many codes there are of 1–16 bits, and what they stand for, shortest first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Table {
    pub(super) counts: [u8; LONGEST],
    pub(super) symbols: Vec<u8>,
}

impl Table {
    /// The best code for categories that occur so often ([T81](photosite_core::references#t81), annex K.2).
    pub(super) fn for_counts(occurrences: &[u64; CATEGORIES]) -> Self {
        // One more category takes the code of ones only, which must not occur.
        let mut weights: Vec<u64> = occurrences.iter().copied().chain([1]).collect();
        let mut lengths = [0usize; CATEGORIES + 1];
        let mut members: Vec<Vec<usize>> = (0..=CATEGORIES).map(|i| vec![i]).collect();
        loop {
            // The two lightest trees become one. Of equals the later: so the reserved category ends up deepest.
            let lightest = |but: Option<usize>| {
                let candidates = (0..weights.len()).rev().filter(|&i| weights[i] > 0 && Some(i) != but);
                candidates.min_by_key(|&i| weights[i])
            };
            let Some(first) = lightest(None) else { break };
            let Some(second) = lightest(Some(first)) else { break };
            let joined = std::mem::take(&mut members[first]);
            weights[second] += std::mem::take(&mut weights[first]);
            members[second].extend(joined);
            for &member in &members[second] {
                lengths[member] += 1;
            }
        }
        let mut counts = [0u8; CATEGORIES + 2];
        for &length in lengths.iter().filter(|&&length| length > 0) {
            counts[length] += 1;
        }
        // Codes that are too long: of a pair, one takes its parent's place, and the other shares a shorter code's.
        for length in (LONGEST + 1..counts.len()).rev() {
            while counts[length] > 0 {
                let shorter = (1..length - 1).rev().find(|&l| counts[l] > 0).unwrap_or(1);
                counts[length] -= 2;
                counts[length - 1] += 1;
                counts[shorter] -= 1;
                counts[shorter + 1] += 2;
            }
        }
        // The reserved category has one of the longest codes.
        if let Some(longest) = (1..=LONGEST).rev().find(|&l| counts[l] > 0) {
            counts[longest] -= 1;
        }
        let mut symbols: Vec<u8> = (0..CATEGORIES as u8).filter(|&s| occurrences[usize::from(s)] > 0).collect();
        symbols.sort_by_key(|&s| (lengths[usize::from(s)], s));
        Self { counts: std::array::from_fn(|i| counts[i + 1]), symbols }
    }

    /// Code and its length in bits for each category, (0, 0) where it has none (annex C).
    pub(super) fn codes(&self) -> [(u16, u32); CATEGORIES] {
        let mut codes = [(0, 0); CATEGORIES];
        let mut symbols = self.symbols.iter();
        let mut code = 0u32;
        for (i, &count) in self.counts.iter().enumerate() {
            for &symbol in symbols.by_ref().take(count.into()) {
                codes[usize::from(symbol)] = (code as u16, i as u32 + 1);
                code += 1;
            }
            code <<= 1;
        }
        codes
    }
}

/// A table for reading (annex F.2.2.3).
#[derive(Clone, Debug)]
pub(super) struct Reader {
    /// First code after those of each length, aligned to 16 bits.
    ends: [u32; LONGEST],
    /// First code of each length, with the index of its symbol.
    starts: [(u32, usize); LONGEST],
    symbols: Vec<u8>,
}

impl Reader {
    /// `None` where the counts are no code or a symbol is no category.
    pub(super) fn new(table: Table) -> Option<Self> {
        let total: usize = table.counts.iter().map(|&count| usize::from(count)).sum();
        if total != table.symbols.len() || table.symbols.iter().any(|&s| usize::from(s) >= CATEGORIES) {
            return None;
        }
        let (mut ends, mut starts) = ([0; LONGEST], [(0, 0); LONGEST]);
        let (mut code, mut symbol) = (0u32, 0);
        for (i, &count) in table.counts.iter().enumerate() {
            starts[i] = (code, symbol);
            code += u32::from(count);
            symbol += usize::from(count);
            if code > 1 << (i + 1) {
                return None;
            }
            ends[i] = code << (LONGEST - 1 - i);
            code <<= 1;
        }
        Some(Self { ends, starts, symbols: table.symbols })
    }

    /// The category whose code the 16 bits begin with, and how many bits that has.
    #[inline]
    pub(super) fn find(&self, bits: u32) -> Option<(u32, u32)> {
        let i = self.ends.iter().position(|&end| bits < end)?;
        let (code, symbol) = self.starts[i];
        let symbol = symbol + ((bits >> (LONGEST - 1 - i)) - code) as usize;
        Some((u32::from(*self.symbols.get(symbol)?), i as u32 + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lengths(occurrences: &[u64; CATEGORIES]) -> [u32; CATEGORIES] {
        Table::for_counts(occurrences).codes().map(|(_, length)| length)
    }

    #[test]
    fn frequent_categories_have_short_codes() {
        let mut occurrences = [0; CATEGORIES];
        [occurrences[2], occurrences[5], occurrences[9]] = [100, 10, 1];
        let lengths = lengths(&occurrences);
        assert_eq!([lengths[2], lengths[5], lengths[9], lengths[0]], [1, 2, 3, 0]);
    }

    #[test]
    fn no_code_is_longer_than_16_bits_and_none_has_ones_only() {
        // Fibonacci numbers give the deepest tree.
        let mut fibonacci = [1u64; CATEGORIES];
        for i in 2..CATEGORIES {
            fibonacci[i] = fibonacci[i - 1] + fibonacci[i - 2];
        }
        for occurrences in [fibonacci, [1; CATEGORIES], std::array::from_fn(|i| 1 << (2 * i))] {
            let codes = Table::for_counts(&occurrences).codes();
            let mut kraft = 0.0;
            for (code, length) in codes {
                assert!((1..=16).contains(&length) && u32::from(code) != (1 << length) - 1, "{codes:?}");
                kraft += 0.5f64.powi(length as i32);
            }
            // What is missing to 1 is the reserved code.
            assert!(kraft < 1.0 && kraft >= 1.0 - 0.5f64.powi(4), "{kraft}");
        }
        assert_eq!(lengths(&std::array::from_fn(|i| u64::from(i == 3)))[3], 1);
    }

    #[test]
    fn codes_are_found_again() {
        let table = Table::for_counts(&std::array::from_fn(|i| 1 << i));
        let reader = Reader::new(table.clone()).expect("a code");
        for (category, (code, length)) in table.codes().into_iter().enumerate() {
            let bits = u32::from(code) << (16 - length);
            assert_eq!(reader.find(bits), Some((category as u32, length)));
        }
        assert_eq!(reader.find(0xffff), None);
        assert!(Reader::new(Table { counts: [3; 16], symbols: vec![0; 48] }).is_none(), "more codes than there are");
        assert!(Reader::new(Table { counts: [0; 16], symbols: vec![0] }).is_none());
    }
}
