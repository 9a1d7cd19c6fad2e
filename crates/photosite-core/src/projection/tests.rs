//! Checks of both directions of every model against each other, against closed forms and against numerical derivatives.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};
use rstest::rstest;

use super::*;

fn brown_conrady(k: [f64; 6], p: [f64; 2], s: [f64; 4]) -> Projection {
    Projection::BrownConrady(BrownConrady { k, p, s })
}

fn radial(k1: f64) -> Projection {
    brown_conrady([k1, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 2], [0.0; 4])
}

#[rstest]
#[case(Projection::Perspective)]
#[case(radial(-0.4))]
#[case(radial(0.4))]
#[case(brown_conrady([-0.3, 0.1, -0.02, 0.0, 0.0, 0.0], [1e-3, -2e-3], [0.0; 4]))]
#[case(brown_conrady([0.8, -0.3, 0.05, 1.1, -0.2, 0.03], [-2e-3, 1e-3], [3e-3, -1e-3, 2e-3, 5e-4]))]
#[case(brown_conrady([0.0; 6], [0.02, -0.03], [0.01, 0.0, -0.02, 0.0]))]
#[case(Projection::Polynomial { k: [0.4, 0.05] })]
#[case(Projection::Polynomial { k: [-0.4, 0.02] })]
#[case(Projection::Division { lambda: -0.3 })]
#[case(Projection::Division { lambda: 0.3 })]
#[case(Projection::KannalaBrandt { k: [0.0; 4] })]
#[case(Projection::KannalaBrandt { k: [-0.02, 0.003, -1e-3, 1e-4] })]
#[case(Projection::KannalaBrandt { k: [0.1, 0.01, 0.0, 0.0] })]
#[case(Projection::ClassicalFisheye(FisheyeProjection::Equisolid))]
#[case(Projection::ClassicalFisheye(FisheyeProjection::Stereographic))]
#[case(Projection::ClassicalFisheye(FisheyeProjection::Orthographic))]
#[case(Projection::Equirectangular)]
#[case(Projection::Omnidirectional { xi: 0.0, distortion: BrownConrady::default() })]
#[case(Projection::Omnidirectional { xi: 1.0, distortion: BrownConrady::default() })]
#[case(Projection::Omnidirectional {
    xi: 1.6,
    distortion: BrownConrady { k: [-0.2, 0.1, 0.0, 0.0, 0.0, 0.0], p: [1e-3, -2e-3], s: [0.0; 4] },
})]
fn both_directions_agree_up_to_the_reach(#[case] projection: Projection) {
    let reach = projection.reach(None);
    for i in 0..=60 {
        // Near the end of the reach as well, where the derivative of a fold vanishes; flat images end far away.
        let angle = reach.angle.min(1.5) * (f64::from(i) / 60.0).sqrt() * (1.0 - 1e-9);
        for j in 0..12 {
            let about = DVec2::from_angle(f64::from(j) * PI / 6.0 + 0.1);
            let direction = (about * angle.sin()).extend(angle.cos());
            let place = projection.project(direction, &reach).expect("within reach");
            let seen = projection.unproject(place, &reach).unwrap_or_else(|| panic!("{angle} {about}: {place}"));
            let again = projection.project(seen.direction, &reach).expect("what is seen is within reach");
            // Some ten roundings of numbers as large as the place; where the inverse folds, they grow by one over its
            // slope, √(2·1e-9) at the last angle. An image of 4000 px is held to 1e-7 px.
            assert!((again - place).length() < 2e-11 * (1.0 + place.length()), "{angle} {about}: {place} {again}");
            // Where nothing folds, the direction is as good.
            if angle < 0.9 * reach.angle && angle < 1.4 {
                assert!(
                    (seen.direction - direction).length() < 1e-11,
                    "{angle} {about}: {} {direction}",
                    seen.direction
                );
                let expected = numerical_solid_angle(&projection, place, &reach);
                // Central differences at steps of 1e-5 of functions with third derivatives of some hundreds.
                assert!((seen.solid_angle / expected - 1.0).abs() < 1e-6, "{angle}: {} {expected}", seen.solid_angle);
            }
        }
    }
}

/// |∂d/∂x × ∂d/∂y| of the unit direction d.
fn numerical_solid_angle(projection: &Projection, place: DVec2, reach: &Reach) -> f64 {
    let step = 1e-5;
    let along = |axis: DVec2| {
        let at = |sign: f64| projection.unproject(place + axis * (sign * step), reach).expect("inside").direction;
        (at(1.0) - at(-1.0)) / (2.0 * step)
    };
    along(DVec2::X).cross(along(DVec2::Y)).length()
}

#[test]
fn folds_are_where_derivatives_vanish() {
    // r − 0.3r³ is largest at r = 1/√0.9; 1 + 3·(−0.3)θ² vanishes at the same θ.
    let largest = 1.0 / 0.9_f64.sqrt();
    for (projection, angle) in [
        (radial(-0.3), largest.atan()),
        (Projection::KannalaBrandt { k: [-0.3, 0.0, 0.0, 0.0] }, largest),
        (Projection::Polynomial { k: [-0.3, 0.0] }, (largest * (1.0 - 0.3 * largest * largest)).atan()),
        // r/(1 + 0.25r²) is largest, 1, at r = 2.
        (Projection::Division { lambda: 0.25 }, 1.0_f64.atan()),
    ] {
        let reach = projection.reach(None);
        assert_eq!(reach.end, ReachEnd::Folds, "{projection:?}");
        assert!((reach.angle - angle).abs() < 1e-12, "{projection:?}: {} {angle}", reach.angle);
        assert!(projection.unproject(DVec2::X * 2.1, &reach).is_none(), "{projection:?}");
    }
    // A denominator that vanishes: 1 − r² at r = 1.
    let pole = brown_conrady([0.0, 0.0, 0.0, -1.0, 0.0, 0.0], [0.0; 2], [0.0; 4]).reach(None);
    assert!((pole.angle - PI / 4.0).abs() < 1e-9, "{}", pole.angle);
    // Tangential distortion alone: the determinant of x' = x + 2pxy, y' = y + p(r² + 2y²) is (1 + 2py)(1 + 6py) −
    // 4p²x², which vanishes first at y = −1/(6p).
    let tangential = brown_conrady([0.0; 6], [0.1, 0.0], [0.0; 4]).reach(None);
    assert!((tangential.angle.tan() - 1.0 / 0.6).abs() < 1e-3, "{}", tangential.angle.tan());
}

#[test]
fn images_without_a_fold_reach_as_far_as_the_model_can_see() {
    assert_eq!(radial(0.4).reach(None).end, ReachEnd::Flat);
    // The whole sphere of a fisheye, and what a mirror shows.
    assert_eq!(Projection::KannalaBrandt { k: [0.0; 4] }.reach(None).angle, PI);
    let mirror = |xi| Projection::Omnidirectional { xi, distortion: BrownConrady::default() }.reach(None);
    assert!((mirror(2.0).angle - (-0.5_f64).acos()).abs() < 1e-7);
    // An image of 5730 focal lengths of a hyperbolic mirror ends just before cos θ = −ξ.
    assert!((mirror(0.5).angle - (-0.5_f64).acos()).abs() < 1e-3);
    let cut = Projection::KannalaBrandt { k: [0.0; 4] }.reach(Some(1.0));
    assert_eq!((cut.angle, cut.end), (1.0, ReachEnd::Sees));
}

#[test]
fn closed_forms() {
    let at = |projection: Projection, direction: DVec3| {
        projection.project(direction, &projection.reach(None)).expect("within reach")
    };
    let right = DVec3::X;
    let behind = DVec3::new(1.0, 0.0, -1.0);
    let close = |found: DVec2, x: f64, y: f64| assert!((found - DVec2::new(x, y)).length() < 1e-14, "{found} {x} {y}");
    close(at(Projection::KannalaBrandt { k: [0.0; 4] }, right), FRAC_PI_2, 0.0);
    close(at(Projection::KannalaBrandt { k: [0.0; 4] }, behind), 0.75 * PI, 0.0);
    let fisheye = |law| Projection::ClassicalFisheye(law);
    close(at(fisheye(FisheyeProjection::Equisolid), right), 2.0_f64.sqrt(), 0.0);
    close(at(fisheye(FisheyeProjection::Equisolid), -DVec3::Z), 2.0, 0.0);
    close(at(fisheye(FisheyeProjection::Stereographic), right), 2.0, 0.0);
    close(at(fisheye(FisheyeProjection::Stereographic), behind), 2.0 * (0.375 * PI).tan(), 0.0);
    close(at(fisheye(FisheyeProjection::Orthographic), right), 1.0, 0.0);
    close(at(fisheye(FisheyeProjection::Orthographic), DVec3::new(3.0, 4.0, 12.0)), 3.0 / 13.0, 4.0 / 13.0);
    close(at(Projection::Equirectangular, behind), 0.75 * PI, 0.0);
    close(at(Projection::Equirectangular, DVec3::Y), 0.0, FRAC_PI_2);
    let parabolic = Projection::Omnidirectional { xi: 1.0, distortion: BrownConrady::default() };
    // tan(θ/2) of a parabolic mirror.
    close(at(parabolic, right), 1.0, 0.0);
    close(at(parabolic, behind), (0.375 * PI).tan(), 0.0);
    // u = u_d(1 + 0.5·u_d²) = 1.5 at u_d = 1; u = u_d/(1 − u_d²/4) = 4/3 at 1.
    close(at(Projection::Polynomial { k: [0.5, 0.0] }, DVec3::new(0.0, 1.5, 1.0)), 0.0, 1.0);
    close(at(Projection::Division { lambda: -0.25 }, DVec3::new(4.0 / 3.0, 0.0, 1.0)), 1.0, 0.0);
    close(at(radial(0.1), DVec3::new(3.0, 4.0, 5.0)), 0.66, 0.88);
}

#[test]
fn models_are_told_by_name_and_coefficients() {
    let k = [0.1, -0.2, 0.3, -0.4, 0.5, -0.6];
    let distortion = BrownConrady { k, p: [0.7, -0.8], s: [0.9, -1.0, 1.1, -1.2] };
    let short = BrownConrady { k: [0.1, -0.2, 0.0, 0.0, 0.0, 0.0], s: [0.0; 4], ..distortion };
    for (model, xi) in [
        (Projection::Perspective, None),
        (Projection::BrownConrady(distortion), None),
        (Projection::BrownConrady(BrownConrady { s: [0.0; 4], ..distortion }), None),
        (Projection::BrownConrady(short), None),
        (Projection::Polynomial { k: [0.1, 0.2] }, None),
        (Projection::Division { lambda: -0.1 }, None),
        (Projection::KannalaBrandt { k: [0.1, 0.2, 0.3, 0.4] }, None),
        (Projection::ClassicalFisheye(FisheyeProjection::Equisolid), None),
        (Projection::ClassicalFisheye(FisheyeProjection::Stereographic), None),
        (Projection::ClassicalFisheye(FisheyeProjection::Orthographic), None),
        (Projection::Equirectangular, None),
        (Projection::Omnidirectional { xi: 1.1, distortion: short }, Some(1.1)),
    ] {
        assert_eq!(Projection::named(model.name(), &model.coefficients(), xi), Some(model));
    }
    assert_eq!(Projection::named("brown-conrad", &[], None), None);
}
