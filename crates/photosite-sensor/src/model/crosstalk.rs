//! Crosstalk: where the electrons of a pixel are collected.

/// Crosstalk kernel: the parts of a pixel's electrons that it and its neighbours collect. They sum to 1, over an odd
/// number of rows and columns around the pixel itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Kernel {
    width: usize,
    height: usize,
    parts: Vec<f64>,
}

impl Kernel {
    /// Builds a kernel from rows of equal, odd length; the parts are not negative and not all 0, and are scaled to sum
    /// to 1. `None` for anything else.
    pub fn new(rows: &[Vec<f64>]) -> Option<Self> {
        let (width, height) = (rows.first()?.len(), rows.len());
        let parts = rows.concat();
        let sum: f64 = parts.iter().sum();
        let is_kernel = width % 2 == 1
            && height % 2 == 1
            && rows.iter().all(|row| row.len() == width)
            && parts.iter().all(|part| *part >= 0.0)
            && sum > 0.0
            && sum.is_finite();
        is_kernel.then(|| Self { width, height, parts: parts.iter().map(|part| part / sum).collect() })
    }

    /// Kernel that leaves every electron in its own pixel.
    pub fn keep() -> Self {
        Self { width: 1, height: 1, parts: vec![1.0] }
    }

    /// Columns that the kernel covers.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Rows that the kernel covers.
    pub(crate) fn height(&self) -> usize {
        self.height
    }

    /// Displacements and the parts that go there, in pixels to the right and downwards, but those that are 0.
    pub(crate) fn displacements(&self) -> impl Iterator<Item = (isize, isize, f32)> {
        let (right, down) = ((self.width / 2) as isize, (self.height / 2) as isize);
        self.parts
            .iter()
            .enumerate()
            .filter(|(_, part)| **part > 0.0)
            .map(move |(i, &part)| ((i % self.width) as isize - right, (i / self.width) as isize - down, part as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_kernel_is_refused() {
        for rows in [vec![], vec![vec![]], vec![vec![0.5, 0.5]], vec![vec![1.0], vec![1.0]], vec![vec![0.0]]] {
            assert_eq!(Kernel::new(&rows), None, "{rows:?}");
        }
        for row in [[1.0, -0.1, 0.1], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
            assert_eq!(Kernel::new(&[row.to_vec()]), None, "{row:?}");
        }
    }
}
