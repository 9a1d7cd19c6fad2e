//! Scenes with everything that cards render.

use std::f32::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3, Vec4};
use photosite_core::spectrum::{Dispersion, Spectrum, library};
use photosite_transport::geometry::QuadricKind;
use photosite_transport::light::{DirectionalLight, GaussianBeam, PointLight, Profile, Projector, SpotLight};
use photosite_transport::scene::description::{
    AlphaMode, AnisotropyDescription, Channel, CoatDescription, Colour, Diffuse, EmissionDescription,
    EnvironmentDescription, FilmDescription, ImageLevel, LayeredDescription, LightKind, MaterialModel, MeshDescription,
    Mix, OrenNayar, Phong, ShapeDescription, TextureDescription, TexturedColour, TexturedFactor, ThinDielectric,
    Translucent,
};
use photosite_transport::texture::{Filter, SamplerSettings, Texels, UvTransform, Wrap};

use crate::skies::sky;
use crate::stage::*;

/// A room with a floor of squares, under a sky of an image: triangles, instances, quadrics, textures, all kinds of
/// materials and of lights.
pub(crate) fn everything() -> Stage {
    let mut scene = Stage::default();
    let checker = (0..64u32).map(|i| if (i % 8 + i / 8) % 2 == 0 { [200, 120, 60, 255] } else { [40, 90, 190, 255] });
    scene.0.images.push(bitmap(8, 8, Texels::Rgba8(checker.collect())));
    let deep = (0..16u16).map(|i| [4000 * i, 65535 - 3000 * i, 30000, 65535]);
    scene.0.images.push(bitmap(4, 4, Texels::Rgba16(deep.collect())));
    let lattice = (0..64u8).map(|i| [200, 200, 60, if i % 4 == 0 || i / 8 % 4 == 0 { 250 } else { 3 * i }]);
    scene.0.images.push(bitmap(8, 8, Texels::Rgba8(lattice.collect())));
    let texture = |image: usize, wrap: Wrap, filter: Filter| TextureDescription {
        image,
        sampler: SamplerSettings { wrap: [wrap, Wrap::Repeat], filter },
        transform: UvTransform { scale: Vec2::new(2.5, 1.5), rotation_rad: 0.3, ..UvTransform::default() },
        uv_set: 0,
    };
    let textured = |rgb: [f32; 3], texture: TextureDescription| TexturedColour {
        colour: Colour::Rgb(rgb),
        texture: Some(texture),
    };
    let floor = textured([0.9, 0.8, 1.0], texture(0, Wrap::MirroredRepeat, Filter::Linear));
    let measured = TexturedColour {
        colour: Colour::Spectrum(Spectrum::from_fn(|l| 0.3 + l / 3000.0)),
        texture: Some(texture(1, Wrap::ClampToEdge, Filter::Nearest)),
    };
    let mixed = Mix { models: [diffuse([0.8, 0.2, 0.2]), metal("Au", 0.4)], weight: 0.35 };
    let channel = |channel: Channel| Some((texture(1, Wrap::Repeat, Filter::Linear), channel));
    let worn = layered(
        textured([0.9, 0.9, 0.8], texture(0, Wrap::Repeat, Filter::Linear)),
        TexturedFactor { value: 0.9, texture: channel(Channel::B) },
        TexturedFactor { value: 0.7, texture: channel(Channel::G) },
    );
    let glossy = layered(grey(0.6), TexturedFactor::plain(0.0), TexturedFactor::plain(0.0));
    let coloured = ball(8, 0.1, true);
    let colours = coloured.positions.iter().map(|p| (0.5 * *p + 0.5).extend(1.0)).collect();
    let coloured = MeshDescription { colours, ..coloured };
    let veil = square(Vec3::new(0.9, 0.9, 1.2), 0.5 * Vec3::X, 0.6 * Vec3::Y);
    let veil =
        MeshDescription { colours: [0.2, 0.9, 0.6, 0.4].map(|alpha| Vec4::new(0.7, 1.0, 0.5, alpha)).to_vec(), ..veil };
    let sky: Vec<[f32; 3]> =
        (0..512).map(|i| [[0.6, 0.8, 1.0], [9.0, 8.0, 6.0]][usize::from(i % 32 == 5 && i / 32 == 4)]).collect();
    let still = DAffine3::IDENTITY;
    let tall = DAffine3::from_scale_rotation_translation(
        DVec3::new(0.2, 0.2, 0.9),
        DQuat::from_rotation_x(-1.2),
        DVec3::new(-1.4, 0.1, 0.9),
    );
    let bumps = texture(1, Wrap::Repeat, Filter::Linear);
    let mut stage = scene
        .add(
            "floor",
            MaterialModel::Diffuse(Diffuse { reflectance: floor }),
            square(Vec3::ZERO, 3.0 * Vec3::Z, 3.0 * Vec3::X),
            &[still],
        )
        .add(
            "wall",
            MaterialModel::OrenNayar(OrenNayar { reflectance: measured, roughness: 0.6 }),
            square(Vec3::new(0.0, 1.5, -2.5), 3.0 * Vec3::X, 1.5 * Vec3::Y),
            &[still],
        )
        .add(
            "balls",
            metal("Cu", 0.35),
            ball(12, 0.05, false),
            &[placed([-1.0, 0.4, 0.0], 0.3), placed([1.2, 0.5, -0.6], 0.4), placed([0.1, 0.3, 1.0], 0.2)],
        )
        .add(
            "smooth",
            diffuse([0.2, 0.6, 0.3]),
            ball(10, 0.0, true),
            &[placed([0.3, 0.5, -1.3], 0.45), placed([-1.9, 0.4, -1.2], 0.35)],
        )
        .add(
            "prism",
            glass(library::glass("SF11").expect("a glass"), 0.0),
            quadric(QuadricKind::Sphere),
            &[placed([0.4, 0.5, 0.2], 0.45)],
        )
        .add(
            "frosted",
            glass(library::glass("BK7").unwrap_or(Dispersion::constant(1.5)), 0.3),
            ball(16, 0.02, false),
            &[placed([-0.4, 0.35, 1.1], 0.3)],
        )
        .add("mirror", metal("Ag", 0.0), quadric(QuadricKind::Disk), &[placed([1.9, 0.9, 0.6], 0.6)])
        .add(
            "sheet",
            MaterialModel::Translucent(Translucent { reflectance: grey(0.4), transmittance: grey(0.35) }),
            square(Vec3::new(-2.0, 0.8, 0.4), 0.5 * Vec3::Z, 0.6 * Vec3::Y),
            &[still],
        )
        .add(
            "phong",
            MaterialModel::Phong(Phong { diffuse: grey(0.3), specular: grey(0.5), exponent: 30.0 }),
            quadric(QuadricKind::Cylinder),
            &[tall],
        )
        .add(
            "mixed",
            MaterialModel::Mix(Box::new(mixed)),
            square(Vec3::new(2.5, 1.0, -0.5), 0.9 * Vec3::Z, -0.9 * Vec3::Y),
            &[still],
        )
        .add("grille", diffuse([0.6; 3]), square(Vec3::new(-0.2, 0.6, 0.7), 0.5 * Vec3::X, 0.5 * Vec3::Y), &[still])
        .add("basket", diffuse([0.8, 0.7, 0.3]), quadric(QuadricKind::Sphere), &[placed([-2.2, 0.4, -2.0], 0.4)])
        .add("veil", diffuse([0.5; 3]), veil, &[still, placed([1.0, 0.2, 0.2], 0.6)])
        .add("worn", worn, square(Vec3::new(0.6, 0.7, -2.0), 0.5 * Vec3::X, 0.6 * Vec3::Y), &[still])
        .add("glossy", glossy, coloured, &[placed([-0.9, 0.35, -1.7], 0.35)])
        .shine("panel", light(900.0), false, square(Vec3::new(-0.6, 2.6, 0.2), 0.4 * Vec3::X, 0.3 * Vec3::Z), still)
        .shine(
            "slide",
            EmissionDescription { texture: Some(texture(0, Wrap::Repeat, Filter::Linear)), ..light(300.0) },
            true,
            square(Vec3::new(1.6, 2.0, -1.5), 0.3 * Vec3::X, 0.3 * Vec3::Y),
            still,
        )
        .shine("sign", light(250.0), true, square(Vec3::new(-1.6, 1.9, 0.9), 0.3 * Vec3::X, 0.3 * Vec3::Y), still)
        .shine("bulb", light(4000.0), false, quadric(QuadricKind::Sphere), placed([-1.2, 1.6, -1.2], 0.08))
        .shine("plate", light(800.0), true, quadric(QuadricKind::Disk), placed([0.9, 2.2, 0.9], 0.2))
        .shine("tube", light(1500.0), false, quadric(QuadricKind::Cylinder), placed([-2.3, 1.9, -0.4], 0.07))
        .lamp(LightKind::Point(PointLight), DAffine3::from_translation(DVec3::new(0.2, 2.0, 1.5)), 60.0)
        .lamp(
            LightKind::Spot(SpotLight::new(0.2, 0.5)),
            DAffine3::from_rotation_translation(DQuat::from_rotation_x(-1.2), DVec3::new(0.0, 2.5, 0.8)),
            200.0,
        )
        .lamp(LightKind::Directional(DirectionalLight), DAffine3::from_quat(DQuat::from_rotation_x(-0.9)), 120.0)
        .environment(EnvironmentDescription::Image {
            image: bitmap(32, 16, Texels::Rgb32F(sky)),
            level: ImageLevel::NitPerUnit(40.0),
            rotation_deg: 25.0,
        });
    let holes = texture(2, Wrap::Repeat, Filter::Linear);
    for material in &mut stage.0.materials {
        match material.name.as_str() {
            "wall" => material.normal_map = Some((bumps.clone(), 0.4)),
            "grille" | "basket" | "sign" => {
                material.alpha = AlphaMode::Mask { cutoff: 0.5 };
                material.alpha_texture = Some(holes.clone());
            }
            "veil" => (material.alpha, material.alpha_factor) = (AlphaMode::Blend, 0.8),
            _ => {}
        }
    }
    stage
}

/// Matt and shiny things and a road sign in the sun, which is low.
pub(crate) fn outdoors() -> Stage {
    let still = DAffine3::IDENTITY;
    Stage::default()
        .add("ground", diffuse([0.5, 0.4, 0.3]), square(Vec3::ZERO, 3.0 * Vec3::Z, 3.0 * Vec3::X), &[still])
        .add("ball", with_all_bounces(metal("Cu", 0.7)), ball(12, 0.05, true), &[placed([-0.8, 0.5, 0.2], 0.5)])
        .add("sign", sheeting(), square(Vec3::new(1.2, 0.9, 0.6), 0.3 * Vec3::X, 0.3 * Vec3::Y), &[still])
        .add(
            "frost",
            with_all_bounces(glass(Dispersion::constant(1.6), 0.7)),
            ball(8, 0.1, true),
            &[placed([0.5, 0.3, 1.4], 0.25)],
        )
        .add("stone", diffuse([0.7; 3]), ball(10, 0.1, false), &[placed([0.9, 0.4, -0.5], 0.45)])
        .add(
            "leaf",
            MaterialModel::Translucent(Translucent { reflectance: grey(0.4), transmittance: grey(0.35) }),
            square(Vec3::new(0.2, 0.7, 0.9), 0.4 * Vec3::X, 0.5 * Vec3::Y),
            &[still],
        )
        .environment(sky(3.0, 20.0, 0.2, true))
}

/// glTF's material with each of its extensions, on things in a room that a window lights.
pub(crate) fn layers() -> Stage {
    let still = DAffine3::IDENTITY;
    let mut scene = Stage::default();
    let dots = (0..64u32).map(|i| if (i % 8 + i / 8) % 3 == 0 { [250, 180, 90, 255] } else { [90, 140, 220, 255] });
    scene.0.images.push(bitmap(8, 8, Texels::Rgba8(dots.collect())));
    let texture = TextureDescription {
        image: 0,
        sampler: SamplerSettings { wrap: [Wrap::Repeat; 2], filter: Filter::Linear },
        transform: UvTransform { scale: Vec2::splat(2.0), ..UvTransform::default() },
        uv_set: 0,
    };
    let channel = |value: f32, channel: Channel| TexturedFactor { value, texture: Some((texture.clone(), channel)) };
    let plain = TexturedFactor::plain;
    let tint = |rgb: [f32; 3]| TexturedColour::plain(Colour::Rgb(rgb));
    let thing = |colour: [f32; 3], roughness: f32| LayeredDescription {
        base_colour: tint(colour),
        roughness: plain(roughness),
        ..LayeredDescription::default()
    };
    let film = |textured: bool| FilmDescription {
        weight: plain(0.9),
        index: 1.4,
        thickness_nm: [250.0, 500.0],
        thickness_texture: textured.then(|| texture.clone()),
    };
    let coat = |roughness: f32, is_bumpy: bool| CoatDescription {
        weight: plain(0.9),
        roughness: plain(roughness),
        normal_map: is_bumpy.then(|| (texture.clone(), 0.3)),
    };
    let absorption = Some(Spectrum::from_fn(|l| if l > 550.0 { 0.4 } else { 2.5 }));
    let crystal = LayeredDescription {
        transmission: plain(1.0),
        absorption_per_m: absorption.clone(),
        index: library::glass("SF11").expect("a glass"),
        ..thing([1.0, 0.95, 0.9], 0.0)
    };
    let frosted = LayeredDescription {
        transmission: plain(0.9),
        absorption_per_m: absorption,
        film: Some(film(false)),
        ..thing([0.9; 3], 0.5)
    };
    let foil = LayeredDescription { transmission: channel(0.9, Channel::R), ..thing([0.6, 0.9, 0.7], 0.3) };
    let curtain = LayeredDescription {
        diffuse_transmission: Some((plain(0.5), tint([0.9, 0.6, 0.3]))),
        ..thing([0.5, 0.6, 0.8], 0.8)
    };
    let velvet = LayeredDescription {
        sheen: Some((tint([0.8, 0.3, 0.5]), channel(0.7, Channel::G))),
        ..thing([0.2, 0.05, 0.1], 0.9)
    };
    let brushed = LayeredDescription {
        metallic: plain(1.0),
        anisotropy: Some(AnisotropyDescription { strength: 0.7, rotation_rad: 0.5, texture: Some(texture.clone()) }),
        ..thing([0.9, 0.7, 0.4], 0.3)
    };
    let beetle = LayeredDescription {
        metallic: plain(0.7),
        film: Some(film(true)),
        coat: Some(coat(0.1, true)),
        ..thing([0.6, 0.5, 0.4], 0.4)
    };
    let car = LayeredDescription { coat: Some(coat(0.0, false)), ..thing([0.7, 0.1, 0.1], 0.6) };
    let grooved_glass = LayeredDescription {
        transmission: plain(0.8),
        absorption_per_m: Some(Spectrum::constant(0.5)),
        anisotropy: Some(AnisotropyDescription { strength: 0.5, rotation_rad: 0.0, texture: None }),
        sheen: Some((tint([0.3; 3]), plain(0.5))),
        coat: Some(coat(0.4, false)),
        ..thing([0.8, 0.9, 1.0], 0.4)
    };
    let mixed = Mix { models: [of_layers(car.clone()), of_layers(velvet.clone())], weight: 0.5 };
    let (ground, wall) = (square(Vec3::ZERO, 3.0 * Vec3::Z, 3.0 * Vec3::X), Vec3::new(0.0, 1.2, -2.4));
    let bumps = texture.clone();
    let mut stage = scene
        .add("ground", diffuse([0.5, 0.45, 0.4]), ground, &[still])
        .add("wall", of_layers(velvet), square(wall, 2.5 * Vec3::X, 1.2 * Vec3::Y), &[still])
        .add("crystal", of_layers(crystal), ball(14, 0.0, true), &[placed([-1.0, 0.5, 0.5], 0.4)])
        .add("frosted", of_layers(frosted), ball(12, 0.02, false), &[placed([0.0, 0.45, 0.8], 0.35)])
        .add("foil", of_layers(foil), square(Vec3::new(1.0, 0.7, 0.9), 0.4 * Vec3::X, 0.5 * Vec3::Y), &[still])
        .add("curtain", of_layers(curtain), square(Vec3::new(-1.8, 0.9, -0.4), 0.5 * Vec3::Z, 0.7 * Vec3::Y), &[still])
        .add("brushed", of_layers(brushed), square(Vec3::new(0.7, 0.6, -1.4), 0.5 * Vec3::X, 0.5 * Vec3::Y), &[still])
        .add("beetle", of_layers(beetle), square(Vec3::new(-0.6, 0.7, -1.7), 0.5 * Vec3::X, 0.6 * Vec3::Y), &[still])
        .add("car", of_layers(car), ball(12, 0.05, true), &[placed([1.4, 0.45, -0.5], 0.45)])
        .add("grooved", of_layers(grooved_glass), quadric(QuadricKind::Sphere), &[placed([0.3, 0.4, -0.4], 0.38)])
        .add("mixed", MaterialModel::Mix(Box::new(mixed)), ball(10, 0.0, true), &[placed([-0.9, 0.35, -0.7], 0.3)])
        .shine("window", light(700.0), true, square(Vec3::new(2.4, 1.6, 0.3), 0.8 * Vec3::Z, 0.6 * Vec3::Y), still)
        .environment(sky(20.0, 60.0, 0.3, false));
    for material in &mut stage.0.materials {
        if material.name == "car" || material.name == "foil" {
            material.normal_map = Some((bumps.clone(), 0.3));
        }
    }
    stage
}

/// A light above the floor that shines down, aslant.
fn hung(place: [f64; 3], aslant: f64) -> DAffine3 {
    let turn = DQuat::from_rotation_y(0.7 * place[0]) * DQuat::from_rotation_x(aslant - 1.5);
    DAffine3::from_rotation_translation(turn, DVec3::from(place))
}

/// Lights of measured profiles, projectors and laser beams with their poses, and levels that light a floor alike.
pub(crate) fn lamps() -> Vec<(LightKind, DAffine3, f64)> {
    let even = |from: f32, to: f32, steps: u8| {
        (0..=steps).map(move |i| from + (to - from) * f32::from(i) / f32::from(steps)).collect::<Vec<_>>()
    };
    let candela = |count: u16| (0..count).map(|i| 30.0 + 25.0 * (1.7 * f32::from(i)).sin()).collect::<Vec<_>>();
    let downlight = Profile::new(even(0.0, 0.5 * PI, 6), vec![0.0], candela(7));
    let mut around = candela(5 * 8);
    around.extend_from_within(..5);
    let around = Profile::new(even(0.2, 2.5, 4), even(0.0, TAU, 8), around);
    let patch =
        |i: u32| [[250, 60, 40, 255], [255; 4], [30, 200, 90, 255], [20, 30, 220, 255]][(i * i % 7 % 4) as usize];
    let slide = bitmap(6, 4, Texels::Rgba8((0..24).map(patch).collect()));
    let sharp = Projector::new(slide.clone(), [0.9, 0.6], [0.1, -0.2], 0.0, 1.0);
    let wide = Projector::new(slide, [1.2, 0.8], [0.0, 0.1], 0.05, 1.4);
    vec![
        (LightKind::Profile(downlight), hung([-1.0, 1.8, 0.4], 0.2), 40.0),
        (LightKind::Profile(around), hung([1.1, 1.5, -0.8], -0.3), 30.0),
        (LightKind::Projector(sharp), hung([0.1, 2.0, 0.9], 0.1), 1200.0),
        (LightKind::Projector(wide), hung([0.7, 1.9, 0.2], 0.5), 1600.0),
        (LightKind::GaussianBeam(GaussianBeam::new([0.15, 0.15], [0.05, 0.05])), hung([-0.5, 2.1, -0.6], 0.3), 400.0),
        (LightKind::GaussianBeam(GaussianBeam::new([0.06, 0.004], [0.0, 0.4])), hung([0.2, 1.7, 0.0], 0.6), 500.0),
    ]
}

/// Things on a floor under all of these lights, at dusk.
pub(crate) fn under_lamps() -> Stage {
    let stage = Stage::default()
        .add("floor", diffuse([0.7, 0.6, 0.5]), square(Vec3::ZERO, 2.5 * Vec3::Z, 2.5 * Vec3::X), &[DAffine3::IDENTITY])
        .add("stone", diffuse([0.7; 3]), ball(10, 0.1, false), &[placed([0.6, 0.3, 0.5], 0.3)])
        .add("ball", metal("Cu", 0.5), ball(12, 0.05, true), &[placed([-0.7, 0.35, -0.2], 0.35)]);
    let dusk = EnvironmentDescription::Constant { colour: Colour::Rgb([0.7, 0.8, 0.9]), luminance_nit: Some(5.0) };
    let stage = stage.environment(dusk);
    lamps().into_iter().fold(stage, |stage, (kind, to_world, level)| stage.lamp(kind, to_world, level))
}

/// Things on a floor under lamps without a surface, with panes, a foil, boundaries of index 1 and a haze between them.
pub(crate) fn lamps_behind_panes() -> Stage {
    let index = library::glass("BK7").unwrap_or(Dispersion::constant(1.5));
    let pane = |transmittance: f32| {
        let transmittance = Spectrum::from_fn(|l| f64::from(transmittance) * l / 800.0);
        MaterialModel::ThinDielectric(ThinDielectric { index: index.clone(), transmittance })
    };
    let tinted = Mix { models: [pane(0.9), diffuse([0.5; 3])], weight: 0.3 };
    let clear = LayeredDescription {
        transmission: TexturedFactor::plain(0.8),
        roughness: TexturedFactor::plain(0.0),
        ..LayeredDescription::default()
    };
    let foil = LayeredDescription { base_colour: TexturedColour::plain(Colour::Rgb([0.9, 0.6, 0.4])), ..clear.clone() };
    let absorption_per_m = Some(Spectrum::from_fn(|l| 0.5 + l / 400.0));
    let haze = LayeredDescription { index: Dispersion::constant(1.0), absorption_per_m, ..clear };
    under_lamps()
        .add(
            "pane",
            pane(0.8),
            square(Vec3::new(0.0, 1.3, 0.0), 0.8 * Vec3::X, 0.8 * Vec3::Z),
            &[DAffine3::IDENTITY, placed([0.3, 0.1, -0.2], 0.8)],
        )
        .add(
            "tinted",
            MaterialModel::Mix(Box::new(tinted)),
            quadric(QuadricKind::Disk),
            &[placed([-0.5, 1.0, 0.3], 0.4)],
        )
        .add(
            "nothing",
            glass(Dispersion::constant(1.0), 0.0),
            quadric(QuadricKind::Sphere),
            &[placed([0.2, 0.7, 0.6], 0.3)],
        )
        .add(
            "foil",
            of_layers(foil),
            square(Vec3::new(0.5, 0.9, 0.6), 0.4 * Vec3::X, 0.4 * Vec3::Z),
            &[DAffine3::IDENTITY],
        )
        .add("haze", of_layers(haze), ball(8, 0.1, true), &[placed([-0.2, 0.5, -0.7], 0.35)])
        .add("frost", glass(Dispersion::constant(1.0), 0.3), ball(8, 0.1, true), &[placed([-0.4, 0.6, 0.8], 0.3)])
        .add("prism", glass(index.clone(), 0.0), ball(8, 0.1, true), &[placed([0.9, 0.5, -0.6], 0.3)])
        .shine("bulb", light(3000.0), false, quadric(QuadricKind::Sphere), placed([-1.2, 1.6, -1.2], 0.08))
        .lamp(LightKind::Directional(DirectionalLight), DAffine3::from_quat(DQuat::from_rotation_x(-0.9)), 120.0)
}

/// Panes before a wall that shines, in a room of constant light: no lamp without a surface.
pub(crate) fn panes() -> Stage {
    let pane = ThinDielectric {
        index: library::glass("BK7").unwrap_or(Dispersion::constant(1.5)),
        transmittance: Spectrum::constant(0.7),
    };
    Stage::default()
        .add("floor", diffuse([0.7, 0.6, 0.5]), square(Vec3::ZERO, 2.0 * Vec3::Z, 2.0 * Vec3::X), &[DAffine3::IDENTITY])
        .add(
            "pane",
            MaterialModel::ThinDielectric(pane),
            square(Vec3::new(0.0, 0.8, 0.0), Vec3::X, 0.8 * Vec3::Y),
            &[DAffine3::IDENTITY, placed([0.3, 0.2, -0.5], 0.8)],
        )
        .shine("wall", light(200.0), false, square(Vec3::new(0.0, 1.0, -1.8), Vec3::X, Vec3::Y), DAffine3::IDENTITY)
        .environment(EnvironmentDescription::Constant {
            colour: Colour::Rgb([0.7, 0.8, 0.9]),
            luminance_nit: Some(30.0),
        })
}

/// Ways of things that move: far and turning, turning little, growing askew, in a mirror, on the spot by half a turn.
pub(crate) fn ways() -> [Vec<DAffine3>; 5] {
    let skew = DMat3::from_cols(DVec3::new(0.4, 0.05, 0.0), DVec3::new(0.0, 0.3, 0.1), DVec3::new(0.02, 0.0, 0.5));
    let askew = |growth: f64, turn: f64| DAffine3 {
        matrix3: DMat3::from_rotation_z(turn) * skew * growth,
        translation: DVec3::new(1.1, 0.5, -0.6 + 0.2 * turn),
    };
    let mirror = |x: f64, turn: f64| DAffine3 {
        matrix3: DMat3::from_rotation_y(turn) * DMat3::from_diagonal(DVec3::new(-0.8, 0.7, 0.9)),
        translation: DVec3::new(x, 0.1, -1.3),
    };
    [
        vec![placed([-1.3, 0.4, 0.0], 0.3), placed([-0.6, 0.9, 0.5], 0.3), placed([0.2, 0.4, 0.9], 0.3)],
        vec![placed([0.2, 0.35, 1.0], 0.25), placed([0.201, 0.35, 1.002], 0.25)],
        vec![askew(1.0, 0.0), askew(0.7, 0.4), askew(1.3, 0.9), askew(1.2, 0.9)],
        vec![mirror(-0.3, 0.0), mirror(0.4, -0.6)],
        vec![placed([-2.0, 0.5, -1.2], 0.4), placed([-2.0, 0.5, -1.2], 0.4) * DAffine3::from_rotation_x(3.1)],
    ]
}

/// A mesh that goes on to shapes that are longer or shorter along each axis.
fn changing(mesh: MeshDescription, scales: &[Vec3]) -> MeshDescription {
    let shape = |scale: &Vec3| ShapeDescription {
        positions: mesh.positions.iter().map(|position| *position * *scale).collect(),
        normals: mesh.normals.iter().map(|normal| (*normal / *scale).normalize()).collect(),
    };
    MeshDescription { later_shapes: scales.iter().map(shape).collect(), ..mesh }
}

/// Pose of a lamp that is turned up.
fn aimed(place: [f64; 3], up: f64) -> DAffine3 {
    DAffine3::from_rotation_translation(DQuat::from_rotation_x(up), DVec3::from(place))
}

/// A room in which things and lamps move, and some change their shape, before things that stand still, one of them of
/// the mesh of one that moves.
pub(crate) fn moving() -> Stage {
    let mut scene = Stage::default();
    let checker = (0..64u32).map(|i| if (i % 8 + i / 8) % 2 == 0 { [200, 120, 60, 255] } else { [40, 90, 190, 90] });
    scene.0.images.push(bitmap(8, 8, Texels::Rgba8(checker.collect())));
    let squares = TextureDescription {
        image: 0,
        sampler: SamplerSettings { wrap: [Wrap::Repeat; 2], filter: Filter::Linear },
        transform: UvTransform::default(),
        uv_set: 0,
    };
    let checkered = TexturedColour { colour: Colour::Rgb([0.9; 3]), texture: Some(squares.clone()) };
    let still = DAffine3::IDENTITY;
    let [far, little, askew, mirror, turning] = ways();
    let blob = changing(ball(10, 0.05, true), &[Vec3::new(1.3, 0.6, 1.0), Vec3::new(0.8, 1.2, 0.9)]);
    let runner = changing(ball(6, 0.1, false), &[Vec3::new(0.7, 1.0, 1.4)]);
    let flag = changing(
        square(Vec3::new(-1.8, 1.5, -1.9), 0.7 * Vec3::X, 0.4 * Vec3::Y),
        &[Vec3::new(1.0, 0.9, 0.8), Vec3::new(0.9, 1.0, 1.1), Vec3::new(1.1, 1.1, 1.0)],
    );
    let sail = changing(square(Vec3::new(2.2, 1.4, -1.2), 0.4 * Vec3::Z, 0.5 * Vec3::Y), &[Vec3::new(0.8, 1.2, 1.1)]);
    let squares_of_a_flag = checkered.clone();
    let sign = square(Vec3::new(0.0, 0.6, 0.0), 0.6 * Vec3::X, 0.6 * Vec3::Y);
    let glass = glass(library::glass("BK7").unwrap_or(Dispersion::constant(1.5)), 0.0);
    let mut stage = scene
        .add("floor", diffuse([0.6, 0.5, 0.4]), square(Vec3::ZERO, 3.0 * Vec3::Z, 3.0 * Vec3::X), &[still])
        .add(
            "wall",
            diffuse([0.4, 0.5, 0.6]),
            square(Vec3::new(0.0, 1.5, -2.5), 3.0 * Vec3::X, 1.5 * Vec3::Y),
            &[still],
        )
        .add("balls", metal("Cu", 0.35), ball(12, 0.05, false), &[placed([1.9, 0.4, 0.4], 0.35), far[0]])
        .then(&far[1..])
        .add("glass", glass, ball(12, 0.0, false), &[little[0]])
        .then(&little[1..])
        .add("askew", diffuse([0.2, 0.6, 0.3]), ball(10, 0.0, true), &[askew[0]])
        .then(&askew[1..])
        .add("sign", MaterialModel::Diffuse(Diffuse { reflectance: checkered }), sign, &[mirror[0]])
        .then(&mirror[1..])
        .add("turning", diffuse([0.7, 0.3, 0.2]), ball(6, 0.2, false), &[turning[0]])
        .then(&turning[1..])
        .add("blob", diffuse([0.3, 0.4, 0.7]), blob, &[placed([1.1, 0.5, 0.9], 0.35)])
        .add("runner", metal("Au", 0.3), runner, &[placed([-2.2, 0.4, 0.6], 0.3)])
        .then(&[placed([-1.5, 0.6, 1.0], 0.3)])
        .add("flag", MaterialModel::Diffuse(Diffuse { reflectance: squares_of_a_flag }), flag, &[still])
        .shine("panel", light(900.0), false, square(Vec3::new(-0.6, 2.6, 0.2), 0.4 * Vec3::X, 0.3 * Vec3::Z), still)
        .shine("comet", light(600.0), true, square(Vec3::new(0.0, 1.6, 0.0), 0.2 * Vec3::X, 0.2 * Vec3::Y), still)
        .then(&[DAffine3::from_translation(DVec3::new(0.9, 0.3, -0.5)), aimed([1.2, 0.6, 0.3], 0.5)])
        .shine("sail", light(300.0), false, sail, still)
        .lamp(LightKind::Point(PointLight), DAffine3::from_translation(DVec3::new(0.2, 2.0, 1.5)), 60.0)
        .lamp_then(&[
            DAffine3::from_translation(DVec3::new(-1.2, 1.4, 1.1)),
            DAffine3::from_translation(DVec3::new(1.2, 1.4, 0.5)),
        ])
        .lamp(LightKind::Spot(SpotLight::new(0.2, 0.5)), aimed([0.0, 2.5, 0.8], -1.2), 200.0)
        .lamp_then(&[aimed([0.6, 2.2, 0.1], -1.6)])
        .lamp(LightKind::Directional(DirectionalLight), aimed([0.0; 3], -0.9), 60.0)
        .lamp_then(&[aimed([0.0; 3], -1.2), aimed([0.0; 3], -2.0)])
        .environment(EnvironmentDescription::Constant {
            colour: Colour::Rgb([0.7, 0.8, 0.9]),
            luminance_nit: Some(30.0),
        });
    for material in &mut stage.0.materials {
        if material.name == "sign" {
            material.normal_map = Some((squares.clone(), 0.3));
            material.alpha = AlphaMode::Mask { cutoff: 0.5 };
            material.alpha_texture = Some(squares.clone());
        }
    }
    stage
}
