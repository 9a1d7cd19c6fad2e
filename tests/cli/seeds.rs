//! Another seed gives other noise, and nothing else.

use photosite::image::{Channel, Planes};
use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;

/// How many standard deviations a sum of all pixels may be off: a chance of 1 in 10⁵ for each comparison.
const SIGMAS: f64 = 4.5;

fn sum(channel: &Channel) -> f64 {
    channel.data.iter().map(|&value| f64::from(value)).sum()
}

/// Renders with two seeds, as `one` and `two`.
fn two_seeds(folder: &Folder) {
    folder.succeed("render capture.toml --seed 1 -o one");
    folder.succeed("render capture.toml --seed 2 -o two");
}

#[rstest]
fn mean_electrons_agree_within_their_variance(#[values("sobol", "independent")] sampler: &str) {
    let folder = room(&format!("[render]\nsamples_per_pixel = 32\nsampler = '{sampler}'\n"));
    two_seeds(&folder);
    let (one, two) = (folder.electrons("one"), folder.electrons("two"));
    let sums = |planes: &Planes| planes.channels().iter().map(sum).collect::<Vec<_>>();
    let (sum_one, sum_two) = (sums(&one.mean), sums(&two.mean));
    let (variance_one, variance_two) = (sums(&one.variance), sums(&two.variance));
    for channel in 0..3 {
        let (difference, sigma) =
            (sum_one[channel] - sum_two[channel], (variance_one[channel] + variance_two[channel]).sqrt());
        // Were the noise half the signal, agreement within it would mean nothing.
        assert!(sigma < 0.1 * sum_one[channel], "{sigma} of {}", sum_one[channel]);
        assert!(difference.abs() < SIGMAS * sigma, "channel {channel}: {difference} is beyond {SIGMAS} times {sigma}");
    }
    let differing = (0..32 * 24).filter(|&i| one.mean.channels()[1].data[i] != two.mean.channels()[1].data[i]).count();
    assert!(differing > 32 * 24 * 9 / 10, "light transport follows the seed: {differing} pixels differ");
}

#[test]
fn all_that_is_no_noise_stays() {
    let folder = room("[render]\nsamples_per_pixel = 4");
    two_seeds(&folder);
    let (one, two) = (folder.report("one"), folder.report("two"));
    for key in ["photosite_version", "input", "camera", "lens", "sensor", "exposure", "files", "warnings", "paths"] {
        assert!(!one[key].is_null());
        assert_eq!(one[key], two[key], "{key}");
    }
    assert_eq!((&one["seed"], &two["seed"]), (&1.into(), &2.into()));
}

/// In the dark there is no noise but that of the sensor.
#[test]
fn the_noise_of_the_sensor_follows_the_seed() {
    let folder = room("");
    folder.add(
        "capture.toml",
        "[scene]\ngeometry = ['sails.gltf']\n[sensor]\nresolution_px = [32, 24]\n\
         [exposure]\ntime_s = 4\n",
    );
    two_seeds(&folder);
    assert!(folder.electrons("one") == folder.electrons("two"), "no light, no noise of light");
    let (one, two) = (folder.raw("one/raw.dng"), folder.raw("two/raw.dng"));
    let differing = one.data.iter().zip(&two.data).filter(|(a, b)| a != b).count();
    assert!(differing > one.data.len() / 4, "{differing} pixels differ");
}
