//! Parts of a render: some samples of every pixel, which are no image yet.
//!
//! A part is a folder with the sums of its samples, `film.npy.gz` (numbered where a camera moves), and `part.json`,
//! written last, which says what they are the sums of. Sensor, noise and development come when all are together.

use photosite_core::{Help, Remedy, input};
use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use photosite_capture::Capture;
use photosite_core::{Error, Invalid, Result};
use photosite_files::file_sum::FileSum;
use photosite_files::film_file::FilmReader;
use photosite_files::light_rows::LightRows;
use photosite_transport::film::{Film, FilmResponses, Response};
use photosite_transport::integrator::{Device, PathLimits, PathTracer};
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::Scene;
use serde_json::Value;

use super::completed_rows::CompletedRows;
use crate::camera::capture_camera::pixels;
use crate::prepare::strips::Strips;
use crate::write::file_names::{PART, named};
use crate::write::output_folder::OutputFolder;
use crate::write::provenance::{DEVICE, FINGERPRINT, difference, provenance};
use photosite_capture::report::{PartReport, REPORT};

/// Refuses samples that are no part of what a capture asks for.
pub fn check_samples(samples: &Range<u32>, capture: &Capture) -> Result<()> {
    let refuse = |key: &str, message: &str, help: &str| {
        Err(capture.source().error(Invalid::new(key, message).help(help).within("render")))
    };
    let help = "remove it, and write samples_per_pixel";
    if capture.render().noise_target.is_some() {
        return refuse(
            "noise_target",
            "cannot be combined with a part of the samples: no part knows the noise of the whole",
            help,
        );
    }
    if capture.render().time_limit_s.is_some() {
        return refuse("time_limit_s", "cannot be combined with a part of the samples: parts would end anywhere", help);
    }
    let count = capture.render().samples_per_pixel;
    if samples.end > count {
        let message = format!("the samples {}..{}: there are {count} samples per pixel", samples.start, samples.end);
        let more = Remedy::Override(format!("render.samples_per_pixel={}", samples.end));
        let help = Help::any([Remedy::Say(format!("write at most 0..{count}")), more]);
        return Err(Error::Usage { message, help: Some(help) });
    }
    Ok(())
}

/// Name of the device that has traced parts, perhaps of another machine.
#[derive(Debug)]
pub struct FormerDevice(String);

impl FormerDevice {
    /// The device of parts by [`DEVICE`] of their provenance, or of the identity of their data set; `None` where the
    /// processor traced them.
    pub fn of(device: Option<&Value>) -> Option<Arc<dyn Device>> {
        Some(Arc::new(Self(device?.as_str()?.to_owned())))
    }
}

impl Device for FormerDevice {
    fn name(&self) -> String {
        self.0.clone()
    }

    fn load(&self, _: &Scene, _: PathLimits, _: SamplerKind) -> Result<Box<dyn PathTracer>, Invalid> {
        Err(Invalid::new("", format!("is of parts that {} has traced, which are merged", self.0)))
    }
}

/// All parts of a render, in the order of their samples.
pub struct Parts {
    parts: Vec<(PathBuf, PartReport)>,
}

impl Parts {
    /// Reads folders that hold all samples of one render, each of them once.
    pub fn read(folders: &[PathBuf]) -> Result<Self> {
        let read = |folder: &PathBuf| Ok((folder.clone(), read_part(folder)?));
        let mut parts = folders.iter().map(read).collect::<Result<Vec<_>>>()?;
        parts.sort_by_key(|(_, part)| part.samples);
        let refuse = |message: String, help: Help| Err(Error::Usage { message, help: Some(help) });
        let range = |[a, b]: [u32; 2]| format!("{a}..{b}");
        for ((folder, part), (next_folder, next)) in parts.iter().zip(&parts[1..]) {
            let [one, two] = [folder, next_folder].map(|folder| folder.display());
            if part.provenance.get(FINGERPRINT) != next.provenance.get(FINGERPRINT) {
                let [earlier, now] = [part, next].map(|part| Value::Object(part.provenance.clone()));
                let difference = difference(&earlier, &now);
                let message = format!("{one} and {two} are not parts of the same render: in {two}, {difference}");
                return refuse(message, "give parts of the same capture, seed and version".into());
            }
            if next.samples[0] < part.samples[1] {
                let both = [next.samples[0], part.samples[1].min(next.samples[1])];
                let message = format!("{one} and {two} both hold the samples {}", range(both));
                return refuse(message, "give each sample once".into());
            }
        }
        // Gaps between neighbours, and before the first and after the last.
        let (first, last) = (&parts[0], &parts[parts.len() - 1]);
        let missing = |from: u32, to: u32, place: String| {
            let part = range([from, to]);
            let message = format!("the samples {part} are missing {place}");
            refuse(message, Remedy::Samples([from, to]).into())
        };
        if first.1.samples[0] > 0 {
            return missing(0, first.1.samples[0], format!("before those of {}", first.0.display()));
        }
        for ((folder, part), (next_folder, next)) in parts.iter().zip(&parts[1..]) {
            if part.samples[1] < next.samples[0] {
                let place = format!("between {} and {}", folder.display(), next_folder.display());
                return missing(part.samples[1], next.samples[0], place);
            }
        }
        if last.1.samples[1] < last.1.samples_per_pixel {
            let place = format!("after those of {}", last.0.display());
            return missing(last.1.samples[1], last.1.samples_per_pixel, place);
        }
        Ok(Self { parts })
    }

    /// Report of the first part, which all others share but for their samples.
    pub fn first(&self) -> &PartReport {
        &self.parts[0].1
    }

    /// A capture on the device that traced the parts, which traces nothing more: it stands in the provenance of both.
    pub fn on_their_device(&self, capture: Capture) -> Capture {
        match FormerDevice::of(self.first().provenance.get(DEVICE)) {
            Some(device) => capture.on_device(device),
            None => capture,
        }
    }

    /// Seconds that all of them were traced for, where that is known.
    pub fn trace_s(&self) -> Option<f64> {
        self.parts.iter().map(|(_, part)| part.trace_s).sum()
    }

    /// Refuses a capture that is not, or no longer, the one that the parts were made of.
    pub(crate) fn check(&self, capture: &Capture) -> Result<()> {
        let now = provenance(capture)?;
        let (folder, part) = &self.parts[0];
        if part.provenance.get(FINGERPRINT) == now.get(FINGERPRINT) {
            return Ok(());
        }
        let difference = difference(&Value::Object(part.provenance.clone()), &Value::Object(now));
        let message = format!(
            "{} is a part of something else than {} is now: {difference}",
            folder.display(),
            capture.source().path().display()
        );
        Err(Error::Usage { message, help: Some("render its parts again, or undo the change".into()) })
    }

    /// Light of all samples, of the image of that number where a camera moves.
    pub(crate) fn light(
        &self,
        number: Option<u32>,
        capture: &Capture,
        responses: &[Response],
        strips: &Strips,
        folder: &OutputFolder,
    ) -> Result<Arc<LightRows>> {
        let size = pixels(capture).map(|n| n as usize);
        let open = |(folder, part): &(PathBuf, PartReport)| {
            let path = folder.join(named("film", number, "npy.gz"));
            let unreadable = |reason| Error::io(&path, "read", reason);
            // Before any of it is taken for light
            let found = FileSum::of(&path).map_err(unreadable)?;
            let known = path.file_name().and_then(|name| part.sums.get(&*name.to_string_lossy()));
            if known != Some(&found) {
                let message = format!("is damaged: its checksum does not match {PART}");
                return Err(Invalid::new("", message).help("render that part again").in_file(&path));
            }
            let file = input::open(&path).map_err(unreadable)?;
            let sums = FilmReader::compressed(size, responses.len(), BufReader::new(file));
            let sums = sums.map_err(|invalid| invalid.in_file(&path))?;
            Ok((path, part.samples[1] - part.samples[0], sums))
        };
        let mut parts = self.parts.iter().map(open).collect::<Result<Vec<_>>>()?;
        let light = CompletedRows::light(capture, responses, strips.are_several().then(|| folder.store()).transpose()?);
        let responses = FilmResponses::new(responses);
        for rows in strips.from(0) {
            let mut film = Film::of_rows(size[0], rows, responses.clone());
            for (path, count, sums) in &mut parts {
                sums.add_to(&mut film, *count).map_err(|invalid| invalid.in_file(path))?;
            }
            light.write(&film).map_err(|reason| Error::io(folder.path(), "write into", reason))?;
        }
        Ok(light)
    }
}

/// Reads the report of a folder that holds a part.
pub(crate) fn read_part(folder: &Path) -> Result<PartReport> {
    let path = folder.join(PART);
    if !path.exists() {
        let whole = folder.join(REPORT).exists();
        let message = if whole {
            "contains a whole image, not a part of one".to_owned()
        } else {
            format!("does not contain a part of a render: there is no {PART}")
        };
        let help = "give folders that contain a finished part; one that was broken off has to be rendered \
                    again";
        return Err(Invalid::new("", message).help(help).in_file(folder));
    }
    let text = input::read_text(&path, input::TREE_BYTES).map_err(|reason| Error::io(&path, "read", reason))?;
    let damaged =
        |what: String| Invalid::new("", format!("is damaged: {what}")).help("render that part again").in_file(&path);
    let part: PartReport = serde_json::from_str(&text).map_err(|error| damaged(error.to_string()))?;
    if part.samples[0] >= part.samples[1] || part.samples[1] > part.samples_per_pixel {
        return Err(damaged(format!("samples {:?} of {}", part.samples, part.samples_per_pixel)));
    }
    if !part.provenance.get(FINGERPRINT).is_some_and(Value::is_string) {
        return Err(damaged(format!("it has no {FINGERPRINT}")));
    }
    Ok(part)
}
