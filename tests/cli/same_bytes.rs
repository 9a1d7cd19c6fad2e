//! The same input and seed give the same bytes on any number of threads.

use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;
use crate::room::room;

/// `capture.json` without what time passing changes.
pub(crate) fn timeless(mut report: Value) -> Value {
    let object = report.as_object_mut().expect("an object");
    for key in ["timings", "paths_per_s"] {
        object.remove(key).expect(key);
    }
    report
}

pub(crate) fn assert_same(folder: &Folder, one: &str, two: &str) {
    let (mut first, mut second) = (folder.results(one), folder.results(two));
    assert_eq!(timeless(folder.report(one)), timeless(folder.report(two)));
    for results in [&mut first, &mut second] {
        results.remove("capture.json");
    }
    assert!(first.keys().eq(second.keys()), "{:?} {:?}", first.keys(), second.keys());
    for (name, bytes) in &first {
        assert!(*bytes == second[name], "{name} differs");
    }
}

#[rstest]
fn one_and_two_threads_give_the_same_bytes(
    #[values("sobol", "independent")] sampler: &str,
    #[values(1, 2)] frames: u32,
    #[values("all-filters", "own-filter")] wavelengths: &str,
) {
    let folder = room(&format!(
        "frames = {frames}\n[render]\nsamples_per_pixel = 8\nsampler = '{sampler}'\nsplitting = {frames}\nseed = 7\n\
         wavelengths = '{wavelengths}'\n\
         [output]\nraw = ['dng', 'tiff', 'pgm', 'npy']\nirradiance = true\n"
    ));
    folder.succeed("render capture.toml --threads 1 -o one");
    folder.succeed("render capture.toml --threads 2 -o two");
    folder.succeed("render capture.toml -o all");
    assert_same(&folder, "one", "two");
    assert_same(&folder, "one", "all");
    assert_eq!(folder.results("one").len(), 4 * frames as usize + 4, "{:?}", folder.results("one").keys());
}

#[test]
fn automatic_exposure_and_focus_do_not_depend_on_threads() {
    let folder = room("[render]\nsamples_per_pixel = 4");
    let capture = String::from_utf8(folder.results(".")["capture.toml"].clone()).expect("UTF-8");
    folder.add("capture.toml", capture.replace("time_s = 0.0002", "auto = true"));
    folder.succeed("render capture.toml --threads 1 -o one");
    folder.succeed("render capture.toml --threads 2 -o two");
    assert_same(&folder, "one", "two");
}
