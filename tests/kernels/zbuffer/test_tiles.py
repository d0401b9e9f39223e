"""How work is put in order and dealt out."""

from __future__ import annotations

import numpy as np
import pytest

from hsr.kernels.zbuffer import tiles


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_pieces_are_dealt_to_and_fro(threads: int) -> None:
    """Each run of a thread holds large and small pieces."""
    runs = tiles.to_and_fro(np.arange(4 * threads), threads).reshape(threads, 4)
    assert sorted(runs.ravel()) == list(range(4 * threads))
    assert len(set(runs.sum(axis=1))) == 1
    assert runs[0].tolist() == [0, 2 * threads - 1, 2 * threads, 4 * threads - 1]


def test_things_come_nearest_first_and_those_beside_the_image_not_at_all() -> None:
    seen = [0.0, 9.0, 0.0, 9.0]
    depths = [1.5, 1.25, np.nan, 1.75, -np.inf, 1.25, np.inf]
    extent = np.array([[*seen, z] for z in depths] + [[3.0, 3.0, 0.0, 9.0, 1.1], [0.0, 9.0, 5.0, 2.0, 1.1]])
    assert tiles.nearest_first(extent).tolist() == [2, 4, 1, 5, 0, 3, 6]


def test_tiles_list_what_may_cover_them() -> None:
    width, height = 2 * tiles.COLUMNS, 2 * tiles.LINES
    far = [0.0, float(width), 0.0, float(height), 1.5]
    near = [float(tiles.COLUMNS) - 1.0, float(tiles.COLUMNS) + 1.0, 0.0, 1.0, 1.25]
    listed, dealt = tiles.deal(np.array([far, near]), width, height, 1)
    lists = {(row, column): listed[start:end].tolist() for row, column, start, end in dealt.tolist()}
    assert lists == {(0, 0): [1, 0], (0, 1): [1, 0], (1, 0): [0], (1, 1): [0]}
