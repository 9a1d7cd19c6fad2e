//! Memory that an instance takes: a scene of many is compared with one of few, by an allocator that counts.

use std::alloc::System;
use std::sync::Arc;

use cap::Cap;
use glam::{DAffine3, DVec3, Vec3};
use photosite_core::spectrum::Spectrum;
use photosite_transport::scene::description::{
    Colour, Diffuse, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription, ObjectDescription,
    SceneDescription, TexturedColour,
};
use photosite_transport::scene::{Scene, build};

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Objects of one file with six meshes, as a helmet of leather, glass, wood, metal and so on has.
fn scene(count: usize) -> Scene {
    const PARTS: usize = 6;
    let reflectance = TexturedColour::plain(Colour::Rgb([0.5; 3]));
    let mesh = |part: usize| {
        let corner = |i: u32| Vec3::new((i % 50) as f32, (i / 50) as f32, part as f32) * 0.01;
        let square = |i: u32| [[i, i + 1, i + 50], [i + 1, i + 51, i + 50]];
        let triangles = (0..49 * 50).filter(|i| i % 50 < 49).flat_map(square).collect();
        Arc::new(MeshDescription {
            positions: (0..2500).map(corner).collect(),
            triangles,
            ..MeshDescription::default()
        })
    };
    let to_world = |i: usize| DAffine3::from_translation(DVec3::new((i % 100) as f64, (i / 100) as f64, 0.0));
    let instance = |i| InstanceDescription {
        meshes: 0..PARTS,
        is_movable: true,
        ..InstanceDescription::of_mesh("helmet", 0, to_world(i))
    };
    let object = |i| ObjectDescription {
        name: format!("helmet-{i}"),
        category: None,
        to_world: to_world(i),
        later: Vec::new(),
        keypoints: Vec::new(),
        instances: i..i + 1,
    };
    let description = SceneDescription {
        materials: vec![MaterialDescription::new("all", MaterialModel::Diffuse(Diffuse { reflectance }))],
        meshes: (0..PARTS).map(mesh).collect(),
        instances: (0..count).map(instance).collect(),
        objects: (0..count).map(object).collect(),
        ..SceneDescription::default()
    };
    build(description, &Spectrum::constant(1.0))
}

/// Memory that a scene takes once it is built, bytes.
fn bytes(count: usize) -> usize {
    let before = ALLOCATOR.allocated();
    let scene = scene(count);
    let bytes = ALLOCATOR.allocated() - before;
    drop(scene);
    bytes
}

#[test]
fn an_instance_takes_at_most_200_bytes() {
    // What is made once for the process, such as tables and threads, is there after the first.
    bytes(2);
    let one = bytes(1);
    for count in [501, 5001] {
        let each = (bytes(count) - one) as f64 / (count - 1) as f64;
        println!("{count} instances: {one} bytes of one, {each:.0} more of each");
        assert!(each <= 200.0, "{count} instances: {each} bytes each");
    }
    // Six meshes of 2,401 squares each are far more than that.
    assert!(one > 6 * 2401 * 2 * 12, "{one}");
}
