//! Focus by the least spot, zoom between positions.

use glam::{DVec2, DVec3};
use photosite_core::spectrum::dispersion::lines;
use photosite_lens::focus::{Distance, FocusBy};
use photosite_lens::positions::GapCurves;
use photosite_lens::prescription::Position;
use photosite_lens::trace::Apertures;
use photosite_lens::{Lens, Prescription, Ray};
use rstest::rstest;

use crate::neutral::{LENSES, close, prescription, read};

const SPECTRUM: [(f64, f64); 3] = [(lines::F, 1.0), (lines::D, 2.0), (lines::C, 1.0)];

/// Mean square of the heights on the sensor, mm², of rays of a point on the axis that fill a ring of the pupil each.
fn spot(lens: &Lens, distance_mm: f64) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for (nm, weight) in SPECTRUM {
        let at = lens.at(nm);
        let first_order = at.first_order();
        for i in 0..400 {
            let height = 0.55 * first_order.entrance_pupil_diameter_mm * (f64::from(i) / 400.0).sqrt();
            let origin = DVec3::new(0.0, 0.0, -distance_mm);
            let aim = DVec3::new(0.0, height, first_order.entrance_pupil_mm);
            let ray = Ray { origin, direction: (aim - origin).normalize() };
            if let Some(landed) = at.landing(ray, Apertures::Clip) {
                sum += weight * landed.length_squared();
                weights += weight;
            }
        }
    }
    sum / weights
}

/// Spots are larger with the gap a little longer or shorter; the distance counts from the sensor.
#[test]
fn the_spot_is_least_at_the_distance_from_the_sensor() {
    for name in LENSES {
        let lens = Lens::new(&prescription(&read(name))).expect("a lens");
        let distance = 60.0 * lens.at(lines::D).first_order().efl_mm + lens.sensor_z_mm();
        let focused =
            lens.focused_by_spot(FocusBy::WholeLens, Distance::FromSensor(distance), &SPECTRUM).expect("in reach");
        let last = lens.surfaces().len() - 1;
        let spot_at = |by: f64| {
            let moved = focused.with_gaps(&[(last, focused.gap_mm(last) + by)]);
            spot(&moved, distance - moved.sensor_z_mm())
        };
        // Of the parabola through three places the least one is where the lens stands: 400 rings are like 256.
        let step = 0.02 * focused.at(lines::D).first_order().f_number;
        let [before, there, behind] = [-step, 0.0, step].map(spot_at);
        let least = 0.5 * step * (before - behind) / (before - 2.0 * there + behind);
        assert!(there < before && there < behind, "{name}: {before} {there} {behind}");
        close(name, least, 0.0, 0.02 * step);
        // The paraxial focus is another one.
        let paraxial =
            lens.focused_paraxially(FocusBy::WholeLens, Distance::FromSensor(distance), lines::D).expect("in reach");
        assert!((paraxial.gap_mm(last) - focused.gap_mm(last)).abs() > 1e-4, "{name}");
    }
}

#[test]
fn a_lens_without_aberrations_focuses_by_the_lensmakers_equation() {
    let lens = Lens::new(&prescription(&read("cooke-triplet"))).expect("a lens");
    // A stop of nearly nothing leaves a paraxial lens.
    let lens = lens.with_stop_radius(1e-3);
    let at = Distance::FromFirstVertex(2000.0);
    let by_spot = lens.focused_by_spot(FocusBy::WholeLens, at, &[(550.0, 1.0)]).expect("in reach");
    let paraxial = lens.focused_paraxially(FocusBy::WholeLens, at, 550.0).expect("in reach");
    close("last gap", by_spot.gap_mm(5), paraxial.gap_mm(5), 1e-6);
}

#[rstest]
#[case(Distance::FromSensor(40.0))]
#[case(Distance::FromSensor(f64::NAN))]
#[case(Distance::FromFirstVertex(-1.0))]
#[case(Distance::FromFirstVertex(30.0))]
fn what_is_nearer_than_the_focal_length_is_refused(#[case] distance: Distance) {
    let lens = Lens::new(&prescription(&read("cooke-triplet"))).expect("a lens");
    let error = lens.focused_by_spot(FocusBy::WholeLens, distance, &SPECTRUM).expect_err("too near");
    assert!(error.key == "focus_distance_m" && error.message.contains("cannot be focused at"), "{error}");
}

/// Positions of focus are met where they are, and between them the image stays on the sensor.
#[test]
fn focus_follows_the_positions_of_a_prescription() {
    let file = read("zoom-laikin");
    let zoom = Lens::new(&prescription(&file)).expect("a lens");
    let infinity = zoom.focused_paraxially(FocusBy::WholeLens, Distance::Infinity, lines::D).expect("in reach");
    let position = |distance: Distance, object_distance_mm| {
        let lens = infinity.focused_paraxially(FocusBy::FrontGroup(4), distance, lines::D).expect("in reach");
        Position { gaps: vec![(4, lens.gap_mm(4))], object_distance_mm, ..Position::default() }
    };
    let positions = [
        position(Distance::Infinity, None),
        position(Distance::FromFirstVertex(8000.0), Some(8000.0)),
        position(Distance::FromFirstVertex(2000.0), Some(2000.0)),
    ];
    let curves = GapCurves::of_focus(&infinity, &positions).expect("three positions of focus");
    let focused = |distance| infinity.focused_paraxially(FocusBy::Positions(&curves), distance, lines::D);
    for position in &positions {
        let distance = position.object_distance_mm.map_or(Distance::Infinity, Distance::FromFirstVertex);
        let lens = focused(distance).expect("in reach");
        close("at a position", lens.gap_mm(4), position.gaps[0].1, 1e-6);
    }
    let between = focused(Distance::FromFirstVertex(4000.0)).expect("in reach");
    let image = between.at(lines::D).image(4000.0).distance_mm;
    close("between positions", image, between.gap_mm(between.surfaces().len() - 1), 1e-9);
    assert!(focused(Distance::FromFirstVertex(1500.0)).is_err(), "nearer than the last position");
    assert!(GapCurves::of_focus(&zoom, &prescription(&file).positions).is_none(), "positions of a zoom");
}

#[test]
fn a_zoom_goes_through_its_positions_and_keeps_its_focus_between_them() {
    let prescription = prescription(&read("zoom-laikin"));
    let lens = Lens::new(&prescription).expect("a lens");
    let efl = |lens: &Lens| lens.at(lines::D).first_order().efl_mm;
    let defocus = |lens: &Lens| lens.at(lines::D).image(f64::INFINITY).distance_mm - lens.gap_mm(23);
    let mut ends = Vec::new();
    for position in &prescription.positions {
        let there = lens.in_position(position);
        let zoomed = lens.zoomed(&prescription.positions, efl(&there)).expect("in range");
        for &(surface, gap) in &position.gaps {
            close(&position.label, zoomed.gap_mm(surface), gap, 1e-5);
        }
        ends.push(defocus(&there));
    }
    let [low, high] = [f64::min, f64::max].map(|f| ends.iter().copied().reduce(f).expect("four"));
    for focal_length in [15.013, 18.0, 24.0, 50.0, 100.0, 149.0] {
        let zoomed = lens.zoomed(&prescription.positions, focal_length).expect("in range");
        close("focal length", efl(&zoomed) / focal_length, 1.0, 1e-3);
        assert!((low - 1e-9..=high + 1e-9).contains(&defocus(&zoomed)), "{focal_length} mm: {}", defocus(&zoomed));
        let image = zoomed.at(lines::D).landing(Ray { origin: DVec3::ZERO, direction: DVec3::Z }, Apertures::Clip);
        assert_eq!(image, Some(DVec2::ZERO));
    }
    for beyond in [14.0, 160.0, f64::NAN] {
        let error = lens.zoomed(&prescription.positions, beyond).expect_err("out of range");
        assert!(error.key == "focal_length_mm" && error.message.contains("zooms from 15.0"), "{error}");
    }
    let prime = Lens::new(&crate::neutral::prescription(&read("tessar"))).expect("a lens");
    let error = prime.zoomed(&[], 50.0).expect_err("no zoom");
    assert!(error.message.contains("has one focal length"), "{error}");
}

/// A zoom whose front group also focuses has two positions at a distance for each position at infinity. At the
/// positions its gaps are theirs; between them, in zoom and in focus, they are those of the front group alone, which
/// needs no positions.
#[test]
fn a_zoom_with_positions_of_focus_follows_both() {
    const DISTANCES: [f64; 2] = [6000.0, 3000.0];
    let file = prescription(&read("zoom-laikin"));
    let zoom = Lens::new(&file).expect("a lens");
    let efl = |lens: &Lens| lens.at(lines::D).first_order().efl_mm;
    // The sensor follows the image at infinity.
    let surfaces: Vec<usize> = file.positions[0].gaps.iter().map(|(surface, _)| *surface).chain([23]).collect();
    let of_lens = |lens: &Lens, focal_length: f64, distance: Option<f64>| Position {
        gaps: surfaces.iter().map(|surface| (*surface, lens.gap_mm(*surface))).collect(),
        object_distance_mm: distance,
        focal_length_mm: distance.map(|_| focal_length),
        ..Position::default()
    };
    let by_front = |lens: &Lens, distance: Distance| {
        lens.focused_paraxially(FocusBy::FrontGroup(4), distance, lines::D).expect("in reach")
    };
    let mut positions = Vec::new();
    for position in &file.positions {
        let there = zoom.in_position(position);
        let infinity = there.focused_paraxially(FocusBy::WholeLens, Distance::Infinity, lines::D).expect("in reach");
        positions.push(of_lens(&infinity, 0.0, None));
        for distance in DISTANCES {
            let near = by_front(&infinity, Distance::FromFirstVertex(distance));
            // As engraved.
            positions.push(of_lens(&near, (10.0 * efl(&infinity)).round() / 10.0, Some(distance)));
        }
    }
    let prescription = Prescription { positions, ..file.clone() };
    let lens = Lens::new(&prescription).expect("a lens");
    let focused = |focal_length: f64, distance: f64| {
        let zoomed = lens.zoomed(&prescription.positions, focal_length).expect("in range");
        let curves = GapCurves::of_focus(&zoomed, &prescription.positions).expect("positions of focus");
        let focused =
            zoomed.focused_paraxially(FocusBy::Positions(&curves), Distance::FromFirstVertex(distance), lines::D);
        (zoomed, focused)
    };
    for group in prescription.positions.chunks(3) {
        let focal_length = efl(&lens.in_position(&group[0]));
        for position in &group[1..] {
            let (_, there) = focused(focal_length, position.object_distance_mm.expect("a distance"));
            let there = there.expect("in reach");
            for (surface, gap) in &position.gaps {
                close("at a position", there.gap_mm(*surface), *gap, 1e-4);
            }
        }
    }
    for (focal_length, distance) in [(24.0, 8000.0), (50.0, 4000.0), (100.0, 3100.0)] {
        let (zoomed, there) = focused(focal_length, distance);
        let there = there.expect("in reach");
        let front = by_front(&zoomed, Distance::FromFirstVertex(distance));
        close("front group", there.gap_mm(4) - zoomed.gap_mm(4), front.gap_mm(4) - zoomed.gap_mm(4), 1e-4);
        for (surface, _) in prescription.positions[0].gaps.iter().filter(|(surface, _)| *surface != 4) {
            close("other groups", there.gap_mm(*surface), zoomed.gap_mm(*surface), 1e-6);
        }
        close("focal length at infinity", efl(&zoomed) / focal_length, 1.0, 1e-6);
    }
    assert!(focused(50.0, 2000.0).1.is_err(), "nearer than its positions");

    // What does not say where it belongs.
    let refused = |change: &dyn Fn(&mut Vec<Position>)| {
        let mut positions = prescription.positions.clone();
        change(&mut positions);
        Lens::new(&Prescription { positions, ..file.clone() }).expect_err("refused").to_string()
    };
    type Change<'a> = (&'a dyn Fn(&mut Vec<Position>), &'a str);
    let changes: [Change<'_>; 5] = [
        (&|positions| positions[2].focal_length_mm = None, "positions[2]: nothing says which focal length"),
        (&|positions| positions[2].focal_length_mm = Some(20.0), "positions[2]: no position at infinity has its"),
        (&|positions| positions.truncate(4), "no position of the"),
        (
            &|positions| positions[2].object_distance_mm = Some(DISTANCES[0]),
            "positions[2]: it is at 6000 mm, as another",
        ),
        (&|positions| positions.swap(0, 1), "positions[0]: the first position of a zoom must be at infinity"),
    ];
    for (change, message) in changes {
        let error = refused(change);
        assert!(error.contains(message), "{error}");
    }
    let error = refused(&|positions| {
        *positions = vec![file.positions[0].clone(), file.positions[0].clone(), positions[1].clone()]
    });
    assert!(error.contains("positions[1]: it is at infinity as another"), "{error}");
}

/// A stop with blades lets the same light through however it is turned. A square grid of rays over all of the pupil
/// finds where they are least spread.
#[rstest]
#[case::triangle(3)]
#[case::pentagon(5)]
#[case::octagon(8)]
fn the_focus_does_not_turn_with_the_blades(#[case] count: u32) {
    const ACROSS: u32 = 400;
    let focused = |rotation_deg: f64| {
        let blades = Some(photosite_lens::prescription::Blades { count, rotation_deg });
        let lens = Lens::new(&Prescription { blades, ..prescription(&read("double-gauss")) }).expect("a lens");
        lens.focused_by_spot(FocusBy::WholeLens, Distance::Infinity, &SPECTRUM).expect("in reach")
    };
    let turned = [0.0, 11.0, 40.0, 90.0].map(focused);
    let gap = |lens: &Lens| lens.gap_mm(lens.surfaces().len() - 1);
    for lens in &turned {
        close("gap", gap(lens), gap(&turned[0]), 1e-9);
    }
    let lens = &turned[1];
    let (mut products, mut squares) = (0.0, 0.0);
    for (nm, weight) in SPECTRUM {
        let at = lens.at(nm);
        let rim = 0.55 * at.first_order().entrance_pupil_diameter_mm;
        let place = |i: u32| rim * ((f64::from(i) + 0.5) / f64::from(ACROSS) * 2.0 - 1.0);
        for i in 0..ACROSS * ACROSS {
            let ray = Ray { origin: DVec3::new(place(i % ACROSS), place(i / ACROSS), 0.0), direction: DVec3::Z };
            let Ok(behind) = at.trace_in(ray, Apertures::Clip) else { continue };
            let slope = behind.direction.truncate() / behind.direction.z;
            products += weight * behind.at_z(lens.sensor_z_mm()).truncate().dot(slope);
            squares += weight * slope.length_squared();
        }
    }
    // What 256 rings tell of the rim: a ring of the 256 more or less, whose rays land some tenths of a millimetre apart along
    // the axis from the others.
    close("behind the sensor", products / squares, 0.0, 1.0 / 256.0);
}
