//! Values, densities and samples of each scattering model against those of the Rust of the same name.

use glam::Vec3;
use photosite_core::spectrum::SampledSpectrum;
use photosite_gpu::probe;
use photosite_transport::bsdf::{
    Bsdf, Conductor, Dielectric, Diffuse, Ggx, Layered, OrenNayar, Phong, RelativeIndex, ThinDielectric, Translucent,
};
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::packed::materials::model;

use crate::Numbers;
use crate::stage::everything;

const TEXT: &str = "
fn answer(words: array<vec4<u32>, 6>) -> array<vec4<u32>, 5> {
    let f = array<vec4<f32>, 6>(
        bitcast<vec4<f32>>(words[0]), bitcast<vec4<f32>>(words[1]), bitcast<vec4<f32>>(words[2]),
        bitcast<vec4<f32>>(words[3]), bitcast<vec4<f32>>(words[4]), bitcast<vec4<f32>>(words[5]),
    );
    let bsdf = Bsdf(words[0].x, f[0].yz, f[1], f[2], words[0].w == 1u, f[5].z, f[5].w);
    let scattering = eval_bsdf(bsdf, f[3].xyz, f[4].xyz);
    let sample = sample_bsdf(bsdf, f[3].xyz, f[3].w, f[5].xy);
    let flags = select(0u, 1u, sample.is_delta) | select(0u, 2u, sample.is_transmission) | select(0u, 4u, sample.terminates_secondary)
        | select(0u, 8u, is_delta(bsdf)) | select(0u, 16u, has_lobes(bsdf)) | select(0u, 32u, transmits(bsdf));
    return array<vec4<u32>, 5>(
        bitcast<vec4<u32>>(scattering.f),
        bitcast<vec4<u32>>(vec4<f32>(scattering.pdf, sample.pdf, sample.eta, 0.0)),
        bitcast<vec4<u32>>(sample.f),
        bitcast<vec4<u32>>(vec4<f32>(sample.wi, 0.0)),
        vec4<u32>(flags, 0u, 0u, 0u),
    );
}";

/// A model with the words by which cards know it.
struct Case {
    name: &'static str,
    bsdf: Bsdf,
    model: u32,
    roughness: [f32; 2],
    parameters: [SampledSpectrum; 2],
    is_dispersive: bool,
    /// Metalness and specular weight of glTF's material.
    weights: [f32; 2],
}

fn cases() -> Vec<Case> {
    let (a, b) = (SampledSpectrum::from([0.2, 0.5, 0.7, 0.9]), SampledSpectrum::from([0.6, 0.3, 0.1, 0.05]));
    let (eta, k) = (SampledSpectrum::from([0.2, 0.9, 1.4, 0.05]), SampledSpectrum::from([3.1, 2.4, 1.9, 4.2]));
    let index = SampledSpectrum::from([1.52, 1.53, 1.55, 1.5]);
    let zero = SampledSpectrum::ZERO;
    let case = |name, bsdf, model, roughness, parameters| Case {
        name,
        bsdf,
        model,
        roughness,
        parameters,
        is_dispersive: false,
        weights: [0.0; 2],
    };
    let mut all = vec![
        case("diffuse", Bsdf::Diffuse(Diffuse { reflectance: a }), model::DIFFUSE, [0.0; 2], [a, zero]),
        case(
            "oren-nayar",
            Bsdf::OrenNayar(OrenNayar { reflectance: a, roughness: 0.7 }),
            model::OREN_NAYAR,
            [0.7, 0.0],
            [a, zero],
        ),
        case(
            "phong",
            Bsdf::Phong(Phong { diffuse: b, specular: b, exponent: 17.0 }),
            model::PHONG,
            [17.0, 0.0],
            [b, b],
        ),
        case(
            "translucent",
            Bsdf::Translucent(Translucent { reflectance: b, transmittance: a }),
            model::TRANSLUCENT,
            [0.0; 2],
            [b, a],
        ),
        case(
            "pane",
            Bsdf::ThinDielectric(ThinDielectric {
                index: RelativeIndex { eta: index, dispersive: true, is_one: false },
                transmittance: a,
            }),
            model::THIN_DIELECTRIC,
            [0.0; 2],
            [index, a],
        ),
    ];
    for [x, y] in [[0.0f32; 2], [0.05, 0.05], [0.3, 0.6], [0.9, 0.2], [0.5, 0.5]] {
        let distribution = Ggx::new(x, y);
        let metal = Conductor { eta, k, distribution, energy_compensation: false };
        if x == y {
            for (metallic, specular) in [(0.0, 1.0), (0.4, 0.7), (1.0, 1.0)] {
                let layers = Layered { base_colour: a, f0: b, metallic, specular, distribution, ..Layered::default() };
                let case = case("layered", Bsdf::Layered(layers), model::LAYERED, [x, y], [a, b]);
                all.push(Case { weights: [metallic, specular], ..case });
            }
        }
        all.push(case("metal", Bsdf::Conductor(metal), model::CONDUCTOR, [x, y], [eta, k]));
        for (dispersive, eta) in
            [(false, SampledSpectrum::splat(1.5)), (true, index), (false, SampledSpectrum::splat(0.7))]
        {
            let index = RelativeIndex { eta, dispersive, is_one: false };
            let glass = Dielectric { index, distribution, energy_compensation: false };
            let case = case("glass", Bsdf::Dielectric(glass), model::DIELECTRIC, [x, y], [eta, zero]);
            all.push(Case { is_dispersive: dispersive, ..case });
        }
    }
    all
}

/// Whether two numbers differ by no more than a part, or a part of one.
fn near(found: f32, expected: f32, part: f32, floor: f32) -> bool {
    (found - expected).abs() <= part * expected.abs().max(floor)
}

#[test]
fn models_scatter_as_on_the_processor() {
    let Some(card) = crate::card() else { return };
    // Its tables hold the albedos of facets.
    let scene = everything().build().packed().expect("a scene that cards render");
    let mut numbers = Numbers(11);
    for Case { name, bsdf, model, roughness: [x, y], parameters, is_dispersive, weights } in cases() {
        let draws: Vec<(Vec3, Vec3, f32, [f32; 2])> = (0..4096)
            .map(|_| (numbers.direction(), numbers.direction(), numbers.next(), [numbers.next(), numbers.next()]))
            // Near the horizon and where lobes are narrow one rounding is many parts of the value.
            .filter(|(wo, wi, ..)| wo.z.abs() > 0.05 && wi.z.abs() > 0.05)
            .collect();
        let inputs: Vec<[[u32; 4]; 6]> = draws
            .iter()
            .map(|(wo, wi, u_lobe, u)| {
                let [first, second] = parameters.map(|s| s.to_array().map(f32::to_bits));
                [
                    [model, x.to_bits(), y.to_bits(), u32::from(is_dispersive)],
                    first,
                    second,
                    [wo.x, wo.y, wo.z, *u_lobe].map(f32::to_bits),
                    [wi.x, wi.y, wi.z, 0.0].map(f32::to_bits),
                    [u[0], u[1], weights[0], weights[1]].map(f32::to_bits),
                ]
            })
            .collect();
        let found =
            probe::answers::<6, 5>(card, &scene, SamplerKind::Sobol, TEXT, &inputs).expect("a kernel that runs");
        let narrowest = x.min(y).max(1e-3);
        // Facets amplify the rounding of directions by one over their roughness.
        let part = if x > 0.0 { 3e-6 / (narrowest * narrowest) } else { 2e-5 };
        // The facet of a refraction is as uncertain as one over |η − 1|, and more where both directions graze it.
        let part = if name == "glass" { 5.0 * part } else { part };
        let mut flipped = 0;
        for ((wo, wi, u_lobe, u), words) in draws.iter().zip(found) {
            let [f, pdfs, sample_f, sample_wi, [flags, ..]] = words;
            let [f, pdfs, sample_f, sample_wi] = [f, pdfs, sample_f, sample_wi].map(|word| word.map(f32::from_bits));
            let at = format!("{name} {x} {y}: {wo} {wi} {u_lobe} {u:?}");
            let expected = bsdf.eval(*wo, *wi);
            assert!(near(pdfs[0], expected.pdf.0, part, 1e-2), "{at}: density {} for {}", pdfs[0], expected.pdf.0);
            for (found, expected) in f.iter().zip(expected.f.to_array()) {
                assert!(near(*found, expected, part, 1e-2), "{at}: {found} for {expected}");
            }
            let traits = [bsdf.is_delta(), bsdf.has_lobes(), bsdf.transmits()];
            assert_eq!(traits, [8, 16, 32].map(|bit| flags & bit != 0), "{at}");
            let Some(sample) = bsdf.sample(*wo, *u_lobe, *u) else {
                flipped += usize::from(pdfs[1] > 0.0);
                continue;
            };
            let bits = [sample.is_delta, sample.is_transmission, sample.terminates_secondary];
            // Where the lobe is chosen by a hair.
            if bits != [1, 2, 4].map(|bit| flags & bit != 0) || pdfs[1] <= 0.0 {
                flipped += 1;
                continue;
            }
            let apart = (Vec3::from([sample_wi[0], sample_wi[1], sample_wi[2]]) - sample.wi).length();
            assert!(apart < 2e-4, "{at}: {sample_wi:?} for {:?}", sample.wi);
            assert!(near(pdfs[1], sample.pdf.0, 10.0 * part, 1e-2), "{at}: density {} for {}", pdfs[1], sample.pdf.0);
            assert!(near(pdfs[2], sample.eta, 1e-6, 1.0), "{at}: index {} for {}", pdfs[2], sample.eta);
            for (found, expected) in sample_f.iter().zip(sample.f.to_array()) {
                assert!(near(*found, expected, 10.0 * part, 1e-2), "{at}: {found} for {expected}");
            }
        }
        assert!(flipped <= 2, "{name} {x} {y}: {flipped} of {} draws go another way", draws.len());
    }
}
