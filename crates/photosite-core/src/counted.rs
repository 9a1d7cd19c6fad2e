//! Counts in words.

use std::fmt::Display;

/// A count with its noun in the singular or plural: `1 image`, `2 images`.
pub fn counted<N: Display + PartialEq + From<u8>>(count: N, [one, several]: [&str; 2]) -> String {
    format!("{count} {}", if count == N::from(1) { one } else { several })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_one_is_singular() {
        let images = |count| counted(count, ["image", "images"]);
        assert_eq!([0_u32, 1, 2].map(images), ["0 images", "1 image", "2 images"]);
    }
}
