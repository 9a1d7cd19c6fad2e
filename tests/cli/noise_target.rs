//! Rendering until noise is low enough in each pixel, in a scene with depth of field.

use photosite::image::{Estimate, Planes};
use serde_json::Value;

use crate::folder::Folder;
use crate::same_bytes::assert_same;

const SIZE: [usize; 2] = [24, 16];
/// Monte Carlo noise of this part of the sensor's adds 0.7 % to the total: √(1 + 0.12²).
const TARGET: f64 = 0.12;

/// A card in focus under an overcast sky, and before the wall behind it two small lamps, which become discs. The gain
/// is the lowest.
fn scene() -> Folder {
    let obj = "mtllib scene.mtl\n\
        v -3 0 1\nv 3 0 1\nv 3 0 -4\nv -3 0 -4\n\
        v -3 0 -3.2\nv 3 0 -3.2\nv 3 3 -3.2\nv -3 3 -3.2\n\
        v -0.40 0.30 -3\nv -0.39 0.30 -3\nv -0.39 0.31 -3\nv -0.40 0.31 -3\n\
        v 0.30 0.22 -3\nv 0.31 0.22 -3\nv 0.31 0.23 -3\nv 0.30 0.23 -3\n\
        v -0.05 0 -0.45\nv 0.05 0 -0.55\nv 0.05 0.15 -0.55\nv -0.05 0.15 -0.45\n\
        usemtl grey\nf 1 2 3 4\nf 5 6 7 8\nusemtl lamp\nf 9 10 11 12\nf 13 14 15 16\nusemtl card\nf 17 18 19 20\n";
    let mtl = "newmtl grey\nKd 0.3 0.3 0.3\nnewmtl card\nKd 0.7 0.5 0.3\nnewmtl lamp\nKd 0 0 0\nKe 300 300 300\n";
    let capture = format!(
        "[scene]\ngeometry = ['scene.obj']\nenvironment = {{ illuminant = 'D65', illuminance_lux = 40 }}\n\
         [camera]\nposition_m = [0, 0.12, 0]\nlook_at_m = [0, 0.11, -0.5]\n\
         [lens]\nfocal_length_mm = 25\nf_number = 1\nfocus_distance_m = 0.5\n\
         [sensor]\npreset = 'generic-cmos-color'\nresolution_px = {SIZE:?}\npixel_pitch_um = [400, 400]\n\
         [sensor.noise]\nprnu_percent = 0\ndsnu_e = 0\ndark_current_e_per_s = 0\n\
         [exposure]\ntime_s = 4e-8\n\
         [render]\nsamples_per_pixel = 4_000_000\nnoise_target = {TARGET}\nmax_depth = 2\nsampler = 'independent'\n"
    );
    let files = [("scene.obj", obj.as_bytes()), ("scene.mtl", mtl.as_bytes()), ("capture.toml", capture.as_bytes())];
    Folder::new(files.map(|(name, bytes)| (name, bytes.to_vec())))
}

/// The values of each pixel's own channel.
fn mosaic(planes: &Planes) -> Vec<f64> {
    let value = |i: usize| {
        let name = [["R", "G"], ["G", "B"]][i / SIZE[0] % 2][i % SIZE[0] % 2];
        f64::from(planes.plane(name).expect(name)[i])
    };
    (0..SIZE[0] * SIZE[1]).map(value).collect()
}

/// What `samples.npy` holds.
fn samples(folder: &Folder, name: &str) -> Vec<f64> {
    let file = folder.bytes(&format!("{name}/samples.npy"));
    let array = npyz::NpyFile::new(&file[..]).expect("an array");
    assert_eq!(array.shape(), [SIZE[1] as u64, SIZE[0] as u64]);
    array.into_vec::<u32>().expect("numbers").into_iter().map(f64::from).collect()
}

#[test]
fn noise_is_as_low_as_that_of_the_worst_pixels_samples_everywhere_with_far_fewer_paths() {
    let folder = scene();
    folder.succeed("render capture.toml -o out");
    let report = folder.report("out");
    let Estimate { mean, variance } = folder.electrons("out");
    let (mean, variance, counts) = (mosaic(&mean), mosaic(&variance), samples(&folder, "out"));
    let pixels = counts.len() as f64;

    // Shot noise, read noise and quantisation.
    let of_sensor: Vec<f64> = mean.iter().map(|mean| mean + 4.0 * 4.0 + 1.0 / (12.0 * 0.1344 * 0.1344)).collect();
    // The samples that 99 % of the pixels are content with.
    let of_one: Vec<f64> = variance.iter().zip(&counts).map(|(v, n)| v * n).collect();
    let mut needed: Vec<f64> = of_one.iter().zip(&of_sensor).map(|(v, s)| v / (s * TARGET * TARGET)).collect();
    needed.sort_by(f64::total_cmp);
    let uniform = needed[(0.99 * pixels) as usize];
    let total = |of_light: &dyn Fn(usize) -> f64| {
        (0..counts.len()).map(|i| of_light(i) + of_sensor[i]).sum::<f64>().sqrt() / pixels.sqrt()
    };
    let ratio = total(&|i| variance[i]) / total(&|i| of_one[i] / uniform);
    let paths = report["paths"].as_f64().expect("a number");
    println!("{paths} paths instead of {}, total noise {ratio} times", uniform * pixels);
    // Light whose noise has reached the target has a variance of TARGET² times the sensor's or less, over all pixels, and the
    // noise that it is compared to is the sensor's at least.
    assert!(ratio < (1.0 + TARGET * TARGET).sqrt(), "{ratio}");
    assert!(paths * 3.0 < uniform * pixels, "{paths} paths against {}", uniform * pixels);

    let noise = &report["render"]["noise"];
    let number = |key: &str| noise[key].as_f64().expect(key);
    assert_eq!(number("target"), TARGET);
    assert!(report["render"]["noise_ratio"].as_f64().expect("a ratio") <= TARGET, "{noise}");
    assert!(number("pixels_at_target") > 0.9, "{noise}");
    assert!(number("ratio_of_99_percent") < 2.0 * TARGET, "{noise}");
    let sum: f64 = counts.iter().sum();
    assert_eq!(number("samples_mean"), sum / pixels);
    assert_eq!(number("samples_least"), counts.iter().copied().fold(f64::INFINITY, f64::min));
    assert_eq!(number("samples_most"), counts.iter().copied().fold(0.0, f64::max));
    assert_eq!(paths, sum + number("pilot_samples_mean") * pixels);

    // The noise is what the variance says: the differences of two renders, of 384 pixels that are nearly normal.
    folder.succeed("render capture.toml -o other --seed 1");
    let other = folder.electrons("other");
    let (other_mean, other_variance) = (mosaic(&other.mean), mosaic(&other.variance));
    let squares = |i: usize| (mean[i] - other_mean[i]).powi(2) / (variance[i] + other_variance[i]);
    let chi_squared = (0..counts.len()).map(squares).sum::<f64>() / pixels;
    assert!((chi_squared - 1.0).abs() < 4.0 * (2.0 / pixels).sqrt(), "{chi_squared}");
    // Nor do both lean to one side: the sum of many z-scores.
    let z = |i: usize| (mean[i] - other_mean[i]) / (variance[i] + other_variance[i]).sqrt();
    let sum = (0..counts.len()).map(z).sum::<f64>() / pixels.sqrt();
    assert!(sum.abs() < 4.0, "{sum}");
}

#[test]
fn a_noise_target_gives_the_same_bytes_on_any_number_of_threads_and_keeps_its_limits() {
    let folder = scene();
    let set = "--set render.noise_target=0.5 --set render.sampler=sobol --set exposure.frames=2";
    for threads in [1, 2] {
        folder.succeed(&format!("render capture.toml -o {threads} --threads {threads} {set}"));
    }
    assert_same(&folder, "1", "2");
    assert!(folder.path("1/samples.npy").exists());
    folder.succeed(&format!("render capture.toml -o few {set} --set render.samples_per_pixel=5"));
    assert!(samples(&folder, "few").iter().all(|&n| n == 5.0));
    folder.succeed(&format!("render capture.toml -o limit {set} --set render.samples_per_pixel=30"));
    let limited = samples(&folder, "limit");
    assert!(limited.contains(&30.0) && limited.iter().all(|&n| (16.0..=30.0).contains(&n)));
    let out = &folder.report("limit")["render"];
    assert_eq!(out["samples_per_pixel"], 30);
    folder.succeed("render capture.toml -o plain --set render.samples_per_pixel=8 --set render.noise_target=1e9");
    assert!(samples(&folder, "plain").iter().all(|&n| n == 8.0));
    assert_ne!(out["noise"], Value::Null);
}
