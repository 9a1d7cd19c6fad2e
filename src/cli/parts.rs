//! Parts of a render: some samples of every pixel, which are no picture yet.
//!
//! A part is a folder with the sums of its samples, `film.npy` (numbered where a camera moves), and `part.json`, written
//! last, which says what they are the sums of. Sensor, noise and development come when all are together.

use std::fs::File;
use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};

use photosite::film::{Film, FilmResponses, Response};
use photosite::io::capture::{Capture, REPORT, real_path};
use photosite::io::film_file::FilmReader;
use photosite::io::light_rows::LightRows;
use photosite::{Error, Invalid, Result};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::film_memory::Strips;
use super::fingerprint::{difference, fingerprinted, keys_and_files};
use super::kept_rows::KeptRows;
use super::output_folder::{OutputFolder, PART, named};
use super::render::{Light, Request, pixels};

/// The object that `part.json` holds.
#[derive(Deserialize, Serialize)]
pub(super) struct PartReport {
    /// The first sample of every pixel, and the one after the last.
    pub(super) samples: [u32; 2],
    /// Of the whole render.
    pub(super) samples_per_pixel: u32,
    /// What was rendered, as it reads from the picture's folder or the data set file, and where it is.
    pub(super) input: String,
    pub(super) path: PathBuf,
    pub(super) overrides: Vec<String>,
    /// Left out where the same input shall give the same bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) trace_s: Option<f64>,
    pub(super) files: Vec<String>,
    /// Names of the film's channels.
    channels: Vec<String>,
    /// What all parts of a render have in common, beside the above: [`makings`].
    #[serde(flatten)]
    makings: Map<String, Value>,
}

/// Everything that decides what a render gives.
pub(super) fn makings(capture: &Capture) -> Result<Map<String, Value>> {
    let mut hashes = Map::new();
    let keys = keys_and_files(capture, &mut hashes)?;
    Ok(fingerprinted(json!({
        "photosite_version": env!("CARGO_PKG_VERSION"),
        "capture": keys,
        "files_sha256": hashes,
    })))
}

impl PartReport {
    /// Of a render of some samples of so many in all; `trace_s` is kept where the request is timed.
    pub(super) fn new(
        request: &Request<'_>,
        samples_per_pixel: u32,
        makings: Map<String, Value>,
        responses: &[Response],
        files: Vec<String>,
        trace_s: f64,
    ) -> Self {
        let samples = match &request.light {
            Light::Part(samples) => [samples.start, samples.end],
            Light::Traced | Light::Merged(_) => [0, samples_per_pixel],
        };
        Self {
            samples,
            samples_per_pixel,
            input: request.named.clone(),
            path: real_path(request.input),
            overrides: request.overrides.clone(),
            trace_s: request.is_timed.then_some(trace_s),
            files,
            channels: responses.iter().map(|response| response.name.clone()).collect(),
            makings,
        }
    }
}

/// Refuses samples that are no part of what a capture asks for.
pub(super) fn check_samples(samples: &Range<u32>, capture: &Capture) -> Result<()> {
    let refuse = |key: &str, message: &str, help: &str| {
        Err(capture.source.error(Invalid::new(key, message).help(help).within("render")))
    };
    let help = "remove it, and write samples_per_pixel";
    if capture.render.noise_target.is_some() {
        return refuse("noise_target", "cannot go with --samples: no part knows the noise of the whole", help);
    }
    if capture.render.time_limit.is_some() {
        return refuse("time_limit_s", "cannot go with --samples: parts would end anywhere", help);
    }
    let count = capture.render.samples_per_pixel;
    if samples.end > count {
        let message = format!("--samples {}..{}: there are {count} samples a pixel", samples.start, samples.end);
        let help = format!("write at most 0..{count}, or add --set render.samples_per_pixel={}", samples.end);
        return Err(Error::Usage { message, help: Some(help) });
    }
    Ok(())
}

/// All parts of a render, in the order of their samples.
pub(super) struct Parts {
    parts: Vec<(PathBuf, PartReport)>,
}

impl Parts {
    /// Reads folders that hold all samples of one render, each of them once.
    pub(super) fn read(folders: &[PathBuf]) -> Result<Self> {
        let read = |folder: &PathBuf| Ok((folder.clone(), read_report(folder)?));
        let mut parts = folders.iter().map(read).collect::<Result<Vec<_>>>()?;
        parts.sort_by_key(|(_, part)| part.samples);
        let refuse = |message: String, help: &str| Err(Error::Usage { message, help: Some(help.to_owned()) });
        let range = |[a, b]: [u32; 2]| format!("{a}..{b}");
        for ((folder, part), (next_folder, next)) in parts.iter().zip(&parts[1..]) {
            let [one, two] = [folder, next_folder].map(|folder| folder.display());
            if part.makings["fingerprint"] != next.makings["fingerprint"] {
                let [earlier, now] = [part, next].map(|part| Value::Object(part.makings.clone()));
                let difference = difference(&earlier, &now);
                let message = format!("{one} and {two} are no parts of the same render: in {two}, {difference}");
                return refuse(message, "give parts of the same capture, seed and version");
            }
            if next.samples[0] < part.samples[1] {
                let both = [next.samples[0], part.samples[1].min(next.samples[1])];
                let message = format!("{one} and {two} both hold the samples {}", range(both));
                return refuse(message, "give each sample once");
            }
        }
        // Gaps between neighbours, and before the first and after the last.
        let (first, last) = (&parts[0], &parts[parts.len() - 1]);
        let missing = |from: u32, to: u32, place: String| {
            let part = range([from, to]);
            let message = format!("the samples {part} are missing {place}");
            refuse(message, &format!("render them with --samples {part}"))
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

    /// What the first says, which all say but for their samples.
    pub(super) fn first(&self) -> &PartReport {
        &self.parts[0].1
    }

    /// Seconds that all of them were traced for, where that is known.
    pub(super) fn trace_s(&self) -> Option<f64> {
        self.parts.iter().map(|(_, part)| part.trace_s).sum()
    }

    /// Refuses a capture that is not, or no longer, the one that the parts were made of.
    pub(super) fn check(&self, capture: &Capture) -> Result<()> {
        let now = makings(capture)?;
        let (folder, part) = &self.parts[0];
        if part.makings["fingerprint"] == now["fingerprint"] {
            return Ok(());
        }
        let difference = difference(&Value::Object(part.makings.clone()), &Value::Object(now));
        let message = format!(
            "{} is a part of something else than {} is now: {difference}",
            folder.display(),
            capture.source.path().display()
        );
        Err(Error::Usage { message, help: Some("render its parts again, or undo the change".to_owned()) })
    }

    /// The light of all samples, of the picture of that number where a camera moves.
    pub(super) fn light(
        &self,
        number: Option<u32>,
        capture: &Capture,
        responses: &[Response],
        strips: Strips,
        folder: &OutputFolder,
    ) -> Result<LightRows> {
        let size = pixels(capture).map(|n| n as usize);
        let open = |(folder, part): &(PathBuf, PartReport)| {
            let path = folder.join(named("film", number, "npy"));
            let file = File::open(&path).map_err(|reason| Error::io(&path, "read", reason))?;
            let sums = FilmReader::new(size, responses.len(), BufReader::new(file));
            let sums = sums.map_err(|invalid| invalid.in_file(&path))?;
            Ok((path, part.samples[1] - part.samples[0], sums))
        };
        let mut parts = self.parts.iter().map(open).collect::<Result<Vec<_>>>()?;
        let light = KeptRows::light(capture, responses, strips.are_several().then(|| folder.store()).transpose()?);
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

fn read_report(folder: &Path) -> Result<PartReport> {
    let path = folder.join(PART);
    if !path.exists() {
        let whole = folder.join(REPORT).exists();
        let message = if whole {
            "holds a whole picture and no part of one".to_owned()
        } else {
            format!("holds no part of a render: there is no {PART}")
        };
        let help = "give folders that photosite render --samples A..B filled; one that was broken off has to be rendered \
                    again";
        return Err(Invalid::new("", message).help(help).in_file(folder));
    }
    let text = std::fs::read(&path).map_err(|reason| Error::io(&path, "read", reason))?;
    let damaged =
        |what: String| Invalid::new("", format!("is damaged: {what}")).help("render that part again").in_file(&path);
    let part: PartReport = serde_json::from_slice(&text).map_err(|error| damaged(error.to_string()))?;
    if part.samples[0] >= part.samples[1] || part.samples[1] > part.samples_per_pixel {
        return Err(damaged(format!("samples {:?} of {}", part.samples, part.samples_per_pixel)));
    }
    Ok(part)
}
