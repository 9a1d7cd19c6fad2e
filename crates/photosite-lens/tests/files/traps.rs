//! Traps of lens file formats.

use photosite_core::spectrum::dispersion::lines;
use photosite_lens::files::{self, Reading};
use photosite_lens::prescription::Position;

use super::{error, reading};

fn efl(reading: &Reading) -> f64 {
    reading.lens.at(lines::D).first_order().efl_mm
}

fn told(reading: &Reading, what: &str) -> bool {
    let report = &reading.report;
    report.assumed.iter().chain(&report.ignored).chain(&report.warnings).any(|note| note.contains(what))
}

/// A plano-convex lens of N-BK7 whose stop is its first surface: EFL = R/(n − 1), n_d = 1.516800.
const SEQ: &str =
    "RDM Y\nDIM M\nTITLE 'singlet'\nEPD 10\nYAN 0 5\nSO 0 1e13\nS 50 4 NBK7_SCHOTT\n  STO\nS 0 90\nSI 0 0\nGO\n";

const ZMX: &str = "MODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 10\nFTYP 0 0 2 1 0 0 0\nYFLN 0 5\nGCAT SCHOTT\nSURF 0\n  DISZ INFINITY\n\
                   SURF 1\n  STOP\n  TYPE STANDARD\n  CURV 0.02\n  DISZ 4\n  GLAS N-BK7 0 0 1.5 40\n  DIAM 8 1\n\
                   SURF 2\n  CURV 0\n  DISZ 90\n  DIAM 8 1\nSURF 3\n  DISZ 0\n";

#[test]
fn the_singlets_have_the_focal_length_of_the_lensmakers_equation() {
    for (name, text) in [("a.seq", SEQ), ("a.zmx", ZMX), ("A.ZMX", ZMX)] {
        let lens = reading(name, text);
        assert!((efl(&lens) - 50.0 / 0.5168).abs() < 1e-3, "{name}: {}", efl(&lens));
        // The entrance pupil is on the first surface, where the stop is.
        assert!((lens.lens.stop_radius_mm() - 5.0).abs() < 1e-12, "{name}");
        assert_eq!(lens.prescription.claims.half_field_deg, Some(5.0), "{name}");
    }
}

#[test]
fn a_sequence_that_does_not_say_what_its_numbers_are_is_refused() {
    let message = error("a.seq", &SEQ.replace("RDM Y\n", ""));
    assert!(message.contains("RDM Y") && message.contains("RDM N"), "{message}");
    // Curvatures and radii are told apart also where they come one by one.
    let curvature = SEQ.replace("RDM Y", "RDM N").replace("S 50 4", "S 0.02 4");
    assert!((efl(&reading("a.seq", &curvature)) - efl(&reading("a.seq", SEQ))).abs() < 1e-9);
    let by_radius = SEQ.replace("RDM Y", "RDM N").replace("S 50 4 NBK7_SCHOTT\n", "S 0 4 NBK7_SCHOTT\n  RDY S1 50\n");
    assert!((efl(&reading("a.seq", &by_radius)) - efl(&reading("a.seq", SEQ))).abs() < 1e-9);
}

#[test]
fn units_of_a_sequence_scale_all_of_it() {
    let inches = reading("a.seq", &SEQ.replace("DIM M", "DIM I"));
    assert!((efl(&inches) / efl(&reading("a.seq", SEQ)) - 25.4).abs() < 1e-9);
    assert!((inches.lens.stop_radius_mm() - 127.0).abs() < 1e-9);
    assert!(told(&reading("a.seq", &SEQ.replace("DIM M\n", "")), "DIM"));
}

#[test]
fn defocus_on_the_image_counts() {
    let lens = reading("a.seq", &SEQ.replace("SI 0 0", "SI 0 -0.4"));
    assert!((lens.prescription.surfaces[1].thickness_mm - 89.6).abs() < 1e-12);
    assert!(told(&lens, "defocus of -0.4"));
}

#[test]
fn glasses_of_a_sequence() {
    for (glass, nd, vd) in [
        ("517000.520000", 1.517, 52.0),
        ("1.5168:64.17", 1.5168, 64.17),
        ("BK7_SCHOTT", 1.5168, 64.167),
        ("SLAL8_OHARA", 1.713, 53.87),
        ("caf2", 1.43385, 95.0),
    ] {
        let lens = reading("a.seq", &SEQ.replace("NBK7_SCHOTT", glass));
        let found = &lens.report.glasses[0];
        assert!((found.nd - nd).abs() < 1e-4 && (found.vd - vd).abs() < 0.3, "{glass}: {found:?}");
    }
    for glass in ["F2", "NBK77_SCHOTT", "1.5168"] {
        assert!(error("a.seq", &SEQ.replace("NBK7_SCHOTT", glass)).contains("a.seq:7: surface 1"), "{glass}");
    }
    assert!(error("a.seq", &SEQ.replace("NBK7_SCHOTT", "F2")).contains("schott/F2, hikari/F2, cdgm/F2"));
    assert!(error("a.seq", &SEQ.replace("NBK7_SCHOTT", "NBK77_SCHOTT")).contains("schott/N-BK7"));
}

/// A sequence whose glass is a table of the private catalogue, nm and indices.
fn with_table(table: &[(f64, f64)]) -> String {
    let words = |of: &dyn Fn(&(f64, f64)) -> String| table.iter().map(of).collect::<Vec<_>>().join(" ");
    let (nm, n) = (words(&|row| row.0.to_string()), words(&|row| format!("{:.6}", row.1)));
    let catalogue = format!("PRV\n PWL {nm}\n 'MINE' {n}\nEND\n");
    SEQ.replace("EPD 10", &format!("{catalogue}EPD 10")).replace("NBK7_SCHOTT", "'MINE'")
}

/// Schott's Sellmeier formulas of the data sheets give tables of few and of many lines: photosite goes through the
/// lines, and between them differs from the formula by less than three terms leave.
#[test]
fn a_private_catalogue_goes_through_its_table() {
    let glasses: [(&str, [f64; 3], [f64; 3]); 3] = [
        ("N-BK7", [1.03961212, 0.231792344, 1.01046945], [0.00600069867, 0.0200179144, 103.560653]),
        ("N-SF6", [1.77931763, 0.338149866, 2.08734474], [0.0133714182, 0.0617533621, 174.01759]),
        ("N-FK58", [0.738042712, 0.363371967, 0.989296264], [0.00339065607, 0.0117551189, 212.842145]),
    ];
    let lines_nm = [1529.6, 1013.98, 852.1, 706.5, 656.3, 587.6, 546.1, 486.1, 435.8, 404.7, 365.0];
    for (name, b, c) in glasses {
        let sellmeier = |nm: f64| {
            let l2 = (nm * 1e-3).powi(2);
            (1.0 + b.iter().zip(c).map(|(b, c)| b * l2 / (l2 - c)).sum::<f64>()).sqrt()
        };
        for table in
            [&lines_nm[2..9], &lines_nm[2..10], &lines_nm[..], &lines_nm[4..8], &lines_nm[4..7], &lines_nm[5..7]]
        {
            let rows: Vec<(f64, f64)> = table.iter().map(|&nm| (nm, sellmeier(nm))).collect();
            let lens = reading("a.seq", &with_table(&rows));
            let glass = lens.prescription.surfaces[0].glass.as_ref().expect("a glass");
            for &(nm, n) in &rows {
                let off = (glass.dispersion.index(nm) - n).abs();
                assert!(off <= 1.1e-5, "{name}, {} lines: {off:e} at {nm} nm", rows.len());
            }
            assert!(!told(&lens, "is no smooth curve"), "{name}: {:?}", lens.report.warnings);
            // Between the ends, where there are lines enough: the precision, and what its differences leave between.
            let (from, to) = (table[table.len() - 1], table[0]);
            for nm in (0..50).map(|i| from + (to - from) * f64::from(i) / 49.0).filter(|_| table.len() > 6) {
                let off = (glass.dispersion.index(nm) - sellmeier(nm)).abs();
                assert!(off <= 5e-5, "{name}, {} lines: {off:e} at {nm} nm", rows.len());
            }
        }
        // A digit that is wrong is said, and the glass read.
        let mut rows: Vec<(f64, f64)> = lines_nm.iter().map(|&nm| (nm, sellmeier(nm))).collect();
        rows[5].1 += 0.003;
        let lens = reading("a.seq", &with_table(&rows));
        assert!(told(&lens, "MINE of the private catalogue is no smooth curve"), "{:?}", lens.report.warnings);
        // Between the nanometres of a spectrum a corner of 1e-4 a nm is rounded by a quarter of that.
        let glass = lens.prescription.surfaces[0].glass.as_ref().expect("a glass");
        for &(nm, n) in rows.iter().filter(|(nm, _)| *nm < 1100.0) {
            let off = (glass.dispersion.index(nm) - n).abs();
            assert!(off <= 3e-5, "{name}: {off:e} at {nm} nm");
        }
        // Our own file keeps it.
        let own = reading("a.toml", &files::to_toml(&lens.prescription));
        assert_eq!(own.prescription.surfaces, lens.prescription.surfaces, "{name}");
    }
}

#[test]
fn what_a_sequence_leaves_open_can_be_said() {
    use photosite_lens::files::{FirstNumber, read_with};
    let with = |name: &str, text: &str, first| read_with(text.as_bytes(), name.as_ref(), Some(first));
    let without = SEQ.replace("RDM Y\n", "");
    let radii = with("a.seq", &without, FirstNumber::Radius).expect("a lens");
    assert!((efl(&radii) - 50.0 / 0.5168).abs() < 1e-3 && told(&radii, "as you say"));
    let curvatures = with("a.seq", &without.replace("S 50 4", "S 0.02 4"), FirstNumber::Curvature).expect("a lens");
    assert!((efl(&curvatures) - efl(&radii)).abs() < 1e-9);
    // The radius of a command of its own stays one.
    let by_command = without.replace("S 50 4 NBK7_SCHOTT\n", "S 0 4 NBK7_SCHOTT\n  RDY S1 50\n");
    let by_command = with("a.seq", &by_command, FirstNumber::Curvature).expect("a lens");
    assert!((efl(&by_command) - efl(&radii)).abs() < 1e-9);
    // What the file says holds.
    let contrary = with("a.seq", SEQ, FirstNumber::Curvature).expect("a lens");
    assert!((efl(&contrary) - efl(&radii)).abs() < 1e-12 && told(&contrary, "the RDM of the file holds"));
    let message = with("a.zmx", ZMX, FirstNumber::Radius).expect_err("refused").to_string();
    assert!(message.contains("says itself"), "{message}");
}

#[test]
fn names_of_opticstudio_are_looked_up_in_its_catalogues_and_model_glasses_have_their_numbers() {
    let of = |glass: &str, catalogues: &str| ZMX.replace("N-BK7 0 0 1.5 40", glass).replace("GCAT SCHOTT", catalogues);
    let nd = |text: &str| reading("a.zmx", text).report.glasses[0].nd;
    assert!((nd(&of("F2 0 0 1.5 40", "GCAT SCHOTT CDGM")) - 1.62004).abs() < 1e-5);
    assert!((nd(&of("F2 0 0 1.5 40", "GCAT CDGM SCHOTT")) - 1.61293).abs() < 1e-5);
    assert!((nd(&of("___BLANK 1 0 1.7 30.5 0 0 0", "GCAT SCHOTT")) - 1.7).abs() < 1e-4);
    // Mode 1 takes the numbers, whatever the name, but where they are the same.
    assert!((nd(&of("N-BK7 1 0 1.6 50.3", "GCAT SCHOTT")) - 1.6).abs() < 1e-4);
    assert_eq!(reading("a.zmx", &of("N-BK7 1 0 1.5168 64.17", "")).report.glasses[0].name, "N-BK7");
    // Leftovers behind a name that is not known are no index.
    let message = error("a.zmx", &of("D-ZK3M 0 0 1.601 50.28", "GCAT LIGHTPATH"));
    assert!(message.contains("D-ZK3M") && message.contains("cdgm/D-ZK3") && message.contains("1.601"), "{message}");
    let message = error("a.zmx", &of("B270 0 0 1.5 40", "GCAT SCHOTT"));
    assert!(message.contains("B270") && !message.contains("40"), "{message}");
}

#[test]
fn the_deviation_of_a_model_glass_moves_its_blue_index() {
    let of = |deviation: &str| {
        let glass = format!("___BLANK 1 0 1.70123 30.55 {deviation} 0 0");
        let lens = reading("a.zmx", &ZMX.replace("N-BK7 0 0 1.5 40", &glass));
        lens.prescription.surfaces[0].glass.as_ref().map(|glass| glass.dispersion.index(435.8343)).expect("a glass")
    };
    let mean = 0.70123 / 30.55;
    assert!((of("0.01") - of("-0.01") - 0.02 * mean).abs() < 2e-4 * mean + 2e-4, "{} {}", of("0.01"), of("-0.01"));
    assert!(of("0.01") > of("0.0"));
}

#[test]
fn clap_clips_and_diam_stands_in() {
    let lens = reading("a.zmx", &ZMX.replace("  DIAM 8 1\nSURF 2", "  DIAM 8 1\n  CLAP 0 4 0\nSURF 2"));
    let semi = |lens: &Reading, i: usize| lens.prescription.surfaces[i].semi_aperture_mm.expect("given");
    // The file limits the stop itself.
    assert_eq!([semi(&lens, 0), semi(&lens, 1)], [4.0, 8.0]);
    assert!(told(&lens, "DIAM"));
    // A diameter that is found automatically is that of the beam.
    let lens = reading("a.zmx", &ZMX.replace("  DISZ 90\n  DIAM 8 1", "  DISZ 90\n  DIAM 0 0"));
    assert!((4.5..5.5).contains(&semi(&lens, 1)), "{}", semi(&lens, 1));
}

#[test]
fn dummy_surfaces_go_and_field_stops_stay() {
    let dummy = "SURF 2\n  CURV 0\n  DISZ 90\n  DIAM 8 1\nSURF 3\n  CURV 0\n  DISZ -40\n  DIAM 9\nSURF 4\n  CURV 0\n  DISZ 40\n  DIAM 9\nSURF 5\n";
    let with_dummies = ZMX.replace("SURF 2\n  CURV 0\n  DISZ 90\n  DIAM 8 1\nSURF 3\n", dummy);
    let lens = reading("a.zmx", &with_dummies);
    assert_eq!(lens.prescription.surfaces.len(), 2);
    assert_eq!(lens.prescription.surfaces[1].thickness_mm, 90.0);
    assert!(told(&lens, "SURF 3, SURF 4"));
    let limiting = with_dummies.replace("DISZ -40\n  DIAM 9", "DISZ 10\n  CLAP 0 9 0");
    assert_eq!(reading("a.zmx", &limiting).prescription.surfaces.len(), 3);
}

#[test]
fn pbrts_old_files_are_refused_by_their_first_gap() {
    let new = "# lens\n50 4 1.5168 16\n0 1 0 8\n-50 0 1 16\n";
    let lens = reading("a.dat", new);
    assert!(lens.prescription.surfaces[1].is_stop);
    assert!(told(&lens, "no dispersion") && told(&lens, "the last gap is"));
    let message = error("a.dat", "50 0 1.5168 16\n0 4 0 8\n-50 40 1 16\n");
    assert!(message.contains("a.dat:1") && message.contains("before the surfaces"), "{message}");
}

#[test]
fn orders_of_the_optical_bench() {
    let of = |constants: &str| {
        let text = format!(
            "[descriptive data]\ntitle\tUS 7,000,001 example 1\n[constants]\n{constants}[variable distances]\nFocal Length\t96.7\n\
             F-Number\t9.7\nAngle of View\t10\nImage Height\t17\nd2\t90\n[lens data]\n1\t50\t4\t1.5168\t16\t64.2\n2\tInfinity\td2\t\t16\n\
             3\tAS\t5\t\t30\n[aspherical data]\n1\t50\t-0.5\t1e-5\t1e-7\t1e-9\t1e-11\n"
        );
        reading("a.txt", &text)
    };
    let orders =
        |lens: &Reading| lens.prescription.surfaces[0].asphere.iter().map(|(order, _)| *order).collect::<Vec<_>>();
    assert_eq!(orders(&of("")), [4, 6, 8, 10]);
    assert_eq!(orders(&of("AsphericalA2\n")), [2, 4, 6, 8]);
    assert_eq!(orders(&of("AsphericalOddCount\t1\n")), [3, 4, 6, 8]);
    assert_eq!(orders(&of("AsphericalOddCount\t2\n")), [3, 4, 5, 6]);
    let lens = of("");
    assert_eq!(lens.prescription.surfaces[0].conic, -0.5);
    // Diameters and full angles.
    assert_eq!(lens.prescription.surfaces[0].semi_aperture_mm, Some(8.0));
    assert_eq!(lens.prescription.claims.half_field_deg, Some(5.0));
    assert_eq!(lens.prescription.claims.image_half_diagonal_mm, Some(8.5));
    assert_eq!(lens.prescription.patent.as_deref(), Some("US 7,000,001"));
    assert!((efl(&lens) - 50.0 / 0.5168).abs() < 0.01);
}

#[test]
fn the_optical_bench_leaves_undefined_what_a_patent_does_not_say() {
    let text = "[variable distances]\nFocal Length\t96.7\tundefined\nF-Number\t9.7\tundefined\nAngle of View\t10\tundefined\n\
                Total Length\tundefined\tundefined\nP\t1\t2\t3\nd0\tInfinity\t900\nd2\t90\t100\n[lens data]\n\
                1\t50\t4\t1.5168\t16\t64.2\n2\tInfinity\td2\t\t16\n3\tAS\t5\t\t30\n";
    let lens = reading("a.txt", text);
    let labels: Vec<_> = lens.prescription.positions.iter().map(|position| position.label.as_str()).collect();
    assert_eq!(labels, ["96.7 mm", "object at 900 mm"]);
    assert_eq!(lens.prescription.claims.focal_length_mm, Some(96.7));
}

/// Columns of a zoom at infinity and at a distance: those at a distance belong to those at infinity by what the file says, or
/// in turn; what leaves that open is refused.
#[test]
fn the_optical_bench_has_columns_of_zoom_and_of_focus() {
    let of = |focal_lengths: &str, d0: &str, d2: &str, d4: &str| {
        format!(
            "[variable distances]\nFocal Length\t{focal_lengths}\nd0\t{d0}\nd2\t{d2}\nd4\t{d4}\n[lens data]\n\
             1\t100\t4\t1.5168\t16\t64.2\n2\tInfinity\td2\t\t16\n3\t80\t4\t1.5168\t16\t64.2\n4\tInfinity\td4\t\t16\n\
             5\tAS\t40\t\t10\n"
        )
    };
    // Two thin lenses of 193.5 and 154.8 mm, so far apart: 86 to 99 mm or so.
    let (d0, d2, d4) = ("Infinity\tInfinity\t900\t900", "1\t40\t3\t44", "20\t20\t25\t25");
    let stated = reading("a.txt", &of("86.6\t98.3\t98.3\t86.6", d0, d2, d4)).prescription;
    let of_near = |positions: &[Position]| positions[2..].iter().map(|p| p.focal_length_mm).collect::<Vec<_>>();
    assert_eq!(of_near(&stated.positions), [Some(98.3), Some(86.6)]);
    let lens = reading("a.txt", &of("86.6\t98.3\tundefined\tundefined", d0, d2, d4));
    let in_turn: Vec<f64> = of_near(&lens.prescription.positions).into_iter().flatten().collect();
    assert!(in_turn.len() == 2 && in_turn[0] < 90.0 && in_turn[1] > 95.0, "{in_turn:?}");
    assert!(told(&lens, "by their order: object at 900 mm to 8"), "{:?}", lens.report.assumed);
    // Our own file says it.
    let own = reading("a.toml", &files::to_toml(&lens.prescription));
    assert_eq!(own.prescription.positions, lens.prescription.positions);
    let odd = of("86.6\t98.3\tundefined", "Infinity\tInfinity\t900", "1\t40\t3", "20\t20\t25");
    let error = files::read(odd.as_bytes(), "a.txt".as_ref()).expect_err("refused").to_string();
    assert!(error.contains("2 positions at infinity and 1 at a distance, and nothing says"), "{error}");
}

#[test]
fn what_a_file_claims_and_its_lens_does_not_keep_is_warned_of() {
    let claim = "unit = \"mm\"\nfocal_length = 100\nsurfaces = [{ radius = 50, thickness = 4, glass = \"N-BK7\", semi_aperture = 8, stop = true },\
                 { thickness = 94, semi_aperture = 8 }]\n";
    let lens = reading("a.toml", claim);
    assert!(told(&lens, "the focal length is 96.7") && told(&lens, "claims 100 mm"), "{:?}", lens.report.warnings);
    let kept = reading("a.toml", &claim.replace("focal_length = 100", "focal_length = 97"));
    assert_eq!(kept.report.warnings, Vec::<String>::new());
}

#[test]
fn a_wrong_abbe_number_shows_in_the_axial_colour() {
    // The EF 50 mm of DeepLens' file has 25.6 for a glass of 32.1, which leaves 0.27 mm of axial colour.
    let reference = super::reference("canon-ef50");
    assert!(!told(&reference, "foci of F and C"), "{:?}", reference.report.warnings);
    let toml = files::to_toml(&reference.prescription);
    let at = toml.find("[glasses.\"1.6727").expect("the glass");
    let end = at + toml[at..].find("source").expect("its end");
    let wrong = format!("{}[glasses.\"1.6727/32.1\"]\nnd = 1.6727\nvd = 25.6\n{}", &toml[..at], &toml[end..]);
    let lens = reading("a.toml", &wrong);
    assert!(told(&lens, "look for a wrong Abbe number"), "{:?}", lens.report.warnings);
}

#[test]
fn a_shifted_asphere_order_shows_in_the_distortion() {
    let phone = super::reference("phone-us7535658");
    assert!(!told(&phone, "distortion"), "{:?}", phone.report.warnings);
    let mut shifted = phone.prescription.clone();
    for (order, _) in shifted.surfaces.iter_mut().skip(5).flat_map(|surface| &mut surface.asphere) {
        *order += 1;
    }
    let toml = files::to_toml(&shifted);
    let lens = files::read(toml.as_bytes(), "a.toml".as_ref());
    let told = lens.map_or_else(|error| error.to_string(), |lens| lens.report.warnings.join("; "));
    assert!(told.contains("distortion") || told.contains("folds") || told.contains("runs through"), "{told}");
}
