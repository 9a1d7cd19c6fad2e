//! Pixels that share what lies beyond their first surfaces: the same light as without, and less noise.

use glam::Vec3;
use photosite::film::Film;
use photosite::integrator::RenderSettings;
use photosite::optics::{Focus, LensDescription, LensKind};
use photosite::scene::description::{
    AlphaMode, Dielectric, Diffuse, LayeredDescription, MaterialModel, Mix, Roughness, TexturedFactor,
};
use photosite::spectrum::Dispersion;

use crate::light_paths::{RESOLUTION, compare, glass, gold, grey, image, lens, room};
use crate::stage::{Stage, sphere, square};

fn settings(reuse: u32) -> RenderSettings {
    RenderSettings { reuse, ..RenderSettings::default() }
}

fn diffuse(reflectance: f32) -> MaterialModel {
    MaterialModel::Diffuse(Diffuse { reflectance: grey(reflectance) })
}

/// A ball on a floor beside a wall, under the sky.
fn outdoors(ball: MaterialModel) -> Stage {
    let lifted = sphere(10, 0.5).into_iter().map(|t| t.map(|corner| corner + Vec3::new(0.1, -0.5, -0.6)));
    Stage::default()
        .diffuse(square(Vec3::new(0.0, -1.0, 0.0), Vec3::Z, Vec3::X, 4.0), 0.6, 0.0)
        .diffuse(square(Vec3::new(-0.8, 0.0, -1.0), Vec3::Z, Vec3::NEG_Y, 1.0), 0.8, 0.0)
        .mesh(lifted.collect(), ball, None)
}

#[test]
fn neighbours_that_are_close_share_nearly_all() {
    // Pixels of 2 cm on a wall, eight in a group: of light off other surfaces an eighth of the variance is left, but
    // all of the lamp's, which has some two fifths of it.
    let close = LensDescription { kind: LensKind::Pinhole, ..LensDescription::thin(0.3, 4.0, Focus::Infinity) };
    let gain = compare("close", &room(diffuse(0.7)).build(), &close, settings(8));
    assert!(gain > 2.0, "{gain}");
}

#[test]
fn light_is_the_same_where_pixels_share_and_often_quieter() {
    // By how much the variance falls at least, in groups that are half a metre wide or more, as pixels here are: as
    // measured, to notice when sharing becomes worse. `None` where it may rise: under an even sky all directions of a
    // path bring the same, which sharing tears apart, and groups that see different surfaces find little for each
    // other.
    let mix = MaterialModel::Mix(Box::new(Mix { models: [diffuse(0.9), gold(0.1)], weight: 0.3 }));
    let dull = MaterialModel::Layered(Box::new(LayeredDescription {
        roughness: TexturedFactor::plain(0.8),
        base_colour: grey(0.7),
        ..LayeredDescription::default()
    }));
    let pane = MaterialModel::Dielectric(Dielectric {
        index: Dispersion::constant(1.5),
        distribution: Roughness::SMOOTH,
        energy_compensation: false,
    });
    let open = LensDescription::thin(0.01, 0.2, Focus::Distance(1.1));
    let cases = [
        ("diffuse", room(diffuse(0.7)), lens(), settings(8), Some(1.2)),
        ("groups cut by an edge", room(diffuse(0.7)), lens(), settings(3), Some(1.1)),
        ("groups cut by both edges", room(diffuse(0.7)), lens(), settings(35), Some(1.1)),
        ("out of focus", room(diffuse(0.7)), open, settings(8), None),
        ("splitting", room(diffuse(0.7)), lens(), RenderSettings { splitting: Some(3), ..settings(4) }, Some(1.0)),
        ("black", room(diffuse(0.0)), lens(), settings(8), Some(1.0)),
        ("metal", room(gold(0.2)), lens(), settings(8), Some(1.3)),
        ("glass", room(glass(0.0)), lens(), settings(8), None),
        ("mix", room(mix), lens(), settings(8), Some(1.2)),
        ("layers", room(dull), lens(), settings(8), Some(1.1)),
        ("holes", room(diffuse(0.7)).alpha(AlphaMode::Blend, 0.5), lens(), settings(8), Some(1.0)),
        ("early roulette", room(diffuse(0.7)), lens(), RenderSettings { roulette_depth: 1, ..settings(8) }, Some(2.0)),
        ("two segments", room(diffuse(0.7)), lens(), RenderSettings { max_depth: 2, ..settings(8) }, Some(1.1)),
        ("even sky", outdoors(diffuse(0.7)).environment(1.0), lens(), settings(8), None),
        ("glass under the sky", outdoors(pane).environment(1.0), lens(), settings(8), None),
    ];
    for (name, stage, lens, settings, least) in cases {
        let gain = compare(name, &stage.build(), &lens, settings);
        assert!(least.is_none_or(|least| gain > least), "{name}: {gain}");
    }
}

#[test]
fn pixels_share_with_their_own_group_alone() {
    // Some pixels have some of their samples already, so that groups of one wave have unlike numbers of paths.
    let scene = room(diffuse(0.7)).build();
    let pixels = (RESOLUTION[0] * RESOLUTION[1]) as usize;
    let is_ahead = |pixel: usize| pixel % RESOLUTION[0] as usize % 4 < 2;
    let ahead = |film: &mut Film| film.add([], (0..pixels).map(|pixel| if is_ahead(pixel) { 13 } else { 0 }));
    // One beside the other, and two above two.
    for reuse in [2, 4] {
        let [whole, rest] = [false, true].map(|some| {
            let estimate = image(&scene, &lens(), settings(reuse), |film| {
                if some {
                    ahead(film)
                }
            });
            estimate.mean.channels().to_vec()
        });
        for (whole, rest) in whole.iter().zip(&rest) {
            for pixel in (0..pixels).filter(|&pixel| !is_ahead(pixel)) {
                assert_eq!(whole.data[pixel], rest.data[pixel], "{reuse}, {pixel}");
            }
        }
    }
}
