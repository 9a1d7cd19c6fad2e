//! Selection of the frames that a process makes: lists of ranges, and shares of equal workers.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// List of frames by number: ranges and single ones, `0..4,9`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameList(Vec<Range<u32>>);

impl FrameList {
    /// List of these frame numbers, which are in order.
    pub fn of(numbers: &[u32]) -> Self {
        let mut ranges: Vec<Range<u32>> = Vec::new();
        for &number in numbers {
            match ranges.last_mut() {
                Some(last) if last.end == number => last.end = number.saturating_add(1),
                _ => ranges.push(number..number.saturating_add(1)),
            }
        }
        Self(ranges)
    }

    /// Whether the list is empty.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Ranges of the list.
    pub fn ranges(&self) -> impl Iterator<Item = &Range<u32>> {
        self.0.iter()
    }

    /// Complete list as it is read, however long it is.
    pub fn in_full(&self) -> String {
        let ranges = self.0.iter().map(|range| match range {
            Range { start, end } if end - start == 1 => start.to_string(),
            Range { start, end } => format!("{start}..{end}"),
        });
        ranges.collect::<Vec<_>>().join(",")
    }

    /// Frames of the list below `count`, each once and in order, and whether the list names more.
    pub fn among(&self, count: u32) -> (Vec<u32>, bool) {
        let numbers = self.0.iter().flat_map(|range| range.start..range.end.min(count)).collect();
        (in_order(numbers), self.0.iter().any(|range| range.end > count))
    }
}

/// Numbers, each once and in ascending order.
pub(super) fn in_order(mut numbers: Vec<u32>) -> Vec<u32> {
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

impl FromStr for FrameList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |part: &str| part.trim().parse::<u32>().ok().filter(|&number| number < u32::MAX);
        let item = |item: &str| {
            let range = match item.split_once("..") {
                Some((start, end)) => number(start).zip(number(end)).map(|(start, end)| start..end),
                None => number(item).map(|number| number..number + 1),
            };
            match range {
                Some(range) if range.is_empty() => {
                    Err(format!("{}: the first number must be below the second", item.trim()))
                }
                Some(range) => Ok(range),
                None => Err("write frames, for example 0..4,9".to_owned()),
            }
        };
        text.split(',').map(item).collect::<Result<_, _>>().map(Self)
    }
}

/// Prints the list as it is read; only the first of many ranges.
impl fmt::Display for FrameList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const MOST: usize = 8;
        let more = if self.0.len() > MOST { " and more" } else { "" };
        let first = Self(self.0.iter().take(MOST).cloned().collect());
        write!(f, "{}{more}", first.in_full())
    }
}

/// Shard: one of several equal workers. `3/8` makes every eighth frame from the third on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: usize,
    of: usize,
}

impl Shard {
    /// Frames of this worker.
    pub fn share(self, numbers: Vec<u32>) -> Vec<u32> {
        numbers.into_iter().skip(self.number - 1).step_by(self.of).collect()
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |part: &str| part.trim().parse::<u16>().ok().map(usize::from);
        match text.split_once('/').and_then(|(k, n)| Some((number(k)?, number(n)?))) {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            Some((_, of @ 1..)) => Err(format!("workers are counted from 1: write 1/{of} to {of}/{of}")),
            Some(_) | None => Err("write the number of this worker and how many there are, for example 3/8".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::*;

    #[rstest]
    #[case::one("7", 10, &[7], false)]
    #[case::a_range("0..3", 10, &[0, 1, 2], false)]
    #[case::both("0..4,9", 10, &[0, 1, 2, 3, 9], false)]
    #[case::out_of_order_and_twice("9, 2..4 ,3", 10, &[2, 3, 9], false)]
    #[case::past_the_end("8..12", 10, &[8, 9], true)]
    #[case::all_past_the_end("10..12", 10, &[], true)]
    fn lists_of_frames_are_read(
        #[case] text: &str,
        #[case] count: u32,
        #[case] numbers: &[u32],
        #[case] is_more: bool,
    ) {
        let list: FrameList = text.parse().expect("a list");
        assert_eq!(list.among(count), (numbers.to_vec(), is_more));
    }

    #[rstest]
    #[case::empty("")]
    #[case::backwards("4..2")]
    #[case::nothing("3..3")]
    #[case::half_a_range("3..")]
    #[case::negative("-1")]
    #[case::trailing_comma("1,")]
    #[case::too_large("4294967295")]
    fn what_is_no_list_is_refused(#[case] text: &str) {
        assert!(text.parse::<FrameList>().is_err());
    }

    #[test]
    fn lists_are_written_as_they_are_read() {
        let numbers = [0, 1, 2, 3, 9, 11, 12];
        let list = FrameList::of(&numbers);
        assert_eq!(list.to_string(), "0..4,9,11..13");
        assert_eq!(list.to_string().parse::<FrameList>().expect("a list").among(99).0, numbers);
    }

    #[test]
    fn shards_make_each_frame_once() {
        for of in [1_usize, 3, 8, 40] {
            let share = |k: usize| format!("{k}/{of}").parse::<Shard>().expect("a shard").share((5..30).collect());
            let mut all: Vec<u32> = (1..=of).flat_map(share).collect();
            let sizes: Vec<usize> = (1..=of).map(|k| share(k).len()).collect();
            assert!(sizes.iter().max().unwrap_or(&0) - sizes.iter().min().unwrap_or(&0) <= 1, "equal work");
            all.sort_unstable();
            assert_eq!(all, (5..30).collect::<Vec<_>>());
        }
        for wrong in ["0/8", "9/8", "3", "3/", "0/0", "a/b", "-1/8"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
