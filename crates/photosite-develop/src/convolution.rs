//! Filters given as kernels: every pixel becomes the sum of those around it, each times its weight,
//!
//! f(x, y) = Σ k(i, j)·g(x + i − a, y + j − b), with (a, b) the middle of the kernel.
//!
//! That is correlation, as OpenCV's `filter2D` has it; it is convolution with the kernel turned by 180°. At the edges
//! the image is mirrored. A kernel of rank 1, k(i, j) = r(i)·c(j), is applied along rows and then along columns: n +
//! m products a pixel in place of n·m.

use photosite_core::rows::for_each_row;

use super::settings::DevelopSettings;
use super::window::{mirror, separable};
use photosite_core::Invalid;
use photosite_core::image::Planes;

/// Longest side of a kernel, weights.
const LARGEST_SIDE: usize = 101;
/// Largest deviation from a product of a row and a column at which a kernel counts as one, of its largest number: single
/// precision does not tell it.
const RANK_TOLERANCE: f64 = 1e-7;

/// Weights of a filter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kernel {
    /// Kernels along rows and along columns, whose product is the whole one.
    Separable([Vec<f32>; 2]),
    /// Rows from the top.
    Whole(Vec<Vec<f32>>),
}

impl Kernel {
    /// The kernel of the settings, if they have one.
    pub(super) fn of(settings: &DevelopSettings) -> Result<Option<Self>, Invalid> {
        let Some(rows) = &settings.kernel else { return Ok(None) };
        let columns = rows.first().map_or(0, Vec::len);
        let is_side = |n: usize| n % 2 == 1 && n <= LARGEST_SIDE;
        let refused = |message: String| {
            Err(Invalid::new("kernel", message).help("for example kernel = [[1, 2, 1], [2, 4, 2], [1, 2, 1]]"))
        };
        if !is_side(rows.len()) || !is_side(columns) {
            return refused(format!(
                "must have an odd number of rows and columns, up to {LARGEST_SIDE}, got {} × {columns}",
                rows.len()
            ));
        }
        if let Some(row) = rows.iter().position(|row| row.len() != columns) {
            return refused(format!("row {} has {} numbers, the first {columns}", row + 1, rows[row].len()));
        }
        if let Some(number) = rows.iter().flatten().find(|number| !(-1e6..=1e6).contains(*number)) {
            return refused(format!("numbers must lie from -1e6 to 1e6, got {number}"));
        }
        let sum: f64 = rows.iter().flatten().sum();
        let divisor = if settings.kernel_normalised == Some(true) { sum } else { 1.0 };
        if divisor.abs() < 1e-9 {
            let message = format!("the numbers of kernel add up to {sum}, which nothing can be divided by");
            return Err(Invalid::new("kernel_normalised", message).help("remove it"));
        }
        Ok(Some(Self::new(rows, divisor)))
    }

    /// Kernel of rows that are as long as each other, over a divisor.
    fn new(rows: &[Vec<f64>], divisor: f64) -> Self {
        let single = |numbers: &[f64]| numbers.iter().map(|&number| number as f32).collect::<Vec<_>>();
        let scaled: Vec<Vec<f64>> =
            rows.iter().map(|row| row.iter().map(|number| number / divisor).collect()).collect();
        let places = (0..scaled.len()).flat_map(|j| (0..scaled[j].len()).map(move |i| (i, j)));
        let largest = places.max_by(|&(i, j), &(k, l)| scaled[j][i].abs().total_cmp(&scaled[l][k].abs()));
        // The row and the column through the largest number, if any product is the kernel.
        if let Some((i, j)) = largest.filter(|&(i, j)| scaled[j][i] != 0.0) {
            let peak = scaled[j][i];
            let across: Vec<f64> = scaled[j].clone();
            let down: Vec<f64> = scaled.iter().map(|row| row[i] / peak).collect();
            let is_product = scaled.iter().zip(&down).all(|(row, of_row)| {
                row.iter().zip(&across).all(|(k, a)| (k - a * of_row).abs() <= RANK_TOLERANCE * peak.abs())
            });
            if is_product {
                return Self::Separable([single(&across), single(&down)]);
            }
        }
        Self::Whole(scaled.iter().map(|row| single(row)).collect())
    }

    /// The sums of a plane.
    fn filter(&self, plane: &[f32], size: [usize; 2]) -> Vec<f32> {
        match self {
            Self::Separable([across, down]) => separable(plane, size, [across, down]),
            Self::Whole(rows) => whole(plane, size, rows),
        }
    }
}

/// Filters every plane.
pub(super) fn apply(image: &mut Planes, settings: &DevelopSettings) -> Result<(), Invalid> {
    let Some(kernel) = Kernel::of(settings)? else { return Ok(()) };
    let size = [image.width(), image.height()];
    for channel in image.channels_mut() {
        channel.data = kernel.filter(&channel.data, size);
    }
    Ok(())
}

fn whole(plane: &[f32], [width, height]: [usize; 2], kernel: &[Vec<f32>]) -> Vec<f32> {
    let mut result = vec![0.0; plane.len()];
    let middle = kernel.len() / 2;
    for_each_row(&mut result, width, |y, to| {
        for (j, numbers) in kernel.iter().enumerate() {
            let row = &plane[mirror(y + j, middle, height) * width..][..width];
            for (x, to) in to.iter_mut().enumerate() {
                let value = |i: usize| row[mirror(x + i, numbers.len() / 2, width)];
                *to += numbers.iter().enumerate().map(|(i, number)| number * value(i)).sum::<f32>();
            }
        }
    });
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernel(rows: &[&[f64]]) -> Kernel {
        Kernel::new(&rows.iter().map(|row| row.to_vec()).collect::<Vec<_>>(), 1.0)
    }

    #[test]
    fn products_of_a_row_and_a_column_are_known() {
        let sobel = kernel(&[&[-1.0, 0.0, 1.0], &[-2.0, 0.0, 2.0], &[-1.0, 0.0, 1.0]]);
        let Kernel::Separable([across, down]) = sobel else { panic!("rank 1") };
        let product: Vec<f32> = down.iter().flat_map(|c| across.iter().map(move |r| r * c)).collect();
        assert_eq!(product, [-1.0, 0.0, 1.0, -2.0, 0.0, 2.0, -1.0, 0.0, 1.0]);
        let laplace = kernel(&[&[0.0, 1.0, 0.0], &[1.0, -4.0, 1.0], &[0.0, 1.0, 0.0]]);
        assert!(matches!(laplace, Kernel::Whole(_)));
        assert!(matches!(kernel(&[&[0.0]]), Kernel::Whole(_)));
    }

    #[test]
    fn a_point_becomes_the_turned_kernel_and_edges_mirror() {
        let rows: [&[f64]; 3] = [&[1.0, 2.0, 3.0], &[4.0, 50.0, 6.0], &[7.0, 8.0, 9.0]];
        let mut point = vec![0.0; 25];
        point[12] = 1.0;
        let found = kernel(&rows).filter(&point, [5, 5]);
        assert_eq!(
            [&found[6..9], &found[11..14], &found[16..19]],
            [&[9.0, 8.0, 7.0][..], &[6.0, 50.0, 4.0], &[3.0, 2.0, 1.0]]
        );
        // At the left edge, what lies one column beyond is the column beside it.
        let mut beside = vec![0.0; 25];
        beside[11] = 1.0;
        assert_eq!(kernel(&rows).filter(&beside, [5, 5])[10], 4.0 + 6.0);
    }

    #[test]
    fn both_ways_are_the_same_filter() {
        let rows = vec![vec![1.0, 4.0, 6.0], vec![2.0, 8.0, 12.0], vec![0.5, 2.0, 3.0]];
        let plane: Vec<f32> = (0..7 * 6).map(|i| ((i * 37) % 11) as f32).collect();
        let fast = Kernel::new(&rows, 38.5);
        assert!(matches!(fast, Kernel::Separable(_)));
        let slow = whole(
            &plane,
            [7, 6],
            &rows.iter().map(|r| r.iter().map(|k| (k / 38.5) as f32).collect()).collect::<Vec<_>>(),
        );
        let apart = fast.filter(&plane, [7, 6]).iter().zip(&slow).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-5, "{apart}");
    }
}
