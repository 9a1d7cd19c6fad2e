//! A data set as jobs of schedulers. Programs of the same names stand for theirs; `tests/cluster.py` asks the real ones.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use rstest::rstest;
use serde_json::Value;

use crate::dataset::{files, folder as board};
use crate::folder::Folder;
use crate::signals::send;

const SIX: &str = "frames = 6\n[poses.random]\ntarget = 'board'\ndistance_m = [0.6, 0.9]\nmargin_px = 1\n";

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

/// A program of this name that is found before others.
fn program(folder: &Folder, name: &str, script: &str) {
    use std::os::unix::fs::PermissionsExt;
    let name = format!("bin/{name}");
    folder.add(&name, format!("#!/bin/bash\n{script}\n"));
    fs::set_permissions(folder.path(&name), fs::Permissions::from_mode(0o755)).expect("set");
}

/// A command with these programs in its path, and others only where `others` says so.
fn with_programs(folder: &Folder, mut command: Command, others: bool) -> Command {
    let others = if others { format!(":{}", std::env::var("PATH").expect("a path")) } else { String::new() };
    command.env("PATH", format!("{}{others}", folder.path("bin").display()));
    command
}

fn texts(output: &Output) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let errors = text(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    (text(&output.stdout), errors)
}

/// The lines of a script that sbatch reads.
fn directives(script: &str) -> Vec<&str> {
    script.lines().filter_map(|line| line.strip_prefix("#SBATCH ")).collect()
}

#[test]
fn a_script_asks_for_what_was_measured() {
    let folder = board(SIX);
    folder.succeed("dataset set.toml -o out --frames 2");
    let there = files(&folder, "out");
    let arguments = "submit slurm set.toml -o out --tasks 2 --threads 1 --account physics --partition long \
                     --directive=--qos=high --json";
    let outcome = folder.succeed(arguments);
    assert!(there == files(&folder, "out"), "nothing is changed");
    let said = json(&outcome.stdout);
    let script = said["text"].as_str().expect("a script");
    let asked = directives(script);
    for line in
        ["--array=0-1", "--cpus-per-task=1", "--requeue", "--open-mode=append", "--signal=B:USR1@30", "--job-name=set"]
    {
        assert!(asked.contains(&line), "{line}: {asked:?}");
    }
    assert_eq!(
        asked[asked.len() - 3..],
        ["--account=physics", "--partition=long", "--qos=high"],
        "which overrule others"
    );
    assert!(script.contains("frames=(\n    0..2\n    3..6\n)\n"), "{script}");
    let number = |value: &Value| value.as_f64().expect("a number");
    let (each, forecast) = (&said["each"], &said["forecast"]);
    assert_eq!((&said["tasks"], &each["frames_per_task"], &forecast["present"]), (&2.into(), &3.into(), &1.into()));
    // Head room: half as much memory again, in whole steps, and twice the time with two minutes.
    let memory = number(&forecast["memory_bytes"]) / f64::from(1 << 20) * 1.5;
    let asked_mib = number(&each["memory_mib"]);
    assert!(asked_mib >= memory && asked_mib < memory + 256.0 && asked.contains(&&*format!("--mem={asked_mib}M")));
    let minutes = (number(&forecast["frame_s"]) * 3.0 * 2.0 + 120.0) / 60.0;
    assert_eq!(number(&each["time_limit_min"]), minutes.ceil());
    assert!((number(&forecast["time_s"]) / number(&forecast["frame_s"]) - 5.0).abs() < 1e-6, "five frames are missing");
}

/// Two pictures of a frame by two cameras, and tasks by time: at most as many frames as fit in.
#[test]
fn tasks_are_cut_by_measured_time() {
    let folder = board("frames = 8\n[[cameras]]\nname = 'a'\n[[cameras]]\nname = 'b'\nset = ['lens.f_number=8']\n");
    let whole = json(&folder.succeed("submit openjd set.toml --json --threads 1").stdout);
    assert_eq!((&whole["tasks"], &whole["each"]["frames_per_task"]), (&1.into(), &8.into()), "they take no half hour");
    assert_eq!(whole["forecast"]["pictures"], 16);
    // No frame takes a microsecond.
    let single = json(&folder.succeed("submit openjd set.toml --json --task-time 1e-9 --threads 1").stdout);
    assert_eq!((&single["tasks"], &single["each"]["frames_per_task"]), (&8.into(), &1.into()));
    let few = json(&folder.succeed("submit openjd set.toml --json --tasks 3 --threads 1 --time-limit 7").stdout);
    assert_eq!((&few["tasks"], &few["each"]["frames_per_task"]), (&3.into(), &3.into()));
    assert_eq!(few["each"]["time_limit_min"], 7);
    let many = json(&folder.succeed("submit openjd set.toml --json --tasks 100 --threads 1").stdout);
    assert_eq!(many["tasks"], 8, "no task without a frame");
}

#[test]
fn what_is_complete_needs_no_jobs() {
    let folder = board(SIX);
    folder.succeed("dataset set.toml -o out");
    let outcome = folder.succeed("submit slurm set.toml -o out");
    assert_eq!(outcome.stdout, "");
    assert!(outcome.text().contains("all 6 pictures that can be made exist: there is nothing to submit"));
    assert_eq!(json(&folder.succeed("submit slurm set.toml -o out --json").stdout)["tasks"], 0);
}

/// A script as Slurm starts it, for its first task, with programs in the places of Slurm's and photosite's.
fn task(folder: &Folder, photosite: &str) -> Command {
    program(folder, "photosite judged", photosite);
    program(folder, "scontrol", "echo \"$@\" >> requeued");
    program(folder, "sleep", "echo \"$@\" >> slept");
    let judged = folder.path("bin/photosite judged");
    let mut command = folder.command("submit slurm set.toml --write job.sh --force --quiet --retries 2 --program");
    assert!(command.arg(judged).status().expect("the binary runs").success());
    let mut task = Command::new("bash");
    task.current_dir(folder.path("")).arg("job.sh").stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    task.env("SLURM_ARRAY_TASK_ID", "0").env("SLURM_JOB_ID", "17").env_remove("SLURM_RESTART_COUNT");
    with_programs(folder, task, true)
}

fn lines(folder: &Folder, name: &str) -> Vec<String> {
    fs::read_to_string(folder.path(name)).unwrap_or_default().lines().map(str::to_owned).collect()
}

#[rstest]
#[case::done("exit 0", 1, 0)]
#[case::failed("exit 1", 1, 1)]
#[case::wrong_usage("exit 2", 1, 2)]
#[case::crashed("kill -SEGV $$", 1, 139)]
#[case::another_try("exit 75", 3, 75)]
#[case::killed("kill -KILL $$", 3, 137)]
#[case::ended("exit 143", 3, 143)]
#[case::once_killed("[[ -e tried ]] && exit 0; touch tried; kill -KILL $$", 2, 0)]
#[case::once_full("[[ -e tried ]] && exit 1; touch tried; exit 75", 2, 1)]
fn a_task_is_tried_again_where_that_may_help(#[case] photosite: &str, #[case] tries: usize, #[case] status: i32) {
    let folder = board(SIX);
    let output = task(&folder, &format!("echo \"$@\" >> tries\n{photosite}")).output().expect("bash is there");
    let (_, errors) = texts(&output);
    assert_eq!(output.status.code(), Some(status), "{errors}");
    let tried = lines(&folder, "tries");
    assert_eq!(tried.len(), tries, "{errors}");
    let (input, out) = (folder.path("set.toml"), folder.path("set"));
    let threads = std::thread::available_parallelism().expect("known");
    let wanted =
        format!("dataset {} -o {} --frames 0..6 --threads {threads} --keep-going", input.display(), out.display());
    assert!(tried.iter().all(|words| *words == wanted), "{tried:?}");
    assert!(lines(&folder, "requeued").is_empty(), "its time is not over");
    let waits = if photosite.contains("75") { tries - 1 } else { 0 };
    assert_eq!(lines(&folder, "slept").len(), waits, "a full disk is given time");
}

/// USR1 comes when the time is nearly over, TERM when somebody cancels the job. Both reach photosite as TERM, after which
/// it keeps a checkpoint. A task is requeued as often as photosite is started again, but no more.
#[rstest]
#[case::time("USR1", "0", true)]
#[case::time_again("USR1", "1", true)]
#[case::time_once_more("USR1", "2", false)]
#[case::cancelled("TERM", "0", false)]
fn photosite_is_told_to_end(#[case] signal: &str, #[case] restarts: &str, #[case] is_requeued: bool) {
    let folder = board(SIX);
    // It needs a while to end.
    let photosite =
        "trap 'kill $!; /bin/sleep 0.3; echo kept >> kept; exit 143' TERM; touch begun; /bin/sleep 100 & wait";
    let mut process = task(&folder, photosite).env("SLURM_RESTART_COUNT", restarts).spawn().expect("bash is there");
    while !folder.path("begun").exists() {
        assert!(process.try_wait().expect("a child").is_none(), "it ended early");
        sleep(Duration::from_millis(1));
    }
    send(signal, process.id());
    let output = process.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(143), "{:?}", texts(&output));
    assert_eq!(lines(&folder, "kept"), ["kept"]);
    assert_eq!(lines(&folder, "requeued"), if is_requeued { vec!["requeue 17"] } else { Vec::new() });
}

/// With the program itself, and whatever characters names have.
#[test]
fn a_script_makes_the_set_and_its_index() {
    let folder = board(SIX);
    folder.succeed("dataset set.toml -o whole --set exposure.gain_db=6");
    folder.add("it's \"here\" $HOME/set.toml", fs::read(folder.path("set.toml")).expect("read"));
    folder.add("it's \"here\" $HOME/board.toml", fs::read(folder.path("board.toml")).expect("read"));
    let mut command = folder.command("submit slurm --tasks 2 --threads 1 --quiet --set exposure.gain_db=6 --write");
    command.arg(folder.path("a b/job.sh")).arg("it's \"here\" $HOME/set.toml").arg("-o").arg("the out");
    let output = command.output().expect("the binary runs");
    assert!(output.status.success(), "{output:?}");
    let run = |arguments: &[&str], task: &str| {
        let mut command = Command::new("bash");
        command.current_dir(folder.path("")).arg("a b/job.sh").args(arguments).env("SLURM_ARRAY_TASK_ID", task);
        command.output().expect("bash is there")
    };
    for task in ["0", "1"] {
        assert_eq!(run(&["index"], "0").status.code(), Some(1), "pictures are missing");
        assert!(run(&[], task).status.success());
    }
    assert!(run(&["index"], "0").status.success());
    assert!(files(&folder, "whole") == files(&folder, "the out"));
}

#[test]
fn scripts_are_sent_with_sbatch() {
    let folder = board(SIX);
    program(&folder, "sbatch", "echo \"$*\" >> sent; cat > script-$(wc -l < sent); echo \"4$(wc -l < sent);cluster\"");
    let command = folder.command("submit slurm set.toml -o out --submit --json --tasks 2");
    let output = with_programs(&folder, command, true).output().expect("the binary runs");
    let (said, errors) = texts(&output);
    assert_eq!(output.status.code(), Some(0), "{errors}");
    let said = json(&said);
    assert_eq!((&said["jobs"], &said["sent"]), (&vec!["41", "42"].into(), &true.into()));
    let wanted = ["--parsable /dev/stdin", "--parsable --dependency=afterany:41 --array=0 /dev/stdin index"];
    assert_eq!(lines(&folder, "sent"), wanted);
    let scripts = ["script-1", "script-2"].map(|name| fs::read_to_string(folder.path(name)).expect("read"));
    assert!(scripts[0].starts_with("#!/bin/bash\n") && scripts[0] == scripts[1]);
    // The folder is that of the data set from now on.
    assert!(folder.path("out/dataset.json").exists());
}

#[test]
fn programs_that_are_not_there_are_named() {
    let folder = board(SIX);
    fs::create_dir(folder.path("bin")).expect("made");
    for (arguments, wanted) in [
        (
            "submit slurm set.toml -o out --submit",
            ["sbatch is not installed here", "write the script with --write FILE"],
        ),
        ("submit openjd set.toml -o out --submit", ["openjd is not installed here", "pip install openjd-cli"]),
    ] {
        let output = with_programs(&folder, folder.command(arguments), false).output().expect("the binary runs");
        let (said, errors) = texts(&output);
        assert_eq!((output.status.code(), &*said), (Some(1), ""), "{errors}");
        assert!(wanted.iter().all(|words| errors.contains(words)), "{errors}");
    }
    program(&folder, "sbatch", "echo 'sbatch: error: invalid partition' >&2; exit 1");
    let command = folder.command("submit slurm set.toml -o out --submit");
    let output = with_programs(&folder, command, true).output().expect("the binary runs");
    let errors = texts(&output).1;
    assert_eq!(output.status.code(), Some(1));
    assert!(errors.contains("sbatch refused the job") && errors.contains("invalid partition"), "{errors}");
}

#[rstest]
fn folders_of_something_else_are_refused(
    #[values("slurm", "openjd")] scheduler: &str,
    #[values("", "--submit")] submit: &str,
) {
    let folder = board(SIX);
    folder.succeed("dataset set.toml -o out --frames 1");
    let another = format!("submit {scheduler} set.toml -o out --set exposure.gain_db=6 {submit}");
    folder.fail(&another, 2, &["out contains another data set: its overrides say something else", "-o"]);
    folder.add("notes/text", "mine");
    folder.fail(
        &format!("submit {scheduler} set.toml -o notes {submit}"),
        2,
        &["notes is not empty and does not contain a data set"],
    );
    folder.fail(&format!("submit {scheduler} set.toml -o set.toml {submit}"), 2, &["set.toml is a file"]);
    folder.add("set.toml", "capture = 'board.toml'\nframes = 4\n[[vary]]\nkey = 'exposure.gain_db'\nsweep = [0, 60]\n");
    folder.fail(&format!("submit {scheduler} set.toml -o new {submit}"), 1, &["in frame 2: exposure.gain_db: 40 dB"]);
    folder.fail(&format!("submit {scheduler} set.toml -o new --tasks 0"), 2, &["--tasks"]);
    folder.fail(&format!("submit {scheduler} set.toml -o new --tasks 2 --task-time 3"), 2, &["cannot be used with"]);
}

/// Files appear whole, and none is lost.
#[test]
fn files_are_not_overwritten_unasked() {
    let folder = board(SIX);
    folder.add("job.sh", "mine");
    folder.fail("submit slurm set.toml --write job.sh", 2, &["job.sh already exists", "--force"]);
    folder.succeed("submit slurm set.toml --write job.sh --force");
    assert!(fs::read_to_string(folder.path("job.sh")).expect("read").ends_with("exit \"$status\"\n"));
}

/// What cannot be written to is told before anything is sent.
#[cfg(target_os = "linux")]
#[test]
fn a_read_only_folder_and_a_full_disk_send_nothing() {
    let folder = board(SIX);
    folder.succeed("dataset set.toml -o out --frames 1");
    fs::create_dir(folder.path("disk")).expect("made");
    program(&folder, "sbatch", "touch sent; echo 1");
    let binary = env!("CARGO_BIN_EXE_photosite");
    let script = format!(
        "mount --bind out out && mount -o remount,ro,bind out && mount -t tmpfs -o size=8k none disk || exit 99\n\
         export PATH=\"$PWD/bin:$PATH\"; cat /dev/zero > disk/filler\n\
         {binary} submit slurm set.toml -o out --submit --quiet; echo $?\n\
         {binary} submit slurm set.toml -o disk/out --submit --quiet; echo $?\n\
         {binary} submit slurm set.toml -o new --write disk/job.sh --quiet; echo $?; find disk -type f"
    );
    let Some(output) = crate::exit_status::with_mounts(&folder, &script) else { return };
    let (said, errors) = texts(&output);
    assert_eq!(said, "1\n75\n75\ndisk/filler\n", "{errors}");
    assert!(errors.contains("Read-only file system") && errors.contains("No space left on device"), "{errors}");
    assert!(!folder.path("sent").exists());
}

#[test]
fn templates_hold_names_as_parameters() {
    let folder = board(SIX);
    folder.add("it's {{Param.x}}/set.toml", fs::read(folder.path("set.toml")).expect("read"));
    folder.add("it's {{Param.x}}/board.toml", fs::read(folder.path("board.toml")).expect("read"));
    let mut command = folder.command("submit openjd --tasks 2 --threads 1 --time-limit 9 --set exposure.gain_db=6");
    let output = command.arg("it's {{Param.x}}/set.toml").output().expect("the binary runs");
    let (said, errors) = texts(&output);
    assert!(output.status.success(), "{errors}");
    let template = json(&said);
    let parameters = template["parameterDefinitions"].as_array().expect("a list");
    let value = |name: &str| parameters.iter().find(|p| p["name"] == name).expect("one")["default"].clone();
    let text = |path: &Path| Value::from(path.to_string_lossy());
    assert_eq!(value("Input"), text(&folder.path("it's {{Param.x}}/set.toml")));
    assert_eq!((value("Frames"), value("FramesPerTask"), value("Threads")), ("0-5".into(), 3.into(), 1.into()));
    assert_eq!((value("Argument0"), value("Argument1")), ("--set".into(), "exposure.gain_db=6".into()));
    let [render, index] = [0, 1].map(|i| &template["steps"][i]);
    let action = &render["script"]["actions"]["onRun"];
    assert_eq!((&action["timeout"], &action["cancelation"]["notifyPeriodInSeconds"]), (&540.into(), &30.into()));
    assert_eq!(index["dependencies"][0]["dependsOn"], render["name"]);
    let steps = template["steps"].to_string();
    assert!(!steps.contains("it's") && !steps.contains("gain_db"), "{steps}");
    let long = format!("submit openjd set.toml --set camera.position_m=[0,0,0.6{}]", "0".repeat(1100));
    folder.fail(&long, 2, &["camera.position_m=[0,0,0.6", "has more than 1024 characters", "(`set`)"]);
}
