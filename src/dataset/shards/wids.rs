//! The index of tar files, `index.json`, in the form of WebDataset's module `wids`
//! ([WebDataset](photosite_core::references#webdataset)).

use std::collections::BTreeSet;
use std::io;
use std::path::Path;

use serde_json::{Value, json};

use crate::io::output::write_whole;
use crate::{Error, Invalid, Result};
use photosite_core::input;

/// Its name.
const INDEX: &str = "index.json";

/// Lists all tar files of a folder with the numbers of their samples, which are so many in all.
pub(super) fn write_index(folder: &Path, samples: usize) -> Result<()> {
    let entries = input::entries(folder).map_err(|reason| Error::io(folder, "read", reason))?;
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let names: BTreeSet<String> = names.filter(|name| name.starts_with("shard-") && name.ends_with(".tar")).collect();
    let entry = |name: &String| {
        let path = folder.join(name);
        entry(name, &path).map_err(|reason| Error::io(&path, "read", reason))
    };
    let shards: Vec<Value> = names.iter().map(entry).collect::<Result<_>>()?;
    let found: u64 = shards.iter().filter_map(|shard| shard.get("nsamples")?.as_u64()).sum();
    if found != samples as u64 {
        let message = format!("holds {found} samples, of {samples}: a file of a shard is lost");
        let help = "remove all files of the shard that lacks one, and run the command again, which writes it again";
        return Err(Invalid::new("", message).help(help).in_file(folder));
    }
    let index = json!({ "__kind__": "wids-shard-index-v1", "wids_version": 1, "shardlist": shards });
    let text = serde_json::to_string_pretty(&index).unwrap_or_default();
    write_whole(&folder.join(INDEX), |to| writeln!(to, "{text}"))
}

fn entry(name: &str, path: &Path) -> io::Result<Value> {
    let file = input::open(path)?;
    let bytes = file.metadata()?.len();
    let mut keys = BTreeSet::new();
    for member in tar::Archive::new(file).entries_with_seek()? {
        let name = member?.path()?.to_string_lossy().into_owned();
        keys.insert(name.split('.').next().unwrap_or_default().to_owned());
    }
    Ok(json!({ "url": name, "nsamples": keys.len(), "filesize": bytes }))
}
