//! Sharpening by an unsharp mask: v + a·(v − G_σ(v)), G_σ being a Gaussian of standard deviation σ.

use photosite_core::rows::for_each_row;

use super::window::{gaussian_weights, separable};
use photosite_core::image::Planes;

/// Sharpens every plane by the amount a, on values as they are shown.
pub(super) fn apply(image: &mut Planes, amount: f64, sigma_px: f64) {
    if amount == 0.0 {
        return;
    }
    let size = [image.width(), image.height()];
    let weights = gaussian_weights(sigma_px, (3.0 * sigma_px).ceil() as usize);
    let amount = amount as f32;
    for channel in image.channels_mut() {
        let smooth = separable(&channel.data, size, [&weights; 2]);
        for_each_row(&mut channel.data, size[0], |y, row| {
            let smooth = &smooth[y * size[0]..];
            row.iter_mut().zip(smooth).for_each(|(value, smooth)| *value += amount * (*value - smooth));
        });
    }
}
