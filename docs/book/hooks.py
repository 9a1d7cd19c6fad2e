"""What the build of the book does beside MkDocs: pages that are generated, links into the repository, equations.

MkDocs calls these functions: <https://www.mkdocs.org/dev-guide/plugins/#events>.
"""

from __future__ import annotations

import logging
import posixpath
import re
import sys
from pathlib import Path

import latex2mathml.converter
from mkdocs.structure.files import File

BOOK = Path(__file__).resolve().parent
ROOT = BOOK.parents[1]
sys.path.insert(0, str(BOOK))
import command_pages  # noqa: E402
from key_examples import Examples  # noqa: E402
import python_page  # noqa: E402
import schema_pages  # noqa: E402

log = logging.getLogger("mkdocs.hooks")

SCHEMAS = {
    "capture": ("Capture file: all keys", "capture", "A capture file says what is in front of the camera, and what camera it is. "
                "[The capture file](../guides/capture-file.md) shows one with comments."),
    "data-set": ("Data set file: all keys", "dataset", "A data set file names a capture and says what differs from frame to frame. "
                 "[Data sets](../guides/data-sets.md) shows how."),
    "sensor": ("Sensor file: all keys", "sensor", "A sensor file describes a sensor by the parameters of EMVA 1288. The same keys follow "
               "`preset` in `[sensor]` of a capture. [Sensors](../guides/sensors.md) shows how."),
    "noise": ("Noise to add: all keys", "noise", "What `photosite noise add` takes after `--set`."),
    "report": ("capture.json: all keys", "report", "What `capture.json` holds, which each render leaves beside its images: all that is "
               "needed to use them and to make them again."),
}


def on_files(files, config):
    """Adds the pages that are made of schemas, of --help, of docstrings, and of CONTRIBUTING.md."""
    pages = {"reference/commands.md": command_pages.page(), "reference/python.md": python_page.page()}
    examples = Examples()
    for name, (title, kind, beginning) in SCHEMAS.items():
        schema = (ROOT / f"assets/{kind}.schema.json").read_text(encoding="utf-8")
        pages[f"reference/{name}.md"] = schema_pages.page(title, beginning, kind, schema, None if kind == "report" else examples)
    pages["contributing.md"] = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for path, content in pages.items():
        files.append(File.generated(config, path, content=content))
    return files


LINK = re.compile(r"(?<!!)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^()\s#]+)(#[^()\s]*)?\)")


def on_page_markdown(markdown, page, config, files):
    """Turns links to files of the repository outside the book into their paths, and warns of those that are not there."""
    folder = posixpath.dirname(page.file.src_uri)

    def replaced(link):
        text, target = link[1], link[2]
        if re.match(r"[a-z]+:", target):
            return link[0]
        path = posixpath.normpath(posixpath.join("docs", folder, target))
        if path.startswith("docs/") and files.get_file_from_path(path[len("docs/"):]):
            return link[0]
        if page.file.src_uri == "contributing.md":
            path = posixpath.normpath(target)
        if not (ROOT / path).exists():
            log.warning("%s links to %s, which is not in the repository", page.file.src_uri, target)
        return f"`{path}`" if text.strip("`") in path or text == target else f"{text} (`{path}`)"

    return LINK.sub(replaced, markdown)


EQUATION = re.compile(r'<(span|div) class="arithmatex">(\\[(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_page_content(html, page, config, files):
    """Equations become MathML, which browsers draw by themselves."""

    def drawn(equation):
        text = equation[3].replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
        return latex2mathml.converter.convert(text.strip(), display="block" if equation[2] == r"\[" else "inline")

    return EQUATION.sub(drawn, html)
