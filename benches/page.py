#!/usr/bin/env python3
"""Measures again what docs/benchmarks shows, and writes the tables into the page.

    python3 benches/page.py                    # everything, two hours and a half
    python3 benches/page.py embree             # one section: mitsuba, rivals, noise, lens, embree, scale, frames, objects or view

What follows the section's name goes to its program: `page.py mitsuba a --runs 9`. Nothing else should run meanwhile.
"""

import datetime
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "benchmarks" / "README.md"
COMMANDS = {
    "mitsuba": ["python3", "benches/compare.py"],
    "rivals": ["python3", "benches/rivals.py"],
    "noise": ["python3", "benches/noise_target.py"],
    "lens": ["python3", "benches/prescription.py"],
    "embree": ["cargo", "bench", "--quiet", "--bench", "embree"],
    "scale": ["cargo", "bench", "--quiet", "--bench", "scale"],
    "objects": ["python3", "benches/moving_objects.py", "target/release/photosite"],
    "view": ["node", "benches/view.mjs", "target/release/photosite"],
    "frames": ["python3", "benches/many_frames.py", "target/release/photosite"],
}


def machine():
    """The processor's name and the number of cores."""
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    name = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "unknown processor")
    return f"{name}, {os.cpu_count()} cores"


def measure(section, more):
    """Runs a section's program and replaces what the page has between its marks."""
    command = COMMANDS[section] + (["--", *more] if more and section == "scale" else more)
    load = os.getloadavg()[0]
    # Incremental builds trace up to 15 % fewer rays a second than those of users.
    environment = dict(os.environ, CARGO_INCREMENTAL="0")
    # A bench whose goals are not reached fails, and says so in its tables.
    done = subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True, check=False)
    if "|" not in done.stdout:
        sys.exit(f"{' '.join(command)} gave no table")
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    head = f"`{' '.join(command)}`, {datetime.date.today()}, {machine()}, commit {commit.stdout.strip()}; "
    head += f"{load:.1f} other programs were running on average" if load > 0.2 else "nothing else was running"
    begin, end = f"<!-- {section} -->", f"<!-- end of {section} -->"
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(begin)
    _, after = rest.split(end)
    PAGE.write_text(f"{before}{begin}\n\n{head}\n\n{done.stdout.strip()}\n\n{end}{after}", encoding="utf-8")
    print(done.stdout)


def main():
    if len(sys.argv) > 1 and sys.argv[1] not in COMMANDS:
        sys.exit(f"there is no section {sys.argv[1]}: {', '.join(COMMANDS)}")
    for section in sys.argv[1:2] or COMMANDS:
        measure(section, sys.argv[2:])


if __name__ == "__main__":
    main()
