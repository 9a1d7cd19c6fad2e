//! Help: the output of `photosite --help`.

use std::ffi::OsString;
use std::fmt::Write;

use clap::Command;
use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Commands in groups, in the order in which people need them. A test checks that none is missing.
pub(super) const GROUPS: [(&str, &[&str]); 6] = [
    ("Make images", &["render", "expose", "develop", "merge-hdr", "view"]),
    ("Scenes and cameras", &["init", "info", "sensors", "lens", "target", "camera", "project"]),
    ("Data sets", &["dataset", "status", "merge", "layout", "rectify", "depth"]),
    ("Measure", &["compare", "measure", "noise", "emva1288", "emva1288-report", "fit"]),
    ("Other programs", &["export-mitsuba", "schema"]),
    ("This program", &["devices", "completions", "man"]),
];

const EXAMPLES: &str = "\
Examples:
  photosite render model.glb                   a first image
  photosite init model.glb -o capture.toml     its scene and camera, as a file
  photosite render capture.toml --spp 64       the image of that file
  photosite view capture.toml --open           the same, with sliders";

/// Exit statuses, for scripts and schedulers.
const EXIT_STATUS: &str = "\
Exit status: 0 done; 1 failed, or images differ; 2 wrong usage; 3 and 4 of `photosite status` (see its --help); 75 \
failed, but another try may succeed (disk full, a server or a file went away, another process writes to the same \
place); 129, 130, 143 ended by SIGHUP, SIGINT, SIGTERM: a render continues from its checkpoint when the same command \
is run again.";

/// Command with its subcommands in groups, examples and exit statuses in its help.
pub(super) fn grouped(command: Command) -> Command {
    let mut listed = String::new();
    for (title, names) in GROUPS {
        let _ = write!(listed, "\n{title}:\n");
        // `view` may be left out of the build.
        for found in names.iter().filter_map(|name| command.find_subcommand(name)) {
            let about = found.get_about().map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(listed, "  {:15}  {about}", found.get_name());
        }
    }
    let template = "{about-with-newline}\n{usage-heading} {usage}\n".to_owned()
        + &listed
        + "\n`photosite COMMAND --help` describes a command.\n\nOptions:\n{options}{after-help}";
    command.help_template(template).after_help(format!("{EXAMPLES}\n\n{EXIT_STATUS}"))
}

/// Error of an unknown option, with advice on setting keys where the option may be a key of a capture file. `command`
/// has all subcommands.
pub(super) fn unknown_option(mut error: clap::Error, command: &Command, arguments: &[OsString]) -> clap::Error {
    let given = arguments.iter().find_map(|argument| command.find_subcommand(argument));
    let sets_keys = given.is_some_and(|given| given.get_arguments().any(|option| option.get_long() == Some("set")));
    let has_near = error.get(ContextKind::SuggestedArg).is_some();
    if error.kind() == ErrorKind::UnknownArgument && !has_near && sets_keys {
        let words = "keys of a capture file are set by --set, for example --set exposure.gain_db=24";
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![words.into()]));
    }
    error
}
