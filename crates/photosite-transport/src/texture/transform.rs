//! Transforms of UVs that move, turn and scale them, as the glTF extension KHR_texture_transform does.

use glam::{Affine2, Mat2, Vec2};

/// KHR_texture_transform: uv' = T·R·S·uv.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Offset after rotation and scaling.
    pub offset: Vec2,
    /// Rotation, rad, counter-clockwise as the extension defines it: as one sees it with u to the right and v down.
    pub rotation_rad: f32,
    /// Scale along u and v.
    pub scale: Vec2,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation_rad: 0.0, scale: Vec2::ONE }
    }
}

impl UvTransform {
    /// The transformed UV: with (s, t) = scale·uv and the angle r, (s·cos r + t·sin r, −s·sin r + t·cos r) + offset.
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        self.to_affine().transform_point2(uv)
    }

    /// Transform of the UVs as a matrix.
    pub fn to_affine(&self) -> Affine2 {
        let (sin, cos) = self.rotation_rad.sin_cos();
        let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        Affine2::from_mat2_translation(rotation * Mat2::from_diagonal(self.scale), self.offset)
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use glam::vec2;

    use super::*;

    #[test]
    fn the_default_changes_nothing() {
        assert_eq!(UvTransform::default().apply(vec2(0.3, -7.0)), vec2(0.3, -7.0));
    }

    #[test]
    fn the_examples_of_the_extension() {
        // "Utilizes only the lower left quadrant of the source image, rotated clockwise 90°": v points down.
        let quadrant = UvTransform { offset: vec2(0.0, 1.0), rotation_rad: FRAC_PI_2, scale: vec2(0.5, 0.5) };
        for (uv, expected) in [
            // The image's left bottom corner is seen at the top left, its left edge along the top.
            (vec2(0.0, 0.0), vec2(0.0, 1.0)),
            (vec2(1.0, 0.0), vec2(0.0, 0.5)),
            (vec2(0.0, 1.0), vec2(0.5, 1.0)),
            (vec2(1.0, 1.0), vec2(0.5, 0.5)),
        ] {
            assert!(quadrant.apply(uv).abs_diff_eq(expected, 1e-6), "{uv}");
        }
        // "Inverts the T axis".
        let inverted = UvTransform { offset: vec2(0.0, 1.0), rotation_rad: 0.0, scale: vec2(1.0, -1.0) };
        assert_eq!(inverted.apply(vec2(0.25, 0.25)), vec2(0.25, 0.75));
    }

    #[test]
    fn scale_comes_before_rotation_and_rotation_before_offset() {
        let transform = UvTransform { offset: vec2(10.0, 20.0), rotation_rad: FRAC_PI_2, scale: vec2(2.0, 3.0) };
        // (1, 1) → (2, 3) → (3, −2) → (13, 18).
        assert!(transform.apply(vec2(1.0, 1.0)).abs_diff_eq(vec2(13.0, 18.0), 1e-5));
    }
}
