//! Reflectances of coatings as the Python package tmm 0.2.0 computes them.

use crate::neutral::{list, number, numbers, read};
use photosite_core::spectrum::Dispersion;
use photosite_lens::coating::{Side, split};
use photosite_lens::prescription::{Layer, LayerIndex};

#[test]
fn reflectance_and_transmittance_of_three_coatings() {
    let bk7 = Dispersion::Sellmeier {
        b: vec![1.03961212, 0.231792344, 1.01046945],
        c_um2: vec![0.00600069867, 0.0200179144, 103.560653],
    };
    let mut compared = 0;
    for coating in list(&read("coatings")["coatings"]) {
        let layer = |pair: &serde_json::Value| Layer {
            index: LayerIndex::Constant { n: number(&pair[0]), k: 0.0 },
            thickness_nm: number(&pair[1]),
        };
        let layers: Vec<Layer> = list(&coating["layers_from_air_index_nm"]).iter().map(layer).collect();
        for value in list(&coating["values"]) {
            let (nm, degrees) = (number(&value["nm"]), number(&value["degrees"]));
            let glass = bk7.index(nm);
            let (from, index, behind) = match value["from"].as_str() {
                Some("air") => (Side::Air, 1.0, glass),
                Some("glass") => (Side::Glass, glass, 1.0),
                side => panic!("{side:?}"),
            };
            let found = split(&layers, from, index, behind, degrees.to_radians().cos(), nm);
            for (found, key) in [(found.reflectance, "R_s_p"), (found.transmittance, "T_s_p")] {
                for (found, expected) in found.into_iter().zip(numbers(&value[key])) {
                    assert!((found - expected).abs() < 1e-9, "{} {value}: {found}", coating["coating"]);
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, 3 * 12 * 4);
}
