//! Lateral chromatic aberration: images of different size at different wavelengths.

/// Magnification of the image about the principal point by wavelength: linear between its points, and constant before
/// the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct LateralColour {
    /// Wavelength, nm, rising, and magnification, above 0; at least one.
    pub points: Vec<(f64, f64)>,
}

impl LateralColour {
    /// Magnification at a wavelength, nm.
    #[inline]
    pub fn magnification(&self, lambda_nm: f64) -> f64 {
        let after = self.points.partition_point(|(lambda, _)| *lambda <= lambda_nm);
        match (after.checked_sub(1).and_then(|i| self.points.get(i)), self.points.get(after)) {
            (Some((l0, m0)), Some((l1, m1))) => m0 + (m1 - m0) * (lambda_nm - l0) / (l1 - l0),
            (Some((_, m)), None) | (None, Some((_, m))) => *m,
            (None, None) => 1.0,
        }
    }
}
