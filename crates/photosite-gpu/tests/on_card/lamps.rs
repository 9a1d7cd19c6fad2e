//! Samples of lights without a surface against those of the processor.

use glam::Vec3;
use photosite_core::spectrum::Wavelengths;
use photosite_gpu::probe;
use photosite_transport::light::{Facing, LightSampleContext, PointLight, SpotLight};
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::description::LightKind;

use crate::Numbers;
use crate::scenes::lamps;
use crate::stage::{Stage, placed};

const TEXT: &str = "
fn answer(words: array<vec4<u32>, 3>) -> array<vec4<u32>, 3> {
    let place = bitcast<vec4<f32>>(words[0]);
    let normal = bitcast<vec4<f32>>(words[1]);
    let ctx = LightContext(place.xyz, normal.xyz, true);
    let choice = choose_light(ctx, place.w);
    if (choice.light == NONE) {
        return array<vec4<u32>, 3>(vec4<u32>(0u), vec4<u32>(0u), vec4<u32>(0u));
    }
    let sample = sample_chosen(choice, normal.w, ctx, 0.0, bitcast<vec4<f32>>(words[2]));
    return array<vec4<u32>, 3>(
        bitcast<vec4<u32>>(sample.radiance),
        bitcast<vec4<u32>>(vec4<f32>(sample.wi, sample.pdf)),
        bitcast<vec4<u32>>(vec4<f32>(sample.position, select(0.0, 1.0, sample.is_delta))),
    );
}";

#[test]
fn lamps_shine_as_on_the_processor() {
    let Some(card) = crate::card() else { return };
    let mut all = lamps();
    all.push((LightKind::Point(PointLight), placed([0.3, 1.6, 0.2], 1.0), 50.0));
    all.push((LightKind::Spot(SpotLight::new(0.2, 0.9)), placed([0.3, 1.6, 0.2], 1.0), 50.0));
    for (number, (kind, to_world, level)) in all.into_iter().enumerate() {
        let name = kind.name();
        let scene = Stage::default().lamp(kind, to_world, level).build();
        let mut numbers = Numbers(41);
        let draws: Vec<(Vec3, Vec3, [f32; 2], [f32; 4])> = (0..1 << 14)
            .map(|i| {
                // Half of the points are where the light shines to.
                let around = numbers.direction();
                let [x, y, z] = [(); 3].map(|()| numbers.next());
                let ahead = Vec3::new(0.9 * x - 0.45, 0.9 * y - 0.45, -0.2 - 1.5 * z);
                let point = if i % 2 == 0 { (2.0 * around).as_dvec3() } else { ahead.as_dvec3() };
                let lambda_nm = [(); 4].map(|()| 400.0 + 300.0 * numbers.next());
                let point = to_world.transform_point3(point).as_vec3();
                (point, numbers.direction(), [numbers.next(), numbers.next()], lambda_nm)
            })
            .collect();
        let inputs: Vec<[[u32; 4]; 3]> = draws
            .iter()
            .map(|(point, normal, [u, v], lambda_nm)| {
                let words = [[point.x, point.y, point.z, *u], [normal.x, normal.y, normal.z, *v], *lambda_nm];
                words.map(|word| word.map(f32::to_bits))
            })
            .collect();
        let packed = scene.packed().expect("a lamp that cards know");
        let found =
            probe::answers::<3, 3>(card, &packed, SamplerKind::Sobol, TEXT, &inputs).expect("a kernel that runs");
        let (mut lit, mut elsewhere, mut farthest) = (0, 0, 0.0f32);
        for ((point, normal, u, lambda_nm), words) in draws.iter().zip(found) {
            let [radiance, [x, y, z, pdf], [px, py, pz, is_delta]] = words.map(|word| word.map(f32::from_bits));
            let ctx = LightSampleContext { point: *point, facing: Facing::Both(*normal) };
            let wavelengths = Wavelengths::new(*lambda_nm, [1.0; 4]);
            let Some(expected) = scene.sample_light(&ctx, 0.0, *u, &wavelengths) else {
                elsewhere += usize::from(pdf != 0.0);
                continue;
            };
            lit += 1;
            let (place, _) = expected.position.expect("a light that is somewhere");
            let is_there = pdf == expected.pdf.0
                && is_delta == 1.0
                && (Vec3::new(x, y, z) - expected.wi).length() < 2e-6
                && (Vec3::new(px, py, pz) - place).length() < 2e-6;
            let apart = radiance
                .iter()
                .zip(expected.radiance.to_array())
                .map(|(found, expected)| (found - expected).abs() / expected.abs().max(1e-6))
                .fold(0.0, f32::max);
            if is_there && apart < 1e-4 {
                farthest = farthest.max(apart);
            } else {
                elsewhere += 1;
            }
        }
        println!("{number} {name}: {lit} of {} lit, {elsewhere} differ, others by {farthest:e}", draws.len());
        // At the edges of a slide's texels and where a light ends.
        assert!(lit * 20 > draws.len() && elsewhere * 2000 <= draws.len(), "{name}: {lit}, {elsewhere}");
    }
}
