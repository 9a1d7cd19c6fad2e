//! `--film-memory`, which commands that trace have in common.

use clap::Args;
use photosite::pipeline::FilmMemory;

#[derive(Args, Clone, Copy)]
pub(super) struct FilmMemoryArgs {
    /// Most memory for the film, GiB: a picture of which it needs more is traced in strips, one after the other.
    #[arg(long = "film-memory", value_name = "GIB", default_value = "4", value_parser = parse)]
    film_memory: FilmMemory,
}

impl FilmMemoryArgs {
    pub(super) fn value(self) -> FilmMemory {
        self.film_memory
    }
}

fn parse(text: &str) -> Result<FilmMemory, String> {
    let gib = text.parse().ok().and_then(|gib| FilmMemory::gib(gib).ok());
    gib.ok_or_else(|| "write a number above 0, for example 2.5".to_owned())
}
