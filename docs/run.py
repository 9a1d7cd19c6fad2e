#!/usr/bin/env python3
"""Runs what the pages of the book show, page by page, each in an empty folder.

    docs/run.py                            all pages
    docs/run.py tutorials/first-picture    the named ones
    docs/run.py --keep DIR …               leaves the folders of the pages in DIR
    docs/run.py --figures …                and takes over the images that the pages show
    docs/run.py --list                     prints the names of the pages

The program is the `photosite` on the PATH; Python blocks, and `python` in commands, run in the Python that runs this script, which needs
docs/requirements-run.txt and, for pages that import it, the package photosite.

What the kinds of fenced blocks mean:

    ```sh                     commands, run one after the other; the first that fails fails the page
    ```python                 Python, in one session for the whole page
    ```toml title="a.toml"    a file, written before what follows runs (any language, any name)
    ```toml                   a part of a capture, data set or sensor file: checked against the schemas
    ```console                commands that are only shown: photosite must have their options
    ```py                     Python that is only shown: it must be Python
    ```text                   what the block before printed: its lines, in order

In ```text an ellipsis … stands for anything, a line of … for any number of lines. A number agrees with the printed one where both are
the same but for one unit of the last digit that the page has. A figure in bold, **12.3 px**, stands for itself: some
number that was printed on the page must agree with it. The image ![…](images/a.jpg "out/image.png") is the one that
its page makes at out/image.png: both are compared.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
import traceback
from dataclasses import dataclass
from pathlib import Path

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
PAGES = [*sorted((DOCS / "tutorials").glob("*.md")), *sorted((DOCS / "guides").glob("*.md")), *sorted((DOCS / "reference").glob("*.md")), DOCS / "index.md", ROOT / "README.md"]
FENCE = re.compile(r"^( *)```(\w+)?(?: title=\"([^\"]+)\")?\n(.*?)^\1```$", re.DOTALL | re.MULTILINE)
NUMBER = re.compile(r"(?<![\w.])[-+−]?\d+(?:\.\d+)?")
BOLD = re.compile(r"\*\*([-+−]?\d+(?: \d{3})*(?:\.\d+)?)(?![\d.])[^*]*\*\*")
PICTURE = re.compile(r'!\[[^\]]*\]\((images/[^ )]+) "([^"]+)"\)')
# Mean difference of 8-bit codes between a figure and the image that its page makes, past which they are not the same. The
# same image may differ in the last digit on another processor; other noise differs by more.
SAME_PICTURE = 0.5
HOW_TO_SAVE = {".jpg": {"quality": 92, "subsampling": 0, "optimize": True}, ".png": {"optimize": True}}


class Wrong(Exception):
    """What a page says is not what happens."""


@dataclass
class Block:
    language: str
    title: str
    text: str
    line: int


def blocks(page: str) -> "list[Block]":
    found = []
    for match in FENCE.finditer(page):
        indent, language, title, text = match.groups()
        text = re.sub(f"^{indent}", "", text, flags=re.MULTILINE)
        found.append(Block(language or "", title or "", text, page.count("\n", 0, match.start()) + 1))
    return found


def number(text: str) -> float:
    return float(text.replace("−", "-").replace(" ", ""))


def agrees(shown: str, printed: str) -> bool:
    """Whether two numbers are the same but for one unit of the last digit that is shown."""
    decimals = len(shown.partition(".")[2])
    return abs(number(shown) - number(printed)) <= 1.0001 * 10.0**-decimals if decimals or "." in printed else number(shown) == number(printed)


def lines_agree(shown: str, printed: str) -> bool:
    shown_words, printed_words = shown.split(), printed.split()
    pattern, numbers = "", []
    for word in shown_words:
        pattern += r"\s*" if not pattern else r"\s+"
        rest = word
        while rest:
            found = NUMBER.search(rest)
            if not found:
                pattern += re.escape(rest).replace("…", ".*")
                break
            pattern += re.escape(rest[: found.start()]).replace("…", ".*") + r"([-+−]?\d+(?:\.\d+)?)"
            numbers.append(found[0])
            rest = rest[found.end():]
    match = re.fullmatch(pattern + r"\s*", " ".join(printed_words))
    return bool(match) and all(agrees(a, b) for a, b in zip(numbers, match.groups()))


def compare(shown: str, printed: str) -> None:
    """Fails where lines that a page shows were not printed in this order."""
    lines = [line for line in printed.splitlines() if line.strip()]
    at, may_skip = 0, False
    for line in shown.splitlines():
        if not line.strip():
            continue
        if line.strip() == "…":
            may_skip = True
            continue
        candidates = range(at, len(lines)) if may_skip else range(at, min(at + 1, len(lines)))
        found = next((i for i in candidates if lines_agree(line, lines[i])), None)
        if found is None:
            near = "\n".join(lines[at:at + 6])
            raise Wrong(f"the page shows\n    {line}\nbut what was printed goes on\n{near}")
        at, may_skip = found + 1, False
    if at < len(lines) and not may_skip:
        raise Wrong(f"the page leaves out what was printed in the end:\n{lines[at]}")


def schemas() -> "dict[str, dict]":
    return {kind: json.loads((ROOT / f"assets/{kind}.schema.json").read_text()) for kind in ("capture", "dataset", "sensor")}


def check_part(text: str) -> None:
    """Fails where a part of a file is none of a capture, a data set or a sensor file."""
    import jsonschema

    given = tomllib.loads(text)
    complaints = []
    for kind, schema in schemas().items():
        # A part need not have what the whole must have.
        schema = {**schema, "required": []}
        error = next(jsonschema.Draft202012Validator(schema).iter_errors(given), None)
        if error is None:
            return
        complaints.append(f"as {kind}: {error.message[:200]}")
    raise Wrong("the part of a file does not fit its schema\n" + "\n".join(complaints))


def check_shown(text: str) -> None:
    """Fails where a command that is only shown has an option which the program does not have."""
    for line in text.replace("\\\n", " ").splitlines():
        command = line.removeprefix("$ ").split("#")[0].split()
        if not command or command[0] != "photosite":
            continue
        names = []
        for word in command[1:]:
            asked = subprocess.run(["photosite", *names, word, "--help"], capture_output=True, text=True)
            if not re.fullmatch("[a-z0-9-]+", word) or asked.returncode or "Usage: photosite " + " ".join([*names, word]) not in asked.stdout:
                break
            names.append(word)
        told = subprocess.run(["photosite", *names, "--help"], capture_output=True, text=True, check=True).stdout
        for option in re.findall(r"(?<=\s)--?[a-z][a-z0-9-]*", line):
            if not re.search(rf"(?<![\w-]){option}(?![\w-])", told):
                raise Wrong(f"`photosite {' '.join(names)}` has no {option}")


class Run:
    """One page."""

    def __init__(self, page: Path, folder: Path):
        self.page, self.folder = page, folder
        self.session: dict = {"__name__": "__main__"}
        self.printed = ""
        self.all_printed = ""
        self.functions = folder / ".functions"
        self.functions.write_text("")

    def block(self, block: Block) -> None:
        if block.title:
            path = self.folder / block.title
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
        if block.language == "sh":
            self.shell(block.text)
        elif block.language == "python":
            self.python(block)
        elif block.language == "toml" and not block.title:
            check_part(block.text)
        elif block.language == "console":
            check_shown(block.text)
        elif block.language == "py":
            compile(block.text, str(self.page), "exec")
        elif block.language == "text":
            compare(block.text, self.printed)

    def shell(self, block_text: str) -> None:
        # Functions stay from block to block.
        functions = shlex.quote(str(self.functions))
        python = f'python() {{ {shlex.quote(sys.executable)} "$@"; }}'
        text = f"{python}; source {functions}; trap 'declare -f >{functions}' EXIT\n{block_text}"
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", text], cwd=self.folder, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True)
        self.took(done.stdout)
        if done.returncode:
            raise Wrong(f"exit status {done.returncode} of\n{block_text}\n{done.stdout[-2000:]}")

    def python(self, block: Block) -> None:
        printed, before = io.StringIO(), os.getcwd()
        os.chdir(self.folder)
        try:
            with contextlib.redirect_stdout(printed):
                # With the page's lines, so that a traceback names them.
                exec(compile("\n" * block.line + block.text, str(self.page), "exec"), self.session)
        except Exception:
            raise Wrong(traceback.format_exc(limit=-2)) from None
        finally:
            os.chdir(before)
            self.took(printed.getvalue())

    def took(self, printed: str) -> None:
        self.printed = printed
        self.all_printed += printed

    def prose(self, text: str) -> None:
        """Figures in bold."""
        printed = [found[0] for found in NUMBER.finditer(self.all_printed)]
        for bold in BOLD.finditer(text):
            if not any(agrees(bold[1], candidate) for candidate in printed):
                raise Wrong(f"no command has printed {bold[0]}")


def run(page: Path, folder: Path) -> "str | None":
    """What is wrong with a page, or nothing."""
    text = page.read_text(encoding="utf-8")
    found = blocks(text)
    (folder / "scenes").symlink_to(ROOT / "scenes")
    state = Run(page, folder)
    for block in found:
        try:
            state.block(block)
        except Wrong as wrong:
            return f"{page.relative_to(ROOT)}:{block.line}: {wrong}"
    # Prose may speak of what the page shows further down.
    try:
        state.prose(FENCE.sub("", text))
    except Wrong as wrong:
        return f"{page.relative_to(ROOT)}: {wrong}"
    return None


def figures(page: Path, folder: Path, take_over: bool) -> "str | None":
    """Compares the images that a page shows with those that its run has made, or takes these over."""
    from PIL import Image, ImageChops, ImageStat

    for shown, made in PICTURE.findall(page.read_text(encoding="utf-8")):
        if not (folder / made).exists():
            return f"{page.relative_to(ROOT)}: no command has made {made}, which {shown} shows"
        kept = page.parent / shown
        # As it is when it was saved as the figure.
        saved = folder / f"figure{kept.suffix}"
        Image.open(folder / made).convert("RGB").save(saved, **HOW_TO_SAVE[kept.suffix])
        picture = Image.open(saved).convert("RGB")
        if take_over:
            kept.parent.mkdir(exist_ok=True)
            shutil.copyfile(saved, kept)
        elif not kept.exists():
            return f"{page.relative_to(ROOT)}: {shown} is missing: docs/run.py --figures makes it"
        else:
            figure = Image.open(kept).convert("RGB")
            if figure.size != picture.size:
                return f"{kept.relative_to(ROOT)} is of {figure.size} pixels, {made} of {picture.size}"
            differences = ImageStat.Stat(ImageChops.difference(figure, picture)).mean
            if max(differences) > SAME_PICTURE:
                return f"{kept.relative_to(ROOT)} is not what its page makes now, {made}: mean difference {max(differences):.1f}"
    return None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="*", metavar="PAGE", help="a page's path in docs, without .md")
    parser.add_argument("--without", nargs="+", default=[], metavar="PAGE", help="all but these")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="leave the folders of the pages there")
    parser.add_argument("--figures", action="store_true", help="take over the figures that the pages have made")
    parser.add_argument("--list", action="store_true", help="print the names of the pages")
    options = parser.parse_args()
    names = {str(page.relative_to(DOCS if DOCS in page.parents else ROOT).with_suffix("")): page for page in PAGES}
    for name in [*options.pages, *options.without]:
        if name not in names:
            parser.error(f"there is no page {name!r}; there are {', '.join(names)}")
    if options.list:
        print("\n".join(names))
        return 0
    os.environ.setdefault("MPLBACKEND", "Agg")
    failed = 0
    for name in options.pages or [name for name in names if name not in options.without]:
        begun = time.monotonic()
        if options.keep:
            folder = options.keep / name
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
        else:
            folder = Path(tempfile.mkdtemp())
        wrong = run(names[name], folder)
        wrong = wrong or figures(names[name], folder, options.figures)
        if not options.keep:
            shutil.rmtree(folder)
        print(f"{name}: {'failed' if wrong else 'passed'} in {time.monotonic() - begun:.1f} s", flush=True)
        if wrong:
            print("  " + wrong.replace("\n", "\n  "), flush=True)
        failed += bool(wrong)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
