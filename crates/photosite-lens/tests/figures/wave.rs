//! Point spread functions by diffraction, for objects at any distance, and offsets that are drawn from them.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::{Arc, Mutex};

use glam::{DMat2, DVec2, DVec3};
use photosite_lens::focus::{Distance, FocusBy};
use photosite_lens::profile::Travel;
use photosite_lens::spread_table::SpreadTable;
use photosite_lens::trace::{Apertures, LensAt, Step};
use photosite_lens::wave::{FocusSurface, Shelf, WaveSpread};
use photosite_lens::{Lens, Ray, files};

const NM: f64 = 550.0;
/// Offsets that are drawn along each side of a grid.
const N: u32 = 512;

/// A lens that ships, stopped down and focused on a distance from its first vertex.
fn lens(name: &str, f_number: f64, distance_mm: f64) -> Lens {
    let lens = files::shipped(name).expect("ships").lens;
    let lens = lens.with_stop_radius(lens.at(587.5618).stop_radius_of_f_number(f_number));
    let spectrum = [(NM, 1.0)];
    let distance = if distance_mm.is_finite() { Distance::FromFirstVertex(distance_mm) } else { Distance::Infinity };
    lens.focused_by_spot(FocusBy::WholeLens, distance, &spectrum).expect("within reach")
}

/// Distance along a chief ray to the plane at a distance before the first vertex.
fn along(chief: &photosite_lens::chief::ChiefRay, distance_mm: f64) -> f64 {
    (chief.before.origin.z + distance_mm) / chief.before.direction.z
}

/// Σ exp(−2πi·ν·x)/n over offsets, along an axis.
fn transform(offsets: impl Iterator<Item = DVec2>, axis: DVec2, frequency: f64) -> DVec2 {
    let phases = offsets.map(|x| (DVec2::from_angle(-TAU * frequency * x.dot(axis)), 1.0));
    let (sum, count) = phases.fold((DVec2::ZERO, 0.0), |(sum, count), (phase, one)| (sum + phase, count + one));
    sum / count
}

fn drawn(draw: impl Fn([f64; 2]) -> DVec2) -> Vec<DVec2> {
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(N);
    (0..N * N).map(|i| draw([at(i % N), at(i / N)])).collect()
}

/// Modulation by diffraction at a round aperture, at a fraction of the limit (M. Born, E. Wolf, §9.5.2).
fn round(part: f64) -> f64 {
    if part >= 1.0 { 0.0 } else { 2.0 / PI * (part.acos() - part * (1.0 - part * part).sqrt()) }
}

/// The optical path from an object point to the sensor along the ray that arrives with given direction cosines, found by
/// tracing in, as light goes: W is that less D·(landing − chief landing) but for the chief ray's own.
fn path_in(at: &LensAt<'_>, object: DVec3, start: DVec3, cosines: DVec2) -> (f64, DVec2) {
    let across = start.any_orthonormal_pair();
    let ray = |turn: DVec2| {
        let direction = (start + across.0 * turn.x + across.1 * turn.y).normalize();
        // From near the lens, so that no digit is lost on the way there.
        let to_plane = (-20.0 - object.z) / direction.z;
        (Ray { origin: object + direction * to_plane, direction }, to_plane)
    };
    let behind = |turn: DVec2| at.trace_in(ray(turn).0, Apertures::Ignore).expect("passes");
    let miss = |turn: DVec2| behind(turn).direction.truncate() + cosines;
    let mut turn = DVec2::ZERO;
    for _ in 0..30 {
        let step = 1e-6;
        let here = miss(turn);
        let jacobian = DMat2::from_cols(
            (miss(turn + DVec2::X * step) - here) / step,
            (miss(turn + DVec2::Y * step) - here) / step,
        );
        turn -= jacobian.inverse() * here;
    }
    let (ray, mut length) = ray(turn);
    let steps = (0..at.lens.surfaces().len()).map(Step::refract);
    let out = at.trace(ray, Travel::ToSensor, steps, Apertures::Ignore, |hit| length += hit.index * hit.distance);
    let out = out.expect("passes");
    let landing = out.at_z(at.lens.sensor_z_mm());
    (length + (landing - out.origin).dot(out.direction), landing.truncate())
}

#[test]
fn path_differences_of_a_near_object_are_those_of_rays_from_it() {
    let distance = 700.0;
    let lens = lens("double-gauss", 2.8, distance);
    let at = lens.at(NM);
    for height in [0.0, 9.0, 18.0] {
        let chief = at.chief_ray_at_height(height).expect("a chief ray");
        let wavefront = at.wavefront_of(chief, along(&chief, distance), 32).expect("light");
        let object = chief.before.origin - chief.before.direction * along(&chief, distance);
        assert!((object.z + distance).abs() < 1e-9);
        let w = |cosines: DVec2| {
            let (path, landing) = path_in(&at, object, chief.before.direction, cosines);
            path + cosines.dot(landing - DVec2::new(0.0, chief.image_height_mm))
        };
        let zero = w(-chief.behind.direction.truncate());
        let mut worst = 0.0_f64;
        let mut largest = 0.0_f64;
        for (i, path) in wavefront.path_mm.iter().enumerate().step_by(7) {
            let Some(path) = path else { continue };
            let cosines = wavefront.cosines[i];
            worst = worst.max((path - (w(cosines) - zero)).abs());
            largest = largest.max(path.abs());
        }
        // Both are sums of some 800 mm in f64; a slip of a sign is as large as the aberrations.
        assert!(worst < 1e-8 && largest > 1e-4, "{height} mm: {worst} of {largest} mm");
    }
}

#[test]
fn objects_far_away_are_those_at_infinity() {
    let lens = lens("double-gauss", 4.0, f64::INFINITY);
    let at = lens.at(NM);
    let chief = at.chief_ray(0.2).expect("a chief ray");
    let near = at.wavefront_of(chief, 1e10, 24).expect("light");
    let far = at.wavefront(0.2, 24).expect("light");
    let both = near.path_mm.iter().zip(&far.path_mm).filter_map(|(near, far)| Some(((*near)?, (*far)?)));
    // The sphere's height over the plane, (15 mm)²/2/1e10 mm, is 1e-8 mm.
    let worst = both.map(|(near, far)| (near - far).abs()).fold(0.0, f64::max);
    assert!(worst < 3e-8, "{worst} mm");
}

/// Interpolation from a coarse grid, with partly covered cells at the edge, agrees with a fine traced grid.
#[test]
fn interpolated_wave_fronts_have_the_modulation_of_traced_ones() {
    for (name, f_number) in [("double-gauss", 2.8), ("retrofocus", 5.6), ("phone-us7535658", 2.8), ("canon-rf24", 4.0)]
    {
        let lens = lens(name, f_number, f64::INFINITY);
        let at = lens.at(NM);
        let corner = at.chief_ray(0.3).expect("a chief ray").image_height_mm;
        for part in [0.0, 0.6, 1.0] {
            let chief = at.chief_ray_at_height(part * corner).expect("a chief ray");
            let found = at.point_spread(chief, f64::INFINITY).expect("light");
            let wavefront = at.wavefront_of(chief, f64::INFINITY, 200).expect("light");
            let limit = wavefront.spacing * 199.0 / (NM * 1e-6);
            let expected = wavefront.point_spread();
            for axis in [DVec2::X, DVec2::Y] {
                for frequency in [0.03, 0.1, 0.2, 0.4, 0.7].map(|part| part * limit) {
                    let (a, b) = (found.mtf(axis, frequency), expected.mtf(axis, frequency));
                    // 0.3 and 0.2 % of the light is folded back into the two images, whose sizes differ.
                    assert!((a - b).abs() < 6e-3, "{name} {part} {axis} {frequency}/mm: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn offsets_of_a_table_have_the_modulation_of_the_image() {
    for (f_number, height) in [(2.0, 0.0), (2.0, 15.0), (4.0, 10.0), (8.0, 20.0), (22.0, 0.0)] {
        let lens = lens("double-gauss", f_number, 1500.0);
        let at = lens.at(NM);
        let chief = at.chief_ray_at_height(height).expect("a chief ray");
        let spread = at.point_spread(chief, along(&chief, 1500.0)).expect("light");
        let table = SpreadTable::new(&spread);
        let offsets = drawn(|u| table.sample(u));
        let limit = 1.0 / (f_number * NM * 1e-6);
        for axis in [DVec2::X, DVec2::Y] {
            for frequency in [5.0, 20.0, 50.0, 100.0, 0.5 * limit] {
                let (a, b) =
                    (transform(offsets.iter().copied(), axis, frequency).length(), spread.mtf(axis, frequency));
                // 64 cells from the middle, cells twice as large: sinc(0.11) of 1.1 µm at 100/mm, of what lands there.
                assert!((a - b).abs() < 8e-3, "f/{f_number} {height} mm {axis} {frequency}/mm: {a} {b}");
            }
        }
    }
}

/// Many waves of coma, so that the landing points of rays determine the point spread function but for the modulation of
/// diffraction alone; with its phase, which an image upside down, or shifted, would change.
#[test]
fn light_of_large_aberrations_lands_where_rays_do() {
    let distance = 1200.0;
    let lens = lens("double-gauss", 1.8, distance);
    let at = lens.at(NM);
    let chief = at.chief_ray_at_height(12.0).expect("a chief ray");
    let from = along(&chief, distance);
    let object = chief.before.origin - chief.before.direction * from;
    let table = SpreadTable::new(&at.point_spread(chief, from).expect("light"));
    let offsets = drawn(|u| table.sample(u));
    // Rays evenly over the directions from the sensor are those of the pupil's image; here evenly over those to the
    // lens, whose density there differs by little.
    let (sagittal, meridional) = (DVec3::X, DVec3::X.cross(chief.before.direction));
    let reach = 40.0 / from;
    let place = |i: i32| reach * (f64::from(i) / 300.0 - 1.0);
    let landing = |i: i32| {
        let direction = chief.before.direction + sagittal * place(i % 601) + meridional * place(i / 601);
        let origin = object + direction * (from - 40.0);
        let landed = at.landing(Ray { origin, direction: direction.normalize() }, Apertures::Clip)?;
        Some(landed - DVec2::new(0.0, chief.image_height_mm))
    };
    let mut is_told = false;
    let rays: Vec<DVec2> = (0..601 * 601).filter_map(landing).collect();
    for axis in [DVec2::X, DVec2::Y] {
        for frequency in [3.0, 6.0, 12.0, 20.0] {
            let found = transform(offsets.iter().copied(), axis, frequency);
            let expected = transform(rays.iter().copied(), axis, frequency) * round(frequency * 1.8 * NM * 1e-6);
            assert!(found.distance(expected) < 0.03, "{axis} {frequency}/mm: {found} {expected}");
            let upside_down = DVec2::new(expected.x, -expected.y);
            is_told |= found.distance(upside_down) > 0.1;
        }
    }
    assert!(is_told);
}

#[test]
fn a_lens_of_small_aberrations_makes_airys_pattern() {
    let distance = 3000.0;
    let lens = lens("double-gauss", 16.0, distance);
    let at = lens.at(NM);
    let pupil = at.pupil_region(0.0, 128).expect("light");
    let limit = 2.0 * pupil.boundary(0).distance(pupil.centre) / (NM * 1e-6);
    let reference_mm = at.first_order().entrance_pupil_mm;
    let focus = FocusSurface { distance_mm: distance + reference_mm, reference_mm, is_flat: true };
    let wave = WaveSpread::new(&lens, focus, 20.0, NM);
    let offsets = drawn(|u| wave.offset(DVec2::ZERO, NM, u));
    for axis in [DVec2::X, DVec2::Y] {
        for part in [0.1, 0.25, 0.5, 0.75, 0.9, 1.1] {
            let found = transform(offsets.iter().copied(), axis, part * limit).length();
            // W is 0.02 λ there: 1 − (2π·0.02)² of Strehl's ratio.
            assert!((found - round(part)).abs() < 0.012, "{axis} {part}: {found} {}", round(part));
        }
    }
    // 83.8 % within the first dark ring, 1.22/limit.
    let within = offsets.iter().filter(|offset| offset.length() * limit < 1.2197).count() as f64 / f64::from(N * N);
    assert!((within - 0.838).abs() < 0.012, "{within}");
}

/// Modulation in the middle between the nodes of height and of wavelength, whose tables are mixed.
#[test]
fn between_nodes_the_modulation_is_nearly_that_of_the_place() {
    let distance = 2000.0;
    for (name, f_number, corner) in
        [("double-gauss", 2.0, 21.6), ("double-gauss", 5.6, 21.6), ("retrofocus", 4.0, 21.6), ("canon-rf24", 4.0, 21.6)]
    {
        let lens = lens(name, f_number, distance);
        let reference_mm = lens.at(587.5618).first_order().entrance_pupil_mm;
        let focus = FocusSurface { distance_mm: distance + reference_mm, reference_mm, is_flat: true };
        let wave = WaveSpread::new(&lens, focus, corner, NM);
        for (height, nm) in [(12.5, 550.0), (12.0, 562.5), (12.5, 437.5), (20.5, 612.5)] {
            let height = height / 24.0 * corner;
            let at = lens.at(nm);
            let chief = at.chief_ray_at_height(height).expect("a chief ray");
            let expected = at.point_spread(chief, along(&chief, distance)).expect("light");
            let offsets = drawn(|u| wave.offset(DVec2::new(0.0, height), nm, u));
            for axis in [DVec2::X, DVec2::Y] {
                let worst = [10.0, 20.0, 40.0, 80.0].map(|frequency| {
                    transform(offsets.iter().copied(), axis, frequency).length() - expected.mtf(axis, frequency)
                });
                let most = worst.iter().fold(0.0_f64, |most, off| most.max(off.abs()));
                // Half-way between two of height, or somewhere between wavelengths; see `WaveSpread`.
                assert!(most < 0.03, "{name} f/{f_number} {height} mm {nm} nm {axis}: {worst:?}");
            }
        }
    }
}

/// Every number that point spread functions depend on is in the key: a change of any makes another key.
#[test]
fn another_lens_stop_focus_wavelength_or_sensor_has_another_key() {
    let prescription = files::shipped("canon-rf24").expect("ships").prescription;
    let focus = FocusSurface { distance_mm: 2000.0, reference_mm: 30.0, is_flat: true };
    let key =
        |lens: &Lens, focus: FocusSurface, corner_mm: f64, nm: f64| WaveSpread::new(lens, focus, corner_mm, nm).key();
    let lens = Lens::new(&prescription).expect("a lens");
    let changed = |change: &dyn Fn(&mut photosite_lens::Prescription)| {
        let mut prescription = prescription.clone();
        change(&mut prescription);
        key(&Lens::new(&prescription).expect("a lens"), focus, 21.6, NM)
    };
    let asphere = prescription.surfaces.iter().position(|surface| !surface.asphere.is_empty()).expect("an asphere");
    let glass = prescription.surfaces.iter().position(|surface| surface.glass.is_some()).expect("glass");
    let mut other = prescription.surfaces.iter().filter_map(|surface| surface.glass.clone());
    let other = other.next_back().expect("glass");
    let least = 1.0 + 4.0 * f64::EPSILON;
    let keys = [
        key(&lens, focus, 21.6, NM),
        key(&lens.with_stop_radius(lens.stop_radius_mm() / least), focus, 21.6, NM),
        key(&lens.with_gaps(&[(lens.surfaces().len() - 1, 40.0)]), focus, 21.6, NM),
        key(&lens, FocusSurface { distance_mm: 2000.0 * least, ..focus }, 21.6, NM),
        key(&lens, FocusSurface { reference_mm: 30.0 * least, ..focus }, 21.6, NM),
        key(&lens, FocusSurface { is_flat: false, ..focus }, 21.6, NM),
        key(&lens, focus, 21.6 * least, NM),
        key(&lens, focus, 21.6, NM + 1.0),
        changed(&|p| p.surfaces[glass].radius_mm = p.surfaces[glass].radius_mm.map(|radius| radius * least)),
        changed(&|p| p.surfaces[glass].thickness_mm *= least),
        changed(&|p| p.surfaces[glass].semi_aperture_mm = p.surfaces[glass].semi_aperture_mm.map(|semi| semi / least)),
        changed(&|p| p.surfaces[glass].glass = Some(other.clone())),
        changed(&|p| p.surfaces[asphere].conic += 1e-15),
        changed(&|p| p.surfaces[asphere].asphere[0].1 *= least),
        changed(&|p| p.blades = Some(photosite_lens::prescription::Blades { count: 7, rotation_deg: 0.0 })),
        changed(&|p| p.blades = Some(photosite_lens::prescription::Blades { count: 9, rotation_deg: 0.0 })),
        changed(&|p| p.blades = Some(photosite_lens::prescription::Blades { count: 7, rotation_deg: 1.0 })),
    ];
    for (i, one) in keys.iter().enumerate() {
        assert!(keys[..i].iter().all(|other| other != one), "{i}");
    }
    assert_eq!(keys[0], key(&lens.clone(), focus, 21.6, NM));
}

/// A shelf in memory.
#[derive(Debug, Default)]
struct Kept(Mutex<HashMap<usize, Vec<u8>>>);

impl Shelf for Kept {
    fn take(&self, number: usize) -> Option<Vec<u8>> {
        self.0.lock().expect("whole").get(&number).cloned()
    }

    fn keep(&self, number: usize, bytes: &[u8]) {
        self.0.lock().expect("whole").insert(number, bytes.to_vec());
    }
}

/// Offsets from kept tables equal those computed anew, to the last bit, and so do those where the kept bytes are of
/// something else.
#[test]
fn images_that_were_kept_are_the_same() {
    let prescription = files::shipped("double-gauss").expect("ships").prescription;
    for blades in [None, Some(photosite_lens::prescription::Blades { count: 6, rotation_deg: 20.0 })] {
        let lens = Lens::new(&photosite_lens::Prescription { blades, ..prescription.clone() }).expect("a lens");
        let focus = FocusSurface { distance_mm: f64::INFINITY, reference_mm: 0.0, is_flat: true };
        let shelf = Arc::new(Kept::default());
        let wave = || WaveSpread::new(&lens, focus, 21.6, NM).with_shelf(shelf.clone());
        let offsets = |wave: &WaveSpread| -> Vec<DVec2> {
            let point = |i: u32| DVec2::from_angle(f64::from(i)) * 3.0;
            (0..40).map(|i| wave.offset(point(i), NM, [f64::from(i) / 40.0, (f64::from(i) * 0.618).fract()])).collect()
        };
        let first = offsets(&wave());
        let kept = shelf.0.lock().expect("whole").len();
        assert!(kept > 1 && offsets(&wave()) == first && shelf.0.lock().expect("whole").len() == kept);
        shelf.0.lock().expect("whole").values_mut().for_each(|bytes| bytes.truncate(bytes.len() - 1));
        assert_eq!(offsets(&wave()), first);
    }
}

/// Openings of a stop with blades do not turn with the azimuth, and neither do the spikes of the point spread function.
#[test]
fn images_turn_with_the_place_and_spikes_do_not() {
    let distance = 2000.0;
    let prescription = files::shipped("double-gauss").expect("ships").prescription;
    let blades = Some(photosite_lens::prescription::Blades { count: 5, rotation_deg: 11.0 });
    let lens = Lens::new(&photosite_lens::Prescription { blades, ..prescription }).expect("a lens");
    let lens = lens.with_stop_radius(lens.at(587.5618).stop_radius_of_f_number(11.0));
    let lens =
        lens.focused_by_spot(FocusBy::WholeLens, Distance::FromFirstVertex(distance), &[(NM, 1.0)]).expect("focus");
    let reference_mm = lens.at(587.5618).first_order().entrance_pupil_mm;
    let focus = FocusSurface { distance_mm: distance + reference_mm, reference_mm, is_flat: true };
    let wave = WaveSpread::new(&lens, focus, 21.6, NM);
    for azimuth in [0.0_f64, 0.4, 1.9, 3.3, 5.0] {
        let point = DVec2::from_angle(azimuth) * 6.0;
        let offsets = drawn(|u| wave.offset(point, NM, u));
        // Five edges make ten spikes, across them: light far out by its direction, folded by tenths of a turn.
        let far = offsets.iter().filter(|offset| offset.length() > 0.03 && offset.length() < 0.2);
        let folded = far.map(|offset| DVec2::from_angle(10.0 * offset.to_angle())).sum::<DVec2>();
        // Edges lie in the middle between corners at 11° + k·72°.
        let expected = (10.0 * (11.0 + 36.0_f64).to_radians()).rem_euclid(TAU);
        let off = (folded.to_angle() - expected + PI).rem_euclid(TAU) - PI;
        assert!(off.abs() < 0.3, "at {azimuth} rad: {} rad off", off / 10.0);
    }
}

/// Azimuths of the tables, computed or mirrored: edges lie at 47° + k·72°, so that tables are at 29° + k·18° from y.
#[test]
fn images_of_blades_are_those_of_the_lens_turned_to_the_place() {
    const HEIGHT: f64 = 16.0 / 24.0 * 21.6;
    // What a mirror image cuts off or in half at the borders of the levels of a table: rows with below a thousandth of the light.
    const BOUND: f64 = 1e-3;
    let distance = 2000.0;
    let prescription = files::shipped("double-gauss").expect("ships").prescription;
    let turned = |rotation_deg: f64| {
        let blades = Some(photosite_lens::prescription::Blades { count: 5, rotation_deg });
        let lens = Lens::new(&photosite_lens::Prescription { blades, ..prescription.clone() }).expect("a lens");
        let lens = lens.with_stop_radius(lens.at(587.5618).stop_radius_of_f_number(4.0));
        lens.focused_by_spot(FocusBy::WholeLens, Distance::FromFirstVertex(distance), &[(NM, 1.0)]).expect("focus")
    };
    let lens = turned(11.0);
    let reference_mm = lens.at(587.5618).first_order().entrance_pupil_mm;
    let focus = FocusSurface { distance_mm: distance + reference_mm, reference_mm, is_flat: true };
    let wave = WaveSpread::new(&lens, focus, 21.6, NM);
    let mut is_told = false;
    for azimuth_deg in [29.0_f64, 47.0, 65.0, 83.0, 227.0] {
        let turn = DVec2::from_angle(azimuth_deg.to_radians());
        let offsets: Vec<DVec2> = drawn(|u| wave.offset(turn.rotate(DVec2::Y * HEIGHT), NM, u));
        let last = lens.surfaces().len() - 1;
        let lens = turned(11.0 - azimuth_deg).with_gaps(&[(last, lens.gap_mm(last))]);
        let at = lens.at(NM);
        let chief = at.chief_ray_at_height(HEIGHT).expect("a chief ray");
        let table = SpreadTable::new(&at.point_spread(chief, along(&chief, distance)).expect("light"));
        let expected = drawn(|u| table.sample(u));
        for axis in [DVec2::X, DVec2::Y, DVec2::new(0.6, 0.8), DVec2::new(-0.6, 0.8)] {
            for frequency in [25.0, 60.0, 100.0] {
                let found = transform(offsets.iter().copied(), turn.rotate(axis), frequency);
                let [exact, mirrored] = [axis, DVec2::new(-axis.x, axis.y)]
                    .map(|axis| transform(expected.iter().copied(), axis, frequency));
                assert!(found.distance(exact) < BOUND, "{azimuth_deg}° {axis} {frequency}/mm: {found} {exact}");
                is_told |= mirrored.distance(exact) > 10.0 * BOUND;
            }
        }
    }
    assert!(is_told, "mirror images are told apart");
}
