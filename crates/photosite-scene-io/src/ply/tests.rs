//! Whole files, made here: their meaning, and errors of damaged ones.

use std::fs;

use glam::{Vec2, Vec3, Vec4};
use rstest::rstest;

use super::*;
use photosite_core::spectrum::rgb;
use photosite_transport::scene::description::{AlphaMode, MaterialModel};
use photosite_transport::scene::description::{Diffuse, MeshDescription};
use photosite_transport::texture::Texels;

/// The header of a file, and its values as text or as bytes of a type each.
fn file(form: &str, header: &str, rows: &str) -> Vec<u8> {
    let mut bytes = format!("ply\nformat {form} 1.0\n{header}end_header\n").into_bytes();
    if form == "ascii" {
        bytes.extend(rows.bytes());
        return bytes;
    }
    let kinds: Vec<Vec<&str>> = elements(header);
    for (row, kinds) in rows.lines().zip(kinds) {
        let mut words = row.split_whitespace();
        let mut push = |kind: &str, word: &str| {
            let mut value = match kind {
                "char" | "int8" => word.parse::<i8>().expect(word).to_le_bytes().to_vec(),
                "uchar" | "uint8" => word.parse::<u8>().expect(word).to_le_bytes().to_vec(),
                "short" | "int16" => word.parse::<i16>().expect(word).to_le_bytes().to_vec(),
                "ushort" | "uint16" => word.parse::<u16>().expect(word).to_le_bytes().to_vec(),
                "int" | "int32" => word.parse::<i32>().expect(word).to_le_bytes().to_vec(),
                "uint" | "uint32" => word.parse::<u32>().expect(word).to_le_bytes().to_vec(),
                "float" | "float32" => word.parse::<f32>().expect(word).to_le_bytes().to_vec(),
                "double" | "float64" => word.parse::<f64>().expect(word).to_le_bytes().to_vec(),
                _ => panic!("{kind}"),
            };
            if form == "binary_big_endian" {
                value.reverse();
            }
            bytes.extend(value);
        };
        for kind in kinds {
            let word = words.next().expect("a value");
            match kind.strip_prefix("list ").and_then(|kinds| kinds.split_once(' ')) {
                None => push(kind, word),
                Some((length, item)) => {
                    push(length, word);
                    (0..word.parse().expect(word)).for_each(|_| push(item, words.next().expect("an item")));
                }
            }
        }
    }
    bytes
}

/// The types of each row.
fn elements(header: &str) -> Vec<Vec<&str>> {
    let mut elements: Vec<(usize, Vec<&str>)> = Vec::new();
    for line in header.lines() {
        if let Some(element) = line.strip_prefix("element ") {
            elements.push((element.rsplit(' ').next().expect("a count").parse().expect("a count"), Vec::new()));
        } else if let Some(property) = line.strip_prefix("property ") {
            elements.last_mut().expect("an element").1.push(property.rsplit_once(' ').expect("a name").0);
        }
    }
    elements.into_iter().flat_map(|(count, kinds)| std::iter::repeat_n(kinds, count)).collect()
}

const FORMS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

/// A square of two triangles.
const HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element face 2\nproperty list uchar int vertex_indices\n";
const ROWS: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0.1\n3 0 1 2\n3 0 2 3\n";

fn read_bytes(bytes: &[u8]) -> Result<SceneDescription> {
    parse(bytes, Path::new("in/my mesh.ply"), MissingNormals::Flat, &Sandbox::default())
}

fn scene(header: &str, rows: &str) -> SceneDescription {
    read_bytes(&file("ascii", header, rows)).expect("a valid file")
}

fn mesh(header: &str, rows: &str) -> MeshDescription {
    MeshDescription::clone(&scene(header, rows).meshes[0])
}

/// Message of the error that refuses a file with these changes.
fn error(header: &str, rows: &str) -> String {
    read_bytes(&file("ascii", header, rows)).expect_err("to be refused").to_string()
}

#[test]
fn all_forms_say_the_same() {
    for form in FORMS {
        let scene = read_bytes(&file(form, HEADER, ROWS)).expect(form);
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.positions, [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.1]].map(Vec3::from), "{form}");
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert!(mesh.normals.is_empty() && mesh.uvs.is_empty() && mesh.colours.is_empty());
        assert_eq!(
            (&*mesh.name, &*scene.instances[0].name, &*scene.materials[0].name),
            ("my mesh", "my mesh", "my mesh")
        );
        let MaterialModel::Diffuse(Diffuse { reflectance }) = &scene.materials[0].model else { panic!("not diffuse") };
        assert!(matches!(reflectance.colour, Colour::Rgb([0.5, 0.5, 0.5])) && scene.materials[0].double_sided);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
}

#[rstest]
#[case::first(["char", "uchar", "short", "ushort", "int", "uint", "float", "double"])]
#[case::second(["int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"])]
fn all_types_are_read_by_both_names(#[case] names: [&str; 8], #[values(0, 1, 2)] form: usize) {
    // The largest numbers of each type beside the coordinates, which have it, too.
    let extremes = ["-128", "255", "-32768", "65535", "-2147483648", "4294967295", "-3.5e38", "1e-300"];
    for (i, name) in names.into_iter().enumerate() {
        let extreme = if name.starts_with("float") && !name.ends_with("64") { "-3.4e38" } else { extremes[i] };
        let header = format!(
            "element vertex 3\nproperty {name} x\nproperty {name} y\nproperty {name} extreme\nproperty {name} z\n\
             element face 1\nproperty list {} {} vertex_index\n",
            if i < 6 { name } else { "int" },
            names[i]
        );
        let rows = format!("0 1 {extreme} 2\n100 0 {extreme} 0\n0 100 {extreme} 0\n3 0 1 2\n");
        let scene = read_bytes(&file(FORMS[form], &header, &rows)).expect(name);
        assert_eq!(scene.meshes[0].positions, [[0., 1., 2.], [100., 0., 0.], [0., 100., 0.]].map(Vec3::from), "{name}");
        assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]], "{name}");
    }
}

#[test]
fn normals_uv_and_colours_are_those_of_the_vertices() {
    let with = |properties: &str| HEADER.replace("float z\n", &format!("float z\n{properties}"));
    let rows =
        |values: &str| ROWS.replace(" 0\n", &format!(" 0 {values}\n")).replace(" 0.1\n", &format!(" 0.1 {values}\n"));
    let normals = with("property float nx\nproperty float ny\nproperty float nz\n");
    assert_eq!(mesh(&normals, &rows("0 0 2")).normals, [Vec3::Z; 4], "unit length");
    for [u, v] in [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["s0", "t0"]] {
        let header = with(&format!("property float {u}\nproperty float {v}\n"));
        assert_eq!(mesh(&header, &rows("0.25 0.75")).uvs, [[Vec2::new(0.25, 0.25); 4]], "v grows downwards");
    }
    let encoded = [51.0f32, 102.0, 204.0].map(|c| rgb::decode(c / 255.0));
    let cases = [
        ("uchar", ["red", "green", "blue"], "51 102 204", encoded),
        ("uchar", ["r", "g", "b"], "51 102 204", encoded),
        ("ushort", ["diffuse_red", "diffuse_green", "diffuse_blue"], "13107 26214 52428", encoded),
        ("float", ["red", "green", "blue"], "0.2 0.4 0.8", [0.2, 0.4, 0.8]),
        ("double", ["red", "green", "blue"], "0.2 0.4 0.8", [0.2, 0.4, 0.8]),
    ];
    for (kind, names, values, colour) in cases {
        let header = with(&names.map(|name| format!("property {kind} {name}\n")).concat());
        let scene = scene(&header, &rows(values));
        assert_eq!(scene.meshes[0].colours, [Vec3::from(colour).extend(1.0); 4], "{kind} {names:?}");
        let MaterialModel::Layered(layers) = &scene.materials[0].model else { panic!("colours need layers") };
        assert!(layers.specular.value == 0.0 && matches!(layers.base_colour.colour, Colour::Rgb([1.0, 1.0, 1.0])));
        assert!(scene.materials[0].alpha == AlphaMode::Opaque && scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
}

#[test]
fn opacity_counts_where_there_is_any() {
    let of = |alpha: &str| {
        let header = HEADER.replace(
            "float z\n",
            "float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n",
        );
        let values = format!("255 255 255 {alpha}\n");
        let rows = ROWS.replace(" 0\n", &format!(" 0 {values}")).replace(" 0.1\n", &format!(" 0.1 {values}"));
        let scene = scene(&header, &rows);
        (scene.meshes[0].colours[0], scene.materials[0].alpha, scene.warnings.len())
    };
    assert_eq!(of("255"), (Vec4::ONE, AlphaMode::Opaque, 0));
    assert_eq!(of("51"), (Vec3::ONE.extend(0.2), AlphaMode::Blend, 0), "not encoded");
    assert_eq!(of("0"), (Vec4::ONE, AlphaMode::Opaque, 1), "alpha of nothing is not meant");
}

#[test]
fn polygons_are_cut_as_those_of_obj_files_are() {
    let header = HEADER.replace("vertex 4", "vertex 5").replace("face 2", "face 3");
    let arrow = "0 0 0\n2 2 0\n4 0 0\n2 5 0\n9 9 9\n4 0 1 2 3\n3 0 1 2\n4 3 0 1 2\n";
    let found = mesh(&header, arrow);
    // Cut across its notch, whichever corner comes first.
    assert_eq!(found.triangles, [[3, 0, 1], [1, 2, 3], [0, 1, 2], [3, 0, 1], [3, 1, 2]]);
    assert_eq!(found.positions.len(), 4, "the vertex that no face has is left out");
}

#[test]
fn smooth_normals_know_no_seams() {
    let bytes = file(
        "ascii",
        &HEADER.replace("vertex 4", "vertex 6"),
        "0 1 0\n0 1 1\n1 0 0\n0 1 0\n0 1 1\n-1 0 1\n3 0 1 2\n3 4 3 5\n",
    );
    let smooth = parse(&bytes, Path::new("a.ply"), MissingNormals::Smooth, &Sandbox::default()).expect("valid");
    let normals = &smooth.meshes[0].normals;
    assert!(normals[0] == normals[3] && normals[0] != normals[2], "{normals:?}");
    assert!(read_bytes(&bytes).expect("valid").meshes[0].normals.is_empty());
}

#[test]
fn faces_may_come_first_and_unknown_elements_anywhere() {
    let header = "comment made by hand\nobj_info none\nelement camera 1\nproperty float view\nelement face 1\n\
        property list uchar uint vertex_indices\nproperty uchar flags\nproperty list uchar float weights\n\
        element odd 3000000000\nelement vertex 3\nproperty double quality\nproperty float x\nproperty list int char marks\n\
        property float y\nproperty float z\nelement edge 2\nproperty int vertex1\nproperty list ushort double more\n";
    let rows = "5\n3 0 1 2 7 2 0.5 0.25\nnan 0 2 1 -1 0 0\n1 1 0 0 0\n1 0 1 3 1 0\n1 0\n2 2 1e300 4\n";
    for form in FORMS {
        // Elements without properties take no bytes, however many they are.
        let bytes = file(form, &header.replace("3000000000", "0"), rows);
        let at = bytes.windows(5).position(|w| w == b"odd 0").expect("odd");
        let bytes = [&bytes[..at], b"odd 3000000000", &bytes[at + 5..]].concat();
        let scene = read_bytes(&bytes).expect(form);
        assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]]);
        assert_eq!(scene.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y], "{form}");
        let warnings = ["odd", "edge"]
            .map(|name| format!("in/my mesh.ply: the element {name:?} is not supported and is left out"));
        assert_eq!(scene.warnings, warnings, "{form}");
    }
}

#[test]
fn lines_end_as_on_any_system() {
    for form in FORMS {
        let plain = file(form, HEADER, ROWS);
        let body = plain.windows(11).position(|w| w == b"end_header\n").expect("an end") + 11;
        for end in ["\r\n", "\r"] {
            let header = String::from_utf8_lossy(&plain[..body]).replace('\n', end);
            let scene = read_bytes(&[header.as_bytes(), &plain[body..]].concat()).expect(form);
            assert_eq!(scene.meshes[0].triangles.len(), 2);
        }
    }
    // A coordinate that begins with the byte of a line's end.
    let mut bytes =
        file("binary_little_endian", &HEADER.replace("float x", "uchar x"), &ROWS.replace("0 0 0\n1", "10 0 0\n1"));
    let body = bytes.windows(11).position(|w| w == b"end_header\n").expect("an end") + 11;
    bytes[..body].iter_mut().filter(|byte| **byte == b'\n').for_each(|byte| *byte = b'\r');
    assert_eq!(read_bytes(&bytes).expect("valid").meshes[0].positions[0].x, 10.0);
}

#[test]
fn the_image_of_meshlab_is_that_of_the_surface() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scan.ply");
    let grey = image::RgbImage::from_pixel(1, 1, image::Rgb([77, 78, 79]));
    grey.save(folder.path().join("my tex.png")).expect("encoded");
    let read = |header: &str, rows: &str| {
        fs::write(&path, file("ascii", &format!("comment VCGLIB generated\n{header}"), rows)).expect("written");
        read(&path, MissingNormals::Flat, &Sandbox::default())
    };
    let wedges = format!("comment TextureFile my tex.png\n{HEADER}property list uchar float texcoord\n");
    let rows = ROWS.replace("0 1 2\n", "0 1 2 6 0 0 1 0 1 1\n").replace("0 2 3\n", "0 2 3 6 0 0 1 1 0.5 1\n");
    let scene = read(&wedges, &rows).expect("valid");
    let MaterialModel::Diffuse(Diffuse { reflectance }) = &scene.materials[0].model else { panic!("not diffuse") };
    assert!(matches!(reflectance.colour, Colour::Rgb([1.0, 1.0, 1.0])) && reflectance.texture.is_some());
    assert!(matches!(&scene.images[0].texels, Texels::Rgba8(t) if t[..] == [[77, 78, 79, 255]]));
    assert_eq!(scene.files, [folder.path().join("my tex.png")]);
    let mesh = &scene.meshes[0];
    let uvs = [[0., 1.], [1., 1.], [1., 0.], [0.5, 0.]].map(Vec2::from);
    assert_eq!(
        (&mesh.uvs[0][..], &mesh.triangles[..]),
        (&uvs[..], &[[0, 1, 2], [0, 2, 3]][..]),
        "shared corners stay so"
    );
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);

    // Another UV of the same corner is another vertex.
    let torn = read(&wedges, &rows.replace("0 0 1 1 0.5 1", "0.5 0 1 1 0.5 1")).expect("valid");
    assert_eq!(torn.meshes[0].triangles, [[0, 1, 2], [3, 2, 4]]);
    assert_eq!(torn.meshes[0].positions[3], Vec3::ZERO);

    let error = read(&wedges.replace("my tex", "gone"), &rows).expect_err("no image").to_string();
    assert!(error.contains("scan.ply:4: TextureFile: ") && error.contains("gone.png"), "{error}");
    fs::create_dir(folder.path().join("in")).expect("a folder");
    let sandbox = Sandbox::new(&folder.path().join("in")).expect("a sandbox");
    let bytes = file("ascii", &wedges.replace("my tex", "../my tex"), &rows);
    let outside = parse(&bytes, &folder.path().join("in/scan.ply"), MissingNormals::Flat, &sandbox);
    let error = outside.expect_err("outside").to_string();
    assert!(error.contains(":3: TextureFile: names ") && error.contains("not in the sandbox"), "{error}");
    let bare = read(&format!("comment TextureFile my tex.png\n{HEADER}"), ROWS).expect("valid");
    assert!(bare.images.is_empty() && bare.warnings[0].contains("no UV"), "{:?}", bare.warnings);
    let two = read(&format!("comment TextureFile other.png\n{wedges}"), &rows).expect("valid");
    assert!(two.images.is_empty() && two.warnings[0].contains("lines 4–5"), "{:?}", two.warnings);
}

#[test]
fn what_would_show_is_told_when_it_is_left_out() {
    let warning = |header: &str, rows: &str| {
        let warnings = scene(header, rows).warnings;
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        warnings[0].clone()
    };
    let with_faces = |more: &str, values: &str| {
        warning(
            &format!("{HEADER}{more}"),
            &ROWS.replace("0 1 2\n", &format!("0 1 2{values}\n")).replace("0 2 3\n", &format!("0 2 3{values}\n")),
        )
    };
    assert!(
        with_faces("property uchar red\nproperty uchar green\nproperty uchar blue\n", " 1 2 3")
            .contains("colours of faces")
    );
    assert!(warning(HEADER, &format!("{ROWS}0 0 7\n")).ends_with("3 bytes behind the last element are left out"));
    assert!(warning(HEADER, &ROWS.replace("3 0 1 2", "2 0 1")).contains("fewer than 3 corners are left out: 1"));
    assert!(warning(HEADER, &ROWS.replace("3 0 1 2", "3 0 1 1")).contains("1 triangle of zero area"));
    let strips = format!("{HEADER}element tristrips 1\nproperty list int int vertex_indices\n");
    assert!(warning(&strips, &format!("{ROWS}4 0 1 2 3\n")).contains("\"tristrips\" is not supported"));
    let colours = |kind: &str| {
        HEADER.replace(
            "float z\n",
            &format!("float z\nproperty {kind} red\nproperty {kind} green\nproperty {kind} blue\n"),
        )
    };
    let rows = ROWS.replace(" 0\n", " 0 1 2 0\n").replace(" 0.1\n", " 0.1 1 2 0\n");
    assert!(warning(&colours("float"), &rows).contains("beyond 0–1"));
    assert!(warning(&colours("int"), &rows).contains("their type int"));
}

#[rstest]
#[case::kind("ply", "plz", ": is not a PLY file")]
#[case::no_end("end_header", "end_heade", ":9: cannot be read: \"end_heade\"")]
#[case::form("ascii", "asci", ":2: cannot be read: \"format asci 1.0\"")]
#[case::version("1.0", "2.0", ":2: cannot be read: \"format ascii 2.0\"")]
#[case::no_form("format ascii 1.0\n", "", ": the header has no line \"format\"")]
#[case::count("vertex 4", "vertex -4", ":3: cannot be read: \"element vertex -4\"")]
#[case::huge("vertex 4", "vertex 99999999999999999999", ":3: cannot be read")]
#[case::kind_of_number("float y", "real y", ":5: property: \"real\" is not a type of numbers")]
#[case::length("list uchar", "list float", ":8: cannot be read")]
#[case::early("element vertex 4\n", "", ":3: cannot be read: \"property float x\"")]
#[case::no_z("float z", "float height", ": vertex: needs the properties x, y and z")]
#[case::list_for_number("float z", "list uchar float z", ": vertex: needs the properties x, y and z")]
#[case::twice("float y", "float x", ":3: \"x\" appears twice")]
#[case::no_list("vertex_indices", "indices", ": face: has no list vertex_indices")]
#[case::cloud("element face 2\nproperty list uchar int vertex_indices\n", "", ": is a cloud of 4 points without faces")]
#[case::word("1 0 0", "1 x 0", ":11: vertex 1: \"x\" is not a number")]
#[case::comma("1 0 0", "1 0,5 0", ":11: vertex 1: \"0,5\" is not a number")]
#[case::not_a_number("1 0 0", "1 nan 0", ":11: vertex 1: y is not finite: NaN")]
#[case::infinite("1 0 0", "1 1e39 0", ":11: vertex 1: y is not finite: inf")]
#[case::missing("1 0 0", "1 0", ":11: vertex 1: has other values than the header announces: x, y, z")]
#[case::too_many("1 0 0", "1 0 0 0", ":11: vertex 1: has other values than the header announces: x, y, z")]
#[case::index("3 0 2 3", "3 0 2 4", ":15: face 1: refers to vertex 4, but there are 4")]
#[case::negative("3 0 2 3", "3 0 2 -1", ":15: face 1: refers to vertex -1, but there are 4")]
#[case::fraction("3 0 2 3", "3 0 2 1.5", ":15: face 1: \"1.5\" is no int")]
#[case::range("3 0 2 3", "300 0 2 3", ":15: face 1: \"300\" is no uchar")]
#[case::long_list("3 0 2 3", "99 0 2 3", ":15: face 1: a list of 99 values is impossible")]
#[case::short_list("3 0 2 3", "4 0 2 3", ":15: face 1: the file ends within it")]
#[case::more_vertices("vertex 4", "vertex 5", ":14: vertex 4: has other values than the header announces")]
#[case::many_vertices(
    "vertex 4",
    "vertex 4000000000",
    ": is truncated: 4000000000 of \"vertex\" are announced, but only"
)]
#[case::too_many_vertices("vertex 4", "vertex 5000000000", ": vertex: has 5000000000 vertices, more than 4294967295")]
#[case::many_faces("face 2", "face 18446744073709551615", ": is truncated: 18446744073709551615 of \"face\"")]
#[case::all_flat("3 0 1 2\n3 0 2 3", "3 0 1 1\n3 0 0 3", ": has no triangles but 2 of zero area")]
fn damaged_files_are_refused_with_their_line(#[case] from: &str, #[case] to: &str, #[case] message: &str) {
    let text = String::from_utf8(file("ascii", HEADER, ROWS)).expect("text");
    assert!(text.contains(from), "{from}");
    let error = read_bytes(text.replacen(from, to, 1).as_bytes()).expect_err("to be refused").to_string();
    assert!(error.starts_with(&format!("in/my mesh.ply{message}")), "{error}");
}

#[test]
fn damage_of_binary_files_is_refused_with_its_byte() {
    let bytes = file("binary_little_endian", HEADER, ROWS);
    let body = bytes.windows(11).position(|w| w == b"end_header\n").expect("an end") + 11;
    let refused = |bytes: &[u8], message: &str| {
        let error = read_bytes(bytes).expect_err("to be refused").to_string();
        assert!(error.contains(message), "{error}");
    };
    let with = |at: usize, values: &[u8]| [&bytes[..body + at], values, &bytes[body + at + values.len()..]].concat();
    refused(&with(16, &f32::NAN.to_le_bytes()), &format!("vertex 1: y is not finite: NaN, at byte {}", body + 24));
    refused(
        &with(49, &9u32.to_le_bytes()),
        &format!("face 0: refers to vertex 9, but there are 4, counted from 0, at byte {}", body + 61),
    );
    refused(
        &with(48, &[255]),
        &format!("face 0: a list of 255 values is impossible where at most 7 follow, at byte {}", body + 49),
    );
    refused(&with(61, &[4]), &format!("face 1: the file ends within it, at byte {}", body + 74));
    refused(&bytes[..bytes.len() - 1], &format!("face 1: the file ends within it, at byte {}", body + 70));
    // Lists of four billion, and those of less than nothing.
    for (kind, length) in [("uint", u32::MAX), ("int", i32::MIN as u32)] {
        let mut wide = file("binary_little_endian", &HEADER.replace("list uchar", &format!("list {kind}")), ROWS);
        let at = wide.len() - 16;
        wide[at..at + 4].copy_from_slice(&length.to_le_bytes());
        refused(&wide, "face 1: a list of ");
    }
}

#[test]
fn polygons_that_would_take_for_ever_are_refused() {
    let corners: String = (0..20_000).map(|i| format!(" {}", i % 4)).collect();
    let rows = ROWS.replace("3 0 2 3", &format!("20000{corners}"));
    let error = error(&HEADER.replace("list uchar", "list int"), &rows);
    assert!(error.contains(":15: face 1: has 20000 corners, more than 5000"), "{error}");
}

/// Everything that a file can have.
fn rich(form: &str) -> Vec<u8> {
    let header = "comment TextureFile\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\n\
        property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n\
        property uchar blue\nproperty uchar alpha\nproperty float s\nproperty float t\nelement face 2\n\
        property list uchar int vertex_indices\nproperty list uchar float texcoord\nelement edge 1\nproperty int a\n";
    let rows = "0 0 0 0 0 1 1 2 3 4 0 0\n1 0 0 0 0 1 1 2 3 4 1 0\n1 1 0 0 0 1 1 2 3 4 1 1\n0 1 0 0 0 1 1 2 3 4 0 1\n\
        3 0 1 2 6 0 0 1 0 1 1\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n7\n";
    file(form, header, rows)
}

#[test]
fn no_damage_makes_a_file_panic() {
    for form in FORMS {
        let bytes = rich(form);
        let read = |bytes: &[u8]| {
            let read = parse(bytes, Path::new("damaged.ply"), MissingNormals::Smooth, &Sandbox::default());
            if let Ok(mut scene) = read {
                crate::complete(&mut scene, &mut crate::ChangedMeshes::default());
            }
        };
        for at in 0..bytes.len() {
            read(&bytes[..at]);
            for flip in [0x01, 0x10, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[at] ^= flip;
                read(&damaged);
            }
        }
    }
}

#[test]
fn every_prefix_of_a_file_is_refused() {
    for form in FORMS {
        let bytes = rich(form);
        // The last number may lose digits.
        let least = if form == "ascii" { bytes.len() - 2 } else { bytes.len() - 1 };
        for len in 0..=least {
            assert!(read_bytes(&bytes[..len]).is_err(), "{form}: {len} of {}", bytes.len());
        }
    }
}
