//! Whole files, made here: their meaning, and errors of damaged ones.

use glam::Vec3;
use rstest::rstest;

use super::*;

fn read_bytes(bytes: &[u8]) -> Result<SceneDescription> {
    parse(bytes, Path::new("in/my part.stl"), MissingNormals::Flat)
}

fn error(bytes: &[u8]) -> String {
    read_bytes(bytes).expect_err("to be refused").to_string()
}

/// The facets of a tetrahedron.
const FACETS: [[[f32; 3]; 3]; 4] = [
    [[0., 0., 0.], [0., 1., 0.], [1., 0., 0.]],
    [[0., 0., 0.], [0., 0., 1.5e-3], [0., 1., 0.]],
    [[0., 0., 0.], [1., 0., 0.], [0., 0., 1.5e-3]],
    [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.5e-3]],
];
const NORMALS: [[f32; 3]; 4] = [[0., 0., -1.], [-1., 0., 0.], [0., -1., 0.], [0., 0., 1.]];

fn solid(name: &str, facets: &[[[f32; 3]; 3]]) -> String {
    let facet = |([a, b, c], n): (&[[f32; 3]; 3], &[f32; 3])| {
        let [n, a, b, c] = [n, a, b, c].map(|[x, y, z]| format!("{x:e} {y} {z:e}"));
        format!(
            "  facet normal {n}\n    outer loop\n      vertex {a}\n      vertex {b}\n      vertex {c}\n    endloop\n  endfacet\n"
        )
    };
    let facets: String = facets.iter().zip(&NORMALS).map(facet).collect();
    format!("solid {name}\n{facets}endsolid {name}\n")
}

fn binary(head: &[u8], facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = head.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((facets.len() as u32).to_le_bytes());
    for (facet, normal) in facets.iter().zip(&NORMALS) {
        bytes.extend(normal.iter().chain(facet.as_flattened()).flat_map(|number| number.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

#[test]
fn both_kinds_say_the_same() {
    let upper = solid("my part", &FACETS).to_uppercase().replace('E', "e");
    let kinds = [
        solid("my part", &FACETS).into_bytes(),
        solid("my part", &FACETS).replace('\n', "\r\n").into_bytes(),
        upper.replace("MY PART", "my part").into_bytes(),
        solid("", &FACETS).into_bytes(),
        binary(b"a head", &FACETS),
        binary(b"solid of a program that does not know better", &FACETS),
    ];
    for bytes in kinds {
        let scene = read_bytes(&bytes).expect("valid");
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::Y, Vec3::X, Vec3::new(0.0, 0.0, 1.5e-3)], "each once");
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [2, 1, 3]]);
        assert!(mesh.normals.is_empty() && mesh.uvs.is_empty() && mesh.colours.is_empty());
        assert_eq!(
            (&*mesh.name, &*scene.instances[0].name, &*scene.materials[0].name),
            ("my part", "my part", "my part")
        );
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
}

#[test]
fn solids_are_meshes() {
    let text = solid("left  one", &FACETS[..1]) + &solid("nothing", &[]) + "\n" + &solid("", &FACETS[1..]);
    let scene = read_bytes(text.as_bytes()).expect("valid");
    let found: Vec<_> = scene.meshes.iter().map(|mesh| (&*mesh.name, mesh.triangles.len(), mesh.material)).collect();
    assert_eq!(found, [("left  one", 1, 0), ("my part", 3, 0)]);
    assert_eq!(scene.instances.len(), 2);
}

#[test]
fn normals_are_smooth_on_request() {
    let smooth = parse(&binary(b"", &FACETS), Path::new("a.stl"), MissingNormals::Smooth).expect("valid");
    assert_eq!(smooth.meshes[0].normals.len(), 4);
    assert!(smooth.meshes[0].normals[0].max_element() < 0.0, "the corner at the origin points away from all others");
}

#[test]
fn zeros_of_either_sign_are_the_same_place() {
    let text = solid("a", &FACETS).replacen("vertex 0e0 0 0e0", "vertex -0 0 -0.0", 2);
    assert!(text.contains("-0.0"));
    assert_eq!(read_bytes(text.as_bytes()).expect("valid").meshes[0].positions.len(), 4);
}

#[test]
fn what_would_show_is_told_when_it_is_left_out() {
    let warning = |bytes: &[u8]| {
        let warnings = read_bytes(bytes).expect("valid").warnings;
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        warnings[0].clone()
    };
    let mut turned = FACETS;
    turned[0].swap(0, 1);
    turned[2].swap(1, 2);
    for bytes in [binary(b"", &turned), solid("", &turned).into_bytes()] {
        assert!(
            warning(&bytes)
                .starts_with("in/my part.stl: the normals of 2 of 4 facets contradict the order of their corners")
        );
    }
    let mut coloured = binary(b"COLOR=", &FACETS);
    coloured[84 + 48] = 0x1f;
    coloured[84 + 99] = 0x80;
    assert!(warning(&coloured).contains("the attributes of 2 facets"));
    let longer = [binary(b"", &FACETS), vec![0; 7]].concat();
    assert!(warning(&longer).contains("7 bytes behind the 4 facets that are announced are left out"));
    // No area, no normal: that programs write what is no number there is no damage.
    let flat =
        solid("", &[[[0.; 3], [1., 0., 0.], [1., 0., 0.]], FACETS[1]]).replacen("0e0 0 -1e0", "-nan(ind) nan inf", 1);
    assert!(warning(flat.as_bytes()).contains("1 triangle of zero area"), "{flat}");
}

#[rstest]
#[case::word("facet normal", "fact normal", ":2: \"facet\" or \"endsolid\" must follow, not \"fact\"")]
#[case::normal("facet normal", "facet norm", ":2: \"normal\" must follow, not \"norm\"")]
#[case::two_corners("vertex 1e0 0 0e0\n", "", ":6: \"vertex\" must follow, not \"endloop\"")]
#[case::four_corners(
    "vertex 1e0 0 0e0\n",
    "vertex 1 0 0\nvertex 1 0 0\n",
    ":7: \"endloop\" must follow, not \"vertex\""
)]
#[case::number("vertex 1e0 0", "vertex 1,0 0", ":6: a number must follow, not \"1,0\"")]
#[case::two_numbers("vertex 1e0 0 0e0\n", "vertex 1 0\n", ":7: a number must follow, not \"endloop\"")]
#[case::not_a_number("vertex 1e0 0", "vertex nan 0", ":8: vertex: is not finite: [NaN, 0, 0]")]
#[case::infinite("vertex 1e0 0", "vertex 1e39 0", ":8: vertex: is not finite: [inf, 0, 0]")]
#[case::no_end("endsolid a b\n", "", ":29: the file ends where \"facet\" or \"endsolid\" must follow")]
#[case::more("endsolid a b\n", "endsolid a b\nendsolid\n", ":31: \"solid\" must follow, not \"endsolid\"")]
fn damaged_texts_are_refused_with_their_line(#[case] from: &str, #[case] to: &str, #[case] message: &str) {
    let text = solid("a b", &FACETS);
    assert!(text.contains(from), "{from}");
    let error = error(text.replacen(from, to, 1).as_bytes());
    assert!(error.starts_with(&format!("in/my part.stl{message}")), "{error}");
}

#[test]
fn damaged_binary_files_are_refused_with_what_they_lack() {
    let bytes = binary(b"", &FACETS);
    let refused = |bytes: &[u8], message: &str| {
        let error = error(bytes);
        assert!(error.starts_with("in/my part.stl: ") && error.contains(message), "{error}");
    };
    refused(&[], "is not an STL file");
    refused(b"ply\n", "is not an STL file");
    refused(&bytes[..83], "is not an STL file");
    refused(&bytes[..bytes.len() - 1], "is truncated: 4 facets are announced, but only 3 follow");
    refused(&binary(b"", &[]), "has no triangles");
    refused(b"solid a\nendsolid a\n", "has no triangles");
    refused(&binary(b"solid", &FACETS)[..150], "is truncated: 4 facets are announced, but only 1 follow");
    let mut damaged = bytes.clone();
    damaged[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    refused(&damaged, "is truncated: 4294967295 facets are announced, but only 4 follow");
    let mut damaged = bytes.clone();
    damaged[84 + 50 + 16..][..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    refused(&damaged, "facet 1 (from byte 134).vertex: is not finite: [0, inf, 0]");
    refused(&binary(b"", &[[[0.; 3]; 3]]), "has no triangles but 1 of zero area");
}

#[test]
fn every_prefix_is_refused_and_no_damage_makes_a_file_panic() {
    for bytes in [binary(b"solid", &FACETS), solid("a b", &FACETS).into_bytes()] {
        let last = bytes.trim_ascii_end().len() - " a b".len();
        for len in 0..last {
            assert!(read_bytes(&bytes[..len]).is_err(), "{len} of {}", bytes.len());
            for flip in [0x01, 0x10, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[len] ^= flip;
                let _ = parse(&damaged, Path::new("damaged.stl"), MissingNormals::Smooth);
            }
        }
    }
}
