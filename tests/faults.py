#!/usr/bin/env python3
"""Whether the tests notice faults: `python3 tests/faults.py [NAME...]`, or `--list`.

Each fault below is one change of the program that is plausibly a slip: a square forgotten, a sign turned, a rounding left
out. A copy of the program has all of them, and PHOTOSITE_FAULT chooses one, so that it is compiled once. Of the tests that
watch over a step some must fail with its fault, and these must pass without. Without names all faults are tried. That each
text to change still stands in the sources, once, is looked up for all of them every time, and by `--check` alone.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@dataclass
class Fault:
    """The expression `right` in the sources is `wrong` where the fault is chosen; of the tests of `target`, a crate or a
    file of tests, those whose names have `names` must fail."""

    right: str
    wrong: str
    target: str
    names: str


PHYSICS = "physics"


def crate(name: str) -> str:
    return f"photosite_{name}"


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
        "(1.0 / eta, mirrored(wo))",
        "(eta, mirrored(wo))",
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
        "(dark_variance - 1.0 / 12.0).sqrt() / gain",
        "dark_variance.sqrt() / gain",
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
    # With new times: cargo would take what was compiled of an earlier copy for this one.
    subprocess.run(["tar", "-x", "-m", "-f", "all.tar"], cwd=to, check=True)
    (to / "all.tar").unlink()


# What each crate of the copy gets: the number of the fault that is chosen.
CHOSEN = """
#[allow(missing_docs)]
fn planted(number: u32) -> bool {
    static CHOSEN: std::sync::LazyLock<u32> =
        std::sync::LazyLock::new(|| std::env::var("PHOTOSITE_FAULT").map_or(0, |text| text.parse().expect("a number")));
    *CHOSEN == number
}
"""


def plant(names: list[str], folder: Path) -> None:
    """Brings faults into a copy of the program; their numbers count from 1."""
    crates = set()
    for number, name in enumerate(names, 1):
        fault, path = FAULTS[name], place(name, folder)
        both = f"(if crate::planted({number}) {{ {fault.wrong} }} else {{ {fault.right} }})"
        path.write_text(path.read_text().replace(fault.right, both))
        crates.add(next(above for above in path.parents if above.name == "src"))
    for source in crates:
        with open(source / "lib.rs", "a") as file:
            file.write(CHOSEN)


def programs(targets: set[str], folder: Path) -> dict[str, Path]:
    """Compiles tests of a copy; returns the programs by their targets. What they stand on is that of the program itself."""
    kinds = ["--lib", *(["--test", PHYSICS] if PHYSICS in targets else [])]
    environment = dict(os.environ, CARGO_TARGET_DIR=os.environ.get("CARGO_TARGET_DIR", str(ROOT / "target")))
    command = ["cargo", "test", "--release", "--locked", "--no-run", "--message-format=json-render-diagnostics", *kinds]
    packages = [word for target in sorted(targets - {PHYSICS}) for word in ("-p", target.replace("_", "-"))]
    if PHYSICS in targets:
        packages += ["-p", "photosite"]
    # A number that is the usual one, but said: these crates get other names than those of the program, which lie in the same
    # folder and would be taken for it later, faults and all.
    ours = ["photosite", *(path.name for path in (folder / "crates").iterdir())]
    apart = [word for crate in ours for word in ("--config", f"profile.release.package.{crate}.codegen-units=16")]
    built = subprocess.run([*command, *apart, *packages], cwd=folder, env=environment, capture_output=True, text=True)
    # A fault that does not compile would be noticed by the compiler, not by a test.
    if built.returncode:
        sys.exit(f"{built.stderr}\nthe changed program does not compile")
    made = [json.loads(line) for line in built.stdout.splitlines()]
    return {unit["target"]["name"]: Path(unit["executable"]) for unit in made if unit.get("executable")}


def failed(program: Path, names: list[str], number: int, folder: Path) -> list[str]:
    """Tests of those names that fail with the fault of a number, 0 for none."""
    # As cargo does: tests look for their files from the folder of their package.
    crate = folder / "crates" / program.name.rsplit("-", 1)[0].replace("_", "-")
    environment = dict(os.environ, PHOTOSITE_FAULT=str(number))
    tests = subprocess.run([program, *names], cwd=crate if crate.exists() else folder, env=environment, capture_output=True, text=True)
    lines = [line for line in tests.stdout.splitlines() if line.startswith("    ") and "::" in line]
    if tests.returncode and not lines:
        sys.exit(f"{program.name} {' '.join(names)}: ended with {tests.returncode}\n{tests.stderr}")
    return sorted(set(map(str.strip, lines))) if tests.returncode else []


def missed(names: list[str]) -> list[str]:
    """Faults that no test notices."""
    faults = {name: FAULTS[name] for name in names}
    missed = []
    with tempfile.TemporaryDirectory(prefix="faults-") as temporary:
        folder = Path(temporary)
        copy_of_the_program(folder)
        plant(names, folder)
        found = programs({fault.target for fault in faults.values()}, folder)
        for number, (name, fault) in enumerate(faults.items(), 1):
            program = found[fault.target]
            noticed = failed(program, [fault.names], number, folder)[:3]
            if noticed and (without := failed(program, ["--exact", *noticed], 0, folder)):
                sys.exit(f"{name}: without a fault, too, there fail {', '.join(without)}")
            print(f"{name}: noticed by {', '.join(noticed)}" if noticed else f"{name}: NOT NOTICED", flush=True)
            if not noticed:
                missed.append(name)
    return missed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="faults to try; all without")
    parser.add_argument("--list", action="store_true", help="print the names and end")
    parser.add_argument("--check", action="store_true", help="look up the texts to change and end")
    parser.add_argument("--quick", action="store_true", help="with --list: those that unit tests of one crate find")
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
    if unnoticed := missed(arguments.names or list(FAULTS)):
        sys.exit(f"{len(unnoticed)} faults that no test noticed: {', '.join(unnoticed)}")


if __name__ == "__main__":
    main()
