//! Scenes whose textures are missing: an error, or with `--lenient` a warning and grey, which the report keeps.

use serde_json::json;

use crate::folder::Folder;

const OBJ: &str = "mtllib tri.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
const SMALL: &str = "--set sensor.resolution_px=[8,6] --set render.samples_per_pixel=2 --set scene.environment=even";

fn folder() -> Folder {
    Folder::new([("tri.obj", OBJ.into()), ("tri.mtl", b"newmtl a\nmap_Kd gone.png\n".to_vec())])
}

#[test]
fn every_command_that_reads_scenes_says_how_to_go_on_and_does_so() {
    let folder = folder();
    for command in [
        "info tri.obj",
        &format!("render tri.obj -o r {SMALL}"),
        "camera tri.obj --format opencv",
        "export-mitsuba tri.obj -o m --approximate",
    ] {
        folder.fail(command, 1, &["tri.mtl", "map_Kd", "gone.png", "add --lenient, and grey is used instead"]);
        folder.succeed(&format!("{command} --lenient"));
    }
    let warnings = &folder.report("r")["warnings"];
    let warned = |w: &serde_json::Value| w.as_str().is_some_and(|w| w.contains("gone.png") && w.contains("grey"));
    assert_eq!(warnings.as_array().map(|all| all.iter().filter(|w| warned(w)).count()), Some(1), "{warnings}");
}

#[test]
fn a_report_renders_the_same_image_again() {
    let folder = folder();
    folder.succeed(&format!("render tri.obj -o a --lenient {SMALL}"));
    assert_eq!(folder.report("a")["capture"]["scene"]["lenient"], json!(true));
    folder.add("capture.toml", "[scene]\ngeometry = ['tri.obj']\nlenient = true\nenvironment = 'even'\n");
    folder.succeed(&format!("render capture.toml -o b {SMALL}"));
    for part in ["0..1", "1..2"] {
        folder.succeed(&format!("render tri.obj -o part-{part} --lenient --samples {part} {SMALL}"));
    }
    folder.succeed("merge part-0..1 part-1..2 -o c");
    folder.succeed("render a/capture.json -o d");
    for other in ["b", "c", "d"] {
        let read = |name: &str| folder.bytes(&format!("{name}/image.png"));
        assert!(read("a") == read(other), "{other}");
    }
}
