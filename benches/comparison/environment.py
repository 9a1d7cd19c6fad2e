"""The Python environment of the comparisons."""

import os
import subprocess
import sys
from pathlib import Path

BENCHES = Path(__file__).resolve().parents[1]
ROOT = BENCHES.parent
ENVIRONMENT = ROOT / "target" / "benches-venv"


def enter():
    """Starts the program again in an environment that has Mitsuba and numpy, unless this one has."""
    try:
        import mitsuba  # noqa: F401
        return
    except ImportError:
        python = ENVIRONMENT / "bin" / "python"
    if Path(sys.prefix) == ENVIRONMENT:
        sys.exit(f"Mitsuba cannot be loaded from {ENVIRONMENT}: remove that folder and try again")
    if not python.is_file():
        subprocess.run([sys.executable, "-m", "venv", str(ENVIRONMENT)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", "-r", str(BENCHES / "requirements.txt")], check=True)
    os.execv(python, [str(python), *sys.argv])
