//! Places of a colour checker in an image, and the colours that its patches must have: both follow from the capture.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::capture_camera::pixels;
use super::focusing::place_camera;
use super::lens_corrections::LensSeen;
use photosite_capture::Capture;
use photosite_core::colour::ColourSpace;
use photosite_core::colour::adaptation::bradford;
use photosite_core::image::Planes;
use photosite_core::spectrum::{Spectrum, cie, library};
use photosite_core::{Invalid, Result, Sandbox};
use photosite_develop::Resampling;
use photosite_measure::measures::{CheckerReport, checker};
use photosite_sensor::RegionOfInterest;
use photosite_transport::optics::Camera;
use photosite_transport::scene::description::{Colour, Diffuse, MaterialDescription, MaterialModel};
use photosite_transport::scene::{self, Scene};

/// Pixels that a patch's edge is kept away from, since neighbours mix there.
const MARGIN: usize = 3;

/// Measures the colours of a colour checker in an image: linear sRGB, of the file `image_path`. The capture at `path`
/// says which of its pixels show which patch, and what the patches' colours are in the light of its scene; what it
/// names must lie in the sandbox.
///
/// # Errors
///
/// A capture that cannot be read, that shows no patch, or that has images of another size.
pub fn measure_checker(image: &Planes, image_path: &Path, path: &Path, sandbox: &Sandbox) -> Result<CheckerReport> {
    let mut capture = Capture::load_within(sandbox, path, &[])?;
    let size = [image.width(), image.height()];
    let description = Arc::unwrap_or_clone(capture.take_scene());
    let (names, spectra): (Vec<&str>, Vec<Spectrum>) = library::colour_checker().unzip();
    let patch_of_material: Vec<Option<usize>> =
        description.materials.iter().map(|material| patch_of(material, &spectra)).collect();
    let scene = scene::build(description, &Spectrum::constant(1.0));
    let camera = place_camera(&capture, || &scene)?;
    let grid = Grid::of_image(&capture, &camera, size).map_err(|invalid| invalid.in_file(image_path))?;
    let seen = shown_patches(&grid, &camera, &scene, &patch_of_material);
    if seen.iter().all(Option::is_none) {
        let help = "the chart's materials must have reflectances \"colour-checker/01-dark-skin\" and so on";
        let message = "its camera sees no patch of a colour checker";
        return Err(capture.source().error(Invalid::new("materials", message).help(help)));
    }
    let light = scene.light_spectrum();
    let white = DVec3::from_array(cie::xyz(light));
    let adaptation = bradford(white / white.y, ColourSpace::Srgb.white());
    let colour = |spectrum: &Spectrum| adaptation * (DVec3::from_array(cie::xyz(&light.product(spectrum))) / white.y);
    let patches: Vec<(String, DVec3)> =
        names.iter().zip(&spectra).map(|(name, spectrum)| ((*name).to_owned(), colour(spectrum))).collect();
    checker(image, &seen, &patches).map_err(|invalid| invalid.in_file(image_path))
}

/// The patch whose reflectance a material has.
fn patch_of(material: &MaterialDescription, spectra: &[Spectrum]) -> Option<usize> {
    if let MaterialModel::Diffuse(Diffuse { reflectance }) = &material.model
        && let (Colour::Spectrum(spectrum), None) = (&reflectance.colour, &reflectance.texture)
    {
        return spectra.iter().position(|patch| patch == spectrum);
    }
    None
}

/// Grid of an image on the sensor: the places that its pixels show.
struct Grid {
    size: [usize; 2],
    /// Resampling of a developed image; `None` for the pixels of the sensor itself.
    resampling: Option<Resampling>,
}

impl Grid {
    /// Grid of an image of `size` pixels: that of the developed image, or else that of the sensor.
    fn of_image(capture: &Capture, camera: &Camera, size: [usize; 2]) -> Result<Self, Invalid> {
        let sensor = pixels(capture).map(|n| n as usize);
        let seen = LensSeen::new(
            capture.lens(),
            camera,
            capture.sensor(),
            &RegionOfInterest::WHOLE,
            capture.exposure().stages,
        );
        let resampling = seen.resampling(capture.develop());
        let developed = resampling.as_ref().map_or(sensor, Resampling::size_px);
        if size == developed || size == sensor {
            return Ok(Self { size, resampling: resampling.filter(|_| size == developed) });
        }
        let [[width, height], [columns, rows]] = [size, developed];
        let message = format!("the image has {width} × {height} pixels, the capture {columns} × {rows}");
        Err(Invalid::new("", message).help("give the capture that the image was rendered from"))
    }

    /// The place that the centre of a pixel shows.
    fn source(&self, camera: &Camera, pixel: [usize; 2]) -> Option<DVec2> {
        match &self.resampling {
            None => Some(camera.cells().centre(pixel)),
            Some(resampling) => resampling.source_px(DVec2::from_array(pixel.map(|n| n as f64)) + 0.5),
        }
    }
}

/// Finds for every pixel the patch that it shows, with all of its surroundings.
fn shown_patches(
    grid: &Grid,
    camera: &Camera,
    scene: &Scene,
    patch_of_material: &[Option<usize>],
) -> Vec<Option<usize>> {
    let [width, height] = grid.size;
    let patch = |i: usize| {
        let place = grid.source(camera, [i % width, i / width])?;
        let hit = scene.closest(&camera.chief_ray(place)?)?;
        patch_of_material.get(scene.point(&hit, 0.0).material as usize).copied().flatten()
    };
    let shown: Vec<Option<usize>> = (0..width * height).map(patch).collect();
    let whole = |i: usize| {
        let (x, y) = (i % width, i / width);
        let inside =
            (MARGIN..width.saturating_sub(MARGIN)).contains(&x) && (MARGIN..height.saturating_sub(MARGIN)).contains(&y);
        let same =
            || (y - MARGIN..=y + MARGIN).all(|y| (x - MARGIN..=x + MARGIN).all(|x| shown[y * width + x] == shown[i]));
        shown[i].filter(|_| inside && same())
    };
    (0..width * height).map(whole).collect()
}
