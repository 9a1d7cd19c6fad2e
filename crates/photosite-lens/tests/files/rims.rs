//! Rims that run through each other, end beside the glass, or stand behind the next vertex; by closed forms of spheres.

use photosite_core::spectrum::dispersion::lines;
use photosite_lens::Ray;
use photosite_lens::files::Reading;
use photosite_lens::trace::{Apertures, Reason};

use super::{error, reading};

/// Radii of the faces of a biconvex lens, its half and whole thickness, mm.
const R: f64 = 50.0;

/// Distance from the axis at which the faces of a biconvex lens of this thickness meet: each has half of it as its sag,
/// r² = R² − (R − d/2)².
fn meeting(r: f64, d: f64) -> f64 {
    (r * r - (r - 0.5 * d).powi(2)).sqrt()
}

/// A biconvex lens of ±50 mm of this thickness and these semi-apertures, and a stop 3 mm behind, in each format.
fn files(d: f64, [first, second]: [f64; 2], stop: f64) -> Vec<(&'static str, String)> {
    let (f2, s2, t2) = (2.0 * first, 2.0 * second, 2.0 * stop);
    let surface = |kind: &str, roc: f64, r: f64, mat: &str, gap: f64| {
        format!("{{\"type\": \"{kind}\", \"r\": {r}, \"roc\": {roc}, \"mat2\": \"{mat}\", \"d_next\": {gap}}}")
    };
    let deeplens = [
        surface("Spheric", R, first, "n-bk7", d),
        surface("Spheric", -R, second, "air", 3.0),
        surface("Aperture", 0.0, stop, "air", 45.0),
    ];
    let optiland = |z: f64, radius: &str, medium: &str, rim: f64, is_stop: bool| {
        format!(
            "{{\"geometry\": {{\"type\": \"StandardGeometry\", \"radius\": {radius}, \"cs\": {{\"z\": {z}}}}}, \
             \"material_post\": {medium}, \"aperture\": {{\"r_max\": {rim}}}, \"is_stop\": {is_stop}}}"
        )
    };
    let air = "{\"type\": \"IdealMaterial\", \"index\": 1.0}";
    let glass = "{\"type\": \"Material\", \"name\": \"N-BK7\"}";
    let optiland = [
        optiland(-1e12, "Infinity", air, 99.0, false),
        optiland(0.0, &R.to_string(), glass, first, false),
        optiland(d, &(-R).to_string(), air, second, false),
        optiland(d + 3.0, "Infinity", air, stop, true),
        optiland(d + 48.0, "Infinity", air, 99.0, false),
    ];
    vec![
        (
            "a.zmx",
            format!(
                "UNIT MM\nSURF 0\n DISZ INFINITY\nSURF 1\n CURV {}\n DISZ {d}\n GLAS N-BK7\n DIAM {first}\nSURF 2\n \
                 CURV {}\n DISZ 3\n DIAM {second}\nSURF 3\n STOP\n DISZ 45\n DIAM {stop}\nSURF 4\n DISZ 0\n",
                1.0 / R,
                -1.0 / R
            ),
        ),
        (
            "a.seq",
            format!(
                "RDM\nDIM M\nSO 0 1e13\nS {R} {d} NBK7\nCIR {first}\nS -{R} 3\nCIR {second}\nS 0 45\nSTO\nCIR {stop}\nSI 0 0\n"
            ),
        ),
        ("a.txt", format!("[lens data]\n1\t{R}\t{d}\t1.5168\t{f2}\t64.2\n2\t-{R}\t3\t\t{s2}\n3\tAS\t45\t\t{t2}\n")),
        ("a.dat", format!("{R} {d} 1.5168 {f2}\n-{R} 3 1 {s2}\n0 45 0 {t2}\n")),
        ("a.json", format!("{{\"surfaces\": [{}]}}", deeplens.join(", "))),
        ("b.json", format!("{{\"surface_group\": {{\"surfaces\": [{}]}}}}", optiland.join(", "))),
    ]
}

fn rim(lens: &Reading, surface: usize) -> f64 {
    lens.prescription.surfaces[surface].semi_aperture_mm.expect("given")
}

fn says(list: &[String], what: &str) -> bool {
    list.iter().any(|note| note.contains(what))
}

#[test]
fn rims_that_overlap_are_cut_back_to_where_the_faces_meet() {
    // From micrometres to a third of the rim; the smaller one is cut, whichever it is.
    for d in [1.2875, 1.25, 0.6] {
        let meeting = meeting(R, d);
        for (rims, smaller) in [([8.1, 8.05], 1), ([8.05, 8.1], 0)] {
            for (name, text) in files(d, rims, 3.0) {
                let lens = reading(name, &text);
                assert!((0.0..=2e-4).contains(&(meeting - rim(&lens, smaller))), "{name} {d}: {}", rim(&lens, smaller));
                assert!((rim(&lens, 1 - smaller) - 8.1).abs() < 1e-12, "{name} {d}");
                assert!(says(&lens.report.assumed, "cut back"), "{name}: {:?}", lens.report.assumed);
                assert!(says(&lens.report.assumed, &format!("{:.4}", rim(&lens, smaller))), "{name}");
            }
        }
        // What fits stays.
        for (name, text) in files(d, [meeting - 1e-3; 2], 3.0) {
            let lens = reading(name, &text);
            assert!((rim(&lens, 0) - meeting + 1e-3).abs() < 1e-9 && !says(&lens.report.assumed, "cut back"), "{name}");
        }
    }
}

#[test]
fn an_overlap_that_the_beam_comes_to_is_refused() {
    // The beam on the axis is wider at the lens than at the stop behind it.
    let d = 0.6;
    for (name, text) in files(d, [8.1, 8.05], meeting(R, d)) {
        let message = error(name, &text);
        assert!(message.contains("runs through"), "{name}: {message}");
    }
    for (name, text) in files(d, [8.1, 8.05], 0.9 * meeting(R, d)) {
        reading(name, &text);
    }
}

#[test]
fn rims_beyond_the_sphere_or_the_fold_of_an_asphere_are_cut_back() {
    let bench = |rows: &str, aspheres: &str| format!("[lens data]\n{rows}[aspherical data]\n{aspheres}");
    let rows = "1\t10\t4\t1.5168\t20.4\t64.2\n2\tInfinity\t3\t\t16\n3\tAS\t15\t\t2\n";
    let lens = reading("a.txt", &bench(&rows.replace("4\t1.5168", "12\t1.5168"), ""));
    assert!((9.999..=10.0).contains(&rim(&lens, 0)), "{}", rim(&lens, 0));
    assert!(says(&lens.report.assumed, "surface 1 has no surface beyond"), "{:?}", lens.report.assumed);
    // An ellipsoid of k = 1 ends at R/√2; rims are diameters.
    let lens = reading("a.txt", &bench(&rows.replace("4\t1.5168", "12\t1.5168"), "1\t10\t1\n"));
    assert!((0.0..2e-4).contains(&(10.0 / 2f64.sqrt() - rim(&lens, 0))), "{}", rim(&lens, 0));
    let narrow = rows.replace("\t2\n", "\t15.8\n");
    assert!(error("a.txt", &bench(&narrow.replace("4\t1.5168", "12\t1.5168"), "1\t10\t1\n")).contains("surface 1"));
}

/// A field stop 0.3 mm behind the vertex of the convex surface that stands in its opening.
#[test]
fn openings_in_air_may_stand_behind_the_next_vertex() {
    let with = |fs: &str| {
        format!(
            "[lens data]\n1\t50\t4\t1.5168\t16\t64.2\n2\tInfinity\t2\t\t16\n{fs}3\t20\t4\t1.5168\t12\t64.2\n4\tInfinity\t1\t\t12\n5\tAS\t20\t\t8\n"
        )
    };
    let plain = reading("a.txt", &with("").replace("Infinity\t2", "Infinity\t1.7"));
    let stopped = reading("a.txt", &with("2a\tFS\t-0.3\t\t10\n"));
    let at = [&plain, &stopped].map(|reading| reading.lens.at(lines::D));
    assert!((at[0].first_order().efl_mm - at[1].first_order().efl_mm).abs() < 1e-12);
    for i in 0..60 {
        let ray = Ray { origin: glam::DVec3::new(0.0, 0.1 * f64::from(i), -1.0), direction: glam::DVec3::Z };
        let [free, traced] = [&at[0], &at[1]].map(|at| at.trace_in(ray, Apertures::Clip));
        // By the ray's height in the plane of the opening, which it crosses in air.
        let mut points = Vec::new();
        let _ = at[1].trace(
            ray,
            photosite_lens::profile::Travel::ToSensor,
            (0..3).map(photosite_lens::trace::Step::refract),
            Apertures::Ignore,
            |hit| points.push(hit.point),
        );
        match (free, traced) {
            (Ok(free), Ok(traced)) => {
                assert!(points[2].y <= 5.0 && (free.direction - traced.direction).length() < 1e-12, "{i}");
            }
            (_, Err(stopped)) if points[2].y > 5.0 => {
                assert!(stopped.surface == 2 && stopped.reason == Reason::Blocked)
            }
            (free, traced) => assert!(free.is_err() && traced.is_err(), "{i}: {free:?} {traced:?}"),
        }
    }
    // The glass reaches 20 − √(20² − 2²) = 0.1 mm behind its vertex there: the opening is in it.
    assert!(error("a.txt", &with("2a\tFS\t-0.3\t\t4\n")).contains("surface 2a: air cannot be -0.3 mm thick"));
    // A stop in the hollow of the surface before it, by its sag of 0.63 mm at 5 mm.
    let hollow = with("").replace("4\tInfinity\t1\t", "4\t-20\t-0.6\t").replace("\t8\n", "\t10\n");
    reading("a.txt", &hollow);
    assert!(error("a.txt", &hollow.replace("-0.6", "-0.7")).contains("surface 4: air cannot be -0.7 mm thick"));
    // Two pieces of glass do not meet in an opening.
    assert!(
        error("a.txt", &with("2a\tFS\t-0.3\t\t10\n").replace("Infinity\t2\t", "Infinity\t0.1\t"))
            .contains("runs through")
    );
}

#[test]
fn a_stop_alone_defines_the_rims_of_a_file_of_opticstudio() {
    let of = |stop: f64| {
        format!(
            "UNIT MM\nFLOA\nSURF 0\n DISZ INFINITY\nSURF 1\n CURV 0.05\n DISZ 5\n GLAS N-BK7 1 0 1.5168 64.17\nSURF 2\n \
             CURV -0.05\n DISZ 10\nSURF 3\n STOP\n DISZ 20\n DIAM {stop} 1\nSURF 4\n DISZ 0\n"
        )
    };
    // A ray parallel to the axis is the marginal ray: height at the stop over height at SURF 1, to first order.
    let n: f64 = 1.5168;
    let u = -0.05 * (n - 1.0) / n;
    let y = 1.0 + 5.0 * u;
    let at_stop = y + 10.0 * (n * u - y * 0.05 * (n - 1.0));
    // Rims are those of the F line, too, where the power is 1 % more.
    let lens = reading("a.zmx", &of(0.1));
    assert!((rim(&lens, 0) / (0.1 / at_stop) - 1.0).abs() < 2e-2, "{} {}", rim(&lens, 0), 0.1 / at_stop);
    assert!((rim(&lens, 2) - 0.1).abs() < 1e-12 && lens.report.warnings.iter().all(|w| !w.contains("no light fills")));
    // Wider than light fills: the faces meet at the edge, and bound the beam.
    let lens = reading("a.zmx", &of(8.5));
    let edge = meeting(20.0, 5.0);
    assert!(rim(&lens, 0).min(rim(&lens, 1)) <= edge + 1e-4 && rim(&lens, 0) > 0.9 * edge, "{:?}", lens.prescription);
    assert!(says(&lens.report.warnings, "no light fills the stop"), "{:?}", lens.report.warnings);
}
