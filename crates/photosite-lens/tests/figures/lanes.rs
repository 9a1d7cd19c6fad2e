//! Rays in lanes of single precision against the same rays in double precision, which are those of both programs.

use glam::DVec2;
use photosite_core::math::philox::Philox;
use photosite_lens::lanes::{LaneLens, LaneRay};
use photosite_lens::prescription::Blades;
use photosite_lens::profile::Travel;
use photosite_lens::pupil_table::PupilTable;
use photosite_lens::trace::{Apertures, Step};
use photosite_lens::{Lens, Prescription, Ray};
use rand::RngExt;

use crate::neutral::{Case, cases, close, number, prescription, read};

const PUPIL_NM: [f64; 3] = [450.0, 550.0, 650.0];
/// Number of rays of each case.
const RAYS: u32 = 3000;
/// Number of rays that are also traced one by one.
const ALONE: usize = 500;
/// Tolerances of landing points, mm, and of the transmittance of a surface. A direction error of δ moves the image by
/// f·δ.
const POINT_MM: f64 = 1e-4;
const TRANSMITTANCE: f64 = 1e-4;

/// Traces rays from the sensor out, and each back in at another wavelength. Rays within the error of single precision
/// of a rim may pass in one and not in the other: 1e-4 mm of a pupil of millimetres, and 1e-3 of the rays at most.
fn compare(name: &str, lens: &Lens, corner_mm: f64) {
    let pupil = PupilTable::new(lens, corner_mm, &PUPIL_NM);
    let lanes = LaneLens::new(lens, &pupil, corner_mm);
    let mut random = Philox::new(41, 0);
    let mut unit = || random.random::<f64>();
    let mut nm = || (450.0 + 200.0 * unit()).round();
    let wavelengths: Vec<[f64; 2]> = (0..RAYS).map(|_| [nm(), nm()]).collect();
    let mut starts: Vec<(DVec2, DVec2)> = Vec::new();
    for _ in 0..RAYS {
        let point = DVec2::from_angle(unit() * std::f64::consts::TAU) * corner_mm * unit();
        let direction = pupil.sample(point, [unit(), unit()]).unwrap_or_else(|| panic!("{name}: {point} is dark"));
        starts.push((point, direction.cosines));
    }
    let mut out: Vec<LaneRay> = starts
        .iter()
        .zip(&wavelengths)
        .map(|(&(point, cosines), [nm, _])| LaneRay::from_sensor(point, cosines, *nm as f32))
        .collect();
    let mut alone = out[..ALONE].to_vec();
    lanes.trace_out(&mut out);
    // What becomes of a ray does not depend on those beside it.
    alone.iter_mut().for_each(|ray| lanes.trace_out(std::slice::from_mut(ray)));
    for (alone, beside) in alone.iter().zip(&out) {
        assert!(alone == beside || alone.passed == 0.0 && beside.passed == 0.0, "{name}: {alone:?} {beside:?}");
    }
    let mut back: Vec<LaneRay> = out.iter().zip(&wavelengths).map(|(ray, [_, nm])| ray.back(*nm as f32)).collect();
    lanes.trace_in(&mut back);

    let (mut differ, mut passing) = (0, 0);
    let (count, efl_mm) = (lens.surfaces().len(), lens.at(550.0).first_order().efl_mm);
    for (i, &(point, cosines)) in starts.iter().enumerate() {
        let [first, second] = wavelengths[i];
        let at = lens.at(first);
        let mut passed = 1.0;
        let steps = (0..count).rev().map(Step::refract);
        let exact = at.trace(at.ray_from_sensor(point, cosines), Travel::ToScene, steps, Apertures::Clip, |hit| {
            passed *= at.split_at(hit).mean_transmittance();
        });
        differ += u32::from(exact.is_ok() != (out[i].passed > 0.0));
        let (Ok(exact), true) = (exact, out[i].passed > 0.0) else { continue };
        let what = format!("{name}, ray {i} from {point} at {first} nm");
        close(&what, out[i].point.as_dvec3().distance(exact.origin), 0.0, POINT_MM);
        close(&what, out[i].direction.as_dvec3().distance(exact.direction), 0.0, POINT_MM / efl_mm);
        close(&what, out[i].passed.into(), passed, TRANSMITTANCE * count as f64);
        // From where the lanes are, so that only the way in is compared.
        let origin = out[i].point.as_dvec3();
        let ray = Ray { origin, direction: -out[i].direction.as_dvec3().normalize() };
        let landed = lens.at(second).trace_in(ray, Apertures::Clip);
        differ += u32::from(landed.is_ok() != (back[i].passed > 0.0));
        let (Ok(landed), true) = (landed, back[i].passed > 0.0) else { continue };
        passing += 1;
        let there = landed.at_z(lens.sensor_z_mm()).truncate();
        close(
            &format!("{what}, back at {second} nm"),
            back[i].point.truncate().as_dvec2().distance(there),
            0.0,
            POINT_MM,
        );
        if first == second {
            close(&what, there.distance(point), 0.0, POINT_MM);
        }
    }
    assert!(differ <= RAYS / 1000 && passing > RAYS / 2, "{name}: {differ} differ, {passing} pass");
}

#[test]
fn rays_in_lanes_are_those_in_double_precision() {
    for Case { name, lens, figures, .. } in cases() {
        compare(&name, &lens, number(&figures["image_half_diagonal_mm"]));
    }
}

#[test]
fn so_are_those_that_blades_cut_off() {
    let file = read("double-gauss");
    let blades = Some(Blades { count: 7, rotation_deg: 12.0 });
    let lens = Lens::new(&Prescription { blades, ..prescription(&file) }).expect("a lens");
    let lens = lens.with_stop_radius(0.5 * lens.stop_radius_mm());
    compare("double-gauss with blades", &lens, number(&file["figures"]["image_half_diagonal_mm"]));
}
