use photosite_core::math::chi_squared::survival;
use photosite_core::math::statistics::{chi_squared, kolmogorov_smirnov, kolmogorov_smirnov_p_value};
use serde_json::json;

use super::super::SamplingDescription;
use super::*;

const FRAMES: u32 = 4000;

/// Significance level: at fixed seeds nothing fails by chance, so a smaller p-value is a mistake.
const LEAST_P: f64 = 1e-4;

fn distribution(d: Value) -> ValueDistribution {
    let d: VariationDescription = serde_json::from_value(d).expect("a description");
    match VariationDistribution::new(&d, &["a.png".to_owned(), "b.png".to_owned()]).expect("a distribution") {
        VariationDistribution::Value(distribution) => distribution,
        VariationDistribution::Choices(_) | VariationDistribution::Count(_) => panic!("no value"),
    }
}

fn drawn(d: &Value, sampling: SamplingDescription) -> Vec<String> {
    let distribution = distribution(d.clone());
    (0..FRAMES).map(|frame| distribution.draw(&mut Draws::new(sampling, 21, frame, FRAMES), frame, FRAMES)).collect()
}

fn vectors(d: &Value, sampling: SamplingDescription) -> Vec<Vec<f64>> {
    drawn(d, sampling).iter().map(|text| serde_json::from_str(text).expect("numbers")).collect()
}

fn samplings() -> [SamplingDescription; 2] {
    [SamplingDescription::Independent, SamplingDescription::LatinHypercube]
}

/// Probability of numbers that are farther from a uniform distribution between 0 and 1.
fn p_of_even(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    kolmogorov_smirnov_p_value(kolmogorov_smirnov(&values, |u| u.clamp(0.0, 1.0)), values.len())
}

#[test]
fn numbers_follow_their_laws() {
    for sampling in samplings() {
        let numbers = |d: Value| drawn(&d, sampling).into_iter().map(|text| text.parse::<f64>().expect("a number"));
        assert!(p_of_even(numbers(json!({ "uniform": [-2, 6] })).map(|x| (x + 2.0) / 8.0)) > LEAST_P);
        let logs = numbers(json!({ "log_uniform": [0.01, 100] })).map(|x| (x.log10() + 2.0) / 4.0);
        assert!(p_of_even(logs) > LEAST_P);
        let normal = numbers(json!({ "normal": [20, 3] })).map(|x| photosite_core::math::normal::cdf((x - 20.0) / 3.0));
        assert!(p_of_even(normal) > LEAST_P);
        let sweep: Vec<f64> = numbers(json!({ "sweep": [1, 3] })).collect();
        assert_eq!((sweep[0], sweep[sweep.len() - 1]), (1.0, 3.0));
        assert!(sweep.windows(2).all(|pair| pair[0] < pair[1]));
    }
}

#[test]
fn things_are_drawn_by_their_weights() {
    for (d, weights) in [
        (json!({ "choice": ["a", "b", "c"] }), vec![1.0, 1.0, 1.0]),
        (json!({ "choice": ["a", "b", "c"], "weights": [5, 0, 3] }), vec![5.0, 0.0, 3.0]),
        (json!({ "files": "*.png", "weights": [0.1, 0.9] }), vec![0.1, 0.9]),
    ] {
        for sampling in samplings() {
            let all = drawn(&d, sampling);
            let names =
                if weights.len() == 2 { vec!["\"a.png\"", "\"b.png\""] } else { vec!["\"a\"", "\"b\"", "\"c\""] };
            let sum: f64 = weights.iter().sum();
            let counts: Vec<f64> = names.iter().map(|name| all.iter().filter(|x| x == name).count() as f64).collect();
            assert_eq!(counts.iter().sum::<f64>(), f64::from(FRAMES));
            let expected: Vec<f64> = weights.iter().map(|weight| weight / sum * f64::from(FRAMES)).collect();
            let possible: Vec<usize> = (0..weights.len()).filter(|&i| weights[i] > 0.0).collect();
            assert!((0..weights.len()).all(|i| possible.contains(&i) || counts[i] == 0.0));
            let of = |numbers: &[f64]| possible.iter().map(|&i| numbers[i]).collect::<Vec<_>>();
            let (statistic, freedom) = chi_squared(&of(&counts), &of(&expected));
            assert!(survival(statistic, f64::from(freedom)) > LEAST_P, "{d} {sampling:?}: {counts:?}");
            if sampling == SamplingDescription::LatinHypercube {
                assert!(counts.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 2.0), "{counts:?}");
            }
        }
    }
}

#[test]
fn points_fill_boxes_spheres_and_shells() {
    for sampling in samplings() {
        let points = vectors(&json!({ "box": [[-1, 0, 5], [1, 4, 5]] }), sampling);
        assert!(p_of_even(points.iter().map(|p| (p[0] + 1.0) / 2.0)) > LEAST_P);
        assert!(p_of_even(points.iter().map(|p| p[1] / 4.0)) > LEAST_P);
        assert!(points.iter().all(|p| p.len() == 3 && p[2] == 5.0));
        // Archimedes: each coordinate of even points of a sphere is even.
        let points = vectors(&json!({ "sphere": {} }), sampling);
        for axis in 0..3 {
            assert!(p_of_even(points.iter().map(|p| (p[axis] + 1.0) / 2.0)) > LEAST_P, "{axis}");
        }
        let length = |p: &[f64]| p.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(points.iter().all(|p| (length(p) - 1.0).abs() < 1e-12));
        let shell =
            json!({ "sphere": { "center_m": [1, 2, 3], "radius_m": [1, 3], "up": [0, 0, 2], "angle_deg": [0, 60] } });
        let points = vectors(&shell, sampling);
        let offset = |p: &Vec<f64>| [p[0] - 1.0, p[1] - 2.0, p[2] - 3.0];
        assert!(p_of_even(points.iter().map(|p| (length(&offset(p)).powi(3) - 1.0) / 26.0)) > LEAST_P);
        let cosine = |p: &Vec<f64>| offset(p)[2] / length(&offset(p));
        assert!(points.iter().all(|p| cosine(p) > 0.5 - 1e-12));
        assert!(p_of_even(points.iter().map(|p| (cosine(p) - 0.5) / 0.5)) > LEAST_P);
    }
}

#[test]
fn rotations_are_even() {
    for sampling in samplings() {
        let turns = vectors(&json!({ "rotation": {} }), sampling);
        assert!(turns.iter().all(|q| (q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12));
        // Haar measure: each axis is sent evenly over the sphere, and the angle has the density (1 − cos a)/π.
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let sent = |q: &Vec<f64>| DQuat::from_xyzw(q[1], q[2], q[3], q[0]) * axis;
            for to in [DVec3::X, DVec3::Y, DVec3::Z] {
                assert!(p_of_even(turns.iter().map(|q| (sent(q).dot(to) + 1.0) / 2.0)) > LEAST_P, "{axis} {to}");
            }
        }
        let part = |q: &Vec<f64>| {
            let angle = 2.0 * q[0].abs().min(1.0).acos();
            (angle - angle.sin()) / std::f64::consts::PI
        };
        assert!(p_of_even(turns.iter().map(part)) > LEAST_P);
        let turns = vectors(&json!({ "rotation": { "axis": [0, 2, 0], "angle_deg": [-90, 90] } }), sampling);
        let angle = |q: &Vec<f64>| 2.0 * q[2].atan2(q[0]).to_degrees();
        assert!(turns.iter().all(|q| q[1] == 0.0 && q[3] == 0.0));
        assert!(p_of_even(turns.iter().map(|q| (angle(q) + 90.0) / 180.0)) > LEAST_P);
    }
}

#[test]
fn colours_are_even_in_hue_saturation_and_value() {
    for (hsv, rgb) in [
        ([0.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
        ([360.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
        ([-120.0, 1.0, 0.5], [0.0, 0.0, 0.5]),
        ([60.0, 0.5, 0.8], [0.8, 0.8, 0.4]),
        ([210.0, 0.0, 0.3], [0.3, 0.3, 0.3]),
        // colorsys.hsv_to_rgb(210/360, 0.25, 0.4) of Python
        ([210.0, 0.25, 0.4], [0.3, 0.35, 0.4]),
    ] {
        let found = rgb_of_hsv(hsv);
        assert!(found.iter().zip(rgb).all(|(a, b)| (a - b).abs() < 1e-12), "{hsv:?}: {found:?}");
    }
    let d = json!({ "hsv": { "hue_deg": [90, 150], "saturation": [0.5, 1], "value": [0.2, 0.8] } });
    for sampling in samplings() {
        let colours = vectors(&d, sampling);
        assert!(p_of_even(colours.iter().map(|c| (c[1] - 0.2) / 0.6)) > LEAST_P);
        let saturation = |c: &Vec<f64>| 1.0 - c[0].min(c[2]) / c[1];
        assert!(p_of_even(colours.iter().map(|c| (saturation(c) - 0.5) / 0.5)) > LEAST_P);
    }
}
