//! Path differences and the modulation that diffraction leaves.

use glam::DVec2;
use photosite_lens::Lens;

use crate::neutral::{LENSES, close, list, number, numbers, prescription, read, wavelengths};

/// Optiland's FFT differs by 0.01, and by 0.03 where the wave front is worse than 0.14 waves, as between the programs.
#[test]
fn diffraction_mtf_and_path_differences() {
    for name in LENSES {
        let file = read(name);
        let figures = &file["figures"];
        let (mtf, nm) = (&figures["mtf"], wavelengths(figures)[1]);
        let lens = Lens::new(&prescription(&file)).expect("a lens");
        let lens = lens.with_stop_radius(number(&mtf["stop_semi_aperture_mm"]));
        let at = lens.at(nm);
        for field in list(&mtf["fields"]) {
            let degrees = number(&field["field_deg"]);
            let chief = at.chief_ray(degrees.to_radians()).expect("a chief ray");
            let rms = at.path_differences(chief, f64::INFINITY).expect("light").rms_waves;
            if let Some(expected) = field["ray_optics"].get("opd_rms_waves").map(number) {
                close(&format!("{name}, rms of W"), rms / expected, 1.0, 0.02);
            }
            let spread = at.point_spread(chief, f64::INFINITY).expect("light");
            for (i, frequency) in numbers(&mtf["frequencies_per_mm"]).into_iter().enumerate() {
                let tolerance = if rms > 0.14 { 0.03 } else { 0.01 };
                for (key, axis) in [("tangential", DVec2::Y), ("sagittal", DVec2::X)] {
                    let expected = number(&field["optiland"][key][i]);
                    let what = format!("{name}, {degrees}°, {frequency}/mm, {key}, rms {rms:.3}");
                    close(&what, spread.mtf(axis, frequency), expected, tolerance);
                }
            }
        }
    }
}
