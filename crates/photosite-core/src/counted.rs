//! Numbers of things, in words.

use std::fmt::Display;

/// So many of something: `1 picture`, `2 pictures`.
pub fn counted<N: Display + PartialEq + From<u8>>(count: N, [one, several]: [&str; 2]) -> String {
    format!("{count} {}", if count == N::from(1) { one } else { several })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_one_is_singular() {
        let pictures = |count| counted(count, ["picture", "pictures"]);
        assert_eq!([0_u32, 1, 2].map(pictures), ["0 pictures", "1 picture", "2 pictures"]);
    }
}
