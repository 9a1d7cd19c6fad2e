//! Content of a leaf, encoded as the number that the hierarchy knows it by.

/// The contents of a leaf.
#[derive(Clone, Copy, Debug)]
pub(in crate::geometry) enum Leaf {
    /// Index of a block of triangles.
    Triangles(u32),
    /// Index of a quadric.
    Quadric(u32),
}

/// Bit set in the number of a leaf that holds a quadric. The highest bit is the hierarchy's own.
const QUADRIC: u32 = 1 << 30;

impl Leaf {
    /// The number.
    #[inline(always)]
    pub(super) fn number(self) -> u32 {
        match self {
            Self::Triangles(block) => block,
            Self::Quadric(quadric) => QUADRIC | quadric,
        }
    }

    /// The leaf of a number.
    #[inline(always)]
    pub(super) fn of_number(number: u32) -> Self {
        if number & QUADRIC == 0 { Self::Triangles(number) } else { Self::Quadric(number & !QUADRIC) }
    }

    /// Returns the leaf with `blocks` blocks and `quadrics` quadrics inserted before its own.
    pub(super) fn moved(self, blocks: usize, quadrics: usize) -> Self {
        match self {
            Self::Triangles(block) => Self::Triangles(block + blocks as u32),
            Self::Quadric(quadric) => Self::Quadric(quadric + quadrics as u32),
        }
    }
}
