#!/usr/bin/env python3
"""Tests of the gate's table: every file of the repository has a row, every step can be reached, and choices are those meant."""

import sys
import unittest
from collections import Counter

sys.dont_write_bytecode = True
from choose import ALL, BY_TURN, ROOT, Row, Table, git  # noqa: E402

TABLE = Table()
FILES = [path for path in git("ls-files", "-z").split("\0") if path]


class Rows(unittest.TestCase):
    def test_every_file_has_a_row(self) -> None:
        self.assertEqual([path for path in FILES if TABLE.row(path) is None], [])

    def test_every_row_counts_for_a_file(self) -> None:
        counts = Counter(found[0].pattern for found in map(TABLE.row, FILES) if found)
        # Those of "everything" are for what is new.
        rows = [row.pattern for row in TABLE.rows if row.asks != ["everything"]]
        self.assertEqual([pattern for pattern in rows if not counts[pattern]], [])

    def test_every_crate_and_judge_has_a_row_of_its_own(self) -> None:
        for folder in ("crates/", "tests/judges/"):
            row = TABLE.row(folder + "something-new/a")
            self.assertEqual(row and row[0].pattern, folder)
            shared = [path for path in FILES if path.startswith(folder) and TABLE.row(path)[0].pattern == folder]
            self.assertEqual(shared, [], "these ask for everything")

    def test_every_step_is_reached_by_some_row(self) -> None:
        reached = set().union(*(TABLE.choose([path]) for path in FILES))
        self.assertEqual(set(TABLE.steps) - reached, set())

    def test_every_group_is_used(self) -> None:
        asks = {ask for row in TABLE.rows for ask in row.asks} | {ask for group in TABLE.groups.values() for ask in group}
        self.assertEqual(set(TABLE.groups) - asks, set())

    def test_patterns(self) -> None:
        for pattern, path, names in (
            ("a/", "a/b/c", {}),
            ("a/*.py", "a/b.py", {}),
            ("a/{x}/", "a/b/c/d", {"x": "b"}),
            ("a/{x}.md", "a/b.md", {"x": "b"}),
        ):
            self.assertEqual(Row(pattern, []).expression.fullmatch(path).groupdict(), names, pattern)
        for pattern, path in (("a/", "ab/c"), ("a/*.py", "a/b/c.py"), ("a.b", "axb"), ("a/{x}.md", "a/b/c.md")):
            self.assertIsNone(Row(pattern, []).expression.fullmatch(path), pattern)


class Steps(unittest.TestCase):
    def test_steps_are_whole(self) -> None:
        keys = {"says", "run", "needs", "debian", "beside", "always", "turns"}
        before: "set[str]" = set()
        for name, step in TABLE.steps.items():
            self.assertLessEqual(set(step), keys, name)
            self.assertNotEqual("run" in step, (ROOT / f".ci/steps/{name}.sh").exists(), f"{name}: either run or a file")
            self.assertLessEqual(set(TABLE.needs(name)), before, f"{name} needs what comes later")
            before.add(name)

    def test_every_lock_is_used(self) -> None:
        self.assertEqual(set().union(*map(TABLE.locks_of, TABLE.steps)), set(TABLE.locks))

    def test_needs_and_locks_are_read_from_commands(self) -> None:
        self.assertEqual(TABLE.needs("emva1288-python"), ["build", "wheel"])
        self.assertEqual(TABLE.locks_of("emva1288-python"), {"package", "emva1288"})
        self.assertEqual((TABLE.needs("build"), TABLE.needs("fmt"), TABLE.needs("types")), ([], [], ["wheel"]))

    def test_files_are_those_of_steps(self) -> None:
        names = {path.stem for path in (ROOT / ".ci/steps").glob("*.sh")}
        self.assertEqual(names - set(TABLE.steps), set())


class Choices(unittest.TestCase):
    def steps(self, *paths: str) -> "dict[str, str]":
        return {name: step.cases_text() for name, step in TABLE.choose(list(paths)).items()}

    def test_a_page_runs_itself(self) -> None:
        chosen = self.steps("docs/guides/lenses.md")
        self.assertEqual(chosen["pages"], "guides/lenses")
        self.assertEqual(chosen["test-cli"], "documents")
        self.assertNotIn("test-physics", chosen)

    def test_cases_add_up(self) -> None:
        self.assertEqual(self.steps("docs/guides/lenses.md", "docs/index.md")["pages"], "guides/lenses index")
        self.assertEqual(self.steps("docs/guides/lenses.md", "docs/run.py")["pages"], ALL)

    def test_what_nothing_asks_for_is_not_run(self) -> None:
        self.assertEqual(set(self.steps("CONTRIBUTING.md", ".ci/passed")), {"small", "fmt"})

    def test_what_cannot_be_told_runs_everything(self) -> None:
        for path in ("somewhere/new.rs", "crates/photosite-new/src/lib.rs", "tests/judges/new.py", "Cargo.lock"):
            self.assertEqual(set(self.steps(path)), set(TABLE.everything()), path)

    def test_each_step_has_its_turn_where_everything_is_asked(self) -> None:
        turns = {step["turns"] for step in TABLE.steps.values() if "turns" in step}
        for number in turns:
            chosen = [name for turn in range(number) for name in Table(turn=turn).choose(["Cargo.lock"])]
            seldom = {name for name, step in TABLE.steps.items() if step.get("turns") == number}
            self.assertEqual({name: chosen.count(name) for name in seldom}, dict.fromkeys(seldom, 1))
            self.assertTrue(all(chosen.count(name) == number for name in TABLE.steps if "turns" not in TABLE.steps[name]))

    def test_a_changed_table_runs_the_steps_whose_rows_have_changed(self) -> None:
        before = {"steps": dict(TABLE.steps), "locks": dict(TABLE.locks)}
        before["steps"]["meshes"] = dict(TABLE.steps["meshes"], run="something else")
        before["steps"]["objects"] = dict(TABLE.steps["objects"], says="something else", turns=7)
        del before["steps"]["stereo"], before["locks"]["trainers"]
        table = Table()
        table.before = before
        chosen = set(table.choose([".ci/steps.toml"]))
        self.assertEqual(chosen, {"small", "fmt", "build", "wheel", "meshes", "stereo", "trainers"})
        self.assertEqual(self.steps(".ci/gate.py"), self.steps("CONTRIBUTING.md"))

    def test_steps_that_are_named_run_whosever_turn_it_is(self) -> None:
        for turn in range(6):
            self.assertIn("faults", Table(turn=turn).choose(["tests/faults.py"]))

    def test_locks_ask_for_the_steps_that_use_them(self) -> None:
        self.assertLessEqual({"emva1288", "emva1288-python"}, set(self.steps(".ci/locks/emva1288.lock")))
        self.assertNotIn("calibration", self.steps(".ci/locks/emva1288.lock"))

    def test_needs_are_added(self) -> None:
        self.assertEqual(self.steps("python/photosite/_light.py")["build"], BY_TURN)


if __name__ == "__main__":
    unittest.main()
