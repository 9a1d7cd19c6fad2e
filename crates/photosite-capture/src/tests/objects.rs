//! Tests of `[[scene.objects]]`.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec3;
use rstest::rstest;

use super::*;

/// A single triangle with a corner at [1, 2, 3].
const CORNER: &str = "v 1 2 3\nv 0 0 0\nv 0 1 0\nusemtl paint\nf 1 2 3\n";

fn objects(tables: &str) -> Files {
    objects_of(&format!("[scene]\nenvironment = {{ illuminant = 'D65', luminance_nit = 9 }}\n{tables}"))
}

fn objects_of(capture: &str) -> Files {
    let files = Files::new(capture);
    files.add("corner.obj", CORNER.as_bytes());
    files
}

/// A facet with a corner at [1, 2, 3].
const FACET: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 1 2 3\nvertex 0 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                     endsolid\n";

/// Case: of z up, x stays, and z and −y become y and z.
#[rstest]
#[case("geometry = ['a.stl']", [1.0, 3.0, -2.0], 1)]
#[case("geometry = ['a.stl', 'a.stl']", [1.0, 3.0, -2.0], 1)]
#[case("geometry = ['a.stl']\nup = 'z'", [1.0, 3.0, -2.0], 0)]
#[case("geometry = ['a.stl']\nup = 'y'", [1.0, 2.0, 3.0], 0)]
#[case("geometry = ['a.stl']\nmeters_per_unit = 0.5", [0.5, 1.5, -1.0], 1)]
#[case("geometry = ['corner.obj']", [1.0, 2.0, 3.0], 0)]
#[case("geometry = ['corner.obj']\nup = 'z'", [1.0, 3.0, -2.0], 0)]
#[case("objects = [{ file = 'a.stl' }, { file = 'a.stl', name = 'b' }]", [1.0, 3.0, -2.0], 1)]
#[case("objects = [{ file = 'a.stl', up = 'y' }]", [1.0, 2.0, 3.0], 0)]
fn what_programs_for_design_write_stands_upright(#[case] keys: &str, #[case] expected: [f64; 3], #[case] said: usize) {
    let files = objects_of(&format!("[scene]\nenvironment = {{ illuminant = 'D65', luminance_nit = 9 }}\n{keys}\n"));
    files.add("a.stl", FACET.as_bytes());
    let capture = files.read(&[]).unwrap_or_else(|error| panic!("{error}"));
    let scene = &capture.scene;
    for instance in &scene.instances {
        let found = instance.to_world.transform_point3(scene.meshes[instance.meshes.start].positions[0].as_dvec3());
        assert!(found.abs_diff_eq(DVec3::from_array(expected), 1e-12), "{found} instead of {expected:?}");
    }
    let warnings = capture.warnings();
    let of_axis = warnings.iter().filter(|warning| warning.contains("a.stl") && warning.contains("points up"));
    assert_eq!(of_axis.count(), said, "{warnings:?}");
}

/// Cases of rotation keys of an object, with the place of the corner, in figures of their own.
#[rstest]
#[case::nothing("", [1.0, 2.0, 3.0])]
#[case::position("position_m = [10, 0, -1]", [11.0, 2.0, 2.0])]
#[case::about_x("rotation_deg = [90, 0, 0]", [1.0, -3.0, 2.0])]
#[case::about_y("rotation_deg = [0, 90, 0]", [3.0, 2.0, -1.0])]
#[case::about_z("rotation_deg = [0, 0, 90]", [-2.0, 1.0, 3.0])]
// First about x, to [1, −3, 2], then about y, to [2, −3, −1], then about z.
#[case::in_order("rotation_deg = [90, 90, 90]", [3.0, 2.0, -1.0])]
#[case::quaternion("quaternion_wxyz = [2, 0, 2, 0]", [3.0, 2.0, -1.0])]
#[case::facing_x("look_at_m = [5, 0, 0]", [3.0, 2.0, -1.0])]
#[case::facing_backwards("position_m = [0, 0, 1]\nlook_at_m = [0, 0, 0]", [-1.0, 2.0, -2.0])]
// +z along [1, 0, 1]/√2 and +x along [1, 0, −1]/√2.
#[case::facing_between(
    "look_at_m = [1, 0, 1]", [4.0 * FRAC_1_SQRT_2, 2.0, 2.0 * FRAC_1_SQRT_2]
)]
#[case::scale("scale = 2\nposition_m = [1, 0, 0]", [3.0, 4.0, 6.0])]
#[case::scales("scale = [1, 2, 3]\nrotation_deg = [0, 0, 90]", [-4.0, 1.0, 9.0])]
#[case::z_up("up = 'z'", [1.0, 3.0, -2.0])]
#[case::unit("meters_per_unit = 0.001\nposition_m = [0, 1, 0]", [0.001, 1.002, 0.003])]
// The scale is along the axes of the object, whose y is the file's z.
#[case::all("up = 'z'\nmeters_per_unit = 0.1\nscale = [1, 10, 1]\nposition_m = [1, 0, 0]", [1.1, 3.0, -0.2])]
fn poses_put_the_object_where_they_say(#[case] keys: &str, #[case] expected: [f64; 3]) {
    let capture = objects(&format!("[[scene.objects]]\nfile = 'corner.obj'\n{keys}")).read(&[]).expect("a capture");
    let scene = &capture.scene;
    let [instance] = &scene.instances[..] else { panic!("{:?}", scene.instances) };
    let found = instance.to_world.transform_point3(scene.meshes[instance.meshes.start].positions[0].as_dvec3());
    assert!(found.abs_diff_eq(DVec3::from_array(expected), 1e-12), "{found} instead of {expected:?}");
    // The object's own frame leaves out axes and units of the file: its pose is what was written.
    let object = &scene.objects[0];
    let in_object = object.to_world.inverse().transform_point3(found);
    let turned = if keys.contains("'z'") { [1.0, 3.0, -2.0] } else { [1.0, 2.0, 3.0] };
    let unit = [(0.001, "0.001"), (0.1, "0.1")].into_iter().find(|(_, text)| keys.contains(text));
    let wanted = DVec3::from_array(turned) * unit.map_or(1.0, |(unit, _)| unit);
    assert!(in_object.abs_diff_eq(wanted, 1e-12), "{in_object}");
}

#[test]
fn objects_of_one_file_share_its_meshes() {
    let tables = "
        [[scene.objects]]
        file = 'corner.obj'
        [[scene.objects]]
        file = './corner.obj'
        name = 'other'
        category = 'thing'
        position_m = [1, 0, 0]
        [[scene.objects]]
        file = 'corner.obj'
        material = 'red'
        [[scene.objects]]
        file = 'corner.obj'
        material = { '*' = 'red' }
        [[scene.objects]]
        file = 'corner.obj'
        visible = false
        [materials.red]
        type = 'diffuse'
        reflectance = [0.5, 0.1, 0.1]";
    let capture = objects(tables).read(&[]).expect("a capture");
    let scene = &capture.scene;
    let named: Vec<(&str, &str)> =
        scene.objects.iter().map(|o| (&*o.name, o.category.as_deref().unwrap_or_default())).collect();
    let expected = [("corner", "corner"), ("other", "thing"), ("corner-1", "corner"), ("corner-2", "corner")];
    assert_eq!(named, expected);
    let meshes: Vec<usize> = scene.instances.iter().map(|instance| instance.meshes.start).collect();
    assert_eq!(meshes[2], meshes[3], "two that are painted the same");
    assert_eq!(meshes[0], meshes[1], "one file, however its path is written");
    assert_ne!(meshes[0], meshes[2]);
    let name = |mesh: usize| &*scene.materials[scene.meshes[mesh].material].name;
    assert_eq!([name(meshes[0]), name(meshes[2])], ["paint", "red"]);
}

#[rstest]
#[case::no_file("file = 'other.obj'", "scene.objects[0].file", "there is no file")]
#[case::two_turns(
    "file = 'corner.obj'\nrotation_deg = [0, 0, 0]\nlook_at_m = [0, 0, 1]",
    "look_at_m",
    "cannot be combined with rotation_deg"
)]
#[case::no_turn("file = 'corner.obj'\nquaternion_wxyz = [0, 0, 0, 0]", "quaternion_wxyz", "must not be 0")]
#[case::straight_up("file = 'corner.obj'\nlook_at_m = [0, 1, 0]", "look_at_m", "which way is up")]
#[case::no_size("file = 'corner.obj'\nscale = 0", "scale", "must be above 0")]
#[case::mirror("file = 'corner.obj'\nscale = [1, -1, 1]", "scale", "must be above 0")]
#[case::far("file = 'corner.obj'\nposition_m = [1e19, 0, 0]", "position_m", "too far")]
#[case::unit("file = 'corner.obj'\nmeters_per_unit = -1", "meters_per_unit", "must be above 0")]
#[case::material("file = 'corner.obj'\nmaterial = 'pant'", "material", "did you mean `paint`?")]
#[case::materials("file = 'corner.obj'\nmaterial = { pant = 'paint' }", "material.pant", "did you mean `paint`?")]
#[case::variant("file = 'corner.obj'\nvariant = 'night'", "variant", "no material variant")]
#[case::animation("file = 'corner.obj'\nanimation = 'walk'", "animation", "needs an exposure time")]
#[case::animation_time(
    "file = 'corner.obj'\nanimation_time_s = 1",
    "animation_time_s",
    "only applies with an animation"
)]
#[case::same_name(
    "file = 'corner.obj'\nname = 'a'\n[[scene.objects]]\nfile = 'corner.obj'\nname = 'a'",
    "scene.objects[1].name",
    "already"
)]
#[case::key("file = 'corner.obj'\nposition = [0, 0, 0]", "position", "did you mean `position_m`?")]
fn wrong_keys_are_named(#[case] keys: &str, #[case] key: &str, #[case] message: &str) {
    let error = objects(&format!("[[scene.objects]]\n{keys}")).read(&[]).expect_err("refused").to_string();
    assert!(error.contains(key) && error.contains(message), "{error}");
}

#[test]
fn materials_that_no_object_shows_need_no_description() {
    let told = |keys: &str| {
        let capture = objects(&format!("[[scene.objects]]\nfile = 'corner.obj'\n{keys}")).read(&[]).expect("a capture");
        capture.warnings().iter().filter(|warning| warning.contains("nothing describes the material \"paint\"")).count()
    };
    let red = "material = 'red'\n[materials.red]\ntype = 'diffuse'\nreflectance = 0.5";
    assert_eq!(
        [
            told(""),
            told(red),
            told("name = 'b'\nvisible = false\n[[scene.objects]]\nfile = 'corner.obj'\nmaterial = { paint = 'paint' }")
        ],
        [1, 0, 1]
    );
}

#[test]
fn a_palette_of_materials_may_have_more_than_are_used() {
    let palette = "[materials.red]\ntype = 'diffuse'\nreflectance = 0.5";
    let object = "[[scene.objects]]\nfile = 'corner.obj'\n";
    let unused = objects(&format!("{object}{palette}")).read(&[]).expect("a capture");
    let told = |capture: &Capture| capture.warnings().iter().filter(|w| w.contains("materials.red")).count();
    assert_eq!(told(&unused), 1, "{:?}", unused.warnings());
    let used = objects(&format!("{object}material = 'red'\n{palette}")).read(&[]).expect("a capture");
    assert_eq!(told(&used), 0, "{:?}", used.warnings());
    // Where nothing can be given another material, the name is wrong; and changes need something to change.
    for wrong in [room(palette), format!("[scene]\n{object}[materials.red]\ndouble_sided = true")] {
        let error = objects_of(&wrong).read(&[]).expect_err("refused").to_string();
        assert!(error.contains("has no material \"red\""), "{error}");
    }
}
