//! The reference lenses, written as each format has them: what is read is what was written.

use std::fmt::Write;

use photosite_core::spectrum::dispersion::lines;
use photosite_lens::files::names;
use photosite_lens::prescription::{Prescription, Surface};

use super::{reading, reference};

fn numbers(surface: &Surface) -> Option<(f64, f64)> {
    let dispersion = &surface.glass.as_ref()?.dispersion;
    Some((dispersion.index(lines::D), dispersion.abbe_number()))
}

fn curvature(surface: &Surface) -> f64 {
    surface.radius_mm.map_or(0.0, f64::recip)
}

fn semi(surface: &Surface) -> f64 {
    surface.semi_aperture_mm.expect("given")
}

/// Whether all orders are even, so that formats of even orders can hold them.
fn is_even(lens: &Prescription) -> bool {
    lens.surfaces.iter().flat_map(|surface| &surface.asphere).all(|(order, _)| order % 2 == 0)
}

/// Checks that two lenses are the same up to rounding. Positions are those of the file.
fn assert_same(name: &str, read: &Prescription, expected: &Prescription, index_error: f64) {
    assert_eq!(read.surfaces.len(), expected.surfaces.len(), "{name}");
    for (i, (a, b)) in read.surfaces.iter().zip(&expected.surfaces).enumerate() {
        let near = |x: f64, y: f64| (x - y).abs() <= 1e-12 * (1.0 + y.abs());
        assert!(near(curvature(a), curvature(b)), "{name} {i}: {a:?} {b:?}");
        assert!(near(a.thickness_mm, b.thickness_mm), "{name} {i}: {a:?} {b:?}");
        assert!(near(semi(a), semi(b)), "{name} {i}: {a:?} {b:?}");
        assert!(near(a.conic, b.conic) && a.is_stop == b.is_stop, "{name} {i}: {a:?} {b:?}");
        assert_eq!(a.asphere.len(), b.asphere.len(), "{name} {i}");
        for ((order, x), (other, y)) in a.asphere.iter().zip(&b.asphere) {
            assert!(order == other && (x - y).abs() <= 1e-12 * y.abs(), "{name} {i}: {a:?} {b:?}");
        }
        match (numbers(a), numbers(b)) {
            (Some((n, _)), Some((m, _))) => assert!((n - m).abs() <= index_error, "{name} {i}: {n} {m}"),
            (None, None) => {}
            other => panic!("{name} {i}: {other:?}"),
        }
    }
}

#[test]
fn our_own_form_gives_the_same_prescription_again() {
    for name in names() {
        let lens = reference(name).prescription;
        let toml = photosite_lens::files::to_toml(&lens);
        assert_eq!(reading("lens.toml", &toml).prescription, lens, "{name}");
    }
}

#[test]
fn opticstudio() {
    for name in names() {
        let lens = reference(name).prescription;
        let is_even = is_even(&lens);
        // In inches: every length is scaled, coefficients by their order.
        for (unit, mm) in [("MM", 1.0), ("IN", 25.4)] {
            let mut zmx = format!("MODE SEQ\nUNIT {unit} X W X CM MR CPMM\nSURF 0\n  TYPE STANDARD\n  DISZ INFINITY\n");
            for (i, surface) in lens.surfaces.iter().enumerate() {
                let kind = match (surface.asphere.is_empty(), is_even) {
                    (true, _) => "STANDARD",
                    (false, true) => "EVENASPH",
                    (false, false) => "XOSPHERE",
                };
                let _ =
                    writeln!(zmx, "SURF {}\n  TYPE {kind}\n  CURV {:e} 0 0 0 0 \"\"", i + 1, curvature(surface) * mm);
                if kind == "XOSPHERE" {
                    let _ = writeln!(zmx, "  XDAT 1 12 0 0\n  XDAT 2 2.0 0 0");
                }
                for &(order, a) in &surface.asphere {
                    let scaled = a * mm.powi(order as i32 - 1);
                    let _ = match kind {
                        "EVENASPH" => writeln!(zmx, "  PARM {} {scaled:e}", order / 2),
                        // Over the radius that r is divided by.
                        _ => writeln!(zmx, "  XDAT {} {:e} 0 0", order + 2, scaled * 2f64.powi(order as i32)),
                    };
                }
                let _ = writeln!(zmx, "  DISZ {:e}\n  CONI {}", surface.thickness_mm / mm, surface.conic);
                if let Some((nd, vd)) = numbers(surface) {
                    let _ = writeln!(zmx, "  GLAS ___BLANK 1 0 {nd} {vd} 0 0 0 0 0 0");
                }
                let _ = writeln!(zmx, "  DIAM 99 0 0 0 1 \"\"\n  CLAP 0 {:e} 0", semi(surface) / mm);
                if surface.is_stop {
                    zmx += "  STOP\n";
                }
            }
            let _ = writeln!(zmx, "SURF {}\n  TYPE STANDARD\n  CURV 0\n  DISZ 0", lens.surfaces.len() + 1);
            if lens.positions.len() > 1 {
                let _ = writeln!(zmx, "MNUM {} 1", lens.positions.len());
                for (number, position) in lens.positions.iter().enumerate() {
                    for (row, gap) in &position.gaps {
                        let _ = writeln!(zmx, "THIC {} {} {:e} 0 0 0 1 1 0 0.0 \"\"", row + 1, number + 1, gap / mm);
                    }
                }
            }
            let read = reading("lens.zmx", &zmx).prescription;
            assert_same(name, &read, &lens, 1e-4);
            assert_eq!(read.positions.len(), lens.positions.len(), "{name}");
            for (a, b) in read.positions.iter().zip(&lens.positions) {
                assert!(a.gaps.iter().zip(&b.gaps).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-9), "{name}");
            }
        }
    }
}

#[test]
fn code_v() {
    for name in names() {
        let lens = reference(name).prescription;
        if !is_even(&lens) {
            continue;
        }
        for radius_mode in ["Y", "N"] {
            let mut seq = format!("RDM {radius_mode};LEN\nDIM M\nTITLE 'a lens; with ! in its name'\nSO 0.0 0.1e14\n");
            for surface in &lens.surfaces {
                let first = if radius_mode == "Y" { surface.radius_mm.unwrap_or(0.0) } else { curvature(surface) };
                // Long lines go on behind an &.
                let _ = write!(seq, "S {first:e} &\n   {:e}", surface.thickness_mm);
                if let Some((nd, vd)) = numbers(surface) {
                    let _ = write!(seq, " {nd}:{vd}");
                }
                let _ = write!(seq, " ! a comment\n  CIR {:e}; CCY 0\n", semi(surface));
                if surface.is_stop {
                    seq += "  STO\n";
                }
                if surface.conic != 0.0 || !surface.asphere.is_empty() {
                    let _ = writeln!(seq, "  ASP; K {}", surface.conic);
                }
                for &(order, a) in &surface.asphere {
                    let letter = ["A", "B", "C", "D", "E", "F", "G", "H", "J"][order as usize / 2 - 2];
                    let _ = writeln!(seq, "  {letter} {a:e}");
                }
            }
            seq += "SI 0.0 0.0\n";
            if lens.positions.len() > 1 {
                let _ = writeln!(seq, "ZOO {}", lens.positions.len());
                for (i, (row, _)) in lens.positions[0].gaps.iter().enumerate() {
                    let gaps: Vec<String> =
                        lens.positions.iter().map(|position| position.gaps[i].1.to_string()).collect();
                    let _ = writeln!(seq, "ZOO THI S{} {}", row + 1, gaps.join(" "));
                }
            }
            let read = reading("lens.seq", &(seq + "GO\n")).prescription;
            assert_same(name, &read, &lens, 1e-4);
            assert_eq!(read.name, "a lens; with ! in its name");
            for (a, b) in read.positions.iter().zip(&lens.positions) {
                assert_eq!(a.gaps, b.gaps, "{name}");
            }
        }
    }
}

#[test]
fn optical_bench() {
    for name in names() {
        let lens = reference(name).prescription;
        let is_even = is_even(&lens);
        let constants = if is_even { "" } else { "AsphericalOddCount\t4\n" };
        let mut distances = "Magnification\t0\t0\t0\t0\n".to_owned();
        let mut rows = String::new();
        let mut aspheres = String::new();
        for (i, surface) in lens.surfaces.iter().enumerate() {
            let radius = match (surface.is_stop, surface.radius_mm) {
                (true, None) => "AS".to_owned(),
                (_, None) => "Infinity".to_owned(),
                (_, Some(radius)) => radius.to_string(),
            };
            let varies = lens.positions.iter().any(|position| position.gaps.iter().any(|(row, _)| *row == i));
            let thickness = if varies { format!("d{}", i + 1) } else { surface.thickness_mm.to_string() };
            if varies {
                let of = |gaps: &Vec<(usize, f64)>| gaps.iter().find(|(row, _)| *row == i).map_or(0.0, |(_, gap)| *gap);
                let columns: Vec<String> = lens.positions.iter().map(|p| of(&p.gaps).to_string()).collect();
                let _ = writeln!(distances, "{thickness}\t{}", columns.join("\t"));
            }
            let (nd, vd) = numbers(surface).map_or_else(Default::default, |(n, v)| (n.to_string(), v.to_string()));
            let _ = writeln!(rows, "{}\t{radius}\t{thickness}\t{nd}\t{}\t{vd}", i + 1, 2.0 * semi(surface));
            if surface.conic != 0.0 || !surface.asphere.is_empty() {
                let _ = write!(aspheres, "{}\t{radius}\t{}", i + 1, surface.conic);
                let orders: Vec<u32> = if is_even { (2..=7).map(|i| 2 * i).collect() } else { (3..=10).collect() };
                for order in orders {
                    let a = surface.asphere.iter().find(|(known, _)| *known == order).map_or(0.0, |(_, a)| *a);
                    let _ = write!(aspheres, "\t{a:E}");
                }
                aspheres.push('\n');
            }
        }
        // A stop on glass has a radius there: the Optical Bench has a row of its own for it.
        if lens.surfaces.iter().any(|surface| surface.is_stop && surface.radius_mm.is_some()) {
            continue;
        }
        let text = format!(
            "[descriptive data]\ntitle\t{name}\n[constants]\n{constants}[variable distances]\n{distances}[lens data]\n{rows}\
             [aspherical data]\n{aspheres}"
        );
        let read = reading("lens.txt", &text).prescription;
        assert_same(name, &read, &lens, 1e-4);
        assert_eq!(read.positions.len(), lens.positions.len(), "{name}");
    }
}

#[test]
fn pbrt() {
    for name in names() {
        let lens = reference(name).prescription;
        let has_flats = lens.surfaces.iter().any(|surface| surface.radius_mm.is_none() != surface.is_stop);
        let is_spherical = lens.surfaces.iter().all(|surface| surface.conic == 0.0 && surface.asphere.is_empty());
        if has_flats || !is_spherical {
            continue;
        }
        let mut dat = format!("# {name}\n# radius\tsepar\tn\taperture\n");
        for surface in &lens.surfaces {
            let index = match (surface.is_stop, numbers(surface)) {
                (true, _) => 0.0,
                (false, numbers) => numbers.map_or(1.0, |(n, _)| n),
            };
            let (radius, thickness) = (surface.radius_mm.unwrap_or(0.0), surface.thickness_mm);
            let _ = writeln!(dat, "{radius}\t{thickness}\t{index}\t{}", 2.0 * semi(surface));
        }
        let read = reading("lens.dat", &dat);
        // pbrt focuses by itself: the last gap is that of parallel light.
        let mut expected = lens.clone();
        let focus = read.lens.at(lines::D).first_order().bfl_mm;
        let last = expected.surfaces.last_mut().expect("surfaces");
        assert!((focus - last.thickness_mm).abs() < 0.02 * focus, "{name}: {focus} {}", last.thickness_mm);
        last.thickness_mm = focus;
        expected.positions.clear();
        assert_same(name, &read.prescription, &expected, 1e-12);
        assert_eq!(read.prescription.name, name);
        let [a, b] = [&read.lens, &reference(name).lens].map(|lens| lens.at(lines::D).first_order().efl_mm);
        assert!((a - b).abs() < 1e-9 * b || !lens.positions.is_empty(), "{name}: {a} {b}");
    }
}
