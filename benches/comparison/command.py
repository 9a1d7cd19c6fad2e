"""photosite's command."""

import json
import resource
import subprocess
import sys


def render(photosite, capture, folder, seed, keys, *options):
    """Renders a capture with other values of some keys; returns the report and the processor seconds of the whole program."""
    command = [photosite, "render", capture, "-o", folder, "--force", "--json", "--quiet", "--seed", seed, *options]
    for key in keys:
        command += ["--set", key]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, check=False)
    if done.returncode:
        sys.exit(f"photosite failed with status {done.returncode}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return json.loads(done.stdout), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
