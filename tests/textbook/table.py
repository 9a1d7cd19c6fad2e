"""Rows of docs/theory/textbook.md: an equation, the capture or command that shows it, figures measured and expected."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import OpenEXR

ROOT = Path(__file__).resolve().parents[2]
#: Captures and images that the page shows.
FOLDER = ROOT / "docs/theory/textbook"


@dataclass
class Figure:
    """What is measured, beside what the equation or another program says."""

    what: str
    measured: float
    expected: float
    #: Largest difference, in the figure's unit: derived where it is given.
    tolerance: float
    #: Who says what is expected, where it is not the equation: "OpenCV", "NumPy", "exiftool" …
    by: str = ""

    def holds(self):
        return abs(self.measured - self.expected) <= self.tolerance


@dataclass
class Row:
    """A line of the textbook."""

    title: str
    #: In Unicode, as the lecture has it.
    equation: str
    #: The capture in docs/theory/textbook, or the command, that shows it.
    shown_by: str
    #: Takes a Tool, gives a list of Figures. May draw the image at `tool.picture(NAME)`.
    measure: callable
    #: Name of a PNG in docs/theory/textbook; none where there is nothing to look at.
    picture: str = ""


class Tool:
    """Runs photosite in a scratch folder."""

    def __init__(self, program, scratch, pictures):
        self.program, self.scratch, self.pictures = str(Path(program).resolve()), Path(scratch), Path(pictures)

    def run(self, *arguments):
        """Runs a command and gives what it prints."""
        done = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True, cwd=self.scratch)
        if done.returncode:
            raise RuntimeError(f"photosite {' '.join(map(str, arguments))}\n{done.stderr}")
        return done.stdout

    def json(self, *arguments):
        return json.loads(self.run(*arguments, "--json"))

    def capture(self, name):
        """A capture of docs/theory/textbook."""
        return FOLDER / name

    def render(self, name, output, *overrides):
        """Renders a capture of docs/theory/textbook with changes `key=value`; gives the folder of its results."""
        folder = self.scratch / output
        changes = [part for override in overrides for part in ("--set", override)]
        self.run("render", self.capture(name), "-o", folder, "--quiet", "--force", *changes)
        return folder

    def planes(self, path):
        """The planes of an EXR file by their names."""
        return {name: channel.pixels for name, channel in OpenEXR.File(str(path), separate_channels=True).channels().items()}

    def report(self, folder):
        """The capture.json of a folder."""
        return json.loads((Path(folder) / "capture.json").read_text())

    def picture(self, name):
        """Where an image of the page is written: in the page's folder with --write, else in the scratch folder."""
        return self.pictures / name
