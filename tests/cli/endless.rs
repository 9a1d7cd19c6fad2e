//! Inputs without an end, or that nobody writes: each is refused at once, by name.

#![cfg(unix)]

use std::os::unix::fs::symlink;
use std::process::Command;

use rstest::rstest;

use crate::room::room;

#[rstest]
#[case::capture("render FILE.toml")]
#[case::geometry("render FILE.obj")]
#[case::gltf("render FILE.gltf")]
#[case::curve(
    "render capture.toml --set lights=[{type=\"point\",position_m=[0,1,0],intensity_cd=1,spectrum={file=\"FILE.csv\"}}]"
)]
#[case::environment("render capture.toml --set scene.environment={image=\"FILE.hdr\",illuminance_lux=1}")]
#[case::sensor("render capture.toml --set sensor.preset=\"FILE.toml\"")]
#[case::kernel("render capture.toml --set lens.psf={kind=\"kernel\",pitch_um=1,kernels=[{file=\"FILE.csv\"}]}")]
#[case::ies("render capture.toml --set lights=[{type=\"profile\",file=\"FILE.ies\",position_m=[0,1,0]}]")]
#[case::slide(
    "render capture.toml --set lights=[{type=\"projector\",image=\"FILE.png\",position_m=[0,1,0],look_at_m=[0,0,0],\
     horizontal_fov_deg=20,flux_lm=1}]"
)]
#[case::raw("develop FILE.dng")]
#[case::image("compare FILE.png FILE.png")]
#[case::data_set("dataset FILE.toml")]
fn devices_and_pipes_are_no_inputs(#[case] arguments: &str, #[values("device", "pipe")] kind: &str) {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    let word = arguments.split_whitespace().find(|word| word.contains("FILE")).expect("a file");
    let start = word.find("FILE").expect("a file");
    let name: String = word[start..].chars().take_while(|c| c.is_alphanumeric() || *c == '.').collect();
    let path = folder.path(&name);
    match kind {
        "device" => symlink("/dev/zero", &path).expect("a link"),
        _ => {
            let made = Command::new("mkfifo").arg(&path).status().expect("mkfifo runs");
            assert!(made.success());
        }
    }
    folder.fail(arguments, 1, &[&name, &format!("it is a {kind}")]);
}

#[test]
fn texts_that_are_read_as_a_tree_have_a_largest_size() {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    folder.add("long.toml", "# comment\n".repeat(2 << 20));
    folder.fail("render long.toml", 1, &["long.toml", "larger than 16 MiB"]);
}

#[test]
fn the_line_of_a_text_that_is_no_text_is_named() {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    folder.add("latin.toml", b"# a\n# caf\xe9\n");
    folder.fail("render latin.toml", 1, &["latin.toml", "line 2 is not valid UTF-8 text"]);
    folder.add("light.csv", b"400,1\n500,1\n600,\xff\n");
    let arguments = "render capture.toml \
                     --set lights=[{type=\"point\",position_m=[0,1,0],intensity_cd=1,spectrum={file=\"light.csv\"}}]";
    folder.fail(arguments, 1, &["light.csv", "line 3 is not valid UTF-8 text"]);
}
