"""Compiled dependencies of the crates, kept from one clone to the next in the cache of the gate.

What cargo has compiled of other people's crates depends on Cargo.lock, the profiles and rustc, all of which are in its names
and fingerprints: what does not fit is compiled anew. Our own crates are not kept.
"""

import hashlib
import os
import shutil
import subprocess
from pathlib import Path

from choose import ROOT
from environments import CACHE

OURS = "photosite"


def target() -> Path:
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"


def kept() -> Path:
    """Folder of what fits this Cargo.lock, these profiles and this compiler."""
    rustc = subprocess.run(["rustc", "-vV"], cwd=ROOT, check=True, capture_output=True).stdout
    texts = [(ROOT / name).read_bytes() for name in ("Cargo.lock", "Cargo.toml")]
    return CACHE / f"dependencies-{hashlib.sha256(b''.join([rustc, *texts])).hexdigest()[:16]}"


def entries(folder: Path) -> "set[str]":
    """Names with hashes, such as serde-0a12b9f705426c1b, of what is whole in a folder."""
    fingerprints = folder / ".fingerprint"
    if not fingerprints.exists():
        return set()
    return {path.name for path in fingerprints.iterdir() if not path.name.startswith((OURS, "."))}


def copy(names: "set[str]", source: Path, to: Path) -> None:
    """Copies entries with their times, by which cargo knows them. The fingerprint is the last, and says that one is whole."""
    if not names:
        return
    hashes = {name.rpartition("-")[2] for name in names}
    (to / "deps").mkdir(parents=True, exist_ok=True)
    for path in (source / "deps").iterdir():
        if path.name.partition(".")[0].rpartition("-")[2] in hashes:
            shutil.copy2(path, to / "deps" / path.name)
    for part in ("build", ".fingerprint"):
        (to / part).mkdir(exist_ok=True)
        for name in names:
            if (source / part / name).exists():
                whole, made = to / part / name, to / part / f".{name}"
                shutil.rmtree(made, ignore_errors=True)
                shutil.copytree(source / part / name, made, symlinks=True)
                if not whole.exists():
                    made.rename(whole)


def copied(names: "set[str]", source: Path, to: Path) -> bool:
    """Whether entries could be copied: a full disk, or another gate beside this one, is no reason to fail, as cargo compiles
    what is not there."""
    try:
        copy(names, source, to)
    except OSError as error:
        print(f"warning: compiled dependencies are not all copied to {to}: {error}", flush=True)
        return False
    return True


def restore() -> None:
    """Fills the target folder of a clone that has none."""
    if not target().exists() and (names := entries(kept())) and copied(names, kept(), target()):
        print(f"{len(names)} units of dependencies are there already, from {kept()}", flush=True)


def keep() -> None:
    """Keeps what has been compiled, and removes what fits other versions."""
    new = kept()
    copied(entries(target()) - entries(new), target(), new)
    for old in CACHE.glob("dependencies-*"):
        if old != new:
            shutil.rmtree(old, ignore_errors=True)
