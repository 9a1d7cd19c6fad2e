//! Minima of functions of a few variables without derivatives.

/// The point that the simplex of Nelder and Mead ([NelderMead65](crate::references#neldermead65)) reaches after `steps`
/// steps from `start`, with edges of length `size` at first. The value of `f` there is at most that at the start.
pub fn nelder_mead(start: &[f64], size: f64, steps: usize, f: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let n = start.len();
    let mut simplex: Vec<(f64, Vec<f64>)> = (0..=n)
        .map(|i| {
            let mut point = start.to_vec();
            if i < n {
                point[i] += size;
            }
            (f(&point), point)
        })
        .collect();
    for _ in 0..steps {
        simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
        let centre: Vec<f64> = (0..n).map(|i| simplex[..n].iter().map(|(_, p)| p[i]).sum::<f64>() / n as f64).collect();
        let worst = simplex[n].clone();
        let away = |by: f64| -> (f64, Vec<f64>) {
            let point: Vec<f64> = centre.iter().zip(&worst.1).map(|(c, w)| c + by * (c - w)).collect();
            (f(&point), point)
        };
        let reflected = away(1.0);
        let second_worst = simplex[n.saturating_sub(1)].0;
        simplex[n] = if reflected.0 < simplex[0].0 {
            let expanded = away(2.0);
            if expanded.0 < reflected.0 { expanded } else { reflected }
        } else if reflected.0 < second_worst {
            reflected
        } else {
            let contracted = if reflected.0 < worst.0 { away(0.5) } else { away(-0.5) };
            if contracted.0 < worst.0.min(reflected.0) {
                contracted
            } else {
                // Towards the best.
                let best = simplex[0].1.clone();
                for (value, point) in simplex.iter_mut().skip(1) {
                    point.iter_mut().zip(&best).for_each(|(p, b)| *p = 0.5 * (*p + b));
                    *value = f(point);
                }
                continue;
            }
        };
    }
    simplex.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(|| start.to_vec(), |(_, point)| point)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_banana_valley_of_rosenbrock() {
        let valley = |p: &[f64]| 100.0 * (p[1] - p[0] * p[0]).powi(2) + (1.0 - p[0]).powi(2);
        let found = nelder_mead(&[-1.2, 1.0], 0.5, 300, valley);
        assert!((found[0] - 1.0).abs() < 1e-5 && (found[1] - 1.0).abs() < 1e-5, "{found:?}");
        assert_eq!(nelder_mead(&[3.0], 0.1, 0, |p| p[0].powi(2)), [3.0]);
    }
}
