//! Poses of what moves are those of the processor.

use glam::Affine3A;
use photosite_gpu::probe;
use photosite_transport::geometry::Motion;
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::packed::hierarchy::INSTANCE_WORDS;

use crate::scenes::ways;
use crate::stage::{Stage, ball, diffuse};

const TEXT: &str = "
fn answer(words: array<vec4<u32>, 1>) -> array<vec4<u32>, 6> {
    let transform = transform_at(params.instances, bitcast<f32>(words[0].x));
    return array<vec4<u32>, 6>(
        bitcast<vec4<u32>>(transform.x),
        bitcast<vec4<u32>>(transform.y),
        bitcast<vec4<u32>>(transform.z),
        bitcast<vec4<u32>>(transform.x_object),
        bitcast<vec4<u32>>(transform.y_object),
        bitcast<vec4<u32>>(transform.z_object),
    );
}";

#[test]
fn poses_are_those_of_the_processor() {
    let Some(card) = crate::card() else { return };
    let times: Vec<f32> = (0..=1000u16).map(|i| f32::from(i) / 1000.0).collect();
    let inputs: Vec<_> = times.iter().map(|time| [[time.to_bits(), 0, 0, 0]]).collect();
    for (way, poses) in ways().iter().enumerate() {
        let stage =
            Stage::default().add("thing", diffuse([0.5; 3]), ball(4, 0.0, false), &poses[..1]).then(&poses[1..]);
        let packed = stage.build().packed().expect("a scene that cards render");
        assert_eq!(packed.sections.instances as usize + INSTANCE_WORDS, packed.sections.quadrics as usize);
        let found =
            probe::answers::<1, 6>(card, &packed, SamplerKind::Sobol, TEXT, &inputs).expect("a kernel that runs");
        let motion = Motion::new(poses);
        let mut largest = [0.0f32; 2];
        for (time, rows) in times.iter().zip(found) {
            let expected = motion.at(*time);
            for (side, transform) in [expected.to_world, expected.to_object].into_iter().enumerate() {
                let numbers = |transform: &Affine3A| transform.to_cols_array();
                let size = numbers(&transform).into_iter().fold(0.0f32, |size, number| size.max(number.abs()));
                for (i, expected) in numbers(&transform).into_iter().enumerate() {
                    let found = f32::from_bits(rows[3 * side + i % 3][i / 3]);
                    largest[side] = largest[side].max((found - expected).abs() / size);
                }
            }
        }
        println!("way {way}: off by {largest:?} of the largest number");
        assert!(largest.iter().all(|off| *off < 8.0 * f32::EPSILON), "way {way}: {largest:?}");
    }
}
