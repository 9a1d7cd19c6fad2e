//! Checks that a prescription can be traced. Each error names surface and value.

use glam::DVec3;

use photosite_core::Invalid;

use crate::full_beam;
use crate::lens::Lens;
use crate::positions::ZoomSetting;
use crate::prescription::{Coating, Layer, LayerIndex, Position, Prescription, Surface};
use crate::profile::Profile;
use crate::trace::{Apertures, Ray, Stopped};

/// Largest number of surfaces of a lens: a zoom for broadcasting has 60.
pub const MOST_SURFACES: usize = 200;
/// Highest order of an asphere.
pub const HIGHEST_ORDER: u32 = 30;
/// Largest number of layers of a coating.
pub const MOST_LAYERS: usize = 200;
/// Wavelengths, nm, over which every lens must have indices of 1 or more. Cameras for other wavelengths check theirs
/// with [`check_indices`].
pub const VISIBLE_NM: [f64; 2] = [400.0, 700.0];
/// Overlap of surfaces that still counts as contact, mm: surfaces may touch, and tables give thicknesses of few digits.
const CONTACT_MM: f64 = 1e-6;
/// Number of places from the vertex to the rim at which a sag is checked.
const PLACES: u32 = 64;
/// Steepest slope of an asphere: 89°. A steeper one comes from a wrong coefficient.
const STEEPEST: f64 = 57.3;

impl Lens {
    /// Checks a prescription and makes its lens, in the first position or, without positions, with the surfaces' own
    /// thicknesses. All positions are checked. Keys of errors are those of the prescription,
    /// `surfaces[3].semi_aperture_mm`, with surfaces counted from 0.
    pub fn new(prescription: &Prescription) -> Result<Self, Invalid> {
        check(prescription)?;
        let lens = Self::unchecked(prescription);
        let lens = match prescription.positions.first() {
            Some(position) => lens.in_position(position),
            None => lens,
        };
        check_traced(&lens)?;
        for (number, position) in prescription.positions.iter().enumerate().skip(1) {
            check_traced(&lens.in_position(position)).map_err(|e| e.within(&format!("positions[{number}]")))?;
        }
        check_zoom(&lens, &prescription.positions)?;
        Ok(lens)
    }
}

/// Checks the values of a prescription one by one.
fn check(prescription: &Prescription) -> Result<(), Invalid> {
    let surfaces = &prescription.surfaces;
    if !surfaces.iter().any(|surface| surface.glass.is_some()) {
        let message = format!("none of the {} surfaces refracts: there is no glass", surfaces.len());
        return Err(Invalid::new("surfaces", message).help("a lens needs at least one piece of glass"));
    }
    if surfaces.len() > MOST_SURFACES {
        let message = format!("{} surfaces are more than {MOST_SURFACES}", surfaces.len());
        return Err(Invalid::new("surfaces", message));
    }
    check_stop(surfaces)?;
    if let Some(blades) = prescription.blades {
        if blades.count < 3 {
            let message = format!("{} blades do not enclose an opening", blades.count);
            return Err(Invalid::new("blades", message).help("3 or more, or none for a round opening"));
        }
        finite("blades", "rotation", blades.rotation_deg)?;
    }
    for (number, surface) in surfaces.iter().enumerate() {
        check_surface(surface).map_err(|error| error.within(&at(number)))?;
    }
    check_apertures(prescription)?;
    check_positions(prescription)?;
    check_indices(prescription, VISIBLE_NM)
}

/// Checks that every glass has an index of 1 or more at each nanometre from `range_nm[0]` to `range_nm[1]`.
pub fn check_indices(prescription: &Prescription, range_nm: [f64; 2]) -> Result<(), Invalid> {
    for (number, surface) in prescription.surfaces.iter().enumerate() {
        let Some(glass) = &surface.glass else { continue };
        let steps = (range_nm[1] - range_nm[0]).ceil().max(0.0) as u32;
        for nm in (0..=steps).map(|i| (range_nm[0] + f64::from(i)).min(range_nm[1])) {
            let index = glass.dispersion.index(nm);
            if !(index.is_finite() && index >= 1.0) {
                let message = format!("the glass {} has the index {index} at {nm} nm, not 1 or more", glass.name);
                let help = "check the coefficients of its formula, and that they are for wavelengths in µm";
                return Err(Invalid::new(format!("{}.glass", at(number)), message).help(help));
            }
        }
    }
    Ok(())
}

fn at(surface: usize) -> String {
    format!("surfaces[{surface}]")
}

fn finite(key: &str, what: &str, value: f64) -> Result<(), Invalid> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(Invalid::new(key, format!("the {what} {value} is not a finite number")))
    }
}

fn check_stop(surfaces: &[Surface]) -> Result<(), Invalid> {
    let stops: Vec<usize> = (0..surfaces.len()).filter(|&i| surfaces[i].is_stop).collect();
    match stops[..] {
        [_] => Ok(()),
        [] => {
            let message = format!("none of the {} surfaces is the stop", surfaces.len());
            Err(Invalid::new("surfaces", message).help("mark the surface at which the f-number is set as the stop"))
        }
        [first, second, ..] => {
            let message = format!("surfaces {first} and {second} are both the stop");
            Err(Invalid::new("surfaces", message).help("one surface sets the f-number; the others are apertures"))
        }
    }
}

fn check_surface(surface: &Surface) -> Result<(), Invalid> {
    if let Some(radius) = surface.radius_mm {
        finite("radius_mm", "radius", radius)?;
        if radius == 0.0 {
            return Err(Invalid::new("radius_mm", "a radius of 0 is a point").help("leave it out for a flat surface"));
        }
    }
    finite("thickness_mm", "thickness", surface.thickness_mm)?;
    finite("conic", "conic constant", surface.conic)?;
    for &(order, coefficient) in &surface.asphere {
        finite("asphere", &format!("coefficient of r^{order}"), coefficient)?;
        if !(2..=HIGHEST_ORDER).contains(&order) {
            let message = format!("the asphere has a term in r^{order}: orders go from 2 to {HIGHEST_ORDER}");
            return Err(Invalid::new("asphere", message));
        }
    }
    if let Coating::Layers(layers) = &surface.coating {
        if layers.len() > MOST_LAYERS {
            let message = format!("{} layers are more than {MOST_LAYERS}", layers.len());
            return Err(Invalid::new("coating", message));
        }
        layers.iter().enumerate().try_for_each(|(i, layer)| check_layer(i, layer))?;
    }
    Ok(())
}

fn check_layer(number: usize, layer: &Layer) -> Result<(), Invalid> {
    let key = format!("coating[{number}]");
    if !(layer.thickness_nm.is_finite() && layer.thickness_nm >= 0.0) {
        return Err(Invalid::new(key, format!("a layer cannot be {} nm thick", layer.thickness_nm)));
    }
    let (least_n, least_k) = match &layer.index {
        LayerIndex::Constant { n, k } => (*n, *k),
        LayerIndex::Table { n, k } => (f64::from(n.min()), f64::from(k.min())),
    };
    if !(least_n.is_finite() && least_n > 0.0 && least_k.is_finite() && least_k >= 0.0) {
        let message = format!("the index {least_n} + {least_k}i of a layer is impossible");
        return Err(Invalid::new(key, message).help("n is above 0, and k is 0 or above, where the layer absorbs"));
    }
    Ok(())
}

/// Checks that surfaces have semi-apertures and reach out to them.
fn check_apertures(prescription: &Prescription) -> Result<(), Invalid> {
    for (number, surface) in prescription.surfaces.iter().enumerate() {
        let key = format!("{}.semi_aperture_mm", at(number));
        let Some(semi_aperture) = surface.semi_aperture_mm else {
            let error = Invalid::new(key, "the semi-aperture is missing");
            return Err(match full_beam::semi_aperture_mm(prescription, number) {
                Some(size) => error
                    .help(format!("{size:.3} lets the full beam through to first order, on the axis and at the edge")),
                None => error.help("write the radius in which the surface is clear, in mm"),
            });
        };
        if !(semi_aperture.is_finite() && semi_aperture > 0.0) {
            return Err(Invalid::new(key, format!("a semi-aperture must be above 0, got {semi_aperture} mm")));
        }
        check_shape(surface, semi_aperture).map_err(|error| error.within(&at(number)))?;
    }
    Ok(())
}

/// Checks that a surface reaches out to its rim.
pub(crate) fn check_shape(surface: &Surface, semi_aperture: f64) -> Result<(), Invalid> {
    let (c, k1) = (surface.radius_mm.map_or(0.0, f64::recip), 1.0 + surface.conic);
    let reach = if k1 > 0.0 && c != 0.0 { 1.0 / (k1.sqrt() * c.abs()) } else { f64::INFINITY };
    if semi_aperture > reach {
        let of = if surface.conic == 0.0 { "the sphere" } else { "the conic" };
        let message = format!("the semi-aperture {semi_aperture} mm is wider than {of}, which ends at {reach:.4} mm");
        let help = "check the radius, and that this is not a diameter";
        return Err(Invalid::new("semi_aperture_mm", message).help(help));
    }
    if surface.asphere.is_empty() {
        return Ok(());
    }
    let profile = Profile::new(surface);
    for r in radii(semi_aperture) {
        let slope = profile.slope_over_r(r * r).map(|slope| slope * r);
        let is_fit = profile.sag(r * r).is_some_and(f64::is_finite) && slope.is_some_and(|s| s.abs() < STEEPEST);
        if !is_fit {
            let message =
                format!("the asphere folds at {r:.4} mm from the axis, within the semi-aperture {semi_aperture} mm");
            let help = "check the orders and signs of its coefficients, and that k, not 1 + k, is the conic constant";
            return Err(Invalid::new("asphere", message).help(help));
        }
    }
    Ok(())
}

/// Radii from the axis to the rim.
fn radii(rim: f64) -> impl Iterator<Item = f64> {
    (0..=PLACES).map(move |i| rim * f64::from(i) / f64::from(PLACES))
}

fn check_positions(prescription: &Prescription) -> Result<(), Invalid> {
    let count = prescription.surfaces.len();
    for (number, position) in prescription.positions.iter().enumerate() {
        let key = format!("positions[{number}]");
        for &(surface, gap) in &position.gaps {
            if surface >= count {
                let message = format!("there is no gap behind surface {surface}: there are {count} surfaces, from 0");
                return Err(Invalid::new(key, message));
            }
            finite(&key, &format!("gap behind surface {surface}"), gap)?;
        }
        if let Some(radius) = position.stop_semi_aperture_mm
            && !(radius.is_finite() && radius > 0.0)
        {
            return Err(Invalid::new(key, format!("the stop must have a radius above 0, got {radius} mm")));
        }
        if let Some(distance) = position.object_distance_mm
            && (distance.is_nan() || distance <= 0.0)
        {
            let message = format!("what is sharp must be in front of the lens, got a distance of {distance} mm");
            return Err(Invalid::new(key, message));
        }
        if let Some(focal_length) = position.focal_length_mm
            && !(focal_length.is_finite() && focal_length > 0.0)
        {
            return Err(Invalid::new(key, format!("a focal length must be above 0, got {focal_length} mm")));
        }
    }
    Ok(())
}

/// Checks that every position at a finite distance belongs to a zoom setting, that all settings have such positions if
/// one has, and that no two positions share a distance.
fn check_zoom(lens: &Lens, positions: &[Position]) -> Result<(), Invalid> {
    let refuse = |number: usize, message: String| {
        Err(Invalid::new(format!("positions[{number}]"), message).help(
            "give each focal length of the zoom a position at infinity and one or more with an object_distance, in which \
             focal_length repeats that at infinity",
        ))
    };
    if let Err((number, message)) = ZoomSetting::of(lens, positions) {
        return refuse(number, message);
    }
    for (number, position) in positions.iter().enumerate() {
        let Some(distance) = position.object_distance_mm else { continue };
        let is_same = |other: &Position| {
            other.object_distance_mm == Some(distance) && other.focal_length_mm == position.focal_length_mm
        };
        if positions[..number].iter().any(is_same) {
            return refuse(number, format!("it is at {distance} mm, as another one before it"));
        }
    }
    Ok(())
}

/// Checks a lens as a whole, in one position.
fn check_traced(lens: &Lens) -> Result<(), Invalid> {
    check_gaps(lens)?;
    let [shortest, longest] = VISIBLE_NM;
    for nm in [0.5 * (shortest + longest), shortest, longest] {
        let first_order = lens.at(nm).first_order();
        let efl = first_order.efl_mm;
        if !efl.is_finite() || efl.abs() > LONGEST_EFL_MM {
            return Err(Invalid::new("surfaces", format!("the lens is afocal at {nm} nm: it makes no image")));
        }
        if efl < 0.0 {
            let message = format!("the focal length at {nm} nm is {efl:.4} mm: the lens diverges and makes no image");
            let help = "check the signs of the radii, and that the file gives radii where it seems to give them";
            return Err(Invalid::new("surfaces", message).help(help));
        }
    }
    let middle = lens.at(0.5 * (shortest + longest));
    let height = NEAR_AXIS * middle.first_order().entrance_pupil_diameter_mm;
    let near_axis = Ray { origin: DVec3::new(0.0, height, 0.0), direction: DVec3::Z };
    match middle.trace_in(near_axis, Apertures::Clip) {
        Ok(_) => Ok(()),
        Err(Stopped { surface, reason }) => {
            Err(Invalid::new(at(surface), format!("a ray close to the axis {reason} surface {surface}")))
        }
    }
}

/// Height of a ray that counts as close to the axis, over the diameter of the entrance pupil.
const NEAR_AXIS: f64 = 1e-3;

/// Longest focal length, mm: beyond a kilometre a lens counts as afocal.
const LONGEST_EFL_MM: f64 = 1e6;

/// Checks that surfaces do not cross, out to their rims.
fn check_gaps(lens: &Lens) -> Result<(), Invalid> {
    let surfaces = lens.surfaces();
    let last = surfaces.len() - 1;
    for (number, surface) in surfaces.iter().enumerate() {
        let gap = lens.gap_mm(number);
        let key = format!("{}.thickness_mm", at(number));
        if number == last && gap <= 0.0 {
            let message = format!("the last gap is {gap} mm: the sensor must be behind the lens");
            return Err(Invalid::new(key, message));
        }
        let crossing = crossing(lens, number);
        let is_of_aperture = is_aperture(lens, number) || is_aperture(lens, number + 1);
        // What stands in an opening reaches through its plane.
        if gap < 0.0 && (crossing.is_some() || !is_of_aperture) {
            let filling = if surface.glass.is_some() { "glass" } else { "air" };
            return Err(Invalid::new(key, format!("{filling} cannot be {gap} mm thick")));
        }
        if let Some(Crossing { next, r, left }) = crossing {
            let behind = if number == last { "the sensor".to_owned() } else { format!("surface {next}") };
            let message = format!(
                "surface {number} runs through {behind}: at {r:.3} mm from the axis, within both semi-apertures, \
                 {left:.4} mm are left between them"
            );
            let help = format!(
                "make the smaller of their semi-apertures less than {r:.3} mm, unless the gap or a radius is wrong"
            );
            return Err(Invalid::new(key, message).help(help));
        }
    }
    Ok(())
}

/// Whether a surface is a flat opening in air, as stops are, without glass in its opening, so that a neighbouring
/// surface may reach through its plane.
fn is_aperture(lens: &Lens, number: usize) -> bool {
    let surfaces = lens.surfaces();
    surfaces.get(number).is_some_and(|surface| {
        let before_is_air = number.checked_sub(1).is_none_or(|before| surfaces[before].glass.is_none());
        let is_flat = surface.profile.curvature() == 0.0 && surface.profile.polynomial().is_none();
        is_flat && before_is_air && surface.glass.is_none()
    })
}

/// Crossing of a surface with one behind it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Number of that surface; for the sensor, the number of surfaces.
    pub(crate) next: usize,
    /// Distance from the axis, mm.
    pub(crate) r: f64,
    /// Gap between the surfaces there, mm, below 0.
    pub(crate) left: f64,
}

/// The crossing of a surface nearest to the axis, within its rim and the rim of the surface behind. An opening in air
/// counts by its rim alone.
pub(crate) fn crossing(lens: &Lens, number: usize) -> Option<Crossing> {
    let surfaces = lens.surfaces();
    let surface = &surfaces[number];
    // What is on both sides of an opening must not meet in it, either.
    let behind = if is_aperture(lens, number + 1) && !is_aperture(lens, number) { 2 } else { 1 };
    (number + 1..=number + behind).take_while(|next| *next <= surfaces.len()).find_map(|next| {
        let gap: f64 = (number..next).map(|i| lens.gap_mm(i)).sum();
        let other = surfaces.get(next);
        let rim = other.map_or(surface.semi_aperture_mm, |other| surface.semi_aperture_mm.min(other.semi_aperture_mm));
        let rim_alone = is_aperture(lens, next) || (is_aperture(lens, number) && other.is_some());
        let sag = |profile: &Profile, r: f64| profile.sag(r * r).unwrap_or(0.0);
        let left = |r: f64| gap + other.map_or(0.0, |other| sag(&other.profile, r)) - sag(&surface.profile, r);
        let runs_through = |r: f64| Some(Crossing { next, r, left: left(r) }).filter(|at| at.left < -CONTACT_MM);
        if rim_alone { runs_through(rim) } else { radii(rim).find_map(runs_through) }
    })
}
