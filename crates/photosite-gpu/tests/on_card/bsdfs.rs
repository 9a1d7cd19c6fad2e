//! Values, densities and samples of each scattering model against those of the Rust of the same name.

use glam::{DAffine3, Vec3};
use photosite_core::spectrum::{Dispersion, SampledSpectrum};
use photosite_gpu::probe;
use photosite_transport::bsdf::{
    Bsdf, Coat, Conductor, CubeCorners, Dielectric, Diffuse, Ggx, Layered, OrenNayar, Phong, RelativeIndex,
    Retroreflective, Sheen, ThinDielectric, ThinFilm, Translucent, Volume,
};
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::packed::materials::model;

use crate::Numbers;
use crate::scenes::layers;
use crate::stage::{ball, glass, metal, with_all_bounces};

const TEXT: &str = "
fn answer(words: array<vec4<u32>, 13>) -> array<vec4<u32>, 5> {
    var f: array<vec4<f32>, 13>;
    for (var i = 0u; i < 13u; i += 1u) { f[i] = bitcast<vec4<f32>>(words[i]); }
    layers = Layers(
        f[7].x, f[7].y, f[7].z, (words[7].w & 1u) != 0u, f[8], f[6].z, f[9], f[6].w, f[5].z, f[10], (words[7].w & 2u) != 0u,
        f[11], f[5].w, (words[7].w & 4u) != 0u, f[6].x, f[6].y, f[12].xyz,
    );
    let bsdf = Bsdf(words[0].x, f[0].yz, f[1], f[2], (words[0].w & 1u) != 0u, (words[0].w & 2u) != 0u, false, vec2<f32>(f[4].w, f[12].w));
    view_bsdf(bsdf, f[3].xyz);
    let scattering = eval_bsdf(bsdf, f[3].xyz, f[4].xyz);
    let sample = sample_bsdf(bsdf, f[3].xyz, f[3].w, f[5].xy);
    let flags = select(0u, 1u, sample.is_delta) | select(0u, 2u, sample.is_transmission) | select(0u, 4u, sample.terminates_secondary)
        | select(0u, 8u, is_delta(bsdf)) | select(0u, 16u, has_lobes(bsdf)) | select(0u, 32u, transmits(bsdf))
        | select(0u, 64u, needs_single_wavelength(bsdf));
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
    is_compensated: bool,
    /// Index of cube corners, and their mean active part.
    corners: [f32; 2],
    layers: Layered,
}

/// A model without layers.
fn case(name: &'static str, bsdf: Bsdf, model: u32, roughness: [f32; 2], parameters: [SampledSpectrum; 2]) -> Case {
    Case {
        name,
        bsdf,
        model,
        roughness,
        parameters,
        is_dispersive: false,
        is_compensated: false,
        corners: [0.0; 2],
        layers: Layered::default(),
    }
}

fn cases() -> Vec<Case> {
    let (a, b) = (SampledSpectrum::from([0.2, 0.5, 0.7, 0.9]), SampledSpectrum::from([0.6, 0.3, 0.1, 0.05]));
    let (eta, k) = (SampledSpectrum::from([0.2, 0.9, 1.4, 0.05]), SampledSpectrum::from([3.1, 2.4, 1.9, 4.2]));
    let index = SampledSpectrum::from([1.52, 1.53, 1.55, 1.5]);
    let zero = SampledSpectrum::ZERO;
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
        let is_rough = x > 0.0;
        let metal = Conductor { eta, k, distribution, energy_compensation: false };
        let full = Conductor { energy_compensation: true, ..metal };
        let case_of_full = case("metal with all bounces", Bsdf::Conductor(full), model::CONDUCTOR, [x, y], [eta, k]);
        all.push(Case { is_compensated: is_rough, ..case_of_full });
        for (white, index) in [(b, 1.5), (SampledSpectrum::ZERO, 1.0)] {
            let corners = CubeCorners::new(index);
            let sheeting = Retroreflective { retroreflectance: a, reflectance: white, corners, distribution };
            let sheeting = Bsdf::Retroreflective(sheeting);
            let case = case("sheeting", sheeting, model::RETROREFLECTIVE, [x, y], [a, white]);
            all.push(Case { corners: corners.numbers(), ..case });
        }
        for (name, layers) in all_layers(a, b) {
            let layers = Layered { base_colour: a, f0: b, distribution, ..layers };
            let case = case(name, Bsdf::Layered(layers), model::LAYERED, [x, y], [a, b]);
            let is_dispersive = layers.volume.is_some_and(|volume| volume.dispersive);
            all.push(Case { layers, is_dispersive, ..case });
        }
        all.push(case("metal", Bsdf::Conductor(metal), model::CONDUCTOR, [x, y], [eta, k]));
        for (dispersive, eta) in
            [(false, SampledSpectrum::splat(1.5)), (true, index), (false, SampledSpectrum::splat(0.7))]
        {
            let index = RelativeIndex { eta, dispersive, is_one: false };
            let glass = Dielectric { index, distribution, energy_compensation: false };
            let case = case("glass", Bsdf::Dielectric(glass), model::DIELECTRIC, [x, y], [eta, zero]);
            all.push(Case { is_dispersive: dispersive, ..case });
            let full = Bsdf::Dielectric(Dielectric { energy_compensation: true, ..glass });
            let case_of_full = self::case("glass with all bounces", full, model::DIELECTRIC, [x, y], [eta, zero]);
            all.push(Case { is_dispersive: dispersive, is_compensated: is_rough, ..case_of_full });
        }
    }
    all
}

/// Directions seen and lit, and random numbers: of the lobe, then of the direction.
struct Draw([Vec3; 2], [f32; 3]);

impl Case {
    /// Words of a draw as the kernel takes them.
    fn words(&self, Draw([wo, wi], [u_lobe, u @ ..]): &Draw) -> [[u32; 4]; 13] {
        let ([index, sheen], more, [a, b, c, d, e, [x_coat, y_coat, z_coat, _]]) = layer_words(&self.layers);
        let [first, second] = self.parameters.map(|s| s.to_array().map(f32::to_bits));
        let [x, y] = self.roughness.map(f32::to_bits);
        [
            [self.model, x, y, u32::from(self.is_dispersive) | u32::from(self.is_compensated) << 1],
            first,
            second,
            [wo.x, wo.y, wo.z, *u_lobe].map(f32::to_bits),
            [wi.x, wi.y, wi.z, self.corners[0]].map(f32::to_bits),
            [u[0], u[1], index, sheen].map(f32::to_bits),
            more.map(f32::to_bits),
            a,
            b,
            c,
            d,
            e,
            [x_coat, y_coat, z_coat, self.corners[1].to_bits()],
        ]
    }
}

/// glTF's material with each of its extensions, and with several.
fn all_layers(a: SampledSpectrum, b: SampledSpectrum) -> Vec<(&'static str, Layered)> {
    let plain = Layered::default();
    let of_metal = |metallic, specular| Layered { metallic, specular, ..plain };
    let volume = |eta: SampledSpectrum, dispersive| Some(Volume { eta, dispersive });
    let (even, spread) = (SampledSpectrum::splat(1.5), SampledSpectrum::from([1.52, 1.53, 1.55, 1.5]));
    let film = Some(ThinFilm { weight: 0.8, index: 1.3, waves: SampledSpectrum::from([1.7, 2.1, 2.6, 3.4]) });
    let sheen = |alpha| Some(Sheen { colour: b, alpha });
    let coat = |alpha, normal: Vec3| Some(Coat { weight: 0.7, distribution: Ggx::new(alpha, alpha), normal });
    let tilted = Vec3::new(0.2, -0.1, 0.9).normalize();
    let thin = Layered { transmission: 0.7, ..plain };
    let glass = Layered { transmission: 0.6, volume: volume(even, false), ..plain };
    let curtain = Layered { diffuse_transmission: 0.4, diffuse_transmission_colour: a, ..plain };
    vec![
        ("layers", plain),
        ("half a metal", of_metal(0.4, 0.7)),
        ("a metal", of_metal(1.0, 1.0)),
        ("a thin pane", thin),
        ("a thin pane with a film", Layered { film, ..thin }),
        ("a volume", glass),
        ("a volume of no index", Layered { transmission: 1.0, volume: volume(SampledSpectrum::ONE, false), ..plain }),
        ("a dispersive volume", Layered { transmission: 1.0, volume: volume(spread, true), ..plain }),
        ("a volume with a film", Layered { film, ..glass }),
        ("a curtain", curtain),
        ("a film", Layered { film, ..plain }),
        ("a film on metal", Layered { film, ..of_metal(0.8, 1.0) }),
        ("sheen", Layered { sheen: sheen(0.2), ..plain }),
        ("sheen of a narrow rim", Layered { sheen: sheen(0.03), ..plain }),
        ("a coat", Layered { coat: coat(0.3, Vec3::Z), ..of_metal(0.5, 0.9) }),
        ("a tilted coat", Layered { coat: coat(0.4, tilted), ..plain }),
        ("varnish", Layered { coat: coat(0.0, Vec3::Z), ..of_metal(1.0, 1.0) }),
        ("all on a curtain", Layered { film, sheen: sheen(0.3), coat: coat(0.2, tilted), ..curtain }),
        ("all on a volume", Layered { film, sheen: sheen(0.3), coat: coat(0.2, tilted), metallic: 0.2, ..glass }),
    ]
}

/// Words of layers in the order in which the kernel takes them, the coat's and the film's beside other numbers.
fn layer_words(layers: &Layered) -> ([f32; 2], [f32; 4], [[u32; 4]; 6]) {
    let Layered { metallic, specular, transmission, volume, diffuse_transmission, film, sheen, coat, .. } = *layers;
    let flags = [volume.is_some(), sheen.is_some(), coat.is_some()];
    let flags = (0..3).map(|i| u32::from(flags[i]) << i).sum();
    let bits = |s: SampledSpectrum| s.to_array().map(f32::to_bits);
    let (zero, one) = (SampledSpectrum::ZERO, SampledSpectrum::ONE);
    let normal = coat.map_or(Vec3::Z, |coat| coat.normal);
    let [coat_weight, coat_alpha] = coat.map_or([0.0; 2], |coat| [coat.weight, coat.distribution.alpha()[0]]);
    (
        [film.map_or(1.0, |film| film.index), sheen.map_or(0.0, |sheen| sheen.alpha)],
        [coat_weight, coat_alpha, diffuse_transmission, film.map_or(0.0, |film| film.weight)],
        [
            [metallic.to_bits(), specular.to_bits(), transmission.to_bits(), flags],
            bits(volume.map_or(one, |volume| volume.eta)),
            bits(layers.diffuse_transmission_colour),
            bits(film.map_or(zero, |film| film.waves)),
            bits(sheen.map_or(zero, |sheen| sheen.colour)),
            [normal.x, normal.y, normal.z, 0.0].map(f32::to_bits),
        ],
    )
}

/// Whether two numbers differ by no more than a part, or a part of one.
fn near(found: f32, expected: f32, part: f32, floor: f32) -> bool {
    (found - expected).abs() <= part * expected.abs().max(floor)
}

#[test]
fn models_scatter_as_on_the_processor() {
    let Some(card) = crate::card() else { return };
    // Its tables hold all albedos.
    let [metal, glass] = [metal("Cu", 0.5), glass(Dispersion::constant(1.5), 0.5)].map(with_all_bounces);
    let (ball, still) = (|| ball(4, 0.0, true), [DAffine3::IDENTITY]);
    let scene = layers().add("metal", metal, ball(), &still).add("glass", glass, ball(), &still);
    let scene = scene.build().packed().expect("a scene that cards render");
    let mut numbers = Numbers(11);
    let mut draw = || {
        let draws =
            (0..2048).map(|_| Draw([numbers.direction(), numbers.direction()], [(); 3].map(|()| numbers.next())));
        // Near the horizon and where lobes are narrow one rounding is many parts of the value.
        draws.filter(|Draw(directions, _)| directions.iter().all(|w| w.z.abs() > 0.05)).collect()
    };
    let cases: Vec<(Case, Vec<Draw>)> = cases().into_iter().map(|case| (case, draw())).collect();
    let inputs: Vec<[[u32; 4]; 13]> =
        cases.iter().flat_map(|(case, draws)| draws.iter().map(|draw| case.words(draw))).collect();
    let found = probe::answers::<13, 5>(card, &scene, SamplerKind::Sobol, TEXT, &inputs).expect("a kernel that runs");
    let mut found = found.into_iter();
    for (Case { name, bsdf, roughness: [x, y], layers, .. }, draws) in cases {
        let narrowest = x.min(y).max(1e-3);
        // Facets amplify the rounding of directions by one over their roughness.
        let part = if x > 0.0 { 3e-6 / (narrowest * narrowest) } else { 2e-5 };
        // The facet of a refraction is as uncertain as one over |η − 1|, and more where both directions graze it; films
        // amplify the rounding of cosines by the waves that they hold back.
        let part = if name.starts_with("glass") || layers.volume.is_some() || layers.film.is_some() {
            5.0 * part
        } else {
            part
        };
        let mut flipped = 0;
        for (Draw([wo, wi], [u_lobe, u @ ..]), words) in draws.iter().zip(found.by_ref()) {
            let [f, pdfs, sample_f, sample_wi, [flags, ..]] = words;
            let [f, pdfs, sample_f, sample_wi] = [f, pdfs, sample_f, sample_wi].map(|word| word.map(f32::from_bits));
            let at = format!("{name} {x} {y}: {wo} {wi} {u_lobe} {u:?}");
            let expected = bsdf.eval(*wo, *wi);
            assert!(near(pdfs[0], expected.pdf.0, part, 1e-2), "{at}: density {} for {}", pdfs[0], expected.pdf.0);
            for (found, expected) in f.iter().zip(expected.f.to_array()) {
                assert!(near(*found, expected, part, 1e-2), "{at}: {found} for {expected}");
            }
            let traits = [bsdf.is_delta(), bsdf.has_lobes(), bsdf.transmits(), bsdf.needs_single_wavelength()];
            assert_eq!(traits, [8, 16, 32, 64].map(|bit| flags & bit != 0), "{at}");
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
            // With the cosine: a tilted coat's value grows without end towards the horizon.
            for (found, expected) in sample_f.iter().zip(sample.f.to_array()) {
                let [found, expected] = [found * sample_wi[2].abs(), expected * sample.wi.z.abs()];
                assert!(near(found, expected, 10.0 * part, 1e-2), "{at}: {found} for {expected}");
            }
        }
        assert!(flipped <= 2, "{name} {x} {y}: {flipped} of {} draws go another way", draws.len());
    }
}
