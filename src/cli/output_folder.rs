//! The folder that a render fills.

use std::fs;
use std::io::{ErrorKind, Result as IoResult};
use std::path::{Path, PathBuf};

use photosite::develop::Picture8;
use photosite::film::Film;
use photosite::io::capture::{OutputSettings, RawFormat};
use photosite::io::electrons::write_electrons;
use photosite::io::output::{Sink, create_folder, write_whole};
use photosite::io::png::write_png;
use photosite::io::spectral_exr::write_irradiance;
use photosite::raw::{RawImage, write_dng, write_npy, write_pgm, write_tiff};
use photosite::{Error, Result};

use super::chain::Exposed;
use super::report::Report;

/// The file whose presence says that a render was finished here.
const REPORT: &str = "capture.json";
/// The picture that is there while a render runs.
const PREVIEW: &str = "preview.png";

/// A folder for results.
pub(super) struct OutputFolder {
    path: PathBuf,
    written: Vec<String>,
}

impl OutputFolder {
    /// Creates the folder where missing. One that holds an earlier render is refused unless `force` is given.
    pub(super) fn claim(path: &Path, force: bool) -> Result<Self> {
        if path.join(REPORT).exists() && !force {
            return Err(Error::Usage {
                message: format!("{} holds the results of an earlier render", path.display()),
                help: Some("add --force to overwrite them, or choose another folder with -o".to_owned()),
            });
        }
        create_folder(path)?;
        // Whether files can be made here shows now rather than after an hour of tracing.
        tempfile::tempfile_in(path).map_err(|source| Error::io(path, "write into the folder", source))?;
        Ok(Self { path: path.to_owned(), written: Vec::new() })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the files written so far.
    pub(super) fn files(&self) -> Vec<String> {
        self.written.clone()
    }

    /// Everything but the report; takes the preview away.
    pub(super) fn write_results(
        &mut self,
        output: &OutputSettings,
        exposed: &Exposed,
        film: &Film,
        picture: &Picture8,
    ) -> Result<()> {
        for (index, raw) in exposed.frames.iter().enumerate() {
            let stem = if exposed.frames.len() == 1 { "raw".to_owned() } else { format!("raw-{index:04}") };
            for format in &output.raw {
                self.write_raw(&stem, *format, raw)?;
            }
        }
        if output.electrons {
            self.write("electrons.exr", |to| write_electrons(&exposed.electrons, exposed.exposure.time, to))?;
        }
        if let Some(bands) = &output.irradiance {
            let names: Vec<_> = (0..bands.count).map(|band| bands.centre_nm(band).to_string()).collect();
            let irradiance = film.estimate(names.iter().map(String::as_str)).mean;
            self.write("irradiance.exr", |to| write_irradiance(&irradiance, to))?;
        }
        self.write("image.png", |to| write_png(picture, to))?;
        let preview = self.path.join(PREVIEW);
        match fs::remove_file(&preview) {
            Err(source) if source.kind() != ErrorKind::NotFound => Err(Error::io(&preview, "remove", source)),
            Ok(()) | Err(_) => Ok(()),
        }
    }

    fn write_raw(&mut self, stem: &str, format: RawFormat, raw: &RawImage) -> Result<()> {
        match format {
            RawFormat::Dng => self.write(&format!("{stem}.dng"), |to| write_dng(raw, to)),
            RawFormat::Tiff => self.write(&format!("{stem}.tiff"), |to| write_tiff(raw, to)),
            RawFormat::Pgm => self.write(&format!("{stem}.pgm"), |to| write_pgm(raw, to)),
            RawFormat::Npy => self.write(&format!("{stem}.npy"), |to| write_npy(raw, to)),
        }
    }

    /// The picture as far as it has come.
    pub(super) fn write_preview(&self, picture: &Picture8) -> Result<()> {
        write_whole(&self.path.join(PREVIEW), |to| write_png(picture, to))
    }

    /// The last file: what the others are.
    pub(super) fn write_report(&self, report: &Report) -> Result<()> {
        let text =
            serde_json::to_string_pretty(report).expect("our own structures have string keys and finite numbers");
        write_whole(&self.path.join(REPORT), |to| writeln!(to, "{text}"))
    }

    fn write(&mut self, name: &str, write: impl FnOnce(&mut dyn Sink) -> IoResult<()>) -> Result<()> {
        write_whole(&self.path.join(name), write)?;
        self.written.push(name.to_owned());
        Ok(())
    }
}
