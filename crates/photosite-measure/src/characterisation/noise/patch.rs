//! Patches, whose noise is estimated, and variances with their errors.

use serde::Serialize;

use photosite_core::Invalid;

/// The values of a patch of one image, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) values: Vec<f64>,
}

impl Patch {
    /// Patch of width × height finite values, at least 2 × 2.
    pub fn new(width: usize, height: usize, values: Vec<f64>) -> Result<Self, Invalid> {
        if width < 2 || height < 2 || values.len() != width * height {
            let message = format!("{} values in {width} × {height} pixels do not form a patch", values.len());
            return Err(Invalid::new("patch", message).help("choose at least 2 × 2 pixels"));
        }
        let mut not_finite = values.iter().enumerate().filter(|(_, value)| !value.is_finite());
        if let Some((i, value)) = not_finite.next() {
            let (count, x, y) = (1 + not_finite.count(), i % width, i / width);
            let (are, first) = if count == 1 { ("value is", "") } else { ("values are", "the first ") };
            let message = format!("{count} {are} not finite in the patch, {first}{value} in its column {x}, row {y}");
            return Err(Invalid::new("patch", message).help("choose a patch of finite values"));
        }
        Ok(Self { width, height, values })
    }

    /// Squares of `side` × `side` pixels side by side from the top-left corner on.
    pub(super) fn squares(&self, side: usize) -> impl Iterator<Item = Self> + '_ {
        let corners = move |length: usize| (0..(length + 1).saturating_sub(side)).step_by(side);
        let square = move |x: usize, y: usize| {
            let row = |y: usize| self.values[y * self.width + x..][..side].iter().copied();
            Self { width: side, height: side, values: (y..y + side).flat_map(row).collect() }
        };
        corners(self.height).flat_map(move |y| corners(self.width).map(move |x| square(x, y)))
    }

    pub(super) fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }
}

/// A variance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Variance {
    /// σ².
    pub variance: f64,
    /// Standard error of the variance, σ²·√(2/freedom).
    pub error: f64,
    /// σ.
    pub sigma: f64,
}

impl Variance {
    /// Variance from a sum of squared deviations with this number of degrees of freedom.
    pub(super) fn of(squares: f64, freedom: f64) -> Self {
        let variance = squares / freedom;
        Self { variance, error: variance * (2.0 / freedom).sqrt(), sigma: variance.sqrt() }
    }
}
