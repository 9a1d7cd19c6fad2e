//! What `photosite --help` shows, and the description of all commands from which completions and manual pages are made.

use std::ffi::OsString;
use std::fmt::Write;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory};

use super::Cli;

/// The commands in groups, in the order in which people need them. All are here: a test looks.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Make pictures", &["render", "expose", "develop", "merge-hdr", "view"]),
    ("Scenes and cameras", &["init", "info", "sensors", "lens", "target", "camera", "project"]),
    ("Data sets", &["dataset", "status", "submit", "merge", "layout", "rectify", "depth"]),
    ("Measure", &["compare", "measure", "noise", "emva1288", "emva1288-report"]),
    ("Other programs", &["export-mitsuba", "schema"]),
    ("This program", &["completions", "man"]),
];

const EXAMPLES: &str = "\
Examples:
  photosite render model.glb                   a first picture
  photosite init model.glb -o capture.toml     its scene and camera, as a file
  photosite render capture.toml --spp 64       the picture of that file
  photosite view capture.toml --open           the same, with sliders";

/// What scripts and schedulers go by.
const EXIT_STATUS: &str = "\
Exit status: 0 done; 1 failed, or pictures differ; 2 wrong usage; 3 and 4 of `photosite status` (see its --help); 75 \
failed, but another try may succeed (disk full, a server or a file went away, another process writes to the same \
place); 129, 130, 143 ended by SIGHUP, SIGINT, SIGTERM: a render continues from its checkpoint when the same command \
is run again.";

/// The command with all its subcommands.
pub(super) fn command() -> Command {
    let command = Cli::command();
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

/// The same error, where an option that does not exist may be a key of a capture file, with how those are set.
pub(super) fn unknown_option(mut error: clap::Error, arguments: &[OsString]) -> clap::Error {
    let has_near = error.get(ContextKind::SuggestedArg).is_some();
    if error.kind() == ErrorKind::UnknownArgument && !has_near && sets_keys(arguments) {
        let words = "keys of a capture file are set by --set, for example --set exposure.gain_db=24";
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![words.into()]));
    }
    error
}

/// Whether the command that is given has `--set`.
fn sets_keys(arguments: &[OsString]) -> bool {
    let command = Cli::command();
    let given = arguments.iter().find_map(|argument| command.find_subcommand(argument));
    given.is_some_and(|command| command.get_arguments().any(|argument| argument.get_long() == Some("set")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(command: &Command, found: &mut Vec<Command>) {
        for subcommand in command.get_subcommands() {
            all(subcommand, found);
            found.push(subcommand.clone());
        }
    }

    #[test]
    fn every_command_is_in_one_group() {
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        grouped.retain(|name| cfg!(feature = "view") || *name != "view");
        let command = command();
        let mut there: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
        grouped.sort_unstable();
        there.sort_unstable();
        assert_eq!(grouped, there);
    }

    #[test]
    fn help_fits_into_80_columns() {
        let mut whole = command();
        whole.build();
        let mut commands = Vec::new();
        all(&whole, &mut commands);
        commands.push(whole);
        for mut command in commands {
            for text in [command.render_help(), command.render_long_help()] {
                for line in text.to_string().lines() {
                    assert!(line.chars().count() <= 80, "{}: {line}", command.get_name());
                }
            }
        }
    }

    /// Lines of examples begin with the program, two columns in; what follows three blanks explains them.
    #[test]
    fn examples_can_be_given_as_they_are() {
        let mut commands = Vec::new();
        all(&command(), &mut commands);
        let with_examples = commands.iter().filter(|command| command.get_after_help().is_some()).count();
        assert!(with_examples >= 26, "{with_examples}");
        commands.push(command());
        for after in commands.iter().filter_map(Command::get_after_help) {
            for line in after.to_string().lines().filter(|line| line.starts_with("  photosite")) {
                let line = line.trim().split("   ").next().unwrap_or_default().split(" > ").next().unwrap_or_default();
                let parsed = command().try_get_matches_from(line.split_whitespace());
                assert!(parsed.is_ok(), "{line}: {}", parsed.err().map(|e| e.to_string()).unwrap_or_default());
            }
        }
    }
}
