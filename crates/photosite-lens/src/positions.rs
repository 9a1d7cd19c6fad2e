//! How gaps change with zoom and focus: curves through the positions of a prescription.

use photosite_core::Invalid;
use photosite_core::math::monotone_cubic::MonotoneCubic;
use photosite_core::spectrum::dispersion::lines;

use crate::lens::Lens;
use crate::prescription::Position;

/// Positions of a zoom are told apart by focal lengths that differ by more than this part.
const DISTINCT: f64 = 1e-6;
/// How far beyond its ends a zoom may be set, as a part of the focal length: engravings are rounded.
const BEYOND_ENDS: f64 = 0.01;
/// Steps of the searches for a focal length and for the compensating gap, and when they end.
const MOST_STEPS: usize = 60;
const FOCAL_LENGTH_PRECISION: f64 = 1e-9;
const COMPENSATION_MM: f64 = 1e-9;
/// The step by which the effect of a gap on the image is found, mm.
const STEP_MM: f64 = 1e-4;

/// Gaps and the stop's radius as functions of one parameter.
#[derive(Clone, Debug)]
pub struct GapCurves {
    /// Of each gap that changes: its surface and its thickness, mm.
    gaps: Vec<(usize, MonotoneCubic)>,
    /// Radius of the stop, mm, where it changes.
    stop: Option<MonotoneCubic>,
    /// Parameters of the positions, rising.
    parameters: Vec<f64>,
}

impl GapCurves {
    /// The curves of a lens through positions, each with its parameter; `None` where two parameters are the same or
    /// there are none.
    fn new(lens: &Lens, positions: &[(f64, &Position)]) -> Option<Self> {
        let mut positions = positions.to_vec();
        positions.sort_by(|a, b| a.0.total_cmp(&b.0));
        let parameters: Vec<f64> = positions.iter().map(|(parameter, _)| *parameter).collect();
        let set: Vec<Lens> = positions.iter().map(|(_, position)| lens.in_position(position)).collect();
        let curve = |of: &dyn Fn(&Lens) -> f64| MonotoneCubic::new(parameters.clone(), set.iter().map(of).collect());
        let mut surfaces: Vec<usize> =
            positions.iter().flat_map(|(_, position)| position.gaps.iter().map(|(surface, _)| *surface)).collect();
        surfaces.sort_unstable();
        surfaces.dedup();
        let gaps = surfaces.into_iter().map(|i| Some((i, curve(&|lens| lens.gap_mm(i))?)));
        let changes_stop = positions.iter().any(|(_, position)| position.stop_semi_aperture_mm.is_some());
        Some(Self {
            gaps: gaps.collect::<Option<_>>()?,
            stop: if changes_stop { Some(curve(&Lens::stop_radius_mm)?) } else { None },
            parameters,
        })
    }

    /// The lens at a parameter.
    pub(crate) fn set(&self, lens: &Lens, parameter: f64) -> Lens {
        let gaps: Vec<_> = self.gaps.iter().map(|(surface, curve)| (*surface, curve.eval(parameter))).collect();
        let lens = lens.with_gaps(&gaps);
        self.stop.as_ref().map_or_else(|| lens.clone(), |stop| lens.with_stop_radius(stop.eval(parameter)))
    }

    /// The focus of a lens by the positions of its prescription that say how far what is sharp is: curves over
    /// 1/distance from the first vertex. `None` where fewer than two do.
    pub fn of_focus(lens: &Lens, positions: &[Position]) -> Option<Self> {
        let is_focus = positions.iter().any(|position| position.object_distance_mm.is_some());
        let parameter = |position: &Position| position.object_distance_mm.map_or(0.0, f64::recip);
        let all: Vec<_> = positions.iter().map(|position| (parameter(position), position)).collect();
        if is_focus && all.len() > 1 { Self::new(lens, &all) } else { None }
    }

    /// The greatest parameter: of a focus, that of the nearest distance.
    pub(crate) fn end(&self) -> f64 {
        self.parameters.last().copied().unwrap_or(0.0)
    }
}

impl Lens {
    /// The lens zoomed to a focal length in mm, by the positions of its prescription.
    ///
    /// Gaps follow monotone cubics in the logarithm of the positions' focal lengths. Then the gap that moves the image
    /// most is changed until the paraxial image at the d line is as far from the sensor as the positions about have it, so
    /// that the focus stays.
    pub fn zoomed(&self, positions: &[Position], focal_length_mm: f64) -> Result<Self, Invalid> {
        let efl = |lens: &Self| lens.at(lines::D).first_order().efl_mm;
        let set: Vec<_> = positions.iter().map(|position| (efl(&self.in_position(position)), position)).collect();
        let shortest = set.iter().map(|(efl, _)| *efl).fold(f64::INFINITY, f64::min);
        let longest = set.iter().map(|(efl, _)| *efl).fold(0.0, f64::max);
        let key = "focal_length_mm";
        if longest <= shortest * (1.0 + DISTINCT) {
            let own = efl(self);
            let message =
                format!("the lens has one focal length, {own:.4} mm, and cannot be zoomed to {focal_length_mm} mm");
            return Err(Invalid::new(key, message).help("leave focal_length_mm out"));
        }
        let allowed = shortest * (1.0 - BEYOND_ENDS)..=longest * (1.0 + BEYOND_ENDS);
        if !allowed.contains(&focal_length_mm) {
            let message = format!("the lens zooms from {shortest:.4} to {longest:.4} mm, not to {focal_length_mm} mm");
            return Err(Invalid::new(key, message));
        }
        let by_logarithm: Vec<_> = set.iter().map(|(efl, position)| (efl.ln(), *position)).collect();
        let not_distinct = || Invalid::new(key, "two positions of the lens have the same focal length");
        let curves = GapCurves::new(self, &by_logarithm).ok_or_else(not_distinct)?;
        let defocus =
            |lens: &Self| lens.at(lines::D).image(f64::INFINITY).distance_mm - lens.gap_mm(lens.surfaces().len() - 1);
        let mut defocuses: Vec<_> =
            set.iter().map(|(efl, position)| (efl.ln(), defocus(&self.in_position(position)))).collect();
        defocuses.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (logarithms, defocuses) = defocuses.into_iter().unzip();
        let intended = MonotoneCubic::new(logarithms, defocuses).ok_or_else(not_distinct)?;
        let at = |parameter: f64| curves.set(self, parameter).compensated(&curves, intended.eval(parameter), defocus);
        let target = focal_length_mm.clamp(shortest, longest).ln();
        let mut parameter = target;
        for _ in 0..MOST_STEPS {
            let lens = at(parameter);
            let off = efl(&lens).ln() - target;
            if off.abs() < FOCAL_LENGTH_PRECISION {
                return Ok(lens);
            }
            // The curves go through the positions, so that the focal length rises about as the parameter does.
            parameter -= off;
        }
        Err(Invalid::new(key, format!("the lens finds no setting for {focal_length_mm} mm between its positions")))
    }

    /// The lens with that gap changed which moves its image most, until `defocus` is what is intended.
    fn compensated(self, curves: &GapCurves, intended: f64, defocus: impl Fn(&Self) -> f64) -> Self {
        let effect = |surface: usize| {
            let moved = self.with_gaps(&[(surface, self.gap_mm(surface) + STEP_MM)]);
            (defocus(&moved) - defocus(&self)) / STEP_MM
        };
        let effects = curves.gaps.iter().map(|(surface, _)| (*surface, effect(*surface)));
        let Some((surface, effect)) = effects.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else { return self };
        let mut lens = self;
        for _ in 0..MOST_STEPS {
            let step = (intended - defocus(&lens)) / effect;
            lens = lens.with_gaps(&[(surface, lens.gap_mm(surface) + step)]);
            if step.abs() < COMPENSATION_MM || !step.is_finite() {
                break;
            }
        }
        lens
    }
}
