"""Work in other processes: forked ones have no threads of their parent."""

from __future__ import annotations

import multiprocessing
import os
from pathlib import Path

import numpy as np
import pytest

import photosite as ps


def render(capture: ps.Capture) -> bytes:
    return np.asarray(ps.render(capture).raw).tobytes()


@pytest.mark.parametrize("how", ["fork", "spawn", "forkserver"])
def test_processes_render_what_their_parent_renders(how: str, room: Path) -> None:
    if how not in multiprocessing.get_all_start_methods():
        pytest.skip("there is none of that kind here")
    capture = ps.load(room)
    # From here on the parent has threads, of which a forked child has none.
    expected = render(capture)
    with multiprocessing.get_context(how).Pool(2) as pool:
        found = pool.map_async(render, [capture] * 4).get(timeout=120)
    assert found == [expected] * 4
    assert render(capture) == expected


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_forked_child_uses_what_its_parent_has_made(room: Path) -> None:
    light = ps.trace(room)
    expected = np.asarray(light.expose(time_s=0.02).raw).tobytes()
    child = os.fork()
    if child == 0:
        same = np.asarray(light.expose(time_s=0.02).raw).tobytes() == expected
        os._exit(0 if same else 1)
    _, status = os.waitpid(child, 0)
    assert status == 0


def fail(path: str) -> None:
    ps.load(path)


def test_errors_come_back_from_processes(room: Path) -> None:
    room.write_text(room.read_text().replace("time_s = 0.01", "time_s = -1"))
    with multiprocessing.get_context("spawn").Pool(1) as pool, pytest.raises(ps.InputError) as error:
        pool.apply(fail, (str(room),))
    assert error.value.line == 11 and error.value.key == "exposure.time_s"
