//! A lens that can be traced: the checked surfaces of a prescription in one position of zoom and focus.

use glam::DVec2;

use photosite_core::spectrum::Dispersion;

use crate::prescription::{Blades, Coating, Position, Prescription};
use crate::profile::Profile;

/// A lens in one position of zoom and focus, at one opening of its stop. Lengths are mm.
#[derive(Clone, Debug)]
pub struct Lens {
    surfaces: Vec<LensSurface>,
    stop: usize,
    blades: Option<BladesOf>,
    sensor_z_mm: f64,
}

/// A surface of a [`Lens`].
#[derive(Clone, Debug)]
pub struct LensSurface {
    /// Shape of the surface.
    pub profile: Profile,
    /// Position of the vertex on the axis.
    pub z_mm: f64,
    /// Distance along the axis to the next surface, or from the last to the sensor.
    pub(crate) gap_mm: f64,
    /// Radius within which light passes.
    pub semi_aperture_mm: f64,
    /// Glass of the gap behind the surface; `None` is air.
    pub glass: Option<Dispersion>,
    /// Coating of the surface.
    pub coating: Coating,
}

impl LensSurface {
    /// Index of the gap behind the surface.
    pub(crate) fn index_behind(&self, wavelength_nm: f64) -> f64 {
        self.glass.as_ref().map_or(1.0, |glass| glass.index(wavelength_nm))
    }
}

/// Opening of a stop with blades: a regular polygon in the unit circle.
#[derive(Clone, Debug)]
struct BladesOf {
    /// Unit normals of the edges.
    normals: Vec<DVec2>,
    /// Distance of the edges from the axis.
    apothem: f64,
}

impl BladesOf {
    fn new(blades: Blades) -> Self {
        let count = f64::from(blades.count);
        let middle_of_edge = |i: u32| (f64::from(i) + 0.5) * std::f64::consts::TAU / count;
        let normal = |i| DVec2::from_angle(blades.rotation_deg.to_radians() + middle_of_edge(i));
        Self { normals: (0..blades.count).map(normal).collect(), apothem: (std::f64::consts::PI / count).cos() }
    }
}

impl Lens {
    /// The lens of a prescription whose values are checked, with its surfaces' own thicknesses.
    pub(crate) fn unchecked(prescription: &Prescription) -> Self {
        let surfaces = prescription.surfaces.iter().map(|surface| LensSurface {
            profile: Profile::new(surface),
            z_mm: 0.0,
            gap_mm: surface.thickness_mm,
            semi_aperture_mm: surface.semi_aperture_mm.expect("checked"),
            glass: surface.glass.as_ref().map(|glass| glass.dispersion.clone()),
            coating: surface.coating.clone(),
        });
        let stop = prescription.surfaces.iter().position(|surface| surface.is_stop).expect("checked");
        let blades = prescription.blades.map(BladesOf::new);
        let mut lens = Self { surfaces: surfaces.collect(), stop, blades, sensor_z_mm: 0.0 };
        lens.place();
        lens
    }

    /// Places surfaces and sensor by the gaps.
    fn place(&mut self) {
        self.sensor_z_mm = self.surfaces.iter_mut().fold(0.0, |z, surface| {
            surface.z_mm = z;
            z + surface.gap_mm
        });
    }

    /// Surfaces, from the scene to the sensor.
    pub fn surfaces(&self) -> &[LensSurface] {
        &self.surfaces
    }

    /// Number of the stop surface.
    pub fn stop(&self) -> usize {
        self.stop
    }

    /// Radius of the stop, mm.
    pub fn stop_radius_mm(&self) -> f64 {
        self.surfaces[self.stop].semi_aperture_mm
    }

    /// Unit normals of the edges of a stop with blades, and the edges' distance from the axis, mm; `None` of a round
    /// one.
    pub(crate) fn stop_edges(&self) -> Option<(&[DVec2], f64)> {
        let BladesOf { normals, apothem } = self.blades.as_ref()?;
        Some((normals, self.stop_radius_mm() * apothem))
    }

    /// Fraction of a circle about the axis, of a radius in mm, that lies within the blades of the stop: each of n edges
    /// at the distance a cuts off acos(a/r)/π. The fraction is 1 for a round stop.
    pub(crate) fn part_within_blades(&self, radius_mm: f64) -> f64 {
        let Some((normals, edge_mm)) = self.stop_edges() else { return 1.0 };
        let cut_off = (edge_mm / radius_mm).min(1.0).acos() / std::f64::consts::PI;
        (1.0 - normals.len() as f64 * cut_off).max(0.0)
    }

    /// Position of the sensor on the axis, mm.
    pub fn sensor_z_mm(&self) -> f64 {
        self.sensor_z_mm
    }

    /// Distance along the axis from a surface to the next, or from the last to the sensor, mm.
    pub fn gap_mm(&self, surface: usize) -> f64 {
        self.surfaces[surface].gap_mm
    }

    /// Lens with the stop opened to a radius, mm.
    #[must_use]
    pub fn with_stop_radius(&self, radius_mm: f64) -> Self {
        let mut lens = self.clone();
        lens.surfaces[self.stop].semi_aperture_mm = radius_mm;
        lens
    }

    /// Lens with a round stop in place of blades.
    #[must_use]
    pub fn with_round_stop(&self) -> Self {
        Self { blades: None, ..self.clone() }
    }

    /// Lens with the blades of its stop turned by an angle in rad.
    #[must_use]
    pub(crate) fn with_turned_stop(&self, angle_rad: f64) -> Self {
        let turn = DVec2::from_angle(angle_rad);
        let mut lens = self.clone();
        let normals = lens.blades.iter_mut().flat_map(|blades| &mut blades.normals);
        normals.for_each(|normal| *normal = turn.rotate(*normal));
        lens
    }

    /// Lens with other gaps: pairs of the surface before the gap and its thickness, mm.
    #[must_use]
    pub fn with_gaps(&self, gaps: &[(usize, f64)]) -> Self {
        let mut lens = self.clone();
        gaps.iter().for_each(|&(surface, thickness_mm)| lens.surfaces[surface].gap_mm = thickness_mm);
        lens.place();
        lens
    }

    /// Lens in a position of its prescription.
    #[must_use]
    pub fn in_position(&self, position: &Position) -> Self {
        let lens = self.with_gaps(&position.gaps);
        position.stop_semi_aperture_mm.map_or(lens.clone(), |radius_mm| lens.with_stop_radius(radius_mm))
    }

    /// Distance of a point, mm from the axis, inside the opening of a surface, relative to its radius; below 0 outside.
    pub(crate) fn margin(&self, surface: usize, point: DVec2) -> f64 {
        let radius = self.surfaces[surface].semi_aperture_mm;
        let within = 1.0 - point.length() / radius;
        match &self.blades {
            Some(blades) if surface == self.stop => {
                let edges = blades.normals.iter().map(|normal| blades.apothem - normal.dot(point) / radius);
                edges.fold(within, f64::min)
            }
            Some(_) | None => within,
        }
    }

    /// Whether light passes a surface at a point, mm from the axis.
    pub(crate) fn passes(&self, surface: usize, point: DVec2) -> bool {
        let radius = self.surfaces[surface].semi_aperture_mm;
        point.length_squared() <= radius * radius
            && match &self.blades {
                Some(blades) if surface == self.stop => {
                    blades.normals.iter().all(|normal| normal.dot(point) <= radius * blades.apothem)
                }
                Some(_) | None => true,
            }
    }
}
