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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_by_hand() {
        // 2y = 4, x + y + z = 6, x − z = −2: the first row has no pivot of its own.
        let a = vec![vec![0.0, 2.0, 0.0], vec![1.0, 1.0, 1.0], vec![1.0, 0.0, -1.0]];
        assert_eq!(solve(a, vec![4.0, 6.0, -2.0]), Some(vec![1.0, 2.0, 3.0]));
        assert_eq!(solve(vec![vec![1.0, 2.0], vec![2.0, 4.0]], vec![1.0, 2.0]), None);
        assert_eq!(solve(Vec::new(), Vec::new()), Some(Vec::new()));
    }
}
