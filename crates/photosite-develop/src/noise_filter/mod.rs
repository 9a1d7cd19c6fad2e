//! Noise filters, one file each. In and out: demosaicked, white-balanced planes.
//!
//! Filters that tell noise from detail work on values f whose noise has a standard deviation of 1 everywhere
//! ([`stabilise`]).

mod bilateral;
mod mean;
mod median;
mod non_local_means;
mod stabilise;

use super::choices::NoiseFilter;
use super::settings::DevelopSettings;
use super::window::{gaussian_weights, separable};
use photosite_core::image::Planes;
use stabilise::NoiseModel;

/// Smooths every plane. `profile` holds (S, O) of each channel's variance S·x + O before white balance, or is empty.
pub(super) fn apply(image: &mut Planes, settings: &DevelopSettings, profile: &[[f64; 2]], neutral: &[f64]) {
    let radius = settings.noise_radius_px();
    match settings.noise_filter {
        NoiseFilter::None => {}
        NoiseFilter::Mean => for_planes(image, |plane, size| mean::filter(plane, size, radius)),
        NoiseFilter::Gaussian => {
            let weights = gaussian_weights(settings.noise_sigma_px(), radius);
            for_planes(image, |plane, size| separable(plane, size, [&weights; 2]));
        }
        NoiseFilter::Median => for_planes(image, |plane, size| median::filter(plane, size, radius)),
        NoiseFilter::Bilateral => {
            let sigma_px = settings.noise_sigma_px() as f32;
            if let Some(sigma) = settings.noise_sigma_range {
                let size = [image.width(), image.height()];
                let filtered = bilateral::by_difference(&taken(image), size, radius, sigma_px, sigma as f32);
                image.channels_mut().iter_mut().zip(filtered).for_each(|(channel, plane)| channel.data = plane);
            } else {
                stabilised(image, profile, neutral, |planes, size| {
                    bilateral::by_noise(planes, size, radius, sigma_px, settings.noise_strength() as f32)
                });
            }
        }
        NoiseFilter::NonLocalMeans => {
            stabilised(image, profile, neutral, |planes, size| {
                non_local_means::filter(planes, size, radius, settings.noise_strength() as f32)
            });
        }
    }
}

fn for_planes(image: &mut Planes, filter: impl Fn(&[f32], [usize; 2]) -> Vec<f32>) {
    let size = [image.width(), image.height()];
    for channel in image.channels_mut() {
        channel.data = filter(&channel.data, size);
    }
}

/// Values of all planes, moved out.
fn taken(image: &mut Planes) -> Vec<Vec<f32>> {
    image.channels_mut().iter_mut().map(|channel| std::mem::take(&mut channel.data)).collect()
}

/// Filters all planes together where their noise has a standard deviation of 1.
fn stabilised(
    image: &mut Planes,
    profile: &[[f64; 2]],
    neutral: &[f64],
    filter: impl FnOnce(&[Vec<f32>], [usize; 2]) -> Vec<Vec<f32>>,
) {
    let size = [image.width(), image.height()];
    let model = |(c, plane): (usize, &Vec<f32>)| {
        let balance = neutral.get(c).copied().unwrap_or(1.0);
        match profile.get(c).or(profile.first()) {
            Some(&[s, o]) if s >= 0.0 && o >= 0.0 && s + o > 0.0 => NoiseModel::new(s / balance, o / balance.powi(2)),
            Some(_) | None => NoiseModel::estimated(plane, size),
        }
    };
    let planes = taken(image);
    let models: Vec<NoiseModel> = planes.iter().enumerate().map(model).collect();
    let forward: Vec<Vec<f32>> = planes.into_iter().zip(&models).map(|(plane, model)| model.forward(plane)).collect();
    let filtered = filter(&forward, size);
    for ((channel, plane), model) in image.channels_mut().iter_mut().zip(filtered).zip(&models) {
        channel.data = model.inverse(plane);
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_distr::StandardNormal;

    use super::*;
    use photosite_core::image::Channel;
    use photosite_core::math::philox::Philox;
    use photosite_core::math::statistics::Moments;

    const FILTERS: [NoiseFilter; 5] = [
        NoiseFilter::Mean,
        NoiseFilter::Gaussian,
        NoiseFilter::Median,
        NoiseFilter::Bilateral,
        NoiseFilter::NonLocalMeans,
    ];
    const N: usize = 96;
    const S: f64 = 4e-4;
    const O: f64 = 1e-6;

    /// Dark on the left, bright on the right, with shot and read noise.
    fn noisy() -> Planes {
        let mut random = Philox::new(5, 0);
        let mut value = |i: usize| {
            let x: f64 = if i % N < N / 2 { 0.1 } else { 0.6 };
            (x + (S * x + O).sqrt() * random.sample::<f64, _>(StandardNormal)) as f32
        };
        let mut plane = |name: &str| Channel { name: name.to_owned(), data: (0..N * N).map(&mut value).collect() };
        let channels = ["R", "G", "B"].map(&mut plane).into();
        Planes::new(N, N, channels).expect("right sizes")
    }

    fn moments(image: &Planes, columns: std::ops::Range<usize>) -> Moments {
        let inside = |i: &usize| columns.contains(&(i % N));
        image.channels().iter().flat_map(|c| (0..N * N).filter(inside).map(|i| f64::from(c.data[i]))).collect()
    }

    #[test]
    fn filters_keep_means_and_lessen_noise() {
        for noise_filter in FILTERS {
            let settings = DevelopSettings { noise_filter, ..DevelopSettings::default() };
            let (before, mut after) = (noisy(), noisy());
            apply(&mut after, &settings, &[[S, O]; 3], &[1.0; 3]);
            for columns in [4..N / 2 - 8, N / 2 + 8..N - 4] {
                let [noise, left] = [&before, &after].map(|image| moments(image, columns.clone()));
                // The mean of 11 000 pixels is known to a hundredth of the noise; filters spread pixels a few times.
                let error = (left.mean() - noise.mean()) / noise.variance().sqrt();
                assert!(error.abs() < 0.05, "{noise_filter:?}: mean {error} standard deviations away");
                let part = (left.variance() / noise.variance()).sqrt();
                println!("{noise_filter:?}: {part:.3} of the noise left");
                assert!(part < 0.65, "{noise_filter:?}: {part} of the noise left");
            }
        }
    }

    #[test]
    fn filters_that_know_noise_keep_edges() {
        for (noise_filter, keeps) in FILTERS.into_iter().zip([false, false, true, true, true]) {
            let settings = DevelopSettings { noise_filter, ..DevelopSettings::default() };
            let mut after = noisy();
            apply(&mut after, &settings, &[[S, O]; 3], &[1.0; 3]);
            let [dark, bright] = [N / 2 - 1, N / 2].map(|x| moments(&after, x..x + 1).mean());
            assert_eq!(bright - dark > 0.9 * 0.5, keeps, "{noise_filter:?}: {dark} | {bright}");
        }
    }

    #[test]
    fn small_images_and_files_without_a_noise_profile() {
        for noise_filter in FILTERS {
            for (width, height) in [(1, 1), (3, 2), (1, 7)] {
                let channel = Channel { name: "Y".to_owned(), data: vec![0.25; width * height] };
                let mut image = Planes::new(width, height, vec![channel]).expect("right sizes");
                let settings = DevelopSettings { noise_filter, ..DevelopSettings::default() };
                apply(&mut image, &settings, &[], &[]);
                let wrong = image.channels()[0].data.iter().find(|v| (**v - 0.25).abs() > 1e-5);
                assert_eq!(wrong, None, "{noise_filter:?} {width} × {height}");
            }
        }
    }
}
