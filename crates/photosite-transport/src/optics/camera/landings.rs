//! Rays through the glass of a prescription for many samples at a time, and where the light of each wavelength lands.
//!
//! Rays of four wavelengths that leave one point of the sensor part company in the glass. A path would carry its hero
//! alone, at the cost of much noise of colour. But the ray of the hero out in the scene is a ray of all four: the other
//! three go along it back **in**, and each lands at a point x_j of its own, where it adds its light. Since a lens keeps
//! étendue at each wavelength, no Jacobian appears.
//!
//! A ray of the scene may so be found from four points of the sensor, one for each wavelength as hero. Over these the
//! balance heuristic ([Wilkie14](photosite_core::references#wilkie14)) makes the light L of wavelength j count
//!
//! E_j = w_j·T_j·L,   w_j = 4 / Σ_k v_kj/|R(x_k)|
//!
//! with the area |R(x)| of the region that directions are drawn from at x, the transmittance T_j of the glass, and v_kj = 1
//! where wavelength k passes from a point of which a path may start and which is near enough to x_j, else 0. Inside the
//! image that is |R|, as if the lens did not disperse.
//!
//! Where something moves, the ray belongs to the time t at which its path starts. Rows of a rolling shutter see light at
//! times of their own, each as long as any other: v_kj is 0, too, where the row of x_k is not exposed at t.
//!
//! Where points are spread as waves are, the ray out in the scene goes through a point of the plane of focus, whose chief ray
//! lands at a place for each wavelength, and an offset is drawn for each about it, by the same numbers. The density of a ray
//! and these numbers is the same for all heroes but for |R|, so that the weights are those above.

use glam::DVec2;

use super::Camera;
use super::ray::{CameraRay, CameraSample};
use crate::optics::prescribed::{PrescribedLens, Start};
use photosite_core::spectrum::{LANES, SampledSpectrum, Wavelengths};
use photosite_lens::lanes::LaneRay;

/// Pixel in which the light of a wavelength lands, and its weight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Landing {
    /// Column and row of the pixel.
    pub cell: [u32; 2],
    /// Weight of the light in that pixel, without the lens's transmittance; 0 where it does not land in the image.
    pub weight: f32,
}

/// A ray into the scene that serves four wavelengths.
#[derive(Clone, Copy, Debug)]
pub struct LandingRay {
    /// Ray and weight for a path that goes on with the hero alone, which lands in the pixel that it came from.
    pub of_hero: CameraRay,
    /// Landings of the wavelengths, for a path that carries all of them: E = weight · L, sr.
    pub landings: [Landing; LANES],
}

/// Buffers for rays through a lens.
#[derive(Debug, Default)]
pub struct LensRays {
    /// The hero of each sample, and the area of the region that its direction was drawn from.
    out: Vec<LaneRay>,
    areas: Vec<f32>,
    /// Sensor points [`Start::image`] of the rays.
    images: Vec<DVec2>,
    /// The other wavelengths of each sample, or all of each way in.
    pub(super) back: Vec<LaneRay>,
}

/// A ray that is none.
pub(super) const BLOCKED: LaneRay =
    LaneRay { point: glam::Vec3::ZERO, direction: glam::Vec3::Z, wavelength_nm: 550.0, passed: 0.0 };

impl Camera {
    /// Whether [`land_each`](Self::land_each) serves this camera: it has the lens of a prescription, and its pixels are
    /// rectangles of an image.
    pub fn lands_wavelengths(&self) -> bool {
        self.prescribed.is_some() && !self.scans && !self.cells.is_staggered()
    }

    /// The rays of samples at their hero's wavelength.
    pub(super) fn prescribed_each(
        &self,
        lens: &PrescribedLens,
        samples: &[CameraSample],
        wavelengths: &mut [Wavelengths],
        mut take: impl FnMut(usize, &Wavelengths, Option<(CameraRay, SampledSpectrum)>),
    ) {
        wavelengths.iter_mut().for_each(Wavelengths::terminate_secondary);
        let mut rays = LensRays::default();
        self.trace_heroes(lens, samples, wavelengths, &mut rays);
        for (i, (sample, wavelengths)) in samples.iter().zip(wavelengths).enumerate() {
            let LensRays { out, areas, images, .. } = &mut rays;
            lens.aim(&mut out[i], images[i]);
            let ray = self.prescribed_camera_ray(lens, sample, &out[i], areas[i]);
            take(i, wavelengths, ray.map(|ray| (ray, SampledSpectrum::ONE)));
        }
    }

    fn trace_heroes(
        &self,
        lens: &PrescribedLens,
        samples: &[CameraSample],
        wavelengths: &[Wavelengths],
        rays: &mut LensRays,
    ) {
        let LensRays { out, areas, images, .. } = rays;
        out.clear();
        areas.clear();
        images.clear();
        for (sample, wavelengths) in samples.iter().zip(wavelengths) {
            let start = self.prescribed_start(lens, sample, wavelengths.lambda_nm(0));
            let Start { ray, area, image } = start.unwrap_or(Start { ray: BLOCKED, area: 0.0, image: DVec2::ZERO });
            out.push(ray);
            areas.push(area);
            images.push(image);
        }
        lens.trace_out(out);
    }

    /// Makes the rays of several samples, and gives `take` the index of each with its ray, or `None` where the hero is
    /// blocked. `starts` says of the index of a sample, a column and a row whether a path of that sample's number starts in
    /// that pixel of the image; `reach` is how many rows apart light may land from where its path came from.
    pub fn land_each(
        &self,
        samples: &[CameraSample],
        wavelengths: &[Wavelengths],
        rays: &mut LensRays,
        reach: u32,
        starts: impl Fn(usize, [u32; 2]) -> bool,
        mut take: impl FnMut(usize, Option<LandingRay>),
    ) {
        let Some(lens) = &self.prescribed else { return };
        // The heroes go out
        self.trace_heroes(lens, samples, wavelengths, rays);
        let LensRays { out, areas, images, back } = rays;

        // The other wavelengths come back in along the same rays
        back.clear();
        for (hero, wavelengths) in out.iter().zip(wavelengths) {
            for lane in 1..LANES {
                let ray = hero.back(wavelengths.lambda_nm(lane));
                back.push(if hero.passed > 0.0 { ray } else { BLOCKED });
            }
        }
        lens.trace_in(back);

        for (i, sample) in samples.iter().enumerate() {
            // Those of the glass tell what passes
            lens.aim(&mut out[i], images[i]);
            let Some(of_hero) = self.prescribed_camera_ray(lens, sample, &out[i], areas[i]) else {
                take(i, None);
                continue;
            };
            // Where something moves, the ray is there at the time of its path
            let of_time = self.recording.as_ref().map(|recording| {
                let row = self.cells.cell_at(sample.pixel).y;
                (recording, recording.time_s(row, sample.time))
            });
            let is_exposed = |[_, row]: [u32; 2]| {
                of_time.is_none_or(|(recording, time_s)| recording.is_exposed(f64::from(row), time_s))
            };

            // Where each has landed, the density there of paths that start along this ray, and its transmittance
            let mut cells = [[0; 2]; LANES];
            let mut densities = [0.0; LANES];
            let mut passed = [0.0; LANES];
            for lane in 0..LANES {
                let (pixel, area) = if lane == 0 {
                    passed[lane] = out[i].passed;
                    (sample.pixel, areas[i])
                } else {
                    let ray = &back[i * (LANES - 1) + lane - 1];
                    passed[lane] = ray.passed;
                    if ray.passed <= 0.0 {
                        continue;
                    }
                    let outside = (out[i].point, out[i].direction);
                    let Some(landed) = lens.landing(ray, outside, sample.spread) else { continue };
                    (self.pixel_of(landed), lens.area(landed))
                };
                if area <= 0.0 {
                    continue;
                }
                let Some(cell) = self.lit_cell(pixel) else { continue };
                if starts(i, cell) && (lane == 0 || is_exposed(cell)) {
                    cells[lane] = cell;
                    densities[lane] = 1.0 / area;
                }
            }

            // The balance heuristic over the wavelengths as heroes
            let mut landings = [Landing::default(); LANES];
            for lane in 0..LANES {
                if densities[lane] <= 0.0 {
                    continue;
                }
                let mut sum = 0.0;
                for other in 0..LANES {
                    if cells[other][1].abs_diff(cells[lane][1]) <= reach {
                        sum += densities[other];
                    }
                }
                landings[lane] = Landing { cell: cells[lane], weight: LANES as f32 * passed[lane] / sum };
            }
            take(i, Some(LandingRay { of_hero, landings }));
        }
    }

    /// The cell of the image in which a place lies, if it sees light.
    #[inline]
    pub(super) fn lit_cell(&self, pixel: DVec2) -> Option<[u32; 2]> {
        let [columns, rows] = self.resolution.map(f64::from);
        let cell = self.cells.cell_at(pixel);
        let is_in_image = cell.x >= 0.0 && cell.y >= 0.0 && cell.x < columns && cell.y < rows;
        (is_in_image && self.cells.sees_light(pixel)).then_some([cell.x as u32, cell.y as u32])
    }
}
