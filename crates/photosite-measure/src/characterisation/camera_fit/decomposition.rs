//! An averaged image as a sum: its mean, a smooth part, rows, columns, and the rest.

/// Degrees of the polynomials that stand for shading.
fn degrees(length: usize) -> usize {
    match length {
        0..16 => 0,
        16..64 => 2,
        _ => 4,
    }
}

/// Parts of an image, whose sum it is: the mean, what rows and what columns have in common, and the rest. The smooth part of
/// each is a polynomial in x and y, orthogonal over the pixels.
pub(super) struct Decomposition {
    pub(super) rows: Basis,
    pub(super) columns: Basis,
    pub(super) mean: f64,
    /// Means of rows and of columns, less the mean of all.
    pub(super) row_means: Vec<f64>,
    pub(super) column_means: Vec<f64>,
    /// Deviations of pixels from mean, row and column.
    pub(super) rest: Vec<f64>,
    row_smooth: Vec<f64>,
    column_smooth: Vec<f64>,
    rest_smooth: Vec<f64>,
}

impl Decomposition {
    pub(super) fn of(image: &[f64], size: [usize; 2]) -> Self {
        let [columns, rows] = size.map(|length| Basis::new(length, degrees(length)));
        let (m, n) = (rows.length as f64, columns.length as f64);
        let mean = image.iter().sum::<f64>() / (m * n);
        let row_means: Vec<f64> = image.chunks_exact(size[0]).map(|line| line.iter().sum::<f64>() / n - mean).collect();
        let mut column_means = vec![-mean; size[0]];
        for line in image.chunks_exact(size[0]) {
            column_means.iter_mut().zip(line).for_each(|(sum, y)| *sum += y / m);
        }
        let rest: Vec<f64> =
            (0..image.len()).map(|i| image[i] - mean - row_means[i / size[0]] - column_means[i % size[0]]).collect();
        let (row_smooth, column_smooth) = (rows.smooth(&row_means), columns.smooth(&column_means));
        let rest_smooth = rows.smooth_both(&columns, &rest);
        Self { rows, columns, mean, row_means, column_means, rest, row_smooth, column_smooth, rest_smooth }
    }

    /// Row and column of a pixel.
    fn place(&self, i: usize) -> [usize; 2] {
        [i / self.columns.length, i % self.columns.length]
    }

    /// Deviation of a pixel's smooth part from the mean.
    pub(super) fn smooth(&self, i: usize) -> f64 {
        let [y, x] = self.place(i);
        self.rest_smooth[i] + self.row_smooth[y] + self.column_smooth[x]
    }

    /// Deviations of rows, of columns and of pixels from their smooth parts.
    pub(super) fn rough(&self) -> [impl Iterator<Item = f64>; 3] {
        let parts = [
            (&self.row_means, &self.row_smooth),
            (&self.column_means, &self.column_smooth),
            (&self.rest, &self.rest_smooth),
        ];
        parts.map(|(values, smooth)| values.iter().zip(smooth).map(|(value, smooth)| value - smooth))
    }

    /// Deviation of a pixel from the mean, with factors on what its row, its column and itself have beyond the smooth part.
    pub(super) fn weighted(&self, i: usize, [row, column, pixel]: [f64; 3]) -> f64 {
        let [y, x] = self.place(i);
        self.smooth(i)
            + row * (self.row_means[y] - self.row_smooth[y])
            + column * (self.column_means[x] - self.column_smooth[x])
            + pixel * (self.rest[i] - self.rest_smooth[i])
    }
}

/// Orthonormal polynomials over the places of a line, without the constant.
pub(super) struct Basis {
    length: usize,
    terms: Vec<Vec<f64>>,
}

impl Basis {
    fn new(length: usize, degrees: usize) -> Self {
        let mut terms: Vec<Vec<f64>> = vec![vec![1.0 / (length as f64).sqrt(); length]];
        let place = |i: usize| 2.0 * i as f64 / (length as f64 - 1.0).max(1.0) - 1.0;
        for _ in 0..degrees {
            // x times the last, made orthogonal to all before it twice, for rounding.
            let last = &terms[terms.len() - 1];
            let mut next: Vec<f64> = last.iter().enumerate().map(|(i, t)| t * place(i)).collect();
            for _ in 0..2 {
                for term in &terms {
                    let part: f64 = term.iter().zip(&next).map(|(a, b)| a * b).sum();
                    next.iter_mut().zip(term).for_each(|(value, t)| *value -= part * t);
                }
            }
            let norm = next.iter().map(|v| v * v).sum::<f64>().sqrt();
            next.iter_mut().for_each(|v| *v /= norm);
            terms.push(next);
        }
        terms.remove(0);
        Self { length, terms }
    }

    pub(super) fn degrees(&self) -> f64 {
        self.terms.len() as f64
    }

    /// Coefficient of each term.
    fn coefficients(&self, values: &[f64]) -> Vec<f64> {
        self.terms.iter().map(|term| term.iter().zip(values).map(|(t, v)| t * v).sum()).collect()
    }

    /// The smooth part of a line.
    fn smooth(&self, values: &[f64]) -> Vec<f64> {
        let mut smooth = vec![0.0; self.length];
        for (term, c) in self.terms.iter().zip(self.coefficients(values)) {
            smooth.iter_mut().zip(term).for_each(|(value, t)| *value += c * t);
        }
        smooth
    }

    /// Largest mean square of a term, each line being the mean of `across` pixels.
    pub(super) fn largest_term(&self, values: &[f64], across: f64) -> f64 {
        self.coefficients(values).into_iter().map(|c| across * c * c).fold(0.0, f64::max)
    }

    /// The smooth part of an image of these rows and other columns, of products of terms.
    fn smooth_both(&self, columns: &Self, image: &[f64]) -> Vec<f64> {
        let width = columns.length;
        let mut coefficients = vec![vec![0.0; columns.terms.len()]; self.terms.len()];
        for (y, line) in image.chunks_exact(width).enumerate() {
            for (b, c) in columns.coefficients(line).into_iter().enumerate() {
                coefficients.iter_mut().zip(&self.terms).for_each(|(row, term)| row[b] += term[y] * c);
            }
        }
        let mut smooth = vec![0.0; image.len()];
        for (y, line) in smooth.chunks_exact_mut(width).enumerate() {
            for (b, term) in columns.terms.iter().enumerate() {
                let c: f64 = coefficients.iter().zip(&self.terms).map(|(row, t)| row[b] * t[y]).sum();
                line.iter_mut().zip(term).for_each(|(value, t)| *value += c * t);
            }
        }
        smooth
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_make_the_image() {
        const SIZE: [usize; 2] = [20, 17];
        let image: Vec<f64> = (0..340).map(|i| f64::from((i * 7919) % 101)).collect();
        let parts = Decomposition::of(&image, SIZE);
        for (i, value) in image.iter().enumerate() {
            assert!((parts.mean + parts.weighted(i, [1.0; 3]) - value).abs() < 1e-9);
            assert_eq!(parts.weighted(i, [0.0; 3]), parts.smooth(i));
        }
    }
}
