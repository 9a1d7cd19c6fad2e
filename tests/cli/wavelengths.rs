//! `render.wavelengths`: pixels of every filter array get the wavelengths of their own filter.

use photosite::image::Planes;
use rstest::rstest;

use crate::folder::Folder;

const SIZE: [usize; 2] = [12, 8];

/// Daylight through a pane of glass that disperses, so that each path is left with one wavelength.
fn pane(preset: &str, cfa: &str) -> Folder {
    let obj = "mtllib scene.mtl\nusemtl glass\n\
        v -9 -9 -1\nv 9 -9 -1\nv 9 9 -1\nv -9 9 -1\nv -9 -9 -2\nv 9 -9 -2\nv 9 9 -2\nv -9 9 -2\nf 1 2 3 4\nf 8 7 6 5\n";
    let capture = format!(
        "[scene]\ngeometry = ['scene.obj']\nenvironment = {{ illuminant = 'D65', illuminance_lux = 100 }}\n\
         [camera]\nposition_m = [0, 0, 0]\nlook_at_m = [0, 0, -1]\n\
         [lens]\nfocal_length_mm = 25\nf_number = 4\nfocus_distance_m = 1.5\n\
         [sensor]\npreset = '{preset}'\ncfa = '{cfa}'\nresolution_px = {SIZE:?}\n\
         [materials.glass]\ntype = 'dielectric'\nglass = 'BK7'\n\
         [exposure]\ntime_s = 0.01\n\
         [render]\nsamples_per_pixel = 1024\nmax_depth = 8\nsampler = 'independent'\n\
         [output]\nraw = ['dng']\n"
    );
    let files = [("scene.obj", obj), ("scene.mtl", "newmtl glass\n"), ("capture.toml", &capture)];
    Folder::new(files.map(|(name, text)| (name, text.into())))
}

#[rstest]
fn each_pixel_of_a_mosaic_is_quieter_in_its_own_colour(#[values("RGGB", "GBRG", "x-trans", "quad-bayer")] cfa: &str) {
    let folder = pane("generic-cmos-color", cfa);
    folder.succeed("render capture.toml -o all --seed 2");
    folder.succeed("render capture.toml --set render.wavelengths=own-filter -o own");
    assert_eq!(folder.report("own")["render"]["wavelengths"], "own-filter");
    let tile = folder.raw("own/raw.dng").cfa;
    let [all, own] = ["all", "own"].map(|name| folder.electrons(name));
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let channel = &tile.channels()[tile.channel_at(x, y)];
            let [all, own] = [&all, &own].map(|estimate| {
                let value = |planes: &Planes| f64::from(planes.plane(channel).expect("a plane")[y * SIZE[0] + x]);
                (value(&estimate.mean), value(&estimate.variance))
            });
            let z = (own.0 - all.0) / (own.1 + all.1).sqrt();
            // 96 such values exceed 4.5 once in 1500 times.
            assert!(z.abs() < 4.5, "{channel} in {x}, {y}: {} with all filters, {} with its own", all.0, own.0);
            // Of single wavelengths some third is seen by each of three filters, of its own nine tenths: relative
            // variances of 1/p − 1 are 2 and 0.1, and more where a filter is broad.
            assert!(
                own.1 < 0.25 * all.1,
                "{channel} in {x}, {y}: variance {} with all filters, {} with its own",
                all.1,
                own.1
            );
        }
    }
}

#[rstest]
#[case::mono("sony-imx249-mono", "mono")]
#[case::full("generic-cmos-color", "full:RGB")]
fn where_all_pixels_see_the_same_nothing_changes(#[case] preset: &str, #[case] cfa: &str) {
    let folder = pane(preset, cfa);
    for choice in ["all-filters", "own-filter"] {
        folder.succeed(&format!("render capture.toml --set render.wavelengths={choice} -o {choice}"));
    }
    let [all, own] = ["all-filters", "own-filter"].map(|name| folder.results(name).remove("electrons.exr"));
    assert!(all.is_some() && all == own, "{cfa}");
    let warnings = folder.report("own-filter")["warnings"].to_string();
    assert!(warnings.contains("render.wavelengths: all pixels see the same"), "{warnings}");
    assert!(!folder.report("all-filters")["warnings"].to_string().contains("wavelengths"));
}

/// Bands must not take the wavelengths that the sensor sees. With p(λ) for the image alone and at least p/(1 + b)
/// beside bands, a path of one wavelength has a relative variance V = ∫f²/p dλ − 1 that grows to (1 + b)·V + b at most,
/// b being 0.2.
#[test]
fn bands_beside_the_image_of_a_sensor_that_sees_infrared_leave_its_noise_as_it_is() {
    let folder = pane("sony-imx249-mono", "mono");
    let render = "render capture.toml --set scene.environment.illuminant=A";
    folder.succeed(&format!("{render} -o alone"));
    folder.succeed(&format!("{render} --set output.irradiance=true -o beside"));
    let [alone, beside] = ["alone", "beside"].map(|name| {
        let electrons = folder.electrons(name);
        let [mean, variance] = [&electrons.mean, &electrons.variance].map(|planes| {
            let plane = planes.plane("Y").expect("a plane");
            plane.iter().map(|&value| f64::from(value)).sum::<f64>() / plane.len() as f64
        });
        1024.0 * variance / (mean * mean)
    });
    // The mean of 96 variances of 1024 samples each is known to √(κ/98304), 2 % for a kurtosis κ of 40.
    assert!(beside < 1.06 * (1.2 * alone + 0.2), "variances of a sample: {alone} alone, {beside} beside bands");
}

/// The CIE's table of D65 ends at 830 nm with 60.3125, where silicon still sees; beyond, it is a blackbody of 6504 K.
#[test]
fn daylight_beyond_its_table_reaches_the_sensor() {
    let folder = pane("sony-imx249-mono", "mono");
    let mean = |name: &str, [first, last]: [f64; 2]| {
        let rows = format!("{first},0\n{},1\n{},1\n{last},0\n", first + 1.0, last - 1.0);
        folder.add(&format!("{name}.csv"), rows);
        let curve = format!("sensor.channels.Y.quantum_efficiency={{file=\"{name}.csv\"}}");
        folder.succeed(&format!("render capture.toml --set {curve} -o {name}"));
        let electrons = folder.electrons(name).mean;
        let plane = electrons.plane("Y").expect("a plane");
        plane.iter().map(|&value| f64::from(value)).sum::<f64>() / plane.len() as f64
    };
    let [beyond, green] = [mean("beyond", [900.0, 1000.0]), mean("green", [550.0, 570.0])];
    // Photons, QE·λ, of trapezoids; D65 is 104.046, 100 and 96.334 at 550, 560 and 570 nm.
    let photons = |first: f64, last: f64, light: &dyn Fn(f64) -> f64| -> f64 {
        let steps = 1000;
        let at = |i: i32| first + (last - first) * (f64::from(i) + 0.5) / f64::from(steps);
        let curve = |l: f64| (l - first).min(last - l).clamp(0.0, 1.0);
        (0..steps).map(|i| at(i) * curve(at(i)) * light(at(i))).sum::<f64>() * (last - first) / f64::from(steps)
    };
    let blackbody = |l: f64| l.powi(-5) / (1.438_777e7 / (l * 6504.0)).exp_m1();
    let infrared = photons(900.0, 1000.0, &|l| 60.3125 * blackbody(l) / blackbody(830.0));
    let visible = photons(550.0, 570.0, &|l| 100.0 - (l - 560.0) * if l < 560.0 { 0.4046 } else { 0.3666 });
    let ratio = beyond / green;
    // A path of 98304 has one wavelength; a trapezoid drawn with its own density and 5 % evenly has a relative variance
    // below 1.
    assert!(
        (ratio / (infrared / visible) - 1.0).abs() < 4.0 * 2.0_f64.sqrt() / 98304.0_f64.sqrt(),
        "{ratio} instead of {}",
        infrared / visible
    );
}

#[test]
fn spectra_that_end_before_the_sensor_does_are_named() {
    let folder = pane("sony-imx249-mono", "mono");
    let warnings = |arguments: &str| {
        folder.succeed(&format!("render capture.toml --set render.samples_per_pixel=1 --force -o out {arguments}"));
        folder.report("out")["warnings"].to_string()
    };
    let infrared = warnings("");
    assert!(infrared.contains("spectra of the scene are not known (environment;"), "{infrared}");
    for known in
        ["--set scene.environment.illuminant=A", "--set sensor.preset=generic-cmos-color --set sensor.cfa=RGGB"]
    {
        let warnings = warnings(known);
        assert!(!warnings.contains("not known"), "{known}: {warnings}");
    }
}

#[test]
fn light_for_the_own_filter_is_exposed_behind_others_with_a_warning() {
    let folder = pane("generic-cmos-color", "RGGB");
    let quick = "--set render.samples_per_pixel=1";
    folder.succeed(&format!("render capture.toml {quick} --set render.wavelengths=own-filter -o own"));
    folder.succeed(&format!("render capture.toml {quick} -o all"));
    for (input, cfa, warns) in [("own", "RGGB", false), ("own", "BGGR", true), ("all", "BGGR", false)] {
        let output = format!("{input}-{cfa}");
        folder.succeed(&format!("expose {input} --set sensor.cfa={cfa} -o {output}"));
        let warnings = folder.report(&output)["warnings"].to_string();
        assert_eq!(warnings.contains("was traced for its own filter"), warns, "{output}: {warnings}");
    }
}
