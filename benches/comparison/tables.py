"""The tables of compare.py, as Markdown."""

import statistics

from .figures import Ratio
from .photosite_renderer import UNDIVIDED
from .scenes import SCENES


def best(runs, program, undivided=False):
    """The name of a program's way of the highest efficiency; if asked, of those that trace one path a sample and no more."""
    names = [name for name in runs if name.startswith(program)]
    if undivided:
        alone = [name for name in names if name.split(", ", 1)[1] in UNDIVIDED]
        names = alone or [name for name in names if name.endswith("default")] or names
    return max(names, key=lambda name: runs[name].efficiency())


def report(key, result):
    """Prints a scene's tables."""
    print(f"\n### {key}: {SCENES[key][0]}")
    for samples, runs in result["samples"].items():
        base = runs[best(runs, "Mitsuba")]
        print(f"\n{samples} samples per pixel; ratios to {best(runs, 'Mitsuba')}.\n")
        print("| | Mpaths/s | ratio | by processor time | relMSE | efficiency | ratio | by processor time | relMSE of the sum "
              "| ratio by processor time | relMSE of 4 × 4 pixels | ratio by processor time | whole program, s | of the processor, s |")
        print("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|")
        for name, r in runs.items():
            gain, grey_gain, coarse_gain = base.relmse / r.relmse, base.grey_relmse / r.grey_relmse, base.coarse_relmse / r.coarse_relmse
            wall, busy = r.whole_s()
            cells = [
                name,
                f"{r.paths / statistics.median(r.wall) / 1e6:.2f}",
                Ratio.of(base.wall, r.wall),
                Ratio.of(base.busy, r.busy),
                f"{r.relmse:.5f}",
                f"{r.efficiency():.1f}",
                Ratio.of(base.wall, r.wall, gain),
                Ratio.of(base.busy, r.busy, gain),
                f"{r.grey_relmse:.5f}",
                Ratio.of(base.busy, r.busy, grey_gain),
                f"{r.coarse_relmse:.5f}",
                Ratio.of(base.busy, r.busy, coarse_gain),
                f"{wall:.2f}",
                f"{busy:.2f}",
            ]
            print("| " + " | ".join(str(cell) for cell in cells) + " |")
    means = ", ".join(f"{value:.4f}" for value in result["mean_ratio"])
    print(f"\nReferences, photosite / Mitsuba: mean electrons in R, G, B {means}; relMSE between them {result['relmse_of_references']:.1e}.")


def summarise(results):
    """Prints what matters of all scenes: the default, the best of each program, and the goals."""
    print("\n### In short\n")
    print("Paths per second are those of ways that trace one path a sample. Efficiency: the default's, then that of the best way by "
          "hand, each over that of Mitsuba's best sampler. Whole programs: Mitsuba's processor time over that of the default. Goals: paths "
          "per second at least 1, efficiency at least 2.5, the default within 15 % of the best.\n")
    print("| scene | samples | paths per second | by processor time | default | by processor time | best | by processor time | which "
          "| whole programs | |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for key, result in results.items():
        for samples, runs in result["samples"].items():
            print("| " + " | ".join(str(cell) for cell in in_short(key, samples, runs)) + " |")


def in_short(key, samples, runs):
    """A scene's cells of the summary."""
    name = best(runs, "photosite")
    theirs, ours = runs[best(runs, "Mitsuba")], runs[name]
    usual = runs.get("photosite, default", ours)
    undivided = runs[best(runs, "photosite", undivided=True)]
    rate = Ratio.of(theirs.wall, undivided.wall), Ratio.of(theirs.busy, undivided.busy)
    efficiency = [
        ratio
        for way in (usual, ours)
        for ratio in (Ratio.of(theirs.wall, way.wall, theirs.relmse / way.relmse), Ratio.of(theirs.busy, way.busy, theirs.relmse / way.relmse))
    ]
    reached = {"paths": rate[1].median >= 1, "efficiency": efficiency[1].median >= 2.5, "default": efficiency[1].median >= 0.85 * efficiency[3].median}
    missed = ", ".join(goal for goal, is_reached in reached.items() if not is_reached)
    whole = theirs.whole_s()[1] / usual.whole_s()[1]
    verdict = f"**not reached**: {missed}" if missed else "reached"
    return [f"{key}: {SCENES[key][0]}", samples, *rate, *efficiency, name.removeprefix("photosite, "), f"{whole:.2f}", verdict]


def report_before(results):
    """Prints the paths per second of this build over those of the one before."""
    print("\n### Paths per second, this build over the one before\n")
    print("| scene | samples | | ratio | by processor time |")
    print("|---|---|---|---|---|")
    for key, result in results.items():
        for samples, before in result["before"].items():
            for name, earlier in before.items():
                now = result["samples"][samples][name]
                print(f"| {key} | {samples} | {name} | {Ratio.of(earlier.wall, now.wall)} | {Ratio.of(earlier.busy, now.busy)} |")
