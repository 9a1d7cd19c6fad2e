//! Links of strangers in place of any file or folder: with `--sandbox` no command follows one out, and each says so.

use std::fs;
use std::path::{Path, PathBuf};

use rstest::rstest;
use tempfile::TempDir;

use crate::dataset::BOARD;
use crate::folder::{Folder, Outcome};
use crate::room::room;

/// A copy of a folder, one file or folder of which may be a link to what lies outside.
struct Planted {
    copy: Folder,
    outside: TempDir,
}

impl Planted {
    fn of(folder: &Folder) -> Self {
        let copy = Folder::new([]);
        for (path, bytes) in folder.contents() {
            let to = copy.path("").join(path.strip_prefix(folder.path("")).expect("below"));
            match bytes {
                Some(bytes) => {
                    fs::create_dir_all(to.parent().expect("a folder")).expect("made");
                    fs::write(to, bytes).expect("written");
                }
                None => fs::create_dir_all(to).expect("made"),
            }
        }
        Self { copy, outside: tempfile::tempdir().expect("a folder") }
    }

    /// With a link in place of a file or folder, to the same bytes outside.
    #[cfg(unix)]
    fn linked(folder: &Folder, name: &Path) -> Self {
        let planted = Self::of(folder);
        let (from, to) = (planted.copy.path("").join(name), planted.outside.path().join("private"));
        fs::rename(&from, &to).expect("moved");
        std::os::unix::fs::symlink(&to, &from).expect("linked");
        planted
    }

    /// With other bytes in place of those of these files.
    fn spoilt(folder: &Folder, names: &[PathBuf]) -> Self {
        let planted = Self::of(folder);
        for path in names.iter().map(|name| planted.copy.path("").join(name)).filter(|path| path.is_file()) {
            fs::write(path, "spoilt").expect("written");
        }
        planted
    }

    fn run(&self, command: &str) -> Outcome {
        self.copy.run(&format!("--sandbox . {command}"))
    }
}

/// All files and folders of a folder, by their names in it.
fn names(folder: &Folder) -> Vec<PathBuf> {
    let root = folder.path("");
    folder.contents().into_keys().map(|path| path.strip_prefix(&root).expect("below").to_owned()).collect()
}

/// Runs a command with a link in place of each file and folder in turn: it is refused by its name, or the command does
/// not read it, which shows where all such files hold something else. Returns what was refused.
fn refused(folder: &Folder, command: &str) -> Vec<String> {
    let (mut refused, mut unread) = (Vec::new(), Vec::new());
    for name in names(folder) {
        let outcome = Planted::linked(folder, &name).run(command);
        let text = outcome.text();
        let last = name.file_name().expect("a name").to_string_lossy();
        // What would be read through the link, or written.
        if text.contains("not in the sandbox") || text.contains("a link leads out of the sandbox") {
            assert!(outcome.status == Some(1) && text.contains(&*last), "{command}, {name:?}: {outcome:?}");
            refused.push(name.display().to_string());
        } else {
            assert_eq!(outcome.status, Some(0), "{command}, {name:?}: {outcome:?}");
            unread.push(name);
        }
    }
    let outcome = Planted::spoilt(folder, &unread).run(command);
    assert_eq!(outcome.status, Some(0), "{command} reads one of {unread:?}, and followed a link: {outcome:?}");
    refused
}

/// Test that these are refused, and whatever else the command reads.
fn refuse(folder: &Folder, command: &str, wanted: &[&str]) {
    let refused = refused(folder, command);
    for name in wanted {
        assert!(refused.iter().any(|refused| refused == name), "{command}: {name} is read, of {refused:?}");
    }
}

#[cfg(unix)]
#[rstest]
#[case("render capture.toml -o new", &["capture.toml", "room.obj", "room.mtl", "tiles.png", "sky.hdr", "sails.gltf"])]
#[case("render capture.toml -o r --force", &["capture.toml", "r"])]
#[case("info capture.toml", &["capture.toml", "room.mtl"])]
#[case("init room.obj", &["room.obj", "room.mtl"])]
#[case("export-mitsuba capture.toml -o m --approximate", &["capture.toml", "tiles.png", "sky.hdr"])]
#[case("camera capture.toml --format opencv", &["capture.toml"])]
#[case("project capture.toml --points points.csv", &["points.csv"])]
#[case("expose r -o e", &["r", "r/capture.json", "r/electrons.exr"])]
#[case("expose r/irradiance.exr -o e --set sensor.preset='own.toml'", &["own.toml", "r/irradiance.exr"])]
#[case("expose r/ideal.exr -o e --unit lux --set sensor.preset='own.toml'", &["r/ideal.exr"])]
#[case("develop r/raw.dng -o d.png", &["r/raw.dng"])]
#[case("develop r/raw.dng -o d.png --capture capture.toml", &["r/raw.dng", "capture.toml"])]
#[case("develop r/ideal.exr -o d.png", &["r/ideal.exr"])]
#[case("info r/raw.dng", &["r/raw.dng"])]
#[case("info r/truth.exr", &["r/truth.exr"])]
#[case("info r/capture.json", &["r/capture.json"])]
#[case("info own.toml", &["own.toml"])]
#[case("compare r/raw.dng r/raw.exr", &["r/raw.dng", "r/raw.exr"])]
#[case("compare r/electrons.exr r/electrons.exr", &["r/electrons.exr"])]
#[case("measure histogram r/image.png", &["r/image.png"])]
#[case("measure similarity r/image.png r/image.png", &["r/image.png"])]
#[case("noise r/raw.dng", &["r/raw.dng"])]
#[case("noise add r/image.png -o n.png --set gaussian.sigma=4", &["r/image.png"])]
#[case("merge-hdr r/raw.dng long.dng -o hdr.exr", &["r/raw.dng"])]
#[case("depth r/truth.exr -o z.exr --focal-length-px 9 --baseline-m 1 --inverse --channel depth", &["r/truth.exr"])]
#[case("emva1288 own.toml --size 24x16 --steps 8 --spatial 4", &["own.toml"])]
#[case("lens own.zmx", &["own.zmx"])]
fn renders_hold_nothing_from_outside(#[case] command: &str, #[case] wanted: &[&str]) {
    let truth = "truth = ['depth', 'instance']";
    let folder = room(&format!(
        "[render]\nsamples_per_pixel = 1\nmax_depth = 1\n[output]\nraw = ['dng', 'exr']\nirradiance = true\nideal = true\n\
         objects = true\n{truth}\n"
    ));
    folder.add("points.csv", "0, 0.7, 0\n");
    folder.add("own.toml", OWN);
    folder.add("own.zmx", ZMX);
    folder.succeed("render capture.toml -o long -q --set exposure.time_s=0.0008");
    fs::rename(folder.path("long/raw.dng"), folder.path("long.dng")).expect("moved");
    fs::remove_dir_all(folder.path("long")).expect("removed");
    folder.succeed("render capture.toml -o r -q");
    refuse(&folder, command, wanted);
}

#[cfg(unix)]
#[test]
fn parts_of_images_hold_nothing_from_outside() {
    let folder = room("[render]\nsamples_per_pixel = 2\nmax_depth = 1\n");
    folder.succeed("render capture.toml --samples 0..1 -o a -q");
    folder.succeed("render capture.toml --samples 1..2 -o b -q");
    refuse(
        &folder,
        "merge a b -o m --input capture.toml",
        &["a", "a/part.json", "b/film.npy.gz", "capture.toml", "tiles.png"],
    );
}

#[cfg(unix)]
#[test]
fn checkpoints_hold_nothing_from_outside() {
    let more = "checkpoint_interval_s = 0.0001\npreview_interval_s = 0";
    let folder = room(&format!("[render]\nsamples_per_pixel = 64\nmax_depth = 1\n[output]\n{more}\n"));
    assert!(folder.killed_at("pass-ended", 3, "render capture.toml -o r -q"));
    let checkpoint = names(&folder).into_iter().find(|name| name.ends_with("checkpoint.film")).expect("a checkpoint");
    refuse(&folder, "render capture.toml -o r", &["r", &checkpoint.display().to_string()]);
}

/// A single lens, as Zemax writes it.
const ZMX: &str = "\
MODE SEQ
UNIT MM X W X CM MR CPMM
ENPD 5
WAVM 1 0.5876 1
PWAV 1
SURF 0
  CURV 0
  DISZ INFINITY
SURF 1
  STOP
  CURV 0.02
  DISZ 4
  GLAS N-BK7 0 0 1.5168 64.17
  DIAM 10
SURF 2
  CURV -0.02
  DISZ 48
  DIAM 10
SURF 3
  CURV 0
  DISZ 0
";

/// A sensor that names no files.
const OWN: &str = include_str!("../../crates/photosite-sensor/assets/sensors/andor-zyla-55.toml");

const SET: &str = "\
capture = 'board.toml'
frames = 1
[[cameras]]
name = 'left'
[[cameras]]
name = 'right'
position_m = [0.1, 0, 0]
";

/// A folder with a data set in `out`, made with these arguments.
fn set(arguments: &str) -> Folder {
    let board = BOARD.replace("[9, 6]", "[5, 4]").replace("max_depth = 2", "max_depth = 1");
    let folder = Folder::new([("board.toml", board.into()), ("set.toml", SET.into())]);
    folder.succeed(&format!("dataset set.toml -o out -q {TRUTH} {arguments}"));
    folder
}

const TRUTH: &str = "--set output.truth=['depth','instance'] --set output.objects=true";
const MANIFEST: &str = "out/manifest.jsonl";
const REPORT: &str = "out/left/000000/capture.json";
const IMAGE: &str = "out/right/000000/image.png";
const OF_TRUTH: &str = "out/right/000000/truth.exr";

#[cfg(unix)]
#[rstest]
#[case("dataset set.toml -o out TRUTH", &["set.toml", "board.toml", "out/dataset.json", REPORT, IMAGE])]
#[case("dataset set.toml -o out TRUTH --verify", &[REPORT, IMAGE])]
#[case("dataset set.toml -o out TRUTH --index-only", &[REPORT])]
#[case("dataset set.toml -o out TRUTH --dry-run", &["set.toml", "board.toml"])]
#[case("status out", &["out", "out/dataset.json", REPORT, IMAGE, OF_TRUTH])]
#[case("layout out --format colmap -o laid", &[MANIFEST, REPORT, IMAGE])]
#[case("layout out --format euroc -o laid", &[MANIFEST, REPORT, IMAGE])]
#[case("layout out --format kalibr -o laid", &[MANIFEST, REPORT, IMAGE])]
#[case("layout out --format bop -o laid", &[MANIFEST, REPORT, IMAGE, OF_TRUTH])]
#[case("layout out --format nerfstudio -o laid", &[MANIFEST, REPORT, IMAGE, OF_TRUTH])]
#[case("layout out --format coco -o laid", &[MANIFEST, REPORT, IMAGE, OF_TRUTH])]
#[case("rectify out -o rectified", &[MANIFEST, REPORT, IMAGE, OF_TRUTH])]
fn data_sets_hold_nothing_from_outside(#[case] command: &str, #[case] wanted: &[&str]) {
    refuse(&set(""), &command.replace("TRUTH", TRUTH), wanted);
}

#[cfg(unix)]
#[test]
fn what_is_made_of_data_sets_holds_nothing_from_outside() {
    let folder = set("");
    folder.succeed("rectify out -o rectified -q");
    let map = "rectified/left/000000/truth.exr";
    let depth = format!("depth {map} --channel disparity --rectified rectified -o z.exr");
    refuse(&folder, &depth, &[map, "rectified/rectify.json"]);
    for part in ["0..1", "1..2"] {
        folder.succeed(&format!("dataset set.toml -o part{part} -q --samples {part} --set render.samples_per_pixel=2"));
    }
    fs::remove_dir_all(folder.path("out")).expect("removed");
    refuse(
        &folder,
        "merge part0..1 part1..2 -o merged --input set.toml",
        &["part0..1/dataset.json", "part1..2/left/000000/part.json"],
    );
}

#[cfg(unix)]
#[test]
fn image_sets_hold_nothing_from_outside() {
    let folder = Folder::new([]);
    folder.succeed("emva1288 generic-cmos-color --channels G --size 12x8 --steps 5 --spatial 3 -o sets -q");
    let wanted = ["sets", "sets/emva1288.json", "sets/G/emva1288.txt"];
    refuse(&folder, "emva1288-report sets", &wanted);
    refuse(&folder, "emva1288-report sets/G/emva1288.txt -o page.html", &wanted[2..]);
}

/// Commands with the folder or file that they write.
#[cfg(unix)]
#[rstest]
#[case("render capture.toml -o", "r")]
#[case("develop raw.dng -o", "d.png")]
#[case("develop raw.dng -o", "d.exr")]
#[case("expose electrons -o", "e")]
#[case("noise add raw.dng --set gaussian.sigma=4 -o", "n.npy")]
#[case("merge-hdr raw.dng long.dng -o", "hdr.exr")]
#[case("export-mitsuba capture.toml --approximate -o", "m")]
#[case("init room.obj -o", "i.toml")]
#[case("camera capture.toml --format opencv -o", "c.yaml")]
#[case("lens own.zmx -o", "l.toml")]
#[case("dataset set.toml -o", "set")]
#[case("emva1288 generic-cmos-color --channels G --size 12x8 --steps 5 --spatial 3 -o", "sets")]
#[case("noise raw.dng --plots", "plots")]
fn nothing_is_written_through_links(#[case] command: &str, #[case] output: &str) {
    let folder = room("[render]\nsamples_per_pixel = 1\nmax_depth = 1\n[output]\nraw = ['dng']\n");
    folder.add("own.zmx", ZMX);
    folder.add("set.toml", "capture = 'capture.toml'\nframes = 1\n");
    folder.succeed("render capture.toml -o electrons -q");
    folder.succeed("render capture.toml -o long -q --set exposure.time_s=0.0008");
    fs::rename(folder.path("long/raw.dng"), folder.path("long.dng")).expect("moved");
    fs::copy(folder.path("electrons/raw.dng"), folder.path("raw.dng")).expect("copied");
    let outside = Folder::new([("private", b"private".to_vec())]);
    let link = |to: &str, name: &str| std::os::unix::fs::symlink(outside.path(to), folder.path(name)).expect("linked");
    let before = outside.contents();
    // A folder on the way to the output.
    link("", "out");
    let outcome = folder.run(&format!("--sandbox . {command} out/{output}"));
    assert!(outcome.status == Some(1) && outcome.text().contains("sandbox"), "{command}: {outcome:?}");
    assert_eq!(outside.contents(), before, "{command} writes through a folder's link");
    // The output itself: replaced, or refused.
    link("private", output);
    for force in ["", "--force"] {
        let outcome = folder.run(&format!("--sandbox . {command} {output} {force}"));
        assert!(outcome.status != Some(101), "{command} {force}: {outcome:?}");
        assert_eq!(outside.contents(), before, "{command} {force} writes through a file's link");
    }
    fs::remove_file(folder.path(output)).or_else(|_| fs::remove_dir_all(folder.path(output))).expect("removed");
    link("absent", output);
    folder.run(&format!("--sandbox . {command} {output} --force"));
    assert_eq!(outside.contents(), before, "{command} writes through a link to nothing");
    // Without a link it is written, whether its folder is named or not.
    let remove = |name: &str| fs::remove_file(folder.path(name)).or_else(|_| fs::remove_dir_all(folder.path(name)));
    drop(remove(output));
    for place in [output.to_owned(), format!("./{output}")] {
        folder.succeed(&format!("--sandbox . {command} {place}"));
        remove(output).expect("removed");
    }
}

/// Links in place of each file that a command writes into a folder of its own.
#[cfg(unix)]
#[rstest]
#[case("render capture.toml -o r --force", "r")]
#[case("expose electrons -o e --force", "e")]
#[case("export-mitsuba capture.toml --approximate -o m --force", "m")]
fn links_among_outputs_are_replaced(#[case] command: &str, #[case] output: &str) {
    let more = "raw = ['dng', 'tiff']\ntruth = ['depth']\nobjects = true\npreview_interval_s = 0\n";
    let folder = room(&format!("[render]\nsamples_per_pixel = 1\nmax_depth = 1\n[output]\n{more}"));
    folder.succeed("render capture.toml -o electrons -q");
    folder.succeed(command);
    let outside = Folder::new([("private", b"private".to_vec())]);
    let before = outside.contents();
    for name in names(&folder).into_iter().filter(|name| name.starts_with(output) && name != Path::new(output)) {
        let path = folder.path("").join(&name);
        let is_file = path.is_file();
        if is_file { fs::remove_file(&path) } else { fs::remove_dir_all(&path) }.expect("removed");
        let to = outside.path(if is_file { "private" } else { "" });
        std::os::unix::fs::symlink(to, &path).expect("linked");
        let outcome = folder.run(&format!("--sandbox . {command}"));
        assert!(outcome.status != Some(101), "{name:?}: {outcome:?}");
        assert_eq!(outside.contents(), before, "{command} writes through {name:?}: {outcome:?}");
        if path.is_symlink() {
            fs::remove_file(&path).expect("removed");
            folder.succeed(command);
        }
    }
}
