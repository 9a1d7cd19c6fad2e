//! Every scene of the suite against its stored reference, which Mitsuba 3 rendered (`references.py`).
//!
//! Both pictures are mean electrons with the variance of the mean, so that z = (ours − Mitsuba's)/√(sum of variances)
//! of each pixel and channel follows N(0, 1) where both renderers mean the same. Neither Python nor Mitsuba is needed
//! here.

mod branches;
mod irradiance;

use std::path::Path;
use std::process::Command;

use photosite::io::picture_file::read_picture_file;
use photosite::raw::Pixels;
use photosite::validation::{Comparison, Settings, compare};
use rstest::rstest;

/// Largest difference between channel means, percent.
const MEAN_PERCENT: f64 = 0.5;
/// The spread of z is 1 to within this. It is estimated from 4096 pixels, hence by itself uncertain by 1/√8192 = 0.011.
const SPREAD: f64 = 0.03;

/// Our picture of a capture against the reference beside it.
fn against_reference(capture: &Path) -> Comparison {
    let out = tempfile::tempdir().expect("a temporary folder");
    let render = Command::new(env!("CARGO_BIN_EXE_photosite"))
        .args(["render", "--quiet", "--set", "output.raw=[]", "-o"])
        .args([out.path(), capture])
        .output()
        .expect("the command starts");
    assert!(render.status.success(), "{}", String::from_utf8_lossy(&render.stderr));
    let read = |path: &Path| read_picture_file(path, Pixels::Active).unwrap_or_else(|error| panic!("{error}"));
    let reference = capture.with_file_name("reference.exr");
    compare(&read(&out.path().join("electrons.exr")), &read(&reference), &Settings::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

#[rstest]
fn agrees_with_mitsuba(
    #[files("tests/mitsuba/scenes/*/capture.toml")]
    #[mode = path]
    capture: std::path::PathBuf,
) {
    let comparison = against_reference(&capture);
    for channel in &comparison.channels {
        let z = channel.z_scores.as_ref().expect("both sides have variances");
        assert!(channel.mean_difference_percent.abs() < MEAN_PERCENT, "{channel:#?}");
        assert!((z.spread - 1.0).abs() < SPREAD, "{channel:#?}");
    }
    let verdict = comparison.verdict.expect("both sides have variances");
    assert!(verdict.agree, "{verdict:#?}\n{:#?}", comparison.worst);
}
