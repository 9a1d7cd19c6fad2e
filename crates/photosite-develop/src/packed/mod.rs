//! Development as plain data, for devices: what the steps of [`develop`](crate::develop()) find out about a raw image
//! and its settings before they touch a pixel, by the same functions. What a device does not have is refused by its
//! key.
//!
//! | step | numbers |
//! |---|---|
//! | linear numbers, black level, white balance | [`linearisation`](PackedDevelopment::linearisation), [`places`](PackedDevelopment::places) |
//! | the lens's falloff | [`gain_maps`](PackedDevelopment::gain_maps) |
//! | highlights | [`ceiling`](PackedDevelopment::ceiling) |
//! | demosaicking | [`demosaicking`](PackedDevelopment::demosaicking) |
//! | colour matrix and exposure | [`colour`](PackedDevelopment::colour) |
//! | tone curve, grey | [`is_filmic`](PackedDevelopment::is_filmic), [`luminance`](PackedDevelopment::luminance) |
//! | encoding | [`levels`](PackedDevelopment::levels) |

mod refusals;

use photosite_core::Invalid;
use photosite_core::colour::{ColourSpace, Transfer};
use photosite_raw::{Cfa, GainMap, Opcode, Orientation, PixelArea, RawImage};

use crate::choices::{Demosaic, ToneCurve};
use crate::demosaic::{MARGIN, Tent, method_for, red_place};
use crate::develop::matrix_and_exposure;
use crate::encode::levels;
use crate::neighbours::radius_for_all;
use crate::opcodes::{frame, opcodes};
use crate::resampling::Resampling;
use crate::settings::DevelopSettings;
use crate::{black_level, colour, highlights, linearisation, white_balance};
use refusals::{check_file, check_settings, refused};

/// Development of a raw image as plain data; see the module.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedDevelopment {
    /// Columns and rows of the raw image, masked pixels included.
    pub stored_px: [usize; 2],
    /// Values of each pixel, one beside the other: 1 in a mosaic.
    pub samples: usize,
    /// The pixels that see light. Places of all that follows begin at its corner.
    pub active: PixelArea,
    /// The part of the active area that is shown.
    pub shown: PixelArea,
    /// Linear number for each stored one, the last for all beyond; empty where stored numbers are linear.
    pub linearisation: Vec<u16>,
    /// Values along a row of the tile of `places`.
    pub tile_columns: usize,
    /// Levels and channels at the places of a tile, row by row.
    pub places: Vec<Place>,
    /// Gains against the lens's falloff, each map after the one before.
    pub gain_maps: Vec<PackedGainMap>,
    /// Level that no channel passes before and after demosaicking, saturation of the most sensitive one being 1.
    pub ceiling: f32,
    /// Method of demosaicking.
    pub demosaicking: Demosaicking,
    /// Channels of the camera, 1 or 3.
    pub channels: usize,
    /// Camera → linear components of the image, a column per channel; of one channel the first number alone counts.
    pub colour: [[f32; 3]; 3],
    /// Whether components are bent by the curve x(2.51x + 0.03)/(x(2.43x + 0.59) + 0.14) before they are encoded.
    pub is_filmic: bool,
    /// Weights of the components in luminance, where that alone is shown.
    pub luminance: Option<[f32; 3]>,
    /// Least linear value of every code from 1 on: the code of a value is the number of these that it reaches.
    pub levels: Vec<f32>,
    /// Bits of a code, 8 or 16.
    pub bits: u8,
    /// Orientation of the image.
    pub orientation: Orientation,
    /// Colour space of the image.
    pub colour_space: ColourSpace,
    /// Transfer function of its codes.
    pub transfer: Transfer,
    /// Width of a pixel of the image over its height.
    pub pixel_aspect: f64,
}

/// Place of a tile: x = min((DN − black)·factor·gain·balance, ceiling).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Black level, DN.
    pub black: f32,
    /// 1/(white − black), 1/DN.
    pub factor: f32,
    /// Factor of the white balance.
    pub balance: f32,
    /// Index of the channel.
    pub channel: usize,
}

/// Gains against the lens's falloff: the product of what a value's column and row name is found between four gains,
/// along rows first.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedGainMap {
    /// Gains of the map.
    pub gains: Vec<f32>,
    /// For each value along a row of the active area the points on both sides; `None` where it keeps its value.
    pub across: Vec<Option<Line>>,
    /// For each row of the active area the points above and below; `None` where it keeps its values.
    pub down: Vec<Option<Line>>,
}

/// Gains on both sides of a place along an axis: the sum of two such indices is that of a gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Indices of the gains before and behind the place.
    pub indices: [usize; 2],
    /// Distance from the first, in those between the points.
    pub part: f32,
}

/// Method of demosaicking.
#[derive(Clone, Debug, PartialEq)]
pub enum Demosaicking {
    /// Every pixel has all channels.
    Apart,
    /// Means of neighbours.
    Bilinear(Box<Neighbours>),
    /// Bilinear interpolation corrected by curvature.
    Malvar,
    /// Interpolation along edges.
    Menon {
        /// Parity of the rows that hold red pixels, and of the columns.
        red: [usize; 2],
    },
}

/// Neighbours of a pixel of a Bayer mosaic that a mean is taken of, nearest first: step to the right and down, pixels,
/// and weight; for the four places of the tile, row by row, and in each for the three channels.
pub type Neighbours = [[Vec<([isize; 2], f32)>; 3]; 4];

impl Demosaicking {
    /// Pixels around a pixel that its result depends on at most.
    pub fn margin(&self) -> usize {
        match self {
            Self::Apart => 0,
            Self::Bilinear(_) | Self::Malvar | Self::Menon { .. } => MARGIN,
        }
    }
}

impl PackedDevelopment {
    /// Packs the development of a raw image with these settings. The pixel values of `raw` do not count and may be
    /// missing.
    ///
    /// # Errors
    ///
    /// The key of the first setting, or of the first fact about the raw image, that a device does not have; the image
    /// is developed by [`develop`](crate::develop()) instead. Settings and facts that `develop` refuses are refused
    /// here, too.
    pub fn new(raw: &RawImage, settings: &DevelopSettings) -> Result<Self, Invalid> {
        raw.validate_area()?;
        settings.validate().map_err(|invalid| invalid.within("develop"))?;
        check_settings(settings)?;

        // Of a raw image without values these steps change what is known of it alone
        let bare = raw.with_data(Vec::new());
        let described = settings.raw.apply(&bare).map_err(|invalid| invalid.within("develop.raw"))?;
        check_file(&described, settings.lens_falloff)?;
        let cfa = &described.cfa;
        if !matches!(cfa.channels().len(), 1 | 3) || cfa.is_mosaic() && !cfa.is_bayer() {
            return Err(refused("cfa", &format!("the filter array {cfa}")));
        }
        let table = described.linearisation.clone().filter(|_| settings.linearisation);
        let linear = linearisation::apply(&described, settings.linearisation).cropped();
        let size = [linear.width, linear.height];
        let shown = shown(&linear, settings)?;

        let blamed = |invalid| settings.raw.blamed(invalid).within("develop");
        let neutral = white_balance::neutral(&linear, &[], settings).map_err(blamed)?;
        let (matrix, exposure) = matrix_and_exposure(&linear.metadata, &neutral, settings).map_err(blamed)?;
        let channels = linear.cfa.channels().len();
        let colour = match matrix {
            Some(columns) => colour::scaled(&columns, exposure),
            None => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|unit| unit.map(|v| (v * exposure) as f32))
                .to_vec(),
        };
        let Ok(colour) = <[[f32; 3]; 3]>::try_from(colour) else {
            return Err(refused("develop.colour_matrix", "colours of a single channel"));
        };

        let is_grey = settings.colour_model.is_grey() && channels == 3;
        let encoding = settings.encoding();
        let orientation = settings.orientation(&linear.metadata);
        let (tile_columns, places) = places(&linear, settings.black_level, &white_balance::factors(&neutral));
        Ok(Self {
            stored_px: [described.width, described.height],
            samples: linear.cfa.samples_per_pixel(),
            active: PixelArea { width: size[0], height: size[1], ..described.active() },
            shown,
            linearisation: table.unwrap_or_default(),
            tile_columns,
            places,
            gain_maps: gain_maps(&linear, settings.lens_falloff),
            ceiling: highlights::ceiling(settings.highlights),
            demosaicking: demosaicking(&linear, settings.demosaic)?,
            channels,
            colour,
            is_filmic: settings.tone_curve == ToneCurve::Filmic,
            luminance: is_grey.then(|| encoding.colour_space.luminance_weights().as_vec3().to_array()),
            levels: levels(encoding.transfer, encoding.bits),
            bits: encoding.bits,
            orientation,
            colour_space: encoding.colour_space,
            transfer: encoding.transfer,
            pixel_aspect: orientation.pixel_aspect(settings.pixel_aspect(&linear.metadata)),
        })
    }

    /// Components of a pixel of the image, 1 or 3.
    pub fn components(&self) -> usize {
        if self.luminance.is_some() { 1 } else { self.channels }
    }

    /// Columns and rows of the image.
    pub fn image_px(&self) -> [usize; 2] {
        self.orientation.turned([self.shown.width, self.shown.height])
    }
}

/// The part of the active area that is shown, where no pixel is moved.
fn shown(linear: &RawImage, settings: &DevelopSettings) -> Result<PixelArea, Invalid> {
    let [width, height] = [linear.width, linear.height];
    match Resampling::new(&linear.metadata, [width, height], settings) {
        None => Ok(PixelArea { x: 0, y: 0, width, height }),
        Some(resampling) => resampling.as_part().ok_or_else(|| {
            if resampling.undistorts() {
                refused("develop.distortion", "images without the lens's distortion")
            } else {
                refused("develop.square_pixels", "square pixels made of others")
            }
        }),
    }
}

/// Columns of the smallest tile that filters and black levels both repeat with, and its places.
fn places(linear: &RawImage, black_level: bool, balances: &[f32]) -> (usize, Vec<Place>) {
    let ((cfa_columns, cfa_rows), ((columns, rows), _)) = (linear.cfa.tile_size(), linear.black_level_dn.tile());
    let [columns, rows] = [common_multiple(cfa_columns, columns), common_multiple(cfa_rows, rows)];
    let place = |i: usize| {
        let [x, y] = [i % columns, i / columns];
        let (black, factor) = black_level::scale(linear, black_level, [x, y]);
        let channel = linear.cfa.channel_at(x, y);
        Place { black, factor, balance: balances[channel], channel }
    };
    (columns, (0..columns * rows).map(place).collect())
}

fn common_multiple(a: usize, b: usize) -> usize {
    (1..=b).map(|k| k * a).find(|multiple| multiple.is_multiple_of(b)).unwrap_or(a * b)
}

fn gain_maps(linear: &RawImage, lens_falloff: bool) -> Vec<PackedGainMap> {
    let frame = frame(linear);
    let packed = |map: &GainMap| {
        let line = |axis: usize, place: usize, index: &dyn Fn(usize) -> usize| {
            let between = map.between(axis, frame.place(axis, place));
            Line { indices: [between.first, between.second].map(index), part: between.part }
        };
        let of_value = |i: usize| {
            let (x, plane) = (i / frame.samples, i % frame.samples);
            map.has_number(x, plane).then(|| line(0, x, &|column| map.index(column, 0, plane)))
        };
        let of_row = |y: usize| map.has_row(y).then(|| line(1, y, &|row| map.index(0, row, 0)));
        PackedGainMap {
            gains: map.gains().to_vec(),
            across: (0..linear.row_length()).map(of_value).collect(),
            down: (0..linear.height).map(of_row).collect(),
        }
    };
    let maps = opcodes(linear, 1, lens_falloff);
    maps.filter_map(|opcode| if let Opcode::GainMap(map) = opcode { Some(packed(map)) } else { None }).collect()
}

fn demosaicking(linear: &RawImage, method: Demosaic) -> Result<Demosaicking, Invalid> {
    let method = method_for(linear, method).map_err(|invalid| invalid.within("develop"))?;
    let cfa = &linear.cfa;
    if !cfa.is_mosaic() {
        return Ok(Demosaicking::Apart);
    }
    match method {
        Demosaic::Menon => Ok(Demosaicking::Menon { red: red_place(cfa) }),
        Demosaic::Malvar => Ok(Demosaicking::Malvar),
        Demosaic::Bilinear => Ok(Demosaicking::Bilinear(Box::new(neighbours(cfa)))),
        Demosaic::Auto | Demosaic::Nearest | Demosaic::Guided | Demosaic::Markesteijn | Demosaic::Lmmse => {
            Err(refused("develop.demosaic", "methods other than \"menon\", \"malvar\" and \"bilinear\""))
        }
    }
}

fn neighbours(cfa: &Cfa) -> Neighbours {
    let tents = [0, 1, 2].map(|channel| Tent::new(cfa, channel, radius_for_all(cfa)));
    [0, 1, 2, 3].map(|place| {
        [0, 1, 2].map(|channel| {
            let taps = &tents[channel].taps()[place];
            taps.iter().map(|(step, weight)| ([step.dx, step.dy], *weight)).collect()
        })
    })
}
