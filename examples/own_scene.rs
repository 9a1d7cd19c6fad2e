//! A scene that no file holds: a red sphere on a grey floor under a clear sky.
//!
//! `cargo run --release --example own_scene`

use glam::{DAffine3, DVec3, Vec3};
use photosite::geometry::QuadricKind;
use photosite::keys::{
    CameraKeys, CaptureKeys, EnvironmentKeys, LensKeys, RenderKeys, SceneKeys, SensorKeys, SensorTableKeys,
};
use photosite::scene::description::{
    Colour, Diffuse, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription, SceneDescription,
    TexturedColour,
};
use photosite::{Capture, Options, render};

/// All but the geometry.
fn keys() -> CaptureKeys {
    Capture::builder()
        .scene(SceneKeys::new().environment(EnvironmentKeys::new().illuminant("D65").illuminance_lux(10000.0)))
        .camera(CameraKeys::new().position_m([0.0, 1.2, 4.0]).look_at_m([0.0, 0.5, 0.0]))
        .lens(LensKeys::new().focal_length_mm(3.0).f_number(4.0).focus_distance_m(3.5))
        .sensor(SensorKeys::new().preset("generic-cmos-color").resolution_px([320, 240]))
        .render(RenderKeys::new().samples_per_pixel(64))
}

fn main() -> photosite::Result<()> {
    let matt = |name: &str, rgb: [f32; 3]| {
        let reflectance = TexturedColour::plain(Colour::Rgb(rgb));
        MaterialDescription::new(name, MaterialModel::Diffuse(Diffuse { reflectance }))
    };
    let corners = [[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [3.0, 0.0, -3.0], [-3.0, 0.0, -3.0]];
    let floor = MeshDescription {
        name: "floor".to_owned(),
        material: 0,
        positions: corners.map(Vec3::from_array).to_vec(),
        normals: vec![Vec3::Y; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshDescription::default()
    };
    let half_metre =
        DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), glam::DQuat::IDENTITY, DVec3::new(0.0, 0.5, 0.0));
    let sphere = MeshDescription::of_quadric(QuadricKind::Sphere, "sphere".to_owned(), 1);
    let scene = SceneDescription {
        materials: vec![matt("grey", [0.5; 3]), matt("red", [0.6, 0.05, 0.05])],
        meshes: vec![floor.into(), sphere.into()],
        instances: vec![
            InstanceDescription::of_mesh("floor", 0, DAffine3::IDENTITY),
            InstanceDescription::of_mesh("sphere", 1, half_metre),
        ],
        ..SceneDescription::default()
    };

    let capture = Capture::of_scene(scene, &keys())?;
    let shot = render(&capture, Options::default())?;
    photosite::save_raw(&shot.raw, "own-scene.dng")?;
    shot.develop(capture.develop())?.save("own-scene.png")?;
    println!("exposed for {:.3} ms", shot.exposure.time.0 * 1e3);
    Ok(())
}
