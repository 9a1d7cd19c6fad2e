"""Which steps of the gate a commit asks for: a function of what has changed since the commit in `.ci/passed`, by steps.toml."""

import re
import subprocess
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TABLE = ".ci/steps.toml"
# Cases of a step: some of them, by the commit, and all.
BY_TURN, ALL = "by-turn", "*"


@dataclass
class Row:
    """Pattern of paths, and what a change of such a path asks for."""

    pattern: str
    asks: "list[str]"
    expression: "re.Pattern[str]" = field(init=False)

    def __post_init__(self) -> None:
        parts = re.split(r"(\*|\{\w+\})", self.pattern)
        part = {True: lambda p: "[^/]*" if p == "*" else f"(?P<{p[1:-1]}>[^/]+)", False: re.escape}
        below = ".*" if self.pattern.endswith("/") else ""
        self.expression = re.compile("".join(part[i % 2 == 1](p) for i, p in enumerate(parts)) + below)


@dataclass
class Chosen:
    """Cases of a step that run, and why: what has changed, by the row that matches it."""

    cases: "set[str]" = field(default_factory=set)
    why: "list[str]" = field(default_factory=list)

    def cases_text(self) -> str:
        return ALL if ALL in self.cases else " ".join(sorted(self.cases))


class Table:
    def __init__(self, path: Path = ROOT / TABLE, turn: "int | None" = None) -> None:
        table = tomllib.loads(path.read_text())
        self.turn = turn_of_commit() if turn is None else turn
        self.rows = [Row(pattern, asks) for pattern, asks in table["changes"].items()]
        self.groups: "dict[str, list[str]]" = table["groups"]
        self.steps: "dict[str, dict]" = table["steps"]
        self.locks: "dict[str, list[str]]" = table["locks"]
        # The same of the commit that passed, where it is known
        self.before: "dict[str, dict] | None" = None

    def commands(self, step: str) -> str:
        return self.steps[step].get("run") or (ROOT / f".ci/steps/{step}.sh").read_text()

    def needs(self, step: str) -> "list[str]":
        """Steps that run before one."""
        commands = self.commands(step)
        used = {"build": "target/release", "wheel": r"\+wheel|\$SCRATCH\"?/wheels"}
        found = [need for need, words in used.items() if step not in ("build", need) and re.search(words, commands)]
        return [*found, *self.steps[step].get("needs", [])]

    def locks_of(self, step: str) -> "set[str]":
        """Names of the Python environments that a step uses."""
        return set(re.findall(r"\b(?:python|interpreter_of) ([a-z0-9]+)", self.commands(step))) & set(self.locks)

    def row(self, path: str) -> "tuple[Row, dict[str, str]] | None":
        """The last row that matches a path, with what stands for its {names}."""
        for row in reversed(self.rows):
            if match := row.expression.fullmatch(path):
                return row, match.groupdict()
        return None

    def everything(self) -> "list[str]":
        """All steps; of those that have turns, the ones whose turn it is."""
        rare = [name for name, step in self.steps.items() if "turns" in step]
        off = {name for i, name in enumerate(rare) if (self.turn + i) % self.steps[name]["turns"]}
        return [name for name in self.steps if name not in off]

    def cases(self, asked: str) -> "list[tuple[str, str]]":
        """Steps with one case each that a value of a row stands for."""
        name, _, case = asked.partition(":")
        if asked == "everything":
            return [(step, BY_TURN) for step in self.everything()]
        if name == "lock":
            return [(step, BY_TURN) for step in self.steps if case == "tools" or case in self.locks_of(step)]
        if name in self.groups:
            return [found for member in self.groups[name] for found in self.cases(member)]
        if name not in self.steps:
            raise SystemExit(f".ci/steps.toml: there is no step and no group {name!r}")
        return [(name, case or BY_TURN)]

    def steps_that_differ(self, before: "dict[str, dict]") -> "list[tuple[str, str]]":
        """Steps that do something else than in a table of before, or whose lock is another."""
        counts = lambda step: {key: value for key, value in step.items() if key not in ("says", "turns")}
        known = {name: counts(step) for name, step in before["steps"].items()}
        found = [(name, BY_TURN) for name, step in self.steps.items() if counts(step) != known.get(name)]
        locks = [name for name, sources in self.locks.items() if sources != before["locks"].get(name)]
        return found + [case for name in locks for case in self.cases(f"lock:{name}")]

    def asked_by(self, path: str) -> "tuple[str, list[tuple[str, str]]]":
        """Reason and steps of a path that has changed."""
        if path == TABLE and self.before:
            return f"{path}, rows of steps", self.steps_that_differ(self.before)
        found = self.row(path)
        if found is None:
            return f"{path}, which no row names", self.cases("everything")
        row, names = found
        return f"{path} (row {row.pattern})", [case for ask in row.asks for case in self.cases(ask.format(**names))]

    def choose(self, paths: "list[str]") -> "dict[str, Chosen]":
        chosen: "dict[str, Chosen]" = {}
        for name, step in self.steps.items():
            if step.get("always"):
                chosen[name] = Chosen({BY_TURN}, ["always"])
        for path in paths:
            why, cases = self.asked_by(path)
            for name, case in cases:
                step = chosen.setdefault(name, Chosen())
                step.cases.add(case)
                if why not in step.why:
                    step.why.append(why)
        return self.with_needs(chosen)

    def all_steps(self, why: str) -> "dict[str, Chosen]":
        return self.with_needs({name: Chosen({BY_TURN}, [why]) for name in self.everything()})

    def all_cases(self, why: str) -> "dict[str, Chosen]":
        return {name: Chosen({ALL}, [why]) for name in self.steps}

    def with_needs(self, chosen: "dict[str, Chosen]") -> "dict[str, Chosen]":
        """Adds what chosen steps need, in the order of the table."""
        for name in reversed(self.steps):
            for need in self.needs(name) if name in chosen else []:
                chosen.setdefault(need, Chosen({BY_TURN}, [f"{name} needs it"]))
        return {name: chosen[name] for name in self.steps if name in chosen}


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout


def changed_since(commit: str) -> "list[str] | None":
    """Paths that differ from those of a commit, or None where it is no ancestor of this one, or not in this clone."""
    ancestor = ["git", "merge-base", "--is-ancestor", commit, "HEAD"]
    if not commit or subprocess.run(ancestor, cwd=ROOT, capture_output=True).returncode:
        return None
    changed = git("diff", "--name-only", "--no-renames", "-z", commit) + git("ls-files", "--others", "--exclude-standard", "-z")
    return sorted(set(filter(None, changed.split("\0"))))


def turn_of_commit() -> int:
    """Number of the commit's files by which some of all steps, and some of their cases, are chosen."""
    return int(git("rev-parse", "HEAD^{tree}")[:8], 16)
