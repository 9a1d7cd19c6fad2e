//! Autocovariance: how far the noise of a pixel tells that of its neighbours.

use serde::Serialize;

/// Covariances C(Δr, Δc) = ⟨e(r, c)·e(r + Δr, c + Δc)⟩ of deviations e from the mean, averaged over all pairs of pixels
/// so far apart ([TruccoVerri98](photosite_core::references#truccoverri98), algorithm `AUTO_COVARIANCE`, divided by the
/// number of pairs so that it is not biased towards nothing).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Autocovariance {
    /// C(0, Δc) for Δc = 0, 1, …: along rows.
    pub along_rows: Vec<f64>,
    /// C(Δr, 0) for Δr = 0, 1, …: along columns.
    pub along_columns: Vec<f64>,
    /// C(Δr, Δc), a list for each Δr.
    pub covariances: Vec<Vec<f64>>,
    /// Standard error of a correlation C/C(0, 0) of noise without any: 1/√(values).
    pub correlation_error: f64,
    /// Largest difference between the correlation at (Δr, Δc) and the product of those along columns and along rows:
    /// nothing where noise is correlated along both independently.
    pub inseparability: f64,
}

impl Autocovariance {
    /// The mean over patches of deviations, up to a distance of `most_lag` or half of the patch.
    pub(super) fn mean_of(patches: &[Vec<f64>], [width, height]: [usize; 2], most_lag: usize) -> Self {
        let lags = |side: usize| 0..=most_lag.min(side / 2);
        let covariance = |dr: usize, dc: usize| {
            let mut sum = 0.0;
            for deviations in patches {
                for row in 0..height - dr {
                    let upper = &deviations[row * width..][..width - dc];
                    let lower = &deviations[(row + dr) * width + dc..][..width - dc];
                    sum += upper.iter().zip(lower).map(|(a, b)| a * b).sum::<f64>();
                }
            }
            sum / (patches.len() * (height - dr) * (width - dc)) as f64
        };
        let covariances: Vec<Vec<f64>> =
            lags(height).map(|dr| lags(width).map(|dc| covariance(dr, dc)).collect()).collect();
        let along_columns: Vec<f64> = covariances.iter().map(|row| row[0]).collect();
        let along_rows = covariances[0].clone();
        let variance = along_rows[0];
        let mut inseparability: f64 = 0.0;
        for (row, c) in covariances.iter().zip(&along_columns) {
            for (both, r) in row.iter().zip(&along_rows) {
                if variance > 0.0 {
                    inseparability = inseparability.max((both / variance - c / variance * (r / variance)).abs());
                }
            }
        }
        let values = patches.len() * width * height;
        Self { along_rows, along_columns, covariances, correlation_error: (values as f64).powf(-0.5), inseparability }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_distr::StandardNormal;

    use super::*;
    use photosite_core::math::philox::Philox;

    #[test]
    fn a_moving_average_is_found() {
        // White noise of variance 1, averaged over 2 pixels along rows: C(0, 0) = ½, C(0, 1) = ¼, nothing beyond and
        // nothing along columns.
        let (width, height) = (160, 120);
        let white: Vec<f64> = (0..(width + 1) * height).map(|i| Philox::new(3, i).sample(StandardNormal)).collect();
        let (width, height) = (width as usize, height as usize);
        let at = |x: usize, y: usize| white[y * (width + 1) + x];
        let smooth: Vec<f64> =
            (0..width * height).map(|i| 0.5 * (at(i % width, i / width) + at(i % width + 1, i / width))).collect();
        let found = Autocovariance::mean_of(&[smooth], [width, height], 4);
        assert_eq!((found.along_rows.len(), found.along_columns.len()), (5, 5));
        // The variance of an estimate is at most Σ over all lags of 2·C²/n = 2·(¼ + 2/16)/n; 5 standard errors.
        let within = 5.0 * (0.75 / (width * height) as f64).sqrt();
        for (lag, expected) in [0.5, 0.25, 0.0, 0.0, 0.0].into_iter().enumerate() {
            assert!((found.along_rows[lag] - expected).abs() < within, "{found:?}");
        }
        assert!(found.along_columns[1..].iter().all(|c| c.abs() < within), "{found:?}");
        assert!(found.inseparability < 2.0 * within / 0.5, "{found:?}");
    }

    #[test]
    fn a_checkerboard_by_hand() {
        let board: Vec<f64> = (0..64).map(|i| if (i + i / 8) % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let found = Autocovariance::mean_of(&[board], [8, 8], 9);
        assert_eq!(found.along_rows, [1.0, -1.0, 1.0, -1.0, 1.0]);
        assert_eq!(found.covariances[1], [-1.0, 1.0, -1.0, 1.0, -1.0]);
        assert_eq!(found.inseparability, 0.0);
    }
}
