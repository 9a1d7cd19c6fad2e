//! Spectral upsampling: reflectances and emission spectra for colours of textures and files, after
//! [JakobHanika19](crate::references#jakobhanika19).
//!
//! Linear sRGB becomes a smooth reflectance between 0 and 1 that has this colour under D65, or light of this colour as
//! a multiple of D65. Greys become constants. Of the infinitely many spectra of a colour this is a plausible one, not
//! the true one: where the light is far from D65, or the sensor far from the eye, a measured spectrum is worth more.
//! Beyond 360–830 nm the value at the nearer end holds.
//!
//! [`reflectance_polynomial`] is for textures, a table look-up good to about 0.002 in each channel; the functions that
//! give a [`Spectrum`] are for constants and exact.

mod fit;
mod polynomial;
mod table;

use glam::DVec3;

pub use polynomial::{RANGE_NM, SigmoidPolynomial};

use super::{Spectrum, illuminant};

/// A reflectance of this linear sRGB under D65. Channels are clamped to [0, 1]; NaN becomes 0.
#[inline]
pub fn reflectance_polynomial(rgb: [f32; 3]) -> SigmoidPolynomial {
    let rgb = rgb.map(within_unit);
    if rgb[0] == rgb[1] && rgb[1] == rgb[2] { SigmoidPolynomial::constant(rgb[0]) } else { table::look_up(rgb) }
}

/// Reflectance whose linear sRGB under D65 is met to 1e-5: the polynomial of [`reflectance_polynomial`] after a few
/// Newton steps.
pub fn precise_polynomial(rgb: [f32; 3]) -> SigmoidPolynomial {
    let rgb = rgb.map(within_unit);
    let guess = reflectance_polynomial(rgb);
    if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
        return guess;
    }
    let target = DVec3::from_array(rgb.map(f64::from));
    let fitted = fit::fit(target, guess.homogeneous().as_dvec4(), 20);
    SigmoidPolynomial::from_homogeneous(fitted.v.as_vec4())
}

/// A reflectance of this linear sRGB under D65 as a table; see [`precise_polynomial`].
pub fn reflectance_spectrum(rgb: [f32; 3]) -> Spectrum {
    precise_polynomial(rgb).to_spectrum()
}

/// Factor and polynomial of a colour without an upper bound: rgb = factor·S with S at most about ½, so that bright
/// saturated colours stay smooth ([pbrt4](crate::references#pbrt4) §4.6.6). Negative channels, infinite ones and NaN
/// become 0.
#[inline]
pub fn unbounded_polynomial(rgb: [f32; 3]) -> (f32, SigmoidPolynomial) {
    let (factor, rgb) = halved(rgb);
    (factor, reflectance_polynomial(rgb))
}

/// Light of this linear sRGB: factor·S(λ) times D65 in the scale of [`illuminant::d65`], so that (1, 1, 1) is D65
/// itself. Channels may be above 1.
pub fn rgb_illuminant(rgb: [f32; 3]) -> Spectrum {
    let (factor, rgb) = halved(rgb);
    reflectance_spectrum(rgb).product(illuminant::d65()).scale(f64::from(factor))
}

/// The table of fitted polynomials as plain data: the bits of b₀, b₁, b₂, w of each node, 32 along each of the three axes
/// of each of the three largest channels.
pub fn table_words() -> Vec<[u32; 4]> {
    table::nodes().iter().map(|node| node.to_array().map(f32::to_bits)).collect()
}

/// Channel clamped to [0, 1]; 0 for NaN.
#[inline]
fn within_unit(channel: f32) -> f32 {
    if channel > 0.0 { channel.min(1.0) } else { 0.0 }
}

/// Factor and colour of [`unbounded_polynomial`]: twice the largest channel, and the colour divided by it.
#[inline]
fn halved(rgb: [f32; 3]) -> (f32, [f32; 3]) {
    let rgb = rgb.map(|channel| if channel.is_finite() { channel.max(0.0) } else { 0.0 });
    let largest = rgb[0].max(rgb[1]).max(rgb[2]);
    if largest > 0.0 {
        ((2.0 * largest).min(f32::MAX), rgb.map(|channel| channel / largest * 0.5))
    } else {
        (0.0, [0.0; 3])
    }
}

/// The content of `assets/spectra/jakob-hanika-srgb.bin`, fitted anew, and the largest error of a channel relative to
/// its colour's largest channel; for `tests/tools/fit_upsampling.rs`.
#[doc(hidden)]
pub fn fit_table() -> (Vec<u8>, f64) {
    table::fit_all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::philox::philox4x32_10;
    use crate::spectrum::{Wavelengths, cie, rgb};

    /// Colours of the unit cube: half of them dark, as photographs are, a third of them on a face or an edge of the
    /// cube.
    fn colours(count: u32) -> impl Iterator<Item = [f32; 3]> {
        (0..count).map(|i| {
            let random = philox4x32_10([i, 0, 0, 0], [19, 0]);
            let uniform = [random[0], random[1], random[2]].map(|bits| (bits >> 8) as f32 / (1 << 24) as f32);
            let mut colour = if i % 2 == 0 { uniform } else { uniform.map(|v| v.powi(3)) };
            let choice = random[3] as usize;
            if i % 3 == 0 {
                colour[choice % 3] = (choice >> 8 & 1) as f32;
            }
            if i % 9 == 0 {
                colour[(choice + 1) % 3] = (choice >> 9 & 1) as f32;
            }
            colour
        })
    }

    /// Linear sRGB of light, 1 for the luminance of D65.
    fn seen(light: &Spectrum) -> [f64; 3] {
        let white = cie::xyz(illuminant::d65())[1];
        (*rgb::xyz_to_rgb() * DVec3::from_array(cie::xyz(light)) / white).to_array()
    }

    fn under_d65(reflectance: SigmoidPolynomial) -> [f64; 3] {
        seen(&reflectance.to_spectrum().product(illuminant::d65()))
    }

    fn distance(a: [f64; 3], b: [f32; 3]) -> f64 {
        (0..3).map(|i| (a[i] - f64::from(b[i])).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn looked_up_reflectances_have_their_colour() {
        let (mut worst, mut squares) = (0.0f64, 0.0);
        for colour in colours(6000) {
            let error = distance(under_d65(reflectance_polynomial(colour)), colour);
            worst = worst.max(error);
            squares += error * error;
        }
        let rms = (squares / 6000.0).sqrt();
        // Found when the table was laid out: 0.0020 at most, half a step of 8 bits, and 0.0005.
        assert!(worst < 0.0022 && rms < 0.0006, "max {worst}, rms {rms}");
    }

    #[test]
    fn precise_reflectances_meet_their_colour_to_1e_5() {
        // The fit converges to 1e-10; what is left are f32 coordinates, amplified where the polynomial is steep.
        for colour in colours(500) {
            let error = distance(seen(&reflectance_spectrum(colour).product(illuminant::d65())), colour);
            assert!(error < 1e-5, "{colour:?}: {error}");
        }
    }

    #[test]
    fn greys_are_constant() {
        for value in [0.0, 0.18, 0.5, 1.0] {
            let spectrum = reflectance_spectrum([value; 3]);
            assert_eq!(spectrum.min(), spectrum.max());
            assert!((spectrum.min() - value).abs() < 1e-7);
        }
    }

    #[test]
    fn light_has_its_colour_and_white_is_d65() {
        let white = rgb_illuminant([1.0; 3]);
        assert!(white.iter().zip(illuminant::d65().iter()).all(|((_, a), (_, b))| (a - b).abs() <= 1e-6 * b));
        for colour in [[30.0, 2.0, 0.0], [0.0, 0.0, 5e-4], [1e6, 9e5, 1e6]] {
            let largest = f64::from(colour.iter().copied().fold(0.0, f32::max));
            assert!(distance(seen(&rgb_illuminant(colour)), colour) < 2e-5 * largest, "{colour:?}");
            let (factor, shape) = unbounded_polynomial(colour);
            let looked_up = under_d65(shape).map(|channel| channel * f64::from(factor));
            assert!(distance(looked_up, colour) < 2.0 * 0.0022 * largest, "{colour:?}");
        }
        assert_eq!(rgb_illuminant([0.0; 3]).values(), Spectrum::constant(0.0).values());
    }

    #[test]
    fn no_colour_leads_outside_0_to_1() {
        let odd =
            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e-45, 1e-30, 0.5, 1.0, 1.0 + f32::EPSILON, 3e38];
        let n = odd.len();
        let odd = (0..n.pow(3)).map(|i| [odd[i % n], odd[i / n % n], odd[i / n / n]]);
        let lambda = Wavelengths::new([300.0, 480.0, 595.0, 1000.0], [1.0; 4]);
        for colour in odd.chain(colours(1000)) {
            let (factor, shape) = unbounded_polynomial(colour);
            assert!(factor >= 0.0);
            for polynomial in [reflectance_polynomial(colour), shape] {
                let lanes = polynomial.sample(&lambda).to_array();
                assert!(lanes.iter().all(|value| (0.0..=1.0).contains(value)), "{colour:?}: {lanes:?}");
            }
        }
    }
}
