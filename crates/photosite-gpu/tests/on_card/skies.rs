//! Radiance, samples and densities of skies against those of the processor.

use glam::{DVec3, Vec3};
use photosite_core::spectrum::Wavelengths;
use photosite_gpu::probe;
use photosite_transport::light::SkyConditions;
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::description::EnvironmentDescription;

use crate::Numbers;
use crate::stage::Stage;

const TEXT: &str = "
fn answer(words: array<vec4<u32>, 3>) -> array<vec4<u32>, 3> {
    let towards = bitcast<vec4<f32>>(words[0]);
    let radiance = environment_radiance(towards.xyz, bitcast<vec4<f32>>(words[1]));
    let sample = sample_environment(bitcast<vec2<f32>>(words[2].xy));
    return array<vec4<u32>, 3>(
        bitcast<vec4<u32>>(radiance),
        bitcast<vec4<u32>>(sample),
        bitcast<vec4<u32>>(vec4<f32>(density_of_environment(towards.xyz), 0.0, 0.0, 0.0)),
    );
}";

/// A sky with the sun at an elevation.
pub(crate) fn sky(turbidity: f64, elevation_deg: f64, ground_albedo: f64, has_sun: bool) -> EnvironmentDescription {
    let (sin, cos) = elevation_deg.to_radians().sin_cos();
    let towards_sun = DVec3::new(0.6 * cos, sin, 0.8 * cos);
    EnvironmentDescription::Sky(SkyConditions { towards_sun, turbidity, ground_albedo, has_sun })
}

#[test]
fn skies_shine_and_are_sampled_as_on_the_processor() {
    let Some(card) = crate::card() else { return };
    for (turbidity, elevation, albedo, has_sun) in
        [(2.0, 60.0, 0.0, false), (3.7, 25.0, 0.3, true), (9.0, 3.0, 1.0, true), (1.0, 90.0, 0.8, true)]
    {
        let scene = Stage::default().environment(sky(turbidity, elevation, albedo, has_sun)).build();
        let environment = scene.lights().environment().expect("a sky");
        let mut numbers = Numbers(29);
        let draws: Vec<(Vec3, [f32; 4], [f32; 2])> = (0..1 << 14)
            .map(|i| {
                let u = [numbers.next(), numbers.next()];
                // From all around, and from where the sky is sampled: the sun.
                let all_around = numbers.direction();
                let sampled = environment.sample([numbers.next(), numbers.next()]).map(|(towards, _)| towards);
                let towards = if i % 2 == 0 { all_around } else { sampled.unwrap_or(all_around) };
                // Beyond the wavelengths of the model as well.
                (towards, [(); 4].map(|()| 310.0 + 700.0 * numbers.next()), u)
            })
            .collect();
        let inputs: Vec<[[u32; 4]; 3]> = draws
            .iter()
            .map(|(towards, lambda_nm, [u, v])| {
                let towards = [towards.x, towards.y, towards.z, 0.0];
                [towards, *lambda_nm, [*u, *v, 0.0, 0.0]].map(|word| word.map(f32::to_bits))
            })
            .collect();
        let packed = scene.packed().expect("a sky that cards know");
        let found =
            probe::answers::<3, 3>(card, &packed, SamplerKind::Sobol, TEXT, &inputs).expect("a kernel that runs");
        let near = |found: f32, expected: f32| (found - expected).abs() <= 1e-5 * expected.abs().max(1e-6);
        let mut elsewhere = [0; 3];
        for ((towards, lambda_nm, u), words) in draws.iter().zip(found) {
            let [radiance, [x, y, z, density_of_sample], [density, ..]] = words.map(|word| word.map(f32::from_bits));
            let wavelengths = Wavelengths::new(*lambda_nm, [1.0; 4]);
            let expected = scene.environment_radiance(*towards, &wavelengths).to_array();
            elsewhere[0] += usize::from(!radiance.iter().zip(expected).all(|(found, expected)| near(*found, expected)));
            elsewhere[1] += usize::from(!near(density, environment.pdf(*towards).0));
            let is_same = match environment.sample(*u) {
                Some((expected, pdf)) => {
                    (Vec3::new(x, y, z) - expected).length() < 2e-5 && near(density_of_sample, pdf.0)
                }
                None => density_of_sample == 0.0,
            };
            elsewhere[2] += usize::from(!is_same);
        }
        println!("turbidity {turbidity}, {elevation}°: {elsewhere:?} of {} differ", draws.len());
        // At the edge of the sun, a part in 180 of which is as wide as the rounding of its cosine, and at the edges of
        // the distribution's cells.
        assert!(elsewhere.iter().all(|count| count * 150 <= draws.len()), "{elsewhere:?}");
    }
}
