use std::f64::consts::PI;

use glam::DVec3;

use super::*;
use crate::files;
use crate::lens::Lens;

const SIZE: usize = 64;
/// Number of rays from the axis to the rim.
const RINGS: usize = 256;
const FREQUENCIES_PER_MM: [f64; 5] = [10.0, 20.0, 40.0, 70.0, 100.0];
const LINES_NM: [f64; 3] = [486.1327, 587.5618, 656.2725];

/// Lenses that ship, in all positions: as they are, and with wider rims, which makes them faster.
fn lenses() -> Vec<(String, Lens, Option<f64>)> {
    let of = |name: &'static str| {
        let reading = files::shipped(name).expect("ships");
        [1.0, 1.15].into_iter().flat_map(move |wider| {
            let mut prescription = reading.prescription.clone();
            prescription.surfaces.iter_mut().for_each(|surface| {
                surface.semi_aperture_mm = surface.semi_aperture_mm.map(|semi| semi * wider);
            });
            let lens = Lens::unchecked(&prescription);
            let positions: Vec<Lens> =
                prescription.positions.iter().map(|position| lens.in_position(position)).collect();
            let all = if positions.is_empty() { vec![lens] } else { positions };
            let half_field_rad = prescription.claims.half_field_deg.map(f64::to_radians);
            all.into_iter().enumerate().map(move |(i, lens)| (format!("{name} {wider} {i}"), lens, half_field_rad))
        })
    };
    files::names().flat_map(of).collect()
}

/// Pair of sin u′ and W, minus that of the axis, of a ray parallel to the axis at a height, traced along the light.
fn traced_in(at: &LensAt<'_>, height: f64) -> Option<(f64, f64)> {
    let origin = DVec3::new(0.0, height, -1.0);
    let steps = (0..at.lens.surfaces().len()).map(Step::refract);
    let mut length = 0.0;
    let ray = Ray { origin, direction: DVec3::Z };
    let out = at.trace(ray, Travel::ToSensor, steps, Apertures::Clip, |hit| length += hit.index * hit.distance).ok()?;
    let landing = out.at_z(at.lens.sensor_z_mm());
    let path = length + (landing - out.origin).dot(out.direction) - out.direction.y * landing.y;
    Some((-out.direction.y, path))
}

/// Area of the pupil and rms of W in mm, by rings.
fn by_rings(at: &LensAt<'_>) -> (f64, f64) {
    let [mut low, mut high] = [0.0, at.lens.surfaces()[0].semi_aperture_mm * 1.01];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if traced_in(at, middle).is_some() { low = middle } else { high = middle }
    }
    let at_part = |part: f64| traced_in(at, low * part.sqrt()).expect("inside");
    let (mut area, mut sum, mut squares) = (0.0, 0.0, 0.0);
    let axis = at_part(0.0).1;
    for i in 0..RINGS {
        let sine = |edge: usize| at_part(edge as f64 / RINGS as f64).0;
        let ring = PI * (sine(i + 1).powi(2) - sine(i).powi(2));
        let path = at_part((i as f64 + 0.5) / RINGS as f64).1 - axis;
        area += ring;
        sum += ring * path;
        squares += ring * path * path;
    }
    (area, (squares / area - (sum / area).powi(2)).sqrt())
}

#[test]
fn on_the_axis_pupils_are_round_and_whole() {
    for (name, lens, _) in lenses() {
        for nm in LINES_NM {
            let at = lens.at(nm);
            let wavefront = at.wavefront(0.0, SIZE).expect("light");
            let (area, rms_mm) = by_rings(&at);
            let found = wavefront.covered.iter().sum::<f64>() * wavefront.spacing.powi(2);
            assert_eq!(wavefront.lost, 0.0, "{name} {nm} nm");
            // Edges through cells: the square of a cell over the square of the radius, 1/31².
            assert!((found / area - 1.0).abs() < 1e-3, "{name} {nm} nm: {found} for {area} sr");
            let chief = at.chief_ray(0.0).expect("a chief ray");
            let found = at.path_differences(chief, f64::INFINITY).expect("light");
            let expected = rms_mm / (nm * 1e-6);
            assert_eq!(found.lost, 0.0, "{name} {nm} nm");
            assert!((found.rms_waves / expected - 1.0).abs() < 0.01, "{name} {nm} nm: {found:?} for {expected} waves");
            let spread = wavefront.point_spread();
            for frequency in FREQUENCIES_PER_MM {
                let [across, up] = [DVec2::X, DVec2::Y].map(|axis| spread.mtf(axis, frequency));
                assert!((across - up).abs() < 1e-5, "{name} {nm} nm, {frequency}/mm: {across} and {up}");
            }
        }
    }
}

#[test]
fn off_the_axis_no_point_of_a_pupil_is_lost() {
    for (name, lens, half_field_rad) in lenses() {
        let at = lens.at(LINES_NM[1]);
        let field = half_field_rad.unwrap_or(0.35);
        let Some(edge) = at.chief_ray(field) else { continue };
        for part in [0.5, 1.0] {
            let chief = at.chief_ray_at_height(part * edge.image_height_mm).expect("a chief ray");
            let Some(region) = Rays::new(&at, chief, f64::INFINITY).region(DIRECTIONS) else { continue };
            let wavefront = at.wavefront_of(chief, f64::INFINITY, SIZE).expect("light");
            let found = wavefront.covered.iter().sum::<f64>() * wavefront.spacing.powi(2);
            assert_eq!(wavefront.lost, 0.0, "{name} {part}");
            // Corners of a cat's eye cut cells otherwise than along an edge.
            assert!((found / region.area() - 1.0).abs() < 3e-3, "{name} {part}: {found} for {} sr", region.area());
        }
    }
}
