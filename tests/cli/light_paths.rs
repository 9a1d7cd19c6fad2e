//! Paths from lamps on the command line: the same bytes however the work is shared out, and what they do not go with.

use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::assert_same;

fn room_with(light_paths: f64, more: &str) -> Folder {
    room_of(&format!("light_paths = {light_paths}"), more)
}

fn room_of(keys: &str, more: &str) -> Folder {
    room(&format!(
        "{more}\n[render]\nsamples_per_pixel = 8\nseed = 7\n{keys}\n\
         [output]\nraw = ['npy']\nirradiance = true\n"
    ))
}

#[rstest]
#[case::few("light_paths = 0.3")]
#[case::many("light_paths = 5.1")]
#[case::split("light_paths = 0.3\nsplitting = 3")]
fn the_bytes_are_the_same_in_threads_strips_and_parts(#[case] keys: &str) {
    is_the_same_however_it_is_shared_out(&room_of(keys, ""));
}

/// Renders in threads, strips and parts, and without paths from lights.
fn is_the_same_however_it_is_shared_out(folder: &Folder) {
    folder.succeed("render capture.toml --threads 1 -o one");
    folder.succeed("render capture.toml --threads 2 -o two");
    assert_same(folder, "one", "two");
    // 32 columns of 33 channels of 32 bytes: strips of 5 rows.
    let memory = 32.0 * (33.0 * 32.0 + 4.0) * 5.5 / f64::from(1 << 30);
    folder.succeed(&format!("render capture.toml --film-memory {memory} -o strips"));
    assert_same(folder, "one", "strips");
    folder.succeed("render capture.toml --samples 0..3 -o first");
    folder.succeed("render capture.toml --samples 3..8 -o rest");
    folder.succeed("merge rest first -o merged");
    assert_same(folder, "one", "merged");
    folder.succeed("render capture.toml --set render.light_paths=0 -o without");
    assert!(folder.results("without")["raw.npy"] != folder.results("one")["raw.npy"]);
}

/// The room through a wide lens from a prescription.
fn room_through_glass(keys: &str) -> Folder {
    let folder = room_of(keys, "");
    let text = folder.text("capture.toml");
    let (before, after) = text.split_once("[lens]").expect("a lens");
    let (_, after) = after.split_once("[sensor]").expect("a sensor");
    let lens = "[lens]\nprescription = 'canon-rf24'\nf_number = 2.8\nfocus_distance_m = 3\n\n[sensor]";
    let after = after.replace("pixel_pitch_um = [100, 100]", "pixel_pitch_um = [900, 900]");
    // Larger pixels: not all of them saturate.
    let after = after.replace("time_s = 0.0002", "time_s = 0.000001");
    folder.add("capture.toml", format!("{before}{lens}{after}"));
    folder
}

/// Test of a prescription, whose light lands in other pixels than its paths came from, and paths from lights find their own way in.
#[test]
fn so_are_those_through_a_prescription() {
    let folder = room_through_glass("light_paths = 1.3");
    is_the_same_however_it_is_shared_out(&folder);
    let target = "--set render.noise_target=0.5 --set render.samples_per_pixel=64";
    folder.succeed(&format!("render capture.toml {target} --threads 1 -o one-target"));
    folder.succeed(&format!("render capture.toml {target} --threads 2 -o two-target"));
    assert_same(&folder, "one-target", "two-target");
}

/// A sensor without a mosaic gets the same light with paths from lamps as without.
#[test]
fn a_monochrome_sensor_sees_as_much_light_through_a_prescription() {
    let folder = room_through_glass("light_paths = 1");
    let render = "render capture.toml --set sensor.preset=sony-imx249-mono --set sensor.resolution_px=[32,24] \
                  --set sensor.pixel_pitch_um=[900,900] --set output.irradiance=false --spp 512 --quiet";
    folder.succeed(&format!("{render} -o with"));
    folder.succeed(&format!("{render} --set render.light_paths=0 --seed 8 -o without"));
    let [with, without] = ["with", "without"].map(|name| folder.electrons(name));
    let values = |planes: &photosite::image::Planes| -> Vec<f64> {
        assert_eq!(planes.channels().len(), 1);
        planes.channels()[0].data.iter().map(|&v| f64::from(v)).collect()
    };
    let sum = |planes| values(planes).iter().sum::<f64>();
    let difference = sum(&with.mean) - sum(&without.mean);
    // Neighbouring pixels get light of the same paths: less than all of one sample's four wavelengths.
    let error = (4.0 * (sum(&with.variance) + sum(&without.variance))).sqrt();
    assert!(difference.abs() < 4.0 * error, "{difference} ± {error} of {}", sum(&without.mean));
    // A tenth more or less would show.
    assert!(error < 0.02 * sum(&without.mean), "{error} of {}", sum(&without.mean));
}

#[rstest]
#[case::below("render.light_paths=-1", "render.light_paths: must be from 0 to 64, got -1")]
#[case::above("render.light_paths=65", "render.light_paths: must be from 0 to 64, got 65")]
fn a_number_of_paths_that_cannot_be_is_refused(#[case] set: &str, #[case] message: &str) {
    room_with(0.5, "").fail(&format!("render capture.toml --set {set}"), 1, &[message, "light_paths = 0.5"]);
}

#[test]
fn what_filters_see_alone_and_what_scans_is_refused() {
    let folder = room_with(0.5, "");
    let filters = "--set render.wavelengths=own-filter";
    folder.fail(
        &format!("render capture.toml {filters}"),
        1,
        &["render.light_paths: cannot be combined with wavelengths", "remove"],
    );
    let scanning =
        "--set sensor.preset=sony-imx249-mono --set sensor.shutter.kind=scanning --set sensor.shutter.row_time_us=1000";
    folder.fail(
        &format!("render capture.toml {scanning}"),
        1,
        &["render.light_paths: cannot be combined with a sensor that scans"],
    );
}

#[test]
fn what_moves_is_refused() {
    let moving = "frames = 2\nframe_interval_s = 0.01\n[camera.motion]\nvelocity_m_per_s = [20, 0, 0]";
    let message = "render.light_paths: cannot be combined with a camera or a scene that moves";
    room_with(0.5, moving).fail("render capture.toml", 1, &[message, "remove it, or camera.motion"]);
}

/// A matt floor and a wall of some material under a lamp.
fn wall(material: &str, keys: &str) -> Folder {
    let obj = "mtllib scene.mtl\nusemtl floor\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 4 3 2\n\
        usemtl lamp\nv -1 2 -1\nv 1 2 -1\nv 1 2 1\nv -1 2 1\nf 5 6 7 8\n\
        usemtl wall\nv -1 1 -1\nv 1 1 -1\nf 1 2 10 9\n";
    let capture = format!(
        "[scene]\ngeometry = ['scene.obj']\n[materials.wall]\n{material}\n[camera]\nposition_m = [0, 1, 3]\n\
         look_at_m = [0, 0, 0]\n[sensor]\nresolution_px = [16, 12]\n[render]\nsamples_per_pixel = 4\n{keys}\n"
    );
    let mtl = "newmtl floor\nnewmtl wall\nnewmtl lamp\nKe 9 9 9\n";
    Folder::new([("scene.obj", obj), ("scene.mtl", mtl), ("capture.toml", &capture)].map(|(name, t)| (name, t.into())))
}

#[rstest]
#[case::matt("type = 'diffuse'\nreflectance = 0.5")]
#[case::rough_metal("type = 'conductor'\nmetal = 'Ag'\nroughness = 0.7")]
#[case::metal("type = 'conductor'\nmetal = 'Ag'\nroughness = 0.4")]
fn light_paths_set_out_whether_or_not_anything_focuses(#[case] material: &str) {
    let folder = wall(material, "max_depth = 4");
    folder.succeed("render capture.toml -o without");
    let outcome = folder.succeed("render capture.toml --set render.light_paths=1 -o with");
    assert!(!outcome.text().contains("warning: render.light_paths"), "{outcome:?}");
    let [with, without] = ["with", "without"].map(|name| folder.results(name).remove("electrons.exr"));
    assert_ne!(with, without);
}

#[test]
fn a_scene_without_lamps_is_rendered_with_a_warning() {
    let folder = room_with(0.5, "");
    folder.add("sails.toml", SAILS);
    let outcome = folder.succeed("render sails.toml --set render.light_paths=1 -o sails");
    assert!(outcome.text().contains("warning: render.light_paths: no surface shines"), "{outcome:?}");
}

/// Somewhat polished sails under a sky.
const SAILS: &str = "\
[scene]
geometry = ['sails.gltf']
environment = { illuminance_lux = 100, linear_rgb = [1, 1, 1] }
[render]
samples_per_pixel = 1
[sensor]
resolution_px = [16, 12]
";
