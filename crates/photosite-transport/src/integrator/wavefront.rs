//! A wavefront of paths: their rays are traced together, then every path advances at its surface, then their shadow
//! rays are traced. While the memory brings what one ray needs, others go on, and each part of the code runs for all
//! paths before the next one does. Paths that have come to diffuse surfaces advance eight at a time.

use std::ops::ControlFlow;

use super::mis_ratio::MisRatio;
use super::path::{Contribution, DiffuseBatch, Path, PathLimits, Queues, Tracing};
use super::path_tracer::Paths;
use crate::geometry::{Geometry, Hit, Ray};
use crate::sampler::{SamplePosition, Sampler};
use crate::scene::Scene;
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};

/// Estimate of the radiance that arrives against the ray's unit direction, W·m⁻²·sr⁻¹·nm⁻¹ at each wavelength, by one
/// path and its branches, with the random numbers from the sampler's position on; its position afterwards is
/// unspecified. A refraction that disperses leaves only the hero of `wavelengths`.
pub fn radiance(
    scene: &Scene,
    ray: Ray,
    wavelengths: &mut Wavelengths,
    sampler: &mut Sampler,
    limits: PathLimits,
) -> SampledSpectrum {
    let mut wavefront = Wavefront::new(limits, MisRatio::NONE);
    wavefront.start(ray, *wavelengths, sampler.position());
    let _ = wavefront.trace(scene, sampler);
    let (light, remaining) = wavefront.arrived(0);
    *wavelengths = *remaining;
    light
}

/// Paths that are traced together; see the module.
pub(super) struct Wavefront {
    limits: PathLimits,
    /// MIS ratio of each path at its start.
    mis_ratio: MisRatio,
    /// The paths that were started, and then the branches of those that have split.
    paths: Vec<Path>,
    /// Sums over the branches of each path that was started.
    branched: Vec<SampledSpectrum>,
    active: ActivePaths,
    /// The paths that are active next.
    next: ActivePaths,
    hits: Vec<Option<Hit>>,
    diffuse: DiffuseBatch,
    queues: Queues,
    occluded: Vec<bool>,
    /// Rays that were traced to surfaces and to lights.
    rays: [u64; 2],
}

/// The paths that go on: their indices and rays.
#[derive(Default)]
struct ActivePaths {
    indices: Vec<u32>,
    rays: Vec<Ray>,
}

impl ActivePaths {
    fn clear(&mut self) {
        self.indices.clear();
        self.rays.clear();
    }

    #[inline]
    fn push(&mut self, index: u32, ray: Ray) {
        self.indices.push(index);
        self.rays.push(ray);
    }
}

/// Prefetches the corners of triangles that are needed soon, and before that the triangles.
#[inline]
fn prefetch_corners(geometry: &Geometry, hits: &[Option<Hit>]) {
    const DISTANCE: usize = 4;
    if let Some(Some(hit)) = hits.get(2 * DISTANCE) {
        geometry.prefetch_primitive(hit.primitive);
    }
    if let Some(Some(hit)) = hits.get(DISTANCE) {
        geometry.prefetch_corners(hit.primitive);
    }
}

impl Wavefront {
    /// An empty wavefront.
    pub(super) fn new(limits: PathLimits, mis_ratio: MisRatio) -> Self {
        assert!(limits.splitting > 0, "a path goes on as at least one");
        Self {
            limits,
            mis_ratio,
            paths: Vec::new(),
            branched: Vec::new(),
            active: ActivePaths::default(),
            next: ActivePaths::default(),
            hits: Vec::new(),
            diffuse: DiffuseBatch::new(),
            queues: Queues::default(),
            occluded: Vec::new(),
            rays: [0; 2],
        }
    }

    /// Advances all active paths from one surface to the next.
    fn advance(&mut self, scene: &Scene, sampler: &mut Sampler) {
        let Self { limits, paths, active, next, hits, diffuse, queues, .. } = self;
        // Intersect the rays of all paths
        self.rays[0] += active.rays.len() as u64;
        scene.closest_each(&active.rays, hits);

        // Advance each path at its surface, those on diffuse surfaces in batches
        let mut tracing = Tracing { scene, limits, sampler, queues };
        let prefetches = scene.geometry().exceeds_caches();
        for (i, ((&index, ray), hit)) in active.indices.iter().zip(&active.rays).zip(&*hits).enumerate() {
            if prefetches {
                prefetch_corners(scene.geometry(), &hits[i..]);
            }
            let path = &mut paths[index as usize];
            if diffuse.push(index, path, ray, hit.as_ref(), &tracing) {
                if diffuse.is_full() {
                    diffuse.advance(paths, &mut tracing, |index, ray| next.push(index, ray));
                }
            } else if let Some(ray) = path.advance(index, ray, *hit, &mut tracing) {
                next.push(index, ray);
            }
        }
        diffuse.advance(paths, &mut tracing, |index, ray| next.push(index, ray));

        // Add the branches of paths that have split
        for (path, ray) in queues.branches.drain(..) {
            next.push(paths.len() as u32, ray);
            paths.push(path);
        }
        active.clear();
        std::mem::swap(active, next);

        // Trace the shadow rays
        self.trace_shadow_rays(scene);
    }

    /// Adds the contributions of the shadow rays that are not occluded to their paths.
    fn trace_shadow_rays(&mut self, scene: &Scene) {
        let Self { paths, queues: Queues { shadow_rays, contributions, .. }, occluded, .. } = self;
        self.rays[1] += shadow_rays.len() as u64;
        scene.occluded_each(shadow_rays, occluded);
        for ((Contribution { path, light, is_delta, medium }, ray), occluded) in
            contributions.drain(..).zip(&*shadow_rays).zip(&*occluded)
        {
            let path = &mut paths[path as usize];
            if !occluded && medium.is_none() {
                path.light += light;
            } else if is_delta && scene.has_panes() {
                path.light += light * scene.through_panes(ray, medium, &path.wavelengths);
            }
        }
        shadow_rays.clear();
    }
}

impl Paths for Wavefront {
    #[inline]
    fn start(&mut self, ray: Ray, wavelengths: Wavelengths, position: SamplePosition) {
        self.active.push(self.paths.len() as u32, ray);
        self.paths.push(Path::new(wavelengths, position, self.mis_ratio));
    }

    fn len(&self) -> usize {
        self.paths.len()
    }

    fn trace(&mut self, scene: &Scene, sampler: &mut Sampler) -> ControlFlow<()> {
        let started_count = self.paths.len();
        if self.limits.max_depth == 0 {
            self.active.clear();
        }
        // Advance from surface to surface until no path goes on
        while !self.active.indices.is_empty() {
            self.advance(scene, sampler);
        }

        // Sum the light of the branches of each path
        self.branched.clear();
        self.branched.resize(started_count, SampledSpectrum::ZERO);
        let (started, branches) = self.paths.split_at(started_count);
        for branch in branches {
            let Some(origin) = branch.origin.map(|index| index as usize) else { continue };
            self.branched[origin] += branch.arrived_at(&started[origin]);
        }
        ControlFlow::Continue(())
    }

    #[inline]
    fn arrived(&self, index: usize) -> (SampledSpectrum, &Wavelengths) {
        let Path { light, wavelengths, .. } = &self.paths[index];
        (*light + self.branched[index] * (1.0 / self.limits.splitting as f32), wavelengths)
    }

    fn clear(&mut self) {
        self.paths.clear();
    }

    fn rays(&self) -> [u64; 2] {
        self.rays
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3, Vec3};

    use super::*;
    use crate::light::PointLight;
    use crate::sampler::SamplerKind;
    use crate::scene::build;
    use crate::scene::description::{
        Colour, Conductor, Dielectric, Diffuse, EmissionDescription, EnvironmentDescription, InstanceDescription,
        LightDescription, LightKind, MaterialDescription, MaterialModel, MeshDescription, Roughness, SceneDescription,
        TexturedColour, ThinDielectric,
    };
    use photosite_core::spectrum::{Dispersion, Spectrum, library};

    /// Adds a mesh with a material of its own.
    fn add(scene: &mut SceneDescription, material: MaterialDescription, mesh: MeshDescription) {
        let (name, index) = (material.name.clone(), scene.materials.len());
        scene.materials.push(material);
        scene.meshes.push(MeshDescription { name: name.clone(), material: index, ..mesh }.into());
        scene.instances.push(InstanceDescription::of_mesh(name, index, DAffine3::IDENTITY));
    }

    /// A floor under a slab of glass that disperses and a mirror, in a room that is bright everywhere, with an emitter
    /// and a light without extent. The floor's shading normals lean, in parts below what is seen.
    fn scene() -> Scene {
        let mut scene = SceneDescription {
            environment: Some(EnvironmentDescription::Constant {
                colour: Colour::Rgb([0.9; 3]),
                luminance_nit: Some(50.0),
            }),
            ..SceneDescription::default()
        };
        let silver = library::conductor("Ag").expect("a metal");
        let materials = [
            (
                -1.0,
                MaterialModel::Diffuse(Diffuse { reflectance: TexturedColour::plain(Colour::Rgb([0.7, 0.5, 0.3])) }),
            ),
            (
                0.0,
                MaterialModel::Dielectric(Dielectric {
                    index: library::glass("SF11").expect("a glass"),
                    distribution: Roughness::SMOOTH,
                    energy_compensation: false,
                }),
            ),
            (
                0.5,
                MaterialModel::Dielectric(Dielectric {
                    index: library::glass("SF11").expect("a glass"),
                    distribution: Roughness::isotropic(0.3),
                    energy_compensation: false,
                }),
            ),
            (
                1.5,
                MaterialModel::Conductor(Conductor {
                    eta: silver.eta,
                    k: silver.k,
                    distribution: Roughness::SMOOTH,
                    energy_compensation: false,
                }),
            ),
        ];
        let leaning = [[0.0, 0.0], [3.0, -1.0], [0.5, 0.5], [-8.0, 0.2]].map(|[x, y]| Vec3::new(x, y, 1.0));
        for (z, model) in materials {
            let mesh = MeshDescription {
                positions: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                    .map(|[x, y]| Vec3::new(x, y, z))
                    .to_vec(),
                normals: if z < 0.0 { leaning.map(Vec3::normalize).to_vec() } else { vec![] },
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                ..MeshDescription::default()
            };
            add(&mut scene, MaterialDescription::new(format!("z = {z}"), model), mesh);
        }
        let emission = |level: f64| EmissionDescription {
            colour: Colour::Rgb([1.0, 0.8, 0.6]),
            level: Some(level),
            texture: None,
        };
        // Triangles that shine to one side and to both, and walls without shading normals.
        for (x, level, double_sided) in
            [(-0.9f32, Some(80.0), false), (0.9, Some(90.0), true), (-1.1, None, false), (1.1, None, true)]
        {
            let grey =
                MaterialModel::Diffuse(Diffuse { reflectance: TexturedColour::plain(Colour::Rgb([0.4, 0.5, 0.6])) });
            let material = MaterialDescription {
                emission: level.map(emission),
                double_sided,
                ..MaterialDescription::new(format!("x = {x}"), grey)
            };
            let mesh = MeshDescription {
                positions: [[-0.7, -0.9], [0.8, -0.9], [0.0, 0.4]].map(|[y, z]| Vec3::new(x, y, z)).to_vec(),
                triangles: vec![[0, 1, 2]],
                ..MeshDescription::default()
            };
            add(&mut scene, material, mesh);
        }
        scene.lights.push(LightDescription {
            name: "point".into(),
            to_world: DAffine3::from_translation(DVec3::new(0.1, 0.8, -0.3)),
            later: vec![],
            kind: LightKind::Point(PointLight),
            emission: emission(20.0),
        });
        build(scene, &Spectrum::constant(1.0))
    }

    #[test]
    fn paths_of_a_wave_bring_what_each_brings_alone() {
        let scene = scene();
        for (kind, splitting, max_depth) in [
            (SamplerKind::Sobol, 1, 6),
            (SamplerKind::Sobol, 3, 6),
            (SamplerKind::Sobol, 4, 1),
            (SamplerKind::Sobol, 1, 0),
            (SamplerKind::Independent, 3, 12),
        ] {
            let limits = PathLimits { max_depth, roulette_depth: 3, splitting };
            let mut wavefront = Wavefront::new(limits, MisRatio::NONE);
            // The second wavefront is smaller, and nothing of the first may be left in it.
            for count in [40, 7] {
                let mut sampler = Sampler::new(kind, 5);
                let start = |sampler: &mut Sampler, index: u32| {
                    sampler.start(u64::from(index / 20), index);
                    let [x, y] = sampler.next_2d();
                    let target = Vec3::new(2.4 * x - 1.2, 2.4 * y - 1.2, 0.2);
                    let ray =
                        Ray::new(Vec3::new(0.3, -0.2, 1.2), target.normalize() * (1.0 - 2.0 * (index % 2) as f32));
                    (ray, Wavelengths::new([450.0, 520.0, 590.0, 660.0], [0.01; 4]))
                };
                for index in 0..count {
                    let (ray, wavelengths) = start(&mut sampler, index);
                    wavefront.start(ray, wavelengths, sampler.position());
                }
                let _ = wavefront.trace(&scene, &mut sampler);
                let mut lit = 0;
                for index in 0..count {
                    let mut alone = Sampler::new(kind, 5);
                    let (ray, mut wavelengths) = start(&mut alone, index);
                    let light = radiance(&scene, ray, &mut wavelengths, &mut alone, limits);
                    assert_eq!(
                        wavefront.arrived(index as usize),
                        (light, &wavelengths),
                        "{kind:?}, {limits:?}, {index}"
                    );
                    lit += u32::from(!light.is_black());
                }
                assert_eq!(lit > 0, max_depth > 0, "{limits:?}");
                wavefront.clear();
            }
        }
    }

    #[test]
    fn panes_let_the_light_of_lamps_without_a_surface_through() {
        // At normal incidence a pane of index 1.5 lets (1 − R)/(1 + R) through, R = 0.04, times what its glass leaves.
        let clear = 0.96 / 1.04;
        let tinted = 0.96f64.powi(2) * 0.5 / (1.0 - (0.04f64 * 0.5).powi(2));
        let seen = |panes: &[f64]| {
            let mut scene = SceneDescription::default();
            let square = |z: f32| MeshDescription {
                positions: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                    .map(|[x, y]| Vec3::new(x, y, z))
                    .to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                ..MeshDescription::default()
            };
            let white = MaterialModel::Diffuse(Diffuse { reflectance: TexturedColour::plain(Colour::Rgb([0.7; 3])) });
            add(&mut scene, MaterialDescription::new("floor", white), square(0.0));
            for (i, &transmittance) in panes.iter().enumerate() {
                let pane = MaterialModel::ThinDielectric(ThinDielectric {
                    index: Dispersion::constant(1.5),
                    transmittance: Spectrum::constant(transmittance as f32),
                });
                add(&mut scene, MaterialDescription::new(format!("pane {i}"), pane), square(1.0 + i as f32));
            }
            scene.lights.push(LightDescription {
                name: "point".into(),
                to_world: DAffine3::from_translation(DVec3::new(0.1, 0.2, 4.0)),
                later: vec![],
                kind: LightKind::Point(PointLight),
                emission: EmissionDescription { colour: Colour::Rgb([1.0; 3]), level: Some(20.0), texture: None },
            });
            let scene = build(scene, &Spectrum::constant(1.0));
            let mut sampler = Sampler::new(SamplerKind::Sobol, 5);
            sampler.start(0, 0);
            let mut wavelengths = Wavelengths::new([450.0, 520.0, 590.0, 660.0], [0.01; 4]);
            // Below the lamp, seen from beneath the panes.
            let ray = Ray::new(Vec3::new(0.6, 0.2, 0.5), Vec3::new(-0.5, 0.0, -0.5).normalize());
            let limits = PathLimits { max_depth: 1 + 1, roulette_depth: 9, splitting: 1 };
            f64::from(radiance(&scene, ray, &mut wavelengths, &mut sampler, limits)[0])
        };
        let open = seen(&[]);
        for (panes, expected) in
            [(&[1.0][..], clear), (&[1.0, 1.0], clear * clear), (&[0.5], tinted), (&[0.5, 1.0], tinted * clear)]
        {
            let part = seen(panes) / open;
            assert!((part - expected).abs() < 1e-4, "{panes:?}: {part}, {expected}");
        }
    }
}
