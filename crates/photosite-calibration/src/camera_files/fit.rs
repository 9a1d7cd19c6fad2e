//! Fit of a calibration tool's model to a lens that is traced.
//!
//! The chief rays of a lens from a prescription follow no formula, and do not meet in one point. As in a calibration,
//! the model of least squared error over the image is chosen, for points at the distance that the lens is focused on.

use glam::{DVec2, DVec3};

use photosite_core::math::linear::least_squares;
use photosite_core::projection::{BrownConrady, Intrinsics, Projection};
use photosite_transport::optics::Camera;

/// Columns and rows of the grid of positions, whose border is that of the image.
const PLACES: [u32; 2] = [97, 73];
/// Tolerance of the choice, px: the first model that is nowhere farther from the lens is taken, as no calibration tells
/// closer ones apart.
const SAME_PX: f64 = 0.02;
/// Rounds of reweighting, after which the squares of a fraction's own error are weighted right.
const ROUNDS: usize = 8;

/// Models to choose from, from few coefficients to many. All are OpenCV's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Models {
    /// Brown–Conrady's k₁ k₂, k₁ k₂ k₃ or k₁ … k₆, or a fisheye for a lens that sees too much for these: the models of
    /// OpenCV, ROS and COLMAP.
    Rational,
    /// Brown–Conrady's k₁ k₂, or a fisheye: the models of Kalibr and EuRoC.
    Radtan,
}

impl Models {
    fn of_a_lens(self, is_flat: bool) -> &'static [Form] {
        match (self, is_flat) {
            (_, false) => &[Form::Fisheye],
            (Self::Rational, true) => &[
                Form::Radial { over: 2, under: 0 },
                Form::Radial { over: 3, under: 0 },
                Form::Radial { over: 3, under: 3 },
            ],
            (Self::Radtan, true) => &[Form::Radial { over: 2, under: 0 }, Form::Fisheye],
        }
    }
}

#[derive(Clone, Copy)]
enum Form {
    /// Brown and Conrady's model, with the numbers of coefficients above and below the fraction bar.
    Radial { over: usize, under: usize },
    /// Kannala and Brandt's model.
    Fisheye,
}

/// Model fitted to a traced lens, and its distance from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedLens {
    /// Intrinsics in photosite's coordinates, where the centre of the first pixel is 0.5, 0.5.
    pub intrinsics: Intrinsics,
    /// Projection of the model.
    pub projection: Projection,
    /// Root mean square of the distances between positions by the model and by the lens, over the image, px.
    pub rms_px: f64,
    /// Largest of the distances between positions by the model and by the lens, px.
    pub largest_px: f64,
    /// Distance from the camera's origin of the points that the model was fitted to, m: along the axis, or the
    /// Euclidean distance for a lens that sees a half-space or more. Infinite for a lens focused at infinity.
    pub distance_m: f64,
}

/// Position in the image, and the direction from which its light comes.
struct Sighting {
    pixel: DVec2,
    /// Unit vector from the camera's origin in OpenCV's axes, to the point at the distance of the focus.
    towards: DVec3,
    /// Distance from the principal point in normalised coordinates.
    radius: f64,
}

impl FittedLens {
    /// Fit to the lens of a camera; `None` where no model shows all that the lens shows of its image.
    pub fn new(camera: &Camera, models: Models) -> Option<Self> {
        let distance_m = Some(camera.focus_distance_m()).filter(|distance| *distance > 0.0).unwrap_or(f64::INFINITY);
        let is_flat = camera.projection().is_flat();
        let sightings = sightings(camera, distance_m, is_flat);
        let mut best: Option<Self> = None;
        for form in models.of_a_lens(is_flat) {
            let Some(fitted) = form.fitted(camera.intrinsics(), &sightings, distance_m) else { continue };
            if best.is_none_or(|best| fitted.rms_px < best.rms_px) {
                best = Some(fitted);
            }
            if fitted.largest_px <= SAME_PX {
                break;
            }
        }
        best
    }
}

/// Positions of a grid over the image that light reaches.
fn sightings(camera: &Camera, distance_m: f64, is_flat: bool) -> Vec<Sighting> {
    let [width, height] = camera.resolution().map(f64::from);
    let [columns, rows] = PLACES;
    let part = |i: u32, count: u32| f64::from(i) / f64::from(count - 1);
    let place = |i: u32| DVec2::new(width * part(i % columns, columns), height * part(i / columns, rows));
    let sighting = |pixel: DVec2| {
        camera.relative_illumination(pixel).filter(|part| *part > 0.0)?;
        let (origin, direction) = camera.line_of_sight(pixel)?;
        let along = if is_flat { (distance_m + origin.z) / -direction.z } else { distance_m };
        let towards = if distance_m.is_finite() { origin + direction * along } else { direction };
        let radius = camera.intrinsics().place(pixel).length();
        Some(Sighting { pixel, towards: DVec3::new(towards.x, -towards.y, -towards.z).normalize(), radius })
    };
    (0..columns * rows).map(place).filter_map(sighting).collect()
}

impl Form {
    /// Model with the coefficients of least error. A lens is rotationally symmetric, and so is the model.
    fn fitted(self, near: Intrinsics, sightings: &[Sighting], distance_m: f64) -> Option<FittedLens> {
        let (over, under) = match self {
            Self::Radial { over, under } => (over + 1, under),
            Self::Fisheye => (5, 0),
        };
        let variable = |sighting: &Sighting| {
            let across = sighting.towards.truncate().length();
            match self {
                Self::Radial { .. } => across / sighting.towards.z,
                Self::Fisheye => across.atan2(sighting.towards.z),
            }
        };
        let points: Vec<(f64, f64)> = sightings.iter().map(|sighting| (variable(sighting), sighting.radius)).collect();
        let largest = points.iter().map(|(x, _)| *x).fold(0.0, f64::max);
        if !(largest > 0.0 && largest.is_finite()) || points.iter().any(|(x, _)| *x < 0.0) {
            return None;
        }
        let fraction = fraction(&points, largest, over, under)?;
        let (size, k) = (fraction.over[0] / largest, fraction.coefficients(largest));
        let projection = match self {
            Self::Radial { .. } => {
                let k = std::array::from_fn(|i| {
                    let (from, i) = if i < 3 { (0, i) } else { (over - 1, i - 3) };
                    let has = if from == 0 { i < over - 1 } else { i < under };
                    if has { k[from + i] } else { 0.0 }
                });
                Projection::BrownConrady(BrownConrady { k, ..BrownConrady::default() })
            }
            Self::Fisheye => Projection::KannalaBrandt { k: std::array::from_fn(|i| k[i]) },
        };
        let intrinsics = Intrinsics { fx: near.fx * size, fy: near.fy * size, ..near };
        let reach = projection.reach(None);
        let (mut squares, mut largest_px) = (0.0, 0.0_f64);
        for sighting in sightings {
            let off = intrinsics.pixel(projection.project(sighting.towards, &reach)?).distance(sighting.pixel);
            squares += off * off;
            largest_px = largest_px.max(off);
        }
        let rms_px = (squares / sightings.len() as f64).sqrt();
        Some(FittedLens { intrinsics, projection, rms_px, largest_px, distance_m })
    }
}

/// Fraction y = Σ aᵢ·q^(2i + 1)/(1 + Σ bⱼ·q^(2j)) with q = x over the largest x.
struct Fraction {
    over: Vec<f64>,
    under: Vec<f64>,
}

impl Fraction {
    /// Coefficients of the fraction in x in place of q, divided by that of x itself.
    fn coefficients(&self, largest: f64) -> Vec<f64> {
        let power = |i: usize| largest.powi(2 * (i as i32 + 1));
        let over = self.over.iter().skip(1).enumerate().map(|(i, a)| a / self.over[0] / power(i));
        let under = self.under.iter().enumerate().map(|(j, b)| b / power(j));
        over.chain(under).collect()
    }
}

/// Fraction of least error, by linear least squares of y·(1 + Σ bⱼ·q^(2j)) − Σ aᵢ·q^(2i + 1), each point divided by the
/// denominator of the round before, so that the error of y counts in the end.
fn fraction(points: &[(f64, f64)], largest: f64, over: usize, under: usize) -> Option<Fraction> {
    let mut below = vec![1.0; points.len()];
    let mut found = None;
    for _ in 0..if under == 0 { 1 } else { ROUNDS } {
        let rows: Vec<Vec<f64>> = points
            .iter()
            .zip(&below)
            .map(|(&(x, y), below)| {
                let q = x / largest;
                let above = (0..over).map(|i| q.powi(2 * i as i32 + 1));
                above.chain((1..=under).map(|j| -y * q.powi(2 * j as i32))).map(|term| term / below).collect()
            })
            .collect();
        let wanted = points.iter().zip(&below).map(|(&(_, y), below)| y / below).collect();
        let mut over_terms = least_squares(rows, wanted)?;
        let under_terms = over_terms.split_off(over);
        let value = |x: f64| {
            let q2 = (x / largest).powi(2);
            1.0 + under_terms.iter().rev().fold(0.0, |sum, b| q2 * (b + sum))
        };
        below = points.iter().map(|(x, _)| value(*x)).collect();
        if below.iter().any(|value| *value <= 0.0) {
            return None;
        }
        found = Some(Fraction { over: over_terms, under: under_terms });
    }
    found
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;
    use photosite_transport::optics::{Focus, LensDescription, PixelGrid};

    use super::*;

    const GRID: PixelGrid = PixelGrid { resolution: [640, 480], pitch_m: [6e-6, 8e-6] };

    fn camera(projection: Projection, focus: Focus) -> Camera {
        let mut lens = LensDescription::thin(0.004, 4.0, focus);
        lens.projection = projection;
        Camera::new(&lens, &GRID, DAffine3::IDENTITY, f64::NAN).expect("a lens")
    }

    fn brown_conrady(k: [f64; 6]) -> Projection {
        Projection::BrownConrady(BrownConrady { k, ..BrownConrady::default() })
    }

    /// Test: a lens that is one of the models is found again, in each of them.
    #[test]
    fn models_find_themselves() {
        for (projection, models) in [
            (brown_conrady([-0.1, 0.02, 0.0, 0.0, 0.0, 0.0]), Models::Radtan),
            (brown_conrady([-0.1, 0.02, -0.1, 0.0, 0.0, 0.0]), Models::Rational),
            (brown_conrady([0.3, 0.05, 0.02, 0.2, 0.1, 0.05]), Models::Rational),
            (Projection::KannalaBrandt { k: [-0.02, 0.003, -0.001, 0.0] }, Models::Radtan),
            (Projection::KannalaBrandt { k: [-0.02, 0.003, -0.001, 0.0] }, Models::Rational),
        ] {
            for focus in [Focus::Infinity, Focus::Distance(0.5)] {
                let camera = camera(projection, focus);
                let fitted = FittedLens::new(&camera, models).expect("a model");
                assert!(fitted.largest_px < SAME_PX, "{projection:?} {fitted:?}");
                assert!(
                    (fitted.intrinsics.fx / camera.intrinsics().fx - 1.0).abs() < 1e-4,
                    "{projection:?} {fitted:?}"
                );
                assert_eq!(fitted.distance_m, camera.focus_distance_m());
            }
        }
    }

    #[test]
    fn the_fewest_coefficients_that_do_are_taken() {
        let camera = camera(Projection::Perspective, Focus::Infinity);
        let fitted = FittedLens::new(&camera, Models::Rational).expect("a model");
        let Projection::BrownConrady(BrownConrady { k: [k1, k2, rest @ ..], .. }) = fitted.projection else { panic!() };
        assert!(k1.abs() < 1e-9 && k2.abs() < 1e-9 && rest == [0.0; 4], "{fitted:?}");
        assert!(fitted.rms_px < 1e-9, "{fitted:?}");
    }
}
