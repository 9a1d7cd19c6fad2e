"""The gate: everything that must hold before a change is taken. Runs as root on Debian 12 with cargo and Python 3.11.

    .ci/run                  what the changes since the commit in .ci/passed ask for, by the table of .ci/steps.toml
    .ci/run --full           all steps with all their cases
    .ci/run --list           prints what would run, and why
    .ci/run STEP[:CASE]...   these steps, and what they need

Where the commit in .ci/passed is not in the clone or no ancestor, all steps run, with some of their cases, and of the longer
steps (`turns`) some.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

CI = Path(__file__).resolve().parent
ROOT = CI.parent
sys.path.insert(0, str(CI))
sys.dont_write_bytecode = True
import dependencies  # noqa: E402
from choose import TABLE, Chosen, Table, changed_since, git  # noqa: E402


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog=".ci/run", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("steps", nargs="*", metavar="STEP[:CASE]")
    parser.add_argument("--full", action="store_true", help="all steps with all cases")
    parser.add_argument("--list", action="store_true", help="print what would run, and why")
    parser.add_argument("--since", metavar="COMMIT", help="the last commit that passed (default: the one in .ci/passed)")
    parser.add_argument("--changed", nargs="+", metavar="PATH", help="with --list: as if these had changed")
    parser.add_argument("--keep-going", action="store_true", help="go on after a step that fails")
    options = parser.parse_args()
    if options.changed and not options.list:
        parser.error("--changed goes with --list: a gate is of what has changed")
    return options


def choice(table: Table, options: argparse.Namespace) -> "dict[str, Chosen]":
    if options.full:
        return table.all_cases("--full")
    if options.steps:
        asked: "dict[str, Chosen]" = {}
        for name, case in (found for step in options.steps for found in table.cases(step)):
            asked.setdefault(name, Chosen(why=["asked for"])).cases.add(case)
        return table.with_needs(asked)
    if options.changed:
        return table.choose(options.changed)
    passed = options.since or (CI / "passed").read_text().strip()
    changed = changed_since(passed)
    if changed is None:
        return table.all_steps(f"{passed or 'the commit of .ci/passed'} is no ancestor in this clone")
    if TABLE in changed and git("ls-tree", passed, TABLE):
        table.before = tomllib.loads(git("show", f"{passed}:{TABLE}"))
    return table.choose(changed)


def show(chosen: "dict[str, Chosen]") -> None:
    for name, step in chosen.items():
        cases = {"by-turn": "", "*": ":*"}.get(step.cases_text(), f":{step.cases_text()}")
        others = f" and {len(step.why) - 1} more" if len(step.why) > 1 else ""
        print(f"{name}{cases}  <- {step.why[0]}{others}")


def install(packages: "set[str]") -> None:
    """Installs those packages of Debian that are missing."""
    query = ["dpkg-query", "-W", "-f", "${Package} ${Status}\n", *sorted(packages)]
    there = subprocess.run(query, capture_output=True, text=True).stdout
    missing = sorted(package for package in packages if f"{package} install ok installed\n" not in there)
    if missing:
        quiet = dict(os.environ, DEBIAN_FRONTEND="noninteractive")
        subprocess.run(["apt-get", "update", "-qq"], check=True, env=quiet)
        done = subprocess.run(["apt-get", "install", "-y", "-qq", "--no-install-recommends", *missing], env=quiet, capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stdout + done.stderr)


@dataclass
class Running:
    process: "subprocess.Popen[bytes]"
    begun: float
    log: "Path | None"


class Run:
    """Steps that run, in a folder that they share."""

    def __init__(self, table: Table, chosen: "dict[str, Chosen]", scratch: Path) -> None:
        self.table, self.chosen, self.scratch = table, chosen, scratch
        self.running: "dict[str, Running]" = {}
        self.seconds: "dict[str, float]" = {}
        self.failed: "list[str]" = []
        self.begun = time.monotonic()

    def start(self, name: str) -> None:
        """Starts a step in a bash of its own: within functions of one script `set -e` would be void wherever a condition calls them."""
        step = self.table.steps[name]
        commands = step.get("run") or f". .ci/steps/{name}.sh"
        environment = dict(
            os.environ,
            SCRATCH=str(self.scratch),
            CI_ROOT=str(ROOT),
            CI_CASES=self.chosen[name].cases_text(),
            CI_TURN=str(self.table.turn),
            CARGO_TERM_COLOR="never",
            PYTHONDONTWRITEBYTECODE="1",
        )
        log = self.scratch / f"{name}.log" if step.get("beside") else None
        beside = f"; beside others, to {log.name}" if log else ""
        print(f"\n=== {name}: {step['says']} ({time.monotonic() - self.begun:.0f} s{beside})", flush=True)
        with open(log or os.devnull, "wb") as output:
            process = subprocess.Popen(
                ["bash", "-euo", "pipefail", "-O", "inherit_errexit", "-c", f". .ci/lib.sh\n{commands}"],
                cwd=ROOT,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=output if log else None,
                stderr=subprocess.STDOUT if log else None,
                start_new_session=True,
            )
        self.running[name] = Running(process, time.monotonic(), log)

    def finish(self, name: str) -> None:
        step = self.running[name]
        status = step.process.wait()
        self.end(name)
        self.seconds[name] = time.monotonic() - step.begun
        if status:
            if step.log:
                print(step.log.read_text(errors="replace"), flush=True)
            print(f"*** {name} failed with {status}", flush=True)
            self.failed.append(name)

    def end(self, name: str) -> None:
        """Ends what a step has left running."""
        try:
            os.killpg(self.running.pop(name).process.pid, signal.SIGTERM)
        except ProcessLookupError:
            pass

    def all(self, keep_going: bool) -> None:
        try:
            for name in self.chosen:
                needs = self.table.needs(name)
                for need in needs:
                    if need in self.running:
                        self.finish(need)
                if any(need in self.failed for need in needs):
                    print(f"\n=== {name}: left out, as what it needs has failed", flush=True)
                    self.failed.append(name)
                elif not self.failed or keep_going:
                    self.start(name)
                    if not self.table.steps[name].get("beside"):
                        self.finish(name)
            for name in list(self.running) if keep_going or not self.failed else []:
                self.finish(name)
        finally:
            for name in list(self.running):
                self.end(name)

    def report(self) -> None:
        print("\n=== seconds of each step")
        for name, seconds in self.seconds.items():
            print(f"{seconds:7.0f}  {name}{' (failed)' if name in self.failed else ''}")
        print(f"{time.monotonic() - self.begun:7.0f}  in all", flush=True)


def main() -> int:
    options = arguments()
    os.chdir(ROOT)
    table = Table()
    chosen = choice(table, options)
    if options.list:
        # Ends quietly where `head` has read enough.
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
        show(chosen)
        return 0
    install({package for name in chosen for package in table.steps[name].get("debian", [])} | {"python3-venv"})
    # Tests send signals that a shell or nohup lets its background jobs ignore, and these hand that on.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for ignored in (signal.SIGQUIT, signal.SIGHUP):
        signal.signal(ignored, signal.SIG_DFL)
    # A signal ends the run as an exception does, so that no step outlives it.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    dependencies.restore()
    with tempfile.TemporaryDirectory(prefix="photosite-ci-") as scratch:
        run = Run(table, chosen, Path(scratch))
        try:
            run.all(options.keep_going)
        finally:
            dependencies.keep()
        run.report()
    if run.failed:
        print(f"Failed: {', '.join(run.failed)}")
        return 1
    print(f"All {len(chosen)} steps passed.")
    if options.full and not git("status", "--porcelain"):
        print("Everything passed at this commit; to begin from here next time: git rev-parse HEAD >.ci/passed, and commit that")
    return 0


if __name__ == "__main__":
    sys.exit(main())
