//! Several frames of the same light.

use photosite::math::statistics::Moments;

use crate::room::room;

#[test]
fn frames_are_numbered_and_differ_by_zero_mean_noise() {
    let folder = room("frames = 3\n[render]\nsamples_per_pixel = 4\n[output]\nraw = ['dng', 'npy']\n");
    folder.succeed("render capture.toml -o out");
    let names: Vec<String> = folder.results("out").into_keys().collect();
    let numbered = ["raw-0000.dng", "raw-0000.npy", "raw-0001.dng", "raw-0001.npy", "raw-0002.dng", "raw-0002.npy"];
    assert_eq!(names[..3], ["capture.json", "electrons.exr", "image.png"]);
    assert_eq!(names[3..], numbered);
    assert_eq!(folder.report("out")["exposure"]["frames"], 3);

    let [first, second, third] = [0, 1, 2].map(|frame| folder.raw(&format!("out/raw-{frame:04}.dng")).data);
    for (a, b) in [(&first, &second), (&second, &third), (&first, &third)] {
        // What the frames have in common cancels in the difference, so its own spread is the yardstick.
        let difference: Moments = a.iter().zip(b).map(|(&a, &b)| f64::from(a) - f64::from(b)).collect();
        let error = (difference.variance() / a.len() as f64).sqrt();
        assert!(error > 0.0 && difference.mean().abs() < 4.5 * error, "{} ± {error} DN", difference.mean());
    }
}

#[test]
fn a_series_begins_with_the_single_image() {
    let folder = room("[render]\nsamples_per_pixel = 4");
    folder.succeed("render capture.toml -o single");
    folder.succeed("render capture.toml -o series --set exposure.frames=2");
    let (single, series) = (folder.results("single"), folder.results("series"));
    assert!(single["raw.dng"] == series["raw-0000.dng"]);
    assert!(single["image.png"] == series["image.png"]);
    assert!(series["raw-0000.dng"] != series["raw-0001.dng"]);
}
