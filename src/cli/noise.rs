//! `photosite noise`: estimates of the noise of pictures.

use std::path::{Path, PathBuf};

use clap::Args;
use photosite::characterisation::noise::{Knowledge, NoiseEstimate, Patch, Variance, estimate};
use photosite::io::picture_file::read_picture_file;
use photosite::raw::{Cfa, PixelArea, Pixels};
use photosite::validation::Picture;
use photosite::{Error, Invalid, Result};
use serde::Serialize;

use super::print::{print_json, println_out, rounded};

/// Estimate the noise of a picture, or of several of the same scene.
///
/// From several pictures: what changes from one to the next, and the fixed pattern under it. From one: what an even
/// patch spreads, what a plane leaves of a patch with linear shading. Colours of a mosaic are looked at one by one. Of
/// raw files that say which pixels see light (DNG, raw EXR) these alone are looked at.
#[derive(Args)]
pub(super) struct NoiseArgs {
    /// EXR, PNG, TIFF or raw files (DNG, PGM, NPY); several are taken to show the same scene.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Look at this part only: left, top, width and height in pixels, counted from the corner of the pixels that see
    /// light.
    #[arg(long, value_name = "X,Y,W,H", value_parser = rectangle)]
    patch: Option<[usize; 4]>,
    /// Look at the masked pixels of raw files, too; --patch counts from the corner of the file.
    #[arg(long)]
    masked: bool,
    /// Standard deviation that every pixel should have: the χ² of the plane is reported.
    #[arg(long, value_name = "X", value_parser = positive)]
    sigma: Option<f64>,
    /// Value of no light [default: the black level of a DNG, otherwise 0].
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    black: Option<f64>,
    /// How far to look for correlations, in pixels of one colour.
    #[arg(long, value_name = "PX", default_value_t = 4, value_parser = clap::value_parser!(u64).range(0..=256))]
    lags: u64,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// The object that `--json` prints.
#[derive(Serialize)]
struct Report {
    files: Vec<String>,
    /// Left, top, width, height, in the active area where there is one.
    patch_px: [usize; 4],
    /// The pixels of the file that are looked at, where masked ones are left out: left, top, width, height.
    active_area_px: Option<[usize; 4]>,
    unit: Option<String>,
    planes: Vec<PlaneReport>,
}

/// One channel, or the pixels of one place in the tile of a mosaic.
#[derive(Serialize)]
struct PlaneReport {
    name: String,
    #[serde(flatten)]
    estimate: NoiseEstimate,
}

/// A picture with what its file says of its numbers.
struct Input {
    picture: Picture,
    black: Option<f64>,
    white: Option<f64>,
    /// Distance between neighbouring numbers, where they are whole.
    step: Option<f64>,
}

pub(super) fn run(args: &NoiseArgs) -> Result<()> {
    let pixels = if args.masked { Pixels::All } else { Pixels::Active };
    let inputs: Vec<Input> = args.files.iter().map(|path| read(path, pixels)).collect::<Result<_>>()?;
    let size = |input: &Input| [input.picture.mean.width(), input.picture.mean.height()];
    let names = |input: &Input| input.picture.mean.channels().iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    let first = &inputs[0];
    for (input, path) in inputs.iter().zip(&args.files) {
        if size(input) != size(first) || names(input) != names(first) || input.picture.mosaic != first.picture.mosaic {
            return Err(Error::Usage {
                message: format!("{} differs from {} in size or channels", path.display(), args.files[0].display()),
                help: Some("several pictures must show the same scene, taken by the same camera".into()),
            });
        }
    }
    let [width, height] = size(first);
    let patch = args.patch.unwrap_or([0, 0, width, height]);
    let [x, y, w, h] = patch;
    let whole = if first.picture.active_area.is_some() { "active area" } else { "picture" };
    if x.checked_add(w).is_none_or(|end| end > width) || y.checked_add(h).is_none_or(|end| end > height) {
        return Err(Error::Usage {
            message: format!("the patch {x},{y},{w},{h} reaches beyond the {width} × {height} pixels of the {whole}"),
            help: Some("write left, top, width and height, for example --patch 100,100,64,64".into()),
        });
    }
    let known = Knowledge {
        black: args.black.or(first.black).unwrap_or(0.0),
        white: first.white,
        step: first.step,
        variance: args.sigma.map(|sigma| sigma * sigma),
    };
    let unfit = |Invalid { message, help, .. }| Error::Usage { message, help };
    let mut planes = Vec::new();
    for View { name, channel, offset, stride } in views(&first.picture) {
        let patches = inputs.iter().map(|input| {
            let values = &input.picture.mean.channels()[channel].data;
            let part = |start: usize, length: usize, offset: usize, stride: usize| {
                (start..start + length).filter(move |i| i % stride == offset)
            };
            let columns: Vec<usize> = part(x, w, offset[0], stride[0]).collect();
            let rows: Vec<usize> = part(y, h, offset[1], stride[1]).collect();
            let value = |row: &usize, column: &usize| f64::from(values[row * width + column]);
            let all = rows.iter().flat_map(|row| columns.iter().map(move |column| value(row, column))).collect();
            Patch::new(columns.len(), rows.len(), all)
        });
        let patches: Vec<Patch> = patches.collect::<Result<_, _>>().map_err(unfit)?;
        let estimate = estimate(&patches, &known, args.lags as usize).map_err(unfit)?;
        planes.push(PlaneReport { name, estimate });
    }
    let files = args.files.iter().map(|path| path.display().to_string()).collect();
    let active_area_px = first.picture.active_area.map(|PixelArea { x, y, width, height }| [x, y, width, height]);
    let report = Report { files, patch_px: patch, active_area_px, unit: first.picture.unit.clone(), planes };
    if args.json { print_json(&report) } else { println_out(&text(&report)) }
}

fn read(path: &Path, pixels: Pixels) -> Result<Input> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("dng")) {
        let picture = read_picture_file(path, pixels)?;
        let (white, step) = (picture.full_scale, picture.full_scale.map(|_| 1.0));
        return Ok(Input { picture, black: None, white, step });
    }
    let raw = photosite::raw::read(path)?.linear().into_owned();
    Ok(Input {
        black: Some(f64::from(raw.black_level_dn.mean())),
        white: Some(f64::from(raw.white_level_dn)),
        step: Some(1.0),
        picture: Picture::from_raw(path.display().to_string(), raw, pixels),
    })
}

/// Pixels that are looked at together.
struct View {
    name: String,
    /// Number of the channel of the picture.
    channel: usize,
    /// Column and row of the first, and the steps to the next.
    offset: [usize; 2],
    stride: [usize; 2],
}

/// Every channel of a picture, and of a mosaic every place in its tile.
fn views(picture: &Picture) -> Vec<View> {
    let whole = |channel: usize| {
        let name = picture.mean.channels()[channel].name.clone();
        vec![View { name, channel, offset: [0, 0], stride: [1, 1] }]
    };
    let of_mosaic = |cfa: &Cfa| {
        let (columns, rows) = cfa.tile_size();
        let place = |i: usize| {
            let offset = [i % columns, i / columns];
            let letter = &cfa.channels()[cfa.channel_at(offset[0], offset[1])];
            let name = format!("{letter} at column {}, row {}", offset[0], offset[1]);
            View { name, channel: 0, offset, stride: [columns, rows] }
        };
        (0..columns * rows).map(place).collect()
    };
    match &picture.mosaic {
        Some(cfa) => of_mosaic(cfa),
        None => (0..picture.mean.channels().len()).flat_map(whole).collect(),
    }
}

fn text(report: &Report) -> String {
    let unit = report.unit.as_deref().unwrap_or("");
    let unit = if unit.starts_with("codes") { "codes" } else { unit };
    let of_plane = |PlaneReport { name, estimate: e }: &PlaneReport| {
        let number = |x: f64| rounded(x, 5).to_string();
        let variance = |v: &Variance| {
            format!("σ = {} {unit}, σ² = {} ± {}", number(v.sigma), number(v.variance), number(rounded(v.error, 2)))
        };
        let mut lines = vec![("mean", format!("{} {unit}", number(e.mean)))];
        if let Some(t) = &e.temporal {
            lines.push((
                "temporal noise",
                format!("{}; largest σ of a pixel {}", variance(&t.noise), number(t.largest_sigma)),
            ));
            let pattern = t.pattern.as_ref().map_or("hidden by the temporal noise".to_owned(), variance);
            lines.push(("fixed pattern", pattern));
        }
        lines.push(("as an even patch", variance(&e.uniform)));
        let [a, b] = e.plane.slope;
        lines.push((
            "after a plane",
            format!("{}; slope {} along x, {} along y a pixel", variance(&e.plane.noise), number(a), number(b)),
        ));
        if let Some(chi) = &e.plane.chi_squared {
            let [value, reduced] = [chi.value, chi.reduced].map(number);
            let p = if chi.p_value < 1e-4 { format!("{:.0e}", chi.p_value) } else { number(rounded(chi.p_value, 3)) };
            lines.push((
                "χ² of the plane",
                format!("{value} for {} degrees of freedom, reduced {reduced}, p = {p}", chi.freedom),
            ));
        }
        if let (Some(ratio), Some(db), Some(bits)) = (e.snr.ratio, e.snr.db, e.snr.bits) {
            lines.push(("signal over noise", format!("{} = {} dB = {} bit", number(ratio), number(db), number(bits))));
        }
        if let Some(bits) = e.snr.effective_bits {
            lines.push(("effective bits", number(bits)));
        }
        if let Some(q) = &e.quantisation {
            let part = q
                .part_percent
                .map_or(String::new(), |part| format!(", {} % of the variance", number(rounded(part, 3))));
            lines.push(("quantisation", format!("q²/12 = {}{part}", number(q.variance))));
        }
        let correlations = |lags: &[f64]| {
            let all: Vec<String> = lags[1..].iter().map(|c| format!("{:+.3}", c / lags[0])).collect();
            all.join(" ")
        };
        let c = &e.autocovariance;
        if c.along_rows[0] > 0.0 && c.along_rows.len() > 1 && c.along_columns.len() > 1 {
            lines.push((
                "correlation along rows",
                format!("{} (± {:.3})", correlations(&c.along_rows), c.correlation_error),
            ));
            lines.push(("correlation along columns", correlations(&c.along_columns)));
        }
        let width = lines.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        let body: Vec<String> = lines.iter().map(|(name, value)| format!("  {name:width$}  {value}")).collect();
        format!("{name}: {} × {} pixels of {} picture(s)\n{}", e.size[0], e.size[1], e.pictures, body.join("\n"))
    };
    let area = report.active_area_px.map(|[x, y, w, h]| format!("active area: {w} × {h} pixels at {x}, {y}"));
    area.into_iter().chain(report.planes.iter().map(of_plane)).collect::<Vec<_>>().join("\n\n")
}

fn rectangle(text: &str) -> Result<[usize; 4], String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    numbers
        .and_then(|n| <[usize; 4]>::try_from(n).ok())
        .ok_or_else(|| "write left, top, width and height, for example 100,100,64,64".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or_else(|| "write a number above 0".to_owned())
}
