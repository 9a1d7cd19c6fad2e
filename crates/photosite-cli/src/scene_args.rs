//! Arguments that all commands which read scenes share.

use std::path::Path;

use clap::Args;

use photosite_capture::typed_change;

#[derive(Args)]
pub(super) struct SceneArgs {
    /// Go on where a texture of a scene file is missing or broken: grey is used instead, and a warning says so.
    #[arg(long)]
    lenient: bool,
}

impl SceneArgs {
    /// Changes to keys of the capture `input`, whose paths are made relative to its folder, and the changes by these
    /// arguments.
    pub(super) fn after(&self, overrides: &[String], input: &Path) -> Vec<String> {
        let folder = input.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let lenient = self.lenient.then(|| "scene.lenient=true".to_owned());
        overrides.iter().map(|change| typed_change(change, folder)).chain(lenient).collect()
    }
}
