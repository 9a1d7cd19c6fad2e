//! The materials of a scene, from their description to the light that comes back: every model in a white furnace.

use glam::Vec3;
use photosite::bsdf::CubeCorners;
use photosite::geometry::Ray;
use photosite::integrator::{PathLimits, radiance};
use photosite::math::statistics::Moments;
use photosite::sampler::{Sampler, SamplerKind};
use photosite::scene::description::{
    CoatDescription, Colour, Conductor, Dielectric, Diffuse, FilmDescription, LayeredDescription, MaterialModel, Mix,
    OrenNayar, Phong, Retroreflective, Roughness, TexturedColour, TexturedFactor, ThinDielectric, Translucent,
};
use photosite::spectrum::{Dispersion, Spectrum, Wavelengths};

use crate::stage::{Stage, sphere};
use crate::transport::{along, assert_mean};

fn grey(value: f32) -> TexturedColour {
    TexturedColour::plain(Colour::Spectrum(Spectrum::constant(value)))
}

fn diffuse(value: f32) -> MaterialModel {
    MaterialModel::Diffuse(Diffuse { reflectance: grey(value) })
}

fn layered(layers: LayeredDescription) -> MaterialModel {
    MaterialModel::Layered(Box::new(LayeredDescription { base_colour: grey(1.0), ..layers }))
}

/// Name of a lossless material of each model, and by how much less or more it may give back. A model that is
/// added has no place here yet, which the compiler says.
fn tolerance(model: &MaterialModel) -> (&'static str, f64) {
    match model {
        MaterialModel::Diffuse(_) => ("diffuse", 0.0),
        MaterialModel::Conductor(_) => ("conductor", 0.0),
        MaterialModel::Dielectric(_) => ("dielectric", 0.0),
        MaterialModel::OrenNayar(_) => ("Oren–Nayar", 1e-4),
        // From aslant the surface cuts off part of the lobe: at half a lobe, along the surface, half of it.
        MaterialModel::Phong(_) => ("Phong", 0.5),
        MaterialModel::Translucent(_) => ("translucent", 0.0),
        MaterialModel::ThinDielectric(_) => ("thin dielectric", 0.0),
        // What goes back to steeper angles is the smaller of both active parts: |da/dθ| ≤ 1.8/n times the mean width of
        // the lobe, π·α, with n = 1.5 and α = 0.05².
        MaterialModel::Retroreflective(_) => ("retroreflective", 0.0095),
        MaterialModel::Mix(_) => ("mix", 0.012),
        // The tables of `bsdf::albedo`; of all bounces within a clear body as many again.
        MaterialModel::Layered(layers) if layers.transmission.value > 0.0 => ("clear layers", 0.024),
        MaterialModel::Layered(_) => ("layers", 0.012),
    }
}

#[test]
fn white_materials_vanish_in_a_furnace() {
    let rough = |value| TexturedFactor::plain(value);
    let clear = |thin: bool| LayeredDescription {
        transmission: rough(1.0),
        roughness: rough(0.7),
        absorption_per_m: (!thin).then(|| Spectrum::constant(0.0)),
        ..LayeredDescription::default()
    };
    let film = || {
        Some(FilmDescription { weight: rough(1.0), index: 1.33, thickness_nm: [0.0, 400.0], thickness_texture: None })
    };
    let coat = || Some(CoatDescription { weight: rough(1.0), roughness: rough(0.3), normal_map: None });
    let models = [
        diffuse(1.0),
        MaterialModel::Conductor(Conductor {
            eta: Spectrum::constant(0.0),
            k: Spectrum::constant(1.0),
            distribution: Roughness::SMOOTH,
            energy_compensation: false,
        }),
        MaterialModel::Dielectric(Dielectric {
            index: Dispersion::constant(1.5),
            distribution: Roughness::SMOOTH,
            energy_compensation: false,
        }),
        MaterialModel::OrenNayar(OrenNayar { reflectance: grey(1.0), roughness: 0.7 }),
        MaterialModel::Phong(Phong { diffuse: grey(0.5), specular: grey(0.5), exponent: 20.0 }),
        MaterialModel::Translucent(Translucent { reflectance: grey(0.3), transmittance: grey(0.7) }),
        MaterialModel::Retroreflective(Retroreflective {
            retroreflectance: grey(1.0),
            reflectance: grey(1.0),
            corners: CubeCorners::new(1.5),
            distribution: Roughness::isotropic(0.05),
        }),
        MaterialModel::ThinDielectric(ThinDielectric {
            index: Dispersion::constant(1.5),
            transmittance: Spectrum::constant(1.0),
        }),
        MaterialModel::Mix(Box::new(Mix {
            models: [
                layered(LayeredDescription { index: Dispersion::constant(1.6), ..LayeredDescription::default() }),
                MaterialModel::Mix(Box::new(Mix {
                    models: [
                        diffuse(1.0),
                        MaterialModel::OrenNayar(OrenNayar { reflectance: grey(1.0), roughness: 1.0 }),
                    ],
                    weight: 0.5,
                })),
            ],
            weight: 0.4,
        })),
        layered(LayeredDescription { coat: coat(), film: film(), ..LayeredDescription::default() }),
        layered(LayeredDescription { metallic: rough(1.0), roughness: rough(0.8), ..LayeredDescription::default() }),
        layered(clear(true)),
        layered(clear(false)),
        layered(LayeredDescription { film: film(), ..clear(false) }),
    ];
    for model in models {
        let (name, tolerance) = tolerance(&model);
        let what = format!("{name}: {model:?}").chars().take(200).collect::<String>();
        let scene = Stage::default().mesh(sphere(24, 1.0), model, None).environment(2.0).build();
        for x in [0.05, 0.6, 0.9] {
            let got = along(&scene, Vec3::new(x, 0.07, 5.0), Vec3::NEG_Z, 64, 20_000);
            // 4.5 standard errors (one in 10⁵ by chance), and what Russian roulette's 64 bounces leave out, 1e-4.
            let allowed = 2.0 * tolerance + 4.5 * got.variance_of_mean().sqrt() + 2e-4;
            assert!((got.mean() - 2.0).abs() <= allowed, "{what} at {x}: {} ± {allowed}", got.mean());
        }
    }
}

#[test]
fn a_mix_is_the_mean_of_both_by_weight() {
    for weight in [0.0f32, 0.2, 0.75, 1.0] {
        let inner = MaterialModel::Mix(Box::new(Mix { models: [diffuse(0.1), diffuse(0.9)], weight: 0.25 }));
        let model = MaterialModel::Mix(Box::new(Mix { models: [diffuse(0.6), inner], weight }));
        let scene = Stage::default().mesh(sphere(16, 1.0), model, None).environment(3.0).build();
        // The choice is made by where a path meets the surface and whence: rays spread over the surface see both.
        let at = |i: u16| f32::from(i) / 128.0 - 0.5;
        let mut sampler = Sampler::new(SamplerKind::Independent, 11);
        let path = |i: u16| {
            sampler.start(0, u32::from(i));
            let ray = Ray::new(Vec3::new(at(i % 128), at(i / 128), 5.0), Vec3::NEG_Z);
            let limits = PathLimits { max_depth: 8, roulette_depth: 5, splitting: 1 };
            let mut wavelengths = Wavelengths::new([500.0; 4], [1.0; 4]);
            f64::from(radiance(&scene, ray, &mut wavelengths, &mut sampler, limits)[0])
        };
        let got: Moments = (0..128 * 128).map(path).collect();
        let expected = 3.0 * f64::from(0.6 * (1.0 - weight) + (0.1 * 0.75 + 0.9 * 0.25) * weight);
        assert_mean(&format!("weight {weight}"), &got, expected);
    }
}
