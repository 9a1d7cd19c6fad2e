//! Whole files, made here: their meaning, and errors of damaged ones.

use std::fs;

use glam::{Vec2, Vec3, Vec4};
use rstest::rstest;
use tempfile::TempDir;

use super::*;
use crate::mesh::checked;
use photosite_transport::scene::description::{AlphaMode, Colour, Diffuse, MaterialModel};
use photosite_transport::texture::Texels;

/// A folder with the files of a test, among them `scene.obj`.
fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().expect("temporary folder");
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("written");
    }
    folder
}

fn read_text(text: &str) -> Result<ObjFile> {
    let folder = folder(&[("scene.obj", text.as_bytes())]);
    read(&folder.path().join("scene.obj"), &Choice::default())
}

fn scene(text: &str) -> SceneDescription {
    read_text(text).expect("a valid file").scene
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn corners_are_counted_from_the_start_or_backwards() {
    for face in ["f 1 2 3 4", "f -4 -3 -2 -1", "f 1/1 2/1 3/1 4/1\nvt 0.25 0.25", "f 1//1 2//1 3//1 4//1\nvn 0 0 2"] {
        let mesh = &scene(&format!("{SQUARE}{face}")).meshes[0];
        assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y], "{face}");
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.uvs.len(), usize::from(face.contains("vt")));
        assert_eq!(mesh.normals.len(), if face.contains("vn") { 4 } else { 0 });
        assert!(mesh.uvs.iter().flatten().all(|&uv| uv == Vec2::new(0.25, 0.75)), "v grows downwards");
        assert!(mesh.normals.iter().all(|&n| n == Vec3::Z), "unit normals");
    }
}

#[test]
fn meshes_are_split_by_object_and_material() {
    let text =
        format!("{SQUARE}f 1 2 3\nusemtl red\nf 1 2 3\no box\nf 1 2 3\nusemtl blue\nf 1 2 3\nusemtl red\nf 2 3 4");
    let file = read_text(&text).expect("a valid file");
    let names: Vec<&str> = file.scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    assert_eq!(names, ["red", "mesh", "box/red", "box/blue"]);
    let materials: Vec<&str> =
        file.scene.meshes.iter().map(|m| file.scene.materials[m.material].name.as_str()).collect();
    assert_eq!(materials, ["red", "default", "red", "blue"]);
    assert_eq!(file.undescribed_materials, ["red", "blue"]);
    assert_eq!(file.scene.meshes[2].triangles.len(), 2);
    assert!(file.scene.warnings.is_empty(), "{:?}", file.scene.warnings);
}

#[test]
fn smoothing_groups_smooth_within_themselves() {
    // Two squares that meet at a right angle along the edge 1–2.
    let roof = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\n";
    let (up, side) = ("f 1 2 3 4", "f 2 1 5 6");
    let normals = |text: &str| scene(&format!("{roof}{text}")).meshes[0].normals.clone();
    assert!(normals(&format!("{up}\n{side}")).is_empty(), "flat unless told otherwise");
    let smooth = normals(&format!("s 1\n{up}\n{side}"));
    let between = Vec3::new(0.0, 1.0, 1.0).normalize();
    assert_eq!(smooth.iter().filter(|n| (**n - between).length() < 1e-6).count(), 2, "{smooth:?}");
    let apart = normals(&format!("s 1\n{up}\ns 2\n{side}"));
    assert_eq!(apart.len(), 8);
    assert!(apart.iter().all(|n| *n == Vec3::Y || *n == Vec3::Z), "{apart:?}");
    let half = normals(&format!("s 1\n{up}\ns off\n{side}"));
    assert_eq!(half.len(), 8, "explicit flat normals beside smooth ones");

    let folder = folder(&[("scene.obj", format!("{roof}{up}\n{side}").as_bytes())]);
    let file = read(
        &folder.path().join("scene.obj"),
        &Choice { missing_normals: MissingNormals::Smooth, ..Choice::default() },
    )
    .expect("a valid file");
    assert_eq!(file.scene.meshes[0].normals.len(), 6, "smooth on request");
}

#[test]
fn materials_come_from_the_library_and_images_from_beside_it() {
    let mut png = std::io::Cursor::new(Vec::new());
    let grey = image::GrayImage::from_pixel(1, 1, image::Luma([77]));
    grey.write_to(&mut png, image::ImageFormat::Png).expect("encoded");
    let mtl = b"newmtl my wood\nKd 1 0.5 0.25\nmap_Kd -s 2 2 my pic.png\nmap_d my pic.png\n# comment\nnewmtl lamp\nKe 3 3 3\n";
    let obj = format!("mtllib my lib.mtl\n{SQUARE}vt 0 0\nusemtl my wood\nf 1/1 2/1 3/1\nusemtl lamp\nf 1 2 3\n");
    let folder = folder(&[("scene.obj", obj.as_bytes()), ("my lib.mtl", mtl), ("my pic.png", png.get_ref())]);
    let file = read(&folder.path().join("scene.obj"), &Choice::default()).expect("a valid file");
    let scene = file.scene;
    assert!(file.undescribed_materials.is_empty());
    let wood = &scene.materials[0];
    assert_eq!((wood.name.as_str(), wood.alpha), ("my wood", AlphaMode::Blend));
    let MaterialModel::Diffuse(Diffuse { reflectance }) = &wood.model else { panic!("{:?}", wood.model) };
    let (Colour::Rgb([1.0, 0.5, 0.25]), Some(texture)) = (&reflectance.colour, &reflectance.texture) else {
        panic!("{reflectance:?}")
    };
    assert_eq!(texture.transform.scale, Vec2::splat(2.0));
    let opacity = wood.alpha_texture.as_ref().expect("map_d");
    assert_eq!(scene.images[opacity.image].linear_texel(0), [77.0 / 255.0; 4]);
    assert!(matches!(&scene.images[texture.image].texels, Texels::Rgba8(t) if t[0] == [77, 77, 77, 255]));
    assert_eq!(scene.materials[1].emission.as_ref().and_then(|e| e.level), Some(1.0));
}

/// Linear value of ½ in sRGB (IEC 61966-2-1): ((½ + 0.055)/1.055)^2.4.
const HALF: f32 = 0.214_041_14;

/// Linear colours of the vertices of a square without a material, and the warnings.
fn colours_of(text: &str) -> (Vec<Vec4>, Vec<String>) {
    let file = read_text(text).expect("valid");
    (file.scene.meshes[0].colours.clone(), file.scene.warnings)
}

#[rstest]
#[case::of_photogrammetry("v 0 0 0 1 0 0.5\nv 1 0 0 1 0 0.5\nv 0 1 0 1 0 0.5\nf 1 2 3", [1.0, 0.0, HALF], "")]
#[case::of_bytes("v 0 0 0 255 0 0\nv 1 0 0 255 0 0\nv 0 1 0 255 0 0\nf 1 2 3", [1.0, 0.0, 0.0], "up to 255")]
#[case::beyond("v 0 0 0 1.5 0 -0.5\nv 1 0 0 1.5 0 -1\nv 0 1 0 2 0 -1\nf 1 2 3", [1.0, 0.0, 0.0], "cut off")]
#[case::of_zbrush("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n#MRGB ffff0000ffff0000\n#MRGB 00FF0000", [1.0, 0.0, 0.0], "")]
#[case::before_their_vertices("#MRGB ffff0000ffff000000ff0000\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", [1.0, 0.0, 0.0], "")]
#[case::more_than_vertices("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n#MRGB ffff0000ffff0000ffff0000ffff0000", [1.0, 0.0, 0.0], "of 4 vertices, but 3")]
fn vertices_have_colours(#[case] text: &str, #[case] expected: [f32; 3], #[case] words: &str) {
    let (colours, warnings) = colours_of(text);
    assert_eq!(colours.len(), 3);
    let expected = Vec3::from(expected).extend(1.0);
    // Six digits of the standard's curve
    assert!(colours.iter().all(|colour| (*colour - expected).abs().max_element() < 1e-6), "{colours:?}");
    assert_eq!(warnings.len(), usize::from(!words.is_empty()), "{warnings:?}");
    assert!(warnings.iter().all(|warning| warning.contains(words)), "{warnings:?}");
}

#[test]
fn what_follows_a_position_and_is_no_colour_is_said() {
    for (rest, is_said) in
        [("", false), (" 1.0", false), (" 0.5", true), (" 1 0", true), (" 1 1 0 0", true), (" # 1 0 0", false)]
    {
        let (colours, warnings) = colours_of(&format!("v 0 0 0{rest}\nv 1 0 0\nv 0 1 0\nf 1 2 3"));
        assert!(colours.is_empty());
        assert_eq!(warnings.len(), usize::from(is_said), "{rest}: {warnings:?}");
    }
    for line in ["#MRGB fff", "#MRGB ffffgg00", "#MRGB ff ff ff ff"] {
        let (colours, warnings) = colours_of(&format!("{line}\n{SQUARE}f 1 2 3"));
        assert!(colours.is_empty() && warnings.len() == 1 && warnings[0].contains("line 1: #MRGB"), "{warnings:?}");
    }
}

#[test]
fn colours_of_vertices_are_what_the_material_has_room_for() {
    const RED: &str = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nv 0 0 1\n";
    let read = |mtl: &str, faces: &str| {
        let obj = format!("mtllib a.mtl\n{RED}{faces}");
        let folder = folder(&[("scene.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]);
        image::GrayImage::from_pixel(1, 1, image::Luma([77])).save(folder.path().join("a.png")).expect("saved");
        read(&folder.path().join("scene.obj"), &Choice::default()).expect("valid")
    };
    let layers = |file: &ObjFile| {
        let MaterialModel::Layered(layers) = &file.scene.materials[0].model else { panic!("no layers") };
        let Colour::Rgb(rgb) = layers.base_colour.colour else { panic!("a spectrum") };
        (rgb, layers.specular.value)
    };
    // Without a material: the colours are the reflectance, and where there are none, that of any other surface.
    let file = read("newmtl other\n", "usemtl red\nf 1 2 3\no grey\nf 1 2 4\no none\nf 4 4 4");
    assert_eq!(layers(&file), ([1.0; 3], 0.0));
    assert!(file.undescribed_materials.is_empty(), "{:?}", file.undescribed_materials);
    assert_eq!(file.scene.meshes[0].colours, [Vec4::new(1.0, 0.0, 0.0, 1.0); 3]);
    assert_eq!(file.scene.meshes[1].colours[2], Vec4::new(0.5, 0.5, 0.5, 1.0));
    assert!(file.scene.warnings.iter().any(|warning| warning.contains("have no colour")), "{:?}", file.scene.warnings);
    for (mtl, expected, kept, words) in [
        ("newmtl red\nKd 0.5 0.5 0.5", [0.5; 3], true, ""),
        ("newmtl red\nKd 0 0 0", [1.0; 3], true, "Kd is black"),
        ("newmtl red\nKd 0.5 0.5 0.5\nmap_Kd a.png", [0.5; 3], false, "its image has those"),
        ("newmtl red\nKd 0.5 0.5 0.5\nPr 0.2", [0.5; 3], true, ""),
    ] {
        let file = read(mtl, "usemtl red\nf 1 2 3");
        assert_eq!(layers(&file).0, expected, "{mtl}");
        assert_eq!(!file.scene.meshes[0].colours.is_empty(), kept, "{mtl}");
        let warnings = &file.scene.warnings;
        assert_eq!(warnings.len(), usize::from(!words.is_empty()), "{mtl}: {warnings:?}");
        assert!(warnings.iter().all(|w| w.contains("material \"red\"") && w.contains(words)), "{warnings:?}");
    }
    let glass = read("newmtl red\nNi 1.5\nillum 7", "usemtl red\nf 1 2 3");
    assert!(matches!(glass.scene.materials[0].model, MaterialModel::Dielectric(_)));
    assert!(glass.scene.meshes[0].colours.is_empty() && glass.scene.warnings.len() == 1);
}

#[test]
fn a_missing_library_is_a_warning_and_a_missing_image_an_error() {
    let obj = format!("mtllib gone.mtl\n{SQUARE}usemtl red\nf 1 2 3\n");
    let file = read_text(&obj).expect("valid but for its colours");
    assert!(file.scene.warnings[0].contains("line 1") && file.scene.warnings[0].contains("gone.mtl"));
    assert_eq!(file.undescribed_materials, ["red"]);

    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl red\nf 1 2 3\n");
    let folder = folder(&[("scene.obj", obj.as_bytes()), ("a.mtl", b"newmtl red\nKd 1 0 0\nmap_Kd gone.png\n")]);
    let error = read(&folder.path().join("scene.obj"), &Choice::default()).expect_err("no image").to_string();
    assert!(error.contains("a.mtl:3: map_Kd: ") && error.contains("gone.png"), "{error}");
}

#[rstest]
#[case::beyond("f 1 2 9", ":5: f: refers to vertex 9, but the file has 4")]
#[case::zero("f 0 1 2", ":5: f: \"0\" refers to vertex 0")]
#[case::backwards("f -1 -2 -5", ":5: f: \"-5\" refers to vertex -5")]
#[case::uv("f 1/1 2/1 3/2\nvt 0 0", ":5: f: refers to texture vertex 2")]
#[case::normal("f 1//3 2//1 3//1\nvn 0 0 1", ":5: f: refers to normal 3")]
#[case::word("f 1 2 x", ":5: f: \"x\" is not a corner")]
#[case::slashes("f 1/1/1/1 2 3", ":5: f: \"1/1/1/1\" is not a corner")]
#[case::huge("f 1 2 99999999999999999999", ":5: f: \"99999999999999999999\" is not a corner")]
#[case::two("f 1 2", ":5: f: a face needs 3 corners, found 2")]
#[case::coordinate("v 1 2", ":5: v: \"v\" needs 3 numbers, found 2")]
#[case::nan("v 1 nan 2", ":5: v: \"nan\" is not finite")]
#[case::continued("\n\\\nv 1 \\\n nan 2", ":6: v: ")]
#[case::smoothing("s maybe", ":5: s: \"maybe\" is not a smoothing group")]
#[case::empty("", ": has no triangles")]
#[case::zero_area("f 1 1 2", ": has no triangles")]
fn damaged_files_are_refused_with_their_line(#[case] line: &str, #[case] message: &str) {
    let error = read_text(&format!("{SQUARE}{line}")).expect_err("to be refused").to_string();
    assert!(error.contains(&format!("scene.obj{message}")), "{error}");
}

#[test]
fn zero_area_triangles_are_counted_in_one_warning() {
    let scene = scene(&format!("{SQUARE}f 1 2 3\nf 1 1 2\nf 1 2 2"));
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.warnings[0].ends_with("2 triangles of zero area are left out"), "{:?}", scene.warnings);
}

#[test]
fn every_prefix_of_a_file_is_read_or_refused_without_panic() {
    let text = format!(
        "mtllib a.mtl\no x\n{SQUARE}vt 0 1\nvn 0 0 1\ns 1\nusemtl m\nf 1/1/1 2/1/1 \\\n3/1/1 -1//\nl 1 2\nf 1 2 3"
    );
    for len in 0..text.len() {
        let parsed = Geometry::parse(&text[..len], Path::new("torn.obj"), &mut Warnings::default());
        if let Ok(geometry) = parsed {
            for mesh in mesh::meshes(&geometry, MissingNormals::Flat) {
                assert!(checked(mesh).is_ok());
            }
        }
    }
}

/// The independent reader of the `tobj` crate gives the same triangles.
#[test]
fn tobj_reads_the_same() {
    let text = format!(
        "{SQUARE}v 0.5 0.5 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nvn 0 1 0\n\
         f 1/1/1 2/2/1 3/3/1 4/4/1\nf 1/1/2 2/2/2 5/3/2\nf -4/-1/-1 -3/-2/-1 -1/-3/-1\n"
    );
    let mesh = &scene(&text).meshes[0];
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..tobj::LoadOptions::default() };
    let (models, _) =
        tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| Err(tobj::LoadError::OpenFileFailed)).expect("valid");
    let theirs = &models[0].mesh;
    assert_eq!(mesh.triangles.as_flattened(), theirs.indices);
    let flat = |v: &[Vec3]| v.iter().flat_map(|v| v.to_array()).collect::<Vec<_>>();
    assert_eq!((flat(&mesh.positions), flat(&mesh.normals)), (theirs.positions.clone(), theirs.normals.clone()));
    let uvs: Vec<f32> = mesh.uvs[0].iter().flat_map(|uv| [uv.x, 1.0 - uv.y]).collect();
    assert_eq!(uvs, theirs.texcoords);
}

#[test]
fn images_that_cannot_be_had_get_a_stand_in_where_that_is_allowed() {
    let library = b"newmtl a\nmap_Kd gone.png\nmap_Pr torn.png\nbump gone.png\nnorm gone.png\n";
    let folder = folder(&[
        ("scene.obj", b"mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n"),
        ("scene.mtl", library),
        ("torn.png", b"\x89PNG"),
    ]);
    let path = folder.path().join("scene.obj");
    let error = read(&path, &Choice::default()).expect_err("strict").to_string();
    assert!(error.contains("scene.mtl") && error.contains("gone.png"), "{error}");

    let scene = read(&path, &Choice { is_lenient: true, ..Choice::default() }).expect("lenient").scene;
    let first: Vec<_> = scene.images.iter().map(|image| image.linear_texel(0)).collect();
    let close = |a: [f32; 4], b: [f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.005);
    // Grey is 128 of 255; the roughness is that of `Pr` alone; the normal is that of the surface.
    let flat = [0.5, 0.5, 1.0, 1.0];
    assert!(first.iter().zip([[0.502, 0.502, 0.502, 1.0], [1.0; 4], flat]).all(|(&a, b)| close(a, b)), "{first:?}");
    assert_eq!(scene.warnings.len(), 3, "{:?}", scene.warnings);
    assert!(scene.warnings[0].contains("map_Kd: cannot read") && scene.warnings[0].ends_with("grey is used instead"));
    // What reports keep the sums of.
    assert_eq!(scene.files, ["scene.mtl", "torn.png"].map(|name| folder.path().join(name)));
    let outside = tempfile::tempdir().expect("a folder");
    let sandbox = Sandbox::new(outside.path()).expect("a sandbox");
    assert!(read(&path, &Choice { is_lenient: true, sandbox, ..Choice::default() }).is_err());
}
