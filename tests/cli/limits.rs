//! Renders that end by time or by noise, and automatic exposure.

use crate::folder::Folder;
use crate::room::room;

#[test]
fn a_time_limit_ends_a_render_of_many_samples() {
    let folder = room("[render]\nsamples_per_pixel = 4_000_000_000\ntime_limit_s = 0.3");
    folder.succeed("render capture.toml -o out");
    let report = folder.report("out");
    let traced = report["timings"]["trace_s"].as_f64().expect("seconds");
    // The last pass is finished; here it takes milliseconds, on a busy machine somewhat more.
    assert!((0.3..10.0).contains(&traced), "{traced} s");
    let samples = report["render"]["samples_per_pixel"].as_u64().expect("a number");
    assert!(samples > 0 && samples < 4_000_000_000);
    assert_eq!(report["paths"], 32 * 24 * samples);
}

#[test]
fn a_noise_target_ends_a_render_when_it_is_reached() {
    let folder = Folder::new([
        ("floor.obj", b"v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n".to_vec()),
        (
            "capture.toml",
            b"[scene]\ngeometry = ['floor.obj']\nenvironment = { illuminant = 'D65', illuminance_lux = 500 }\n\
              [sensor]\nresolution_px = [32, 24]\n[sensor.noise]\nprnu_percent = 0\ndsnu_e = 0\ndark_current_e_per_s = 0\n\
              [exposure]\ntime_s = 0.01\n[render]\nsamples_per_pixel = 4_000_000_000\nnoise_target = 0.1\n"
                .to_vec(),
        ),
    ]);
    folder.succeed("render capture.toml -o out");
    let report = folder.report("out");
    let ratio = report["render"]["noise_ratio"].as_f64().expect("a ratio");
    let samples = report["render"]["samples_per_pixel"].as_u64().expect("a number");
    // Ratio ∝ 1/√samples, and the last pass at most doubles the samples.
    assert!(ratio <= 0.1 && ratio > 0.05, "{ratio} after {samples} samples");

    // The same ratio from the file: noise of light against shot, read and quantisation noise, over each pixel's
    // channel.
    let electrons = folder.electrons("out");
    let (read_noise, gain) = (4.0, 0.1344);
    let (mut of_light, mut of_sensor) = (0.0, 0.0);
    for pixel in 0..32 * 24 {
        let (x, y) = (pixel % 32, pixel / 32);
        let name = [["R", "G"], ["G", "B"]][y % 2][x % 2];
        let value = |planes: &photosite::image::Planes| f64::from(planes.plane(name).expect(name)[pixel]);
        of_light += value(&electrons.variance);
        of_sensor += value(&electrons.mean) + read_noise * read_noise + 1.0 / (12.0 * gain * gain);
    }
    let expected = (of_light / of_sensor).sqrt();
    assert!((ratio / expected - 1.0).abs() < 1e-6, "{ratio} against {expected}");
}

#[test]
fn automatic_exposure_puts_the_bright_parts_where_it_is_told() {
    let folder = room("[render]\nsamples_per_pixel = 64");
    let capture = String::from_utf8(folder.results(".")["capture.toml"].clone()).expect("UTF-8");
    folder.add("capture.toml", capture.replace("time_s = 0.0002", "auto = true\nauto_brighter_part = 0.05"));
    for target in [0.3, 0.85] {
        let name = format!("out-{target}");
        folder.succeed(&format!("render capture.toml -o {name} --set exposure.auto_target={target}"));
        let report = folder.report(&name);
        assert_eq!(report["exposure"]["auto"], true);
        let mut raw = folder.raw(&format!("{name}/raw.dng"));
        raw.data.sort_unstable();
        let bright = f64::from(raw.data[raw.data.len() * 95 / 100]) - f64::from(raw.black_level_dn.mean());
        let range = f64::from(raw.white_level_dn) - f64::from(raw.black_level_dn.mean());
        // 25 000 e⁻ have shot noise and PRNU of below 1.1 %, which widens the histogram; 9000 e⁻ of below 1.4 %.
        let level = bright / range;
        assert!((level / target - 1.0).abs() < 0.04, "{level} instead of {target}");
    }
}
