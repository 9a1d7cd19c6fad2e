//! Small systems of linear equations.

/// Solves A·x = b for a square A given by rows, by Gaussian elimination with row pivoting. `None` where A is singular.
pub fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    for column in 0..n {
        let pivot = (column..n).max_by(|&i, &j| a[i][column].abs().total_cmp(&a[j][column].abs()))?;
        a.swap(column, pivot);
        b.swap(column, pivot);
        if a[column][column] == 0.0 || !a[column][column].is_finite() {
            return None;
        }
        let (above, below) = a.split_at_mut(column + 1);
        let row = &above[column];
        for (i, other) in below.iter_mut().enumerate() {
            let factor = other[column] / row[column];
            other.iter_mut().zip(row).skip(column).for_each(|(to, from)| *to -= factor * from);
            b[column + 1 + i] -= factor * b[column];
        }
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| a[i][j] * b[j]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
    Some(b)
}

/// The x that makes |A·x − b| least, for an A given by rows, at least as many as columns, by Householder's reflections. `None` where the
/// columns of A depend on each other.
pub fn least_squares(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let columns = a.first().map_or(0, Vec::len);
    if a.len() < columns {
        return None;
    }
    for column in 0..columns {
        let length = a[column..].iter().map(|row| row[column] * row[column]).sum::<f64>().sqrt();
        if length == 0.0 || !length.is_finite() {
            return None;
        }
        // The column becomes −sign·length along its first place, so that nothing cancels.
        let end = -length.copysign(a[column][column]);
        let mut normal: Vec<f64> = a[column..].iter().map(|row| row[column]).collect();
        normal[0] -= end;
        let square: f64 = normal.iter().map(|x| x * x).sum();
        for other in column..columns {
            let dot: f64 = normal.iter().zip(&a[column..]).map(|(x, row)| x * row[other]).sum();
            normal.iter().zip(&mut a[column..]).for_each(|(x, row)| row[other] -= 2.0 * dot / square * x);
        }
        let dot: f64 = normal.iter().zip(&b[column..]).map(|(x, y)| x * y).sum();
        normal.iter().zip(&mut b[column..]).for_each(|(x, y)| *y -= 2.0 * dot / square * x);
    }
    a.truncate(columns);
    b.truncate(columns);
    // Below the diagonal roundings are left.
    a.iter_mut().enumerate().for_each(|(i, row)| row[..i].fill(0.0));
    solve(a, b)
}

/// Factor L of a symmetric, positive definite matrix L·Lᵀ.
#[derive(Clone, Debug)]
pub struct Cholesky {
    /// Rows of L; above the diagonal 0.
    pub lower: Vec<Vec<f64>>,
}

impl Cholesky {
    /// Factor of a matrix given by rows, of which those from the diagonal on to the left count. `None` where it is not positive
    /// definite.
    pub fn new(mut a: Vec<Vec<f64>>) -> Option<Self> {
        for i in 0..a.len() {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
                let rest = a[i][j] - known;
                a[i][j] = if i == j { Some(rest).filter(|rest| *rest > 0.0)?.sqrt() } else { rest / a[j][j] };
            }
            a[i].iter_mut().skip(i + 1).for_each(|value| *value = 0.0);
        }
        Some(Self { lower: a })
    }

    /// Logarithm of the determinant of L·Lᵀ.
    pub fn log_determinant(&self) -> f64 {
        2.0 * self.lower.iter().enumerate().map(|(i, row)| row[i].ln()).sum::<f64>()
    }

    /// √(vᵀ·(L·Lᵀ)⁻¹·v), which is |L⁻¹·v|.
    pub fn inverse_norm(&self, v: &[f64]) -> f64 {
        let mut found: Vec<f64> = Vec::with_capacity(v.len());
        for (row, value) in self.lower.iter().zip(v) {
            let known: f64 = row.iter().zip(&found).map(|(l, x)| l * x).sum();
            found.push((value - known) / row[found.len()]);
        }
        found.iter().map(|x| x * x).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_make_their_matrix() {
        let a = vec![vec![4.0, 2.0, 0.6], vec![2.0, 5.0, 1.0], vec![0.6, 1.0, 3.0]];
        let factor = Cholesky::new(a.clone()).expect("positive definite");
        for (i, row) in a.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                let found: f64 = factor.lower[i].iter().zip(&factor.lower[j]).map(|(a, b)| a * b).sum();
                assert!((found - value).abs() < 1e-12, "{i} {j}");
            }
        }
        // 4·(15 − 1) − 2·(6 − 0.6) + 0.6·(2 − 3).
        assert!((factor.log_determinant() - 44.6f64.ln()).abs() < 1e-12);
        let v = [1.0, -2.0, 0.5];
        let x = solve(a, v.to_vec()).expect("a solution");
        let square: f64 = x.iter().zip(v).map(|(x, v)| x * v).sum();
        assert!((factor.inverse_norm(&v) - square.sqrt()).abs() < 1e-12);
        assert!(Cholesky::new(vec![vec![1.0, 2.0], vec![2.0, 1.0]]).is_none());
    }

    #[test]
    fn solutions_by_hand() {
        // 2y = 4, x + y + z = 6, x − z = −2: the first row has no pivot of its own.
        let a = vec![vec![0.0, 2.0, 0.0], vec![1.0, 1.0, 1.0], vec![1.0, 0.0, -1.0]];
        assert_eq!(solve(a, vec![4.0, 6.0, -2.0]), Some(vec![1.0, 2.0, 3.0]));
        assert_eq!(solve(vec![vec![1.0, 2.0], vec![2.0, 4.0]], vec![1.0, 2.0]), None);
        assert_eq!(solve(Vec::new(), Vec::new()), Some(Vec::new()));
    }

    #[test]
    fn a_line_through_points_beside_it() {
        // y = 1 + 2x with errors of +1, −2, +1, which are orthogonal to 1 and x.
        let rows = [0.0, 1.0, 2.0].map(|x| vec![1.0, x]).to_vec();
        let found = least_squares(rows, vec![2.0, 1.0, 6.0]).expect("a line");
        assert!((found[0] - 1.0).abs() < 1e-14 && (found[1] - 2.0).abs() < 1e-14, "{found:?}");
        assert_eq!(least_squares(vec![vec![1.0, 1.0]], vec![1.0]), None);
        assert_eq!(least_squares(vec![vec![0.0], vec![0.0]], vec![1.0, 1.0]), None);
    }
}
