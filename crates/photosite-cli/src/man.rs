//! `photosite man`: the manual pages.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man;

use super::log::say;
use super::print::write_result;
use photosite_core::output::create_folder;

const EXAMPLES: &str = "\
Example:
  photosite man ~/.local/share/man/man1";

/// Write the manual pages, one for each command.
///
/// `man photosite` and `man photosite-render` show them where the folder is one of those that `manpath` prints, with
/// /man1 behind it.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ManArgs {
    /// Folder for the pages, created where missing.
    folder: PathBuf,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Overwrite earlier pages.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &ManArgs, command: Command) -> photosite_core::Result<()> {
    let mut command = command.disable_help_subcommand(true);
    command.build();
    let mut pages = Vec::new();
    collect(&command, &mut pages);
    create_folder(&args.folder)?;
    for page in &pages {
        write_result(&args.folder.join(page.get_filename()), args.force, |mut to| page.render(&mut to))?;
    }
    if !args.quiet {
        say!("wrote {} pages to {}", pages.len(), args.folder.display());
    }
    Ok(())
}

/// Collects the pages of a command and of all its subcommands.
fn collect(command: &Command, pages: &mut Vec<Man>) {
    let page = Man::new(command.clone()).manual("photosite").source(concat!("photosite ", env!("CARGO_PKG_VERSION")));
    pages.push(page);
    command.get_subcommands().for_each(|subcommand| collect(subcommand, pages));
}
