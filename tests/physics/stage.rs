//! Small scenes put together in code, and their renders.

use std::ops::ControlFlow;

use glam::{DAffine3, Vec3};
use photosite::film::{FilmResponses, Response};
use photosite::geometry::QuadricKind;
use photosite::image::Estimate;
use photosite::integrator::{RenderJob, RenderSettings, render};
use photosite::optics::{Camera, LensDescription, PixelGrid};
use photosite::scene::description::{
    AlphaMode, Colour, Diffuse, EmissionDescription, EnvironmentDescription, InstanceDescription, LightDescription,
    MaterialDescription, MaterialModel, MeshDescription, SceneDescription, TexturedColour,
};
use photosite::scene::{Scene, build};
use photosite::spectrum::Spectrum;

/// A scene in the making.
#[derive(Default)]
pub(crate) struct Stage(SceneDescription);

impl Stage {
    /// Adds a mesh in world space with a diffuse material of constant reflectance and, where not zero, constant emitted
    /// radiance in W·m⁻²·sr⁻¹·nm⁻¹.
    pub(crate) fn diffuse(self, triangles: Vec<[Vec3; 3]>, reflectance: f32, radiance: f32) -> Self {
        let emission =
            EmissionDescription { colour: Colour::Spectrum(Spectrum::constant(radiance)), level: None, texture: None };
        let reflectance = TexturedColour::plain(Colour::Spectrum(Spectrum::constant(reflectance)));
        let model = MaterialModel::Diffuse(Diffuse { reflectance });
        self.mesh(triangles, model, (radiance > 0.0).then_some(emission))
    }

    /// Adds a mesh in world space with any material.
    pub(crate) fn mesh(
        mut self,
        triangles: Vec<[Vec3; 3]>,
        model: MaterialModel,
        emission: Option<EmissionDescription>,
    ) -> Self {
        let name = format!("material {}", self.0.materials.len());
        let material = MaterialDescription { emission, ..MaterialDescription::new(name, model) };
        self.0.instances.push(InstanceDescription::of_mesh("", self.0.meshes.len(), DAffine3::IDENTITY));
        let mesh = MeshDescription {
            material: self.0.materials.len(),
            positions: triangles.iter().flatten().copied().collect(),
            triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            ..Default::default()
        };
        self.0.meshes.push(mesh.into());
        self.0.materials.push(material);
        self
    }

    /// Adds a quadric of unit size, transformed, that reflects as much of all light and emits as much of it on one side
    /// or both, W·m⁻²·sr⁻¹·nm⁻¹.
    pub(crate) fn quadric(
        self,
        kind: QuadricKind,
        to_world: DAffine3,
        reflectance: f32,
        (radiance, two_sided): (f32, bool),
    ) -> Self {
        let mut stage = self.diffuse(Vec::new(), reflectance, radiance);
        let (mesh, material) = (stage.0.meshes.len() - 1, stage.0.materials.len() - 1);
        stage.0.meshes[mesh] = MeshDescription::of_quadric(kind, String::new(), material).into();
        stage.0.materials[material].double_sided = two_sided;
        stage.0.instances.last_mut().expect("that of the mesh").to_world = to_world;
        stage
    }

    /// Moves the mesh added last through transforms at evenly spaced times.
    pub(crate) fn moving(mut self, places: &[DAffine3]) -> Self {
        let instance = self.0.instances.last_mut().expect("a mesh was added");
        (instance.to_world, instance.later) = (places[0], places[1..].to_vec());
        self
    }

    /// Places the mesh added last once more.
    pub(crate) fn again(self, to_world: DAffine3) -> Self {
        let mesh = self.0.meshes.len() - 1;
        self.again_of(mesh, to_world)
    }

    /// Places a mesh once more.
    pub(crate) fn again_of(mut self, mesh: usize, to_world: DAffine3) -> Self {
        self.0.instances.push(InstanceDescription::of_mesh("", mesh, to_world));
        self
    }

    /// Says with which probability the mesh added last is there.
    pub(crate) fn alpha(mut self, mode: AlphaMode, alpha: f32) -> Self {
        let material = self.0.materials.last_mut().expect("a mesh was added");
        (material.alpha, material.alpha_factor) = (mode, alpha);
        self
    }

    /// Adds a light.
    pub(crate) fn light(mut self, light: LightDescription) -> Self {
        self.0.lights.push(light);
        self
    }

    /// Surrounds the scene with constant radiance, W·m⁻²·sr⁻¹·nm⁻¹.
    pub(crate) fn environment(self, radiance: f32) -> Self {
        self.sky(Spectrum::constant(radiance))
    }

    /// Surrounds the scene with the same spectral radiance in all directions, W·m⁻²·sr⁻¹·nm⁻¹.
    pub(crate) fn sky(self, radiance: Spectrum) -> Self {
        self.surroundings(EnvironmentDescription::Constant { colour: Colour::Spectrum(radiance), luminance_nit: None })
    }

    /// Surrounds the scene with any environment.
    pub(crate) fn surroundings(mut self, environment: EnvironmentDescription) -> Self {
        self.0.environment = Some(environment);
        self
    }

    /// Builds it for a sensor that sees all wavelengths alike.
    pub(crate) fn build(self) -> Scene {
        build(self.0, &Spectrum::constant(1.0))
    }
}

/// A square of side `2·half` about `centre`, its front towards `x.cross(y)`.
pub(crate) fn square(centre: Vec3, x: Vec3, y: Vec3, half: f32) -> Vec<[Vec3; 3]> {
    let corner = |a: f32, b: f32| centre + (x * a + y * b) * half;
    let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
    vec![[a, b, c], [a, c, d]]
}

/// A unit sphere of triangles about the origin, fronts outside, or inside for `scale` < 0.
pub(crate) fn sphere(bands: u32, scale: f32) -> Vec<[Vec3; 3]> {
    let at = |band: u32, sector: u32| {
        let theta = std::f32::consts::PI * band as f32 / bands as f32;
        let phi = std::f32::consts::TAU * (sector % (2 * bands)) as f32 / (2 * bands) as f32;
        let sin = if band == 0 || band == bands { 0.0 } else { theta.sin() };
        Vec3::new(sin * phi.cos(), theta.cos(), -sin * phi.sin()) * scale
    };
    let mut triangles = Vec::new();
    for band in 0..bands {
        for sector in 0..2 * bands {
            let (a, b) = (at(band, sector), at(band, sector + 1));
            let (c, d) = (at(band + 1, sector), at(band + 1, sector + 1));
            triangles.extend([[a, c, b], [b, c, d]].into_iter().filter(|[p, q, r]| p != q && q != r && r != p));
        }
    }
    triangles
}

/// A camera at the origin of `to_world`, without autofocus.
pub(crate) fn camera(lens: &LensDescription, grid: &PixelGrid, to_world: DAffine3) -> Camera {
    Camera::new(lens, grid, to_world, f64::NAN).expect("a valid lens")
}

/// Spectral irradiance averaged over 400–700 nm in every pixel, W·m⁻²·nm⁻¹: one plane called "E".
pub(crate) fn irradiance(scene: &Scene, camera: &Camera, resolution: [u32; 2], settings: &RenderSettings) -> Estimate {
    let band = Spectrum::from_fn(|l| if (400.0..=700.0).contains(&l) { 1.0 } else { 0.0 });
    let responses = [Response::new("E", band.scale(1.0 / band.integral()))];
    let clear = Spectrum::constant(1.0);
    let job = RenderJob {
        scene,
        camera,
        transmittance: &clear,
        responses: &responses,
        filters: None,
        importance: None,
        resolution,
        settings,
        device: None,
    };
    render(&job, FilmResponses::new(&responses), &|_| ControlFlow::Continue(())).estimate(["E"])
}

/// Mean of the first plane.
pub(crate) fn mean(estimate: &Estimate) -> f64 {
    let data = &estimate.mean.channels()[0].data;
    data.iter().map(|&v| f64::from(v)).sum::<f64>() / data.len() as f64
}
