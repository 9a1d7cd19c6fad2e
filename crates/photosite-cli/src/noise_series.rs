//! Images of the same scene, whose noise is estimated.

use std::path::{Path, PathBuf};

use photosite_core::image::{Channel, Planes};
use photosite_core::output::Sink;
use photosite_core::{Error, Invalid, Result};
use photosite_files::exr::Attribute;
use photosite_files::formats::{Format, lists::written};
use photosite_files::image_file::{ImageFile, read_image_file};
use photosite_files::plain_image::{PlainImage, write_plain_image};
use photosite_files::raw_file::{is_mosaic, read_raw};
use photosite_files::stated_colours::StatedColours;
use photosite_measure::characterisation::noise::{Knowledge, Patch, Request, estimate, sigma_map};
use photosite_measure::characterisation::report::{NoiseReport, PlaneNoise};
use photosite_measure::validation::ComparedImage;
use photosite_raw::{Cfa, PixelArea, Pixels};

/// Images of one size and the same channels, and the patch of them that is evaluated.
pub(crate) struct NoiseSeries {
    paths: Vec<PathBuf>,
    inputs: Vec<Input>,
    /// Left, top, width and height of the patch.
    patch: [usize; 4],
}

/// Image with the statements of its file about pixel values.
struct Input {
    image: ComparedImage,
    black: Option<f64>,
    white: Option<f64>,
    /// Distance between neighbouring pixel values, where these are integers.
    step: Option<f64>,
}

/// Pixels that are evaluated together: a channel, or one position in the tile of a mosaic.
struct View {
    name: String,
    /// Index of the image's channel.
    channel: usize,
    /// Column and row of the first pixel, and the steps to the next.
    offset: [usize; 2],
    stride: [usize; 2],
}

impl NoiseSeries {
    /// Reads one or more images, whole or only the `patch` (left, top, width, height).
    pub(crate) fn read(paths: &[PathBuf], pixels: Pixels, patch: Option<[usize; 4]>) -> Result<Self> {
        let inputs: Vec<Input> = paths.iter().map(|path| Input::read(path, pixels)).collect::<Result<_>>()?;
        let Some(first) = inputs.first() else {
            let help = Some("give one image or more".into());
            return Err(Error::Usage { message: "there is no image".to_owned(), help });
        };
        if let Some(other) = inputs.iter().position(|input| !input.goes_with(first)) {
            return Err(Error::Usage {
                message: format!("{} differs from {} in size or channels", paths[other].display(), paths[0].display()),
                help: Some("several images must show the same scene, taken by the same camera".into()),
            });
        }
        let [width, height] = first.size();
        let patch = patch.unwrap_or([0, 0, width, height]);
        let [x, y, w, h] = patch;
        let whole = if first.image.active_area.is_some() { "active area" } else { "image" };
        if x.checked_add(w).is_none_or(|end| end > width) || y.checked_add(h).is_none_or(|end| end > height) {
            return Err(Error::Usage {
                message: format!(
                    "the patch {x},{y},{w},{h} reaches beyond the {width} × {height} pixels of the {whole}"
                ),
                help: Some("write left, top, width and height, for example --patch 100,100,64,64".into()),
            });
        }
        Ok(Self { paths: paths.to_vec(), inputs, patch })
    }

    /// Statements about the files, for the user.
    pub(crate) fn said(&self) -> impl Iterator<Item = String> {
        self.inputs.iter().flat_map(|input| input.image.said())
    }

    /// Estimates the noise of each channel, and of a mosaic for each position in its tile. `black` is the value of no
    /// light where the file does not state it or states it wrongly, `sigma` the standard deviation that every pixel
    /// should have.
    pub(crate) fn estimate(&self, black: Option<f64>, sigma: Option<f64>, request: Request) -> Result<NoiseReport> {
        let first = &self.inputs[0];
        let known = Knowledge {
            black: black.or(first.black).unwrap_or(0.0),
            white: first.white,
            step: first.step,
            variance: sigma.map(|sigma| sigma * sigma),
        };
        let of_view = |view: View| {
            let estimate = estimate(&self.patches(&view)?, &known, request).map_err(unfit)?;
            Ok(PlaneNoise { name: view.name, estimate })
        };
        let area = first.image.active_area;
        Ok(NoiseReport {
            files: self.paths.iter().map(|path| path.display().to_string()).collect(),
            patch_px: self.patch,
            active_area_px: area.map(|PixelArea { x, y, width, height }| [x, y, width, height]),
            unit: first.image.unit.clone(),
            planes: views(&first.image).into_iter().map(of_view).collect::<Result<_>>()?,
        })
    }

    /// Standard deviation σ of every pixel of the patch over the images, of which there must be two or more.
    pub(crate) fn sigma_map(&self) -> Result<Planes> {
        let image = &self.inputs[0].image;
        let [_, _, width, height] = self.patch;
        let of_channel = |(channel, Channel { name, .. }): (usize, &Channel)| {
            let view = View { name: name.clone(), channel, offset: [0, 0], stride: [1, 1] };
            let sigmas = sigma_map(&self.patches(&view)?).map_err(unfit)?;
            Ok(Channel { name: view.name, data: sigmas.into_iter().map(|sigma| sigma as f32).collect() })
        };
        let channels = image.mean.channels().iter().enumerate().map(of_channel).collect::<Result<_>>()?;
        Planes::new(width, height, channels).map_err(unfit)
    }

    /// Values of a view in each image.
    fn patches(&self, view: &View) -> Result<Vec<Patch>> {
        let View { channel, offset, stride, .. } = *view;
        let [x, y, w, h] = self.patch;
        let part = |start: usize, length: usize, axis: usize| {
            (start..start + length).filter(move |i| i % stride[axis] == offset[axis]).collect::<Vec<usize>>()
        };
        let (columns, rows) = (part(x, w, 0), part(y, h, 1));
        let of_image = |input: &Input| {
            let (width, values) = (input.size()[0], &input.image.mean.channels()[channel].data);
            let row = |&row: &usize| columns.iter().map(move |column| f64::from(values[row * width + column]));
            let patch = Patch::new(columns.len(), rows.len(), rows.iter().flat_map(row).collect());
            let of_file = |invalid: Invalid| format!("{}: {}", input.image.name, invalid.message);
            patch.map_err(|invalid| unfit(Invalid { message: of_file(invalid.clone()), ..invalid }))
        };
        self.inputs.iter().map(of_image).collect()
    }
}

impl Input {
    fn read(path: &Path, pixels: Pixels) -> Result<Self> {
        if !is_mosaic(path) {
            let image = read_image_file(path, pixels)?.whole().map_err(|invalid| invalid.in_file(path))?;
            let (white, step) = (image.full_scale, image.full_scale.map(|_| 1.0));
            return Ok(Self { image, black: None, white, step });
        }
        let raw = read_raw(path)?.linear().into_owned();
        Ok(Self {
            black: Some(f64::from(raw.black_level_dn.mean())),
            white: Some(f64::from(raw.white_level_dn)),
            step: Some(1.0),
            image: ImageFile::of_raw(path.display().to_string(), raw, pixels).as_it_lies(),
        })
    }

    fn size(&self) -> [usize; 2] {
        [self.image.mean.width(), self.image.mean.height()]
    }

    fn goes_with(&self, other: &Self) -> bool {
        let names = |input: &Self| input.image.mean.channels().iter().map(|c| c.name.clone()).collect::<Vec<_>>();
        self.size() == other.size() && names(self) == names(other) && self.image.mosaic == other.image.mosaic
    }
}

/// Every channel of an image, and every position in the tile of a mosaic.
fn views(image: &ComparedImage) -> Vec<View> {
    let whole = |(channel, Channel { name, .. }): (usize, &Channel)| View {
        name: name.clone(),
        channel,
        offset: [0, 0],
        stride: [1, 1],
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
    match &image.mosaic {
        Some(cfa) => of_mosaic(cfa),
        None => image.mean.channels().iter().enumerate().map(whole).collect(),
    }
}

/// Usage error of a patch or of images that permit no estimate.
fn unfit(Invalid { message, help, .. }: Invalid) -> Error {
    Error::Usage { message, help }
}

/// Format of a σ map, which holds floating-point values.
pub(crate) fn sigma_map_format(path: &Path) -> Result<&'static Format> {
    written(path, |format| format.floats, "a file for standard deviations")
}

/// Writes a σ map; an EXR file states the unit of its values.
pub(crate) fn write_sigma_map(
    planes: &Planes,
    unit: Option<&str>,
    format: &Format,
    to: &mut dyn Sink,
) -> std::io::Result<()> {
    let unit = unit.map(|unit| ("unit", Attribute::Text(unit.to_owned())));
    let colours = StatedColours::of_exr(unit);
    write_plain_image(&PlainImage { colours, ..PlainImage::plain(planes.clone(), None) }, format, to)
}
