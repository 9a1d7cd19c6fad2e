//! Camera, film and integrator.

use glam::{DAffine3, DMat4, DVec3};

use super::difference::Difference;
use super::element::Element;
use super::output::Output;
use photosite_capture::{Capture, ExposureTime};
use photosite_core::spectrum::Spectrum;
use photosite_sensor::Use;
use photosite_transport::integrator::RenderSettings;
use photosite_transport::optics::{Camera, Falloff, LensKind, Projection};

/// Wavelength range, nm, outside of which Mitsuba's spectra of RGB colours are zero (its CIE_MIN and CIE_MAX).
const MITSUBA_RGB_NM: [f64; 2] = [360.0, 830.0];

/// Response of each channel to radiance: e⁻ per W·m⁻²·sr⁻¹·nm⁻¹ and nm of bandwidth.
pub(super) fn responses(capture: &Capture, camera: &Camera, out: &mut Output) -> Vec<(String, Spectrum)> {
    let lens = capture.lens();
    let time = match capture.exposure().time {
        ExposureTime::Fixed(time) => time.0,
        ExposureTime::Auto(_) => {
            out.approximate(Difference::AutomaticExposure);
            1.0
        }
    };
    let factor = camera.on_axis_sr() * time;
    let to_radiance = |response: Spectrum| response.product(&lens.transmittance).scale(factor);
    capture.sensor().responses().into_iter().map(|(name, response)| (name, to_radiance(response))).collect()
}

/// Whether a sensor sees light of wavelengths at which Mitsuba's RGB colours are black: more than a millionth of what
/// it sees in all.
pub(super) fn sees_beyond_cie(response: &Spectrum) -> bool {
    let [low, high] = MITSUBA_RGB_NM;
    let beyond = response.map(|lambda, value| if (low..=high).contains(&lambda) { 0.0 } else { value });
    beyond.integral() > 1e-6 * response.integral()
}

/// Integrator `path`, or `volpath` where there are holes: shadow rays of `path` take holes for opaque, and it counts
/// those that a path goes through as segments.
pub(super) fn integrator(settings: &RenderSettings, has_holes: bool) -> Element {
    Element::object("integrator", if has_holes { "volpath" } else { "path" })
        .integer("max_depth", settings.max_depth)
        .integer("rr_depth", settings.roulette_depth)
}

/// Camera with its film: one channel for every response.
pub(super) fn sensor(
    capture: &Capture,
    camera: &Camera,
    responses: &[(String, Spectrum)],
    out: &mut Output,
) -> Element {
    let lens = capture.lens();
    let [width, height] = capture.sensor().resolution;
    if capture.recording().is_some() {
        out.approximate(Difference::Motion);
    }
    if lens.falloff != Falloff::None {
        out.approximate(Difference::Falloff);
    }
    if !lens.projection.is_flat() {
        // A fisheye without distortion is one of Kannala and Brandt's model with coefficients of 0.
        let is_fisheye = matches!(lens.projection, Projection::KannalaBrandt { .. });
        let projection = if is_fisheye { "fisheye" } else { lens.projection.name() };
        out.approximate(Difference::CurvedProjection { projection });
    } else if lens.projection != Projection::Perspective {
        out.approximate(Difference::Distortion);
    }
    for (is_there, difference) in [
        (lens.point_spread.is_some(), Difference::PointSpread),
        (lens.lateral_colour.is_some(), Difference::LateralColour),
        (!lens.stops.is_empty(), Difference::Stops),
    ] {
        if is_there {
            out.approximate(difference);
        }
    }
    for [_, of, _] in capture.sensor().obstacles(Use::Mitsuba) {
        out.approximate(Difference::Sensor { of });
    }
    if lens.max_angle_rad.is_some() {
        out.approximate(Difference::MaxAngle);
    }
    let i = camera.intrinsics();
    // Half a thousandth of a pixel is seen by nobody.
    let near = |a: f64, b: f64, scale: f64| (a - b).abs() < 5e-4 / width.max(height) as f64 * scale;
    if !near(i.fx, i.fy, i.fx) || i.skew != 0.0 {
        out.approximate(Difference::PixelsNotSquare);
    }
    if !near(i.cx, width as f64 / 2.0, 1.0) || !near(i.cy, height as f64 / 2.0, 1.0) {
        out.approximate(Difference::PrincipalPoint);
    }
    let kind = match lens.kind {
        LensKind::Pinhole => Element::object("sensor", "perspective"),
        LensKind::Hole | LensKind::Bare | LensKind::Prescription => {
            out.approximate(Difference::Hole);
            Element::object("sensor", "perspective")
        }
        LensKind::Thin => {
            if lens.ground.is_some() || !lens.supplementary.is_empty() {
                out.approximate(Difference::Glass);
            }
            if lens.blades != 0 {
                out.approximate(Difference::Blades);
            }
            let focus = camera.focus_distance_m();
            if focus < 0.0 {
                out.approximate(Difference::NothingInFocus);
            }
            let radius = camera.entrance_pupil_m().unwrap_or_default() / 2.0;
            Element::object("sensor", "thinlens")
                .float("aperture_radius", radius)
                // Mitsuba has no infinity; at this distance the blur of infinity is below a hundred-thousandth of the
                // aperture seen at a metre.
                .float("focus_distance", if focus.is_finite() && focus > 0.0 { focus } else { 1e5 })
        }
    };
    let film = Element::object("film", "specfilm")
        .integer("width", width)
        .integer("height", height)
        .string("component_format", "float32")
        .child(Element::object("rfilter", "box"));
    let film = responses.iter().fold(film, |film, (name, response)| film.spectrum(name, response));
    let sampler = Element::object("sampler", "independent").integer("sample_count", capture.render().samples_per_pixel);
    // Mitsuba's cameras look along +z with x to the left.
    let to_world = camera.to_world() * DAffine3::from_scale(DVec3::new(-1.0, 1.0, -1.0));
    kind.string("fov_axis", "x")
        .float("fov", (2.0 * (width as f64 / 2.0 / i.fx).atan()).to_degrees())
        .float("near_clip", 1e-3)
        .float("far_clip", 1e6)
        .transform("to_world", rows(to_world))
        .child(sampler)
        .child(film)
}

/// Matrix of a transform as Mitsuba writes it, rows first.
pub(super) fn rows(transform: DAffine3) -> [[f64; 4]; 4] {
    DMat4::from(transform).transpose().to_cols_array_2d()
}
