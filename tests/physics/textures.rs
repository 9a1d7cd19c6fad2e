//! Textures that are far away.

use std::sync::Arc;

use glam::{DAffine3, Vec2, Vec3};
use photosite::integrator::RenderSettings;
use photosite::optics::{Falloff, Focus, LensDescription, LensKind, PixelGrid};
use photosite::scene::description::{
    Colour, Diffuse, EmissionDescription, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription,
    SceneDescription, TextureDescription, TexturedColour,
};
use photosite::scene::{Scene, build};
use photosite::spectrum::Spectrum;
use photosite::texture::{Bitmap, Filter, SamplerSettings, Texels, UvTransform, Wrap};
use rstest::rstest;

use crate::stage::{camera, irradiance};

const RESOLUTION: [u32; 2] = [12, 12];
const SAMPLES: u32 = 256;

/// A bright wall under a board of these four squares, which repeat every 5 cm, seen at 70° from 10 m.
fn wall(squares: [u8; 4], filter: Filter) -> Scene {
    let texels = Texels::Rgba8(squares.map(|v| [v, v, v, 255]).to_vec());
    let board = Bitmap { name: "board".into(), width: 2, height: 2, texels };
    let texture = TextureDescription {
        image: 0,
        sampler: SamplerSettings { wrap: [Wrap::Repeat; 2], filter },
        transform: UvTransform::default(),
        uv_set: 0,
    };
    let black = MaterialModel::Diffuse(Diffuse {
        reflectance: TexturedColour::plain(Colour::Spectrum(Spectrum::constant(0.0))),
    });
    let emission = EmissionDescription { colour: Colour::Rgb([1.0; 3]), level: Some(1000.0), texture: Some(texture) };
    let material = MaterialDescription { emission: Some(emission), ..MaterialDescription::new("wall", black) };
    let (sin, cos) = 70f32.to_radians().sin_cos();
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0f32]].map(|c| c.map(|x| 20.0 * x));
    let place = |[x, y]: [f32; 2]| Vec3::new(x, y * cos, -10.0 - y * sin);
    let mesh = MeshDescription {
        positions: corners.map(place).to_vec(),
        uvs: vec![corners.map(|c| Vec2::from_array(c) / 0.05).to_vec()],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshDescription::default()
    };
    let instance = InstanceDescription::of_mesh("", 0, DAffine3::IDENTITY);
    let description = SceneDescription {
        images: vec![Arc::new(board)],
        materials: vec![material],
        meshes: vec![mesh.into()],
        instances: vec![instance],
        ..SceneDescription::default()
    };
    build(description, &Spectrum::constant(1.0))
}

/// Paths pass pixels at places spread over all of their area, and so integrate what a pixel sees of a texture without
/// maps of several sizes: the mean of a board much finer than pixels is that of its squares, exactly where mip maps
/// would blur more than a pixel or shimmer.
#[rstest]
#[case::nearest(Filter::Nearest)]
#[case::bilinear(Filter::Linear)]
fn what_is_finer_than_a_pixel_is_seen_as_its_mean(#[case] filter: Filter) {
    let mut lens = LensDescription::thin(10e-3, 8.0, Focus::Infinity);
    (lens.kind, lens.falloff) = (LensKind::Pinhole, Falloff::None);
    // 6 periods of the board in a pixel across, more along; nothing beyond the wall is in the image.
    let grid = PixelGrid { resolution: RESOLUTION, pitch_m: [0.3e-3; 2] };
    let settings = RenderSettings { samples_per_pixel: SAMPLES, max_depth: 1, seed: 3, ..RenderSettings::default() };
    let camera = camera(&lens, &grid, DAffine3::IDENTITY);
    let values = |squares| {
        let estimate = irradiance(&wall(squares, filter), &camera, RESOLUTION, &settings);
        estimate.mean.channels()[0].data.iter().map(|&v| f64::from(v)).collect::<Vec<_>>()
    };
    let (board, white) = (values([255, 0, 0, 255]), values([255; 4]));
    let ratios: Vec<f64> = board.iter().zip(&white).map(|(board, white)| board / white).collect();
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    // Were samples independent, a pixel would have a standard deviation of 0.5/√256, and the mean of 144 a twelfth of
    // it. The white wall has the same places and wavelengths, so these cancel. 5 σ.
    let sigma = 0.5 / f64::from(SAMPLES).sqrt();
    assert!((mean - 0.5).abs() < 5.0 * sigma / 12.0, "{mean}");
    assert!(ratios.iter().all(|ratio| (ratio - 0.5).abs() < 5.0 * sigma), "{ratios:?}");
}
