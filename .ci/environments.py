#!/usr/bin/env python3
"""Python environments of the gate, made once of the locks in .ci/locks and kept in a cache.

    environments.py NAME            prints the interpreter of an environment, which is made where it is missing
    environments.py NAME --wheel    of one that has the wheel in $SCRATCH/wheels, too; it lasts as long as $SCRATCH
    environments.py --lock [NAME]   makes locks anew, all where none is named: what to do when requirements change
    environments.py --check         whether all locks are those of the requirements that there are

The cache is $PHOTOSITE_CI_CACHE, by default photosite-ci in $XDG_CACHE_HOME or ~/.cache. An environment's folder has the hash of its lock
in its name and is renamed to it when it is whole. Nothing else is kept in the cache but what uv and npm got: it may be deleted.
"""

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from choose import ROOT, Table

LOCKS = ROOT / ".ci/locks"
CACHE = Path(os.environ.get("PHOTOSITE_CI_CACHE") or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "photosite-ci")
PYTHON = "3.11"
# The usual index's PyTorch brings CUDA with it, 5 GB; here are builds without, whose hashes are others.
TORCH_INDEX = "https://download.pytorch.org/whl/cpu"


def run(*command: "str | Path") -> None:
    environment = {"UV_CACHE_DIR": str(CACHE / "uv"), "UV_NATIVE_TLS": "1"} | os.environ
    subprocess.run(command, check=True, env=environment, stdout=sys.stderr)


def uv() -> Path:
    return environment("tools") / "bin/uv"


def environment(name: str) -> Path:
    """The folder of an environment."""
    lock = LOCKS / f"{name}.lock"
    key = hashlib.sha256(lock.read_bytes() + sys.version.encode()).hexdigest()[:16]
    whole = CACHE / f"{name}-{key}"
    if not whole.exists():
        CACHE.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{name}-", dir=CACHE) as folder:
            made = Path(folder) / "venv"
            make(name, lock, made)
            # Somebody else may have made the same meanwhile.
            if not whole.exists():
                made.rename(whole)
    return whole


def make(name: str, lock: Path, folder: Path) -> None:
    if name == "tools":
        run(sys.executable, "-m", "venv", folder)
        run(folder / "bin/pip", "install", "--quiet", "--require-hashes", "-r", lock)
        return
    run(uv(), "venv", "--quiet", "--relocatable", "--python", sys.executable, folder)
    install = [uv(), "pip", "install", "--quiet", "--compile-bytecode", "--python", folder / "bin/python", "--no-deps"]
    if name == "torch":
        locked = [line.split()[0] for line in lock.read_text().splitlines() if line.startswith("torch==")]
        small = {"UV_HTTP_RETRIES": "0", "UV_HTTP_TIMEOUT": "10", "UV_CACHE_DIR": str(CACHE / "uv")} | os.environ
        if subprocess.run([*install, *locked, "--index-url", TORCH_INDEX], env=small, stdout=sys.stderr).returncode == 0:
            rest = folder.parent / "rest.lock"
            rest.write_text(without_torch(lock.read_text()))
            run(*install, "--require-hashes", "-r", rest)
            return
    run(*install, "--require-hashes", "-r", lock)


def without_torch(lock: str) -> str:
    """A lock without PyTorch and what is there for its CUDA."""
    entries = lock.replace(" \\\n    ", " ").splitlines()
    return "\n".join(entry for entry in entries if not entry.startswith(("torch==", "nvidia-", "cuda-", "triton=="))) + "\n"


def with_wheel(name: str) -> Path:
    """A virtual environment of this run: the packages of one in the cache, and the wheel."""
    scratch = Path(os.environ["SCRATCH"])
    folder = scratch / f"{name}+wheel"
    if not folder.exists():
        packages = next((environment(name) / "lib").glob("python*/site-packages"))
        run(uv(), "venv", "--quiet", "--python", sys.executable, folder)
        here = next((folder / "lib").glob("python*/site-packages"))
        # As a folder of packages, whose own .pth files count, rather than a path alone.
        (here / "locked.pth").write_text(f"import site; site.addsitedir({str(packages)!r})\n")
        (wheel,) = (scratch / "wheels").glob("*.whl")
        run(uv(), "pip", "install", "--quiet", "--offline", "--no-deps", "--python", folder / "bin/python", wheel)
    return folder


def head(sources: "list[str]") -> str:
    """First line of a lock: what it was made of, and the hash of that."""
    texts = [(ROOT / source).read_text() if source.endswith(".txt") else source for source in sources]
    return f"# Made by .ci/environments.py --lock of requirements with the hash {hashlib.sha256('|'.join(texts).encode()).hexdigest()[:16]}\n"


def make_lock(name: str, sources: "list[str]") -> None:
    """Compiles requirements to versions and hashes; those with --no-deps apart, without what they ask for."""
    text = head(sources)
    alone = [source.split()[0] for source in sources if source.endswith("--no-deps")]
    others = [f"-r {source}" if source.endswith(".txt") else source for source in sources if not source.endswith("--no-deps")]
    for requirements, options in ((others, []), (alone, ["--no-deps"])):
        if requirements:
            command = [uv(), "pip", "compile", "-", "--quiet", "--generate-hashes", "--no-header", "--no-annotate", "--python-version", PYTHON, *options]
            made = subprocess.run(command, cwd=ROOT, input="\n".join(requirements), capture_output=True, text=True, env={"UV_NATIVE_TLS": "1"} | os.environ)
            if made.returncode:
                sys.exit(f"{name}: {made.stderr}")
            text += made.stdout
    (LOCKS / f"{name}.lock").write_text(text)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--wheel", action="store_true")
    parser.add_argument("--lock", action="store_true")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    locks = Table().locks
    for name in options.names:
        if name not in locks:
            parser.error(f"there is no environment {name!r}; there are {', '.join(locks)}")
    if options.lock:
        for name in options.names or locks:
            make_lock(name, locks[name])
    elif options.check:
        old = [name for name, sources in locks.items() if not (LOCKS / f"{name}.lock").read_text().startswith(head(sources))]
        if old:
            sys.exit(f"requirements have changed since: .ci/environments.py --lock {' '.join(old)}")
    else:
        for name in options.names:
            print((with_wheel if options.wheel else environment)(name) / "bin/python")


if __name__ == "__main__":
    main()
