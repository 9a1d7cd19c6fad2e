//! Pictures of the same scene, whose noise is estimated.

use std::path::{Path, PathBuf};

use super::exr::Attribute;
use super::number_picture::{NumberFormat, NumberPicture, write_numbers};
use super::output::Sink;
use super::picture_file::{PictureFile, read_picture_file};
use crate::characterisation::noise::{Knowledge, Patch, Request, estimate, sigma_map};
use crate::characterisation::report::{NoiseReport, PlaneNoise};
use crate::image::{Channel, Planes};
use crate::raw::{Cfa, PixelArea, Pixels};
use crate::validation::Picture;
use crate::{Error, Invalid, Result};

/// Pictures of one size and the same channels, of which a patch is looked at.
pub struct NoiseSeries {
    paths: Vec<PathBuf>,
    inputs: Vec<Input>,
    /// Left, top, width and height.
    patch: [usize; 4],
}

/// A picture with what its file says of its numbers.
struct Input {
    picture: Picture,
    black: Option<f64>,
    white: Option<f64>,
    /// Distance between neighbouring numbers, where they are whole.
    step: Option<f64>,
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

impl NoiseSeries {
    /// Reads one or more pictures, of which `patch` (left, top, width, height) is looked at, or all.
    pub fn read(paths: &[PathBuf], pixels: Pixels, patch: Option<[usize; 4]>) -> Result<Self> {
        let inputs: Vec<Input> = paths.iter().map(|path| Input::read(path, pixels)).collect::<Result<_>>()?;
        let Some(first) = inputs.first() else {
            let help = Some("give one picture or more".into());
            return Err(Error::Usage { message: "there is no picture".to_owned(), help });
        };
        if let Some(other) = inputs.iter().position(|input| !input.goes_with(first)) {
            return Err(Error::Usage {
                message: format!("{} differs from {} in size or channels", paths[other].display(), paths[0].display()),
                help: Some("several pictures must show the same scene, taken by the same camera".into()),
            });
        }
        let [width, height] = first.size();
        let patch = patch.unwrap_or([0, 0, width, height]);
        let [x, y, w, h] = patch;
        let whole = if first.picture.active_area.is_some() { "active area" } else { "picture" };
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

    /// What is to be said of the files.
    pub fn said(&self) -> impl Iterator<Item = String> {
        self.inputs.iter().flat_map(|input| input.picture.said())
    }

    /// Estimates the noise of each channel, and of a mosaic of each place in its tile. `black` is the value of no light
    /// where the file does not say it or says it wrongly, `sigma` what every pixel should have.
    pub fn estimate(&self, black: Option<f64>, sigma: Option<f64>, request: Request) -> Result<NoiseReport> {
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
        let area = first.picture.active_area;
        Ok(NoiseReport {
            files: self.paths.iter().map(|path| path.display().to_string()).collect(),
            patch_px: self.patch,
            active_area_px: area.map(|PixelArea { x, y, width, height }| [x, y, width, height]),
            unit: first.picture.unit.clone(),
            planes: views(&first.picture).into_iter().map(of_view).collect::<Result<_>>()?,
        })
    }

    /// The σ of every pixel of the patch over the pictures, of which there must be two or more.
    pub fn sigma_map(&self) -> Result<Planes> {
        let picture = &self.inputs[0].picture;
        let [_, _, width, height] = self.patch;
        let of_channel = |(channel, Channel { name, .. }): (usize, &Channel)| {
            let view = View { name: name.clone(), channel, offset: [0, 0], stride: [1, 1] };
            let sigmas = sigma_map(&self.patches(&view)?).map_err(unfit)?;
            Ok(Channel { name: view.name, data: sigmas.into_iter().map(|sigma| sigma as f32).collect() })
        };
        let channels = picture.mean.channels().iter().enumerate().map(of_channel).collect::<Result<_>>()?;
        Planes::new(width, height, channels).map_err(unfit)
    }

    /// The values of a view in each picture.
    fn patches(&self, view: &View) -> Result<Vec<Patch>> {
        let View { channel, offset, stride, .. } = *view;
        let [x, y, w, h] = self.patch;
        let part = |start: usize, length: usize, axis: usize| {
            (start..start + length).filter(move |i| i % stride[axis] == offset[axis]).collect::<Vec<usize>>()
        };
        let (columns, rows) = (part(x, w, 0), part(y, h, 1));
        let of_picture = |input: &Input| {
            let (width, values) = (input.size()[0], &input.picture.mean.channels()[channel].data);
            let row = |&row: &usize| columns.iter().map(move |column| f64::from(values[row * width + column]));
            let patch = Patch::new(columns.len(), rows.len(), rows.iter().flat_map(row).collect());
            let of_file = |invalid: Invalid| format!("{}: {}", input.picture.name, invalid.message);
            patch.map_err(|invalid| unfit(Invalid { message: of_file(invalid.clone()), ..invalid }))
        };
        self.inputs.iter().map(of_picture).collect()
    }
}

impl Input {
    fn read(path: &Path, pixels: Pixels) -> Result<Self> {
        if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("dng")) {
            let picture = read_picture_file(path, pixels)?.whole().map_err(|invalid| invalid.in_file(path))?;
            let (white, step) = (picture.full_scale, picture.full_scale.map(|_| 1.0));
            return Ok(Self { picture, black: None, white, step });
        }
        let raw = crate::raw::read(path)?.linear().into_owned();
        Ok(Self {
            black: Some(f64::from(raw.black_level_dn.mean())),
            white: Some(f64::from(raw.white_level_dn)),
            step: Some(1.0),
            picture: PictureFile::of_raw(path.display().to_string(), raw, pixels).as_it_lies(),
        })
    }

    fn size(&self) -> [usize; 2] {
        [self.picture.mean.width(), self.picture.mean.height()]
    }

    fn goes_with(&self, other: &Self) -> bool {
        let names = |input: &Self| input.picture.mean.channels().iter().map(|c| c.name.clone()).collect::<Vec<_>>();
        self.size() == other.size() && names(self) == names(other) && self.picture.mosaic == other.picture.mosaic
    }
}

/// Every channel of a picture, and of a mosaic every place in its tile.
fn views(picture: &Picture) -> Vec<View> {
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
    match &picture.mosaic {
        Some(cfa) => of_mosaic(cfa),
        None => picture.mean.channels().iter().enumerate().map(whole).collect(),
    }
}

/// Patches and pictures that estimates cannot be made of were asked for on the command line.
fn unfit(Invalid { message, help, .. }: Invalid) -> Error {
    Error::Usage { message, help }
}

/// The format of a σ map, which is of floating-point numbers.
pub fn sigma_map_format(path: &Path) -> Result<NumberFormat> {
    match NumberFormat::of(path) {
        Ok(format @ (NumberFormat::Exr | NumberFormat::Npy | NumberFormat::Tiff)) => Ok(format),
        Ok(NumberFormat::Png | NumberFormat::Pgm | NumberFormat::Ppm) | Err(_) => Err(Error::Usage {
            message: format!("{} is not the name of a file for standard deviations", path.display()),
            help: Some("give a name that ends with .exr, .npy or .tiff".into()),
        }),
    }
}

/// Writes a σ map, of which an EXR file says what the numbers count.
pub fn write_sigma_map(
    planes: &Planes,
    unit: Option<&str>,
    format: NumberFormat,
    to: &mut dyn Sink,
) -> std::io::Result<()> {
    let attributes: Vec<(String, Attribute)> =
        unit.map(|unit| ("unit".to_owned(), Attribute::Text(unit.to_owned()))).into_iter().collect();
    write_numbers(&NumberPicture { planes: planes.clone(), largest: None, profile: None, attributes }, format, to)
}
