"""Measures every row of docs/theory/textbook.md and holds it against what is expected.

Usage: run.py PHOTOSITE [--write] [FILE…]

FILE names files of rows (`lens`, `noise` …); left out: all. --write makes the page and its images anew; without it, the page
must have the same rows.
"""

import argparse
import importlib
import re
import sys
import tempfile
from pathlib import Path

from table import FOLDER, ROOT, Tool

PAGE = ROOT / "docs/theory/textbook.md"
#: Files of rows in the order of the page, with their headings.
FILES = {
    "lens": "Lenses",
    "figures": "Figures of a lens in front of a sensor",
    "sensor": "The sensor's geometry",
    "grabber": "From the sensor to numbers: bandwidth, sampling, quantisation",
    "noise": "Noise",
    "estimation": "Estimating noise",
    "filters": "Filters",
    "colour": "Colour",
    "stereo": "Two views",
    "tone": "High dynamic range",
    "files": "Files",
}
INTRODUCTION = """# The textbook, row by row

What lectures on image acquisition teach, beside what photosite shows: the equation, the capture or command that shows it, what
is measured there and what is expected. `tests/textbook/run.py` measures all of it again, in CI, too. Captures and images are in
[textbook/](textbook).
"""


def number(value):
    return f"{value:.6g}"


def lines(row, figures):
    """The lines of the table for a row, one a figure."""
    shown = f"[{row.shown_by}](textbook/{row.shown_by})" if (FOLDER / row.shown_by).is_file() else f"`{row.shown_by}`"
    picture = f"![{row.title}](textbook/{row.picture})" if row.picture else ""
    for i, figure in enumerate(figures):
        head = [row.title, row.equation, shown, picture] if i == 0 else [""] * 4
        by = f" ({figure.by})" if figure.by else ""
        cells = [*head, figure.what, number(figure.measured), f"{number(figure.expected)} ± {number(figure.tolerance)}{by}"]
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def without_figures(page):
    """The page without its figures, which may differ in their last digits from machine to machine."""
    cells = (re.split(r"(?<!\\)\|", line) for line in page.splitlines())
    return ["|".join(row[:6]) for row in cells]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("photosite")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("files", nargs="*", metavar="FILE")
    arguments = parser.parse_args()
    sys.path.insert(0, str(Path(__file__).parent))
    page, wrong = INTRODUCTION, 0
    for name in arguments.files or FILES:
        page += f"\n## {FILES[name]}\n\n"
        page += "| what | equation | shown by | image | figure | measured | expected |\n" + "|---" * 7 + "|\n"
        for row in importlib.import_module(f"rows.{name}").ROWS:
            with tempfile.TemporaryDirectory() as scratch:
                figures = row.measure(Tool(arguments.photosite, scratch, FOLDER if arguments.write else scratch))
            for figure in figures:
                wrong += not figure.holds()
                verdict = "holds" if figure.holds() else "DOES NOT HOLD"
                print(
                    f"{name}: {row.title}: {figure.what}: {number(figure.measured)}, expected {number(figure.expected)}"
                    f" ± {number(figure.tolerance)}: {verdict}",
                    flush=True,
                )
            page += "".join(line + "\n" for line in lines(row, figures))
    if wrong:
        sys.exit(f"{wrong} figures do not hold")
    if arguments.files:
        return
    if arguments.write:
        PAGE.write_text(page)
    elif without_figures(PAGE.read_text()) != without_figures(page):
        sys.exit("docs/theory/textbook.md has other rows: write it again with --write")


if __name__ == "__main__":
    main()
