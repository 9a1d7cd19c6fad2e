//! Files that hold pictures one after the other, and how a range of pictures becomes one or several of them.

use std::io;
use std::path::{Path, PathBuf};

use super::sample::Sample;
use crate::io::output::{FileBeside, Sink, write_beside};
use crate::{Error, Result};

/// A kind of file.
pub(super) trait Container {
    /// What the file holds of a picture.
    type Item;
    /// That of a picture; `warn` is told what is left out.
    fn item(sample: Sample, warn: &dyn Fn(&str)) -> Result<Self::Item>;
    /// How much of the file it takes.
    fn bytes(item: &Self::Item) -> u64;
    /// Writes a file.
    fn write(items: &mut dyn Iterator<Item = io::Result<Self::Item>>, to: &mut dyn Sink) -> io::Result<()>;
}

/// Writes pictures to as many files as the limit asks for. `name` gives their paths by their place among them; the first
/// gets its name last.
pub(super) fn write_files<C: Container>(
    samples: impl Iterator<Item = Result<Sample>>,
    limit: u64,
    name: impl Fn(usize) -> PathBuf,
    warn: &dyn Fn(&str),
) -> Result<()> {
    write_items(samples.map(|sample| C::item(sample?, warn)), limit, name, C::bytes, C::write)
}

fn write_items<T>(
    items: impl Iterator<Item = Result<T>>,
    limit: u64,
    name: impl Fn(usize) -> PathBuf,
    bytes: impl Fn(&T) -> u64,
    write: impl Fn(&mut dyn Iterator<Item = io::Result<T>>, &mut dyn Sink) -> io::Result<()>,
) -> Result<()> {
    let mut items = items.peekable();
    let mut files: Vec<(PathBuf, FileBeside)> = Vec::new();
    while items.peek().is_some() {
        let path = name(files.len());
        let mut failure = None;
        let mut taken = 0;
        let written = write_beside(&path, |to| {
            let mut of_file = std::iter::from_fn(|| {
                let more = items.peek()?.as_ref().map_or(0, &bytes);
                // A picture that is larger than the limit has a file of its own.
                if taken > 0 && taken + more > limit {
                    return None;
                }
                taken += more.max(1);
                items.next()?.map_or_else(
                    |error| {
                        failure = Some(error);
                        Some(Err(io::Error::other("a picture cannot be read")))
                    },
                    |item| Some(Ok(item)),
                )
            });
            write(&mut of_file, to)
        });
        if let Some(error) = failure {
            return Err(error);
        }
        files.push((path, written?));
    }
    files.into_iter().rev().try_for_each(|(path, file)| file.put_in_place(&path))
}

/// How many bytes a file of some pictures has.
pub(super) fn measure<C: Container>(samples: impl Iterator<Item = Result<Sample>>, path: &Path) -> Result<u64> {
    let items: Vec<C::Item> = samples.map(|sample| C::item(sample?, &|_| ())).collect::<Result<_>>()?;
    let mut file = io::Cursor::new(Vec::new());
    C::write(&mut items.into_iter().map(Ok), &mut file).map_err(|reason| Error::io(path, "write", reason))?;
    Ok(file.into_inner().len() as u64)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// Texts, as long as they are.
    struct Texts;

    impl Texts {
        fn write_all(texts: &[&str], limit: u64, name: impl Fn(usize) -> PathBuf) -> Result<()> {
            let items = texts.iter().map(|text| Ok((*text).to_owned()));
            let bytes = |text: &String| text.len() as u64;
            let write = |items: &mut dyn Iterator<Item = io::Result<String>>, to: &mut dyn Sink| {
                for text in items {
                    to.write_all(text?.as_bytes())?;
                }
                Ok(())
            };
            write_items(items, limit, name, bytes, write)
        }
    }

    #[test]
    fn files_end_before_their_limit_and_what_is_larger_is_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let name = |part: usize| folder.path().join(part.to_string());
        Texts::write_all(&["aaa", "bbb", "cc", "ddddddddd", "e", "f"], 6, name).expect("written");
        let text = |part: usize| fs::read_to_string(name(part)).ok();
        let found: Vec<String> = (0..).map_while(text).collect();
        assert_eq!(found, ["aaabbb", "cc", "ddddddddd", "ef"]);
    }
}
