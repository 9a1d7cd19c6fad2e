//! The survey of a camera's images: statistics of every group, checked for being of one camera, with the dark signal and
//! the photon transfer that follow.

use photosite_core::units::Celsius;
use photosite_core::{Invalid, Result};

use super::dark_model::{DarkFrames, DarkModel};
use super::frame_group::{CameraFrames, FrameGroup};
use super::frame_stack::{Parts, StackStatistics};
use super::lines::MeasuredLine;
use super::measured::Measured;
use super::patterns::MendedFrames;
use super::photon_transfer::{BrightFrames, PhotonTransfer};

/// Statistics of all groups that have any, at one temperature and others.
pub(super) struct Survey {
    pub(super) dark: DarkModel,
    /// Numbers of the groups of the dark model's frames.
    pub(super) dark_groups: Vec<usize>,
    pub(super) transfer: PhotonTransfer,
    /// Lines of dark signals over time at other temperatures.
    pub(super) elsewhere: Vec<(Celsius, MeasuredLine)>,
    pub(super) temperature: Option<Celsius>,
    pub(super) statistics: Vec<Option<StackStatistics>>,
}

impl Survey {
    pub(super) fn new(frames: &MendedFrames<'_>) -> Result<Self> {
        let groups = frames.frames.groups;
        let statistics = |(number, group): (usize, &FrameGroup)| {
            if group.images.len() < 2 {
                return Ok(None);
            }
            let found = frames.stack(number)?.statistics().map_err(|e| e.in_file(group.images[0].as_ref()))?;
            agree(group, &found)?;
            Ok(Some(found))
        };
        let statistics: Vec<Option<StackStatistics>> =
            groups.iter().enumerate().map(statistics).collect::<Result<_>>()?;
        let of = |number: usize| statistics[number].clone();
        let temperature = main_temperature(groups);
        let is_main = |group: &FrameGroup| group.temperature.is_none() || group.temperature == temperature;
        let (mut dark_groups, mut dark, mut bright) = (Vec::new(), Vec::new(), Vec::new());
        for (number, group) in groups.iter().enumerate().filter(|(_, group)| is_main(group)) {
            let Some(statistics) = of(number) else { continue };
            if group.is_dark() {
                dark_groups.push(number);
                dark.push(DarkFrames { time: group.time, statistics });
            } else {
                bright.push(BrightFrames { group: number, time: group.time, photons: group.photons(), statistics });
            }
        }
        if dark.is_empty() {
            let first = groups.iter().flat_map(|g| &g.images).next().map(String::as_str).unwrap_or_default();
            let message =
                "there is no pair of dark images, without which neither the black level nor any noise is known";
            let help = "take two images or more with the cap on, at the exposure times of the bright ones";
            return Err(Invalid::new("", message).help(help).in_file(first.as_ref()));
        }
        one_black_level(groups, &dark_groups, &dark)?;
        let dark = DarkModel::new(dark);
        let transfer = PhotonTransfer::new(&bright, &dark);
        let elsewhere = other_temperatures(groups, temperature, &statistics);
        Ok(Self { dark, dark_groups, transfer, elsewhere, temperature, statistics })
    }

    /// Group of dark images that the dark pattern is taken of: that with the most images, of these the shortest.
    pub(super) fn dark_reference(&self) -> usize {
        let frames = self.dark.frames().iter().enumerate();
        let key = |f: &DarkFrames| (usize::MAX - f.statistics.images, f.time.map_or(0.0, |t| t.0).to_bits());
        frames.min_by_key(|(_, f)| key(f)).map_or(0, |(i, _)| i)
    }

    /// Dark current at each temperature, DN/s, where the dark signal rises with time.
    pub(super) fn dark_currents(&self) -> Vec<(Option<Celsius>, Measured)> {
        let main = self.dark.mean.map(|line| (self.temperature, line.slope));
        let others = self.elsewhere.iter().map(|(celsius, line)| (Some(*celsius), line.slope));
        main.into_iter().chain(others).collect()
    }

    /// Statements about the images.
    pub(super) fn notes(&self, frames: &CameraFrames<'_>) -> Vec<String> {
        let mut notes = Vec::new();
        for (group, statistics) in frames.groups.iter().zip(&self.statistics) {
            match statistics {
                None => notes.push(format!("{}: nothing goes with this image; it is left out", group.name)),
                Some(found) if !group.is_dark() => notes.extend(self.drift(group, found)),
                Some(_) => {}
            }
        }
        let without_dark = self.transfer.points.iter().filter(|p| !p.has_dark).map(|p| &frames.groups[p.group].name);
        let without_dark: Vec<&String> = without_dark.collect();
        if let Some(first) = without_dark.first() {
            let others = match without_dark.len() - 1 {
                0 => String::new(),
                n => format!(" and of {n} more"),
            };
            notes.push(format!(
                "there are no dark images with the exposure time of {first}{others}: those of other times stand for them"
            ));
        }
        notes
    }

    /// Light that was not the same in all images of a group.
    fn drift(&self, group: &FrameGroup, found: &StackStatistics) -> Option<String> {
        let (low, high, difference, error) = found.drift();
        let signal = found.mean.value - self.dark.at(group.time).mean.value;
        let percent = 100.0 * difference / signal;
        // The extremes of many means lie some errors apart by chance, and what is below a thousandth spoils nothing.
        (difference > 6.0 * error && percent.abs() > 0.1).then(|| {
            let [low, high] = [low, high].map(|i| &group.images[i]);
            format!("the light drifts: {high} is {percent:.2} % brighter than {low}, which should be alike")
        })
    }
}

/// Refuses images that are not of the same light or camera: means that lie further apart than the noise of a pixel in
/// the dark, or by a tenth of the signal in the light.
fn agree(group: &FrameGroup, found: &StackStatistics) -> Result<()> {
    let (low, high, difference, _) = found.drift();
    let noise = found.temporal.pixel.value.sqrt().max(1.0);
    let limit = if group.is_dark() { 4.0 * noise } else { (0.1 * found.mean.value).max(4.0 * noise) };
    if difference <= limit {
        return Ok(());
    }
    let [low, high] = [low, high].map(|i| (&group.images[i], found.image_means[i]));
    let message =
        format!("has a mean of {:.1} DN, and {} one of {:.1} DN, which should be alike", high.1, low.0, low.1);
    let help = if group.is_dark() {
        "dark images of one exposure time must be of the same camera and settings, with its cap on"
    } else {
        "images of one light must be alike within a tenth; put those of each brightness into a folder of their own"
    };
    Err(Invalid::new("", message).help(help).in_file(high.0.as_ref()))
}

/// Refuses dark images of two cameras or settings: black levels that do not follow the exposure time.
fn one_black_level(groups: &[FrameGroup], numbers: &[usize], dark: &[DarkFrames]) -> Result<()> {
    let mut order: Vec<usize> = (0..dark.len()).collect();
    order.sort_by(|&a, &b| dark[a].time.map_or(0.0, |t| t.0).total_cmp(&dark[b].time.map_or(0.0, |t| t.0)));
    for pair in order.windows(2) {
        let [short, long] = [&dark[pair[0]], &dark[pair[1]]];
        let [a, b] = [&short.statistics, &long.statistics];
        let noise = a.temporal.pixel.value.max(b.temporal.pixel.value).sqrt().max(1.0);
        let rises = long.time > short.time;
        let difference = b.mean.value - a.mean.value;
        // A dark current may raise the signal without limit, its own noise with it; nothing lets it fall or leap.
        if difference < -4.0 * noise || (!rises && difference > 4.0 * noise) {
            let [first, second] = [pair[0], pair[1]].map(|i| &groups[numbers[i]].name);
            let message =
                format!("has a dark level of {:.1} DN, and {first} one of {:.1} DN", b.mean.value, a.mean.value);
            let help = "give images of one camera with one gain and black level; dark signals do not fall with time";
            return Err(Invalid::new("", message).help(help).in_file(second.as_ref()));
        }
    }
    Ok(())
}

/// Temperature of the bright images, or of most dark ones.
fn main_temperature(groups: &[FrameGroup]) -> Option<Celsius> {
    let bright = groups.iter().filter(|g| !g.is_dark()).find_map(|g| g.temperature);
    bright.or_else(|| {
        let known: Vec<Celsius> = groups.iter().filter_map(|g| g.temperature).collect();
        let count = |celsius: &Celsius| known.iter().filter(|other| *other == celsius).count();
        known.iter().copied().reduce(|best, next| if count(&next) > count(&best) { next } else { best })
    })
}

/// Lines of the dark signal over time at temperatures other than that of most images.
fn other_temperatures(
    groups: &[FrameGroup],
    main: Option<Celsius>,
    statistics: &[Option<StackStatistics>],
) -> Vec<(Celsius, MeasuredLine)> {
    let known = || groups.iter().zip(statistics).filter(|(g, _)| g.is_dark());
    let mut celsius: Vec<f64> = known().filter_map(|(g, _)| Some(g.temperature?.0)).collect();
    celsius.sort_by(f64::total_cmp);
    celsius.dedup();
    let line = |celsius: f64| {
        let here = known().filter(|(g, _)| g.temperature == Some(Celsius(celsius)));
        let points = here.filter_map(|(g, s)| Some((g.time?.0, s.as_ref()?.mean)));
        Some((Celsius(celsius), MeasuredLine::through(&points.collect::<Vec<_>>())?))
    };
    celsius.into_iter().filter(|c| main != Some(Celsius(*c))).filter_map(line).collect()
}

impl Survey {
    /// Exposure time of the dark reference, s, where it is known.
    pub(super) fn reference_time(&self) -> Option<f64> {
        self.dark.frames()[self.dark_reference()].time.map(|t| t.0)
    }

    /// Variances of noise, DN², without light or time.
    pub(super) fn dark_variances(&self) -> Parts {
        self.dark.line_variances()
    }
}
