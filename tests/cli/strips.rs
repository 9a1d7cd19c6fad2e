//! Images whose film is larger than the memory for it, traced in strips: the bytes are those of one that fits.

use std::fs;

use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::assert_same;

/// Columns of the room's image. It has 24 rows.
const WIDTH: f64 = 32.0;
/// Channels of a film with all that can be asked for: those of the sensor, of the bands, of the ideal observer.
const CHANNELS: f64 = 3.0 + 30.0 + 3.0;

/// The option that gives strips of so many rows: 32 bytes a channel and 4 for the number of samples.
fn strips_of(rows: u32, channels: f64) -> String {
    format!("--film-memory {}", WIDTH * (channels * 32.0 + 4.0) * (f64::from(rows) + 0.5) / f64::from(1 << 30))
}

#[rstest]
#[case::still("", "all-filters")]
#[case::own_filter("", "own-filter")]
#[case::automatic("auto = true", "all-filters")]
#[case::moving("frames = 2\nframe_interval_s = 0.01\n[camera.motion]\nvelocity_m_per_s = [20, 0, 0]", "all-filters")]
fn strips_give_the_bytes_of_an_image_in_one_go(#[case] exposure: &str, #[case] wavelengths: &str) {
    let folder = room(&format!(
        "{exposure}\n[render]\nsamples_per_pixel = 6\nseed = 7\nwavelengths = '{wavelengths}'\n\
         [output]\nraw = ['dng', 'npy']\nirradiance = true\nideal = true\ntruth = ['depth', 'normal']\nnoise = true\n"
    ));
    if exposure.starts_with("auto") {
        folder.change("capture.toml", "time_s = 0.0002\n", "");
    }
    folder.succeed("render capture.toml -o whole --threads 1");
    for rows in [1, 5, 23] {
        let strips = strips_of(rows, CHANNELS);
        folder.succeed(&format!("render capture.toml -o strips-{rows} {strips} --threads 2"));
        assert_same(&folder, "whole", &format!("strips-{rows}"));
        assert!(!folder.path(&format!("strips-{rows}/checkpoint.rows")).exists());
    }
}

#[test]
fn parts_are_traced_and_merged_in_strips() {
    let folder = room("[render]\nsamples_per_pixel = 6\n[output]\nirradiance = true\n");
    folder.succeed("render capture.toml -o whole");
    folder.succeed("render capture.toml --samples 0..4 -o part");
    for rows in [1, 7] {
        let strips = strips_of(rows, 33.0);
        folder.succeed(&format!("render capture.toml --samples 0..4 -o strips-{rows} {strips}"));
        assert!(folder.results("part")["film.npy.gz"] == folder.results(&format!("strips-{rows}"))["film.npy.gz"]);
    }
    folder.succeed(&format!("render capture.toml --samples 4..6 -o rest {}", strips_of(5, 33.0)));
    folder.succeed(&format!("merge rest strips-7 -o merged {}", strips_of(4, 33.0)));
    assert_same(&folder, "whole", "merged");
}

/// The rows of the film in a checkpoint, before the first of which all are done.
fn rows_of(folder: &Folder, checkpoint: &str) -> Option<[u64; 2]> {
    let bytes = fs::read(folder.path(checkpoint)).ok()?;
    let line = bytes.split(|&byte| byte == b'\n').next()?;
    let header: Value = serde_json::from_slice(line).expect("a line of JSON");
    Some([0, 1].map(|i| header["rows"][i].as_u64().expect("a row")))
}

/// Kills a render each time it has written a file, and goes on with it, until its checkpoint is as it should be.
fn kill_when(folder: &Folder, arguments: &str, is_time: impl Fn([u64; 2]) -> bool) {
    while !rows_of(folder, "out/checkpoint.film").is_some_and(&is_time) {
        assert!(folder.killed_at("file-named", 1, arguments), "it ended before it was killed");
    }
}

#[rstest]
#[case::image("", ["--samples 0..1600", "it is of a whole image"])]
#[case::part("--samples 5..1600", ["--samples 0..1600", "it has the samples 5..1600"])]
fn a_killed_render_keeps_the_strips_that_are_done(#[case] part: &str, #[case] other: [&str; 2]) {
    let [other_part, message] = other;
    // So many that a strip takes longer than a checkpoint and the pause after it.
    let folder = room(
        "[render]\nsamples_per_pixel = 1600\n[output]\nirradiance = true\ncheckpoint_interval_s = 0.001\n\
         preview_interval_s = 0\n",
    );
    folder.succeed(&format!("render capture.toml -o whole {part}"));
    let go_on = format!("render capture.toml -o out {part} {}", strips_of(5, 33.0));
    kill_when(&folder, &format!("{go_on} --quiet"), |[first, end]| first >= 5 && end > first);
    let [done, _] = rows_of(&folder, "out/checkpoint.film").expect("a checkpoint");
    kill_when(&folder, &format!("{go_on} --quiet"), |[first, _]| first > done);
    let checkpoint = folder.bytes("out/checkpoint.film");
    assert!(!folder.path("out/electrons.exr").exists() && !folder.path("out/film.npy.gz").exists());

    // Less memory than the strip under way takes, other samples, and rows that are not all there.
    kill_when(&folder, &format!("{go_on} --quiet"), |[first, end]| first > done && end > first);
    let [wide, narrow] = [6, 4].map(|rows| format!("render capture.toml -o out {part} {}", strips_of(rows, 33.0)));
    folder.fail(
        &narrow,
        1,
        &["out/checkpoint.film", "another render: its film has the rows", "film memory", "--force"],
    );
    let other = format!("render capture.toml -o out {other_part} {}", strips_of(5, 33.0));
    folder.fail(&other, 1, &["out/checkpoint.film", "another render", message]);
    let rows = folder.bytes("out/checkpoint.rows");
    folder.add("out/checkpoint.rows", &rows[..1000]);
    folder.fail(&go_on, 1, &["out/checkpoint.film", "damaged", "holds 1000 bytes of", "starts again"]);
    let mut damaged = rows.clone();
    damaged[1000] ^= 1;
    folder.add("out/checkpoint.rows", damaged);
    folder.fail(&go_on, 1, &["out/checkpoint.film", "damaged", "the checksum of out/checkpoint.rows", "starts again"]);
    folder.add("out/checkpoint.rows", &*rows);

    // An earlier checkpoint goes with later rows: what is killed may have written these alone. With more memory the
    // strip under way is finished as it was begun, and those after it are others.
    folder.add("out/checkpoint.film", checkpoint.clone());
    let outcome = folder.succeed(&wide);
    assert!(outcome.text().contains("continuing from out/checkpoint.film at"), "{outcome:?}");
    for left in ["checkpoint.film", "checkpoint.rows"] {
        assert!(!folder.path("out").join(left).exists(), "{left}");
    }
    if part.is_empty() {
        assert_same(&folder, "whole", "out");
    } else {
        assert!(folder.results("whole")["film.npy.gz"] == folder.results("out")["film.npy.gz"]);
    }
}

#[rstest]
#[case::noise("--set render.noise_target=0.5", 1, "render.noise_target: takes the film of the whole image")]
#[case::time("--set render.time_limit_s=3", 1, "render.time_limit_s: takes the film of the whole image")]
#[case::nothing("", 2, "write a number above 0")]
fn what_strips_cannot_do_is_refused(#[case] arguments: &str, #[case] status: i32, #[case] message: &str) {
    let folder = room("[render]\nsamples_per_pixel = 6\n");
    let memory = if status == 2 { "--film-memory 0".to_owned() } else { strips_of(5, 3.0) };
    folder.fail(&format!("render capture.toml -o out {arguments} {memory}"), status, &[message, "--film-memory"]);
}
