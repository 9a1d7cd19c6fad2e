//! Completed rows, which have all their samples: the place that they go to, so that their film can be given up.

use std::fs::File;
use std::io::{BufWriter, Cursor};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use photosite_capture::Capture;
use photosite_core::{Error, Result};
use photosite_files::film_file::write_film;
use photosite_files::light_rows::{LightRows, Store};
use photosite_transport::film::{Film, Response};

use crate::camera::capture_camera::pixels;

/// Completed rows of light or of a part.
pub(crate) enum CompletedRows {
    /// Light of an image, and its file if it lies in one.
    Light(Arc<LightRows>, Option<PathBuf>),
    /// Sums of a part, not compressed yet, as far as they have come.
    Sums { file: File, path: PathBuf, height: usize },
}

impl CompletedRows {
    /// Place for light in a store, or in memory where the whole image is one film that fits into it.
    pub(crate) fn light(capture: &Capture, responses: &[Response], store: Option<Box<dyn Store>>) -> Arc<LightRows> {
        let size = pixels(capture).map(|n| n as usize);
        let channels: Vec<String> = responses.iter().map(|response| response.name.clone()).collect();
        // The sensor's channels come first. Of others nobody asks for the variance.
        let with_variance = capture.sensor().cfa.channels().len();
        let in_memory = || -> Box<dyn Store> {
            let bytes = size[0] * size[1] * LightRows::bytes_per_pixel(channels.len(), with_variance);
            Box::new(Cursor::new(Vec::with_capacity(bytes)))
        };
        let store = store.unwrap_or_else(in_memory);
        Arc::new(LightRows::new(store, size, channels, with_variance))
    }

    /// Keeps the rows of a film.
    pub(crate) fn write(&mut self, film: &Film) -> Result<()> {
        match self {
            Self::Light(rows, path) => rows.write(film).map_err(|reason| {
                // Memory takes what it is given.
                Error::io(path.as_deref().unwrap_or(Path::new("")), "write", reason)
            }),
            Self::Sums { file, path, height } => {
                write_film(film, *height, BufWriter::new(file)).map_err(|reason| Error::io(path, "write", reason))
            }
        }
    }
}
