//! Places of a chart's patches in an image, and the means of their pixels.

use photosite_core::Invalid;
use photosite_core::math::linear::solve;
use photosite_raw::RawImage;

/// Part of the distance between two patches, from the centre of each on, whose pixels count.
const REACH: f64 = 0.22;
/// Fewest pixels of a channel that a patch is measured by.
const FEWEST: usize = 16;

/// Patches in rows and columns of equal distances, seen in perspective.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartGrid {
    /// Columns and rows of patches.
    pub patches: [usize; 2],
    /// Centres of the patches in the corners, in pixels of the image, the centre of its first pixel at (0.5, 0.5): the
    /// first patch, the last of the first row, the last of all, and the first of the last row.
    pub corners_px: [[f64; 2]; 4],
}

/// Mean signal of a patch in a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchMean {
    /// Mean above the black level, DN.
    pub signal_dn: f64,
    /// Standard error of the mean, as the pixels vary, DN.
    pub standard_error_dn: f64,
    /// Number of pixels.
    pub pixels: usize,
    /// Number of them that are saturated.
    pub saturated: usize,
}

impl ChartGrid {
    /// Projective map from pixels to columns and rows of patches, of h = (h₀ … h₇):
    /// u = (h₀x + h₁y + h₂)/(h₆x + h₇y + 1), v = (h₃x + h₄y + h₅)/(h₆x + h₇y + 1).
    fn map(&self) -> Result<[f64; 8], Invalid> {
        let [columns, rows] = self.patches.map(|count| count as f64 - 1.0);
        let places = [[0.0, 0.0], [columns, 0.0], [columns, rows], [0.0, rows]];
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for ([x, y], [u, v]) in self.corners_px.into_iter().zip(places) {
            a.push(vec![x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y]);
            a.push(vec![0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y]);
            b.extend([u, v]);
        }
        let found = solve(a, b).filter(|h| self.is_convex() && h.iter().all(|value| value.is_finite()));
        found.and_then(|h| <[f64; 8]>::try_from(h).ok()).ok_or_else(|| {
            Invalid::new("corners", "do not go around the chart").help(
                "write the centres of the first patch, the last of its row, the last patch, and the first of its row",
            )
        })
    }

    /// Whether all turns along the corners go the same way.
    fn is_convex(&self) -> bool {
        let corner = |i: usize| self.corners_px[i % 4];
        let turn = |i: usize| {
            let [[ax, ay], [bx, by], [cx, cy]] = [corner(i), corner(i + 1), corner(i + 2)];
            (bx - ax) * (cy - by) - (by - ay) * (cx - bx)
        };
        (0..4).all(|i| turn(i) > 0.0) || (0..4).all(|i| turn(i) < 0.0)
    }
}

/// Sums over the pixels of a patch in a channel.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: usize,
    saturated: usize,
    sum: f64,
    squares: f64,
}

/// Means of all patches of a raw image whose values are linear: a list of channels for each patch, in the order of
/// reading and of the colour filter array.
///
/// # Errors
///
/// Corners that do not go around a chart, that lie outside the image, or patches of too few pixels.
pub fn patch_means(raw: &RawImage, grid: &ChartGrid) -> Result<Vec<Vec<PatchMean>>, Invalid> {
    let [columns, rows] = grid.patches;
    let h = grid.map()?;
    let size = [raw.width, raw.height];
    let is_outside = |corner: &[f64; 2]| (0..2).any(|axis| !(0.0..=size[axis] as f64).contains(&corner[axis]));
    if let Some([x, y]) = grid.corners_px.iter().find(|corner| is_outside(corner)) {
        let message = format!("{x}, {y} lies outside the image of {} × {} pixels", size[0], size[1]);
        return Err(Invalid::new("corners", message).help("columns and rows are counted from the top left corner"));
    }
    let (channels, samples) = (raw.cfa.channels().len(), raw.cfa.samples_per_pixel());
    let mut sums = vec![vec![Sums::default(); channels]; columns * rows];
    for (i, values) in raw.data.chunks_exact(samples).enumerate() {
        let (x, y) = (i % raw.width, i / raw.width);
        let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
        let depth = h[6] * px + h[7] * py + 1.0;
        let [u, v] = [(h[0] * px + h[1] * py + h[2]) / depth, (h[3] * px + h[4] * py + h[5]) / depth];
        let (column, row) = (u.round(), v.round());
        let is_of_patch = depth > 0.0
            && (0.0..columns as f64).contains(&column)
            && (0.0..rows as f64).contains(&row)
            && (u - column).abs() < REACH
            && (v - row).abs() < REACH;
        if !is_of_patch {
            continue;
        }
        let patch = &mut sums[row as usize * columns + column as usize];
        let black = f64::from(raw.black_level_dn.at(x, y));
        for (sample, &dn) in values.iter().enumerate() {
            let channel = if samples > 1 { sample } else { raw.cfa.channel_at(x, y) };
            let signal = f64::from(dn) - black;
            let sums = &mut patch[channel];
            sums.count += 1;
            sums.saturated += usize::from(dn >= raw.white_of(channel));
            sums.sum += signal;
            sums.squares += signal * signal;
        }
    }
    if let Some(patch) = sums.iter().position(|patch| patch.iter().any(|sums| sums.count < FEWEST)) {
        let least = sums[patch].iter().map(|sums| sums.count).min().unwrap_or(0);
        let message = format!("{least} pixels of a channel lie in patch {}, and {FEWEST} are needed", patch + 1);
        return Err(
            Invalid::new("corners", message).help("write the centres of the corner patches; take a larger image")
        );
    }
    let mean = |sums: &Sums| {
        let count = sums.count as f64;
        let mean = sums.sum / count;
        let variance = (sums.squares / count - mean * mean).max(0.0) * count / (count - 1.0);
        PatchMean {
            signal_dn: mean,
            standard_error_dn: (variance / count).sqrt(),
            pixels: sums.count,
            saturated: sums.saturated,
        }
    };
    Ok(sums.iter().map(|patch| patch.iter().map(mean).collect()).collect())
}

#[cfg(test)]
mod tests {
    use photosite_raw::{BlackLevel, Cfa};

    use super::*;

    /// A chart of 3 × 2 patches in perspective, whose patch i has 100·(i + 1) DN in the first channel and twice as much in the
    /// second.
    fn chart(grid: &ChartGrid) -> RawImage {
        let h = grid.map().expect("a map");
        let cfa = Cfa::parse("RGGB").expect("a pattern");
        let mut raw = RawImage::bare(120, 90, vec![64; 120 * 90], cfa, 4095);
        raw.black_level_dn = BlackLevel::uniform(64.0);
        for i in 0..raw.data.len() {
            let (x, y) = ((i % 120) as f64 + 0.5, (i / 120) as f64 + 0.5);
            let depth = h[6] * x + h[7] * y + 1.0;
            let [u, v] = [(h[0] * x + h[1] * y + h[2]) / depth, (h[3] * x + h[4] * y + h[5]) / depth];
            let (column, row) = (u.round(), v.round());
            if (0.0..3.0).contains(&column) && (0.0..2.0).contains(&row) && (u - column).abs() < 0.4 {
                let channel = raw.cfa.channel_at(i % 120, i / 120);
                raw.data[i] = 64 + 100 * (channel as u16 + 1) * (3 * row as u16 + column as u16 + 1);
            }
        }
        raw
    }

    const GRID: ChartGrid =
        ChartGrid { patches: [3, 2], corners_px: [[20.0, 18.0], [100.0, 25.0], [95.0, 70.0], [24.0, 66.0]] };

    #[test]
    fn patches_are_found_in_perspective() {
        let means = patch_means(&chart(&GRID), &GRID).expect("patches");
        assert_eq!(means.len(), 6);
        for (i, patch) in means.iter().enumerate() {
            for (channel, mean) in patch.iter().enumerate() {
                assert_eq!(mean.signal_dn, 100.0 * (channel + 1) as f64 * (i + 1) as f64, "{i} {channel} {mean:?}");
                assert!(mean.pixels >= FEWEST && mean.saturated == 0 && mean.standard_error_dn == 0.0);
            }
        }
    }

    #[test]
    fn corners_that_are_none_are_refused() {
        let with = |corners_px| patch_means(&chart(&GRID), &ChartGrid { corners_px, ..GRID }).expect_err("refused");
        let [a, b, c, d] = GRID.corners_px;
        assert!(with([a, c, b, d]).message.contains("do not go around"));
        assert!(with([a, b, [200.0, 70.0], d]).message.contains("200, 70 lies outside"));
        assert!(
            with([a, [30.0, 18.0], [30.0, 25.0], [20.0, 25.0]]).message.contains("pixels of a channel lie in patch")
        );
    }
}
