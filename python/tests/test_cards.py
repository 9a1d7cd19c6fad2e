"""Scenes of the suite against Mitsuba, small, on a graphics card or on software that stands for one, against the processor."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import photosite as ps
import pytest

SCENES = Path(__file__).resolve().parents[2] / "tests" / "mitsuba" / "scenes"
CAPTURES = sorted(SCENES.glob("*/capture.toml"))
SIDE = 40


@pytest.fixture(scope="module")
def card() -> str:
    cards = [row["device"] for row in ps.devices() if row["device"] != "cpu" and row["refusal"] is None]
    if not cards:
        pytest.skip("no graphics card, and no software that stands for one")
    return str(cards[0])


def z_scores(capture: ps.Capture, other: ps.Capture, card: str) -> "npt.NDArray[np.float64]":
    seen, expected = ps.trace(capture, device=card), ps.trace(other)
    difference = seen.electrons_per_s.astype(float) - expected.electrons_per_s
    variance = seen.variance.astype(float) + expected.variance
    return np.asarray((difference / np.sqrt(np.where(variance > 0, variance, np.inf)))[variance > 0])


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.parent.name)
def test_scenes_of_the_suite_are_rendered_as_on_the_processor(path: Path, card: str) -> None:
    columns, rows = ps.load(path).resolution_px
    scale = SIDE / max(columns, rows)
    keys = {
        "sensor.scaled_to_px": [round(columns * scale), round(rows * scale)],
        # Random numbers that know nothing of each other: their variance is exact.
        "render.sampler": "independent",
        "render.strategy": "plain",
        "render.samples_per_pixel": 128,
    }
    one, other = (ps.load(path, set={**keys, "render.seed": seed}) for seed in (2, 3))
    z = z_scores(one, other, card)
    # Channels of a pixel share paths, so that a mean counts for a third as many; variances are those of 128 samples with
    # long tails.
    assert abs(z.mean()) * np.sqrt(z.size / 3) < 4.5, f"z of the mean {z.mean() * np.sqrt(z.size / 3):.2f}"
    assert 0.85 < z.std() < 1.15, f"spread {z.std():.3f}"
