//! Paths from lamps on the command line: the same bytes however the work is shared out, and what they do not go with.

use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::assert_same;

fn room_with(light_paths: f64, more: &str) -> Folder {
    room(&format!(
        "{more}\n[render]\nsamples_per_pixel = 8\nseed = 7\nlight_paths = {light_paths}\n\
         [output]\nraw = ['npy']\nirradiance = true\n"
    ))
}

#[rstest]
fn light_of_lamps_has_the_same_bytes_in_threads_strips_and_parts(#[values(0.3, 5.0)] light_paths: f64) {
    let folder = room_with(light_paths, "");
    folder.succeed("render capture.toml --threads 1 -o one");
    folder.succeed("render capture.toml --threads 2 -o two");
    assert_same(&folder, "one", "two");
    assert_eq!(folder.report("one")["render"]["light_paths"], light_paths);
    // 32 columns of 33 channels of 32 bytes: strips of 5 rows.
    let memory = 32.0 * (33.0 * 32.0 + 4.0) * 5.5 / f64::from(1 << 30);
    folder.succeed(&format!("render capture.toml --film-memory {memory} -o strips"));
    assert_same(&folder, "one", "strips");
    folder.succeed("render capture.toml --samples 0..3 -o first");
    folder.succeed("render capture.toml --samples 3..8 -o rest");
    folder.succeed("merge rest first -o merged");
    assert_same(&folder, "one", "merged");
    folder.succeed("render capture.toml --set render.light_paths=0 -o without");
    assert!(folder.results("without")["raw.npy"] != folder.results("one")["raw.npy"]);
}

#[rstest]
#[case::below("render.light_paths=-1", "render.light_paths: must be from 0 to 64, got -1")]
#[case::above("render.light_paths=65", "render.light_paths: must be from 0 to 64, got 65")]
#[case::none("render.light_paths=nan", "render.light_paths: must be from 0 to 64, got NaN")]
fn a_number_of_paths_that_cannot_be_is_refused(#[case] set: &str, #[case] message: &str) {
    room_with(0.5, "").fail(&format!("render capture.toml --set {set}"), 1, &[message, "light_paths = 0.5"]);
}

#[test]
fn what_moves_is_refused() {
    let moving = "frames = 2\nframe_interval_s = 0.01\n[camera.motion]\nvelocity_m_per_s = [20, 0, 0]";
    let message = "render.light_paths: cannot go with a camera or a scene that moves";
    room_with(0.5, moving).fail("render capture.toml", 1, &[message, "remove it, or camera.motion"]);
}

#[test]
fn a_scene_without_lamps_is_rendered_with_a_warning() {
    let folder = room_with(0.5, "");
    folder.add("dark.toml", "[scene]\ngeometry = ['sails.gltf']\nenvironment = { illuminance_lux = 100, linear_rgb = [1, 1, 1] }\n[render]\nsamples_per_pixel = 1\nlight_paths = 1\n[sensor]\nresolution_px = [16, 12]\n");
    let outcome = folder.succeed("render dark.toml -o dark");
    assert!(outcome.text().contains("warning: render.light_paths: no surface shines"), "{outcome:?}");
}
