//! Deliberate faults, one at a time, which show that the validation suite catches them. They exist in the library's own
//! unit tests only: in every other build [`flip`] is its second argument.

/// What can be made wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Light that comes straight from a light is not weighted with the cosine of incidence.
    CosineMissing,
    /// The density of a light sample leaves out with which probability that light was chosen.
    LightPdfWithoutChoice,
    /// All wavelengths of a path are given the density of the hero.
    WavelengthPdfOfHero,
    /// Rays leave from a disk of twice the aperture's radius, though its area counts as it is.
    ApertureRadiusDoubled,
}

/// `wrong` on threads that commit the fault, `right` on all others.
#[cfg(not(test))]
#[inline(always)]
pub(crate) fn flip<T>(_: Fault, right: T, _wrong: T) -> T {
    right
}

#[cfg(test)]
pub(crate) use tests::flip;

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::ops::ControlFlow;
    use std::path::Path;

    use rstest::rstest;

    use super::Fault;
    use crate::film::{FilmResponses, Response};
    use crate::integrator::{RenderJob, RenderSettings, render};
    use crate::io::capture::{Capture, ExposureTime};
    use crate::io::picture_file::read_picture_file;
    use crate::optics::{Camera, PixelGrid};
    use crate::raw::Pixels;
    use crate::scene;
    use crate::spectrum::Spectrum;
    use crate::validation::{Comparison, Picture, Settings, compare};

    thread_local! {
        static COMMITTED: Cell<Option<Fault>> = const { Cell::new(None) };
    }

    pub(crate) fn flip<T>(fault: Fault, right: T, wrong: T) -> T {
        if COMMITTED.get() == Some(fault) { wrong } else { right }
    }

    /// A scene of `tests/mitsuba`, rendered while a fault is committed, against its stored reference.
    fn against_reference(name: &str, fault: Option<Fault>) -> Comparison {
        // Threads of its own, so that the fault stays among them.
        let commit = move |_| COMMITTED.set(fault);
        let threads = rayon::ThreadPoolBuilder::new().start_handler(commit).build().expect("threads");
        threads.install(|| {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mitsuba/scenes").join(name);
            let capture = Capture::read(&folder.join("capture.toml"), &[]).expect("a capture");
            let electrons = electrons(&capture);
            let reference = read_picture_file(&folder.join("reference.exr"), Pixels::Active).expect("a reference");
            compare(&electrons, &reference, &Settings::default()).expect("pictures of one kind")
        })
    }

    /// Mean electrons of a capture, as `photosite render` finds them.
    fn electrons(capture: &Capture) -> Picture {
        let named = |(name, spectrum): (String, Spectrum)| Response::new(name, spectrum);
        let responses: Vec<Response> = capture.sensor.responses().into_iter().map(named).collect();
        let share = |r: &Response, l: f64| f64::from(r.spectrum.eval(l as f32) / r.spectrum.max());
        let importance = Spectrum::from_fn(|l| responses.iter().map(|r| share(r, l)).sum());
        let scene = scene::build(capture.scene.clone(), &importance);
        let resolution = capture.sensor.resolution.map(|n| n as u32);
        let grid = PixelGrid { resolution, pitch_m: capture.sensor.pixel_pitch_m };
        let camera = Camera::new(&capture.lens, &grid, capture.camera_to_world, f64::NAN).expect("a camera");
        // Enough that the skewness of single samples no longer shows in the tails.
        let settings = RenderSettings { samples_per_pixel: 1024, ..capture.render.clone() };
        let job = RenderJob {
            scene: &scene,
            camera: &camera,
            transmittance: &capture.lens.transmittance,
            responses: &responses,
            filters: None,
            resolution,
            settings: &settings,
        };
        let film = render(&job, FilmResponses::new(&responses), &|_| ControlFlow::Continue(()));
        let ExposureTime::Fixed(time) = capture.exposure.time else { panic!("an exposure time is given") };
        let estimate = film.estimate(responses.iter().map(|r| r.name.as_str())).scaled(time.0);
        let (name, unit) = ("ours".to_owned(), Some("e-".to_owned()));
        Picture {
            name,
            mean: estimate.mean,
            variance: estimate.variance,
            unit,
            full_scale: None,
            mosaic: None,
            active_area: None,
        }
    }

    #[rstest]
    fn without_a_fault_the_scenes_agree(#[values("lights-without-surface", "thin-lens")] scene: &str) {
        let comparison = against_reference(scene, None);
        assert!(comparison.verdict.as_ref().is_some_and(|v| v.agree), "{comparison:#?}");
    }

    #[rstest]
    #[case::cosine_missing(Fault::CosineMissing, "lights-without-surface")]
    #[case::light_pdf_without_choice(Fault::LightPdfWithoutChoice, "lights-without-surface")]
    #[case::wavelength_pdf_of_hero(Fault::WavelengthPdfOfHero, "lights-without-surface")]
    #[case::aperture_radius_doubled(Fault::ApertureRadiusDoubled, "thin-lens")]
    fn a_fault_is_caught(#[case] fault: Fault, #[case] scene: &str) {
        let verdict = against_reference(scene, Some(fault)).verdict.expect("variances are known");
        println!("{fault:?} in {scene}: {} pixels past the bound", verdict.pixels_past_bound);
        assert!(!verdict.agree, "{fault:?} passes unseen in {scene}");
    }
}
