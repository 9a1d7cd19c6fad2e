//! Colour differences between two colours given as (L\*, a\*, b\*).

use glam::DVec3;

/// ΔE\*ab of 1976: the distance in CIELAB ([Cie15](crate::references#cie15), 8.2.1.3).
pub fn delta_e_76(a: DVec3, b: DVec3) -> f64 {
    a.distance(b)
}

/// ΔE₉₄ with the weights of graphic arts; `reference` is the colour that the other is judged by
/// ([Cie15](crate::references#cie15), 8.3.1).
pub fn delta_e_94(reference: DVec3, sample: DVec3) -> f64 {
    let chroma = |lab: DVec3| lab.y.hypot(lab.z);
    let difference = reference - sample;
    let chroma_difference = chroma(reference) - chroma(sample);
    let hue_squared = (difference.y.powi(2) + difference.z.powi(2) - chroma_difference.powi(2)).max(0.0);
    let (s_c, s_h) = (1.0 + 0.045 * chroma(reference), 1.0 + 0.015 * chroma(reference));
    (difference.x.powi(2) + (chroma_difference / s_c).powi(2) + hue_squared / s_h.powi(2)).sqrt()
}

/// ΔE₀₀, CIEDE2000 with all parametric factors 1 ([Sharma05](crate::references#sharma05), eqs. 2–22).
pub fn delta_e_2000(a: DVec3, b: DVec3) -> f64 {
    let seventh = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let mean_chroma = 0.5 * (a.y.hypot(a.z) + b.y.hypot(b.z));
    let g = 0.5 * (1.0 - seventh(mean_chroma));
    let polar = |lab: DVec3| {
        let stretched = (1.0 + g) * lab.y;
        (stretched.hypot(lab.z), lab.z.atan2(stretched).to_degrees().rem_euclid(360.0))
    };
    let ((chroma_a, hue_a), (chroma_b, hue_b)) = (polar(a), polar(b));
    let grey = chroma_a * chroma_b == 0.0;
    // The shorter way around the circle of hues, and the middle of that way.
    let turn = hue_b - hue_a;
    let turn = match turn {
        _ if grey => 0.0,
        t if t > 180.0 => t - 360.0,
        t if t < -180.0 => t + 360.0,
        t => t,
    };
    let sum = hue_a + hue_b;
    let mean_hue = match (hue_a - hue_b).abs() {
        _ if grey => sum,
        apart if apart <= 180.0 => 0.5 * sum,
        _ if sum < 360.0 => 0.5 * (sum + 360.0),
        _ => 0.5 * (sum - 360.0),
    };
    let lightness = b.x - a.x;
    let chroma = chroma_b - chroma_a;
    let hue = 2.0 * (chroma_a * chroma_b).sqrt() * (0.5 * turn).to_radians().sin();
    let mean_lightness = 0.5 * (a.x + b.x);
    let mean_chroma = 0.5 * (chroma_a + chroma_b);
    let cosine = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cosine(mean_hue - 30.0) + 0.24 * cosine(2.0 * mean_hue) + 0.32 * cosine(3.0 * mean_hue + 6.0)
        - 0.20 * cosine(4.0 * mean_hue - 63.0);
    let off = (mean_lightness - 50.0).powi(2);
    let s_l = 1.0 + 0.015 * off / (20.0 + off).sqrt();
    let s_c = 1.0 + 0.045 * mean_chroma;
    let s_h = 1.0 + 0.015 * mean_chroma * t;
    let theta = 30.0 * (-((mean_hue - 275.0) / 25.0).powi(2)).exp();
    let r_t = -2.0 * seventh(mean_chroma) * (2.0 * theta).to_radians().sin();
    let (l, c, h) = (lightness / s_l, chroma / s_c, hue / s_h);
    (l * l + c * c + h * h + r_t * c * h).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of the table that accompanies [Sharma05](crate::references#sharma05), which are chosen to find mistakes:
    /// blue's rotation, greys without hue, hues on both sides of 0°, near black.
    const PAIRS: [([f64; 3], [f64; 3], f64); 8] = [
        ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
        ([50.0, -1.0, 2.0], [50.0, 0.0, 0.0], 2.3669),
        ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
        ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
        ([50.0, 2.5, 0.0], [56.0, -27.0, -3.0], 31.9030),
        ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
        ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
        ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
    ];

    #[test]
    fn the_published_pairs_have_their_published_difference() {
        for (a, b, expected) in PAIRS {
            let (a, b) = (DVec3::from_array(a), DVec3::from_array(b));
            for found in [delta_e_2000(a, b), delta_e_2000(b, a)] {
                // Published to four decimals.
                assert!((found - expected).abs() < 0.5e-4, "{a} {b}: {found}, published {expected}");
            }
        }
    }

    #[test]
    fn greys_differ_by_lightness_alone() {
        let (a, b) = (DVec3::new(50.0, 0.0, 0.0), DVec3::new(60.0, 0.0, 0.0));
        assert_eq!([delta_e_76(a, b), delta_e_94(a, b)], [10.0, 10.0]);
        // S_L of L̄ = 55: 1 + 0.015·25/√45.
        assert!((delta_e_2000(a, b) - 10.0 / (1.0 + 0.375 / 45f64.sqrt())).abs() < 1e-12);
        assert_eq!(delta_e_2000(a, a), 0.0);
    }

    #[test]
    fn chroma_counts_less_the_more_there_is_of_it() {
        // By hand: ΔC = 10 over 1 + 0.045·40; ΔH = 10 over 1 + 0.015·40, in which C stays (3-4-5 triangle scaled by
        // 10).
        let reference = DVec3::new(50.0, 40.0, 0.0);
        assert!((delta_e_94(reference, DVec3::new(50.0, 50.0, 0.0)) - 10.0 / 2.8).abs() < 1e-12);
        let turned = DVec3::new(50.0, 24.0, 32.0);
        let hue = reference.distance(turned);
        assert!((delta_e_94(reference, turned) - hue / 1.6).abs() < 1e-12);
    }
}
