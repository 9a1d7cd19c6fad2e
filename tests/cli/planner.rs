//! Renders whose numbers of paths the planner has chosen: the same bytes in one go, in strips and in parts.

use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::assert_same;

/// Samples per pixel from which on the planner looks at an image of the room, 32 × 24 pixels: 2²⁰ in all.
const SAMPLES: u32 = 1366;

fn planned() -> Folder {
    room(&format!("[render]\nsamples_per_pixel = {SAMPLES}\nmax_depth = 5\nseed = 7\n[output]\nraw = ['npy']\n"))
}

#[test]
fn a_planned_render_has_the_same_bytes_in_strips_and_in_parts_and_says_what_was_chosen() {
    let folder = planned();
    let outcome = folder.succeed("render capture.toml -o whole --threads 1");
    assert!(outcome.text().contains("strategy: "), "{outcome:?}");
    let render = &folder.report("whole")["render"];
    let plan = &render["plan"];
    assert!(plan["gain"].as_f64().is_some_and(|gain| gain >= 1.0), "{render}");
    assert!(plan["cost"].as_f64().is_some_and(|cost| cost > 0.0 && cost < 0.15), "{render}");
    assert_eq!([&plan["splitting"], &plan["light_paths"]], [&render["splitting"], &render["light_paths"]]);

    // A film of 7 rows: 32 bytes a channel and 4 for the number of samples.
    let memory = 32.0 * (3.0 * 32.0 + 4.0) * 7.5 / f64::from(1 << 30);
    folder.succeed(&format!("render capture.toml -o strips --threads 2 --film-memory {memory}"));
    assert_same(&folder, "whole", "strips");
    folder.succeed("render capture.toml --samples 0..500 -o first --threads 7");
    folder.succeed(&format!("render capture.toml --samples 500..{SAMPLES} -o rest"));
    folder.succeed("merge rest first -o merged");
    assert_same(&folder, "whole", "merged");
}

#[rstest]
fn a_planned_render_that_was_killed_goes_on_by_its_plan(
    #[values("pass-ended", "file-written", "picture-complete")] point: &str,
    #[values("", "--set output.checkpoint_interval_s=1e-6")] checkpoints: &str,
) {
    let folder = planned();
    folder.succeed(&format!("render capture.toml -o whole {checkpoints}"));
    let again = format!("render capture.toml -o again {checkpoints}");
    for count in [1, 3] {
        folder.killed_at(point, count, &again);
        folder.succeed(&again);
        assert_same(&folder, "whole", "again");
        std::fs::remove_dir_all(folder.path("again")).expect("removed");
    }
}

#[test]
fn plain_paths_and_few_samples_have_no_plan() {
    let folder = planned();
    for more in ["--set render.strategy=plain --spp 1366", "--spp 1365"] {
        folder.succeed(&format!("render capture.toml -o out --force {more}"));
        let render = &folder.report("out")["render"];
        assert_eq!((&render["plan"], &render["splitting"]), (&serde_json::Value::Null, &1.into()), "{more}");
    }
}
