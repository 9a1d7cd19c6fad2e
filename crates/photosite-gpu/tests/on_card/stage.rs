//! Things that scenes of tests are made of: materials, shapes, and the stage that they are put on.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use photosite_core::spectrum::{Dispersion, Spectrum, library};
use photosite_transport::bsdf::CubeCorners;
use photosite_transport::geometry::QuadricKind;
use photosite_transport::scene::description::{
    Colour, Conductor, Dielectric, Diffuse, EmissionDescription, EnvironmentDescription, InstanceDescription,
    LayeredDescription, LightDescription, LightKind, MaterialDescription, MaterialModel, MeshDescription,
    Retroreflective, Roughness, SceneDescription, TexturedColour, TexturedFactor,
};
use photosite_transport::scene::{Scene, build};
use photosite_transport::texture::{Bitmap, Texels};

/// A scene that grows.
#[derive(Default)]
pub(crate) struct Stage(pub(crate) SceneDescription);

pub(crate) fn grey(value: f32) -> TexturedColour {
    TexturedColour::plain(Colour::Rgb([value; 3]))
}

pub(crate) fn diffuse(rgb: [f32; 3]) -> MaterialModel {
    MaterialModel::Diffuse(Diffuse { reflectance: TexturedColour::plain(Colour::Rgb(rgb)) })
}

pub(crate) fn metal(name: &str, roughness: f32) -> MaterialModel {
    let metal = library::conductor(name).expect("a metal");
    let distribution = Roughness::isotropic(roughness);
    MaterialModel::Conductor(Conductor { eta: metal.eta, k: metal.k, distribution, energy_compensation: false })
}

pub(crate) fn glass(index: Dispersion, roughness: f32) -> MaterialModel {
    let distribution = Roughness::isotropic(roughness);
    MaterialModel::Dielectric(Dielectric { index, distribution, energy_compensation: false })
}

pub(crate) fn light(level: f64) -> EmissionDescription {
    EmissionDescription { colour: Colour::Rgb([1.0, 0.8, 0.6]), level: Some(level), texture: None }
}

/// The same material with the light that bounces more than once between facets.
pub(crate) fn with_all_bounces(mut model: MaterialModel) -> MaterialModel {
    if let MaterialModel::Conductor(metal) = &mut model {
        metal.energy_compensation = true;
    }
    if let MaterialModel::Dielectric(glass) = &mut model {
        glass.energy_compensation = true;
    }
    model
}

/// Sheeting of a road sign.
pub(crate) fn sheeting() -> MaterialModel {
    MaterialModel::Retroreflective(Retroreflective {
        retroreflectance: grey(0.6),
        reflectance: grey(0.3),
        corners: CubeCorners::new(1.5),
        distribution: Roughness::isotropic(0.2),
    })
}

/// A square about a centre, its front towards x × y.
pub(crate) fn square(centre: Vec3, x: Vec3, y: Vec3) -> MeshDescription {
    MeshDescription {
        positions: vec![centre - x - y, centre + x - y, centre + x + y, centre - x + y],
        uvs: vec![[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(Vec2::from).to_vec()],
        tangents: vec![x.normalize().extend(-1.0); 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshDescription::default()
    }
}

/// A bumpy sphere of radius 1 about the origin, with shading normals of the sphere where `is_smooth`.
pub(crate) fn ball(bands: u32, bumps: f32, is_smooth: bool) -> MeshDescription {
    let sectors = 2 * bands;
    let at = |band: u32, sector: u32| {
        let (theta, phi) = (PI * band as f32 / bands as f32, TAU * sector as f32 / sectors as f32);
        Vec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin())
    };
    let grid = (0..=bands).flat_map(|band| (0..=sectors).map(move |sector| (band, sector)));
    let directions: Vec<Vec3> = grid.map(|(band, sector)| at(band, sector % sectors)).collect();
    let bumpy = |d: &Vec3| *d * (1.0 + bumps * (9.0 * d.x).sin() * (9.0 * d.y).sin() * (9.0 * d.z).sin());
    let index = |band: u32, sector: u32| band * (sectors + 1) + sector;
    let mut triangles = Vec::new();
    for (band, sector) in (0..bands).flat_map(|band| (0..sectors).map(move |sector| (band, sector))) {
        let [a, b] = [index(band, sector), index(band, sector + 1)];
        let [c, d] = [index(band + 1, sector), index(band + 1, sector + 1)];
        if band > 0 {
            triangles.push([a, c, b]);
        }
        if band + 1 < bands {
            triangles.push([b, c, d]);
        }
    }
    let normals = if is_smooth { directions.clone() } else { Vec::new() };
    MeshDescription { positions: directions.iter().map(bumpy).collect(), normals, triangles, ..Default::default() }
}

/// glTF's material of these layers.
pub(crate) fn of_layers(layers: LayeredDescription) -> MaterialModel {
    MaterialModel::Layered(Box::new(layers))
}

/// glTF's material of these colour, metalness and roughness, with a specular colour of its own.
pub(crate) fn layered(
    base_colour: TexturedColour,
    metallic: TexturedFactor,
    roughness: TexturedFactor,
) -> MaterialModel {
    let specular_colour = TexturedColour::plain(Colour::Rgb([0.9, 1.4, 0.7]));
    let specular = TexturedFactor::plain(0.8);
    let layers =
        LayeredDescription { base_colour, metallic, roughness, specular, specular_colour, ..Default::default() };
    of_layers(layers)
}

impl Stage {
    /// Adds a mesh with a material of its own, once at each place.
    pub(crate) fn add(mut self, name: &str, model: MaterialModel, mesh: MeshDescription, places: &[DAffine3]) -> Self {
        let emission = None;
        self.add_material(MaterialDescription { emission, ..MaterialDescription::new(name, model) }, mesh, places);
        self
    }

    /// Adds a mesh that shines.
    pub(crate) fn shine(
        mut self,
        name: &str,
        emission: EmissionDescription,
        is_double: bool,
        mesh: MeshDescription,
        place: DAffine3,
    ) -> Self {
        let material = MaterialDescription {
            emission: Some(emission),
            double_sided: is_double,
            ..MaterialDescription::new(name, diffuse([0.3; 3]))
        };
        self.add_material(material, mesh, &[place]);
        self
    }

    fn add_material(&mut self, material: MaterialDescription, mesh: MeshDescription, places: &[DAffine3]) {
        let scene = &mut self.0;
        let (name, index) = (material.name.clone(), scene.materials.len());
        scene.materials.push(material);
        let number = scene.meshes.len();
        scene.meshes.push(MeshDescription { name: name.clone(), material: index, ..mesh }.into());
        scene.instances.extend(places.iter().map(|place| InstanceDescription::of_mesh(name.clone(), number, *place)));
    }

    /// Adds a light without a surface.
    pub(crate) fn lamp(mut self, kind: LightKind, to_world: DAffine3, level: f64) -> Self {
        let name = format!("lamp {}", self.0.lights.len());
        self.0.lights.push(LightDescription { name, to_world, later: vec![], kind, emission: light(level) });
        self
    }

    /// Lets the instance that was added last go on to further poses.
    pub(crate) fn then(mut self, later: &[DAffine3]) -> Self {
        self.0.instances.last_mut().expect("an instance").later = later.to_vec();
        self
    }

    /// Lets the light that was added last go on to further poses.
    pub(crate) fn lamp_then(mut self, later: &[DAffine3]) -> Self {
        self.0.lights.last_mut().expect("a light").later = later.to_vec();
        self
    }

    pub(crate) fn environment(mut self, environment: EnvironmentDescription) -> Self {
        self.0.environment = Some(environment);
        self
    }

    pub(crate) fn build(self) -> Scene {
        build(self.0, &Spectrum::constant(1.0))
    }
}

pub(crate) fn quadric(kind: QuadricKind) -> MeshDescription {
    MeshDescription::of_quadric(kind, String::new(), 0)
}

pub(crate) fn placed(place: [f64; 3], scale: f64) -> DAffine3 {
    let turn = DQuat::from_rotation_y(0.4 + place[0]) * DQuat::from_rotation_x(0.3);
    DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, DVec3::from(place))
}

pub(crate) fn bitmap(width: usize, height: usize, texels: Texels) -> Arc<Bitmap> {
    Arc::new(Bitmap { name: "pattern".into(), width, height, texels })
}
