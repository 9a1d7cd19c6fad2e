"""Examples of keys for the reference, taken from files and commands of the repository that CI runs or checks."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Where captures, data sets and sensors lie, those first that a reader is most likely to open.
FILES = ["scenes/*/capture*.toml", "scenes/**/*.toml", "docs/theory/textbook/*.toml", "crates/*/assets/sensors/*.toml",
         "tests/**/*.toml"]
PAGES = ["docs/guides/*.md", "docs/tutorials/*.md", "README.md", "docs/reference/examples.md"]
FENCE = re.compile(r"^ *```(\w+)[^\n]*\n(.*?)^ *```$", re.DOTALL | re.MULTILINE)
# Longer values are no examples for a column of a table.
LONGEST = 48
# Tables whose keys are names that the user gives.
NAMED = {"materials", "channels", "keypoints"}


def toml_value(value: object) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    return json.dumps(value, ensure_ascii=False, default=str)


def fits(text: str, what: str) -> bool:
    """Whether a value is of the type that the reference states: "list of 3 × number", "text or true or false" …"""
    if text.startswith("["):
        count = re.search(r"list of (\d+) ×", what)
        return "list" in what and (not count or len(tomllib.loads(f"value = {text}")["value"]) == int(count[1]))
    if text.startswith("{"):
        return "table" in what
    if text.startswith('"'):
        return "text" in what or "name" in what or text in what
    return "true or false" in what if text in ("true", "false") else "number" in what


def kind_of(file: dict) -> str:
    if "capture" in file:
        return "dataset"
    return "sensor" if {"adc", "cfa", "pixel_pitch_um"} & set(file) else "capture"


class Examples:
    """Short values of keys, by the kind of their file: the first at each path, and all of each name."""

    def __init__(self) -> None:
        self.of_path: "dict[tuple[str, str], str]" = {}
        self.of_name: "dict[tuple[str, str], list[str]]" = {}
        # Pages first: they show what is usual.
        for pattern in PAGES:
            for page in sorted(ROOT.glob(pattern)):
                for language, text in FENCE.findall(page.read_text(encoding="utf-8")):
                    if language == "toml":
                        self.file(text)
                    elif language in ("sh", "console"):
                        self.commands(text)
        for pattern in FILES:
            for path in sorted(ROOT.glob(pattern)):
                self.file(path.read_text(encoding="utf-8"))

    def file(self, text: str) -> None:
        try:
            file = tomllib.loads(text)
        except tomllib.TOMLDecodeError:  # a test of what is refused
            return
        self.table(kind_of(file), "", file)

    def table(self, kind: str, path: str, table: dict) -> None:
        for key, value in table.items():
            at = f"{path}.{key}" if path else key
            if path.split(".")[-1] in NAMED:
                at = f"{path}.NAME"
            self.value(kind, at, value)
            for part in value if isinstance(value, list) else [value]:
                if isinstance(part, dict):
                    self.table(kind, at, part)
                elif kind == "dataset" and key == "set":
                    self.change(part)

    def value(self, kind: str, path: str, value: object) -> None:
        text = toml_value(value)
        if len(text) <= LONGEST and value not in ({}, []):
            self.of_path.setdefault((kind, path), text)
            self.of_name.setdefault((kind, path.split(".")[-1]), []).append(text)
        if kind == "capture" and path.startswith("sensor."):
            self.value("sensor", path.removeprefix("sensor."), value)

    def commands(self, text: str) -> None:
        words = shlex.split(text.replace("\\\n", " "), comments=True)
        kind = "noise" if "noise" in words and "add" in words else "capture"
        for option, change in zip(words, words[1:]):
            if option == "--set":
                self.change(change, kind)

    def change(self, change: str, kind: str = "capture") -> None:
        key, _, value = change.partition("=")
        try:
            value = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:  # a word without quotes
            pass
        self.value(kind, key.strip(), value)

    def find(self, kind: str, path: str, what: str) -> str:
        """An example of a key of a type: at this place, or else of the key of this name at another one."""
        if kind == "capture" and path.startswith("sensor."):
            found = self.find("sensor", path.removeprefix("sensor."), what)
            if found:
                return found
        namesakes = (text for text in self.of_name.get((kind, path.split(".")[-1]), []) if fits(text, what))
        return self.of_path.get((kind, path)) or next(namesakes, "")
