//! Wrong command lines, and folders that cannot be written: status 2 where the command line is at fault, else 1.

use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;

#[rstest]
#[case::flag("render capture.toml --sed 3", "unexpected argument '--sed' found")]
#[case::key_as_option("render capture.toml --gain 3", "keys of a capture file are set by --set")]
#[case::no_input("render", "required arguments were not provided")]
#[case::no_value("render capture.toml -o", "a value is required")]
#[case::subcommand("rendr capture.toml", "unrecognized subcommand 'rendr'")]
#[case::threads("render capture.toml --threads 0", "invalid value '0' for '--threads <N>'")]
#[case::seed("render capture.toml --seed -1", "invalid value '-1' for '--seed <N>'")]
#[case::set_without_value("render capture.toml --set lens.f_number", "--set lens.f_number: there is no value")]
#[case::set_without_key("render capture.toml --set =4", "--set =4: \"\" is not a key")]
#[case::set_half_a_list(
    "render capture.toml --set camera.position_m=[1,2",
    "\"[1,2\" is neither a TOML value nor a word"
)]
fn wrong_usage_is_told_apart_from_failure(#[case] arguments: &str, #[case] message: &str) {
    room("").fail(arguments, 2, &[message]);
}

#[rstest]
#[case::table("lns.f_number=4", "--set lns.f_number=4: lns: unknown key `lns`; did you mean `lens`?")]
#[case::key("lens.fnumber=4", "lens.fnumber: unknown key `fnumber` in [lens]; did you mean `f_number`?")]
#[case::two("render.sampels=4", "unknown key `sampels` in [render]; did you mean `samples_per_pixel` or `sampler`?")]
#[case::kind("lens.f_number=wide", "lens.f_number: expected a number, found string \"wide\"")]
#[case::too_few("camera.look_at_m=[1,2]", "camera.look_at_m: expected a list of 3 values, found 2")]
#[case::too_many("sensor.resolution_px=[8,8,8]", "sensor.resolution_px: expected a list of 2 values, found 3")]
#[case::value("exposure.time_s=-1", "exposure.time_s: must be above 0, got -1")]
#[case::variant("render.sampler=sobel", "did you mean `sobol`?")]
fn errors_of_set_name_the_argument(#[case] argument: &str, #[case] message: &str) {
    let folder = room("[render]\nsamples_per_pixel = 1");
    folder.fail(&format!("render capture.toml --set {argument}"), 1, &[&format!("--set {argument}: "), message]);
}

#[test]
fn earlier_results_are_kept_unless_told_otherwise() {
    let folder = room("[render]\nsamples_per_pixel = 1");
    folder.succeed("render capture.toml -o out");
    folder.fail(
        "render capture.toml --seed 2 -o out",
        2,
        &["out contains the results of an earlier render", "--force"],
    );
    // An image of that name may be anything, a texture for example.
    folder.add("image.png", "mine");
    folder.fail("render capture.toml -o .", 2, &[". already contains a file image.png", "--force"]);
    // A failure must not cost the results that are there either.
    folder.fail("render capture.toml -o out --force --set exposure.time_s=1e300", 1, &["exposure: "]);
}

/// Tests may run as root, to whom permissions mean nothing: files in the way do.
#[rstest]
#[case::file("file")]
#[case::below_a_file("file/deep/er")]
fn a_folder_that_cannot_be_made_is_refused_before_the_render(#[case] output: &str) {
    let folder = room("[render]\nsamples_per_pixel = 4_000_000_000");
    folder.add("file", "");
    folder.fail(
        &format!("render capture.toml -o {output}"),
        1,
        &["file: is a file, but a folder is needed for the results", "-o"],
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_of_the_system_is_refused_before_the_render() {
    let folder = room("[render]\nsamples_per_pixel = 4_000_000_000");
    folder.fail("render capture.toml -o /proc/photosite", 1, &["/proc/photosite: cannot create the folder", "-o"]);
    folder.fail("render capture.toml -o /proc/self", 1, &["/proc/self: cannot write into the folder", "-o"]);
}

#[test]
fn a_render_that_fails_takes_its_folders_away() {
    let folder = room("");
    let dark = "[scene]\ngeometry = ['sails.gltf']\n[sensor]\nresolution_px = [8, 8]\n[exposure]\nauto = true\n";
    folder.add("dark.toml", dark);
    folder.fail(
        "render dark.toml -o new/and/deep",
        1,
        &["dark.toml:6: exposure.auto: no exposure time suits", "time_s = 0.01"],
    );
    std::fs::create_dir(folder.path("old")).expect("made");
    folder.fail("render dark.toml -o old", 1, &["no exposure time suits"]);
}

#[rstest]
#[case::capture("nothing.toml")]
#[case::scene("nothing.glb")]
#[case::image("nothing.exr")]
fn missing_files_are_named(#[case] name: &str) {
    let folder = Folder::new([]);
    for command in ["render", "info"] {
        if (command, name) != ("render", "nothing.exr") {
            folder.fail(&format!("{command} {name}"), 1, &[&format!("{name}: cannot read: ")]);
        }
    }
}

#[rstest]
#[case::model(
    "scene.fbx",
    "Kaydara FBX Binary",
    "give a capture file (.toml) or a scene (.gltf, .glb, .obj, .ply, .stl)"
)]
#[case::no_ending("scene", "o chair", "give a capture file (.toml) or a scene (.gltf, .glb, .obj, .ply, .stl)")]
fn files_of_other_kinds_are_refused(#[case] name: &str, #[case] text: &str, #[case] help: &str) {
    let folder = Folder::new([(name, text.into())]);
    folder.fail(&format!("render {name}"), 1, &[&format!("{name}: is neither TOML nor a scene of a known kind"), help]);
    folder.fail(&format!("info {name}"), 1, &[&format!("{name}: is not a kind of file that photosite knows"), ".dng"]);
}

#[test]
fn a_folder_is_no_capture() {
    let folder = Folder::new([("box/capture.toml", Vec::new())]);
    folder.fail("render box", 1, &["box: is a folder", "give the capture file in it, for example box/capture.toml"]);
}
