"""strace watches photosite write: what has its name is on the disk.

A power cut may come at any time. So each file must be synced before it is renamed to its name, and the folder of the name
after that; and a folder that is renamed must be synced before, with all that is in it.

    durability.py PHOTOSITE
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

CAPTURE = """
[scene]
environment = { illuminant = "D65", illuminance_lux = 500 }
[[targets]]
type = "chessboard"
name = "board"
[sensor]
resolution_px = [48, 32]
[exposure]
time_s = 0.01
[render]
samples_per_pixel = 2
[output]
irradiance = true
checkpoint_interval_s = 0.001
"""
COMMANDS = {
    "render": ["render", "capture.toml", "-o", "out"],
    "expose": ["expose", "out", "-o", "exposed"],
    "develop": ["develop", "out/raw.dng", "-o", "picture.tiff"],
    "dataset": ["dataset", "set.toml", "-o", "set"],
    "layout": ["layout", "set", "--format", "colmap", "-o", "laid"],
    "emva1288": ["emva1288", "sony-imx249-mono", "--size", "8x8", "--steps", "5", "--spatial", "3", "-o", "sets"],
    "export-mitsuba": ["export-mitsuba", "capture.toml", "--approximate", "-o", "mitsuba"],
}
# Shown while a render runs, and nothing afterwards.
FLEETING = {"preview.png"}


def judge(program, name, arguments, folder):
    log = folder / "strace.log"
    calls = "fsync,fdatasync,rename,renameat,renameat2"
    subprocess.run(["strace", "-f", "-y", "-s", "4096", "-e", f"trace={calls}", "-o", log, program, *arguments, "--quiet"],
                   cwd=folder, check=True)
    synced, renamed, missing = {}, [], []
    for number, line in enumerate(log.read_text().splitlines()):
        if match := re.search(r"\b(?:fsync|fdatasync)\(\d+<(.*?)>", line):
            synced.setdefault(match[1], []).append(number)
        elif match := re.search(r"\brename(?:at|at2)?\((?:AT_FDCWD\S*, )?\"(.*?)\", (?:AT_FDCWD\S*, )?\"(.*?)\"", line):
            if " = 0" in line:
                source, target = [str((folder / path).resolve()) for path in match.groups()]
                renamed.append((number, source, target))
    for number, source, target in renamed:
        # A folder that makes way for a new one is none of ours.
        if Path(target).name in FLEETING or ".partial" in target:
            continue
        before = [at for at in synced.get(source, []) if at < number]
        after = [at for at in synced.get(str(Path(target).parent), []) if at > number]
        if not before or not after:
            missing.append(f"{target}: synced before: {bool(before)}, its folder after: {bool(after)}")
        if Path(target).is_dir():
            for path in Path(target).rglob("*"):
                was = source + str(path)[len(target):]
                if not any(at < number for at in synced.get(was, [])):
                    missing.append(f"{path} was not synced before its folder was renamed")
    names = {target for _, _, target in renamed if ".partial" not in target}
    print(f"{name}: {len(names)} names, {sum(map(len, synced.values()))} syncs, {len(missing)} missing")
    assert names, "nothing was renamed"
    for message in missing[:5]:
        print("  " + message)
    return not missing


def main(program):
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder).resolve()
        (folder / "capture.toml").write_text(CAPTURE)
        (folder / "set.toml").write_text("capture = 'capture.toml'\nframes = 2\n")
        outcomes = [judge(str(Path(program).resolve()), name, arguments, folder) for name, arguments in COMMANDS.items()]
    sys.exit(not all(outcomes))


main(sys.argv[1])
