#!/usr/bin/env python3
"""Runs the notebooks of this folder as a reader would, from the first cell to the last.

    run.py                          all of them
    run.py first-picture …          the named ones
    run.py --without train-a-denoiser …   all but the named ones
    run.py --write                  and keeps what they print and draw in their files

A notebook fails where a cell raises an exception, or where one prints to standard error, as warnings do. Progress does too,
and is let through; it is not a part of what --write keeps, since its times differ from run to run. What --write keeps is small:
images have at most 100 KB, for which those with much noise become JPEG files, and all notebooks 1.5 MB.
"""

from __future__ import annotations

import argparse
import base64
import io
import re
import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from PIL import Image

FOLDER = Path(__file__).resolve().parent
# The longest takes two and a half minutes on two cores; a slow build or machine may take more.
CELL_TIMEOUT_S = 1_200
# The package's own line, and the bar of tqdm where that is installed.
PROGRESS = re.compile(r"\w+ +\d+%  [\d.]+ s|\w+: +(\d+%\||[\d.]+\w? \w+ \[).*")
PICTURE_BYTES = 100_000
FOLDER_BYTES = 1_500_000


def execute(path: Path) -> nbformat.NotebookNode:
    """The notebook with what its cells print and draw."""
    notebook = nbformat.read(path, as_version=4)
    metadata = dict(notebook.metadata)
    client = NotebookClient(
        notebook,
        timeout=CELL_TIMEOUT_S,
        kernel_name="python3",
        resources={"metadata": {"path": str(FOLDER)}},
        coalesce_streams=True,
        record_timing=False,
        # Without its advice on sockets.
        extra_arguments=["--log-level=ERROR"],
    )
    client.execute()
    # The kernel has told which Python it is.
    notebook.metadata = nbformat.from_dict(metadata)
    return notebook


def complaints(notebook: nbformat.NotebookNode) -> list[str]:
    """What cells have printed to standard error besides progress, which goes from their outputs."""
    found = []
    for cell in notebook.cells:
        kept = []
        for output in cell.get("outputs", []):
            if output.get("name") != "stderr":
                kept.append(output)
                continue
            lines = [line.strip() for line in re.split(r"[\r\n]+", output.text)]
            found += [line for line in lines if line and not PROGRESS.fullmatch(line)]
        if "outputs" in cell:
            cell.outputs = kept
    return found


def shrink_pictures(notebook: nbformat.NotebookNode) -> list[str]:
    """Stores images that are too large as JPEG; returns which are too large even so."""
    found = []
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    for output in outputs:
        data = output.get("data", {})
        if "image/png" not in data or len(base64.b64decode(data["image/png"])) <= PICTURE_BYTES:
            continue
        picture = Image.open(io.BytesIO(base64.b64decode(data.pop("image/png")))).convert("RGB")
        jpeg = io.BytesIO()
        picture.save(jpeg, "JPEG", quality=85, subsampling=0, optimize=True)
        data["image/jpeg"] = base64.b64encode(jpeg.getvalue()).decode("ascii")
        if jpeg.tell() > PICTURE_BYTES:
            found.append(f"an image of {picture.width} × {picture.height} pixels takes {jpeg.tell():,} bytes")
    return found


def run(path: Path, write: bool) -> list[str]:
    """What is wrong with a notebook, one line or more for each fault."""
    try:
        notebook = execute(path)
    except CellExecutionError as error:
        return [re.sub(r"\x1b\[[\d;]*m", "", str(error))]
    wrong = complaints(notebook) + shrink_pictures(notebook)
    if write and not wrong:
        nbformat.validate(notebook)
        path.write_text(nbformat.writes(notebook, indent=1) + "\n", encoding="utf-8")
    return wrong


def main() -> int:
    parser = argparse.ArgumentParser(description="Run the notebooks of this folder.")
    names = sorted(path.stem for path in FOLDER.glob("*.ipynb"))
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(names)} (default: all)")
    parser.add_argument("--without", nargs="+", default=[], metavar="NAME", help="all but these")
    parser.add_argument("--write", action="store_true", help="keep what they print and draw in their files")
    options = parser.parse_args()
    for name in options.names + options.without:
        if name not in names:
            parser.error(f"there is no notebook {name!r}; there are {', '.join(names)}")
    chosen = [name for name in options.names or names if name not in options.without]
    failed = 0
    for name in chosen:
        begun = time.monotonic()
        wrong = run(FOLDER / f"{name}.ipynb", options.write)
        print(f"{name}: {'failed' if wrong else 'passed'} in {time.monotonic() - begun:.1f} s", flush=True)
        for line in wrong:
            print(f"  {line}", flush=True)
        failed += bool(wrong)
    size = sum(path.stat().st_size for path in FOLDER.glob("*.ipynb"))
    if size > FOLDER_BYTES:
        print(f"the notebooks take {size:,} bytes, more than {FOLDER_BYTES:,}")
        failed += 1
    print(f"{len(chosen) - min(failed, len(chosen))} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
