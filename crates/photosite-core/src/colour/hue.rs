//! HSV, HSL and HSI: RGB in terms of hue. RGB lies in 0 to 1 and is usually encoded. Hue is in degrees from 0 to below
//! 360, and 0 for greys; saturation, value, lightness and intensity lie in 0 to 1.

use glam::DVec3;

/// RGB → hue, saturation, value = max(R, G, B) ([Smith78](crate::references#smith78)).
pub fn rgb_to_hsv(rgb: DVec3) -> DVec3 {
    let (value, range) = (rgb.max_element(), rgb.max_element() - rgb.min_element());
    DVec3::new(hexagonal_hue(rgb), if value > 0.0 { range / value } else { 0.0 }, value)
}

/// Hue, saturation, value → RGB.
pub fn hsv_to_rgb(hsv: DVec3) -> DVec3 {
    let DVec3 { x: hue, y: saturation, z: value } = hsv;
    value * (DVec3::ONE + saturation * (pure(hue) - DVec3::ONE))
}

/// RGB → hue, saturation, lightness = (max + min)/2 ([Joblove78](crate::references#joblove78)).
pub fn rgb_to_hsl(rgb: DVec3) -> DVec3 {
    let (sum, range) = (rgb.max_element() + rgb.min_element(), rgb.max_element() - rgb.min_element());
    let room = 1.0 - (sum - 1.0).abs();
    DVec3::new(hexagonal_hue(rgb), if room > 0.0 { range / room } else { 0.0 }, 0.5 * sum)
}

/// Hue, saturation, lightness → RGB.
pub fn hsl_to_rgb(hsl: DVec3) -> DVec3 {
    let DVec3 { x: hue, y: saturation, z: lightness } = hsl;
    let chroma = saturation * (1.0 - (2.0 * lightness - 1.0).abs());
    DVec3::splat(lightness) + chroma * (pure(hue) - DVec3::splat(0.5))
}

/// RGB → hue, saturation = 1 − min/I, intensity I = (R + G + B)/3 ([Gonzalez18](crate::references#gonzalez18),
/// eqs. 7-16 to 7-19). The hue is the angle around the grey axis.
pub fn rgb_to_hsi(rgb: DVec3) -> DVec3 {
    let intensity = rgb.element_sum() / 3.0;
    let saturation = if intensity > 0.0 { 1.0 - rgb.min_element() / intensity } else { 0.0 };
    // The two axes across the grey one; the arc cosine of the reference loses digits near 0° and 180°.
    let (red, green_over_blue) = (2.0 * rgb.x - rgb.y - rgb.z, 3f64.sqrt() * (rgb.y - rgb.z));
    DVec3::new(wrapped(green_over_blue.atan2(red).to_degrees()), saturation, intensity)
}

/// Hue, saturation, intensity → RGB ([Gonzalez18](crate::references#gonzalez18), eqs. 7-20 to 7-28).
pub fn hsi_to_rgb(hsi: DVec3) -> DVec3 {
    let DVec3 { x: hue, y: saturation, z: intensity } = hsi;
    let sector = hue.rem_euclid(360.0) / 120.0;
    let within = (sector.fract() * 120.0).to_radians();
    let least = intensity * (1.0 - saturation);
    let leading = intensity * (1.0 + saturation * within.cos() / (60f64.to_radians() - within).cos());
    let following = 3.0 * intensity - least - leading;
    if sector < 1.0 {
        DVec3::new(leading, following, least)
    } else if sector < 2.0 {
        DVec3::new(least, leading, following)
    } else {
        DVec3::new(following, least, leading)
    }
}

/// The hue along the edges of a hexagon with red at 0°, yellow at 60° and so on.
fn hexagonal_hue(rgb: DVec3) -> f64 {
    let DVec3 { x: r, y: g, z: b } = rgb;
    let (max, range) = (rgb.max_element(), rgb.max_element() - rgb.min_element());
    if range == 0.0 {
        return 0.0;
    }
    let sixths = if max == r {
        (g - b) / range
    } else if max == g {
        2.0 + (b - r) / range
    } else {
        4.0 + (r - g) / range
    };
    wrapped(60.0 * sixths)
}

/// Angle in degrees, brought into the range from 0 to below 360.
fn wrapped(degrees: f64) -> f64 {
    // The remainder of a tiny negative angle rounds to 360.
    let positive = degrees.rem_euclid(360.0);
    if positive < 360.0 { positive } else { 0.0 }
}

/// The brightest and purest colour of a hue: components from 0 to 1.
fn pure(hue: f64) -> DVec3 {
    let distance = |from: f64| ((hue / 60.0 + from).rem_euclid(6.0) - 3.0).abs();
    DVec3::new(distance(0.0) - 1.0, 2.0 - distance(1.0), 2.0 - distance(-1.0)).clamp(DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn primaries_and_greys() {
        let hues = [([1, 0, 0], 0.0), ([1, 1, 0], 60.0), ([0, 1, 0], 120.0), ([0, 1, 1], 180.0), ([0, 0, 1], 240.0)];
        for (rgb, hue) in hues.into_iter().chain([([1, 0, 1], 300.0)]) {
            let rgb = DVec3::from_array(rgb.map(f64::from));
            assert_eq!(rgb_to_hsv(rgb), DVec3::new(hue, 1.0, 1.0));
            assert_eq!(rgb_to_hsl(rgb), DVec3::new(hue, 1.0, 0.5));
            let hsi = rgb_to_hsi(rgb);
            assert!((hsi.x - hue).abs() < 1e-12 && (hsi.z - rgb.element_sum() / 3.0).abs() < 1e-12, "{hsi}");
        }
        for grey in [0.0, 0.4, 1.0] {
            let found = [rgb_to_hsv, rgb_to_hsl, rgb_to_hsi].map(|of| of(DVec3::splat(grey)));
            assert!(found.iter().all(|hs| hs.abs_diff_eq(DVec3::new(0.0, 0.0, grey), 1e-15)), "{found:?}");
        }
    }

    proptest! {
        #[test]
        fn both_ways_undo_each_other(r in 0.0..1.0, g in 0.0..1.0, b in 0.0..1.0) {
            let rgb = DVec3::new(r, g, b);
            prop_assert!(hsv_to_rgb(rgb_to_hsv(rgb)).abs_diff_eq(rgb, 1e-12));
            prop_assert!(hsl_to_rgb(rgb_to_hsl(rgb)).abs_diff_eq(rgb, 1e-12));
            prop_assert!(hsi_to_rgb(rgb_to_hsi(rgb)).abs_diff_eq(rgb, 1e-12));
        }

        #[test]
        fn the_hue_of_hsi_is_the_arc_cosine_of_the_reference(r in 0.0..1.0, g in 0.0..1.0, b in 0.0..1.0) {
            let numerator = 0.5 * ((r - g) + (r - b));
            let denominator = f64::sqrt((r - g) * (r - g) + (r - b) * (g - b));
            let theta = f64::acos(f64::clamp(numerator / denominator, -1.0, 1.0)).to_degrees();
            let expected = if b <= g { theta } else { 360.0 - theta };
            let found = rgb_to_hsi(DVec3::new(r, g, b)).x;
            // Near 0° and 180° an arc cosine has half the digits.
            prop_assert!((found - expected).abs() < 1e-5 || (found - expected).abs() > 359.999_99, "{} {}", found, expected);
        }
    }
}
