//! Captures with one thing each that Mitsuba has no counterpart for, or does otherwise.

use std::path::Path;

/// A capture of one surface with all else as Mitsuba has it, changed.
pub(super) struct Case {
    /// The kind of difference; empty where the export is refused whatever is allowed.
    pub(super) kind: &'static str,
    /// Words that the message names.
    pub(super) names: &'static str,
    /// The geometry: `triangle.obj`, or a file of `tests/gltf`.
    pub(super) file: &'static str,
    /// Pieces of text in the capture or in the geometry, and what they become.
    pub(super) changes: &'static [(&'static str, &'static str)],
}

const CAPTURE: &str = r#"[scene]
geometry = ["FILE"]
environment = { illuminant = "D65", illuminance_lux = 500 }
[materials.paint]
type = "diffuse"
reflectance = 0.5
[camera]
position_m = [0, 0, 3]
look_at_m = [0, 0, 0]
[lens]
focus_distance_m = 3
falloff = "none"
[sensor]
resolution_px = [16, 12]
[exposure]
time_s = 0.01
"#;

const TRIANGLE: &str = "mtllib paint.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1 2 3\n";
const MTL: &str = "newmtl paint\nKd 0.5 0.5 0.5\n";
/// Files that captures may name.
const OTHERS: [(&str, &str); 4] = [
    ("lamp.ies", "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 1\n0 90\n0\n100 0\n"),
    (
        "scan.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n",
    ),
    ("hole.obj", "mtllib hole.mtl\nusemtl hole\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n"),
    ("hole.mtl", "newmtl hole\nd 0.5\n"),
];
const IMAGES: [&str; 5] = [
    "mitsuba/geometry/colours.png",
    "mitsuba/geometry/bumps.png",
    "mitsuba/geometry/venice.hdr",
    "gltf/shapes.bin",
    "gltf/pixels.png",
];

/// The material of the capture.
const PAINT: &str = "type = \"diffuse\"\nreflectance = 0.5";
/// Leaves the material to the geometry.
const UNPAINTED: (&str, &str) = ("[materials.paint]\ntype = \"diffuse\"\nreflectance = 0.5\n", "");
const FOCUS: &str = "focus_distance_m = 3\nfalloff = \"none\"";
const SURROUNDINGS: &str = "{ illuminant = \"D65\", illuminance_lux = 500 }";
const INFRARED: (&str, &str) = ("resolution_px = [16, 12]", "preset = \"andor-zyla-55\"\nscaled_to_px = [16, 12]");
const WITH_UVS: (&str, &str) = ("f 1 2 3", "f 1/1 2/2 3/3");
const POINT_LIGHT: (&str, &str) =
    ("[camera]", "[[lights]]\ntype = \"point\"\nposition_m = [0, 1, 1]\nintensity_cd = 100\n[camera]");

type Changes = &'static [(&'static str, &'static str)];

const fn case(kind: &'static str, names: &'static str, changes: Changes) -> Case {
    Case { kind, names, file: "triangle.obj", changes }
}

const fn gltf(kind: &'static str, names: &'static str, file: &'static str, changes: Changes) -> Case {
    Case { kind, names, file, changes }
}

pub(super) const CASES: &[Case] = &[
    case("AutomaticExposure", "one second", &[("time_s = 0.01", "auto = true")]),
    case("Motion", "camera", &[("[lens]", "[camera.motion]\nvelocity_m_per_s = [1, 0, 0]\n[lens]")]),
    case("Falloff", "[lens]", &[("falloff = \"none\"", "falloff = \"cos4\"")]),
    case("CurvedProjection", "the fisheye projection", &[("[lens]", "[lens]\nprojection = \"fisheye\"")]),
    case("CurvedProjection", "the equisolid projection", &[("[lens]", "[lens]\nprojection = \"equisolid\"")]),
    case(
        "CurvedProjection",
        "the equirectangular projection",
        &[("[lens]", "[lens]\nprojection = \"equirectangular\"")],
    ),
    case("CurvedProjection", "omnidirectional", &[("[lens]", "[lens]\nprojection = \"omnidirectional\"\nxi = 1.0")]),
    case("Distortion", "[lens]", &[("[lens]", "[lens]\ndistortion = { model = \"brown-conrady\", k = [0.1] }")]),
    case("Distortion", "[lens]", &[("[lens]", "[lens]\ndistortion = { model = \"division\", k = [0.1] }")]),
    case("Distortion", "[lens]", &[("[lens]", "[lens]\ndistortion = { model = \"polynomial\", k = [0.1, 0.0] }")]),
    case("PointSpread", "psf", &[("[lens]", "[lens]\npsf = { kind = \"gaussian\", sigma_um = 1.0 }")]),
    case(
        "LateralColour",
        "[lens]",
        &[("[lens]", "[lens]\nlateral_colour = { wavelength_nm = [450, 650], magnification = [0.9995, 1.0005] }")],
    ),
    case("Stops", "[lens]", &[("[lens]", "[lens]\nstops = [{ distance_mm = 10, radius_mm = 5.0 }]")]),
    case("MaxAngle", "[lens]", &[("[lens]", "[lens]\nmax_angle_deg = 40")]),
    case(
        "Sensor",
        "hexagonal cells of [sensor]",
        &[("[sensor]", "[sensor]\ncells = \"hexagonal\"\npixel_pitch_um = [4, 3.464]")],
    ),
    case("Sensor", "image_circle_mm of [sensor]", &[("[sensor]", "[sensor]\nimage_circle_mm = 0.04")]),
    case("PixelsNotSquare", "not square", &[("[sensor]", "[sensor]\npixel_pitch_um = [4, 5]")]),
    case("PrincipalPoint", "", &[("[lens]", "[lens]\nintrinsics = { fx = 1000, fy = 1000, cx = 9, cy = 6 }")]),
    case("Hole", "[lens]", &[("focus_distance_m = 3", "type = \"hole\"\ndiameter_mm = 0.3\nimage_distance_mm = 16")]),
    case(
        "Glass",
        "[lens]",
        &[("[lens]", "[lens]\nlensmaker = { radii_mm = [50, -50], thickness_mm = 4, index = 1.5, abbe_number = 60 }")],
    ),
    case(
        "Glass",
        "[lens]",
        &[("focus_distance_m = 3", "focus_distance_m = 0.4\nsupplementary = [{ distance_mm = 10, power_dpt = 2 }]")],
    ),
    case("Blades", "", &[("[lens]", "[lens]\nblades = 6")]),
    case("NothingInFocus", "", &[("focus_distance_m = 3", "image_distance_mm = 12")]),
    case(
        "SoftEdge",
        "light \"lamp\"",
        &[(
            "[camera]",
            "[[lights]]\nname = \"lamp\"\ntype = \"spot\"\nposition_m = [0, 1, 1]\nlook_at_m = [0, 0, 0]\n\
             intensity_cd = 100\nouter_angle_deg = 30\n[camera]",
        )],
    ),
    case(
        "KindOfLight",
        "light \"lamp\" of the type gaussian-beam",
        &[(
            "[camera]",
            "[[lights]]\nname = \"lamp\"\ntype = \"gaussian-beam\"\nposition_m = [0, 1, 1]\n\
             direction = [0, 0, -1]\nwaist_radius_mm = [1, 1]\nflux_lm = 1\n[camera]",
        )],
    ),
    case(
        "KindOfLight",
        "of the type profile",
        &[("[camera]", "[[lights]]\ntype = \"profile\"\nfile = \"lamp.ies\"\nposition_m = [0, 1, 1]\n[camera]")],
    ),
    case(
        "KindOfLight",
        "of the type projector",
        &[(
            "[camera]",
            "[[lights]]\ntype = \"projector\"\nimage = \"colours.png\"\nposition_m = [0, 0, 3]\n\
             look_at_m = [0, 0, 0]\nhorizontal_fov_deg = 40\nflux_lm = 100\n[camera]",
        )],
    ),
    case("SkyBeyondItsTables", "", &[(SURROUNDINGS, "{ sky = { sun_elevation_deg = 35 } }"), INFRARED]),
    case("ImageBeyondCie", "", &[(SURROUNDINGS, "{ image = \"venice.hdr\", nit_per_unit = 100 }"), INFRARED]),
    case("ImageColours", "", &[(SURROUNDINGS, "{ image = \"venice.hdr\", nit_per_unit = 100 }")]),
    case(
        "QuadricUvs",
        "sphere \"ball\"",
        &[
            (
                SURROUNDINGS,
                "{ illuminant = \"D65\", illuminance_lux = 500 }\n\
                 spheres = [{ name = \"ball\", material = \"paint\", position_m = [0, 0, 0], radius_m = 0.1 }]",
            ),
            (PAINT, "type = \"conductor\"\nmetal = \"Au\"\nroughness = 0.4\nanisotropy = 0.5"),
            WITH_UVS,
        ],
    ),
    gltf("CornerColours", "mesh", "vertex-colours.gltf", &[UNPAINTED]),
    case(
        "GroovesWithoutUvs",
        "material \"paint\"",
        &[(PAINT, "type = \"conductor\"\nmetal = \"Au\"\nroughness = 0.4\nanisotropy = 0.5")],
    ),
    gltf("CoarseNormals", "mesh \"ball\"", "plain.gltf", &[UNPAINTED]),
    gltf("EmissionTexture", "material \"ball\"", "two-uv-sets.gltf", &[UNPAINTED]),
    case("HolesOfEmitter", "material \"paint\"", &[UNPAINTED, ("Kd 0.5 0.5 0.5", "Kd 0.5 0.5 0.5\nKe 1 1 1\nd 0.5")]),
    case(
        "EmitterOfTwoSides",
        "material \"paint\"",
        &[(PAINT, "type = \"diffuse\"\nreflectance = 0.5\nemission = { illuminant = \"D65\", luminance_nit = 10 }")],
    ),
    gltf("SmoothEmitter", "material \"ball\"", "emissive-strength.gltf", &[UNPAINTED]),
    gltf("UvsOfTheirOwn", "material \"ball\"", "two-uv-sets.gltf", &[UNPAINTED]),
    case(
        "NormalsFromBehind",
        "material \"paint\"",
        &[(PAINT, "type = \"diffuse\"\nreflectance = 0.5\nnormal_map = { texture = \"bumps.png\" }"), WITH_UVS],
    ),
    case(
        "PolishedHalf",
        "material \"paint\"",
        &[(
            PAINT,
            "type = \"mix\"\nweight = 0.5\nfirst = { type = \"diffuse\", reflectance = 0.5 }\n\
             second = { type = \"conductor\", metal = \"Au\" }",
        )],
    ),
    case(
        "PolishedHalf",
        "material \"paint\"",
        &[(
            PAINT,
            "type = \"mix\"\nweight = 0.5\nfirst = { type = \"diffuse\", reflectance = 0.5 }\n\
             second = { type = \"mix\", weight = 0.5, first = { type = \"dielectric\", index = 1.5 }, \
             second = { type = \"diffuse\", reflectance = 0.5 } }",
        )],
    ),
    case("ShadowOfPane", "material \"paint\"", &[(PAINT, "type = \"thin-dielectric\"\nindex = 1.5"), POINT_LIGHT]),
    gltf(
        "ShadowOfPane",
        "material \"ball\"",
        "transmission.gltf",
        &[UNPAINTED, ("\"roughnessFactor\": 0.2", "\"roughnessFactor\": 0.0"), POINT_LIGHT],
    ),
    case(
        "PaneAmongHoles",
        "material \"paint\"",
        &[
            (SURROUNDINGS, "{ illuminant = \"D65\", illuminance_lux = 500 }\nobjects = [{ file = \"hole.obj\" }]"),
            (PAINT, "type = \"thin-dielectric\"\nindex = 1.5"),
        ],
    ),
    case("Shadowing", "material \"paint\"", &[(PAINT, "type = \"conductor\"\nmetal = \"Au\"\nroughness = 0.4")]),
    case("Shadowing", "material \"paint\"", &[(PAINT, "type = \"dielectric\"\nindex = 1.5\nroughness = 0.4")]),
    case(
        "FurtherBounces",
        "material \"paint\"",
        &[(PAINT, "type = \"conductor\"\nmetal = \"Au\"\nroughness = 0.4\nenergy_compensation = true")],
    ),
    case(
        "FurtherBounces",
        "material \"paint\"",
        &[(PAINT, "type = \"dielectric\"\nindex = 1.5\nroughness = 0.4\nenergy_compensation = true")],
    ),
    case("Dispersion", "material \"paint\"", &[(PAINT, "type = \"dielectric\"\nglass = \"BK7\"")]),
    case("Dispersion", "material \"paint\"", &[(PAINT, "type = \"thin-dielectric\"\nglass = \"BK7\"")]),
    case("Dispersion", "material \"paint\"", &[(PAINT, "type = \"plastic\"\nglass = \"BK7\"\nreflectance = 0.5")]),
    case("Relief", "material \"paint\"", &[(PAINT, "type = \"oren-nayar\"\nreflectance = 0.5\nroughness = 0.5")]),
    case(
        "PhongLobe",
        "material \"paint\"",
        &[(PAINT, "type = \"phong\"\ndiffuse = 0.5\nspecular = 0.1\nexponent = 50")],
    ),
    case(
        "Translucence",
        "material \"paint\"",
        &[(PAINT, "type = \"translucent\"\nreflectance = 0.5\ntransmittance = 0.2")],
    ),
    case(
        "Absorption",
        "material \"paint\"",
        &[(PAINT, "type = \"thin-dielectric\"\nindex = 1.5\ntransmittance = 0.5")],
    ),
    case(
        "Retroreflection",
        "material \"paint\"",
        &[(PAINT, "type = \"retroreflective\"\nretroreflectance = 0.4\nreflectance = 0.5")],
    ),
    case("Model", "the \"plastic\" model of material \"paint\"", &[(PAINT, "type = \"plastic\"\nreflectance = 0.5")]),
    case(
        "Model",
        "the \"metallic-roughness\" model of material \"paint\"",
        &[(PAINT, "type = \"metallic-roughness\"\nbase_colour = 0.5\nroughness = 0.5")],
    ),
    case(
        "Model",
        "material \"paint\"",
        &[
            (
                PAINT,
                "type = \"metallic-roughness\"\nbase_colour = 0.5\nroughness = 0.5\n\
                 metallic_roughness_map = { texture = \"colours.png\" }",
            ),
            WITH_UVS,
        ],
    ),
    gltf("Model", "the \"glTF\" model of material \"ball\"", "plain.gltf", &[UNPAINTED]),
    case(
        "Model",
        "the \"MTL\" model of material \"paint\"",
        &[UNPAINTED, ("Kd 0.5 0.5 0.5", "Kd 0.5 0.5 0.5\nPr 0.3")],
    ),
    case("Model", "the \"PLY\" model of", &[UNPAINTED, ("triangle.obj", "scan.ply")]),
    gltf("Extension", "the specular factor of material \"ball\"", "specular.gltf", &[UNPAINTED]),
    gltf("MaskBetweenTexels", "material \"ball\"", "alpha-mask.gltf", &[UNPAINTED, ("9728", "9729")]),
    case(
        "TextureBeyondCie",
        "material \"paint\"",
        &[
            (PAINT, "type = \"diffuse\"\nreflectance = { texture = \"colours.png\", filter = \"nearest\" }"),
            WITH_UVS,
            INFRARED,
        ],
    ),
    case(
        "ColoursBetweenTexels",
        "material \"paint\"",
        &[(PAINT, "type = \"diffuse\"\nreflectance = { texture = \"colours.png\" }"), WITH_UVS],
    ),
    gltf("WrapModes", "u and v", "texture.gltf", &[UNPAINTED, ("\"magFilter\"", "\"wrapS\": 33071, \"magFilter\"")]),
    case("", "rays go through the glass of a lens", &[(FOCUS, "prescription = \"double-gauss\"")]),
    case("", "no camera without a lens", &[(FOCUS, "type = \"none\"")]),
];

impl Case {
    /// Writes the capture into a folder with all that captures here may name.
    pub(super) fn write(&self, folder: &Path) {
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
        for name in IMAGES {
            let from = here.join(name);
            std::fs::copy(&from, folder.join(from.file_name().expect("a file"))).expect("copied");
        }
        let geometry = match self.file {
            "triangle.obj" => TRIANGLE.to_owned(),
            file => std::fs::read_to_string(here.join("gltf").join(file)).expect("a glTF file"),
        };
        let mut texts = [
            ("capture.toml", CAPTURE.replace("FILE", self.file)),
            (self.file, geometry),
            ("paint.mtl", MTL.to_owned()),
        ];
        for (from, to) in self.changes {
            assert!(texts.iter().any(|(_, text)| text.contains(from)), "{}: {from}", self.kind);
            texts.iter_mut().for_each(|(_, text)| *text = text.replace(from, to));
        }
        for (name, text) in texts.iter().map(|(name, text)| (*name, text.as_str())).chain(OTHERS) {
            std::fs::write(folder.join(name), text).expect("written");
        }
    }
}
