//! Scenes from strangers: with `--sandbox` they name no file outside of a folder, whatever way leads there.

use rstest::rstest;

use crate::folder::Folder;
use crate::gltf::triangle;

const OBJ: &str = "mtllib tri.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
const MTL: &str = "newmtl a\nKd 0.5 0.5 0.5\n";
/// Content of what lies outside.
const SECRET: &str = "400, 0.5\n700, 0.5\n";

/// `in/` with a scene, beside files that it must not read.
fn folder(more: &str) -> Folder {
    let folder = Folder::new([
        ("in/tri.obj", OBJ.into()),
        ("in/tri.mtl", MTL.into()),
        ("in/capture.toml", format!("[scene]\ngeometry = ['tri.obj']\n{more}").into()),
        ("in/own.csv", SECRET.into()),
        ("out.csv", SECRET.into()),
    ]);
    for (name, text) in [("out.obj", OBJ.replace("mtllib tri.mtl\n", "")), ("out.mtl", MTL.into())] {
        folder.add(name, text);
    }
    folder
}

/// Every command that reads it refuses it, and only with the option.
fn refuse(folder: &Folder, wanted: &[&str]) {
    let words = [&["not in the sandbox", "put the file there"], wanted].concat();
    for command in ["info in/capture.toml", "render in/capture.toml -o r", "camera in/capture.toml --format opencv"] {
        folder.fail(&format!("{command} --sandbox in"), 1, &words);
    }
}

#[rstest]
#[case::curve("[materials.a]\ntype = 'diffuse'\nreflectance = { file = '../out.csv' }", "materials.a.reflectance")]
#[case::texture("[materials.a]\ntype = 'diffuse'\nreflectance = { texture = '../out.png' }", "reflectance.texture")]
#[case::steps("[materials.a]\ntype = 'diffuse'\nreflectance = { file = 'x/../../out.csv' }", "materials.a.reflectance")]
#[case::environment("environment = { image = '../sky.hdr', illuminance_lux = 500 }", "scene.environment.image")]
#[case::profile("[[lights]]\ntype = 'profile'\nfile = '../lamp.ies'\nposition_m = [0, 0, 1]", "lights[0].file")]
#[case::sensor("[sensor]\npreset = '../sensor.toml'", "sensor.preset")]
#[case::filter("[sensor]\nfilter = { transmittance = { file = '../out.csv' } }", "sensor.filter")]
#[case::lens("[lens]\ntransmittance = { file = '../out.csv' }", "lens.transmittance")]
fn captures_name_nothing_outside(#[case] more: &str, #[case] key: &str) {
    refuse(&folder(more), &["in/capture.toml", key]);
}

#[rstest]
#[case::beside("'../out.obj'")]
#[case::absent("'../nothing.obj'")]
#[case::absolute("'/etc/passwd.obj'")]
fn geometry_lies_inside(#[case] name: &str) {
    let folder = folder("");
    folder.add("in/capture.toml", format!("[scene]\ngeometry = ['tri.obj', {name}]\n"));
    refuse(&folder, &["in/capture.toml", "scene.geometry[1]"]);
}

#[rstest]
#[case::library("in/tri.obj", OBJ.replace("tri.mtl", "../out.mtl"), "in/tri.obj:1: mtllib")]
#[case::library_from_the_root("in/tri.obj", OBJ.replace("tri.mtl", "/etc/hostname"), "in/tri.obj:1: mtllib")]
#[case::image("in/tri.mtl", format!("{MTL}map_Kd ../out.png\n"), "in/tri.mtl:3")]
fn materials_lie_inside(#[case] file: &str, #[case] text: String, #[case] place: &str) {
    let folder = folder("");
    folder.add(file, text);
    refuse(&folder, &[place]);
}

#[rstest]
#[case::buffer("/buffers/0/uri", "../out.csv", "buffers[0].uri")]
#[case::encoded("/buffers/0/uri", "%2e%2e/out.csv", "buffers[0].uri")]
#[case::image("/images", "", "images[0].uri")]
fn gltf_names_nothing_outside(#[case] pointer: &str, #[case] uri: &str, #[case] key: &str) {
    let folder = folder("");
    let mut document = triangle();
    if uri.is_empty() {
        document.json["images"] = serde_json::json!([{ "uri": "../out.png" }]);
        document.json["textures"] = serde_json::json!([{ "source": 0 }]);
        document.json["materials"][0]["pbrMetallicRoughness"] =
            serde_json::json!({ "baseColorTexture": { "index": 0 } });
        document.json["buffers"][0]["uri"] = "own.bin".into();
    } else {
        assert_eq!(pointer, "/buffers/0/uri");
        document.json["buffers"][0]["uri"] = uri.into();
    }
    folder.add("in/own.bin", &document.data);
    folder.add("in/tri.gltf", document.json.to_string());
    folder.add("in/capture.toml", "[scene]\ngeometry = ['tri.gltf']\n");
    refuse(&folder, &["in/tri.gltf", key]);
}

#[cfg(unix)]
#[test]
fn links_lead_nowhere_else() {
    use std::os::unix::fs::symlink;
    let folder = folder("");
    symlink(folder.path("out.obj"), folder.path("in/link.obj")).expect("linked");
    symlink(folder.path(""), folder.path("in/all")).expect("linked");
    for name in ["link.obj", "all/out.obj"] {
        folder.add("in/capture.toml", format!("[scene]\ngeometry = ['{name}']\n"));
        refuse(&folder, &["in/capture.toml", "scene.geometry[0]"]);
        folder.succeed("info in/capture.toml");
    }
}

/// Patterns of data sets look neither outside nor for ever.
#[cfg(unix)]
#[rstest]
#[case::links_to_themselves("deep/*/*/*/*/*/*/*/*/*/*/*/*/*/*/*/*/*.none", "no file matches")]
#[case::all_folders("**/*.none", "no file matches")]
#[case::beside("../*.hdr", "not in the sandbox")]
#[case::beside_by_name("../private*", "not in the sandbox")]
#[case::from_the_root("/etc/host*", "not in the sandbox")]
#[case::link("all/*.hdr", "not in the sandbox")]
#[case::any_link("*/private.hdr", "not in the sandbox")]
fn patterns_stay_inside_and_end(#[case] pattern: &str, #[case] wanted: &str) {
    use std::os::unix::fs::symlink;
    let folder = folder("");
    folder.add("in/deep/own.hdr", "");
    folder.add("private.hdr", "");
    for (to, link) in [(".", "deep/a"), (".", "deep/b"), (".", "deep/c"), ("..", "deep/up")] {
        symlink(to, folder.path("in").join(link)).expect("linked");
    }
    if wanted == "not in the sandbox" {
        symlink(folder.path(""), folder.path("in/all")).expect("linked");
    }
    let vary = format!("[[vary]]\nkey = 'scene.environment.image'\nfiles = '{pattern}'\n");
    folder.add("in/set.toml", format!("capture = 'capture.toml'\nframes = 1\n{vary}"));
    let outcome = folder.run("dataset --dry-run in/set.toml -o o --sandbox in");
    let text = &outcome.stderr;
    assert!(outcome.status == Some(1) && text.contains(wanted) && text.contains("vary[0].files"), "{text}");
    // Names of what lies outside are told only where the file has them itself.
    assert!(pattern.contains("private") || !text.contains("private.hdr") && !text.contains("hostname"), "{text}");
}

#[test]
fn what_lies_inside_is_read_wherever_the_capture_is() {
    let more = "environment = { illuminant = 'D65', illuminance_lux = 500 }\n[materials.a]\ntype = 'diffuse'\nreflectance = { file = 'own.csv' }\n[render]\nsamples_per_pixel = 1\n";
    let folder = folder(more);
    let small = "--set sensor.resolution_px=[8,6] --sandbox in";
    folder.succeed(&format!("render in/capture.toml {small} -o r"));
    folder.succeed(&format!("info in/tri.obj {small}").replace("--set sensor.resolution_px=[8,6] ", ""));
    // Given by the user himself.
    let text = folder.text("in/capture.toml");
    folder.add("capture.toml", text.replace("tri.obj", "in/tri.obj").replace("own.csv", "in/own.csv"));
    folder.succeed(&format!("render capture.toml {small} -o r2"));
    folder.succeed("info out.obj --sandbox in");
    folder.fail("info capture.toml --sandbox nowhere", 1, &["nowhere", "use as a sandbox"]);
}

#[test]
fn data_sets_reports_and_parts_keep_to_it() {
    let folder = folder(
        "environment = { illuminant = 'D65', illuminance_lux = 500 }\n[sensor]\nresolution_px = [8, 6]\n\
         filter = { transmittance = { file = '../out.csv' } }\n[render]\nsamples_per_pixel = 2\n",
    );
    folder.add("in/set.toml", "capture = 'capture.toml'\nframes = 1\n");
    folder.add("in/far.toml", "capture = '../capture.toml'\nframes = 1\n");
    folder.succeed("render in/capture.toml -o r");
    folder.succeed("render in/capture.toml --samples 0..1 -o a");
    folder.succeed("render in/capture.toml --samples 1..2 -o b");
    folder.fail("expose r -o e --sandbox in", 1, &["r/capture.json", "sensor.filter", "not in the sandbox"]);
    folder.fail("merge a b -o m --sandbox in", 1, &["sensor.filter", "not in the sandbox"]);
    folder.fail("merge a b -o m --sandbox r", 1, &["in/capture.toml", "not in the sandbox"]);
    folder.fail("dataset in/set.toml -o d --sandbox in", 1, &["sensor.filter", "not in the sandbox"]);
    folder.fail("dataset in/far.toml -o d --sandbox in", 1, &["in/far.toml", "capture", "not in the sandbox"]);
}
