//! Point spread functions over field and spectrum, as offsets for rays of an ideal lens without aberrations.
//!
//! Aberrations and diffraction blur together, in the plane of focus: neither adds to the other, as a wave front spreads
//! as a whole. So light that would come from a point of that plane to its place on the sensor by the chief ray comes to
//! offsets from there, drawn from the point spread function ([`point_spread`](crate::point_spread)). Objects before or
//! behind the plane are blurred geometrically, since their rays cross the plane at different points.
//!
//! Nodes of image height, wavelength and, of a stop with blades, azimuth are computed when first needed, some 8 ms and
//! 0.1 MB each. An offset is drawn from one of the nodes around, the nearer the likelier; chief rays are interpolated
//! between wavelengths. The mixture has another modulation than the point spread function half-way between two nodes:
//! at 10 to 80/mm, over five camera lenses of f/2 to f/5.6 focused at 2 m, by 0.001 in the median and at most 0.02
//! (once 0.04) between heights; in light of one wavelength between wavelengths by 0.002 in the median and at most 0.07,
//! of a double Gauss at f/2. In light of many wavelengths, errors of neighbouring nodes cancel.

use std::f64::consts::TAU;
use std::fmt::Debug;
use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3};
use photosite_core::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM};

use crate::chief_map::{ChiefMap, Sighting};
use crate::lens::Lens;
use crate::pupil_table::rotation;
use crate::spread_table::SpreadTable;

/// Number of image heights, from the axis to the corner; and their least distance relative to the focal length. On the
/// axis point spread functions do not turn with the place. Were the next height closer than the reach of light, they
/// would turn in the middle of one: then wavelengths that share a path and its numbers would not land equally often
/// everywhere.
const HEIGHTS: usize = 25;
const LEAST_STEP: f64 = 0.005;
/// Step of the wavelengths, which are evenly spaced in 1/λ², because indices, and with them the focus, vary about so: 7
/// nm at 430 nm, 19 nm at 600 nm, in nm⁻².
const STEP: f64 = 1.75e-7;
/// Number of azimuths from one blade of a stop to the next, the first of them across a blade. On either side of it, and
/// of the corner half-way, point spread functions are mirror images: this number of them is computed.
const AZIMUTHS: usize = 4;
const TABLED: usize = AZIMUTHS / 2 + 1;
/// Version of the computation of the tables, to be raised when their numbers change between releases.
const EDITION: u32 = 2;
/// Distance that counts as infinite, mm.
const FAR_MM: f64 = 1e9;

/// Surface in focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FocusSurface {
    /// Distance from the reference point on the axis, mm; infinite for parallel light, below 0 where light that
    /// converges behind that point is in focus.
    pub distance_mm: f64,
    /// Reference point, mm from the first vertex: the paraxial entrance pupil.
    pub reference_mm: f64,
    /// Whether the surface is a plane across the axis; else it lies at the distance from the point where each line of
    /// sight crosses the axis.
    pub is_flat: bool,
}

impl FocusSurface {
    /// Intersection with a line of sight, mm; `None` at infinity.
    fn point(&self, sighting: &Sighting) -> Option<DVec3> {
        let crossing = DVec3::new(0.0, 0.0, sighting.pupil_mm);
        let along = if self.is_flat {
            (self.reference_mm - self.distance_mm - sighting.pupil_mm) / sighting.direction.z
        } else {
            self.distance_mm
        };
        self.distance_mm.is_finite().then(|| crossing + sighting.direction * along)
    }

    /// Intersection with a ray in the scene, mm; a far point at infinity. A surface that is not flat is met at the
    /// distance from the reference point: how much the entrance pupil moves makes no difference, as the ray is thin
    /// there.
    fn met(&self, origin: DVec3, direction: DVec3) -> DVec3 {
        let along = if self.distance_mm.is_infinite() {
            FAR_MM
        } else if self.is_flat {
            (self.reference_mm - self.distance_mm - origin.z) / direction.z
        } else {
            self.distance_mm - (origin - DVec3::new(0.0, 0.0, self.reference_mm)).dot(direction)
        };
        origin + direction * along
    }
}

/// Point spread functions of a lens at its focus.
#[derive(Debug)]
pub struct WaveSpread {
    lens: Lens,
    focus: FocusSurface,
    highest_mm: f64,
    /// Step of the image height, mm.
    step_mm: f64,
    /// First node of 1/λ², nm⁻².
    first: f64,
    blades: usize,
    /// First azimuth, rad from y.
    across_blade_rad: f64,
    /// Chief rays by wavelength.
    chiefs: Vec<OnceLock<Option<ChiefMap>>>,
    /// Tables by wavelength and height, one for each tabulated azimuth, and a single one without blades; none where no
    /// light passes.
    spreads: Vec<OnceLock<Vec<SpreadTable>>>,
    shelf: Option<Arc<dyn Shelf>>,
}

/// Storage of point spread functions beyond the run of a program.
pub trait Shelf: Debug + Send + Sync {
    /// Bytes kept under a number.
    fn take(&self, number: usize) -> Option<Vec<u8>>;
    /// Keeps bytes under a number, if possible.
    fn keep(&self, number: usize, bytes: &[u8]);
}

impl WaveSpread {
    /// Point spread functions of a lens focused on a surface, for image heights up to one in mm. `node_nm` becomes a
    /// node of wavelength, so that light near it is not mixed with that of another node.
    pub fn new(lens: &Lens, focus: FocusSurface, highest_mm: f64, node_nm: f64) -> Self {
        let normals = lens.stop_edges().map_or(&[][..], |(normals, _)| normals);
        let (blades, across_blade_rad) =
            (normals.len(), normals.first().map_or(0.0, |normal| DVec2::Y.angle_to(*normal)));
        let [first, last] = [LAMBDA_MAX_NM, LAMBDA_MIN_NM].map(|nm| f64::from(nm).powi(-2));
        let first = first - STEP + (node_nm.powi(-2) - first).rem_euclid(STEP);
        let wavelengths = ((last - first) / STEP).ceil() as usize + 1;
        Self {
            lens: lens.clone(),
            focus,
            highest_mm,
            step_mm: (highest_mm / (HEIGHTS - 1) as f64).max(LEAST_STEP * lens.at(node_nm).first_order().efl_mm.abs()),
            first,
            blades,
            across_blade_rad,
            chiefs: (0..wavelengths).map(|_| OnceLock::new()).collect(),
            spreads: (0..wavelengths * HEIGHTS).map(|_| OnceLock::new()).collect(),
            shelf: None,
        }
    }

    /// Key that determines the point spread functions: a text of all inputs, distinct for distinct inputs.
    pub fn key(&self) -> String {
        let Self { lens, focus, highest_mm, step_mm, first, blades, across_blade_rad, chiefs, spreads, shelf: _ } =
            self;
        // Of what is derived, Debug leaves out no field, and writes numbers to their last digit.
        let grid = (highest_mm, step_mm, first, blades, across_blade_rad, chiefs.len(), spreads.len());
        format!("{EDITION} {} {lens:?} {focus:?} {grid:?}", env!("CARGO_PKG_VERSION"))
    }

    /// Takes tables from a shelf of this [`key`](Self::key), and keeps computed ones there.
    #[must_use]
    pub fn with_shelf(self, shelf: Arc<dyn Shelf>) -> Self {
        Self { shelf: Some(shelf), ..self }
    }

    fn nm(&self, wavelength: usize) -> f64 {
        (self.first + STEP * wavelength as f64).powf(-0.5)
    }

    /// Node of wavelength before one in nm, and the fraction of the way to the next.
    fn wavelength(&self, nm: f64) -> (usize, f64) {
        let place = ((nm.powi(-2) - self.first) / STEP).max(0.0);
        let node = (place as usize).min(self.chiefs.len() - 2);
        (node, (place - node as f64).min(1.0))
    }

    fn chief(&self, wavelength: usize) -> Option<&ChiefMap> {
        let find = || ChiefMap::new(&self.lens.at(self.nm(wavelength)), self.highest_mm);
        self.chiefs[wavelength].get_or_init(find).as_ref()
    }

    /// Table at a node. Heights whose light does not pass, and places without a chief ray, have the table of the next
    /// height towards the axis.
    fn spread(&self, wavelength: usize, azimuth: usize, height: usize) -> Option<&SpreadTable> {
        let number = wavelength * HEIGHTS + height;
        let tables = || {
            let kept = self.shelf.as_ref().and_then(|shelf| self.tables_of(&shelf.take(number)?));
            kept.unwrap_or_else(|| {
                let tables = self.worked_out(wavelength, height).unwrap_or_default();
                if let Some(shelf) = &self.shelf {
                    shelf.keep(number, &tables.iter().flat_map(SpreadTable::to_bytes).collect::<Vec<_>>());
                }
                tables
            })
        };
        let own = self.spreads[number].get_or_init(tables).get(azimuth);
        own.or_else(|| self.spread(wavelength, azimuth, height.checked_sub(1)?))
    }

    /// Tables of a node from bytes that were kept.
    fn tables_of(&self, mut bytes: &[u8]) -> Option<Vec<SpreadTable>> {
        if bytes.is_empty() {
            return Some(Vec::new());
        }
        let tables = (0..self.tabled()).map(|_| SpreadTable::from_bytes(&mut bytes)).collect::<Option<_>>()?;
        bytes.is_empty().then_some(tables)
    }

    fn worked_out(&self, wavelength: usize, height: usize) -> Option<Vec<SpreadTable>> {
        let lenses: Vec<Lens> = (0..self.tabled()).map(|i| self.lens.with_turned_stop(-self.azimuth_rad(i))).collect();
        let at = self.lens.at(self.nm(wavelength));
        let chief = at.chief_ray_at_height(self.step_mm * height as f64)?;
        let (front, outward) = (chief.before.origin, -chief.before.direction);
        let on_axis = at.first_order().entrance_pupil_mm;
        let pupil_mm = if height > 0 { chief.entrance_pupil_mm() } else { on_axis };
        let in_focus = self.focus.point(&Sighting { direction: outward, pupil_mm });
        let distance_mm = in_focus.map_or(f64::INFINITY, |point| (point - front).dot(outward));
        let spreads = at.point_spreads(chief, distance_mm, &lenses);
        spreads.iter().map(|spread| spread.as_ref().map(SpreadTable::new)).collect()
    }

    /// Largest blur that exceeds its table: the farthest landing ray from the middle of a point spread function, and
    /// the half-width of the latter, mm. `None` where no ray lands beyond it, at all of a few image heights at a
    /// wavelength in nm.
    pub fn beyond_reach_mm(&self, nm: f64) -> Option<[f64; 2]> {
        let (wavelength, _) = self.wavelength(nm);
        let images = (0..HEIGHTS).step_by(6).filter_map(|height| self.spread(wavelength, 0, height));
        let beyond = images.map(|spread| spread.farthest_and_reach_mm).filter(|[far, reach]| far > reach);
        beyond.max_by(|a, b| a[0].total_cmp(&b[0]))
    }

    /// Number of tabulated azimuths.
    fn tabled(&self) -> usize {
        if self.blades == 0 { 1 } else { TABLED }
    }

    /// Step of the tabulated azimuths, rad.
    fn azimuth_step_rad(&self) -> f64 {
        TAU / (self.blades.max(1) * AZIMUTHS) as f64
    }

    /// Angle of a tabulated azimuth from y, rad.
    fn azimuth_rad(&self, node: usize) -> f64 {
        self.across_blade_rad + self.azimuth_step_rad() * node as f64
    }

    /// Samples the offset of light of a wavelength in nm from its chief ray's landing point, mm, near a sensor point,
    /// mm from the axis, by numbers in [0, 1). Zero where no light passes.
    pub fn offset(&self, point: DVec2, nm: f64, [u, v]: [f64; 2]) -> DVec2 {
        let mut u = u;
        // The node before, or the one behind it as likely as it is near; what is left of the number is even again.
        let mut choose = |part: f64| {
            let is_next = u < part;
            u = if is_next { u / part } else { (u - part) / (1.0 - part) };
            usize::from(is_next)
        };
        let (wavelength, part) = self.wavelength(nm);
        let wavelength = wavelength + choose(part);
        let place = point.length() / self.step_mm;
        let height = (place as usize).min(HEIGHTS - 2);
        let height = height + choose((place - height as f64).min(1.0));
        // Blades keep their directions on the sensor, whatever the azimuth of the point: of its node it is turned by whole
        // blades.
        let towards = if height == 0 { DVec2::X } else { rotation(point) };
        let (azimuth, turned) = if self.blades == 0 {
            (0, towards)
        } else {
            let place = (towards.to_angle() - self.across_blade_rad).rem_euclid(TAU) / self.azimuth_step_rad();
            let before = place as usize;
            let node = before + choose(place - before as f64);
            (node % AZIMUTHS, DVec2::from_angle(self.azimuth_rad(node)))
        };
        let (tabled, across) = if azimuth < TABLED { (azimuth, 1.0) } else { (AZIMUTHS - azimuth, -1.0) };
        self.spread(wavelength, tabled, height).map_or(DVec2::ZERO, |spread| {
            let offset = spread.sample([u, v]);
            turned.rotate(DVec2::new(across * offset.x, offset.y))
        })
    }

    /// Unit direction from a point before the lens, mm, to the point of the surface in focus that the chief ray of a
    /// wavelength in nm links to a sensor point, mm from the axis. `None` beyond the chief rays.
    pub fn aim(&self, from: DVec3, sensor_mm: DVec2, nm: f64) -> Option<DVec3> {
        let (node, part) = self.wavelength(nm);
        let [low, high] = [self.chief(node)?.sighting(sensor_mm)?, self.chief(node + 1)?.sighting(sensor_mm)?];
        let sighting = Sighting {
            direction: low.direction.lerp(high.direction, part).normalize(),
            pupil_mm: low.pupil_mm + part * (high.pupil_mm - low.pupil_mm),
        };
        let direction = match self.focus.point(&sighting) {
            None => sighting.direction,
            // What is in focus behind the lens is on the line backwards.
            Some(point) => (point - from) * self.focus.distance_mm.signum(),
        };
        direction.try_normalize()
    }

    /// Sensor point, mm from the axis, of the chief ray of a wavelength in nm through the point where a ray in the
    /// scene, mm and unit vector, meets the surface in focus: the inverse of [`aim`](Self::aim).
    pub fn place(&self, origin: DVec3, direction: DVec3, nm: f64) -> Option<DVec2> {
        let point = self.focus.met(origin, direction);
        let (node, part) = self.wavelength(nm);
        let [low, high] = [self.chief(node)?.place(point)?, self.chief(node + 1)?.place(point)?];
        Some(low.lerp(high, part))
    }
}
