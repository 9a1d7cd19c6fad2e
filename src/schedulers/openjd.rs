//! A job template for Open Job Description, as AWS Deadline Cloud and `openjd run` take it.

use serde_json::{Value, json};

use super::{Job, NOTICE_S, Tasks};
use crate::io::pretty_json::pretty_json;

/// More characters the specification allows no value of a parameter.
pub const LONGEST_PARAMETER: usize = 1024;

/// Nor one of the name of a job.
const LONGEST_NAME: usize = 128;

/// Starts a command with the frames of a chunk, which is named as 4-7, or as 4 where it is one frame.
const RUN: &str = r#"#!/bin/bash
chunk=$1
shift
exec "$@" --frames "${chunk%%-*}..$((${chunk##*-} + 1))"
"#;

/// The template, as JSON, which is YAML, too. What it names are values of its parameters, which whoever submits it may
/// change, and which mean themselves whatever characters they hold.
pub fn template(job: &Job, tasks: &Tasks, about: &[String]) -> String {
    let Job { name, program, input, output, arguments } = job;
    let mut parameters = vec![
        parameter("Program", "The command of photosite.", program),
        parameter("Input", "The data set file, where the hosts see it.", &input.to_string_lossy()),
        parameter("Output", "The folder of the data set, where the hosts see it.", &output.to_string_lossy()),
        parameter("Frames", "The frames that lack pictures.", &range(tasks)),
        json!({ "name": "FramesPerTask", "type": "INT", "description": "Frames of one task.", "default": tasks.frames_per_task }),
        json!({ "name": "Threads", "type": "INT", "description": "Threads of one task.", "default": tasks.threads }),
    ];
    let mut command = ["dataset", "{{Param.Input}}", "-o", "{{Param.Output}}"].map(str::to_owned).to_vec();
    for (index, argument) in arguments.iter().enumerate() {
        let name = format!("Argument{index}");
        parameters.push(parameter(&name, "An argument of photosite dataset.", argument));
        command.push(format!("{{{{Param.{name}}}}}"));
    }
    let mut render = ["{{Task.File.Run}}", "{{Task.Param.Frame}}", "{{Param.Program}}"].map(str::to_owned).to_vec();
    render.extend(command.iter().cloned());
    render.extend(["--threads", "{{Param.Threads}}", "--keep-going"].map(str::to_owned));
    command.extend(["--index-only", "--keep-going"].map(str::to_owned));
    let memory = tasks.memory_mib.map(|mib| json!({ "name": "amount.worker.memory", "min": mib }));
    let amounts: Vec<Value> =
        std::iter::once(json!({ "name": "amount.worker.vcpu", "min": tasks.threads })).chain(memory).collect();
    let template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "extensions": ["TASK_CHUNKING"],
        "name": name.chars().take(LONGEST_NAME).collect::<String>(),
        "description": about.join("\n"),
        "parameterDefinitions": parameters,
        "steps": [
            {
                "name": "Frames",
                "hostRequirements": { "amounts": amounts },
                "parameterSpace": { "taskParameterDefinitions": [{
                    "name": "Frame",
                    "type": "CHUNK[INT]",
                    "range": "{{Param.Frames}}",
                    "chunks": { "defaultTaskCount": "{{Param.FramesPerTask}}", "rangeConstraint": "CONTIGUOUS" },
                }] },
                "script": {
                    "embeddedFiles": [{ "name": "Run", "type": "TEXT", "filename": "run.sh", "data": RUN }],
                    "actions": { "onRun": {
                        "command": "bash",
                        "args": render,
                        "timeout": tasks.time_limit_min * 60,
                        // It gets SIGTERM first, and keeps a checkpoint.
                        "cancelation": { "mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": NOTICE_S },
                    } },
                },
            },
            {
                "name": "Index",
                "dependencies": [{ "dependsOn": "Frames" }],
                "script": { "actions": { "onRun": { "command": "{{Param.Program}}", "args": command } } },
            },
        ],
    });
    pretty_json(&template) + "\n"
}

fn parameter(name: &str, description: &str, value: &str) -> Value {
    json!({ "name": name, "type": "STRING", "description": description, "default": value })
}

/// Frames as the specification has them: `0-7,9`, or from the first to the last where that is too long for it.
fn range(tasks: &Tasks) -> String {
    let ranges = tasks.frames.iter().flat_map(|frames| frames.ranges());
    let mut whole: Vec<std::ops::Range<u32>> = Vec::new();
    for range in ranges {
        match whole.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            Some(_) | None => whole.push(range.clone()),
        }
    }
    let words = whole.iter().map(|range| match range.end - 1 {
        last if last == range.start => last.to_string(),
        last => format!("{}-{last}", range.start),
    });
    let words = words.collect::<Vec<_>>().join(",");
    match (whole.first(), whole.last()) {
        // Those between that are there take no time.
        (Some(first), Some(last)) if words.len() > LONGEST_PARAMETER => format!("{}-{}", first.start, last.end - 1),
        _ => words,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::FrameList;

    fn tasks(frames: Vec<FrameList>) -> Tasks {
        Tasks {
            tasks: frames.len(),
            frames,
            frames_per_task: 3,
            task_s: 1.0,
            time_limit_min: 3,
            memory_mib: None,
            threads: 1,
        }
    }

    #[test]
    fn frames_of_tasks_become_one_range() {
        let frames = [vec![0, 1, 2], vec![3, 4, 7], vec![9]].map(|numbers| FrameList::of(&numbers)).to_vec();
        assert_eq!(range(&tasks(frames)), "0-4,7,9");
        let scattered: Vec<u32> = (5..1000).step_by(2).collect();
        assert_eq!(range(&tasks(vec![FrameList::of(&scattered)])), "5-999");
    }
}
