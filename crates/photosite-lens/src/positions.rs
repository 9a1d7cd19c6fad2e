//! Zoom and focus: curves of the gaps through the positions of a prescription.

use photosite_core::Invalid;
use photosite_core::math::monotone_cubic::MonotoneCubic;
use photosite_core::spectrum::dispersion::lines;

use crate::lens::Lens;
use crate::prescription::Position;

/// Relative difference of focal lengths above which positions of a zoom are distinct.
const DISTINCT: f64 = 1e-6;
/// Margin of a zoom beyond its ends, relative to the focal length: engravings are rounded.
const BEYOND_ENDS: f64 = 0.01;
/// Largest number of steps of the searches for a focal length and for the compensating gap, and their final precisions.
const MOST_STEPS: usize = 60;
const FOCAL_LENGTH_PRECISION: f64 = 1e-9;
const COMPENSATION_MM: f64 = 1e-9;
/// Step for the derivative of the image position by a gap, mm.
const STEP_MM: f64 = 1e-4;

/// Largest relative difference between the focal length named by a position of focus and that of its zoom setting:
/// engravings are rounded.
const SAME_SETTING: f64 = 0.02;

/// A zoom setting: its position at infinity, and those at nearer distances.
#[derive(Debug)]
pub(crate) struct ZoomSetting<'a> {
    /// Logarithm of the focal length in mm.
    logarithm: f64,
    infinity: &'a Position,
    near: Vec<&'a Position>,
}

impl<'a> ZoomSetting<'a> {
    /// Zoom settings by rising focal length; at most one where the lens is no zoom.
    ///
    /// # Errors
    ///
    /// The number of a position that belongs to none of them, and why.
    pub(crate) fn of(lens: &Lens, positions: &'a [Position]) -> Result<Vec<Self>, (usize, String)> {
        let efl = |position: &Position| lens.in_position(position).at(lines::D).first_order().efl_mm;
        let (near, at_infinity): (Vec<_>, Vec<_>) =
            positions.iter().enumerate().partition(|(_, position)| position.object_distance_mm.is_some());
        let setting =
            |&(_, infinity): &(usize, &'a Position)| Self { logarithm: efl(infinity).ln(), infinity, near: Vec::new() };
        let mut settings: Vec<Self> = at_infinity.iter().map(setting).collect();
        settings.sort_by(|a, b| a.logarithm.total_cmp(&b.logarithm));
        let is_zoom = settings.windows(2).any(|pair| pair[1].logarithm - pair[0].logarithm > DISTINCT);
        if !is_zoom {
            if let (Some((number, _)), false) = (at_infinity.get(1), near.is_empty()) {
                return Err((*number, "it is at infinity as another, with the same focal length".to_owned()));
            }
            settings.truncate(1);
            if let Some(only) = settings.first_mut() {
                only.near.extend(near.iter().map(|(_, position)| *position));
            }
            return Ok(settings);
        }
        if positions.first().is_some_and(|first| first.object_distance_mm.is_some()) {
            return Err((0, "the first position of a zoom must be at infinity".to_owned()));
        }
        for &(number, position) in &near {
            let Some(focal_length_mm) = position.focal_length_mm else {
                return Err((number, "nothing says which focal length of the zoom it belongs to".to_owned()));
            };
            let off = |setting: &Self| (setting.logarithm - focal_length_mm.ln()).abs();
            let nearest = settings.iter_mut().min_by(|a, b| off(a).total_cmp(&off(b)));
            match nearest.filter(|setting| off(setting) <= SAME_SETTING) {
                Some(setting) => setting.near.push(position),
                None => {
                    let message = format!("no position at infinity has its focal length of {focal_length_mm} mm");
                    return Err((number, message));
                }
            }
        }
        let lacks = settings.iter().find(|setting| setting.near.is_empty());
        match (near.first(), lacks) {
            (Some((number, _)), Some(lacking)) => {
                let without = lacking.logarithm.exp();
                Err((*number, format!("it is at a distance, as no position of the {without:.4} mm of the zoom is")))
            }
            _ => Ok(settings),
        }
    }

    /// Focus curves of the setting; `None` where two positions share a distance.
    fn curves(&self, lens: &Lens) -> Option<GapCurves> {
        let near = self.near.iter().map(|position| (position.object_distance_mm.map_or(0.0, f64::recip), *position));
        GapCurves::new(lens, &std::iter::once((0.0, self.infinity)).chain(near).collect::<Vec<_>>())
    }
}

/// Gaps and the stop's radius as functions of one parameter.
#[derive(Clone, Debug)]
pub struct GapCurves {
    /// Thickness curve of each gap that changes, mm, with the surface before the gap.
    gaps: Vec<(usize, MonotoneCubic)>,
    /// Curve of the stop's radius, mm, where it changes.
    stop: Option<MonotoneCubic>,
    /// Parameters of the positions, in rising order.
    parameters: Vec<f64>,
}

impl GapCurves {
    /// Curves of a lens through positions, each with its parameter; `None` where two parameters are the same or there
    /// are none.
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

    /// Lens at a parameter.
    pub(crate) fn set(&self, lens: &Lens, parameter: f64) -> Lens {
        let gaps: Vec<_> = self.gaps.iter().map(|(surface, curve)| (*surface, curve.eval(parameter))).collect();
        let lens = lens.with_gaps(&gaps);
        self.stop.as_ref().map_or_else(|| lens.clone(), |stop| lens.with_stop_radius(stop.eval(parameter)))
    }

    /// Focus curves of a lens through the positions of its prescription that have an object distance, over 1/distance
    /// from the first vertex; for a zoom, at the lens's focal length. `None` where fewer than two have one.
    pub fn of_focus(lens: &Lens, positions: &[Position]) -> Option<Self> {
        if positions.iter().all(|position| position.object_distance_mm.is_none()) {
            return None;
        }
        match ZoomSetting::of(lens, positions) {
            Ok(settings) if settings.len() > 1 => Self::between(lens, &settings),
            Ok(_) | Err(_) => {
                let parameter = |position: &Position| position.object_distance_mm.map_or(0.0, f64::recip);
                let all: Vec<_> = positions.iter().map(|position| (parameter(position), position)).collect();
                if all.len() > 1 { Self::new(lens, &all) } else { None }
            }
        }
    }

    /// Focus curves of a zoom at the focal length of a lens. The change of each gap by focus, from infinity to the
    /// nearest distance, is interpolated between zoom settings by monotone cubics in the logarithm of the focal length,
    /// and so is the nearest distance.
    fn between(lens: &Lens, settings: &[ZoomSetting<'_>]) -> Option<Self> {
        let logarithm = lens.at(lines::D).first_order().efl_mm.ln();
        let curves = settings.iter().map(|setting| setting.curves(lens)).collect::<Option<Vec<_>>>()?;
        let logarithms: Vec<f64> = settings.iter().map(|setting| setting.logarithm).collect();
        let at_lens = |of_settings: Vec<f64>| {
            let range = logarithms[0]..=*logarithms.last()?;
            let curve = MonotoneCubic::new(logarithms.clone(), of_settings)?;
            Some(curve.eval(logarithm.clamp(*range.start(), *range.end())))
        };
        let end = at_lens(curves.iter().map(Self::end).collect())?;
        let steps = settings.iter().map(|setting| setting.near.len()).max()?;
        let parts: Vec<f64> = (0..=steps).map(|i| i as f64 / steps as f64).collect();
        let mut surfaces: Vec<usize> =
            curves.iter().flat_map(|curves| curves.gaps.iter().map(|(surface, _)| *surface)).collect();
        surfaces.sort_unstable();
        surfaces.dedup();
        let parameters: Vec<f64> = parts.iter().map(|part| part * end).collect();
        let curve = |surface: usize| {
            let added = |part: f64| {
                let of_setting = |curves: &Self| {
                    let gap = |parameter: f64| {
                        let found = curves.gaps.iter().find(|(known, _)| *known == surface);
                        found.map_or(0.0, |(_, curve)| curve.eval(parameter))
                    };
                    gap(part * curves.end()) - gap(0.0)
                };
                at_lens(curves.iter().map(of_setting).collect())
            };
            let gaps = parts.iter().map(|part| Some(lens.gap_mm(surface) + added(*part)?));
            MonotoneCubic::new(parameters.clone(), gaps.collect::<Option<_>>()?)
        };
        let gaps = surfaces.iter().map(|surface| Some((*surface, curve(*surface)?))).collect::<Option<_>>()?;
        Some(Self { gaps, stop: None, parameters })
    }

    /// Greatest parameter; for a focus, that of the nearest distance.
    pub(crate) fn end(&self) -> f64 {
        self.parameters.last().copied().unwrap_or(0.0)
    }
}

impl Lens {
    /// Lens zoomed to a focal length in mm, by the positions of its prescription.
    ///
    /// Gaps follow monotone cubics in the logarithm of the positions' focal lengths. Then the gap that moves the image
    /// most is changed until the paraxial image at the d line has the distance from the sensor of the neighbouring
    /// positions, so that the focus stays.
    pub fn zoomed(&self, positions: &[Position], focal_length_mm: f64) -> Result<Self, Invalid> {
        let efl = |lens: &Self| lens.at(lines::D).first_order().efl_mm;
        // Focused nearer, a lens has another focal length, which is none of the zoom's.
        let at_infinity: Vec<&Position> =
            positions.iter().filter(|position| position.object_distance_mm.is_none()).collect();
        let set: Vec<_> = at_infinity.iter().map(|&position| (efl(&self.in_position(position)), position)).collect();
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

    /// Lens with the gap that moves the image most changed until `defocus` equals `intended`.
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
