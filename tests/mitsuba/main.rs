//! Every scene of the suite against its stored reference, which Mitsuba 3 rendered (`references.py`).
//!
//! Both images are mean electrons with the variance of the mean, so that z = (ours − Mitsuba's)/√(sum of variances)
//! of each pixel and channel follows N(0, 1) where both renderers mean the same. Neither Python nor Mitsuba is needed
//! here.

mod blocks;
mod branches;
mod irradiance;

use std::path::Path;
use std::process::Command;

use photosite::io::image_file::read_image_file;
use photosite::raw::Pixels;
use photosite::validation::{ComparedImage, ComparisonSettings, compare};
use rstest::rstest;

use blocks::{Block, blocks};

/// Largest difference between channel means, percent.
const MEAN_PERCENT: f64 = 0.5;
/// A fault that blocks may not hide, percent of their light; but for a third of them, as where many-lights shows the edges of
/// small lamps before black.
const FAULT_PERCENT: f64 = 5.0;
/// How many standard errors a normal number may lie off: of the 1,100 blocks and 100 spreads that the suite looks at, one
/// exceeds this with a probability of 1 % (Šidák).
const SIGMAS: f64 = 4.5;

/// Our image of a capture and the reference beside it.
fn ours_and_reference(capture: &Path) -> [ComparedImage; 2] {
    let out = tempfile::tempdir().expect("a temporary folder");
    let render = Command::new(env!("CARGO_BIN_EXE_photosite"))
        .args(["render", "--quiet", "--set", "output.raw=[]", "-o"])
        .args([out.path(), capture])
        .output()
        .expect("the command starts");
    assert!(render.status.success(), "{}", String::from_utf8_lossy(&render.stderr));
    [out.path().join("electrons.exr"), capture.with_file_name("reference.exr")]
        .map(|path| read_image_file(&path, Pixels::Active).unwrap_or_else(|error| panic!("{error}")))
}

#[rstest]
fn agrees_with_mitsuba(
    #[files("tests/mitsuba/scenes/*/capture.toml")]
    #[mode = path]
    capture: std::path::PathBuf,
) {
    let [ours, reference] = ours_and_reference(&capture);
    let comparison =
        compare(&ours, &reference, &ComparisonSettings::default()).unwrap_or_else(|error| panic!("{error}"));
    for channel in &comparison.channels {
        let z = channel.z_scores.as_ref().expect("both sides have variances");
        assert!(channel.mean_difference_percent.abs() < MEAN_PERCENT, "{channel:#?}");
        // The standard error of the spread of n normal numbers is 1/√2n.
        assert!((z.spread - 1.0).abs() < SIGMAS / (2.0 * z.tests as f64).sqrt(), "{channel:#?}");
    }
    let blocks = blocks(&ours, &reference);
    for block in &blocks {
        let bound = MEAN_PERCENT + SIGMAS * block.standard_error_percent;
        assert!(block.difference_percent.abs() < bound, "{block:?}");
    }
    // A block with the fault lies within that bound only if its noise is as far to the other side.
    let may_hide = |block: &&Block| MEAN_PERCENT + 2.0 * SIGMAS * block.standard_error_percent > FAULT_PERCENT;
    let noisy: Vec<&Block> = blocks.iter().filter(may_hide).collect();
    assert!(3 * noisy.len() <= blocks.len(), "more samples: {noisy:#?}");
    let verdict = comparison.verdict.expect("both sides have variances");
    assert!(verdict.agree, "{verdict:#?}\n{:#?}", comparison.worst);
}
