//! The scenes that the benches work on.

use std::f32::consts::{PI, TAU};
use std::path::Path;

use glam::{DAffine3, Vec3};
use photosite::io::{MissingNormals, obj};
use photosite::scene::description::{
    Colour, Diffuse, EmissionDescription, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription,
    SceneDescription, TexturedColour,
};
use photosite::spectrum::{Spectrum, library};

/// A bumpy sphere of about 1 m radius around the origin, flat shaded: 2·`sectors`·(`bands` − 1) triangles of shared
/// corners, far more than fit into the caches.
pub(crate) fn sphere(bands: u32, sectors: u32) -> SceneDescription {
    let corner = |band: u32, sector: u32| match band {
        0 => 0,
        _ if band == bands => (bands - 1) * sectors + 1,
        _ => (band - 1) * sectors + sector % sectors + 1,
    };
    let position = |band: u32, sector: u32| {
        let (theta, phi) = (PI * band as f32 / bands as f32, TAU * sector as f32 / sectors as f32);
        let direction = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
        let Vec3 { x, y, z } = direction * 40.0;
        direction * (1.0 + 0.03 * x.sin() * y.sin() * z.sin())
    };
    let mut positions = vec![position(0, 0)];
    positions.extend((1..bands).flat_map(|band| (0..sectors).map(move |sector| position(band, sector))));
    positions.push(position(bands, 0));
    let mut triangles = Vec::with_capacity((2 * sectors * (bands - 1)) as usize);
    for band in 0..bands {
        for sector in 0..sectors {
            let (a, b) = (corner(band, sector), corner(band, sector + 1));
            let (c, d) = (corner(band + 1, sector), corner(band + 1, sector + 1));
            triangles.extend([[a, b, c], [b, d, c]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
        }
    }
    of_one_mesh([0.7, 0.5, 0.3], MeshDescription { positions, triangles, ..MeshDescription::default() })
}

/// A mesh alone, diffuse in a linear sRGB colour.
pub(crate) fn of_one_mesh(rgb: [f32; 3], mesh: MeshDescription) -> SceneDescription {
    SceneDescription {
        materials: vec![diffuse("all", Colour::Rgb(rgb))],
        meshes: vec![mesh.into()],
        instances: vec![InstanceDescription::of_mesh("", 0, DAffine3::IDENTITY)],
        ..SceneDescription::default()
    }
}

/// Bands and sectors of the large sphere: 1.31 million triangles.
pub(crate) const LARGE_SPHERE: (u32, u32) = (640, 1025);

/// The Cornell box of `scenes/`, in millimetres, with its measured spectra.
pub(crate) fn cornell_box() -> SceneDescription {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/cornell-box.obj");
    let mut scene = obj::read(&path, MissingNormals::Flat, &photosite::Sandbox::default())
        .expect("the scene is part of the repository")
        .scene;
    let measured = |name: &str| library::spectrum(name).expect("the spectrum is part of the repository");
    for material in &mut scene.materials {
        let is_lamp = material.name == "lamp";
        let colour = if is_lamp { "cornell/white".to_owned() } else { format!("cornell/{}", material.name) };
        *material = diffuse(&material.name, Colour::Spectrum(measured(&colour)));
        material.emission = is_lamp.then(|| EmissionDescription {
            colour: Colour::Spectrum(measured("cornell/light")),
            level: Some(10_000.0),
            texture: None,
        });
    }
    scene
}

/// Equal interest in all visible light.
pub(crate) fn visible() -> Spectrum {
    Spectrum::from_fn(|lambda| f64::from(u8::from((400.0..=700.0).contains(&lambda))))
}

pub(crate) fn diffuse(name: &str, reflectance: Colour) -> MaterialDescription {
    let reflectance = TexturedColour::plain(reflectance);
    MaterialDescription::new(name, MaterialModel::Diffuse(Diffuse { reflectance }))
}
