//! Renders through the glass of a prescription against sums over rays of its own.

use glam::{DAffine3, DVec2};
use photosite::integrator::RenderSettings;
use photosite::optics::{Focus, LensDescription, LensKind, PixelGrid};
use photosite_lens::Lens;
use photosite_lens::files::shipped;
use photosite_lens::profile::Travel;
use photosite_lens::trace::{Apertures, Step};

use crate::stage::{Stage, camera, irradiance};

const D_NM: f64 = 587.5618;
/// Places of the band that irradiance is averaged over, nm, with Simpson's weights.
const BAND: [(f64, f64); 5] = [(400.0, 1.0), (475.0, 4.0), (550.0, 2.0), (625.0, 4.0), (700.0, 1.0)];

/// A lens that ships, with the gaps that it has.
pub(crate) fn described(name: &str, f_number: f64) -> (LensDescription, Lens) {
    let reading = shipped(name).expect("ships");
    let lens = reading.lens;
    let at = lens.at(D_NM);
    let (efl_mm, last) = (at.first_order().efl_mm, lens.surfaces().len() - 1);
    let stopped = lens.with_stop_radius(at.stop_radius_of_f_number(f_number));
    let focus = Focus::ImageDistance(lens.gap_mm(last) * 1e-3);
    let description = LensDescription {
        kind: LensKind::Prescription,
        prescription: Some(std::sync::Arc::new(reading.prescription)),
        ..LensDescription::thin(efl_mm * 1e-3, f_number, focus)
    };
    (description, stopped)
}

/// ∬ T dp dq over what passes from a sensor point at a wavelength, by the midpoint rule over the region's bounds.
fn passed(lens: &Lens, height_mm: f64, nm: f64) -> f64 {
    let at = lens.at(nm);
    let Some(region) = at.pupil_region(height_mm, 64) else { return 0.0 };
    let [low, high] = region.bounds();
    let (margin, n) = (0.02 * (high - low), 96);
    let (low, high) = (low - margin, high + margin);
    let cell = (high - low).element_product() / f64::from(n * n);
    let through = |i: i32| {
        let place = DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n);
        let ray = at.ray_from_sensor(DVec2::new(0.0, height_mm), low + (high - low) * place);
        let (mut passed, steps) = (1.0, (0..lens.surfaces().len()).rev().map(Step::refract));
        let whole = at
            .trace(ray, Travel::ToScene, steps, Apertures::Clip, |hit| passed *= at.split_at(hit).mean_transmittance());
        if whole.is_ok() { passed * cell } else { 0.0 }
    };
    (0..n * n).map(through).sum()
}

/// A row of pixels from the axis to the corner, wide enough to be few, and so flat that each has one image height.
#[test]
fn uniform_light_gives_the_projected_solid_angle_at_three_stops() {
    let radiance = 2.0;
    let scene = Stage::default().environment(radiance).build();
    let (columns, pitch_m) = (24_u32, 1.5e-3);
    for (name, f_number) in [("double-gauss", 2.1), ("double-gauss", 4.0), ("canon-ef50", 16.0)] {
        let (description, lens) = described(name, f_number);
        let grid = PixelGrid { resolution: [columns, 1], pitch_m: [pitch_m, 1e-5] };
        let settings = RenderSettings { samples_per_pixel: 1 << 14, ..Default::default() };
        let estimate = irradiance(&scene, &camera(&description, &grid, DAffine3::IDENTITY), grid.resolution, &settings);
        for column in 0..columns as usize / 2 {
            let height_mm = (column as f64 + 0.5 - f64::from(columns) / 2.0).abs() * pitch_m * 1e3;
            let of = |planes: &photosite::image::Planes| f64::from(planes.channels()[0].data[column]);
            let (found, sigma) = (of(&estimate.mean), of(&estimate.variance).sqrt());
            // Simpson's rule over the spectrum and over the pixel.
            let of_height = |height: f64| -> f64 {
                BAND.iter().map(|(nm, weight)| weight * passed(&lens, height, *nm)).sum::<f64>() / 12.0
            };
            let half = 0.5 * pitch_m * 1e3;
            let [near, middle, far] = [height_mm - half, height_mm, height_mm + half].map(of_height);
            let expected = f64::from(radiance) * (near + 4.0 * middle + far) / 6.0;
            let bound = 4.0 * sigma + 2e-3 * expected;
            assert!(
                (found - expected).abs() < bound,
                "{name} f/{f_number}, {height_mm} mm: {found} {expected} ± {bound}"
            );
        }
    }
}
