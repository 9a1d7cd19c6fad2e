//! The BSDFs and directions that the tests go through, with names made from their parameters.

use glam::Vec3;
use photosite::bsdf::{Bsdf, Ggx};
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
    Bsdf::Conductor {
        eta: SampledSpectrum::from([1.40, 0.43, 0.15, 0.14]),
        k: SampledSpectrum::from([1.88, 2.46, 3.44, 4.34]),
        distribution,
    }
}

/// A metal that absorbs nothing: η = 0 makes Fresnel's reflectance 1 at every angle.
pub(crate) fn lossless_metal(distribution: Ggx) -> Bsdf {
    Bsdf::Conductor { eta: SampledSpectrum::ZERO, k: SampledSpectrum::ONE, distribution }
}

/// A clear medium of the same index at all wavelengths.
pub(crate) fn glass(eta: f32, distribution: Ggx) -> Bsdf {
    Bsdf::Dielectric { eta: SampledSpectrum::splat(eta), dispersive: false, distribution }
}

/// glTF's material of one colour at all wavelengths.
pub(crate) fn gltf(base_colour: f32, metallic: f32, distribution: Ggx) -> Bsdf {
    Bsdf::MetallicRoughness { base_colour: SampledSpectrum::splat(base_colour), metallic, distribution }
}

/// Every model that has a lobe of some width, at several roughnesses.
pub(crate) fn wide() -> Vec<Case> {
    let mut cases = vec![Case {
        name: "diffuse".into(),
        bsdf: Bsdf::Diffuse { reflectance: SampledSpectrum::from([0.1, 0.4, 0.7, 1.0]) },
    }];
    cases.push(Case { name: "glTF smooth".into(), bsdf: gltf(0.5, 0.0, Ggx::SMOOTH) });
    for [x, y] in ALPHAS {
        let ggx = Ggx::new(x, y);
        cases.push(Case { name: format!("gold α {x} {y}"), bsdf: gold(ggx) });
        for eta in [1.33, 2.4] {
            cases.push(Case { name: format!("dielectric η {eta} α {x} {y}"), bsdf: glass(eta, ggx) });
        }
        let base_colour = SampledSpectrum::from([0.05, 0.3, 0.6, 1.0]);
        for metallic in [0.0, 0.4] {
            let bsdf = Bsdf::MetallicRoughness { base_colour, metallic, distribution: ggx };
            cases.push(Case { name: format!("glTF metallic {metallic} α {x} {y}"), bsdf });
        }
    }
    cases
}

/// Directions to look from, above the surface: along the normal, oblique, grazing, in different azimuths.
pub(crate) fn above() -> Vec<(String, Vec3)> {
    [(0.0, 0.0), (30.0, 50.0), (60.0, 200.0), (80.0, 320.0)].into_iter().map(|(t, p)| from_degrees(t, p)).collect()
}

/// The directions from which a model can be seen: dielectrics from below too.
pub(crate) fn visible_from(bsdf: &Bsdf) -> Vec<(String, Vec3)> {
    let mut directions = above();
    if matches!(bsdf, Bsdf::Dielectric { .. }) {
        directions.extend([(120.0, 70.0), (150.0, 10.0)].into_iter().map(|(t, p)| from_degrees(t, p)));
    }
    directions
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
