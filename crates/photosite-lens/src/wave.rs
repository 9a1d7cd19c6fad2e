//! Pictures of points over the field and the spectrum, for rays of a lens without aberrations whose points they spread.
//!
//! Aberrations and diffraction blur together, in the plane of focus: neither adds to the other, as a wave front spreads as a
//! whole. So light that would come from a point of that plane to its place on the sensor by the chief ray comes to offsets
//! from there, drawn from the picture of the point ([`point_spread`](crate::point_spread)). What lies before or behind the
//! plane is blurred by where its rays go through the plane, geometrically.
//!
//! Nodes of image height, wavelength and, of a stop with blades, azimuth are worked out when they are first asked for, some
//! 8 ms and 0.1 MB each. An offset is drawn from one of the nodes around, the nearer the likelier; chief rays are
//! interpolated between wavelengths. What is mixed so has another modulation than the picture half-way between two nodes: at
//! 10 to 80/mm, over five camera lenses of f/2 to f/5.6 focused at 2 m, by 0.001 in the median and at most 0.02 (once 0.04)
//! between heights; in light of one wavelength between wavelengths by 0.002 in the median and at most 0.07, of a double Gauss
//! at f/2. Of light of many, the next nodes take what one lacks.

use std::f64::consts::TAU;
use std::fmt::Debug;
use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3};
use photosite_core::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM};

use crate::chief_map::{ChiefMap, Sighting};
use crate::lens::Lens;
use crate::pupil_table::rotation;
use crate::spread_table::SpreadTable;

/// Image heights, from the axis to the corner; and their least distance as a part of the focal length. On the axis pictures
/// do not turn with the place. Were the next height as near as light lands, they would turn in the middle of one: then
/// wavelengths that share a path and its numbers did not land as often everywhere.
const HEIGHTS: usize = 25;
const LEAST_STEP: f64 = 0.005;
/// Step of the wavelengths, which lie evenly over 1/λ², as indices and with them the focus change about: 7 nm at 430 nm, 19 nm
/// at 600 nm, nm⁻².
const STEP: f64 = 1.75e-7;
/// Azimuths from one blade of a stop to the next, the first of them across a blade. On either side of it, and of the corner half-way,
/// pictures are mirror images of each other: so many are worked out.
const AZIMUTHS: usize = 4;
const TABLED: usize = AZIMUTHS / 2 + 1;
/// Number of the way that tables are worked out, which is raised when their numbers change between releases.
const EDITION: u32 = 2;
/// As far as a point that counts as infinitely far, mm.
const FAR_MM: f64 = 1e9;

/// What a lens is focused on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FocusSurface {
    /// Distance from the point of the axis that distances count from, mm; infinite for parallel light, below 0 where light
    /// that comes together behind that point is in focus.
    pub distance_mm: f64,
    /// That point, mm from the first vertex: the paraxial entrance pupil.
    pub reference_mm: f64,
    /// Whether it is a plane across the axis; else it lies at the distance from where each line of sight crosses the axis.
    pub is_flat: bool,
}

impl FocusSurface {
    /// Where a line of sight meets it, mm; `None` at infinity.
    fn point(&self, sighting: &Sighting) -> Option<DVec3> {
        let crossing = DVec3::new(0.0, 0.0, sighting.pupil_mm);
        let along = if self.is_flat {
            (self.reference_mm - self.distance_mm - sighting.pupil_mm) / sighting.direction.z
        } else {
            self.distance_mm
        };
        self.distance_mm.is_finite().then(|| crossing + sighting.direction * along)
    }

    /// Where a ray out in the scene meets it, mm; a far point at infinity. Where the picture is not flat, as far from the
    /// point that distances count from: how much the entrance pupil moves makes no difference, as the ray is thin there.
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

/// The pictures of points of a lens as it is focused.
#[derive(Debug)]
pub struct WaveSpread {
    lens: Lens,
    focus: FocusSurface,
    highest_mm: f64,
    /// From one height to the next, mm.
    step_mm: f64,
    /// 1/λ² of the first node, nm⁻².
    first: f64,
    blades: usize,
    /// The first azimuth, rad from y.
    across_blade_rad: f64,
    /// By wavelength.
    chiefs: Vec<OnceLock<Option<ChiefMap>>>,
    /// Tables by wavelength and height, of each azimuth that is tabled, of one without blades; none where no light passes.
    spreads: Vec<OnceLock<Vec<SpreadTable>>>,
    shelf: Option<Arc<dyn Shelf>>,
}

/// Where pictures of points are kept beyond the run of a program.
pub trait Shelf: Debug + Send + Sync {
    /// What was kept under a number.
    fn take(&self, number: usize) -> Option<Vec<u8>>;
    /// Keeps bytes under a number, if it can.
    fn keep(&self, number: usize, bytes: &[u8]);
}

impl WaveSpread {
    /// Of a lens focused on a surface, for image heights up to one in mm. A wavelength in nm is that of a node, so that
    /// light of about that one has no other mixed in.
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

    /// All that its pictures follow from, as text that no other has.
    pub fn key(&self) -> String {
        let Self { lens, focus, highest_mm, step_mm, first, blades, across_blade_rad, chiefs, spreads, shelf: _ } =
            self;
        // Of what is derived, Debug leaves out no field, and writes numbers to their last digit.
        let grid = (highest_mm, step_mm, first, blades, across_blade_rad, chiefs.len(), spreads.len());
        format!("{EDITION} {} {lens:?} {focus:?} {grid:?}", env!("CARGO_PKG_VERSION"))
    }

    /// Takes pictures from a shelf of this [`key`](Self::key), and keeps there what is worked out.
    #[must_use]
    pub fn with_shelf(self, shelf: Arc<dyn Shelf>) -> Self {
        Self { shelf: Some(shelf), ..self }
    }

    fn nm(&self, wavelength: usize) -> f64 {
        (self.first + STEP * wavelength as f64).powf(-0.5)
    }

    /// The node of wavelength before one in nm, and how far that is on the way to the next.
    fn wavelength(&self, nm: f64) -> (usize, f64) {
        let place = ((nm.powi(-2) - self.first) / STEP).max(0.0);
        let node = (place as usize).min(self.chiefs.len() - 2);
        (node, (place - node as f64).min(1.0))
    }

    fn chief(&self, wavelength: usize) -> Option<&ChiefMap> {
        let find = || ChiefMap::new(&self.lens.at(self.nm(wavelength)), self.highest_mm);
        self.chiefs[wavelength].get_or_init(find).as_ref()
    }

    /// The picture of points at a node. Of heights whose light does not pass, and of places without a chief ray, that of
    /// the next height towards the axis.
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

    /// The tables of a node from bytes that were kept.
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

    /// The largest blur of the picture, as far as the tables see it: how far from the middle of a point's picture rays land,
    /// and how far it reaches, mm. `None` where it reaches as far as rays land, at all of a few image heights at a wavelength
    /// in nm.
    pub fn beyond_reach_mm(&self, nm: f64) -> Option<[f64; 2]> {
        let (wavelength, _) = self.wavelength(nm);
        let pictures = (0..HEIGHTS).step_by(6).filter_map(|height| self.spread(wavelength, 0, height));
        let beyond = pictures.map(|spread| spread.farthest_and_reach_mm).filter(|[far, reach]| far > reach);
        beyond.max_by(|a, b| a[0].total_cmp(&b[0]))
    }

    /// Azimuths that are tabled.
    fn tabled(&self) -> usize {
        if self.blades == 0 { 1 } else { TABLED }
    }

    /// Step from one azimuth of the tables to the next, rad.
    fn azimuth_step_rad(&self) -> f64 {
        TAU / (self.blades.max(1) * AZIMUTHS) as f64
    }

    /// How far an azimuth of the tables is from y, rad.
    fn azimuth_rad(&self, node: usize) -> f64 {
        self.across_blade_rad + self.azimuth_step_rad() * node as f64
    }

    /// Where light of a wavelength in nm lands from where its chief ray does, mm, near a sensor point, mm from the axis: by
    /// numbers in [0, 1). Zero where no light passes.
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

    /// The direction from a point before the lens, mm, on a unit vector, to what of the surface in focus is seen at a sensor
    /// point, mm from the axis, by the chief ray of a wavelength in nm. `None` beyond the chief rays.
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

    /// The sensor point, mm from the axis, at which a chief ray of a wavelength in nm lands that goes by where a ray out in
    /// the scene, mm and unit vector, meets what is in focus: the inverse of [`aim`](Self::aim).
    pub fn place(&self, origin: DVec3, direction: DVec3, nm: f64) -> Option<DVec2> {
        let point = self.focus.met(origin, direction);
        let (node, part) = self.wavelength(nm);
        let [low, high] = [self.chief(node)?.place(point)?, self.chief(node + 1)?.place(point)?];
        Some(low.lerp(high, part))
    }
}
