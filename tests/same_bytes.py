#!/usr/bin/env python3
"""Whether two builds of photosite make the same files of every capture here.

    python3 tests/same_bytes.py OLD_PROGRAM NEW_PROGRAM [--samples N] [--only NAME ...]

Renders every capture file in scenes/ and tests/mitsuba/scenes/ with both programs, one after the other, and compares
raw.dng, electrons.exr and image.png byte for byte, but for the version of the program that wrote them. What differs in
capture.json, besides the timings, is shown but is no failure: it may be worded anew. Ends with status 1 where a file
differs or is missing. Without --samples each capture takes as many as it says, which can take an hour.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FILES = ["raw.dng", "electrons.exr", "image.png"]
# What may differ between two runs of one program, and what is computed from its version or from files that state it.
PASSING = {"timings", "paths_per_s", "photosite_version", "fingerprint", "sums"}


def captures():
    folders = [ROOT / "scenes", ROOT / "tests/mitsuba/scenes"]
    return sorted(file for folder in folders for file in folder.glob("*/*.toml") if is_capture(file))


def is_capture(file):
    return any(line.split("#")[0].strip() in ("[scene]", "[camera]") for line in file.read_text().splitlines())


def name_and_version(program):
    """What a program writes into files as the software that made them: "photosite 0.2.0"."""
    return subprocess.run([program, "--version"], capture_output=True, check=True).stdout.strip()


def render(program, capture, folder, samples):
    command = [program, "render", capture, "-o", folder, "--quiet"]
    if samples:
        command += ["--set", f"render.samples_per_pixel={samples}"]
    run = subprocess.run(command, capture_output=True, text=True)
    return run.returncode, run.stderr.strip()


def differences(old, new, path=""):
    """The paths at which two JSON values differ."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            if key not in PASSING:
                yield from differences(old.get(key), new.get(key), f"{path}.{key}".lstrip("."))
    elif old != new:
        yield path


def compare(old, new, captures, samples):
    names = [name_and_version(program) for program in (old, new)]
    if len(names[0]) != len(names[1]):
        sys.exit(f"{names[0].decode()} and {names[1].decode()} differ in length, and so does all that files hold after them")
    failures = 0
    for capture in captures:
        title = capture.relative_to(ROOT)
        with tempfile.TemporaryDirectory() as scratch:
            folders = [Path(scratch) / which for which in ("old", "new")]
            ends = [render(program, capture, folder, samples) for program, folder in zip((old, new), folders)]
            if any(status for status, _ in ends):
                same = ends[0][0] == ends[1][0]
                print(f"{title}: ends with {ends[0][0]} and {ends[1][0]}: {ends[1][1]}")
                failures += not same
                continue
            different = []
            for file in FILES:
                paths = [folder / file for folder in folders]
                contents = [
                    path.read_bytes().replace(name, names[0]) if path.exists() else None for path, name in zip(paths, names)
                ]
                # A file that neither makes, because the capture asks for others, is no difference.
                if contents[0] != contents[1]:
                    different.append(file)
            reports = [json.loads((folder / "capture.json").read_text()) for folder in folders]
            reworded = list(differences(*reports))
        print(f"{title}: " + (f"DIFFERENT: {', '.join(different)}" if different else "the same"), flush=True)
        if reworded:
            print(f"    capture.json differs at {', '.join(reworded)}")
        failures += bool(different)
    return failures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--samples", type=int, help="samples per pixel, instead of what each capture says")
    parser.add_argument("--only", nargs="+", default=[""], help="captures whose path holds one of these words")
    arguments = parser.parse_args()
    chosen = [file for file in captures() if any(word in str(file) for word in arguments.only)]
    failures = compare(arguments.old.resolve(), arguments.new.resolve(), chosen, arguments.samples)
    print(f"{failures} of {len(chosen)} captures differ" if failures else f"All {len(chosen)} captures: the same bytes.")
    return failures > 0


if __name__ == "__main__":
    sys.exit(main())
