//! Point spreads that were measured.

use glam::DVec2;

use photosite_core::Invalid;
use photosite_core::math::distribution::PiecewiseConstant2D;

/// Kernel: a measured image of a point, even within each of its cells. Its origin lies where the lens puts the point.
#[derive(Clone, Debug)]
pub struct Kernel {
    distribution: PiecewiseConstant2D,
    /// Number of columns.
    width: usize,
    /// Width and height, m.
    size_m: DVec2,
    /// Origin in parts of the size, from the first column and the first row on.
    origin: DVec2,
    values: Vec<f32>,
}

impl PartialEq for Kernel {
    fn eq(&self, other: &Self) -> bool {
        (&self.values, self.size_m, self.origin) == (&other.values, other.size_m, other.origin)
    }
}

impl Kernel {
    /// Makes a kernel from rows of values of cells `pitch_m` apart; only the ratios of the values count. Its origin is
    /// the middle of its rows and columns: the centre of a cell where their number is odd, and where it is even the
    /// edge between two.
    pub fn new(rows: &[Vec<f32>], pitch_m: f64) -> Result<Self, Invalid> {
        let width = rows.first().map_or(0, Vec::len);
        let values: Vec<f32> = rows.iter().flatten().copied().collect();
        let sum: f64 = values.iter().copied().map(f64::from).sum();
        let usable = |v: &f32| v.is_finite() && *v >= 0.0;
        if width == 0 || rows.iter().any(|row| row.len() != width) || !values.iter().all(usable) || sum <= 0.0 {
            let message = "is not an image of a point";
            return Err(Invalid::new("", message).help("write rows of equally many numbers, 0 or more, not all 0"));
        }
        Ok(Self {
            distribution: PiecewiseConstant2D::new(&values, width),
            width,
            size_m: DVec2::new(width as f64, rows.len() as f64) * pitch_m,
            origin: DVec2::splat(0.5),
            values,
        })
    }

    /// Returns the kernel with its origin at the centroid of its light, so that it shifts no image.
    #[must_use]
    pub fn about_centroid(self) -> Self {
        let origin = self.origin + self.centroid_m() / self.size_m;
        Self { origin, ..self }
    }

    /// Centroid of the kernel's light, m to the right of and below its origin: the shift that the kernel gives to the
    /// image.
    pub fn centroid_m(&self) -> DVec2 {
        let size = DVec2::new(self.width as f64, (self.values.len() / self.width) as f64);
        let centre = |i: usize| DVec2::new((i % self.width) as f64 + 0.5, (i / self.width) as f64 + 0.5);
        let sum: f64 = self.values.iter().copied().map(f64::from).sum();
        let moment: DVec2 = self.values.iter().enumerate().map(|(i, &v)| centre(i) * f64::from(v)).sum();
        (moment / sum / size - self.origin) * self.size_m
    }

    /// An offset from which light comes, m. A point spreads to the right where a pixel gathers from the left.
    #[inline]
    pub(super) fn sample(&self, u: [f32; 2]) -> DVec2 {
        let ([x, y], _) = self.distribution.sample(u);
        (self.origin - DVec2::new(f64::from(x), f64::from(y))) * self.size_m
    }
}

/// Kernels at places of the image, of which the nearest counts.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelField(Vec<(DVec2, Kernel)>);

impl KernelField {
    /// Takes at least one kernel; places go from −1 at the left and the top edge to 1 at the opposite ones.
    pub fn new(kernels: Vec<(DVec2, Kernel)>) -> Result<Self, Invalid> {
        if kernels.is_empty() {
            return Err(Invalid::new("kernels", "there is none").help("write { file = \"psf.csv\", at = [0, 0] }"));
        }
        Ok(Self(kernels))
    }

    #[inline]
    pub(super) fn nearest(&self, place: DVec2) -> &Kernel {
        let distance = |(at, _): &(DVec2, Kernel)| (*at - place).length_squared();
        let mut nearest = &self.0[0];
        for kernel in &self.0[1..] {
            if distance(kernel) < distance(nearest) {
                nearest = kernel;
            }
        }
        &nearest.1
    }
}
