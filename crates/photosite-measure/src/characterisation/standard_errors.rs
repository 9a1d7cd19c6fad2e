//! Standard errors of measured figures, from the numbers of pixels and images.

use super::evaluation::{Evaluation, TemporalPoint};
use super::spatial::{SpatialStack, SpatialVariances};

/// Relative standard errors of the figures of an evaluation; `None` of those that are no mean of pixels, as saturation
/// is, which a set knows to one of its steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RelativeErrors {
    /// K, and with it η.
    pub gain: f64,
    /// R.
    pub responsivity: f64,
    /// σ_y.dark.
    pub dark_noise_dn: f64,
    /// σ_d.
    pub dark_noise_e: f64,
    /// DSNU in total, of rows, columns and pixels.
    pub dsnu: [Option<f64>; 4],
    /// PRNU alike.
    pub prnu: [Option<f64>; 4],
}

impl RelativeErrors {
    /// Errors of images of `pixels`, with normal noise: a variance of n differences has a standard error of √(2/n) of
    /// it, a mean of two images one of σ/√(2n). The fits are those of [`evaluate`](super::evaluate()).
    pub fn new(e: &Evaluation, pixels: f64, stacks: Option<&[SpatialStack; 2]>) -> Self {
        let fitted = &e.points[..=e.last_fitted];
        let over = |points: &[TemporalPoint], x: &dyn Fn(&TemporalPoint) -> f64, v: &dyn Fn(&TemporalPoint) -> f64| {
            let xx: f64 = points.iter().map(|p| x(p).powi(2)).sum();
            points.iter().map(|p| x(p).powi(2) * v(p)).sum::<f64>().sqrt() / xx
        };
        let of_noise = |p: &TemporalPoint| 2.0 / pixels * (p.variance.powi(2) + p.dark_variance.powi(2));
        let of_signal = |p: &TemporalPoint| (p.variance + p.dark_variance) / (2.0 * pixels);
        let f = &e.figures;
        let gain = over(fitted, &TemporalPoint::signal, &of_noise) / f.system_gain_dn_per_e;
        let responsivity = over(fitted, &|p| p.photons, &of_signal) / f.responsivity_dn_per_p;
        let dark_variance = dark_variance_error(e, pixels);
        let squared = f.dark_noise_dn.powi(2);
        let without_quantisation = (squared - 1.0 / 12.0).max(f64::MIN_POSITIVE);
        let spatial = stacks.zip(e.spatial).map(|(stacks, [dark, bright])| {
            let [of_dark, of_bright] = [errors_of(&dark, &stacks[0]), errors_of(&bright, &stacks[1])];
            let parts = |v: &SpatialVariances| [v.total, v.row, v.column, v.pixel];
            let [dark, bright] = [parts(&dark), parts(&bright)];
            let relative = |variance: f64, error: f64| (variance > 0.0).then(|| error / (2.0 * variance));
            let dsnu = [0, 1, 2, 3].map(|i| relative(dark[i], of_dark[i]).map(|r| r.hypot(gain)));
            let prnu = [0, 1, 2, 3].map(|i| relative(bright[i] - dark[i], of_bright[i].hypot(of_dark[i])));
            (dsnu, prnu)
        });
        let (dsnu, prnu) = spatial.unwrap_or_default();
        Self {
            gain,
            responsivity,
            dark_noise_dn: dark_variance / (2.0 * squared),
            dark_noise_e: (dark_variance / (2.0 * without_quantisation)).hypot(gain),
            dsnu,
            prnu,
        }
    }

    /// Relative standard error of a row of [`Figures::rows`](super::Figures::rows) by its symbol and unit.
    pub fn of_row(&self, symbol: &str, unit: &str) -> Option<f64> {
        let part = |errors: &[Option<f64>; 4]| {
            let ending = symbol.rsplit_once('.').map_or("", |(_, part)| part);
            errors[["row", "col", "pixel"].iter().position(|name| *name == ending).map_or(0, |i| i + 1)]
        };
        match (symbol, unit) {
            ("η", _) => Some(self.gain.hypot(self.responsivity)),
            ("K" | "1/K", _) => Some(self.gain),
            ("R", _) => Some(self.responsivity),
            ("σ_d", _) => Some(self.dark_noise_e),
            ("σ_y.dark", _) => Some(self.dark_noise_dn),
            (symbol, _) if symbol.starts_with("DSNU") => part(&self.dsnu),
            (symbol, _) if symbol.starts_with("PRNU") => part(&self.prnu),
            (_, _) => None,
        }
    }
}

/// Standard error of σ_y.dark² at no exposure time, DN²: that of the offset of a line, or of one variance.
fn dark_variance_error(e: &Evaluation, pixels: f64) -> f64 {
    let own = |variance: f64| (2.0 / pixels).sqrt() * variance;
    let count = e.darks.len() as f64;
    let mean = e.darks.iter().map(|dark| dark.time.0).sum::<f64>() / count;
    let spread: f64 = e.darks.iter().map(|dark| (dark.time.0 - mean).powi(2)).sum();
    if e.dark_current.is_none_or(|fit| fit.variance.is_none()) || spread == 0.0 {
        return e.darks.first().map_or(0.0, |dark| own(dark.variance));
    }
    let weight = |time: f64| 1.0 / count - mean * (time - mean) / spread;
    e.darks.iter().map(|dark| (weight(dark.time.0) * own(dark.variance)).powi(2)).sum::<f64>().sqrt()
}

/// Standard errors of a stack's total, row, column and pixel variances, DN². A variance of n numbers spreads by √(2/n) of
/// itself with what is on top of it: rows of N pixels have a part 1/N of the pixels' pattern and of the noise that is left.
fn errors_of(v: &SpatialVariances, stack: &SpatialStack) -> [f64; 4] {
    let [columns, rows] = stack.size().map(|side| side as f64);
    let pixel = v.pixel.max(0.0) + v.temporal / f64::from(stack.count());
    let error = |variance: f64, on_top: f64, n: f64| (2.0 / n).sqrt() * (variance.max(0.0) + on_top);
    let parts = [
        error(v.row, pixel / columns, rows),
        error(v.column, pixel / rows, columns),
        error(pixel, 0.0, rows * columns),
    ];
    let total = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
    [total, parts[0], parts[1], parts[2]]
}
