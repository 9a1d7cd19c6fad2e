"""Judges the JSON Schemas of captures, data sets and sensors by jsonschema: every file of this repository fits, wrong ones
do not.

Usage: schemas.py [SCHEMA_FOLDER]
"""

import copy
import json
import subprocess
import sys
import tomllib
from pathlib import Path

from jsonschema import Draft202012Validator

ROOT = Path(__file__).resolve().parent.parent.parent
# Of each kind at least so many are in the repository.
LEAST = {"capture": 30, "dataset": 2, "sensor": 10}
# Where to change a good file, and what to write there: each makes it a wrong one.
WRONG = {
    "capture": [
        (["lense"], {}),
        (["lens", "focal_length"], 8),
        (["camera", "position_m"], [0, 1]),
        (["camera", "position_m"], "here"),
        (["render", "samples_per_pixel"], -1),
        (["render", "samples_per_pixel"], 1.5),
        (["render", "samples_per_pixel"], 0),
        (["lens", "f_number"], 0),
        (["sensor", "fill_factor"], 1.5),
        (["develop", "jpeg_quality"], 101),
        (["output", "raw"], ["dgn"]),
        (["lights"], {"type": "point"}),
        (["lights"], [{"type": "point", "position_m": [0, 0, 0]}]),
        (["materials", "wall"], {"type": "diffuse"}),
        (["materials", "wall"], {"type": "velvet", "reflectance": 1}),
        (["targets"], [{"type": "chessboard", "squares": [9]}]),
        (["sensor", "noise", "read_noise"], 2),
    ],
    "dataset": [
        (["capture"], 3),
        (["captures"], "a.toml"),
        (["frames"], "many"),
        (["frames"], -1),
        (["frames"], 0),
        (["set"], "lens.f_number=4"),
        (["cameras"], [{"position_m": [0, 0, 0]}]),
        (["cameras"], [{"name": "left", "position": [0, 0, 0]}]),
        (["poses"], {"random": {"target": "board"}}),
        (["poses"], {"spiral": {}}),
        (["poses"], {"list": [{"position_m": [0, 0, 1]}]}),
        (["vary"], {"key": "exposure.gain_db", "uniform": [0, 1]}),
        (["vary"], [{"key": "exposure.gain_db", "uniform": [0]}]),
        (["vary"], [{"key": "exposure.gain_db", "normal": ["a", "b"]}]),
        (["vary"], [{"key": "exposure.gain_db", "uniformly": [0, 1]}]),
        (["vary"], [{"key": "exposure.gain_db", "choice": 3}]),
        (["vary"], [{"key": "exposure.gain_db", "per_camera": "yes"}]),
    ],
    "sensor": [
        (["resolution_px"], [640]),
        (["resolution_px"], ["a", "b"]),
        (["resolution"], [640, 480]),
        (["kind"], "film"),
        (["adc", "bits"], -1),
        (["adc", "bits"], 17),
        (["adc", "bit"], 12),
        (["noise", "read_noise"], 2),
        (["noise", "read_noise_e"], "little"),
        (["channels"], 3),
    ],
}


def as_json(value):
    """TOML has dates, which JSON writes as text."""
    if isinstance(value, dict):
        return {key: as_json(item) for key, item in value.items()}
    if isinstance(value, list):
        return [as_json(item) for item in value]
    return value if isinstance(value, (str, bool, int, float)) else value.isoformat()


def kind_of(file):
    """What a TOML file is by its keys, None where it is none of photosite's."""
    if "capture" in file:
        return "dataset"
    if "adc" in file:
        return "sensor"
    return "capture" if any(table in file for table in ("scene", "camera", "lens", "sensor")) else None


def changed(file, path, value):
    file = copy.deepcopy(file)
    table = file
    for key in path[:-1]:
        table = table.setdefault(key, {})
    table[path[-1]] = value
    return file


def without(file, key):
    return {name: value for name, value in file.items() if name != key}


schemas = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "assets"
validators = {}
for kind in ("capture", "dataset", "sensor", "report", "noise"):
    schema = json.loads((schemas / f"{kind}.schema.json").read_text())
    Draft202012Validator.check_schema(schema)
    validators[kind] = Draft202012Validator(schema)

names = subprocess.run(["git", "ls-files", "*.toml"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
good = {kind: [] for kind in LEAST}
for name in filter(None, names):
    file = as_json(tomllib.loads((ROOT / name).read_text()))
    kind = kind_of(file)
    if kind is None:
        continue
    for error in validators[kind].iter_errors(file):
        sys.exit(f"{name}: {error.json_path}: {error.message}")
    good[kind].append(file)
for kind, files in good.items():
    assert len(files) >= LEAST[kind], f"{len(files)} files of the kind {kind}"
    # No file of one kind is taken for one of another.
    for other in LEAST.keys() - {kind}:
        assert not any(validators[other].is_valid(file) for file in files), f"a {kind} fits the schema of a {other}"

refused = 0
for kind, cases in WRONG.items():
    # The first file of each kind is as good as any other, and every change to it is the only thing wrong with it.
    file = good[kind][0]
    for path, value in cases:
        assert not validators[kind].is_valid(changed(file, path, value)), f"{kind}: {'.'.join(path)} = {value!r} is taken"
        refused += 1
for kind, key in (("dataset", "capture"), ("sensor", "adc")):
    assert not validators[kind].is_valid(without(good[kind][0], key)), f"{kind} without {key}"
    refused += 1

counts = ", ".join(f"{len(files)} of the kind {kind}" for kind, files in good.items())
print(f"{counts} fit their schemas; {refused} wrong files do not")
