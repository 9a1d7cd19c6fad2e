//! Photon transfer: system gain, responsivity and saturation from the noise and the signal of bright images.

use photosite_core::units::Seconds;

use super::dark_model::{DarkAt, DarkModel};
use super::frame_stack::StackStatistics;
use super::linearity::Bend;
use super::lines::slope_through_origin;
use super::measured::Measured;

/// Bright images of one light.
#[derive(Clone, Debug)]
pub struct BrightFrames {
    /// Number of the group.
    pub group: usize,
    /// Exposure time, where it is known.
    pub time: Option<Seconds>,
    /// Photons per pixel, where they are known.
    pub photons: Option<f64>,
    /// Statistics of the images.
    pub statistics: StackStatistics,
}

/// Point of the photon transfer curve.
#[derive(Clone, Copy, Debug)]
pub struct TransferPoint {
    /// Number of the group.
    pub group: usize,
    /// Photons per pixel, where they are known.
    pub photons: Option<f64>,
    /// μ_y − μ_y.dark, DN.
    pub signal: Measured,
    /// σ_y² − σ_y.dark² of the pixels, DN².
    pub noise: Measured,
    /// Variance of the pixels in the light and in the dark, DN².
    variances: [Measured; 2],
    /// Signal over the standard deviation that is left of the noise in the average of all images.
    pub clarity: f64,
    /// Mean number in the light, DN.
    pub mean: Measured,
    clipped: f64,
    time: Option<Seconds>,
    /// Whether dark images of the same exposure time were there.
    pub has_dark: bool,
}

/// End of the response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Saturation {
    /// The converter's largest number comes first.
    Converter,
    /// The pixels hold no more: their number there, DN.
    Well(Measured),
    /// The brightest images are below it: their largest signal, DN.
    NotReached(f64),
}

/// Photon transfer curve, from dark to bright, with what follows from it.
#[derive(Clone, Debug)]
pub struct PhotonTransfer {
    /// Points in the order of their signals.
    pub points: Vec<TransferPoint>,
    /// Number of points, from the darkest, that the fits use.
    pub used: usize,
    /// End of the response.
    pub saturation: Saturation,
    /// System gain K, DN/e⁻, or why it cannot be told.
    pub gain: Result<Measured, String>,
    /// Responsivity R, DN per photon, where photons are known.
    pub responsivity: Option<Measured>,
    /// Bend of the response, where light is known and changes enough; where it is told apart from none, gain and responsivity
    /// are those of little light.
    pub bend: Option<Bend>,
}

/// Part of the saturated signal up to which K and R are fitted, as EMVA 1288 has it.
const FITTED: f64 = 0.7;
/// Part of the pixels whose largest numbers would bend a variance.
const MOST_CLIPPED: f64 = 1e-4;

impl PhotonTransfer {
    /// Curve of the bright images of a camera.
    pub fn new(bright: &[BrightFrames], dark: &DarkModel) -> Self {
        let mut points: Vec<TransferPoint> = bright.iter().map(|frames| point(frames, dark)).collect();
        points.sort_by(|a, b| a.signal.value.total_cmp(&b.signal.value));
        let peak = (0..points.len()).max_by(|&a, &b| points[a].noise.value.total_cmp(&points[b].noise.value));
        let (saturation, top) = saturation(&points, peak);
        let fits = |p: &TransferPoint| p.clipped <= MOST_CLIPPED && p.signal.value <= top;
        let used = points.iter().position(|p| !fits(p)).unwrap_or(points.len());
        let bend = bend(&points[..used]);
        let told = bend.filter(Bend::is_told);
        let straightened = |point: &TransferPoint| told.map_or(*point, |bend| point.straightened(bend));
        let fitted: Vec<TransferPoint> = points[..used].iter().map(straightened).collect();
        let gain = system_gain(&fitted, points.is_empty()).map(|gain| match told {
            // The slope of the noise over a signal y has the factor 1 + 3·b·y.
            Some(bend) => {
                let middle = 0.5 * fitted.last().map_or(0.0, |point| point.signal.value);
                let of_bend = gain.value * 3.0 * bend.per_dn.standard_error * middle;
                Measured::new(gain.value, gain.standard_error.hypot(of_bend))
            }
            None => gain,
        });
        let with_photons: Option<Vec<(f64, Measured)>> =
            fitted.iter().map(|p| Some((p.photons.filter(|&photons| photons > 0.0)?, p.signal))).collect();
        let with_photons = with_photons.filter(|points| !points.is_empty());
        let responsivity = with_photons.as_deref().map(slope_through_origin);
        Self { used, saturation, gain, responsivity, bend, points }
    }

    /// Bend of the response where it is told apart from none.
    pub(super) fn told_bend(&self) -> Option<Bend> {
        self.bend.filter(Bend::is_told)
    }

    /// The point of the fits whose average tells patterns best.
    pub fn clearest(&self) -> Option<&TransferPoint> {
        self.points[..self.used].iter().max_by(|a, b| a.clarity.total_cmp(&b.clarity))
    }
}

/// Bend of points whose photons are known, or else their exposure times, which stand for light of which each second is alike.
fn bend(points: &[TransferPoint]) -> Option<Bend> {
    let with = |light: fn(&TransferPoint) -> Option<f64>| -> Option<Vec<(f64, Measured)>> {
        points.iter().map(|point| Some((light(point)?, point.signal))).collect()
    };
    Bend::of(&with(|point| point.photons).or_else(|| with(|point| Some(point.time?.0)))?)
}

impl TransferPoint {
    /// The point that a linear response would give.
    fn straightened(&self, bend: Bend) -> Self {
        let signal = bend.linear(self.signal.value);
        let slope = bend.slope(signal);
        let [bright, dark] = self.variances;
        Self {
            signal: Measured::new(signal, self.signal.standard_error / slope.abs()),
            noise: self.noise.times(slope.powi(-2)),
            variances: [bright.times(slope.powi(-2)), dark],
            ..*self
        }
    }
}

fn point(frames: &BrightFrames, dark: &DarkModel) -> TransferPoint {
    let BrightFrames { group, time, photons, statistics } = frames;
    let DarkAt { mean, variance, is_measured } = dark.at(*time);
    let signal = statistics.mean.minus(mean);
    let own = statistics.temporal.pixel;
    TransferPoint {
        group: *group,
        photons: *photons,
        signal,
        noise: own.minus(variance),
        variances: [own, variance],
        clarity: signal.value * (statistics.images as f64 / own.value.max(f64::MIN_POSITIVE)).sqrt(),
        mean: statistics.mean,
        clipped: statistics.clipped,
        time: *time,
        has_dark: is_measured,
    }
}

/// End of the response, and the signal up to which K and R are fitted. The noise of pixels that hold no more light falls
/// to that of the read-out.
fn saturation(points: &[TransferPoint], peak: Option<usize>) -> (Saturation, f64) {
    let (Some(peak), Some(brightest)) = (peak, points.last()) else { return (Saturation::NotReached(0.0), 0.0) };
    if brightest.clipped > 0.5 {
        return (Saturation::Converter, FITTED * brightest.signal.value);
    }
    let falls = brightest.noise.value < 0.5 * points[peak].noise.value;
    if falls && brightest.signal.value > points[peak].signal.value {
        return (Saturation::Well(brightest.mean), FITTED * brightest.signal.value);
    }
    (Saturation::NotReached(brightest.signal.value), f64::INFINITY)
}

/// K, the slope of noise over signal through the origin. Weights are those of the errors that the fitted line expects:
/// measured ones follow the values, and would prefer those that are too small by chance.
fn system_gain(points: &[TransferPoint], no_bright: bool) -> Result<Measured, String> {
    if no_bright {
        return Err("there are no bright images".to_owned());
    }
    if points.is_empty() {
        return Err("all bright images are saturated".to_owned());
    }
    let alone = |p: &TransferPoint| (p.signal.value, p.noise);
    let mut gain = slope_through_origin(&points.iter().map(alone).collect::<Vec<_>>());
    for _ in 0..2 {
        let expected = |p: &TransferPoint| {
            let [bright, dark] = p.variances;
            let model = dark.value + (gain.value * p.signal.value).max(0.0);
            let error = (bright.relative_error() * model).hypot(dark.standard_error);
            (p.signal.value, Measured::new(p.noise.value, error))
        };
        let fitted: Vec<_> = points.iter().map(expected).collect();
        gain = slope_through_origin(&fitted);
        gain.standard_error = gain.standard_error.hypot(shared_dark_error(points, &fitted));
    }
    if gain.value > 10.0 * gain.standard_error {
        return Ok(gain);
    }
    Err("the noise of the bright images does not grow with their signal, as that of light does".to_owned())
}

/// Error of the slope beyond that of independent points where several have the same dark images: what these are off
/// by moves all of them.
fn shared_dark_error(points: &[TransferPoint], fitted: &[(f64, Measured)]) -> f64 {
    let weight = |y: &Measured| y.standard_error.powi(-2);
    let total: f64 = fitted.iter().map(|(x, y)| weight(y) * x * x).sum();
    let mut of_times: Vec<(Option<Seconds>, f64, f64, f64)> = Vec::new();
    for (point, (x, y)) in points.iter().zip(fitted) {
        let part = weight(y) * x;
        match of_times.iter_mut().find(|(time, ..)| *time == point.time) {
            Some((_, sum, squares, _)) => (*sum, *squares) = (*sum + part, *squares + part * part),
            None => of_times.push((point.time, part, part * part, point.variances[1].standard_error)),
        }
    }
    of_times.iter().map(|(_, sum, squares, error)| (sum * sum - squares) * error * error).sum::<f64>().sqrt() / total
}
