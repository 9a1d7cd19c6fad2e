//! Place of the sensor behind a lens and distance of the plane of focus, to first order, with all elements of the lens.
//!
//! A ray that leaves the main lens at the height a from the axis comes from the sensor point at the height s, at the
//! distance v, and has the slope c − a·q there, with c = −s/v and q = P − 1/v, the main lens's power less the vergence
//! of what comes from the sensor. The elements before it, from the main lens outwards, turn (height, slope) by a matrix
//! ((A, B), (C, D)) with AD − BC = 1 ([Born99](photosite_core::references#born99) §4.4). Seen from the scene this is
//! one thin lens again, which stands in the entrance pupil: its heights are a/D, its chief rays have the slope D·c,
//! and what is sharp lies at the distance u from it with 1/u = D·(D·q − C).

use super::element::NOMINAL_NM;
use super::{Focus, LensDescription, LensKind};
use photosite_core::Invalid;
use photosite_core::spectrum::Spectrum;

/// Ratio of numbers that are equal but for rounding.
const NEARLY: f64 = 1.0 - 1e-12;

/// A focused lens.
#[derive(Clone, Debug)]
pub(super) struct Focusing {
    /// Distance main lens → sensor v, m.
    pub(super) image_distance_m: f64,
    /// Distance entrance pupil → plane of focus u along the axis, m: infinite where focused at infinity, below 0 where
    /// rays of a sensor point leave the lens as if they came from a point behind it.
    pub(super) focus_distance_m: f64,
    /// Coefficient D of the elements before the main lens; 1 without any.
    pub(super) chief_slope: f64,
    /// Distance v of the sensor where the lens is focused at infinity, m; `None` where no sensor could stand.
    pub(super) image_distance_at_infinity_m: Option<f64>,
    /// Chromatic aberration; `None` for a lens that is the same at all wavelengths.
    pub(super) chromatic: Option<ChromaticFocus>,
}

/// Longitudinal chromatic aberration: the focus by wavelength.
#[derive(Clone, Debug)]
pub(super) struct ChromaticFocus {
    /// Vergence 1/u at each wavelength, m⁻¹, of the pupil at the nominal one, whose place and size stand for those at
    /// all.
    per_m: Spectrum,
    /// Size of the image over that at the nominal wavelength: D of elements at a distance.
    pub(super) magnification: Spectrum,
}

impl ChromaticFocus {
    /// Distance u of the plane of focus at a wavelength in nm, m.
    #[inline]
    pub(super) fn focus_distance_m(&self, lambda_nm: f32) -> f64 {
        1.0 / f64::from(self.per_m.eval(lambda_nm))
    }
}

/// The elements before the main lens at one wavelength.
#[derive(Clone, Copy)]
struct Front {
    b: f64,
    c: f64,
    d: f64,
}

impl Front {
    fn new(lens: &LensDescription, lambda_nm: f64) -> Self {
        let mut elements: Vec<_> = lens.supplementary.iter().collect();
        elements.sort_by(|one, other| one.distance_m.total_cmp(&other.distance_m));
        let (mut a, mut b, mut c, mut d, mut at) = (1.0, 0.0, 0.0, 1.0, 0.0);
        for element in elements {
            // On to the element, and refracted by it.
            let gap = element.distance_m - at;
            (a, b, at) = (a + gap * c, b + gap * d, element.distance_m);
            let power = element.power.at(lambda_nm);
            (c, d) = (c - power * a, d - power * b);
        }
        Self { b, c, d }
    }

    /// Vergence 1/u in front of these elements, for the vergence q behind them.
    fn seen(&self, q: f64) -> f64 {
        self.d * (self.d * q - self.c)
    }

    /// The vergence q that makes what is at the distance u sharp.
    fn needed(&self, u: f64) -> f64 {
        (1.0 / u / self.d + self.c) / self.d
    }
}

impl Focusing {
    /// Focuses a lens; `autofocus_distance_m` is what autofocus found, see [`Camera::new`](super::Camera::new).
    pub(super) fn new(lens: &LensDescription, autofocus_distance_m: f64) -> Result<Self, Invalid> {
        let f = lens.focal_length_m;
        let alone = |image_distance_m: f64, focus_distance_m: f64| Self {
            image_distance_m,
            focus_distance_m,
            chief_slope: 1.0,
            image_distance_at_infinity_m: None,
            chromatic: None,
        };
        match lens.kind {
            // A prescription has a focus of its own.
            LensKind::Pinhole | LensKind::Bare | LensKind::Prescription => return Ok(alone(f, f64::INFINITY)),
            // A hole bends nothing: 1/u = 0 − 1/v.
            LensKind::Hole => return Ok(alone(f, -f)),
            LensKind::Thin => {}
        }
        let front = Front::new(lens, NOMINAL_NM);
        if front.d <= 0.0 {
            let message = "these lenses form an image before the main lens";
            return Err(Invalid::new("supplementary", message).help("take weaker ones, or put them nearer to it"));
        }
        // As it focuses, with the elements before it.
        let focused = |v: f64, u: f64| {
            let at_infinity = 1.0 / (1.0 / f - front.needed(f64::INFINITY));
            Self {
                image_distance_m: v,
                focus_distance_m: u,
                chief_slope: front.d,
                // The main lens goes no nearer to the sensor than where it is focused at infinity.
                image_distance_at_infinity_m: Some(at_infinity).filter(|v| v.is_finite() && *v >= f.max(0.0) * NEARLY),
                chromatic: chromatic(lens, v),
            }
        };
        let (key, u) = match lens.focus {
            Focus::Infinity => ("focus_distance_m", f64::INFINITY),
            Focus::Distance(u) => ("focus_distance_m", u),
            Focus::Autofocus { .. } => ("autofocus_px", lens.within_focus_range(autofocus_distance_m)),
            Focus::ImageDistance(v) => {
                let u = 1.0 / front.seen(1.0 / f - 1.0 / v);
                return Ok(focused(v, u));
            }
        };
        let v = if lens.supplementary.is_empty() {
            if u.is_infinite() { f } else { u * f / (u - f) }
        } else {
            1.0 / (1.0 / f - front.needed(u))
        };
        if !(v > 0.0 && v.is_finite()) {
            return Err(unfocused(lens, key, u));
        }
        // The main lens goes from infinity to its nearest distance, and no element stands behind what is sharp.
        let main = 1.0 / front.needed(u);
        let is_too_near = lens.min_focus_distance_m.is_some_and(|nearest| main < nearest * NEARLY);
        if !lens.supplementary.is_empty() && (main < 0.0 || is_too_near || u <= front.b / front.d) {
            return Err(unreached(lens, &front, key, u));
        }
        Ok(focused(v, u))
    }
}

fn chromatic(lens: &LensDescription, v: f64) -> Option<ChromaticFocus> {
    let is_same = |ground: &super::GroundLens| ground.index.is_constant();
    if lens.ground.as_ref().is_none_or(is_same) && lens.supplementary.iter().all(|element| element.power.is_constant())
    {
        return None;
    }
    let power = |lambda_nm| lens.ground.as_ref().map_or(1.0 / lens.focal_length_m, |ground| ground.power(lambda_nm));
    let nominal = Front::new(lens, NOMINAL_NM).d;
    Some(ChromaticFocus {
        per_m: Spectrum::from_fn(|lambda| {
            let Front { c, d, .. } = Front::new(lens, lambda);
            nominal * (d * (power(lambda) - 1.0 / v) - c)
        }),
        magnification: Spectrum::from_fn(|lambda| Front::new(lens, lambda).d / nominal),
    })
}

fn unfocused(lens: &LensDescription, key: &str, u: f64) -> Invalid {
    let f_mm = lens.focal_length_m * 1e3;
    if key == "autofocus_px" {
        // As precise as intersections are.
        let distance = u as f32;
        let message =
            format!("what is there is {distance} m away, within the focal length of {} m", lens.focal_length_m);
        return Invalid::new(key, message).help("move the camera back or shorten the focal length");
    }
    let message = format!("no place of the sensor behind the lens of {f_mm} mm makes what is {u} m away sharp");
    Invalid::new(key, message).help("write another distance, or image_distance_mm, where the sensor stands")
}

fn unreached(lens: &LensDescription, front: &Front, key: &str, u: f64) -> Invalid {
    if u <= front.b / front.d {
        let message = format!("what is {u} m away lies behind the supplementary lenses");
        return Invalid::new(key, message).help("write a larger distance");
    }
    // As precise as anybody reads a scale.
    let seen = |q: f64| (1.0 / front.seen(q)) as f32;
    let nearest = lens.min_focus_distance_m.map(|nearest| seen(1.0 / nearest));
    let farthest = seen(0.0);
    let range = match nearest {
        Some(nearest) if front.needed(u) > 0.0 => format!("no nearer than {nearest} m"),
        Some(_) | None if farthest > 0.0 => format!("no farther than {farthest} m"),
        Some(_) | None => "nowhere".to_owned(),
    };
    let message = format!("through its supplementary lenses the lens focuses {range}, not at {u} m");
    let image_distance_mm = 1e3 / (1.0 / lens.focal_length_m - front.needed(u));
    Invalid::new(key, message).help(format!(
        "write another distance; or image_distance_mm = {image_distance_mm:.6}, for a sensor where this lens does not bring it"
    ))
}
