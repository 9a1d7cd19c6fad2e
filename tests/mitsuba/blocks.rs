//! Means of blocks of an image, which see a fault of a few percent in a part of it that single pixels are too noisy for.

use photosite::validation::ComparedImage;

const COLUMNS: usize = 4;
const ROWS: usize = 3;

/// The light of a block in two images.
#[derive(Debug)]
#[allow(dead_code, reason = "printed where a block fails")]
pub(super) struct Block {
    channel: String,
    column: usize,
    row: usize,
    /// Difference of the first from the second.
    pub(super) difference_percent: f64,
    pub(super) standard_error_percent: f64,
}

/// All blocks of all channels.
pub(super) fn blocks(ours: &ComparedImage, theirs: &ComparedImage) -> Vec<Block> {
    let (width, height) = (ours.mean.width(), ours.mean.height());
    let mut found = Vec::new();
    for channel in theirs.mean.channels() {
        let plane = |image: &ComparedImage, is_variance: bool| {
            let planes = if is_variance { &image.variance } else { &image.mean };
            planes.plane(&channel.name).expect("a channel of both").to_vec()
        };
        let [ours_mean, theirs_mean] = [ours, theirs].map(|image| plane(image, false));
        let variances = [ours, theirs].map(|image| plane(image, true));
        for (column, row) in (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (column, row))) {
            let sum = |data: &[f32]| -> f64 {
                let rows = row * height / ROWS..(row + 1) * height / ROWS;
                let columns = column * width / COLUMNS..(column + 1) * width / COLUMNS;
                rows.flat_map(|y| &data[y * width..][columns.clone()]).copied().map(f64::from).sum()
            };
            let light = sum(&theirs_mean) / 100.0;
            found.push(Block {
                channel: channel.name.clone(),
                column,
                row,
                difference_percent: (sum(&ours_mean) - sum(&theirs_mean)) / light,
                standard_error_percent: variances.iter().map(|data| sum(data)).sum::<f64>().sqrt() / light,
            });
        }
    }
    found
}
