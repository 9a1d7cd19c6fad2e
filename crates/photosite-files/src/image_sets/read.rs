//! Reading an image set back: from a descriptor and its images to statistics.

use std::cell::RefCell;
use std::path::Path;

use crate::image_file::read_image_file;
use photosite_core::units::Seconds;
use photosite_core::{Error, Invalid, Result};
use photosite_core::{counted, input, memory, text};
use photosite_measure::characterisation::{
    DarkPoint, Descriptor, Light, PairStatistics, Series, SpatialStack, TemporalPoint,
};
use photosite_raw::Pixels;

/// Bytes per pixel while a set is evaluated, as measured: two stacks of sums, and images.
const PIXEL: u64 = 40;

/// Statistics of an image set.
#[derive(Clone, Debug)]
pub struct MeasuredSet {
    /// Descriptor of the set.
    pub descriptor: Descriptor,
    /// Bright pairs with the dark pairs of their exposure times.
    pub points: Vec<TemporalPoint>,
    /// Dark pairs of exposure times without a bright pair.
    pub more_dark: Vec<DarkPoint>,
    /// Dark and bright stack, where there are both.
    pub stacks: Option<[SpatialStack; 2]>,
    /// Warnings about the images; of several with the same warning, the first is named.
    pub warnings: Vec<String>,
}

/// Reads a descriptor and the images that it names. `taken` is called after each, and may end the work. Several dark
/// pairs of one exposure time count as their mean.
pub fn read_set(path: &Path, taken: &dyn Fn() -> Result<()>) -> Result<MeasuredSet> {
    let text = input::read_at_most(path, input::TREE_BYTES).and_then(text::decode_any);
    let text = text.map_err(|reason| Error::io(path, "read", reason))?;
    let descriptor = Descriptor::parse(&text).map_err(|(line, invalid)| invalid.at_line(path, line))?;
    let Descriptor { width, height, .. } = descriptor;
    let bytes = (width as u64).saturating_mul(height as u64).saturating_mul(PIXEL);
    memory::check(bytes, &format!("evaluating images of {width} × {height} pixels"), "use smaller images")
        .map_err(|invalid| invalid.in_file(path))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let reader = ImageReader { folder, descriptor: &descriptor, taken, said: RefCell::default() };
    let unfit = |message: String| Invalid::new("", message).in_file(path);

    let mut dark_pairs: Vec<(f64, PairStatistics)> = Vec::new();
    let mut bright_pairs: Vec<(&Series, PairStatistics)> = Vec::new();
    let mut stacks: [Option<(f64, SpatialStack)>; 2] = [None, None];
    for series in &descriptor.series {
        if series.is_stack() {
            let place = usize::from(series.light != Light::Dark);
            if stacks[place].is_some() {
                let kind = ["dark", "bright"][place];
                return Err(unfit(format!("there is more than one stack of more than two {kind} images")));
            }
            stacks[place] = Some((series.exposure_ns, reader.stack(series)?));
        } else {
            let pair = reader.pair(series)?;
            match series.light {
                Light::Dark => dark_pairs.push((series.exposure_ns, pair)),
                Light::Bright { .. } => bright_pairs.push((series, pair)),
            }
        }
    }
    let point = |(series, bright): &(&Series, PairStatistics)| {
        let darks: Vec<&PairStatistics> =
            dark_pairs.iter().filter(|(time, _)| *time == series.exposure_ns).map(|(_, pair)| pair).collect();
        if darks.is_empty() {
            return Err(unfit(format!("there is no dark pair with the exposure time of {} ns", series.exposure_ns)));
        }
        let of_darks =
            |value: fn(&PairStatistics) -> f64| darks.iter().map(|pair| value(pair)).sum::<f64>() / darks.len() as f64;
        Ok(TemporalPoint {
            time: series.time(),
            photons: series.light.photons(),
            mean: bright.mean,
            variance: bright.variance,
            dark_mean: of_darks(|pair| pair.mean),
            dark_variance: of_darks(|pair| pair.variance),
        })
    };
    let points: Vec<TemporalPoint> = bright_pairs.iter().map(point).collect::<Result<_>>()?;
    let mut alone = dark_pairs.clone();
    alone.retain(|(time, _)| bright_pairs.iter().all(|(series, _)| series.exposure_ns != *time));
    alone.sort_by(|a, b| a.0.total_cmp(&b.0));
    let of_time = |pairs: &[(f64, PairStatistics)]| {
        let mean = |value: fn(&PairStatistics) -> f64| {
            pairs.iter().map(|(_, pair)| value(pair)).sum::<f64>() / pairs.len() as f64
        };
        let time = Seconds(pairs.first().map_or(0.0, |(time, _)| time * 1e-9));
        DarkPoint { time, mean: mean(|pair| pair.mean), variance: mean(|pair| pair.variance) }
    };
    let more_dark = alone.chunk_by(|a, b| a.0 == b.0).map(of_time).collect();
    let stacks = match stacks {
        [Some((dark_time, dark)), Some((bright_time, bright))] if dark_time == bright_time => Some([dark, bright]),
        [None, None] => None,
        [_, _] => {
            return Err(unfit("the stacks are not a dark and a bright one with the same exposure time".to_owned()));
        }
    };
    let warnings = reader.said.take().into_iter().map(Said::in_words).collect();
    Ok(MeasuredSet { points, more_dark, stacks, descriptor, warnings })
}

struct ImageReader<'a> {
    folder: &'a Path,
    descriptor: &'a Descriptor,
    taken: &'a dyn Fn() -> Result<()>,
    said: RefCell<Vec<Said>>,
}

/// Statement about images of a set.
struct Said {
    what: String,
    first: String,
    others: usize,
}

impl Said {
    fn in_words(self) -> String {
        let Self { what, first, others } = self;
        match others {
            0 => format!("{first}: {what}"),
            _ => format!("{first}: {what}; the same holds of {}", counted(others, ["other image", "other images"])),
        }
    }
}

impl ImageReader<'_> {
    fn pair(&self, series: &Series) -> Result<PairStatistics> {
        // The parser lets no series pass that has fewer than two images.
        let images = [self.image(&series.images[0])?, self.image(&series.images[1])?];
        PairStatistics::new(&images[0], &images[1]).map_err(|invalid| invalid.in_file(self.folder))
    }

    fn stack(&self, series: &Series) -> Result<SpatialStack> {
        let mut stack = SpatialStack::new(self.descriptor.width, self.descriptor.height);
        for name in &series.images {
            stack.add(&self.image(name)?).map_err(|invalid| invalid.in_file(self.folder))?;
        }
        Ok(stack)
    }

    fn image(&self, name: &str) -> Result<Vec<u16>> {
        let path = self.folder.join(name);
        let image = read_image_file(&path, Pixels::Active)?.whole().map_err(|invalid| invalid.in_file(&path))?;
        let mut said = self.said.borrow_mut();
        for note in image.said() {
            let what = note.strip_prefix(&format!("{}: ", image.name)).unwrap_or(&note).to_owned();
            match said.iter_mut().find(|said| said.what == what) {
                Some(said) => said.others += 1,
                None => said.push(Said { what, first: image.name.clone(), others: 0 }),
            }
        }
        let Descriptor { width, height, .. } = *self.descriptor;
        let planes = &image.mean;
        if [planes.width(), planes.height()] != [width, height] {
            let message = format!("{} × {} pixels instead of {width} × {height}", planes.width(), planes.height());
            return Err(Invalid::new("", message)
                .help("all images of a set have the size of its line n")
                .in_file(&path));
        }
        let is_number = |y: &f32| (0.0..=65_535.0).contains(y) && y.fract() == 0.0;
        let [plane] = planes.channels() else { return Err(no_digital_numbers(&path)) };
        if !plane.data.iter().all(is_number) {
            return Err(no_digital_numbers(&path));
        }
        (self.taken)()?;
        Ok(plane.data.iter().map(|&y| y as u16).collect())
    }
}

fn no_digital_numbers(path: &Path) -> Error {
    let help = "give images of one grey plane: TIFF, PNG, DNG, PGM or NPY; of a colour sensor one channel alone";
    Invalid::new("", "does not hold one plane of digital numbers").help(help).in_file(path)
}
