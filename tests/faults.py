#!/usr/bin/env python3
"""Whether the tests notice faults: `python3 tests/faults.py [--cargo-profile PROFILE] [NAME...]`, or `--list`.

Each fault below is one change of the program that is plausibly a slip: a square forgotten, a sign turned, a rounding left
out. The program is copied to a folder of its own, the change is made there, and the tests that watch over that step are run.
They must compile and fail. Without names all are tried, which takes long. That each text to change still stands in the
sources, once, is looked up for all of them every time, and by `--check` alone.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@dataclass
class Fault:
    """`right` in the sources becomes `wrong`; of the tests of `target` those whose names have `names` must fail."""

    right: str
    wrong: str
    target: str
    names: str


PHYSICS = "-p photosite --test physics"


def crate(name: str) -> str:
    return f"-p photosite-{name} --lib"


FAULTS = {
    # Light transport
    "weights-of-mis-are-one": Fault(
        "R::select(zero.lt(own), one / (one + ratio * ratio), zero)",
        "R::select(zero.lt(own + ratio), one, zero)",
        PHYSICS,
        "transport::",
    ),
    "a-diffuse-density-without-cosine": Fault(
        "BsdfSample::reflected(self.reflectance * FRAC_1_PI, wi, Pdf::new(wi.z * FRAC_1_PI))",
        "BsdfSample::reflected(self.reflectance * FRAC_1_PI, wi, Pdf::new(FRAC_1_PI))",
        PHYSICS,
        "bsdf_sampling::",
    ),
    "glass-seen-from-within-as-from-outside": Fault(
        "if wo.z < 0.0 { (1.0 / eta, mirrored(wo)) }",
        "if wo.z < 0.0 { (eta, mirrored(wo)) }",
        PHYSICS,
        "bsdf_",
    ),
    "falloff-by-the-square-of-the-cosine": Fault(
        "cos2 * cos2 * of_image",
        "cos2 * of_image",
        PHYSICS,
        "lens::",
    ),
    "planck-by-the-fourth-power": Fault(
        "lambda.powi(5)",
        "lambda.powi(4)",
        crate("core"),
        "spectrum::",
    ),
    # The sensor
    "electrons-without-shot-noise": Fault(
        "poisson(f64::from(mean), random) as f32",
        "poisson(0.0, random) as f32 + mean",
        PHYSICS,
        "sensor_photon_transfer::",
    ),
    "dark-current-by-the-cube-of-temperature": Fault(
        "(warm / cool).powf(1.5)",
        "(warm / cool).powf(3.0)",
        crate("sensor"),
        "",
    ),
    "a-response-pattern-that-adds": Fault(
        "mean * (1.0 + deviation).max(0.0)",
        "mean + deviation",
        PHYSICS,
        "sensor_",
    ),
    "numbers-cut-off-instead-of-rounded": Fault(
        "        // Adding a half and cutting rounds halves up, which is right for the levels of 0 and more that are left.\n"
        "        (level.clamp(0.0, self.max_dn) + 0.5) as u16",
        "        level.clamp(0.0, self.max_dn) as u16",
        crate("sensor"),
        "",
    ),
    # Raw files and development
    "predictions-from-the-start-of-the-row": Fault(
        "numbers[(y - 1) * row_length + x]",
        "numbers[(y - 1) * row_length]",
        crate("raw"),
        "lossless_jpeg",
    ),
    "diagonals-that-add-to-a-colour": Fault(
        "4.0 * (along[1] + along[2]) - diagonal - along[0]",
        "4.0 * (along[1] + along[2]) + diagonal - along[0]",
        crate("develop"),
        "demosaic",
    ),
    "adaptation-to-the-wrong-white": Fault(
        "DMat3::from_diagonal((cones * to) / (cones * from))",
        "DMat3::from_diagonal((cones * from) / (cones * to))",
        crate("core"),
        "colour::",
    ),
    # Measures and truth
    "dark-noise-with-that-of-rounding": Fault(
        "dark_noise_e: (dark_variance - 1.0 / 12.0).sqrt() / gain",
        "dark_noise_e: dark_variance.sqrt() / gain",
        crate("measure"),
        "characterisation::",
    ),
    "depth-of-the-other-sign": Fault(
        "[0.0, 0.0, 1.0 / b, 0.0]",
        "[0.0, 0.0, -1.0 / b, 0.0]",
        crate("calibration"),
        "camera_files::",
    ),
    "fundamental-matrix-without-its-transpose": Fault(
        "to_second.transpose() * self.essential() * to_first",
        "to_second * self.essential() * to_first",
        crate("calibration"),
        "camera_files::",
    ),
    "rectified-pictures-turned-the-other-way": Fault(
        "self.rotation.transpose() * self.intrinsics.place(position).extend(1.0)",
        "self.rotation * self.intrinsics.place(position).extend(1.0)",
        crate("calibration"),
        "camera_files::",
    ),
    "pixel-centres-at-halves": Fault(
        "[[fx, skew, cx - 0.5], [0.0, fy, cy - 0.5], [0.0, 0.0, 1.0]]",
        "[[fx, skew, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]",
        crate("capture"),
        "report::",
    ),
    "light-from-half-of-the-sky": Fault(
        'Some(("illuminance_lux", lux / PI))',
        'Some(("illuminance_lux", lux / (2.0 * PI)))',
        crate("capture"),
        "",
    ),
}


def sources(folder: Path) -> list[Path]:
    return [path for part in ("src", "crates") for path in (folder / part).rglob("*.rs")]


def place(name: str, folder: Path) -> Path:
    """The only file that has the text of a fault."""
    text = FAULTS[name].right
    found = [path for path in sources(folder) for _ in range(path.read_text().count(text))]
    if len(found) != 1:
        sys.exit(f"{name}: {text!r} stands in the sources {len(found)} times; bring the fault up to date")
    return found[0]


def copy_of_the_program(to: Path) -> None:
    files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True).stdout
    subprocess.run(["tar", "-c", "--null", "-T", "-", "-f", to / "all.tar"], cwd=ROOT, check=True, input=files)
    subprocess.run(["tar", "-x", "-f", "all.tar"], cwd=to, check=True)
    (to / "all.tar").unlink()


def is_noticed(name: str, profile: str) -> bool:
    fault = FAULTS[name]
    with tempfile.TemporaryDirectory(prefix="fault-") as folder:
        copy_of_the_program(Path(folder))
        path = place(name, Path(folder))
        path.write_text(path.read_text().replace(fault.right, fault.wrong))
        # Dependencies are those that the program has been built with.
        environment = dict(os.environ, CARGO_TARGET_DIR=os.environ.get("CARGO_TARGET_DIR", str(ROOT / "target")))
        cargo = ["cargo", "test", "--quiet", "--locked", "--profile", profile]
        target, names = fault.target.split(), fault.names
        # A fault that does not compile would be noticed by the compiler, not by a test.
        build = [*cargo, "--no-run", *target]
        command = [*cargo, *target, names]
        if subprocess.run(build, cwd=folder, env=environment).returncode:
            sys.exit(f"{name}: the changed program does not compile")
        tests = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        failed = [line for line in tests.stdout.splitlines() if line.startswith("    ") and "::" in line]
        some = ", ".join(sorted(set(map(str.strip, failed)))[:3])
        print(f"{name}: noticed by {some}" if tests.returncode else f"{name}: NOT NOTICED", flush=True)
        return tests.returncode != 0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="faults to try; all without")
    parser.add_argument("--list", action="store_true", help="print the names and end")
    parser.add_argument("--check", action="store_true", help="look up the texts to change and end")
    parser.add_argument("--quick", action="store_true", help="with --list: those that unit tests of one crate find")
    parser.add_argument("--cargo-profile", default="release", help="profile to build with (default: release)")
    arguments = parser.parse_args()
    if arguments.list:
        print("\n".join(name for name, fault in FAULTS.items() if not (arguments.quick and fault.target == PHYSICS)))
        return
    unknown = set(arguments.names) - set(FAULTS)
    if unknown:
        parser.error(f"no such fault: {', '.join(sorted(unknown))}; --list prints those that there are")
    for name in FAULTS:
        place(name, ROOT)
    if arguments.check:
        return
    missed = [name for name in arguments.names or FAULTS if not is_noticed(name, arguments.cargo_profile)]
    if missed:
        sys.exit(f"{len(missed)} faults that no test noticed: {', '.join(missed)}")


if __name__ == "__main__":
    main()
