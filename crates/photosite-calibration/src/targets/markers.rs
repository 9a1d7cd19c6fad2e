//! Dictionaries of square markers: ArUco and AprilTag.
//!
//! The bits are those of OpenCV's predefined dictionaries (`assets/markers`), by OpenCV's names. A marker of n × n bits
//! has a black border around it, one cell wide unless stated otherwise. OpenCV's AprilTags are turned by 180° against
//! those that AprilTag's own programs call upright.

use std::sync::OnceLock;

use glam::DVec2;

use super::Target;
use photosite_core::Invalid;

/// A set of markers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dictionary {
    /// OpenCV's name.
    pub name: &'static str,
    /// n of its n × n bits.
    pub bits: u32,
    /// Number of its markers.
    pub len: u32,
    /// Index into [`FILES`].
    file: usize,
}

macro_rules! files {
    ($($name:literal),*) => { [$(include_str!(concat!("../../assets/markers/", $name, ".txt"))),*] };
}

const FILES: [&str; 10] = files![
    "4x4",
    "5x5",
    "6x6",
    "7x7",
    "aruco-original",
    "aruco-mip-36h12",
    "apriltag-16h5",
    "apriltag-25h9",
    "apriltag-36h10",
    "apriltag-36h11"
];

const fn dictionary(name: &'static str, bits: u32, len: u32, file: usize) -> Dictionary {
    Dictionary { name, bits, len, file }
}

/// All dictionaries. The smaller ones of a family are its first markers.
pub const DICTIONARIES: [Dictionary; 22] = [
    dictionary("DICT_4X4_50", 4, 50, 0),
    dictionary("DICT_4X4_100", 4, 100, 0),
    dictionary("DICT_4X4_250", 4, 250, 0),
    dictionary("DICT_4X4_1000", 4, 1000, 0),
    dictionary("DICT_5X5_50", 5, 50, 1),
    dictionary("DICT_5X5_100", 5, 100, 1),
    dictionary("DICT_5X5_250", 5, 250, 1),
    dictionary("DICT_5X5_1000", 5, 1000, 1),
    dictionary("DICT_6X6_50", 6, 50, 2),
    dictionary("DICT_6X6_100", 6, 100, 2),
    dictionary("DICT_6X6_250", 6, 250, 2),
    dictionary("DICT_6X6_1000", 6, 1000, 2),
    dictionary("DICT_7X7_50", 7, 50, 3),
    dictionary("DICT_7X7_100", 7, 100, 3),
    dictionary("DICT_7X7_250", 7, 250, 3),
    dictionary("DICT_7X7_1000", 7, 1000, 3),
    dictionary("DICT_ARUCO_ORIGINAL", 5, 1024, 4),
    dictionary("DICT_ARUCO_MIP_36h12", 6, 250, 5),
    dictionary("DICT_APRILTAG_16h5", 4, 30, 6),
    dictionary("DICT_APRILTAG_25h9", 5, 35, 7),
    dictionary("DICT_APRILTAG_36h10", 6, 2320, 8),
    dictionary("DICT_APRILTAG_36h11", 6, 587, 9),
];

/// The codes of all markers of all files.
fn codes() -> &'static [Vec<u64>; 10] {
    static CODES: OnceLock<[Vec<u64>; 10]> = OnceLock::new();
    let parsed = |text: &str| -> Vec<u64> {
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        lines.map(|line| u64::from_str_radix(line, 16).expect("part of the program and tested")).collect()
    };
    CODES.get_or_init(|| FILES.map(parsed))
}

impl Dictionary {
    /// The dictionary of a name, in whatever case.
    pub fn named(name: &str) -> Option<Self> {
        DICTIONARIES.into_iter().find(|dictionary| dictionary.name.eq_ignore_ascii_case(name))
    }

    /// The dictionary that the key `dictionary` names, with at least as many markers as are needed.
    pub(super) fn with(name: &str, needed: u32) -> Result<Self, Invalid> {
        let Some(dictionary) = Self::named(name) else {
            let names = DICTIONARIES.map(|dictionary| dictionary.name).join(", ");
            let message = format!("there is no dictionary {name:?}");
            return Err(Invalid::new("dictionary", message).help(format!("known names are {names}")));
        };
        if needed <= dictionary.len {
            return Ok(dictionary);
        }
        let message = format!("{} has {} markers, but {needed} are needed", dictionary.name, dictionary.len);
        Err(Invalid::new("dictionary", message).help("choose a larger dictionary, or fewer markers"))
    }

    /// Whether a bit of a marker is white, by column and row from the top left.
    pub fn is_white(&self, id: u32, column: u32, row: u32) -> bool {
        let code = codes()[self.file][id as usize];
        let place = self.bits * self.bits - 1 - (row * self.bits + column);
        code >> place & 1 == 1
    }
}

/// How a marker is drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct MarkerStyle {
    /// Length of a side with the border, m.
    pub(super) side_m: f64,
    /// Width of the black border, cells.
    pub(super) border_bits: u32,
    /// Whether it stands on its head.
    pub(super) turned: bool,
    /// Index of the black ink, on white.
    pub(super) black: usize,
}

impl Target {
    /// Draws a marker: black cells on the white that is there, those of a row that touch as one.
    pub(super) fn add_marker(&mut self, dictionary: &Dictionary, id: u32, top_left: DVec2, style: MarkerStyle) {
        let MarkerStyle { side_m, border_bits, turned, black } = style;
        let (n, border) = (dictionary.bits, border_bits);
        let cells = n + 2 * border;
        let is_black = |column: u32, row: u32| {
            let [column, row] = if turned { [cells - 1 - column, cells - 1 - row] } else { [column, row] };
            let inside = |i: u32| (border..border + n).contains(&i);
            !(inside(column) && inside(row) && dictionary.is_white(id, column - border, row - border))
        };
        let corner =
            |column: u32, row: u32| top_left + DVec2::new(column.into(), row.into()) * side_m / f64::from(cells);
        for row in 0..cells {
            let mut column = 0;
            while column < cells {
                let end = (column..cells).find(|&c| !is_black(c, row)).unwrap_or(cells);
                if end > column {
                    self.add_rectangle(corner(column, row), corner(end, row + 1), black);
                }
                column = end + 1;
            }
        }
        let mut corners_m = [[0, 0], [cells, 0], [cells, cells], [0, cells]].map(|[column, row]| corner(column, row));
        if turned {
            corners_m.rotate_left(2);
        }
        self.markers.push(super::Marker { dictionary: dictionary.name, id, corners_m });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_hold_what_the_table_says() {
        for dictionary in DICTIONARIES {
            let codes = &codes()[dictionary.file];
            assert!(codes.len() >= dictionary.len as usize, "{}", dictionary.name);
            assert!(codes.iter().all(|code| code >> (dictionary.bits * dictionary.bits) == 0), "{}", dictionary.name);
        }
        for (file, codes) in FILES.iter().zip(codes()) {
            let largest = DICTIONARIES.iter().filter(|d| FILES[d.file] == *file).map(|d| d.len).max();
            assert_eq!(largest, Some(codes.len() as u32), "{file:.40}");
            assert!(file.contains("# source: "));
        }
    }

    /// Codes that others publish: AprilTag's own list for 36h11 begins with 0xd5d628584, which OpenCV has upside down;
    /// its original ArUco markers encode 0 as rows of 10000.
    #[test]
    fn codes_are_those_that_others_publish() {
        let tag = Dictionary::named("DICT_APRILTAG_36h11").expect("listed");
        for place in 0..36 {
            let white = 0xd5d628584_u64 >> (35 - place) & 1 == 1;
            assert_eq!(tag.is_white(0, 5 - place % 6, 5 - place / 6), white);
        }
        let original = Dictionary::named("dict_aruco_original").expect("listed");
        assert!((0..25).all(|i| original.is_white(0, i % 5, i / 5) == (i % 5 == 0)));
    }

    /// No two markers of a dictionary look alike however they are turned.
    #[test]
    fn markers_differ() {
        for dictionary in DICTIONARIES.iter().filter(|d| d.len == codes()[d.file].len() as u32) {
            let n = dictionary.bits;
            let mut seen = std::collections::HashMap::new();
            for id in 0..dictionary.len {
                let image = |turn: u32| -> u64 {
                    (0..n * n).fold(0, |code, i| {
                        let (mut column, mut row) = (i % n, i / n);
                        for _ in 0..turn {
                            (column, row) = (row, n - 1 - column);
                        }
                        code << 1 | u64::from(dictionary.is_white(id, column, row))
                    })
                };
                for turn in 0..4 {
                    let other = seen.insert(image(turn), id);
                    // Some of the original markers are the same upside down.
                    assert!(other.is_none_or(|other| other == id), "{}: {id} and {other:?}", dictionary.name);
                }
            }
        }
    }
}
