//! The BSDFs and directions that the tests go through, with names made from their parameters.

use glam::Vec3;
use photosite::bsdf::{
    Bsdf, Coat, Conductor, CubeCorners, Dielectric, Diffuse, Ggx, Layered, OrenNayar, Phong, RelativeIndex,
    Retroreflective, Sheen, ThinFilm, Translucent, Volume,
};
use photosite::spectrum::SampledSpectrum;
use rand::Rng;

use photosite::math::hash::unit_f32;
use photosite::math::philox::Philox;

/// Samples that a Monte Carlo test draws a case.
pub(crate) const SAMPLES: usize = 100_000;

/// A BSDF under test.
#[derive(Clone)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) bsdf: Bsdf,
}

/// Roughness pairs α_x, α_y: narrow, anisotropic both ways, as rough as it gets.
pub(crate) const ALPHAS: [[f32; 2]; 4] = [[0.1, 0.1], [0.1, 0.5], [0.6, 0.2], [1.0, 1.0]];

/// Gold at 450, 550, 650 and 750 nm: n and k interpolated in P. B. Johnson, R. W. Christy, Phys. Rev. B 6, 4370 (1972).
pub(crate) fn gold(distribution: Ggx) -> Bsdf {
    Bsdf::Conductor(Conductor {
        eta: SampledSpectrum::from([1.40, 0.43, 0.15, 0.14]),
        k: SampledSpectrum::from([1.88, 2.46, 3.44, 4.34]),
        distribution,
        energy_compensation: false,
    })
}

/// A metal that absorbs nothing: η = 0 makes Fresnel's reflectance 1 at every angle.
pub(crate) fn lossless_metal(distribution: Ggx) -> Bsdf {
    Bsdf::Conductor(Conductor {
        eta: SampledSpectrum::ZERO,
        k: SampledSpectrum::ONE,
        distribution,
        energy_compensation: false,
    })
}

/// A clear medium of the same index at all wavelengths.
pub(crate) fn glass(eta: f32, distribution: Ggx) -> Bsdf {
    Bsdf::Dielectric(Dielectric { index: RelativeIndex::constant(eta), distribution, energy_compensation: false })
}

/// A metal or glass with energy compensation.
pub(crate) fn compensated(mut bsdf: Bsdf) -> Bsdf {
    if let Bsdf::Conductor(metal) = &mut bsdf {
        metal.energy_compensation = true;
    } else if let Bsdf::Dielectric(glass) = &mut bsdf {
        glass.energy_compensation = true;
    }
    bsdf
}

/// Retroreflective sheeting: the part that returns along the normal, that of the rest which is scattered, index,
/// roughness.
pub(crate) fn sheeting(returned: SampledSpectrum, reflectance: SampledSpectrum, index: f32, alpha: f32) -> Bsdf {
    Bsdf::Retroreflective(Retroreflective {
        retroreflectance: returned,
        reflectance,
        corners: CubeCorners::new(index),
        distribution: Ggx::new(alpha, alpha),
    })
}

/// glTF's material of one colour at all wavelengths.
pub(crate) fn gltf(base_colour: f32, metallic: f32, distribution: Ggx) -> Bsdf {
    Bsdf::Layered(Layered {
        base_colour: SampledSpectrum::splat(base_colour),
        metallic,
        distribution,
        ..Layered::default()
    })
}

/// A coat without a normal of its own.
pub(crate) fn coat(weight: f32, alpha: f32) -> Option<Coat> {
    Some(Coat { weight, distribution: Ggx::new(alpha, alpha), normal: Vec3::Z })
}

/// Bases and layers of glTF's material: every base alone under every roughness, every layer over every base.
pub(crate) fn layered(colour: SampledSpectrum, alphas: &[[f32; 2]]) -> Vec<(String, Layered)> {
    let waves = SampledSpectrum::from([1.7, 1.4, 1.2, 1.0]);
    let plain = Layered { base_colour: colour, ..Layered::default() };
    let volume = |eta: f32| Some(Volume { eta: SampledSpectrum::splat(eta), dispersive: false });
    let f0 = |eta: f32| SampledSpectrum::splat(((eta - 1.0) / (eta + 1.0)).powi(2));
    let bases = [
        ("coloured", plain),
        ("metal", Layered { metallic: 1.0, ..plain }),
        ("half metal", Layered { metallic: 0.5, ..plain }),
        ("matt", Layered { specular: 0.0, ..plain }),
        ("specular-glossiness", Layered { f0: SampledSpectrum::from([0.1, 0.3, 0.7, 1.0]), ..plain }),
        ("leaf", Layered { diffuse_transmission: 0.6, diffuse_transmission_colour: colour, ..plain }),
        ("sheet", Layered { transmission: 1.0, ..plain }),
        ("half sheet", Layered { transmission: 0.5, diffuse_transmission: 0.3, ..plain }),
        ("glass", Layered { transmission: 1.0, volume: volume(1.5), ..plain }),
        ("half diamond", Layered { transmission: 0.6, volume: volume(2.4), f0: f0(2.4), ..plain }),
    ];
    let film = Some(ThinFilm { weight: 1.0, index: 1.33, waves });
    let sheen = |alpha| Some(Sheen { colour: colour * 0.8, alpha });
    let layers = [
        ("bare", Layered::default()),
        ("coat 0.25", Layered { coat: coat(1.0, 0.25), ..Layered::default() }),
        ("coat 1", Layered { coat: coat(0.7, 1.0), ..Layered::default() }),
        ("sheen 0.2", Layered { sheen: sheen(0.2), ..Layered::default() }),
        ("sheen 1", Layered { sheen: sheen(1.0), ..Layered::default() }),
        ("film", Layered { film, ..Layered::default() }),
        ("all layers", Layered { coat: coat(1.0, 0.3), sheen: sheen(0.5), film, ..Layered::default() }),
    ];
    let mut cases = Vec::new();
    for [x, y] in alphas {
        for (base_name, base) in &bases {
            for (layer_name, Layered { coat, sheen, film, .. }) in &layers {
                let layered =
                    Layered { distribution: Ggx::new(*x, *y), coat: *coat, sheen: *sheen, film: *film, ..*base };
                cases.push((format!("{base_name}, {layer_name}, α {x} {y}"), layered));
            }
        }
    }
    cases
}

/// Every model that has a lobe of some width, at several roughnesses.
pub(crate) fn wide() -> Vec<Case> {
    let mut cases = vec![Case {
        name: "diffuse".into(),
        bsdf: Bsdf::Diffuse(Diffuse { reflectance: SampledSpectrum::from([0.1, 0.4, 0.7, 1.0]) }),
    }];
    let (some, other) = (SampledSpectrum::from([0.1, 0.4, 0.7, 1.0]), SampledSpectrum::from([0.9, 0.5, 0.2, 0.0]));
    for roughness in [0.3, 1.0] {
        let bsdf = Bsdf::OrenNayar(OrenNayar { reflectance: some, roughness });
        cases.push(Case { name: format!("Oren–Nayar {roughness}"), bsdf });
    }
    for exponent in [3.0, 60.0] {
        let bsdf = Bsdf::Phong(Phong { diffuse: some * 0.4, specular: other * 0.6, exponent });
        cases.push(Case { name: format!("Phong {exponent}"), bsdf });
    }
    let bsdf = Bsdf::Translucent(Translucent { reflectance: some, transmittance: other * 0.5 });
    cases.push(Case { name: "translucent".into(), bsdf });
    for (index, alpha) in [(1.5, 0.1), (1.0, 0.5), (2.0, 0.0)] {
        let bsdf = sheeting(some, other, index, alpha);
        cases.push(Case { name: format!("retroreflective n {index} α {alpha}"), bsdf });
    }
    cases.push(Case { name: "glTF smooth".into(), bsdf: gltf(0.5, 0.0, Ggx::SMOOTH) });
    for [x, y] in ALPHAS {
        let ggx = Ggx::new(x, y);
        cases.push(Case { name: format!("gold α {x} {y}"), bsdf: gold(ggx) });
        cases.push(Case { name: format!("compensated gold α {x} {y}"), bsdf: compensated(gold(ggx)) });
        let bsdf = compensated(glass(1.5, Ggx::new(x, x)));
        cases.push(Case { name: format!("compensated dielectric α {x}"), bsdf });
        for eta in [1.33, 2.4] {
            cases.push(Case { name: format!("dielectric η {eta} α {x} {y}"), bsdf: glass(eta, ggx) });
        }
        let base_colour = SampledSpectrum::from([0.05, 0.3, 0.6, 1.0]);
        if x == 0.1 {
            continue;
        }
        for metallic in [0.0, 0.4] {
            let bsdf = Bsdf::Layered(Layered { base_colour, metallic, distribution: ggx, ..Layered::default() });
            cases.push(Case { name: format!("glTF metallic {metallic} α {x} {y}"), bsdf });
        }
    }
    // Every base, every layer over one of all kinds of lobes, all of them over a refracting one.
    let colours = SampledSpectrum::from([0.05, 0.3, 0.6, 1.0]);
    for (name, layers) in layered(colours, &[[0.25, 0.5]]) {
        let has_all = name.starts_with("half diamond") && name.contains("all layers");
        if name.contains("bare") || name.starts_with("half sheet") || has_all {
            cases.push(Case { name, bsdf: Bsdf::Layered(layers) });
        }
    }
    cases
}

/// Every model with parameters drawn from all that they may be, `count` times: what no list of cases thinks of.
pub(crate) fn drawn(count: usize) -> Vec<Case> {
    let mut cases = Vec::new();
    for number in 0..count {
        let mut uniform = Uniform::new(10_000 + number);
        let mut within = |low: f32, high: f32| low + (high - low) * uniform.next();
        let mut add = |name: &str, bsdf| cases.push(Case { name: format!("{name} drawn {number}: {bsdf:?}"), bsdf });
        let lanes = |f: &mut dyn FnMut() -> f32| SampledSpectrum::from([f(), f(), f(), f()]);
        let ggx = [within(0.1, 1.0), within(0.1, 1.0)];
        let ggx = Ggx::new(ggx[0], ggx[1]);
        let colours: [SampledSpectrum; 5] = std::array::from_fn(|_| lanes(&mut || within(0.0, 1.0)));
        let [some, other, third, ..] = colours;

        let (eta, k) = (lanes(&mut || within(0.05, 4.0)), lanes(&mut || within(0.0, 6.0)));
        add("conductor", Bsdf::Conductor(Conductor { eta, k, distribution: ggx, energy_compensation: false }));
        add("dielectric", glass(within(1.2, 3.0), ggx));
        add("Oren–Nayar", Bsdf::OrenNayar(OrenNayar { reflectance: some, roughness: within(0.0, 1.0) }));
        let share = within(0.0, 1.0);
        let (diffuse, specular) = (some * share, other * (1.0 - share));
        add("Phong", Bsdf::Phong(Phong { diffuse, specular, exponent: 100f32.powf(within(0.0, 1.0)) }));
        add("translucent", Bsdf::Translucent(Translucent { reflectance: diffuse, transmittance: specular }));
        add("retroreflective", sheeting(some, other, within(1.0, 2.0), within(0.1, 1.0)));
        // The `plastic` of capture files: glTF's material of any index.
        let f0 = |eta: f32| SampledSpectrum::splat(((eta - 1.0) / (eta + 1.0)).powi(2));
        let plain = Layered { base_colour: some, distribution: ggx, ..Layered::default() };
        add("plastic", Bsdf::Layered(Layered { f0: f0(within(1.1, 2.5)), ..plain }));

        let eta = within(1.2, 2.8);
        let mut maybe = |low: f32, high: f32| if within(0.0, 1.0) < 0.5 { Some(within(low, high)) } else { None };
        let layers = Layered {
            metallic: maybe(0.0, 1.0).unwrap_or(0.0),
            specular: maybe(0.0, 1.0).unwrap_or(1.0),
            f0: f0(eta),
            transmission: maybe(0.0, 1.0).unwrap_or(0.0),
            volume: maybe(0.0, 1.0).map(|_| Volume { eta: SampledSpectrum::splat(eta), dispersive: false }),
            diffuse_transmission: maybe(0.0, 1.0).unwrap_or(0.0),
            diffuse_transmission_colour: other,
            film: maybe(0.2, 1.0).map(|weight| ThinFilm { weight, index: 1.0 + 2.0 * share, waves: third * 3.0 }),
            sheen: maybe(0.1, 1.0).map(|alpha| Sheen { colour: third, alpha }),
            coat: maybe(0.1, 1.0).and_then(|alpha| coat(share, alpha)),
            ..plain
        };
        // A body that light is refracted into and a leaf that it passes by diffusion are two things.
        let is_body = layers.volume.is_some() && layers.transmission > 0.0;
        let diffuse_transmission = if is_body { 0.0 } else { layers.diffuse_transmission };
        add("glTF", Bsdf::Layered(Layered { diffuse_transmission, ..layers }));
    }
    cases
}

/// Directions to look from, above the surface: along the normal, oblique, grazing, in different azimuths.
pub(crate) fn above() -> Vec<(String, Vec3)> {
    [(0.0, 0.0), (30.0, 50.0), (60.0, 200.0), (80.0, 320.0)].into_iter().map(|(t, p)| from_degrees(t, p)).collect()
}

/// The directions from which a model can be seen: what refracts from below too.
pub(crate) fn visible_from(bsdf: &Bsdf) -> Vec<(String, Vec3)> {
    let mut directions = above();
    if bsdf.refracts() {
        directions.extend([(120.0, 70.0), (150.0, 10.0)].into_iter().map(|(t, p)| from_degrees(t, p)));
    }
    directions
}

/// η² of refraction: the index on the side of `wi` over that on the side of `wo`, squared.
pub(crate) fn squared_index(bsdf: &Bsdf, wo: Vec3, wi: Vec3) -> f32 {
    let inside = if let Bsdf::Dielectric(dielectric) = bsdf {
        dielectric.index.eta[0]
    } else if let Bsdf::Layered(Layered { volume: Some(volume), .. }) = bsdf
        && bsdf.refracts()
    {
        volume.eta[0]
    } else {
        1.0
    };
    match (wo.z > 0.0, wi.z > 0.0) {
        (true, false) => inside * inside,
        (false, true) => 1.0 / (inside * inside),
        (true, true) | (false, false) => 1.0,
    }
}

fn from_degrees(theta: f64, phi: f64) -> (String, Vec3) {
    let [t, p] = [theta, phi].map(f64::to_radians);
    let w = glam::DVec3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos()).as_vec3();
    (format!("from {theta}° {phi}°"), w)
}

/// Uniform numbers in [0, 1) for one test case.
pub(crate) struct Uniform(Philox);

impl Uniform {
    pub(crate) fn new(case: usize) -> Self {
        Self(Philox::new(0x5eed_b5df, case as u64))
    }

    pub(crate) fn next(&mut self) -> f32 {
        unit_f32(self.0.next_u32())
    }

    /// The arguments of `Bsdf::sample`.
    pub(crate) fn lobe_and_direction(&mut self) -> (f32, [f32; 2]) {
        (self.next(), [self.next(), self.next()])
    }
}
