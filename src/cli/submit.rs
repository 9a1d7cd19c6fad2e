//! `photosite submit`: a data set as jobs of a scheduler.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use clap::{Args, Subcommand, value_parser};
use serde_json::json;

use super::arguments::positive;
use super::log::{say, warning};
use super::monitor::TerminalMonitor;
use super::print::{print_json, println_out, refuse_existing, write_result};
use super::scene_args::SceneArgs;
use crate::capture::DatasetFile;
use crate::dataset::{DataSet, Forecast, IDENTITY, MakeOptions};
use crate::io::output::create_folder;
use crate::pipeline::FilmMemory;
use crate::schedulers::{Cut, Job, LONGEST_PARAMETER, Site, Tasks, all_quoted, index_command, script, template};
use crate::{Error, Result, Sandbox};
use photosite_core::sandbox::trust;

/// Minutes that a task takes unless something else is asked for.
const TASK_MIN: f64 = 30.0;

const EXAMPLES: &str = "\
Example:
  photosite submit slurm dataset.toml -o set --tasks 100 --submit";

/// Submit a data set to Slurm or an Open Job Description farm.
///
/// What is missing in the folder is divided into tasks, which ask for the time and memory that a few measured
/// pictures need. All hosts must see the same disk, and the files under the same names. Each picture is made by one
/// of them, and finished pictures are kept: a task that is killed continues where it stopped. `photosite status
/// DIR` shows how far they are.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct SubmitArgs {
    #[command(subcommand)]
    scheduler: Scheduler,
}

#[derive(Subcommand)]
enum Scheduler {
    Slurm(SlurmArgs),
    #[command(name = "openjd")]
    OpenJd(OpenJdArgs),
}

/// Write an array script for Slurm's sbatch, and say what the set takes.
///
/// The array makes the pictures; a last job, which depends on it, writes the manifest and fails if pictures are missing.
/// photosite is started again by the script if it was killed (137), ended (143), or failed for a reason that may
/// pass (75); a task whose time is over is requeued. After a failure (1) or wrong usage (2) it is not tried again.
#[derive(Args)]
struct SlurmArgs {
    #[command(flatten)]
    common: CommonArgs,
    /// Submit the array, and the job that comes last, with sbatch.
    #[arg(long)]
    submit: bool,
    /// Account to charge.
    #[arg(long, value_name = "NAME")]
    account: Option<String>,
    /// Partition to run in.
    #[arg(long, value_name = "NAME")]
    partition: Option<String>,
    /// Another line for sbatch, for example --directive=--qos=high; it overrules what was measured.
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    directive: Vec<String>,
    /// A line of the script before photosite is started, for example --setup 'module load photosite'.
    #[arg(long, value_name = "COMMAND")]
    setup: Vec<String>,
    /// In a task, restart photosite at most this often after it was killed, or failed for a reason that may pass;
    /// requeue a task whose time is over at most this often.
    #[arg(long, value_name = "N", default_value = "5")]
    retries: u32,
}

/// Write an Open Job Description template, and say what the set takes.
///
/// A step makes the pictures in chunks of consecutive frames, the next one writes the manifest and fails if pictures are
/// missing. `deadline bundle submit FOLDER` sends a template that was written to FOLDER/template.json to a farm, which
/// tries tasks again that fail; `openjd run` runs it here.
#[derive(Args)]
struct OpenJdArgs {
    #[command(flatten)]
    common: CommonArgs,
    /// Run the template on this machine with `openjd run`.
    #[arg(long)]
    submit: bool,
}

#[derive(Args)]
struct CommonArgs {
    /// A data set file (.toml).
    input: PathBuf,
    /// Folder of the data set, as of `photosite dataset` [default: the input's name, in the current folder].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Write to this file instead of standard output.
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
    /// Overwrite an earlier file.
    #[arg(long)]
    force: bool,
    /// Divide the missing frames into this many tasks.
    #[arg(long, value_name = "N", conflicts_with = "task_time", value_parser = value_parser!(u32).range(1..))]
    tasks: Option<u32>,
    /// Divide them into tasks of about this many minutes, by the time measured [default: 30].
    #[arg(long, value_name = "MINUTES", value_parser = positive)]
    task_time: Option<f64>,
    /// Make this many pictures at once in a task [default: one for each thread where pictures are small, else 1].
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Time that each task asks for, minutes [default: twice the time measured and two minutes].
    #[arg(long, value_name = "MINUTES", value_parser = value_parser!(u64).range(1..))]
    time_limit: Option<u64>,
    /// photosite on the hosts, a name or a path [default: this program].
    #[arg(long, value_name = "PROGRAM")]
    program: Option<String>,
    /// Change a key of the capture file in all frames.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    #[command(flatten)]
    scene: SceneArgs,
    /// Maximum memory for the film, GiB [default: 4].
    #[arg(long, value_name = "GIB", value_parser = positive)]
    film_memory: Option<f64>,
    /// Continue after frames whose keys are wrong.
    #[arg(long)]
    keep_going: bool,
    /// Print nothing but errors and the result.
    #[arg(short, long)]
    quiet: bool,
    /// Print what the data set takes, the file, and the submitted jobs, as JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &SubmitArgs, sandbox: &Sandbox, shared: &[String]) -> Result<()> {
    match &args.scheduler {
        Scheduler::Slurm(args) => args.run(sandbox, shared),
        Scheduler::OpenJd(args) => args.run(sandbox, shared),
    }
}

impl SlurmArgs {
    fn run(&self, sandbox: &Sandbox, shared: &[String]) -> Result<()> {
        let Some(plan) = self.common.plan(sandbox, shared, self.submit)? else { return Ok(()) };
        let named = [("--account", &self.account), ("--partition", &self.partition)];
        let named = named.iter().filter_map(|(option, name)| Some(format!("{option}={}", name.as_ref()?)));
        let directives: Vec<String> = named.chain(self.directive.iter().cloned()).collect();
        refuse_line_breaks(&directives, "--directive")?;
        refuse_line_breaks(&self.setup, "--setup")?;
        let text = script(
            &plan.job,
            &plan.tasks,
            &plan.about,
            &Site { directives, setup: self.setup.clone(), retries: self.retries },
        );
        let written = self.common.write(&text, self.submit)?;
        let mut jobs = Vec::new();
        if self.submit {
            let array = sbatch(&["--parsable".to_owned(), "/dev/stdin".to_owned()], &text)?;
            let last = sbatch(&index_command(&array, None), &text)?;
            self.common.say(format_args!("submitted as job {array}, and {last}, which runs last"));
            jobs = vec![array, last];
        } else if let Some(path) = written {
            let name = path.to_string_lossy();
            let last = all_quoted(index_command("JOB", Some(&name)));
            self.common.say(format_args!(
                "wrote {name}: submit it with `sbatch {}`, and then, with the number of that job, `sbatch {last}`",
                all_quoted([&name])
            ));
        }
        self.common.finish(&plan, "slurm", &text, &jobs, self.submit)
    }
}

impl OpenJdArgs {
    fn run(&self, sandbox: &Sandbox, shared: &[String]) -> Result<()> {
        let Some(plan) = self.common.plan(sandbox, shared, self.submit)? else { return Ok(()) };
        let Job { program, input, output, arguments, .. } = &plan.job;
        let words = [program.clone(), input.to_string_lossy().into_owned(), output.to_string_lossy().into_owned()];
        if let Some(long) = words.iter().chain(arguments).find(|word| word.chars().count() > LONGEST_PARAMETER) {
            let start: String = long.chars().take(60).collect();
            let message = format!(
                "{start}… has more than {LONGEST_PARAMETER} characters, which parameters of Open Job \
                                   Description cannot have"
            );
            let help = "write it into the data set file (`set`), or choose shorter paths";
            return Err(Error::Usage { message, help: Some(help.into()) });
        }
        let text = template(&plan.job, &plan.tasks, &plan.about);
        let written = self.common.write(&text, self.submit)?;
        if self.submit {
            openjd_run(written, &text)?;
        } else if let Some(path) = written {
            let name = path.display();
            self.common.say(format_args!(
                "wrote {name}: run it here with `openjd run`, or submit its folder with `deadline bundle submit`"
            ));
        }
        self.common.finish(&plan, "openjd", &text, &[], self.submit)
    }
}

/// What is to be done, and what it takes.
struct Plan {
    forecast: Forecast,
    job: Job,
    tasks: Tasks,
    about: Vec<String>,
}

impl CommonArgs {
    /// Measures; `None` where nothing is missing. Before anything is sent the folder is taken for the data set: it shows
    /// now if it is that of another one, or cannot be written to.
    fn plan(&self, sandbox: &Sandbox, shared: &[String], claims: bool) -> Result<Option<Plan>> {
        if let Some(file) = &self.write {
            refuse_existing(file, self.force)?;
        }
        let monitor = TerminalMonitor::new(self.quiet, self.json);
        let film_memory = self.film_memory.map_or_else(|| Ok(FilmMemory::default()), FilmMemory::gib)?;
        let file = DatasetFile::read(&self.input)?;
        let overrides = self.scene.after(&self.overrides, &file.capture());
        let set = DataSet::new(sandbox, file, &overrides, film_memory)?;
        let default = PathBuf::from(&*self.input.file_stem().unwrap_or_default().to_string_lossy());
        let output = self.output.as_deref().unwrap_or(&default);
        trust(output);
        set.check_folder(output)?;
        if let Some(file) = self.write.as_ref().filter(|_| !output.join(IDENTITY).exists())
            && absolute(file)?.starts_with(absolute(output)?)
        {
            let message =
                format!("{} lies in the folder of the data set, which must be empty at first", file.display());
            return Err(Error::Usage { message, help: Some("choose a file elsewhere for --write".into()) });
        }
        let frames = set.frames(0..set.frame_count(), self.keep_going, &monitor)?;
        let options = MakeOptions { keeps_going: self.keep_going, jobs: self.jobs, ..MakeOptions::default() };
        let forecast = set.forecast(&frames, output, options, &monitor)?;
        if forecast.missing.is_empty() {
            if self.json {
                print_json(&json!({ "forecast": forecast, "tasks": 0 }))?;
            } else {
                self.say(format_args!(
                    "all {} pictures that can be made exist: there is nothing to submit",
                    forecast.present
                ));
            }
            forecast.check()?;
            return Ok(None);
        }
        if claims {
            set.claim(output)?;
        }
        let cut = self.tasks.map_or(Cut::Time(self.task_time.unwrap_or(TASK_MIN) * 60.0), Cut::Tasks);
        let tasks = Tasks::new(&forecast, cut, self.time_limit);
        let about = tasks.in_words(&forecast);
        if !self.json {
            about.iter().for_each(|line| self.say(format_args!("{line}")));
        }
        let stem = self.input.file_stem().unwrap_or_default().to_string_lossy();
        // Slurm takes names of logs for patterns.
        let name = stem.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
        let set = overrides.into_iter().flat_map(|change| ["--set".to_owned(), change]);
        let film = self.film_memory.iter().flat_map(|gib| ["--film-memory".to_owned(), gib.to_string()]);
        let jobs = self.jobs.iter().flat_map(|jobs| ["--jobs".to_owned(), jobs.to_string()]);
        let job = Job {
            name,
            program: self.program.clone().unwrap_or_else(this_program),
            input: absolute(&self.input)?,
            output: absolute(output)?,
            arguments: shared.iter().cloned().chain(film).chain(jobs).chain(set).collect(),
        };
        Ok(Some(Plan { forecast, job, tasks, about }))
    }

    fn say(&self, words: std::fmt::Arguments<'_>) {
        if !self.quiet {
            say!("{words}");
        }
    }

    /// Writes the file that was asked for, whole, and returns its name. Otherwise, unless it is sent, it is printed.
    fn write(&self, text: &str, is_sent: bool) -> Result<Option<&Path>> {
        match &self.write {
            Some(path) => {
                create_folder(path.parent().unwrap_or(Path::new("")))?;
                write_result(path, self.force, |to| to.write_all(text.as_bytes()))?;
                Ok(Some(path))
            }
            None if is_sent || self.json => Ok(None),
            None => println_out(text.trim_end()).map(|()| None),
        }
    }

    fn finish(&self, plan: &Plan, scheduler: &str, text: &str, jobs: &[String], is_sent: bool) -> Result<()> {
        let Plan { forecast, tasks, .. } = plan;
        if !forecast.failed.is_empty() && !self.quiet {
            warning!("frames that cannot be made are skipped: {}", forecast.failed.len());
        }
        if !self.json {
            return Ok(());
        }
        print_json(&json!({
            "scheduler": scheduler,
            "forecast": forecast,
            "tasks": tasks.tasks,
            "each": tasks,
            "file": self.write,
            "text": if is_sent || self.write.is_some() { None } else { Some(text) },
            "sent": is_sent,
            "jobs": jobs,
        }))
    }
}

/// This program, where it is one: in Python it is the interpreter.
fn this_program() -> String {
    let path = std::env::current_exe().ok();
    let is_own = |path: &PathBuf| path.file_stem().is_some_and(|name| name == "photosite");
    path.filter(is_own).map_or_else(|| "photosite".to_owned(), |path| path.to_string_lossy().into_owned())
}

fn absolute(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path).map_err(|reason| Error::io(path, "find", reason))
}

/// A line of a script must not become two.
fn refuse_line_breaks(lines: &[String], option: &str) -> Result<()> {
    if lines.iter().any(|line| line.contains('\n')) {
        let message = format!("a {option} has more than one line");
        return Err(Error::Usage { message, help: Some(format!("give {option} once for each line").into()) });
    }
    Ok(())
}

/// Sends a script, and returns the number of its job.
fn sbatch(arguments: &[String], text: &str) -> Result<String> {
    let mut command = Command::new("sbatch");
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut process = command.spawn().map_err(|reason| {
        missing(
            "sbatch",
            &reason,
            "write the script with --write FILE, and submit it with sbatch from a host of the cluster",
        )
    })?;
    if let Some(mut input) = process.stdin.take() {
        // Why it reads no further it says itself.
        let _ = input.write_all(text.as_bytes());
    }
    let output = process.wait_with_output().map_err(|reason| Error::io("sbatch".as_ref(), "run", reason))?;
    let [said, errors] = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).trim().to_owned());
    // A number, and in federations the cluster behind a semicolon.
    let number = said.split(';').next().unwrap_or_default().to_owned();
    if output.status.success() && !number.is_empty() && number.bytes().all(|c| c.is_ascii_digit()) {
        return Ok(number);
    }
    let message = format!("sbatch refused the job ({}): {errors}", output.status);
    let help = "see what it says; --partition, --account, --time-limit and --directive change what is asked for";
    Err(Error::Resources { message, help: Some(help.into()) })
}

/// Runs a template on this machine.
fn openjd_run(written: Option<&Path>, text: &str) -> Result<()> {
    let folder = tempfile::tempdir().map_err(|reason| Error::io(&std::env::temp_dir(), "write into", reason))?;
    trust(folder.path());
    let path = match written {
        Some(path) => path.to_owned(),
        None => {
            let path = folder.path().join("template.json");
            std::fs::write(&path, text).map_err(|reason| Error::io(&path, "write", reason))?;
            path
        }
    };
    // What it says goes where what is said goes.
    let status = Command::new("openjd").arg("run").arg(&path).stdout(std::io::stderr()).status();
    let status = status.map_err(|reason| missing("openjd", &reason, "install it with `pip install openjd-cli`"))?;
    if status.success() {
        return Ok(());
    }
    let message = format!("openjd ended with {status}");
    let help =
        "run the same command again, which continues with what is missing; `photosite status` tells what has failed";
    Err(Error::Resources { message, help: Some(help.into()) })
}

fn missing(program: &str, reason: &std::io::Error, help: &str) -> Error {
    let message = if reason.kind() == ErrorKind::NotFound {
        format!("{program} is not installed here")
    } else {
        format!("{program} cannot be started: {reason}")
    };
    Error::Resources { message, help: Some(help.into()) }
}
