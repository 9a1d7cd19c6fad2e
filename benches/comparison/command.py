"""photosite's command."""

import json
import subprocess
import sys


def render(photosite, capture, folder, seed, keys, *options):
    """Renders a capture with other values of some keys, and returns the report."""
    command = [photosite, "render", capture, "-o", folder, "--force", "--json", "--quiet", "--seed", seed, *options]
    for key in keys:
        command += ["--set", key]
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, check=False)
    if done.returncode:
        sys.exit(f"photosite failed with status {done.returncode}")
    return json.loads(done.stdout)
