//! An array script for Slurm.

use super::shell::{all_quoted, quoted};
use super::{Job, NOTICE_S, Tasks};

/// What a job does that has no frames: the argument of its script.
const INDEX: &str = "index";

/// What makes the job of the script at `script` that comes last, after the array `array`: arguments of sbatch.
pub fn index_command(array: &str, script: Option<&str>) -> Vec<String> {
    let mut words = vec!["--parsable".to_owned(), format!("--dependency=afterany:{array}"), "--array=0".to_owned()];
    // Without a name it comes by standard input.
    words.push(script.unwrap_or("/dev/stdin").to_owned());
    words.push(INDEX.to_owned());
    words
}

/// What a site wants of scripts.
#[derive(Clone, Debug)]
pub struct Site {
    /// More lines for sbatch.
    pub directives: Vec<String>,
    /// What is run before photosite is.
    pub setup: Vec<String>,
    /// How often photosite is started again in a task, and how often a task is requeued.
    pub retries: u32,
}

/// The script.
pub fn script(job: &Job, tasks: &Tasks, about: &[String], site: &Site) -> String {
    let Job { name, program, input, output, arguments } = job;
    let Site { directives, setup, retries } = site;
    let [input, output] = [input, output].map(|path| path.to_string_lossy().into_owned());
    let command = [program.as_str(), "dataset", &input, "-o", &output];
    let command = all_quoted(command.into_iter().chain(arguments.iter().map(String::as_str)));
    let about: String = about.iter().map(|line| format!("# {line}\n")).collect();
    let memory = tasks.memory_mib.map_or_else(String::new, |mib| format!("#SBATCH --mem={mib}M\n"));
    let directives: String = directives.iter().map(|line| format!("#SBATCH {line}\n")).collect();
    let setup: String = setup.iter().map(|line| format!("{line}\n")).collect();
    let frames: String = tasks.frames.iter().map(|frames| format!("    {}\n", frames.in_full())).collect();
    format!(
        r#"#!/bin/bash
# A data set by photosite {version}, as an array of jobs and one that comes last:
#
#     array=$(sbatch --parsable SCRIPT)
#     sbatch --dependency=afterany:$array --array=0 SCRIPT {INDEX}
#
{about}#SBATCH --job-name={name}
#SBATCH --array=0-{last}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task={threads}
{memory}#SBATCH --time={limit}
#SBATCH --signal=B:USR1@{NOTICE_S}
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output={name}-%A_%a.log
{directives}
set -u
{setup}photosite=({command})
if [[ ${{1-}} == {INDEX} ]]; then
    exec "${{photosite[@]}}" --index-only --keep-going
fi

frames=(
{frames})
most_tries={retries}

# The time is nearly over, or somebody ends the job: photosite keeps a checkpoint of what it has.
ended_by=
child=
end() {{
    ended_by=$1
    if [[ -n $child ]]; then kill -TERM "$child" 2>/dev/null; fi
}}
trap 'end time' USR1
trap 'end someone' TERM

# Runs a command to its end; a signal that comes meanwhile ends only the wait for it.
run() {{
    "$@" &
    child=$!
    wait "$child"
    status=$?
    while kill -0 "$child" 2>/dev/null; do
        wait "$child"
        status=$?
    done
    child=
}}

status=0
for ((tries = 0; tries <= most_tries; tries++)); do
    run "${{photosite[@]}}" --frames "${{frames[SLURM_ARRAY_TASK_ID]}}" --threads {threads} --keep-going
    if [[ -n $ended_by ]]; then break; fi
    case $status in
        # Killed (memory, somebody), or ended: it goes on here at once. Slurm would wait for two minutes.
        137 | 143) ;;
        # A disk was full, or a server away.
        75)
            if ((tries < most_tries)); then run sleep $((10 * (tries + 1))); fi
            status=75
            ;;
        # Done, failed for good, or wrong usage.
        *) exit "$status" ;;
    esac
    if [[ -n $ended_by ]]; then break; fi
    if ((tries == most_tries)); then break; fi
    echo "photosite ended with status $status; try $((tries + 2)) of $((most_tries + 1))" >&2
done

# It continues from its checkpoint.
if [[ $ended_by == time ]] && ((status != 0 && ${{SLURM_RESTART_COUNT:-0}} < most_tries)); then
    scontrol requeue "$SLURM_JOB_ID"
fi
exit "$status"
"#,
        version = env!("CARGO_PKG_VERSION"),
        last = tasks.frames.len().saturating_sub(1),
        threads = tasks.threads,
        limit = time(tasks.time_limit_min),
        name = quoted(name),
    )
}

/// Minutes as Slurm has them, with days.
fn time(minutes: u64) -> String {
    format!("{}-{:02}:{:02}:00", minutes / 1440, minutes / 60 % 24, minutes % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_written_with_days() {
        assert_eq!(time(3), "0-00:03:00");
        assert_eq!(time(1439), "0-23:59:00");
        assert_eq!(time(3001), "2-02:01:00");
    }
}
