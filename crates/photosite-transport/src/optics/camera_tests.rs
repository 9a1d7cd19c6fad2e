//! Cameras: focus, weight of rays, the way there and back through all lens models, stops, motion.

use glam::{DAffine3, DQuat, DVec2, DVec3};

use super::*;
use photosite_core::math::warp;
use photosite_core::spectrum::Wavelengths;

const GRID: PixelGrid = PixelGrid { resolution: [640, 480], pitch_m: [5e-6, 6e-6] };

fn camera(lens: &LensDescription) -> Camera {
    Camera::new(lens, &GRID, DAffine3::IDENTITY, f64::NAN).expect("a valid lens")
}

#[test]
fn the_image_distance_follows_the_thin_lens_equation() {
    let lens = camera(&LensDescription::thin(0.05, 2.0, Focus::Distance(1.0)));
    let (u, v) = (lens.focus_distance_m(), lens.image_distance_m());
    assert!((1.0 / 0.05 - 1.0 / u - 1.0 / v).abs() < 1e-12);
    assert_eq!(camera(&LensDescription::thin(0.05, 2.0, Focus::Infinity)).image_distance_m(), 0.05);
    assert!((lens.intrinsics().fx - v / 5e-6).abs() < 1e-9 && (lens.intrinsics().fy - v / 6e-6).abs() < 1e-9);
}

#[test]
fn all_rays_of_a_pixel_meet_where_it_is_focused() {
    let lens = camera(&LensDescription::thin(0.05, 1.4, Focus::Distance(0.8)));
    let pixel = DVec2::new(100.25, 400.75);
    let sharp = lens.chief_ray(pixel).expect("no distortion").at(0.8);
    for u in [[0.0, 0.0], [0.99, 0.3], [0.2, 0.9]] {
        let ray = lens.generate(pixel, u).expect("no distortion").ray;
        let t = (sharp - ray.origin).dot(ray.direction);
        // f32 rays at a distance of 0.8 m.
        assert!((ray.at(t) - sharp).length() < 2e-7, "{:?}", ray.at(t) - sharp);
    }
    assert!((lens.project(sharp).expect("in front") - pixel).length() < 1e-3);
}

#[test]
fn the_image_is_upright_and_not_mirrored() {
    let lens = camera(&LensDescription::thin(0.05, 8.0, Focus::Infinity));
    let top_right = lens.chief_ray(DVec2::new(600.0, 20.0)).expect("no distortion").direction;
    assert!(top_right.x > 0.0 && top_right.y > 0.0 && top_right.z < 0.0);
}

#[test]
fn autofocus_within_the_focal_length_is_refused() {
    let lens =
        LensDescription::thin(0.05, 2.0, Focus::Autofocus { pixel: [320.0, 240.0], method: AutofocusMethod::Exact });
    assert!(Camera::new(&lens, &GRID, DAffine3::IDENTITY, 0.04).is_err());
    let focused = Camera::new(&lens, &GRID, DAffine3::IDENTITY, 2.0).expect("in front");
    assert_eq!(focused.focus_distance_m(), 2.0);
}

fn projected(projection: Projection, max_angle_deg: Option<f64>) -> Camera {
    let mut lens = LensDescription::thin(0.004, 2.0, Focus::Distance(0.5));
    (lens.projection, lens.max_angle_rad) = (projection, max_angle_deg.map(f64::to_radians));
    lens.intrinsics = Some(Intrinsics { fx: 400.0, fy: 410.0, cx: 300.0, cy: 250.0, skew: 1.5 });
    camera(&lens)
}

fn barrel(k1: f64) -> Projection {
    Projection::BrownConrady(BrownConrady { k: [k1, 0.0, 0.0, 0.0, 0.0, 0.0], ..BrownConrady::default() })
}

const FISHEYE: Projection = Projection::KannalaBrandt { k: [0.0; 4] };

#[test]
fn pixels_and_what_they_see_agree_over_the_whole_sensor() {
    for projection in [
        Projection::Perspective,
        barrel(-0.1),
        barrel(0.4),
        Projection::Polynomial { k: [0.3, 0.0] },
        Projection::Division { lambda: -0.2 },
        FISHEYE,
        Projection::Equirectangular,
        Projection::Omnidirectional { xi: 1.1, distortion: BrownConrady::default() },
    ] {
        let camera = projected(projection, None);
        camera.check_coverage().expect("all of the sensor sees something");
        for i in 0..=20 {
            let pixel = DVec2::new(f64::from(i) * 32.0, f64::from((i * 7) % 21) * 24.0);
            let seen = camera.seen(pixel).expect("light");
            let found = camera.project_camera(seen.direction * 3.0).expect("in reach");
            assert!((found - pixel).length() < 1e-9, "{projection:?} {pixel}: {found}");
        }
    }
}

#[test]
fn a_fold_within_the_image_is_refused_but_no_image_circle() {
    // It folds at r = √(1/1.5), 0.544 focal lengths or some 218 px from the middle; the corner lies 420 px away.
    let invalid = projected(barrel(-0.5), None).check_coverage().expect_err("a fold");
    assert!(invalid.message.contains("folds back over its own image 21"), "{invalid}");
    let circle = projected(barrel(-0.5), Some(35.0));
    circle.check_coverage().expect("black beyond 35°");
    assert!(circle.seen(DVec2::new(0.0, 0.0)).is_none() && circle.seen(DVec2::new(300.0, 100.0)).is_some());
    let field = circle.field_of_view();
    assert!((field.reach_rad.to_degrees() - 35.0).abs() < 1e-9 && field.blind_px.is_some());
    projected(FISHEYE, None).check_coverage().expect("180° from the axis are far outside");
    assert!(projected(FISHEYE, Some(30.0)).field_of_view().blind_px.is_some());
}

#[test]
fn lenses_that_see_more_than_a_half_space_are_focused_on_a_sphere() {
    let camera = projected(FISHEYE, None);
    // 1.5 rad to the right, and 100° beyond that.
    for pixel in [DVec2::new(900.0, 250.0), DVec2::new(1000.0, 250.0)] {
        let direction = camera.seen(pixel).expect("in reach").direction;
        let sharp = direction * 0.5;
        for u in [[0.1, 0.2], [0.99, 0.3], [0.2, 0.9]] {
            let ray = camera.generate(pixel, u).expect("in reach").ray;
            let origin = ray.origin.as_dvec3();
            // f32 rays.
            assert!(origin.dot(direction).abs() < 1e-9, "the pupil faces the direction");
            assert!((sharp - origin).cross(ray.direction.as_dvec3()).length() < 1e-7);
        }
    }
}

#[test]
fn illumination_follows_the_solid_angle() {
    let at = |camera: &Camera, x: f64| {
        let i = camera.intrinsics();
        camera.relative_illumination(DVec2::new(i.cx + i.fx * x, i.cy)).expect("light")
    };
    for x in [0.2, 0.5, 0.9] {
        // dΩ/dA of an equidistant fisheye is sin θ/θ.
        assert!((at(&projected(FISHEYE, None), x) - x.sin() / x).abs() < 1e-12);
    }
    // A distortion that is none keeps cos⁴; a barrel multiplies it by the area of the ideal image over its own.
    let mut lens = LensDescription::thin(0.004, 200.0, Focus::Infinity);
    for (k1, distorted) in [(0.0, 0.5), (-0.2, 0.45), (0.3, 0.5)] {
        lens.projection = barrel(k1);
        let camera = camera(&lens);
        let ideal =
            camera.seen(DVec2::new(320.0 + camera.intrinsics().fx * distorted, 240.0)).expect("light").direction;
        let r = -ideal.x / ideal.z;
        let growth = (1.0 + k1 * r * r) * (1.0 + 3.0 * k1 * r * r);
        let expected = (1.0 + r * r).powi(-2) / growth;
        // The opening of f/200 adds (D/2v)² = 6e-6.
        assert!((at(&camera, distorted) / expected - 1.0).abs() < 2e-5, "{k1}: {} {expected}", at(&camera, distorted));
    }
}

#[test]
fn the_light_of_an_image_is_that_of_what_it_shows() {
    // Étendue: a far disk of uniform light gives the same power, whatever the distortion. Its image fits the sensor.
    let power = |projection: Projection| {
        let camera = projected(projection, Some(20.0));
        let n = 400;
        let sum: f64 = (0..n * n)
            .map(|i| {
                let pixel = DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n)
                    * DVec2::new(640.0, 480.0);
                camera.generate(pixel, [0.0, 0.0]).map_or(0.0, |ray| f64::from(ray.weight))
            })
            .sum();
        sum
    };
    let ideal = power(Projection::Perspective);
    for k1 in [-0.4, 0.4] {
        // The rim of the disk crosses some 1000 of 30 000 cells, each known to half a cell: √1000/2/30 000 = 5e-4.
        assert!((power(barrel(k1)) / ideal - 1.0).abs() < 2e-3, "{k1}: {} {ideal}", power(barrel(k1)));
    }
}

#[test]
fn illumination_is_told_relative_to_the_axis() {
    let mirror = Projection::Omnidirectional { xi: 1.1, distortion: BrownConrady::default() };
    for (projection, sr_per_area) in
        [(Projection::Perspective, 1.0), (barrel(-0.1), 1.0), (FISHEYE, 1.0), (mirror, 2.1 * 2.1)]
    {
        for (kind, falloff) in [LensKind::Thin, LensKind::Pinhole]
            .into_iter()
            .flat_map(|kind| [Falloff::Cos4, Falloff::None].map(|falloff| (kind, falloff)))
        {
            let mut lens = LensDescription::thin(0.004, 1.4, Focus::Infinity);
            (lens.kind, lens.falloff, lens.projection, lens.blades) = (kind, falloff, projection, 6);
            lens.intrinsics = Some(Intrinsics { fx: 400.0, fy: 410.0, cx: 300.0, cy: 250.0, skew: 0.0 });
            let camera = camera(&lens);
            let axis = DVec2::new(300.0, 250.0);
            let relative = camera.relative_illumination(axis).expect("light");
            assert!((relative - 1.0).abs() < 1e-12, "{projection:?} {kind:?} {falloff:?}: {relative}");
            // The mean weight on the axis is the projected solid angle; near the middle of a mirror's image a radian
            // is 1/(1 + ξ) of a focal length.
            let n: u16 = 200;
            let at = |i: u16| (f32::from(i) + 0.5) / f32::from(n);
            let weight = |i: u16, j: u16| f64::from(camera.generate(axis, [at(i), at(j)]).expect("light").weight);
            let mean = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| weight(i, j)).sum::<f64>()
                / f64::from(u32::from(n) * u32::from(n));
            let expected = camera.on_axis_sr();
            assert!((mean / expected - 1.0).abs() < 1e-4, "{projection:?} {kind:?} {falloff:?}: {mean} {expected}");
            let perspective = LensDescription { projection: Projection::Perspective, ..lens };
            let ratio = expected / self::camera(&perspective).on_axis_sr();
            assert!((ratio / sr_per_area - 1.0).abs() < 1e-12, "{projection:?}: {ratio}");
        }
    }
}

#[test]
fn a_pinhole_has_no_focus() {
    let autofocus = Focus::Autofocus { pixel: [3.0, 4.0], method: AutofocusMethod::Exact };
    for focus in [Focus::Infinity, Focus::Distance(0.5), Focus::Distance(0.001), autofocus] {
        let lens = LensDescription { kind: LensKind::Pinhole, ..LensDescription::thin(0.004, 2.0, focus) };
        let camera = camera(&lens);
        assert_eq!(camera.image_distance_m(), 0.004);
        assert_eq!([camera.intrinsics().fx, camera.intrinsics().fy], [0.004 / 5e-6, 0.004 / 6e-6]);
        assert!(camera.focus_distance_m().is_infinite());
    }
}

/// Area common to two circles whose centres are `d` apart.
fn overlap(a: f64, b: f64, d: f64) -> f64 {
    if d >= a + b {
        return 0.0;
    }
    if d <= (a - b).abs() {
        return std::f64::consts::PI * a.min(b).powi(2);
    }
    let angle = |r: f64, other: f64| ((d * d + r * r - other * other) / (2.0 * d * r)).clamp(-1.0, 1.0).acos();
    let segment = |r: f64, other: f64| {
        let half = angle(r, other);
        r * r * (half - half.sin() * half.cos())
    };
    segment(a, b) + segment(b, a)
}

#[test]
fn stops_leave_the_overlap_of_two_circles() {
    // f = 4 mm at f/2: R = 1 mm.
    let mut lens = LensDescription::thin(0.004, 2.0, Focus::Infinity);
    lens.falloff = Falloff::None;
    // A stop in front is seen along the ray, one behind between lens and sensor, where light converges.
    for (distance_m, radius_m) in [(0.003, 0.0012), (0.006, 0.0015), (-0.002, 0.0009)] {
        lens.stops = vec![Stop { distance_m, radius_m }];
        let camera = camera(&lens);
        for x in [0.0, 80.0, 160.0, 300.0] {
            let tan = x * 5e-6 / 0.004;
            let (radius, apart) = match distance_m {
                d if d > 0.0 => (radius_m, d * tan),
                // At half of the way to the sensor, the light is half as wide and half as far out as the image.
                _ => (radius_m * 2.0, 2.0 * 0.5 * 0.004 * tan),
            };
            let open = overlap(0.001, radius, 0.0);
            let expected = overlap(0.001, radius, apart) / open;
            let found = camera.relative_illumination(DVec2::new(320.0 + x, 240.0)).expect("in reach");
            assert!((found - expected).abs() < 3e-3, "{distance_m} {x}: {found} {expected}");
        }
    }
}

#[test]
fn rays_that_are_made_together_are_those_of_each_sample() {
    let placed = |lens: &LensDescription| {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.0);
        let to_world = DAffine3::from_rotation_translation(turn, DVec3::new(3.0, -20.0, 0.7));
        Camera::new(lens, &GRID, to_world, f64::NAN).expect("a valid lens")
    };
    let near = LensDescription::thin(0.004, 2.0, Focus::Distance(0.5));
    let far = LensDescription { focus: Focus::Infinity, falloff: Falloff::None, ..near.clone() };
    let pinhole = LensDescription { kind: LensKind::Pinhole, ..near.clone() };
    let skewed = Intrinsics { fx: 400.0, fy: 410.0, cx: 300.0, cy: 250.0, skew: 1.5 };
    let skewed = LensDescription { intrinsics: Some(skewed), blades: 5, ..near.clone() };
    let narrow = LensDescription { max_angle_rad: Some(0.3), ..near.clone() };
    let distorted = LensDescription { projection: barrel(-0.05), ..near.clone() };
    let coloured = LensDescription {
        lateral_colour: Some(LateralColour { points: vec![(450.0, 0.998), (650.0, 1.002)] }),
        ..near.clone()
    };
    for lens in [near, far, pinhole, skewed, narrow, distorted, coloured] {
        let camera = placed(&lens);
        for count in [0, 1, 7, 8, 9, 40] {
            let sample = |i: u16| {
                let u = f32::from(i) / 40.0;
                let pixel = DVec2::new(16.25 * f64::from(i), 12.5 * f64::from(i % 7) + 100.0);
                CameraSample { pixel, aperture: [u, 1.0 - u], time: 0.5, spread: [0.5; 2] }
            };
            let samples: Vec<_> = (0..count).map(sample).collect();
            let start = Wavelengths::new([450.0, 550.0, 600.0, 650.0], [0.01; 4]);
            let mut wavelengths = vec![start; samples.len()];
            let (mut numbers, mut seen) = (0.., 0);
            camera.generate_each(&samples, &mut wavelengths, |number, found, ray| {
                assert_eq!(Some(number), numbers.next());
                let mut wavelengths = start;
                let alone = camera.generate_spectral(&samples[number], &mut wavelengths);
                assert_eq!(*found, wavelengths, "{lens:?}");
                assert_eq!(format!("{ray:?}"), format!("{alone:?}"), "{lens:?}");
                seen += usize::from(ray.is_some());
            });
            assert_eq!(numbers.start, samples.len());
            let expected = if lens.max_angle_rad.is_some() { 1..count.max(2) } else { count..count + 1 };
            assert!(count == 0 || count == 1 || expected.contains(&(seen as u16)), "{seen} of {count}: {lens:?}");
        }
    }
}

#[test]
fn lateral_colour_moves_the_image_of_the_hero() {
    let mut lens = LensDescription::thin(0.004, 2.0, Focus::Infinity);
    lens.lateral_colour = Some(LateralColour { points: vec![(450.0, 0.998), (650.0, 1.002)] });
    let camera = camera(&lens);
    for (lambda, magnification) in [(400.0, 0.998), (550.0, 1.0), (600.0, 1.001)] {
        let mut wavelengths = Wavelengths::new([lambda, 500.0, 550.0, 600.0], [1.0; 4]);
        let pixel = DVec2::new(600.5, 100.5);
        let sample = CameraSample { pixel, aperture: [0.5; 2], time: 0.0, spread: [0.0; 2] };
        let (ray, _) = camera.generate_spectral(&sample, &mut wavelengths).expect("light");
        assert!(wavelengths.is_hero_alone());
        let expected = DVec2::new(320.0, 240.0) + (pixel - DVec2::new(320.0, 240.0)) / magnification;
        let found = camera.project_camera(ray.ray.direction.as_dvec3()).expect("in reach");
        // f32 directions: 1e-7 of 800 px.
        assert!((found - expected).length() < 2e-4, "{lambda}: {found} {expected}");
    }
}

#[test]
fn a_point_is_connected_to_the_pixel_whose_ray_goes_by_it() {
    let placed = |lens: &LensDescription| {
        let to_world = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.7), DVec3::new(1.0, -2.0, 0.5));
        Camera::new(lens, &GRID, to_world, f64::NAN).expect("a valid lens")
    };
    let of = |projection| {
        let mut lens = LensDescription::thin(0.004, 0.5, Focus::Distance(0.5));
        (lens.projection, lens.max_angle_rad) = (projection, Some(1.2));
        lens.intrinsics = Some(Intrinsics { fx: 400.0, fy: 410.0, cx: 300.0, cy: 250.0, skew: 1.5 });
        lens
    };
    let points = vec![(400.0, 0.99), (700.0, 1.02)];
    let lenses = [
        LensDescription { kind: LensKind::Pinhole, ..of(Projection::Perspective) },
        of(Projection::Perspective),
        of(barrel(-0.1)),
        of(FISHEYE),
        of(Projection::Omnidirectional { xi: 1.1, distortion: BrownConrady::default() }),
        LensDescription { lateral_colour: Some(LateralColour { points }), ..of(barrel(0.2)) },
        LensDescription { point_spread: Some(PointSpread::Gaussian { sigma_m: 2e-5 }), ..of(Projection::Perspective) },
    ];
    for lens in lenses {
        let camera = placed(&lens);
        for (pixel, aperture, t) in [
            (DVec2::new(310.25, 244.5), [0.3, 0.9], 0.7f32),
            (DVec2::new(420.5, 130.75), [0.95, 0.1], 3.0),
            (DVec2::new(150.0, 400.25), [0.7, 0.4], 0.31),
        ] {
            let spread = [0.4, 0.8];
            let mut wavelengths = Wavelengths::new([450.0, 550.0, 600.0, 650.0], [0.01; 4]);
            let sample = CameraSample { pixel, aperture, time: 0.0, spread };
            let (ray, weights) = camera.generate_spectral(&sample, &mut wavelengths).expect("in reach");
            let mut again = Wavelengths::new([450.0, 550.0, 600.0, 650.0], [0.01; 4]);
            let point = ray.ray.at(t);
            let found = camera.connect(point, aperture, spread, &mut again).expect("it is seen");
            // A point in f32, some 3e-7 m off, is that much more of a pixel the nearer it is: 400 px·rad⁻¹ at 0.3 m.
            assert!((found.pixel - pixel).length() < 1e-3, "{lens:?}: {} is not {pixel}", found.pixel);
            assert!((found.ray.ray.direction - ray.ray.direction).length() < 2e-6, "{lens:?}");
            assert!((found.ray.weight / ray.weight - 1.0).abs() < 1e-4 && found.weights == weights, "{lens:?}");
            assert_eq!(again, wavelengths);
            if matches!(lens.projection, Projection::Perspective) {
                // A pixel shows (z/f)² of a plane across the axis, whichever point of the lens it is seen through.
                let towards = camera.to_world().inverse().transform_vector3(ray.ray.direction.as_dvec3());
                let cos = -towards.z;
                let z = -camera.to_world().inverse().transform_point3(point.as_dvec3()).z;
                let expected = 400.0 * 410.0 / (z * z * cos);
                assert!((f64::from(found.px2_per_m2) / expected - 1.0).abs() < 1e-5, "{lens:?} {pixel}");
            } else if matches!(lens.projection, Projection::KannalaBrandt { .. }) && aperture == [0.7, 0.4] {
                // By rays of four neighbours, on the plane across the ray.
                let at = |x: f64, y: f64| {
                    let ray = camera.generate(pixel + DVec2::new(x, y), aperture).expect("in reach").ray;
                    let normal = found.ray.ray.direction;
                    let t = (point - ray.origin).dot(normal) / ray.direction.dot(normal);
                    ray.at(t).as_dvec3()
                };
                let area = (at(4.0, 0.0) - at(-4.0, 0.0)).cross(at(0.0, 4.0) - at(0.0, -4.0)).length() / 64.0;
                // f32 rays over a patch of 5 mm, and its curvature.
                assert!(
                    (f64::from(found.px2_per_m2) * area - 1.0).abs() < 1e-3,
                    "{}",
                    f64::from(found.px2_per_m2) * area
                );
            }
        }
    }
    // Behind a pinhole, and beyond the edge of what a lens sees.
    let camera = placed(&LensDescription { kind: LensKind::Pinhole, ..of(FISHEYE) });
    for direction in [DVec3::Z, DVec3::new(1.0, 0.0, -0.1)] {
        let point = camera.to_world().transform_point3(direction).as_vec3();
        let mut wavelengths = Wavelengths::new([450.0, 550.0, 600.0, 650.0], [0.01; 4]);
        assert!(camera.connect(point, [0.5; 2], [0.5; 2], &mut wavelengths).is_none());
    }
}

/// A point of the scene in the plane of the axis and x, by tracing a ray of a sensor point through every element.
fn traced(lens: &LensDescription, v: f64, sensor: f64, opening: f64, lambda_nm: f64) -> (f64, f64) {
    let power = lens.ground.as_ref().map_or(1.0 / lens.focal_length_m, |ground| ground.power(lambda_nm));
    let (mut height, mut slope, mut at) = (opening, (opening - sensor) / v, 0.0);
    slope -= height * power;
    for element in &lens.supplementary {
        height += slope * (element.distance_m - at);
        at = element.distance_m;
        slope -= height * element.power.at(lambda_nm);
    }
    // Height of the ray at z = 0, carried on backwards, and its slope.
    (height - slope * at, slope)
}

#[test]
fn elements_before_the_lens_bend_rays_as_a_trace_through_each_does() {
    let bk7 = photosite_core::spectrum::library::glass("BK7").expect("a glass");
    let flint = photosite_core::spectrum::library::glass("SF11").expect("a glass");
    let close_up = |power, distance_m| SupplementaryLens { power: Power::Constant(power), distance_m };
    let meniscus = GroundLens { radii_m: [0.2, 0.5], thickness_m: 0.003, index: flint };
    let glass = SupplementaryLens { power: Power::Ground(meniscus), distance_m: 0.03 };
    let biconvex = GroundLens { radii_m: [0.05, -0.06], thickness_m: 0.004, index: bk7 };
    let f = 1.0 / biconvex.power(587.5618);
    for (ground, supplementary, focus) in [
        (None, vec![], Focus::Distance(0.7)),
        (None, vec![close_up(2.0, 0.0)], Focus::Distance(0.4)),
        (None, vec![close_up(3.0, 0.02), close_up(-1.0, 0.05)], Focus::Distance(0.4)),
        (None, vec![close_up(-2.0, 0.02)], Focus::Infinity),
        (Some(biconvex.clone()), vec![], Focus::Distance(1.5)),
        (Some(biconvex), vec![close_up(1.0, 0.01), glass], Focus::Distance(0.3)),
        (None, vec![], Focus::ImageDistance(0.06)),
    ] {
        let name = format!("{focus:?}, {} before", supplementary.len());
        let f = if ground.is_some() { f } else { 0.05 };
        let lens = LensDescription { ground, supplementary, ..LensDescription::thin(f, 2.0, focus) };
        let placed = camera(&lens);
        let v = placed.image_distance_m();
        let mut pupils_m = Vec::new();
        for lambda_nm in [450.0f32, 587.5618, 680.0] {
            for (column, u) in [(320.0, [0.9, 0.5]), (500.0, [0.9, 0.5]), (500.0, [0.2, 0.5]), (10.0, [0.2, 0.7])] {
                let pixel = DVec2::new(column, 240.0);
                let sample = CameraSample { pixel, aperture: u, time: 0.0, spread: [0.0; 2] };
                let mut wavelengths = Wavelengths::new([lambda_nm; 4], [1.0; 4]);
                let (CameraRay { ray, .. }, _) =
                    placed.generate_spectral(&sample, &mut wavelengths).expect("a lens without a rim");
                let opening = f64::from(warp::concentric_disk(u)[0]) * f / 4.0;
                let (height, slope) = traced(&lens, v, -(320.0 - column) * -5e-6, opening, lambda_nm.into());
                let found = f64::from(ray.direction.x / -ray.direction.z);
                // Rays of f32, and tables of 1 nm.
                assert!((found - slope).abs() < 1e-6, "{name}, {lambda_nm} nm, {column}: slope {found}, not {slope}");
                if lambda_nm == 587.5618 && slope.abs() > 1e-3 {
                    pupils_m.push((f64::from(ray.origin.x) - height) / slope);
                }
            }
        }
        // The camera stands in the entrance pupil, somewhere on the axis: all its rays are the same lines.
        let [low, high] = [f64::min, f64::max].map(|f| pupils_m.iter().copied().reduce(f).expect("some"));
        assert!(high - low < 2e-6 && high < 0.05 && low > -0.05, "{name}: pupils at {pupils_m:?} m");
    }
}

#[test]
fn a_hole_sends_rays_straight_on() {
    let mut lens = LensDescription::thin(0.05, 20.0, Focus::Infinity);
    lens.kind = LensKind::Hole;
    let placed = camera(&lens);
    for (pixel, u) in [([320.0, 240.0], [0.9, 0.3]), ([500.0, 20.0], [0.1, 0.8])] {
        let ray = placed.generate(DVec2::from_array(pixel), u).expect("a hole").ray;
        // From the place of the pixel, upside down behind the hole.
        let sensor = DVec3::new((320.0 - pixel[0]) * 5e-6, (pixel[1] - 240.0) * 6e-6, 0.05);
        let straight = (ray.origin.as_dvec3() - sensor).normalize();
        assert!((straight - ray.direction.as_dvec3()).length() < 1e-6, "{straight} {}", ray.direction);
        assert!(ray.origin.length() < 0.05 / 40.0 * 1.0001);
    }
    assert_eq!(placed.figures(None).expect("a hole").depth_of_field_m, None);
}

#[test]
fn a_bare_sensor_sees_a_half_space_from_where_each_pixel_is() {
    let mut lens = LensDescription::thin(0.05, 2.0, Focus::Infinity);
    lens.kind = LensKind::Bare;
    let placed = camera(&lens);
    let (n, mut cosines) = (256, 0.0);
    for i in 0..n * n {
        let u = [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32);
        let found = placed.generate(DVec2::new(420.0, 140.0), u).expect("light from everywhere");
        assert!((found.ray.origin.as_dvec3() - DVec3::new(-100.0 * 5e-6, -100.0 * 6e-6, 0.0)).length() < 1e-9);
        assert!((f64::from(found.weight) - std::f64::consts::PI).abs() < 1e-6);
        cosines += f64::from(-found.ray.direction.z);
    }
    // ∫cos²θ dΩ/π over the half-space; midpoint rule on a 256² grid, with a root at the rim.
    assert!((cosines / f64::from(n * n) - 2.0 / 3.0).abs() < 3e-4);
    assert_eq!((placed.seen(DVec2::ZERO).is_none(), placed.project(glam::Vec3::NEG_Z)), (true, None));
    assert_eq!(placed.figures(None), None);
}

/// The notes' formulas: H = f²/(N·c) + f, near = u·(H − f)/(H + u − 2f), far = u·(H − f)/(H − u).
#[test]
fn figures_are_those_of_the_formulas() {
    for (f, n, u, c) in
        [(0.05, 2.0, 3.0, 30e-6), (0.016, 8.0, 1.0, 5e-6), (0.2, 4.0, 20.0, 30e-6), (0.016, 8.0, 9.0, 5e-6)]
    {
        let placed = camera(&LensDescription::thin(f, n, Focus::Distance(u)));
        let figures = placed.figures(Some(c)).expect("a lens");
        let h = f * f / (n * c) + f;
        let [near, far] = figures.depth_of_field_m.expect("sharp");
        let expected = [u * (h - f) / (h + u - 2.0 * f), if u < h { u * (h - f) / (h - u) } else { f64::INFINITY }];
        assert!((near / expected[0] - 1.0).abs() < 1e-12, "{near} {expected:?}");
        assert!(far == expected[1] || (far / expected[1] - 1.0).abs() < 1e-12, "{far} {expected:?}");
        assert!((figures.hyperfocal_m.expect("focused at infinity") / h - 1.0).abs() < 1e-12);
        let v = u * f / (u - f);
        assert!((figures.entrance_pupil_m - f / n).abs() < 1e-15);
        assert!((figures.magnification.expect("focused") - f / (u - f)).abs() < 1e-12);
        let [width, height] = [640.0 * 5e-6, 480.0 * 6e-6];
        let diagonal = f64::hypot(width, height);
        for (angle, size) in figures.angle_of_view_rad.into_iter().zip([width, height, diagonal]) {
            assert!((angle.expect("seen") - 2.0 * (size / 2.0 / v).atan()).abs() < 1e-12);
        }
        let [across, down] = figures.field_at_focus_m.expect("focused");
        assert!((across - width * u / v).abs() < 1e-12 && (down - height * u / v).abs() < 1e-12);
        assert!((figures.diffraction_spot_m - 2.44 * 550e-9 * n * v / f).abs() < 1e-15);
    }
    // Through a close-up lens of 2 dioptres, a lens at infinity is focused at half a metre.
    let close_up = SupplementaryLens { power: Power::Constant(2.0), distance_m: 0.0 };
    let lens =
        LensDescription { supplementary: vec![close_up], ..LensDescription::thin(0.05, 2.0, Focus::Distance(0.5)) };
    assert!((camera(&lens).image_distance_m() - 0.05).abs() < 1e-12);
    let farther = Camera::new(&LensDescription { focus: Focus::Distance(0.6), ..lens }, &GRID, DAffine3::IDENTITY, 0.0);
    assert!(farther.expect_err("too far").message.contains("0.5 m"));
}

/// Hyperfocal distance of a lens with elements before it, by the search for what makes the far limit infinite.
#[test]
fn hyperfocal_distance_reaches_to_infinity() {
    let close_up = SupplementaryLens { power: Power::Constant(-1.0), distance_m: 0.02 };
    let lens = LensDescription { supplementary: vec![close_up], ..LensDescription::thin(0.05, 2.0, Focus::Infinity) };
    let hyperfocal = camera(&lens).figures(Some(30e-6)).and_then(|figures| figures.hyperfocal_m).expect("some");
    let far = |u: f64| {
        let focused = camera(&LensDescription { focus: Focus::Distance(u), ..lens.clone() });
        focused.figures(Some(30e-6)).and_then(|figures| figures.depth_of_field_m).expect("sharp")[1]
    };
    assert!(far(hyperfocal * 0.999).is_finite() && far(hyperfocal * 1.001).is_infinite(), "{hyperfocal}");
}

#[test]
fn a_lens_goes_no_nearer_than_it_can() {
    let mut lens = LensDescription::thin(0.05, 2.0, Focus::Distance(0.3));
    lens.min_focus_distance_m = Some(0.45);
    assert_eq!(lens.validate().expect_err("too near").key, "focus_distance_m");
    lens.focus = Focus::Autofocus { pixel: [320.0, 240.0], method: AutofocusMethod::Exact };
    assert_eq!(Camera::new(&lens, &GRID, DAffine3::IDENTITY, 0.3).expect("a lens").focus_distance_m(), 0.45);
    // With 2 dioptres before it, it goes from 0.5 m down to 1/(2 + 1/0.45) m.
    lens.supplementary = vec![SupplementaryLens { power: Power::Constant(2.0), distance_m: 0.0 }];
    for (u, message) in [(0.23, "no nearer than 0.23684"), (0.6, "no farther than 0.5 m")] {
        lens.focus = Focus::Distance(u);
        let error = Camera::new(&lens, &GRID, DAffine3::IDENTITY, 0.0).expect_err("out of range");
        assert!(error.message.contains(message), "{}", error.message);
    }
    lens.focus = Focus::Distance(0.24);
    assert!(Camera::new(&lens, &GRID, DAffine3::IDENTITY, 0.0).is_ok());
}
