//! scratch
use photosite_lens::files;
fn main() {
    for path in std::env::args().skip(1) {
        let bytes = std::fs::read(&path).unwrap();
        println!("=== {path}");
        match files::read(&bytes, path.as_ref()) {
            Ok(r) => {
                let f = r.lens.at(587.5618).first_order();
                println!(
                    "{:?} n={} efl={:.6} bfl={:.6} f/{:.4} claims {:?}",
                    r.prescription.name,
                    r.prescription.surfaces.len(),
                    f.efl_mm,
                    f.bfl_mm,
                    f.f_number,
                    r.prescription.claims
                );
                for a in &r.report.assumed {
                    println!("  assumed {a}")
                }
                for a in &r.report.ignored {
                    println!("  ignored {a}")
                }
                for a in &r.report.warnings {
                    println!("  WARN {a}")
                }
                println!(
                    "  aps {:?}",
                    r.prescription.surfaces.iter().map(|s| s.semi_aperture_mm.unwrap()).collect::<Vec<_>>()
                );
                let toml = files::to_toml(&r.prescription);
                match files::read(toml.as_bytes(), "x.toml".as_ref()) {
                    Ok(again) => {
                        if again.prescription != r.prescription {
                            println!("  NOT THE SAME AGAIN");
                        }
                    }
                    Err(e) => println!("  AGAIN {e:?}\n{toml}"),
                }
            }
            Err(e) => println!("ERR {e}\n   help {:?}", miette::Diagnostic::help(&e).map(|h| h.to_string())),
        }
    }
}
