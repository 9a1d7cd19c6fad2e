//! Errors of wrong captures: one error that names the file, the key and its line, or the argument.

use rstest::rstest;

use photosite_core::Error;

use super::*;

/// Cases of faults, with the line of the capture file after the three of `room`, and what the message must contain.
#[rstest]
#[case::table("[lense]\nf_number = 2", 4, "lense: unknown key `lense`; did you mean `lens`?")]
#[case::key(
    "[lens]\nfocl_length_mm = 16",
    5,
    "lens.focl_length_mm: unknown key `focl_length_mm` in [lens]; did you mean `focal_length_mm`?"
)]
#[case::key_scene("[camera]\nposition = [0, 0, 1]", 5, "did you mean `position_m`?")]
#[case::key_sensor(
    "[sensor]\nresolution = [2, 2]",
    5,
    "unknown key `resolution` in [sensor]; did you mean `resolution_px`?"
)]
#[case::key_of_a_sensor_table("[sensor]\nbits = 10", 5, "unknown key `bits` in [sensor]; did you mean `adc.bits`?")]
#[case::key_sensor_deep(
    "[sensor]\n[sensor.noise]\nread_noise = 2",
    6,
    "unknown key `read_noise` in [sensor.noise]; did you mean `read_noise_e`?"
)]
#[case::key_exposure("[exposure]\ntime = 1", 5, "did you mean `time_s`?")]
#[case::key_render("[render]\nspp = 1\n", 5, "unknown key `spp` in [render]")]
#[case::key_output("[output]\nraws = []", 5, "did you mean `raw`?")]
#[case::layer_as_a_key("[output]\ndepth = true", 5, "did you mean `truth = [\"depth\"]`?")]
#[case::map_as_a_key("[output]\nraw_clean = true", 5, "did you mean `noise = [\"raw_clean\"]`?")]
#[case::key_material(
    "[materials.wall]\ntype = 'diffuse'\nreflectence = 1",
    6,
    "unknown key `reflectence` in [materials.wall]; did you mean `reflectance`?"
)]
#[case::key_emission(
    "[materials.wall]\nemission = { luminance = 1 }",
    5,
    "unknown key `luminance` in [materials.wall.emission]; did you mean `luminance_nit`?"
)]
#[case::key_light(
    "[[lights]]\ntype = 'point'\nposition_m = [0, 0, 0]\nintensity = 1",
    7,
    "unknown key `intensity` in [lights[0]]; did you mean `intensity_cd`?"
)]
#[case::key_distortion("[lens]\ndistortion = { model = 'none', q = 1 }", 5, "unknown key `q` in [lens.distortion]")]
#[case::wrong_type("[lens]\nf_number = 'wide'", 5, "lens.f_number: expected a number, found string \"wide\"")]
#[case::wrong_type_deep(
    "[camera]\nposition_m = [0, 'a', 0]",
    5,
    "camera.position_m[1]: expected a number, found string \"a\""
)]
#[case::wrong_length("[camera]\nposition_m = [0, 1]", 5, "camera.position_m: expected a list of 3 values, found 2")]
#[case::wrong_count("[render]\nsamples_per_pixel = -4", 5, "expected a whole number, not negative, found integer `-4`")]
#[case::wrong_variant("[render]\nsampler = 'sobel'", 5, "unknown value \"sobel\"; did you mean `sobol`?")]
#[case::wrong_choice("[lens]\nautofocus_px = 'center'", 5, "lens.autofocus_px: unknown place \"center\"")]
#[case::wrong_shape(
    "[lens]\nfocus_distance_m = [1]",
    5,
    "lens.focus_distance_m: expected a distance in metres, \"infinity\" or \"scene\""
)]
#[case::wrong_table("[[lens]]\nf_number = 2", 4, "lens: expected a table, found a list")]
#[case::wrong_lights("[lights]\ntype = 'point'", 4, "lights: expected a list of tables")]
#[case::wrong_sensor("sensor = 3", 4, "scene.sensor: unknown key")]
#[case::f_number("[lens]\nf_number = 0", 5, "lens.f_number: must be above 0, got 0")]
#[case::focus(
    "[lens]\nfocal_length_mm = 50\nfocus_distance_m = 0.04",
    6,
    "lens.focus_distance_m: 0.04 m does not lie beyond the focal length"
)]
#[case::two_foci(
    "[lens]\nautofocus_px = 'centre'\nfocus_distance_m = 1",
    5,
    "cannot be combined with focus_distance_m"
)]
#[case::two_foci_by_place(
    "[lens]\nfocus_distance_m = 1\nimage_distance_mm = 20",
    6,
    "cannot be combined with focus_distance_m"
)]
#[case::two_openings("[lens]\nf_number = 2\ndiameter_mm = 4", 6, "lens.diameter_mm: cannot be combined with f_number")]
#[case::two_focal_lengths(
    "[lens]\nfocal_length_mm = 20\nlensmaker = { radii_mm = [50, -50], glass = 'BK7' }",
    5,
    "lens.focal_length_mm: cannot be combined with lensmaker"
)]
#[case::glass(
    "[lens]\nlensmaker = { radii_mm = [50, -50], glass = 'BK8' }",
    5,
    "lens.lensmaker.glass: photosite has no glass \"BK8\"; did you mean `bk7`?"
)]
#[case::radius("[lens]\nlensmaker = { radii_mm = [50, 'plane'], index = 1.5 }", 5, "unknown radius \"plane\"")]
#[case::no_power("[lens]\nlensmaker = { radii_mm = ['flat', 'flat'], index = 1.5 }", 5, "bend no light")]
#[case::no_element("[[lens.supplementary]]\ndistance_mm = 5", 4, "the key `power_dpt` is missing")]
#[case::two_elements(
    "[[lens.supplementary]]\npower_dpt = 2\nradii_mm = [50, -50]\nindex = 1.5",
    6,
    "lens.supplementary[0].radii_mm: cannot be combined with power_dpt"
)]
#[case::glass_of_no_surface(
    "[[lens.supplementary]]\npower_dpt = 2\nglass = 'BK7'",
    6,
    "lens.supplementary[0].glass: only applies with radii_mm"
)]
#[case::element_of_a_hole(
    "[lens]\ntype = 'hole'\nsupplementary = [{ power_dpt = 2 }]",
    6,
    "lens.supplementary: belongs to a thin lens, and this one is \"hole\""
)]
#[case::hole_that_distorts(
    "[lens]\ntype = 'hole'\ndistortion = { model = 'division', k = [-0.1] }",
    6,
    "lens.distortion: a hole has none"
)]
#[case::truth_of_a_bare_sensor(
    "[lens]\ntype = 'none'\n[output]\ntruth = ['depth']",
    7,
    "output.truth: cannot be combined with lens.type = \"none\""
)]
#[case::diverging(
    "[lens]\nfocal_length_mm = -50\nfocus_distance_m = 1",
    6,
    "lens.focus_distance_m: a lens of -50 mm makes light diverge"
)]
#[case::too_near(
    "[lens]\nmin_focus_distance_m = 0.4\nfocus_distance_m = 0.3",
    6,
    "0.3 m is nearer than the lens can be focused on, 0.4 m"
)]
#[case::contrast("[lens]\nautofocus = { steps = 20 }", 5, "lens.autofocus.steps: belongs to the search for contrast")]
#[case::contrast_steps(
    "[lens]\nautofocus = { method = 'contrast', steps = 2 }",
    5,
    "lens.autofocus.steps: must lie between 5 and 200, got 2"
)]
#[case::off_sensor("[lens]\nautofocus_px = [900, 10]", 5, "is not on the sensor of 800 × 600 pixels")]
#[case::blades("[lens]\nblades = 2", 5, "lens.blades: 2 blades do not enclose an opening")]
#[case::transmittance(
    "[lens]\ntransmittance = 1.5",
    5,
    "lens.transmittance: must lie between 0 and 1, but is 1.5 at 300 nm"
)]
#[case::material_type(
    "[materials.wall]\ntype = 'difuse'",
    5,
    "materials.wall.type: unknown value \"difuse\"; did you mean `diffuse`?"
)]
#[case::material_name(
    "[materials.wal]\ntype = 'diffuse'\nreflectance = 1",
    4,
    "materials.wal: the geometry has no material \"wal\"; did you mean `wall`?"
)]
#[case::sphere_material(
    "[[scene.spheres]]\nmaterial = 'wal'\nposition_m = [0, 0, 0]\nradius_m = 1",
    5,
    "scene.spheres[0].material: there is no material \"wal\"; did you mean `wall`?"
)]
#[case::sphere_material_type(
    "[[scene.spheres]]\nmaterial = 'ball'\nposition_m = [0, 0, 0]\nradius_m = 1\n[materials.ball]\ndouble_sided = true",
    8,
    "materials.ball: the key `type` is missing"
)]
#[case::sphere_radius(
    "[[scene.spheres]]\nmaterial = 'wall'\nposition_m = [0, 0, 0]\nradius_m = 0",
    7,
    "scene.spheres[0].radius_m: must be at least 1e-15, got 0"
)]
#[case::sphere_far(
    "[[scene.spheres]]\nmaterial = 'wall'\nposition_m = [0, 1e19, 0]\nradius_m = 1",
    6,
    "scene.spheres[0].position_m: lies farther out than"
)]
#[case::sphere_key(
    "[[scene.spheres]]\nmaterial = 'wall'\nposition_m = [0, 0, 0]\nradius = 1",
    7,
    "unknown key `radius`"
)]
#[case::disk_normal(
    "[[scene.disks]]\nmaterial = 'wall'\nposition_m = [0, 0, 0]\nnormal = [0, 0, 0]\nradius_m = 1",
    7,
    "scene.disks[0].normal: must be a direction (not zero), got [0.0, 0.0, 0.0]"
)]
#[case::cylinder_length(
    "[[scene.cylinders]]\nmaterial = 'wall'\nposition_m = [0, 0, 0]\naxis = [0, 1, 0]\nradius_m = 1\nlength_m = -1",
    9,
    "scene.cylinders[0].length_m: must be at least 1e-15, got -1"
)]
#[case::material_missing("[materials.wall]\ntype = 'diffuse'", 4, "materials.wall: the key `reflectance` is missing")]
#[case::reflectance(
    "[materials.wall]\ntype = 'diffuse'\nreflectance = 1.5",
    6,
    "materials.wall.reflectance: must lie between 0 and 1"
)]
#[case::reflectance_name(
    "[materials.wall]\ntype = 'diffuse'\nreflectance = 'cornel/white'",
    6,
    "did you mean `cornell/white`?"
)]
#[case::reflectance_shape(
    "[materials.wall]\ntype = 'diffuse'\nreflectance = { fiel = 'a' }",
    6,
    "expected a number from 0 to 1, three of them"
)]
#[case::spectrum_file("[materials.wall]\ntype = 'diffuse'\nreflectance = { file = 'gone.csv' }", 6, "gone.csv")]
#[case::metal(
    "[materials.wall]\ntype = 'conductor'\nmetal = 'unobtainium'",
    6,
    "materials.wall.metal: photosite has no metal"
)]
#[case::glass("[materials.wall]\ntype = 'dielectric'\nglass = 'BK8'", 6, "did you mean `bk7`?")]
#[case::too_much("[materials.wall]\ntype = 'translucent'\nreflectance = 0.6\ntransmittance = 0.5", 7, "together 1.1")]
#[case::sheeting(
    "[materials.wall]\ntype = 'retroreflective'\nretroreflectance = 0.4\nreflectance = 0.5\nindex = 0.9",
    8,
    "between 1 and 4, got 0.9"
)]
#[case::exponent(
    "[materials.wall]\ntype = 'phong'\ndiffuse = 0\nspecular = 0\nexponent = -1",
    8,
    "between 0 and 100000"
)]
#[case::mix(
    "[materials.wall]\ntype = 'mix'\nweight = 0.5\nfirst = { type = 'diffuse', reflectance = 0.5 }",
    4,
    "the key `second` is missing"
)]
#[case::mix_type("[materials.wall]\ntype = 'mix'\nweight = 0.5\nfirst = 3\nsecond = 4", 7, "expected a table")]
#[case::no_index("[materials.wall]\ntype = 'dielectric'", 4, "needs a glass or an index")]
#[case::resonance(
    "[materials.wall]\ntype = 'dielectric'\nindex = { sellmeier_b = [1], sellmeier_c_um2 = [0.25] }",
    6,
    "resonance at 500 nm"
)]
#[case::texture("[materials.wall]\ntype = 'diffuse'\nreflectance = { texture = 'gone.png' }", 6, "gone.png")]
#[case::no_level("[materials.wall]\nemission = { illuminant = 'A' }", 5, "says only the colour of the light")]
#[case::two_colours(
    "[materials.wall]\nemission = { illuminant = 'A', rgb = [1, 1, 1], luminance_nit = 1 }",
    5,
    "rgb: cannot be combined with illuminant"
)]
#[case::illuminant(
    "[materials.wall]\nemission = { illuminant = 'D6S', luminance_nit = 1 }",
    5,
    "there is no illuminant \"D6S\"; did you mean `D65`?"
)]
#[case::light_type("[[lights]]\ntype = 'pont'", 5, "lights[0].type: unknown value \"pont\"; did you mean `point`?")]
#[case::no_light_type("[[lights]]\nintensity_cd = 1", 4, "the key `type` is missing")]
#[case::light_direction(
    "[[lights]]\ntype = 'directional'\ndirection = [0, 0, 0]\nilluminance_lux = 1",
    6,
    "lights[0].direction: gives no direction"
)]
#[case::spot_angles(
    "[[lights]]\ntype = 'spot'\nposition_m = [0, 0, 0]\ndirection = [0, 0, 1]\nintensity_cd = 1\nouter_angle_deg = 95",
    9,
    "do not rise from 0 to 90"
)]
#[case::gltf_camera("[camera]\ngltf_camera = 'main'", 5, "the geometry has no camera \"main\"")]
#[case::look_at("[camera]\nposition_m = [0, 0, 1]\nlook_at_m = [0, 0, 1]", 6, "looks nowhere")]
#[case::up("[camera]\nposition_m = [0, 1, 0]\nlook_at_m = [0, 0, 0]", 4, "cannot be up in the image")]
#[case::half_camera("[camera]\nposition_m = [0, 1, 0]", 4, "the key `look_at_m` is missing")]
#[case::preset(
    "[sensor]\npreset = 'generic-cmos-colour'",
    5,
    "sensor.preset: photosite has no sensor \"generic-cmos-colour\"; did you mean `generic-cmos-color`?"
)]
#[case::sensor_file("[sensor]\npreset = 'gone.toml'", 5, "gone.toml")]
#[case::sensor_value("[sensor]\nadc = { bits = 40 }", 5, "sensor.adc.bits: must lie between 1 and 16, got 40")]
#[case::sensor_channel(
    "[sensor]\npreset = 'generic-cmos-color'\ncfa = 'mono'",
    5,
    "sensor.channels.B: the colour filter array \"mono\" has no channel \"B\""
)]
#[case::quantum_efficiency(
    "[sensor]\n[sensor.channels.R]\nquantum_efficiency = 1.2",
    6,
    "sensor.channels.R.quantum_efficiency: must lie between 0 and 1, but is 1.2"
)]
#[case::time("[exposure]\ntime_s = -1", 5, "exposure.time_s: must be above 0, got -1")]
#[case::auto_and_time("[exposure]\ntime_s = 1\nauto = true", 6, "exposure.auto: cannot be combined with time_s")]
#[case::gain("[exposure]\ngain_db = 90", 5, "exposure.gain_db: 90 dB is not among the gains")]
#[case::frames("[exposure]\nframes = 0", 5, "exposure.frames: must be at least 1")]
#[case::samples("[render]\nsamples_per_pixel = 0", 5, "render.samples_per_pixel: must be at least 1")]
#[case::time_limit("[render]\ntime_limit_s = -3", 5, "render.time_limit_s: must be above 0")]
#[case::bands(
    "[output]\nirradiance = { bands_nm = [400, 700, 33] }",
    5,
    "output.irradiance.bands_nm: bands of 33 nm do not fill 400 to 700 nm"
)]
#[case::raw_format("[output]\nraw = ['dng', 'tif']", 5, "output.raw[1]: unknown value \"tif\"; did you mean `tiff`?")]
#[case::syntax("[lens\nf_number = 2", 4, "is not valid TOML")]
#[case::twice("[lens]\nblades = 0\nblades = 5", 6, "is not valid TOML")]
fn errors_name_file_key_and_line(#[case] more: &str, #[case] line: usize, #[case] message: &str) {
    let error = Files::new(&room(more)).read(&[]).expect_err(more).to_string();
    assert!(error.contains(&format!("capture.toml:{line}: ")), "{error}");
    assert!(error.contains(message), "{error}");
}

/// Cases of faults in the `[scene]` table itself, with the line and the message.
#[rstest]
#[case::geometry("[scene]\ngeometry = ['room.obj', 'gone.obj']", 2, "scene.geometry[1]: there is no file")]
#[case::kind("[scene]\ngeometry = ['capture.toml']", 2, "is not a scene of a known kind")]
#[case::unit("[scene]\ngeometry = ['room.obj']\nmeters_per_unit = 0", 3, "scene.meters_per_unit: must be above 0")]
#[case::environment(
    "[scene]\ngeometry = ['room.obj']\nenvironment = { illuminence_lux = 5 }",
    3,
    "unknown key `illuminence_lux` in [scene.environment]; did you mean `illuminance_lux`?"
)]
#[case::environment_name(
    "[scene]\ngeometry = ['room.obj']\nenvironment = 'sky'",
    3,
    "scene.environment: unknown environment \"sky\""
)]
#[case::environment_level(
    "[scene]\ngeometry = ['room.obj']\nenvironment = { illuminant = 'D65' }",
    3,
    "says only the colour"
)]
#[case::environment_type(
    "[scene]\ngeometry = ['room.obj']\nenvironment = 4",
    3,
    "expected \"none\", \"even\" or a table"
)]
#[case::image(
    "[scene]\ngeometry = ['room.obj']\nenvironment = { image = 'gone.hdr', illuminance_lux = 1 }",
    3,
    "gone.hdr"
)]
#[case::image_level(
    "[scene]\ngeometry = ['room.obj']\nenvironment = { image = 'gone.hdr' }",
    3,
    "does not say how bright"
)]
#[case::no_scene("[scene]\n[camera]", 2, "camera: there is none, and no geometry to look at")]
fn errors_of_the_scene_name_file_key_and_line(#[case] text: &str, #[case] line: usize, #[case] message: &str) {
    let error = Files::new(text).read(&[]).expect_err(text).to_string();
    assert!(error.contains(&format!("capture.toml:{line}: ")) && error.contains(message), "{error}");
}

#[rstest]
#[case("lens.f_number=0", "override lens.f_number=0: lens.f_number: must be above 0")]
#[case(
    "lens.fnumber=4",
    "override lens.fnumber=4: lens.fnumber: unknown key `fnumber` in [lens]; did you mean `f_number`?"
)]
#[case("lens.f_number=wide", "override lens.f_number=wide: lens.f_number: expected a number, found string \"wide\"")]
#[case("lns.f_number=4", "override lns.f_number=4: lns: unknown key `lns`; did you mean `lens`?")]
#[case("lens.f_number", "override lens.f_number: there is no value")]
#[case("=4", "override =4: \"\" is not a key")]
#[case("lens.f_number=[4", "is neither a TOML value nor a word")]
#[case("a\nb=4", "is not a key")]
#[case("sensor.preset=nikon", "override sensor.preset=nikon: sensor.preset: photosite has no sensor \"nikon\"")]
fn errors_of_arguments_name_the_argument(#[case] argument: &str, #[case] message: &str) {
    let error = Files::new(&room("[lens]\nf_number = 2")).read(&[argument]).expect_err(argument).to_string();
    assert!(error.contains(message), "{error}");
}

#[test]
fn errors_in_a_sensor_file_name_that_file() {
    let files = Files::new(&room("[sensor]\npreset = 'mine.toml'"));
    let text = include_str!("../../../photosite-sensor/assets/sensors/sony-imx249-mono.toml");
    let text = text.replace(
        "{ file = \"../../../photosite-core/assets/spectra/quantum-efficiency/sony-imx249-mono.csv\" }",
        "0.5",
    );
    let lines = text.lines().take_while(|line| !line.starts_with("full_well_e =")).count();
    for (from, to) in [("full_well_e =", "full_wel_e ="), ("full_well_e = ", "full_well_e = -")] {
        files.add("mine.toml", text.replace(from, to).as_bytes());
        let error = files.read(&[]).expect_err(to).to_string();
        assert!(error.contains(&format!("mine.toml:{}: sensor.charge.full_wel", lines + 1)), "{error}");
    }
}

#[test]
fn later_errors_find_their_line_through_the_source() {
    let capture = capture(&room("[lens]\nautofocus_px = [10, 20]"));
    let error = capture.source.error(Invalid::new("autofocus_px", "sees nothing").within("lens"));
    assert!(error.to_string().contains("capture.toml:5: lens.autofocus_px: sees nothing"), "{error}");
    let Error::Input(input) = error else { panic!("{error}") };
    let span = input.span.expect("a place");
    assert_eq!(&capture.source.text()[span.offset()..span.offset() + span.len()], "[10, 20]");
    // What is not written is placed at the table it belongs to; what belongs to none, at the file.
    let error = capture.source.error(Invalid::new("lens.f_number", "is odd")).to_string();
    assert!(error.contains("capture.toml:4: lens.f_number"), "{error}");
    let error = capture.source.error(Invalid::new("render.seed", "is odd")).to_string();
    assert!(error.contains("capture.toml: render.seed"), "{error}");
}

#[test]
fn neither_text_nor_binary_panics() {
    let files = Files::new("");
    for (bytes, expected) in [
        (&[0xff, 0xfd, 0x00][..], "is neither TOML nor a scene"),
        (b"a = 1\nb = \xff", "line 2 is not valid UTF-8 text"),
        (&[0xff, 0xfe, 0x00], "begins as UTF-16, but is not valid UTF-16"),
        (&[0xff, 0xfe, 0x00, 0x00], "is text in UTF-32"),
    ] {
        files.add("capture.toml", bytes);
        let error = files.read(&[]).expect_err("binary").to_string();
        assert!(error.contains(expected), "{error}");
    }
    assert!(
        Capture::load_with(Path::new("/nowhere/capture.toml"), &[])
            .expect_err("absent")
            .to_string()
            .contains("cannot read")
    );
    let text = room(
        "[materials.wall]\ntype = 'diffuse'\nreflectance = { linear_rgb = [1, 2, 3] }\n[sensor]\nadc.bits = 99\n[[lights]]\n",
    );
    let files = Files::new("");
    for len in (0..text.len()).filter(|len| text.is_char_boundary(*len)) {
        files.add("capture.toml", &text.as_bytes()[..len]);
        let _ = files.read(&[]);
    }
    files.add("capture.toml", "a=".as_bytes().iter().chain(&[b'['; 100_000]).copied().collect::<Vec<_>>().as_slice());
    assert!(files.read(&[]).is_err(), "nested too deeply");
}
