//! Paths that are traced together, from surface to surface: first the rays of all, then what each does where it has come to,
//! then their shadow rays. While the memory brings what one ray needs, others go on, and each part of the code runs for all
//! paths before the next one takes its place. Those that have come to matt surfaces are dealt with eight at a time.

use super::odds::Odds;
use super::path::{MattSurfaces, Path, PathLimits, Postponed, Sharing};
use super::reuse::Connections;
use crate::geometry::{Geometry, Hit, Ray};
use crate::sampler::{SamplePlace, Sampler};
use crate::scene::Scene;
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};

/// An estimate of the radiance that arrives against the ray's unit direction, W·m⁻²·sr⁻¹·nm⁻¹ at each wavelength, by one path
/// and its branches, with the numbers from where the sampler is; where it is afterwards means nothing. A refraction that
/// disperses leaves only the hero of `wavelengths`.
pub fn radiance(
    scene: &Scene,
    ray: Ray,
    wavelengths: &mut Wavelengths,
    sampler: &mut Sampler,
    limits: PathLimits,
) -> SampledSpectrum {
    let mut wave = Wave::new(limits, Odds::NONE);
    wave.start(ray, *wavelengths, sampler.place(), Sharing::Nothing);
    wave.trace(scene, sampler);
    let (light, remaining) = wave.arrived(0);
    *wavelengths = *remaining;
    light
}

/// Paths that are traced together.
pub(super) struct Wave {
    limits: PathLimits,
    /// Those of each path at its start.
    odds: Odds,
    /// Those that were started, and then the branches of those that have split.
    paths: Vec<Path>,
    /// Sums over the branches of each path that was started.
    branched: Vec<SampledSpectrum>,
    front: Front,
    /// What becomes the front.
    next: Front,
    hits: Vec<Option<Hit>>,
    matt: MattSurfaces,
    postponed: Postponed,
    occluded: Vec<bool>,
    connections: Connections,
}

/// Paths that have not come to their ends, by their numbers, and where they go.
#[derive(Default)]
struct Front {
    numbers: Vec<u32>,
    rays: Vec<Ray>,
}

impl Front {
    fn clear(&mut self) {
        self.numbers.clear();
        self.rays.clear();
    }

    #[inline]
    fn push(&mut self, number: u32, ray: Ray) {
        self.numbers.push(number);
        self.rays.push(ray);
    }
}

/// Asks the memory for the corners of triangles that paths soon come to, and before that for where those are.
#[inline]
fn ask_for_corners(geometry: &Geometry, hits: &[Option<Hit>]) {
    const SOON: usize = 4;
    if let Some(Some(hit)) = hits.get(2 * SOON) {
        geometry.prefetch_primitive(hit.primitive);
    }
    if let Some(Some(hit)) = hits.get(SOON) {
        geometry.prefetch_corners(hit.primitive);
    }
}

impl Wave {
    /// Without paths.
    pub(super) fn new(limits: PathLimits, odds: Odds) -> Self {
        assert!(limits.splitting > 0, "a path goes on as at least one");
        Self {
            limits,
            odds,
            paths: Vec::new(),
            branched: Vec::new(),
            front: Front::default(),
            next: Front::default(),
            hits: Vec::new(),
            matt: MattSurfaces::new(),
            postponed: Postponed::default(),
            occluded: Vec::new(),
            connections: Connections::default(),
        }
    }

    /// Adds a path from the camera, with the numbers from a place on.
    #[inline]
    pub(super) fn start(&mut self, ray: Ray, wavelengths: Wavelengths, place: SamplePlace, sharing: Sharing) {
        self.front.push(self.paths.len() as u32, ray);
        self.paths.push(Path::new(wavelengths, place, self.odds, sharing));
    }

    /// Number of paths that were started, before they are traced.
    pub(super) fn len(&self) -> usize {
        self.paths.len()
    }

    /// Traces all that were started to their ends.
    pub(super) fn trace(&mut self, scene: &Scene, sampler: &mut Sampler) {
        let started_count = self.paths.len();
        if self.limits.max_depth == 0 {
            self.front.clear();
        }
        while !self.front.numbers.is_empty() {
            self.advance(scene, sampler);
        }
        self.branched.clear();
        self.branched.resize(started_count, SampledSpectrum::ZERO);
        let (started, branches) = self.paths.split_at(started_count);
        for branch in branches {
            let Some(origin) = branch.origin.map(|number| number as usize) else { continue };
            if branch.sharing != Sharing::Light {
                self.branched[origin] += branch.arrived_at(&started[origin]);
            }
        }
        self.share(scene);
    }

    /// Lets the paths of each group share what they have found.
    fn share(&mut self, scene: &Scene) {
        let Self { paths, branched, postponed: Postponed { firsts, seconds, before, .. }, connections, .. } = self;
        for (origin, light) in before.drain(..) {
            branched[origin as usize] += light;
        }
        // Those of one group stay in the order of their paths.
        firsts.sort_by_key(|first| first.group);
        seconds.sort_by_key(|second| second.group);
        let light = |number: usize| {
            let second = &seconds[number];
            paths[second.branch as usize].arrived_at(&paths[second.origin as usize])
        };
        connections.share(scene, (firsts, seconds), light, |path, light| branched[path as usize] += light);
        firsts.clear();
        seconds.clear();
    }

    /// All paths that go on, from one surface to the next.
    fn advance(&mut self, scene: &Scene, sampler: &mut Sampler) {
        let Self { limits, paths, front, next, hits, matt, postponed, .. } = self;
        scene.closest_each(&front.rays, hits);
        let looks_ahead = scene.geometry().exceeds_caches();
        for (i, ((&number, ray), hit)) in front.numbers.iter().zip(&front.rays).zip(&*hits).enumerate() {
            if looks_ahead {
                ask_for_corners(scene.geometry(), &hits[i..]);
            }
            let path = &mut paths[number as usize];
            if matt.take(number, path, (ray, hit.as_ref()), scene, limits) {
                if matt.is_full() {
                    matt.advance(paths, scene, limits, sampler, postponed, |number, ray| next.push(number, ray));
                }
            } else if let Some(ray) = path.advance(number, (ray, *hit), scene, limits, sampler, postponed) {
                next.push(number, ray);
            }
        }
        matt.advance(paths, scene, limits, sampler, postponed, |number, ray| next.push(number, ray));
        for (path, ray) in postponed.branches.drain(..) {
            next.push(paths.len() as u32, ray);
            paths.push(path);
        }
        front.clear();
        std::mem::swap(front, next);
        self.light_up(scene);
    }

    /// Gives light that nothing is in the way of to its paths.
    fn light_up(&mut self, scene: &Scene) {
        let Self { paths, postponed: Postponed { shadow_rays, lights, .. }, occluded, .. } = self;
        scene.occluded_each(shadow_rays, occluded);
        for ((number, light), occluded) in lights.drain(..).zip(&*occluded) {
            if !occluded {
                paths[number as usize].light += light;
            }
        }
        shadow_rays.clear();
    }

    /// What has arrived along a path that was started, and with which wavelengths.
    pub(super) fn arrived(&self, number: usize) -> (SampledSpectrum, &Wavelengths) {
        let Path { light, wavelengths, .. } = &self.paths[number];
        (*light + self.branched[number] * (1.0 / self.limits.splitting as f32), wavelengths)
    }

    /// Makes room for other paths.
    pub(super) fn clear(&mut self) {
        self.paths.clear();
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3, Vec3};

    use super::*;
    use crate::sampler::SamplerKind;
    use crate::scene::build;
    use crate::scene::description::{
        Colour, EmissionDescription, EnvironmentDescription, InstanceDescription, LightDescription, LightKind,
        MaterialDescription, MaterialModel, MeshDescription, SceneDescription, TexturedColour,
    };
    use photosite_core::spectrum::{Spectrum, library};

    /// Adds a mesh with a material of its own.
    fn add(scene: &mut SceneDescription, material: MaterialDescription, mesh: MeshDescription) {
        let (name, number) = (material.name.clone(), scene.materials.len());
        scene.materials.push(material);
        scene.meshes.push(MeshDescription { name: name.clone(), material: number, ..mesh });
        let to_world = DAffine3::IDENTITY;
        scene.instances.push(InstanceDescription { name, mesh: number, to_world, later: vec![] });
    }

    /// A floor under a slab of glass that disperses and a mirror, in a room that is bright everywhere, with a lamp and a light
    /// without extent. The floor's shading normals lean, in parts below what is seen.
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
            (-1.0, MaterialModel::Diffuse { reflectance: TexturedColour::plain(Colour::Rgb([0.7, 0.5, 0.3])) }),
            (0.0, MaterialModel::Dielectric { index: library::glass("SF11").expect("a glass"), roughness: 0.0 }),
            (0.5, MaterialModel::Dielectric { index: library::glass("SF11").expect("a glass"), roughness: 0.3 }),
            (1.5, MaterialModel::Conductor { eta: silver.eta, k: silver.k, roughness: 0.0, anisotropy: 0.0 }),
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
            let grey = MaterialModel::Diffuse { reflectance: TexturedColour::plain(Colour::Rgb([0.4, 0.5, 0.6])) };
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
            kind: LightKind::Point,
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
            let mut wave = Wave::new(limits, Odds::NONE);
            // The second wave is smaller, and nothing of the first may be left in it.
            for count in [40, 7] {
                let mut sampler = Sampler::new(kind, 5);
                let start = |sampler: &mut Sampler, number: u32| {
                    sampler.start(u64::from(number / 20), number);
                    let [x, y] = sampler.next_2d();
                    let target = Vec3::new(2.4 * x - 1.2, 2.4 * y - 1.2, 0.2);
                    let ray =
                        Ray::new(Vec3::new(0.3, -0.2, 1.2), target.normalize() * (1.0 - 2.0 * (number % 2) as f32));
                    (ray, Wavelengths::new([450.0, 520.0, 590.0, 660.0], [0.01; 4]))
                };
                for number in 0..count {
                    let (ray, wavelengths) = start(&mut sampler, number);
                    wave.start(ray, wavelengths, sampler.place(), Sharing::Nothing);
                }
                wave.trace(&scene, &mut sampler);
                let mut lit = 0;
                for number in 0..count {
                    let mut alone = Sampler::new(kind, 5);
                    let (ray, mut wavelengths) = start(&mut alone, number);
                    let light = radiance(&scene, ray, &mut wavelengths, &mut alone, limits);
                    assert_eq!(wave.arrived(number as usize), (light, &wavelengths), "{kind:?}, {limits:?}, {number}");
                    lit += u32::from(!light.is_black());
                }
                assert_eq!(lit > 0, max_depth > 0, "{limits:?}");
                wave.clear();
            }
        }
    }
}
