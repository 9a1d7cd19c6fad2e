//! The folder that a render fills.

use photosite_core::{Help, Remedy};
use std::collections::BTreeMap;
use std::fs;
use std::fs::File;
use std::io::{ErrorKind, Result as IoResult, Seek};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use photosite_calibration::truth::TruthLayer;
use photosite_capture::{NoiseOutput, OutputSettings, SpectralBands, TruthOutput};
use photosite_core::cleanup::Cleanup;
use photosite_core::colour::ColourSpace;
use photosite_core::image::Planes;
use photosite_core::output::{Sink, Stamp, create_folders, remove_leftovers, write_stamped, write_unsynced};
use photosite_core::units::Seconds;
use photosite_core::{Error, Invalid, Result};
use photosite_develop::{DevelopSettings, EncodedImage, encode, with_layout};
use photosite_files::developed::{write_hdr, write_linear, write_png};
use photosite_files::electrons::write_electrons;
use photosite_files::file_sum::FileSum;
use photosite_files::film_file::{write_compressed, write_samples};
use photosite_files::formats::FORMATS;
use photosite_files::light_rows::{LightRows, Store};
use photosite_files::lock::Lock;
use photosite_files::noise_maps::{NoiseFormat, write_noise_exr, write_noise_npy};
use photosite_files::spectral_exr::write_irradiance;
use photosite_files::truth::{TruthFormat, write_truth_exr, write_truth_npy, write_truth_png};
use photosite_raw::RawImage;
use photosite_sensor::{NoiseMap, NoiseMaps};
use serde::Serialize;

use super::checkpoint;
use super::file_names::{PART, named};
use crate::expose::chain::CollectedElectrons;
use photosite_capture::report::{ObjectsReport, PartReport, REPORT, Report, ReportFiles};
use photosite_core::locked::locked;
use photosite_files::pretty_json::pretty_json;

/// Results that a render may leave besides the report: names with their kinds, numbered or not. None of these is
/// overwritten unasked: a texture may be called `image.png`.
const RESULTS: [(&str, &[&str]); 9] = [
    ("film", &["npy.gz"]),
    ("image", &["png"]),
    ("hdr", &["exr"]),
    ("ideal", &["exr", "png"]),
    ("electrons", &["exr"]),
    ("irradiance", &["exr"]),
    ("samples", &["npy"]),
    (TRUTH, &["exr"]),
    (NOISE, &["exr"]),
];
/// Begin of the names of files of ground truth.
const TRUTH: &str = "truth";
/// Begin of the names of files of noise maps.
const NOISE: &str = "noise";
/// Name of the image that is there while a render runs.
const PREVIEW: &str = "preview.png";

/// Mark that is there while results are written, so that those of a process that was killed do not pass for somebody's
/// files.
const UNFINISHED: &str = ".photosite.unfinished";

/// A folder for results. One that is given up before they are complete holds none of them, but for those that a
/// checkpoint goes on from.
pub struct OutputFolder {
    path: PathBuf,
    force: bool,
    written: Vec<String>,
    /// Checksums of the files that were written.
    sums: BTreeMap<String, FileSum>,
    /// Stamps that tell the files that were written from any that another process writes.
    stamps: BTreeMap<String, Stamp>,
    /// The files that were written, until they are complete; removed before another process can claim the folder.
    unfinished: Arc<Mutex<Vec<PathBuf>>>,
    _removal: Option<Cleanup>,
    /// Lock that keeps other processes out, of a folder that they know. It is let go of before the folder is given up.
    lock: Option<Lock>,
    _cleanup: Cleanup,
}

impl OutputFolder {
    /// Creates the folder where missing. One that holds files of the same names is refused unless `force` is given, or
    /// a render was broken off there; one that another process is writing to is refused in any case.
    pub fn claim(path: &Path, force: bool) -> Result<Self> {
        refuse_results(path, force)?;
        if let Some(file) = path.ancestors().find(|part| part.is_file()) {
            return Err(unusable(file, "is a file, but a folder is needed for the results"));
        }
        let created: Vec<_> = path.ancestors().take_while(|part| !part.exists()).map(Path::to_owned).collect();
        let mut folder = Self::inside(path, force, created);
        create_folders(path).map_err(|reason| unusable(path, format!("cannot create the folder: {reason}")))?;
        // Whether files can be made here shows now rather than after an hour of tracing.
        tempfile::tempfile_in(path)
            .map_err(|reason| unusable(path, format!("cannot write into the folder: {reason}")))?;
        let lock = Lock::of_folder(path)?;
        // Another process may have finished in the meantime.
        refuse_results(path, force)?;
        folder.lock = Some(lock);
        let (path, unfinished) = (path.to_owned(), Arc::clone(&folder.unfinished));
        folder._removal = Some(Cleanup::new(move || {
            let is_kept = checkpoint::are_in(&path);
            for file in locked(&unfinished).drain(..).filter(|file| !is_kept || file.ends_with(UNFINISHED)) {
                let _ = fs::remove_file(file);
            }
        }));
        Ok(folder)
    }

    /// A folder that no other process knows.
    pub fn own(path: &Path) -> Self {
        Self::inside(path, true, Vec::new())
    }

    /// Folder at `path`, with the folders of its path that were made for this render, itself first.
    fn inside(path: &Path, force: bool, created: Vec<PathBuf>) -> Self {
        let preview = path.join(PREVIEW);
        // Takes away what only a render under way needs.
        let cleanup = Cleanup::new(move || {
            let _ = fs::remove_file(&preview);
            // Only folders without files can be removed so.
            created.iter().try_for_each(fs::remove_dir).unwrap_or_default();
        });
        let (written, stamps) = (Vec::new(), BTreeMap::new());
        let unfinished = Arc::default();
        let path = path.to_owned();
        Self {
            path,
            force,
            written,
            sums: BTreeMap::new(),
            stamps,
            unfinished,
            _removal: None,
            lock: None,
            _cleanup: cleanup,
        }
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether files that are there may be overwritten.
    pub(crate) fn is_forced(&self) -> bool {
        self.force
    }

    /// A file without a name, for what does not fit into memory.
    pub(crate) fn store(&self) -> Result<Box<dyn Store>> {
        let file = tempfile::tempfile_in(&self.path).map_err(|reason| Error::io(&self.path, "write into", reason))?;
        Ok(Box::new(file))
    }

    /// Names of the files written so far.
    pub fn files(&self) -> Vec<String> {
        self.written.clone()
    }

    /// Sizes and checksums of the files written so far.
    pub(crate) fn sums(&self) -> &BTreeMap<String, FileSum> {
        &self.sums
    }

    /// Removes the results of an earlier render, its report first: none may pass for results of this one.
    pub(crate) fn remove_earlier(&self) -> Result<()> {
        for report_name in [REPORT, PART] {
            let files =
                ReportFiles::read(&self.path.join(report_name)).map_or_else(|_| Vec::new(), |listing| listing.files);
            // A report that somebody edited must not reach beyond the folder.
            let files =
                files.iter().map(String::as_str).filter(|name| Path::new(name).file_name() == Some(name.as_ref()));
            for path in std::iter::once(report_name).chain(files).map(|name| self.path.join(name)) {
                match fs::remove_file(&path) {
                    Err(reason) if reason.kind() != ErrorKind::NotFound => {
                        return Err(Error::io(&path, "remove the earlier file", reason));
                    }
                    Ok(()) | Err(_) => {}
                }
            }
        }
        Ok(())
    }

    /// Writes a raw image in all formats that are asked for, numbered where there are several.
    pub(crate) fn write_frame(&mut self, output: &OutputSettings, number: Option<u32>, raw: &RawImage) -> Result<()> {
        let raw = &*with_layout(raw, output.raw_layout).map_err(|invalid| invalid.in_file(&self.path))?;
        output.raw.iter().map(|key| key.format()).try_for_each(|format| {
            let name = named("raw", number, format.ending());
            self.write(&name, |to| format.write_raw(raw, output.dng_compression, to))
        })
    }

    pub(crate) fn write_electrons(&mut self, number: Option<u32>, exposed: &CollectedElectrons) -> Result<()> {
        self.write(&named("electrons", number, "exr"), |to| {
            write_electrons(&exposed.electrons, exposed.exposure.time, to)
        })
    }

    pub(crate) fn write_irradiance(
        &mut self,
        number: Option<u32>,
        bands: &SpectralBands,
        light: &LightRows,
    ) -> Result<()> {
        let names: Vec<_> = (0..bands.count).map(|band| bands.centre_nm(band).to_string()).collect();
        let irradiance = light.means(names.iter().map(String::as_str));
        self.write(&named("irradiance", number, "exr"), |to| write_irradiance(&irradiance, to))
    }

    /// Writes noise maps, in all formats that are asked for.
    pub(crate) fn write_noise(&mut self, number: Option<u32>, output: &NoiseOutput, maps: &NoiseMaps) -> Result<()> {
        if output.maps.is_empty() {
            return Ok(());
        }
        output.formats.iter().try_for_each(|format| match format {
            NoiseFormat::Exr => self.write(&named(NOISE, number, "exr"), |to| write_noise_exr(maps, to)),
            NoiseFormat::Npy => output.maps.iter().try_for_each(|&map| {
                let name = named(&format!("{NOISE}-{}", map.name()), number, "npy");
                self.write(&name, |to| write_noise_npy(maps, map, to))
            }),
        })
    }

    /// Writes ground truth, in all formats that are asked for.
    pub(crate) fn write_truth(&mut self, number: Option<u32>, output: &TruthOutput, truth: &Planes) -> Result<()> {
        for format in &output.formats {
            let layers = output.layers.iter().filter(|layer| format.check(**layer).is_ok());
            let name = |layer: TruthLayer, kind| named(&format!("{TRUTH}-{}", layer.name()), number, kind);
            match format {
                TruthFormat::Exr => self.write(&named(TRUTH, number, "exr"), |to| write_truth_exr(truth, to))?,
                TruthFormat::Npy => layers
                    .copied()
                    .try_for_each(|layer| self.write(&name(layer, "npy"), |to| write_truth_npy(truth, layer, to)))?,
                TruthFormat::Png => layers.copied().try_for_each(|layer| {
                    self.write(&name(layer, "png"), |to| write_truth_png(truth, layer, output.depth_unit_m, to))
                })?,
            }
        }
        Ok(())
    }

    /// Writes the facts known of each object.
    pub(crate) fn write_objects(&mut self, number: Option<u32>, objects: &ObjectsReport) -> Result<()> {
        self.write(&named("objects", number, "json"), |to| writeln!(to, "{}", pretty_json(objects)))
    }

    /// Writes the number of samples of each pixel.
    pub(crate) fn write_samples(&mut self, number: Option<u32>, size: [usize; 2], counts: &[u32]) -> Result<()> {
        self.write(&named("samples", number, "npy"), |to| write_samples(size, counts, to))
    }

    /// Writes the sums of a part of a render, from the file in which they were kept. That one stays until the part is
    /// there as a whole.
    pub(crate) fn write_film(&mut self, number: Option<u32>, mut kept: File) -> Result<()> {
        self.write(&named("film", number, "npy.gz"), |to| {
            kept.rewind()?;
            write_compressed(&mut kept, to)
        })
    }

    /// Writes the report of a part, its last file.
    pub(crate) fn write_part(&mut self, part: &PartReport) -> Result<()> {
        self.write_last(PART, part)
    }

    /// Writes the light of a bracket, in which 1 saturates the longest exposure.
    pub(crate) fn write_hdr(
        &mut self,
        light: &Planes,
        space: ColourSpace,
        pixel_aspect: f64,
        longest: Seconds,
    ) -> Result<()> {
        self.write("hdr.exr", |to| write_hdr(light, space, pixel_aspect, longest, to))
    }

    /// Writes the image of an ideal observer: linear, and as it is shown. Codes cannot hold X, Y and Z.
    pub(crate) fn write_ideal(
        &mut self,
        number: Option<u32>,
        image: Planes,
        pixel_aspect: f64,
        settings: &DevelopSettings,
    ) -> Result<()> {
        self.write(&named("ideal", number, "exr"), |to| write_linear(&image, settings.colour_space, pixel_aspect, to))?;
        if settings.colour_space == ColourSpace::Xyz {
            return Ok(());
        }
        let encoded = EncodedImage { pixel_aspect, ..encode(image, &settings.encoding()) };
        self.write(&named("ideal", number, "png"), |to| write_png(&encoded, to))
    }

    pub(crate) fn write_image(&mut self, number: Option<u32>, image: &EncodedImage) -> Result<()> {
        self.write(&named("image", number, "png"), |to| write_png(image, to))
    }

    /// Writes the image as far as it has come.
    pub(crate) fn write_preview(&self, image: &EncodedImage) -> Result<()> {
        write_unsynced(&self.path.join(PREVIEW), |to| write_png(image, to))
    }

    /// Writes the report, the last file, which says what the others are.
    pub(crate) fn write_report(&mut self, report: &Report) -> Result<()> {
        self.write_last(REPORT, report)
    }

    /// Writes the file that names the others, and is there only if all are.
    fn write_last(&mut self, name: &str, content: &impl Serialize) -> Result<()> {
        self.check_written()?;
        // There is none of what is finished.
        let _ = fs::remove_file(self.path.join(PREVIEW));
        self.stamp(name, |to| writeln!(to, "{}", pretty_json(content)))?;
        locked(&self.unfinished).clear();
        let _ = fs::remove_file(self.path.join(UNFINISHED));
        checkpoint::remove(&self.path)?;
        if self.lock.as_ref().is_some_and(Lock::is_proven) {
            remove_leftovers(&self.path);
        }
        Ok(())
    }

    /// Refuses to vouch for files that are gone, or are not those that were written here: where the file system knows
    /// no locks, another process may be writing to the folder.
    fn check_written(&self) -> Result<()> {
        let Some((name, _)) = self.stamps.iter().find(|(name, stamp)| !stamp.is_of(&self.path.join(name))) else {
            return Ok(());
        };
        let path = self.path.join(name);
        let what = if path.exists() { "was replaced by another process" } else { "was removed by another process" };
        let help = "give each process a folder of its own";
        Err(Invalid::new("", what).help(help).in_file(&path).temporary())
    }

    fn write(&mut self, name: &str, write: impl FnOnce(&mut dyn Sink) -> IoResult<()>) -> Result<()> {
        self.stamp(name, write)?;
        let path = self.path.join(name);
        let sum = FileSum::of(&path).map_err(|reason| self.since_claimed(Error::io(&path, "read", reason)))?;
        self.sums.insert(name.to_owned(), sum);
        self.written.push(name.to_owned());
        Ok(())
    }

    fn stamp(&mut self, name: &str, write: impl FnOnce(&mut dyn Sink) -> IoResult<()>) -> Result<()> {
        // One that no other process knows is synced as a whole before it gets its name.
        let is_synced = self.lock.is_some();
        if is_synced && self.stamps.is_empty() {
            let mark = self.path.join(UNFINISHED);
            let marked = fs::write(&mark, "").map_err(|reason| Error::io(&mark, "write", reason));
            marked.map_err(|error| self.since_claimed(error))?;
            locked(&self.unfinished).push(mark);
        }
        let path = self.path.join(name);
        let stamp = write_stamped(&path, is_synced, write).map_err(|error| self.since_claimed(error))?;
        locked(&self.unfinished).push(path);
        self.stamps.insert(name.to_owned(), stamp);
        Ok(())
    }

    /// Marks an error as temporary where the folder is gone, which was there when it was claimed.
    pub(crate) fn since_claimed(&self, error: Error) -> Error {
        if self.path.is_dir() { error } else { error.temporary() }
    }
}

/// Refuses a folder with files that a render may leave, which are somebody's.
fn refuse_results(path: &Path, force: bool) -> Result<()> {
    let in_the_way = results().find(|name| path.join(name).exists());
    let is_broken_off = || checkpoint::are_in(path) || path.join(UNFINISHED).exists();
    let Some(name) = in_the_way.filter(|_| !force && !is_broken_off()) else { return Ok(()) };
    Err(Error::Usage {
        message: match name.as_str() {
            REPORT => format!("{} contains the results of an earlier render", path.display()),
            PART => format!("{} contains a part of a render", path.display()),
            _ => format!("{} already contains a file {name}", path.display()),
        },
        help: Some(Help::any([Remedy::Overwrite, Remedy::Elsewhere("another folder".to_owned())])),
    })
}

/// The names of all that a render may leave, of series by that of their first, the report's before all.
fn results() -> impl Iterator<Item = String> {
    let names = |stem: String, kinds: &'static [&str]| {
        kinds.iter().flat_map(move |kind| [named(&stem, None, kind), named(&stem, Some(0), kind)])
    };
    let of_layer = move |layer: TruthLayer| names(format!("{TRUTH}-{}", layer.name()), &["npy", "png"]);
    let of_map = move |map: NoiseMap| names(format!("{NOISE}-{}", map.name()), &["npy"]);
    let of_maps = NoiseMap::ALL.into_iter().flat_map(of_map);
    let raw = FORMATS.into_iter().filter(|format| format.writes_raw());
    let raw = raw.flat_map(|format| [None, Some(0)].map(|number| named("raw", number, format.ending())));
    let fixed = RESULTS.into_iter().flat_map(move |(stem, kinds)| names(stem.to_owned(), kinds));
    [REPORT, PART]
        .map(str::to_owned)
        .into_iter()
        .chain(fixed)
        .chain(raw)
        .chain(TruthLayer::ALL.into_iter().flat_map(of_layer))
        .chain(of_maps)
}

fn unusable(path: &Path, message: impl Into<String>) -> Error {
    Invalid::new("", message).help(Remedy::Elsewhere("another folder".to_owned())).in_file(path)
}
