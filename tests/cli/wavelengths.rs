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
            // Of single wavelengths some third is seen by each of three filters, of its own nine tenths: relative variances of
            // 1/p − 1 are 2 and 0.1, and more where a filter is broad.
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
