//! Images of a camera, to which a sensor is fitted: those of a descriptor, of a folder that `photosite emva1288` filled,
//! or of any folder of flats and darks.

use std::path::{Path, PathBuf};

use photosite_core::units::{Celsius, Seconds};
use photosite_core::{Error, Invalid, Result, input, memory, text};
use photosite_measure::characterisation::camera_fit::{FrameGroup, FrameLight};
use photosite_measure::characterisation::{Descriptor, Light, Series};
use photosite_measure::validation::ComparedImage;
use photosite_raw::{Cfa, Pixels};

use super::contents::{CONTENTS, ChannelSets, ImageSets};
use super::frame_folder::{FolderFrames, FrameGain, frames_of};
use crate::image_file::read_image_file;

/// Bytes per pixel while a sensor is fitted: two stacks of sums and squares, averages and patterns.
const PIXEL: u64 = 120;

/// Images of a camera with what they were taken of.
#[derive(Clone, Debug)]
pub struct CameraSet {
    /// Groups of images of the same light.
    pub groups: Vec<FrameGroup>,
    /// Columns and rows of the pixels that are evaluated: of a mosaic those of one place of its tile.
    pub size: [usize; 2],
    /// Columns and rows of the images.
    pub whole_size: [usize; 2],
    /// Bits of the digital numbers.
    pub bits: u32,
    /// Whether the bits are those of the files, for want of a statement about the converter.
    pub bits_are_assumed: bool,
    /// Colour filter array of the images.
    pub cfa: Cfa,
    /// Channel that is evaluated.
    pub channel: usize,
    /// Wavelength of the light, where it is stated.
    pub wavelength_nm: Option<f64>,
    /// Pixel pitch, m, where the files state it.
    pub pixel_pitch_m: Option<[f64; 2]>,
    /// Statement about the gain of the images.
    pub gain: Option<FrameGain>,
    paths: Vec<Vec<PathBuf>>,
}

impl CameraSet {
    /// Finds the images of a descriptor (a file) or a folder, those of each gain in a set of their own, the lowest gain
    /// first. `channel` is the channel to evaluate: of the image sets of
    /// a colour sensor, or of a mosaic.
    ///
    /// # Errors
    ///
    /// Images without a statement of what they were taken of, of gains that are not stated alike, of different sizes.
    pub fn find(path: &Path, channel: Option<&str>) -> Result<Vec<Self>> {
        let sets = if !path.is_dir() {
            let descriptor = read_descriptor(path)?;
            let groups = described(path, &descriptor, None);
            vec![Self::of_descriptors(path, &descriptor, groups)?]
        } else if path.join(CONTENTS).exists() {
            vec![Self::of_image_sets(path, channel)?]
        } else {
            let frames = frames_of(path)?.by_gain()?;
            frames.into_iter().map(|(gain, frames)| Self::of_frames(&frames, gain, channel)).collect::<Result<_>>()?
        };
        if let Some(other) = sets.iter().find(|set| set.whole_size != sets[0].whole_size) {
            let [[w, h], [width, height]] = [other.whole_size, sets[0].whole_size];
            let message = format!("{w} × {h} pixels instead of {width} × {height}");
            return Err(Invalid::new("", message).in_file(other.groups[0].name.as_ref()));
        }
        let [width, height] = sets[0].size;
        let bytes = (width as u64).saturating_mul(height as u64).saturating_mul(PIXEL);
        memory::check(bytes, &format!("fitting a sensor of {width} × {height} pixels"), "use smaller images")
            .map_err(|invalid| invalid.in_file(path))?;
        Ok(sets)
    }

    fn of_descriptors(path: &Path, first: &Descriptor, groups: Vec<(FrameGroup, Vec<PathBuf>)>) -> Result<Self> {
        let size = [first.width, first.height];
        if !(1..=16).contains(&first.bits) {
            let message = format!("{} bits are not those of a converter", first.bits);
            return Err(Invalid::new("n", message).help("write 1 to 16: n 12 512 512").in_file(path));
        }
        let (groups, paths) = groups.into_iter().unzip();
        Ok(Self {
            groups,
            paths,
            size,
            whole_size: size,
            bits: first.bits,
            bits_are_assumed: false,
            cfa: Cfa::mono(),
            channel: 0,
            wavelength_nm: None,
            pixel_pitch_m: None,
            gain: None,
        })
    }

    /// Images that `photosite emva1288` took, of one channel.
    fn of_image_sets(folder: &Path, channel: Option<&str>) -> Result<Self> {
        let sets = ImageSets::read(folder)?;
        let names: Vec<&str> = sets.channels.iter().map(|c| c.channel.as_str()).collect();
        let help = || format!("add --channel NAME: {} are there", names.join(", "));
        let usage = |message| Error::Usage { message, help: Some(help().into()) };
        let chosen = match (channel, &sets.channels[..]) {
            (Some(name), all) => all.iter().find(|c| c.channel == name),
            (None, [only]) => Some(only),
            (None, _) => return Err(usage(format!("{} has image sets of several channels", folder.display()))),
        };
        let Some(chosen) = chosen else {
            return Err(usage(format!(
                "{} has no image sets of channel {:?}",
                folder.display(),
                channel.unwrap_or("")
            )));
        };
        let ChannelSets { descriptor, temperature_c, temperatures, .. } = chosen;
        let path = folder.join(descriptor);
        let main = read_descriptor(&path)?;
        let mut groups = described(&path, &main, Some(Celsius(*temperature_c)));
        for set in temperatures {
            let path = folder.join(&set.descriptor);
            let of_set = described(&path, &read_descriptor(&path)?, Some(Celsius(set.temperature_c)));
            // The light of these sets is there for programs that want some.
            groups.extend(of_set.into_iter().filter(|(group, _)| group.is_dark()));
        }
        let gain = (sets.gain_db != 0.0).then(|| FrameGain::new(&format!("{} dB", sets.gain_db)));
        Ok(Self { wavelength_nm: Some(chosen.wavelength_nm), gain, ..Self::of_descriptors(&path, &main, groups)? })
    }

    fn of_frames(frames: &FolderFrames, gain: Option<FrameGain>, channel: Option<&str>) -> Result<Self> {
        let first = &frames.frames[0];
        let image = read_plane_image(&first.path)?;
        let whole_size = [image.mean.width(), image.mean.height()];
        let cfa = image.mosaic.clone().unwrap_or_else(Cfa::mono);
        let names = cfa.channels();
        let number = match channel {
            Some(name) => names.iter().position(|n| n == name).ok_or_else(|| Error::Usage {
                message: format!("{} has no channel {name:?}", first.path.display()),
                help: Some(format!("its channels are {}", names.join(", ")).into()),
            })?,
            None => names.iter().position(|n| n == "G").unwrap_or(0),
        };
        let (columns, rows) = cfa.tile_size();
        let groups = frames.groups();
        let (groups, paths): (Vec<FrameGroup>, Vec<Vec<PathBuf>>) = groups.into_iter().unzip();
        let mut set = Self {
            groups,
            paths,
            size: [whole_size[0] / columns, whole_size[1] / rows],
            whole_size,
            bits: 16,
            bits_are_assumed: frames.bits.is_none(),
            cfa,
            channel: number,
            wavelength_nm: None,
            pixel_pitch_m: frames.pixel_pitch_m,
            gain,
        };
        set.bits = match frames.bits {
            Some(bits) => bits,
            None => set.bits_of_numbers(&image)?,
        };
        Ok(set)
    }

    /// Bits of the numbers of files that do not say: those of saturated images, else those of the file.
    fn bits_of_numbers(&mut self, first: &ComparedImage) -> Result<u32> {
        let of_file = if first.full_scale == Some(255.0) { 8 } else { 16 };
        let mut largest = 0u16;
        for (group, _) in self.groups.clone().iter().enumerate().filter(|(_, group)| !group.is_dark()) {
            largest = largest.max(self.image(group, 0)?.into_iter().max().unwrap_or(0));
        }
        let is_end = largest > 0 && (u32::from(largest) + 1).is_power_of_two();
        self.bits_are_assumed = !is_end;
        Ok(if is_end { largest.count_ones() } else { of_file })
    }

    /// Places of a channel in the tile of the colour filter array.
    pub fn places(&self, channel: usize) -> Vec<[usize; 2]> {
        let (columns, rows) = self.cfa.tile_size();
        let places = (0..columns * rows).map(|i| [i % columns, i / columns]);
        places.filter(|&[x, y]| self.cfa.channel_at(x, y) == channel).collect()
    }

    /// Reads the digital numbers of an image, in the pixels that are evaluated.
    pub fn image(&self, group: usize, image: usize) -> Result<Vec<u16>> {
        let place = self.places(self.channel).first().copied().unwrap_or([0, 0]);
        self.image_at(group, image, place)
    }

    /// Reads the digital numbers of an image at one place of the tile.
    pub fn image_at(&self, group: usize, image: usize, [x, y]: [usize; 2]) -> Result<Vec<u16>> {
        let path = &self.paths[group][image];
        let read = read_plane_image(path)?;
        let size = [read.mean.width(), read.mean.height()];
        if size != self.whole_size {
            let [[w, h], [width, height]] = [size, self.whole_size];
            let message = format!("{w} × {h} pixels instead of {width} × {height}");
            let help = format!("all images must be of one camera; {} has the other size", self.paths[0][0].display());
            return Err(Invalid::new("", message).help(help).in_file(path));
        }
        let cfa = read.mosaic.clone().unwrap_or_else(Cfa::mono);
        // The images of a descriptor are of one plane, whatever their files say.
        if cfa != self.cfa && (cfa.is_mosaic() || self.cfa.is_mosaic()) {
            let message = format!("has the filters {cfa}, and other images have {}", self.cfa);
            return Err(Invalid::new("", message).help("all images must be of one camera").in_file(path));
        }
        let (columns, rows) = self.cfa.tile_size();
        let [width, height] = self.size;
        let plane = &read.mean.channels()[0].data;
        let lines = plane.chunks_exact(self.whole_size[0]).skip(y).step_by(rows).take(height);
        let numbers: Vec<u16> =
            lines.flat_map(|line| line[x..].iter().step_by(columns).take(width).map(|&n| n as u16)).collect();
        let largest = numbers.iter().copied().max().unwrap_or(0);
        if u32::from(largest) >= 1 << self.bits {
            let message = format!("the number {largest} takes more than {} bits", self.bits);
            let help = "state the bits of the numbers in the files, shifted ones included: 16 for 12 bits times 16";
            return Err(Invalid::new("", message).help(help).in_file(path));
        }
        Ok(numbers)
    }
}

/// Reads one plane of digital numbers.
fn read_plane_image(path: &Path) -> Result<ComparedImage> {
    let image = read_image_file(path, Pixels::Active)?.whole().map_err(|invalid| invalid.in_file(path))?;
    let is_number = |y: &f32| (0.0..=65_535.0).contains(y) && y.fract() == 0.0;
    match image.mean.channels() {
        [plane] if plane.data.iter().all(is_number) => Ok(image),
        _ => {
            let help = "give raw images or images of one grey plane: DNG, TIFF, PNG, PGM or NPY, not developed ones";
            Err(Invalid::new("", "does not hold one plane of digital numbers").help(help).in_file(path))
        }
    }
}

fn read_descriptor(path: &Path) -> Result<Descriptor> {
    let text = input::read_at_most(path, input::TREE_BYTES).and_then(text::decode_any);
    let text = text.map_err(|reason| Error::io(path, "read", reason))?;
    Descriptor::parse(&text).map_err(|(line, invalid)| invalid.at_line(path, line))
}

/// Groups of the images of a descriptor, with their paths.
fn described(path: &Path, descriptor: &Descriptor, temperature: Option<Celsius>) -> Vec<(FrameGroup, Vec<PathBuf>)> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let group = |series: &Series| {
        let paths: Vec<PathBuf> = series.images.iter().map(|name| folder.join(name)).collect();
        let images: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        let light = match series.light {
            Light::Dark => FrameLight::Dark,
            Light::Bright { photons } => FrameLight::Bright { photons: Some(photons) },
        };
        let time = (series.exposure_ns > 0.0).then(|| Seconds(series.exposure_ns / 1e9));
        (FrameGroup { name: images[0].clone(), time, light, temperature, images }, paths)
    };
    descriptor.series.iter().map(group).collect()
}
