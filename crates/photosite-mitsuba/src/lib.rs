//! Export of a capture as a scene of Mitsuba 3 (<https://mitsuba-renderer.org>), so that an independent renderer can
//! render the same image.
//!
//! In: a [`Capture`] and the [`Camera`] that it places. Out: the files of a folder, `scene.xml` first. Parts without an
//! exact counterpart in Mitsuba are refused by name, or approximated and listed.
//!
//! Mitsuba's `specfilm` gives the image of `electrons.exr` for it: mean photo-electrons in every channel. With a
//! falloff of none, E = τ·Ω·L̄, so that each channel's response to radiance is
//!
//! R(λ)·τ(λ)·Ω·t, in e⁻ per W·m⁻²·sr⁻¹·nm⁻¹ and nm,
//!
//! with R the sensor's response to irradiance (`SensorModel::responses`), the
//! transmittance τ, the projected solid angle Ω of the aperture ([`Camera::on_axis_sr`]: π·sin²θ', tan θ' = D/2v) and
//! the exposure time t.
//!
//! | here | in Mitsuba | module |
//! |---|---|---|
//! | camera, lens, sensor, settings | `perspective` or `thinlens`, `specfilm`, `path`, `volpath` | `sensor.rs` |
//! | meshes and their instances, spheres, disks, cylinders | `ply`, `shapegroup` and `instance`, `sphere`, `disk`, `cylinder` | `shape.rs` |
//! | materials | `diffuse`, `conductor`, `dielectric` and their rough kin, `blendbsdf`, `twosided`, `mask`, `normalmap` | `material.rs` |
//! | lights | `area`, `point`, `spot`, `directional`, `constant`, `envmap`, `sunsky` with a `disk` for its ground | `emitters.rs` |
//! | images | `bitmap` of an EXR file | `image.rs` |

#![forbid(unsafe_code)]

mod bitmaps;
mod difference;
mod element;
mod emitters;
mod material;
mod output;
mod sensor;
mod shape;

use photosite_core::{Help, Remedy};

use photosite_capture::Capture;
use photosite_core::Invalid;
use photosite_transport::optics::{Camera, LensKind};

use element::Element;
use material::ExportedMaterial;
use output::Output;

pub use difference::Difference;

/// Python script that renders an exported scene in Mitsuba, with the variance of every pixel.
pub const RENDER_SCRIPT: &[u8] = include_bytes!("../assets/render.py");

/// Version of Mitsuba that the files are written for.
const MITSUBA: &str = "3.0.0";

/// Files of a Mitsuba scene.
#[derive(Debug, Default)]
pub struct MitsubaScene {
    /// Names relative to the scene's folder, with `/`, and contents. `scene.xml` comes first.
    pub files: Vec<(String, Vec<u8>)>,
    /// Differences between Mitsuba's rendering of the scene and photosite's.
    pub differences: Vec<Difference>,
}

/// Describes a capture to Mitsuba. Parts without an exact counterpart are an error that names them all, unless
/// `approximate` allows the nearest counterpart.
pub fn export(capture: &Capture, camera: &Camera, approximate: bool) -> Result<MitsubaScene, Invalid> {
    if !camera.makes_image() {
        let message = "Mitsuba has no camera without a lens, all of whose pixels see a half-space";
        return Err(Invalid::new("lens.type", message).help("write type = \"thin\", \"pinhole\" or \"hole\""));
    }
    if capture.lens().kind == LensKind::Prescription {
        let message = "Mitsuba has no camera whose rays go through the glass of a lens";
        let help = "write f_number and focal_length_mm of a thin lens in its place";
        return Err(Invalid::new("lens.prescription", message).help(help));
    }
    let mut out = Output::default();
    let responses = sensor::responses(capture, camera, &mut out);
    out.sees_beyond_cie = responses.iter().any(|(_, response)| sensor::sees_beyond_cie(response));
    let integrator = sensor::integrator(capture.render(), material::has_holes(capture.scene()));
    let sensor = sensor::sensor(capture, camera, &responses, &mut out);
    let materials = material::materials(capture.scene(), &mut out);
    material::panes(capture.scene(), &mut out);
    let shapes = shape::shapes(capture.scene(), &materials, &mut out);
    let lights = emitters::lights(capture.scene(), camera.to_world().translation, &mut out);
    let scene = Element::new("scene")
        .attribute("version", MITSUBA)
        .child(integrator)
        .child(sensor)
        .with(materials.into_iter().flat_map(ExportedMaterial::into_elements))
        .with(shapes)
        .with(lights);
    if !approximate && !out.differences.is_empty() {
        let named: Vec<String> = out.differences.iter().map(Difference::to_string).collect();
        let message = format!("Mitsuba has no exact counterpart for {}", named.join("; "));
        return Err(Invalid::new("", message).help(Help::any(["change the capture".into(), Remedy::Nearest])));
    }
    out.files.insert(0, ("scene.xml".to_owned(), scene.to_xml()));
    Ok(MitsubaScene { files: out.files, differences: out.differences })
}
