//! What holds for targets of every kind, and what each shows where.

use glam::{DAffine3, DVec2, Vec3};
use rstest::rstest;

use super::*;
use photosite_core::math::hash::hash64;

fn all() -> impl Iterator<Item = (TargetKind, Target)> {
    TargetKind::ALL.iter().map(|kind| (*kind, kind.default_description().draw().expect("defaults are possible")))
}

/// Area of the triangles in each mesh, by the name of its ink.
fn areas(target: &Target) -> Vec<(String, f64)> {
    let area = |[a, b, c]: [Vec3; 3]| {
        // Away from the front is +z, so triangles wind the other way.
        let normal = (b - a).as_dvec3().cross((c - a).as_dvec3());
        assert!(normal.z < 0.0, "a triangle looks away from the front");
        normal.length() / 2.0
    };
    let meshes = target.meshes("t").into_iter().map(|(material, mesh)| {
        let triangles = mesh.triangles.iter().map(|t| area(t.map(|corner| mesh.positions[corner as usize])));
        (material.name, triangles.sum())
    });
    meshes.collect()
}

#[test]
fn inks_cover_the_sheet_once() {
    for (kind, target) in all() {
        let size = target.size_m();
        let total: f64 = areas(&target).iter().map(|(_, area)| area).sum();
        // Corners are f32, off by 2⁻²⁵ of up to 0.25 m; what one triangle loses its neighbour gains but at the edge.
        assert!((total / (size.x * size.y) - 1.0).abs() < 1e-6, "{}: {total}", kind.name());
    }
}

/// Areas by hand, in mm².
#[rstest]
#[case::chessboard(TargetKind::Chessboard, 35.0 * 25.0 * 25.0)]
#[case::circle_grid(TargetKind::CircleGrid, 63.0 * std::f64::consts::PI * 36.0)]
#[case::asymmetric(TargetKind::AsymmetricCircleGrid, 44.0 * std::f64::consts::PI * 56.25)]
#[case::dots(TargetKind::DotChart, 425.0 * std::f64::consts::PI * 6.25)]
#[case::star(TargetKind::SiemensStar, std::f64::consts::PI * 90.0 * 90.0 / 2.0)]
#[case::slanted_edge(TargetKind::SlantedEdge, 1e4)]
fn the_second_ink_covers_what_it_should(#[case] kind: TargetKind, #[case] area_mm2: f64) {
    let target = kind.default_description().draw().expect("possible");
    let (name, area) = areas(&target).swap_remove(1);
    // The polygon of a disc has its area; that of the star's rim lacks (2π/288)²/6 = 8e-5 of it.
    assert!((area * 1e6 / area_mm2 - 1.0).abs() < 1e-4, "{name}: {} instead of {area_mm2}", area * 1e6);
}

/// The ink that a place of the sheet has in the mesh.
fn ink_at(target: &Target, meshes: &[(MaterialName, Vec<[DVec2; 3]>)], place: DVec2) -> String {
    let inside = |[a, b, c]: &[DVec2; 3]| {
        let side = |p: DVec2, q: DVec2| (q - p).perp_dot(place - p);
        let sides = [side(*a, *b), side(*b, *c), side(*c, *a)];
        sides.iter().all(|s| *s <= 0.0) || sides.iter().all(|s| *s >= 0.0)
    };
    let found = meshes.iter().find(|(_, triangles)| triangles.iter().any(inside));
    found.map(|(name, _)| name.clone()).unwrap_or_else(|| panic!("no triangle at {place} of {:?}", target.sheet))
}

type MaterialName = String;

fn flat_meshes(target: &Target) -> Vec<(MaterialName, Vec<[DVec2; 3]>)> {
    let meshes = target.meshes("t").into_iter().map(|(material, mesh)| {
        let corner = |c: u32| mesh.positions[c as usize].truncate().as_dvec2();
        (material.name, mesh.triangles.iter().map(|t| t.map(corner)).collect())
    });
    meshes.collect()
}

/// Places all over the sheet, the same every time.
fn places(target: &Target) -> impl Iterator<Item = DVec2> {
    let [low, size] = [target.sheet[0], target.size_m()];
    (0..300).map(move |i| {
        let part = |seed| (hash64(seed, i) >> 11) as f64 / (1u64 << 53) as f64;
        low + size * DVec2::new(part(1), part(2))
    })
}

#[test]
fn chessboards_have_black_where_rows_and_columns_say() {
    let target = TargetKind::Chessboard.default_description().draw().expect("possible");
    let meshes = flat_meshes(&target);
    for place in places(&target) {
        let square = (place / 0.025).floor();
        let on_board = (-1.0..9.0).contains(&square.x) && (-1.0..6.0).contains(&square.y);
        let black = on_board && (square.x + square.y).rem_euclid(2.0) == 0.0;
        assert_eq!(ink_at(&target, &meshes, place), if black { "t-black" } else { "t-white" }, "{place}");
    }
    assert_eq!(target.points.len(), 9 * 6);
    assert_eq!(target.points[10].position_m, DVec2::new(0.025, 0.025));
}

#[test]
fn markers_show_their_bits() {
    for (kind, turned) in [(TargetKind::Charuco, false), (TargetKind::MarkerGrid, false), (TargetKind::AprilGrid, true)]
    {
        let target = kind.default_description().draw().expect("possible");
        let meshes = flat_meshes(&target);
        for marker in target.markers.iter().step_by(7) {
            let dictionary = markers::Dictionary::named(marker.dictionary).expect("known");
            let border = if turned { 2 } else { 1 };
            let cells = dictionary.bits + 2 * border;
            let [origin, right, _, down] = marker.corners_m;
            for i in 0..cells * cells {
                let (column, row) = (i % cells, i / cells);
                let part = |i: u32| (f64::from(i) + 0.5) / f64::from(cells);
                let place = origin + (right - origin) * part(column) + (down - origin) * part(row);
                let bits = border..cells - border;
                let white = bits.contains(&column)
                    && bits.contains(&row)
                    && dictionary.is_white(marker.id, column - border, row - border);
                let wanted = if white { "t-white" } else { "t-black" };
                assert_eq!(ink_at(&target, &meshes, place), wanted, "{} {column} {row}", marker.id);
            }
        }
    }
}

#[test]
fn kalibr_finds_its_first_tag_at_the_bottom_left() {
    let target = TargetKind::AprilGrid.default_description().draw().expect("possible");
    let [_, _, top_left, _] = target.markers[0].corners_m;
    // Corners begin with OpenCV's top left, which is the bottom right of a tag as Kalibr has it.
    assert_eq!(top_left, DVec2::new(0.0, -0.024));
    assert_eq!(target.points[1].position_m, DVec2::new(0.024, 0.0));
    assert_eq!(target.points[12].position_m, DVec2::new(0.0, -0.024));
    assert!(target.markers[6].corners_m[0].y < target.markers[0].corners_m[0].y);
    // The square at the bottom left of the first tag.
    assert_eq!(ink_at(&target, &flat_meshes(&target), DVec2::new(-0.001, 0.001)), "t-black");
}

#[test]
fn points_lie_on_the_sheet_and_have_names_of_their_own() {
    for (kind, target) in all() {
        let [low, high] = target.sheet;
        let mut names: Vec<&str> = target.points.iter().map(|point| point.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), target.points.len(), "{}", kind.name());
        assert!(!target.points.is_empty());
        for point in &target.points {
            let place = point.position_m;
            assert!(place.cmpge(low).all() && place.cmple(high).all(), "{}: {place}", kind.name());
        }
    }
}

#[test]
fn the_largest_dictionary_fits_on_a_sheet() {
    let grid = MarkerGrid {
        markers: [58, 40],
        dictionary: "DICT_APRILTAG_36h10".to_owned(),
        marker_mm: 10.0,
        separation_mm: 3.0,
        ..MarkerGrid::default()
    };
    let target = grid.draw().expect("2320 markers");
    let black: f64 = target
        .markers
        .iter()
        .map(|marker| {
            let dictionary = markers::Dictionary::named(marker.dictionary).expect("known");
            let white = (0..36).filter(|i| dictionary.is_white(marker.id, i % 6, i / 6)).count();
            (64 - white) as f64 * (0.01f64 / 8.0).powi(2)
        })
        .sum();
    // As for the whole sheet; the parts of 0.76 m are larger.
    assert!((areas(&target)[1].1 / black - 1.0).abs() < 1e-5);
}

#[test]
fn patches_have_their_spectra() {
    let target = TargetKind::ColourChecker.default_description().draw().expect("possible");
    let meshes = flat_meshes(&target);
    assert_eq!(target.points.len(), 24);
    for point in &target.points {
        assert_eq!(ink_at(&target, &meshes, point.position_m), format!("t-{}", point.name));
    }
    // Nikon's "red" is red, and the row of greys ends in black at the bottom right.
    let ink = |name: &str| target.inks.iter().find(|ink| ink.name == name).expect("a patch").print;
    assert!(ink("15-red")[0] > 2 * ink("15-red")[2] && ink("24-black").iter().all(|value| *value < 64));
    assert!(target.points[23].position_m.x > 0.1 && target.points[23].position_m.y > 0.05);
}

#[rstest]
#[case::too_few("squares", Chessboard { squares: [1, 7], ..Chessboard::default() }.draw())]
#[case::too_many("squares", Chessboard { squares: [4_000_000_000, 4_000_000_000], ..Chessboard::default() }.draw())]
#[case::not_a_length("square_mm", Chessboard { square_mm: f64::NAN, ..Chessboard::default() }.draw())]
#[case::negative("margin_mm", Chessboard { margin_mm: Some(-1.0), ..Chessboard::default() }.draw())]
#[case::marker_too_large("marker_mm", Charuco { marker_mm: 30.0, ..Charuco::default() }.draw())]
#[case::too_few_markers("dictionary", Charuco { dictionary: "DICT_APRILTAG_16h5".to_owned(), squares: [9, 9], ..Charuco::default() }.draw())]
#[case::unknown_dictionary("dictionary", MarkerGrid { dictionary: "DICT_8X8_50".to_owned(), ..MarkerGrid::default() }.draw())]
#[case::id_overflow("dictionary", MarkerGrid { first_id: u32::MAX, ..MarkerGrid::default() }.draw())]
#[case::border("border_bits", MarkerGrid { border_bits: 0, ..MarkerGrid::default() }.draw())]
#[case::too_many_tags("tags", AprilGrid { tags: [30, 30], ..AprilGrid::default() }.draw())]
#[case::circles_touch("diameter_mm", CircleGrid { diameter_mm: 20.0, ..CircleGrid::default() }.draw())]
#[case::circles_at_the_edge("margin_mm", CircleGrid { margin_mm: Some(5.0), ..CircleGrid::default() }.draw())]
#[case::no_middle("dots", DotChart { dots: [10, 7], ..DotChart::default() }.draw())]
#[case::straight("angle_deg", SlantedEdge { angle_deg: 0.0, ..SlantedEdge::default() }.draw())]
#[case::odd_steps("grey_steps", EsfrChart { grey_steps: 7, ..EsfrChart::default() }.draw())]
#[case::too_dark("density_step", GreyWedge { density_step: 1.0, ..GreyWedge::default() }.draw())]
#[case::too_bright("reflectance", Flat { reflectance: 1.5, ..Flat::default() }.draw())]
fn impossible_sizes_are_told(#[case] key: &str, #[case] drawn: Result<Target, Invalid>) {
    let invalid = drawn.expect_err("impossible");
    assert_eq!(invalid.key, key, "{invalid}");
}

#[test]
fn placed_points_are_where_the_frame_puts_them() {
    let description = TargetKind::Chessboard.default_description();
    let target = description.draw().expect("possible");
    let to_world = DAffine3::from_translation(glam::DVec3::new(1.0, 2.0, 3.0));
    let placed = PlacedTarget { name: "board".to_owned(), description, target, to_world };
    let (name, point) = placed.points().nth(9).expect("54 points");
    assert_eq!((name, point), ("9", glam::DVec3::new(1.0, 2.025, 3.0)));
}
