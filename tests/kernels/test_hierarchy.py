"""The hierarchy: every box in one leaf, every node around what is below it."""

from __future__ import annotations

import numpy as np
import pytest

from hsr.kernels import hierarchy
from hsr.kernels.hierarchy import INNER, LEAF, build


def boxes(seed, n):
    random = np.random.default_rng(seed)
    low = random.normal(size=(n, 3))
    return low, low + random.uniform(0.0, 0.2, (n, 3))


@pytest.mark.parametrize("n", [1, 8, 9, 100, 1000])
def test_every_box_is_in_one_leaf_and_every_node_holds_its_boxes(n):
    low, high = boxes(n, n)
    order, nodes = build(low, high)
    assert sorted(order) == list(range(n))
    leaves = nodes[nodes["count"] != INNER]
    places = np.concatenate([np.arange(leaf["first"], leaf["first"] + leaf["count"]) for leaf in leaves])
    assert sorted(places) == list(range(n))
    assert leaves["count"].max() <= LEAF
    for k, node in enumerate(nodes):
        if node["count"] == INNER:
            assert node["first"] > k
            below = nodes[node["first"] : node["first"] + 2]
            assert (node["low"] == below["low"].min(axis=0)).all()
            assert (node["high"] == below["high"].max(axis=0)).all()
        else:
            inside = order[node["first"] : node["first"] + node["count"]]
            assert (node["low"] == low[inside].min(axis=0)).all()
            assert (node["high"] == high[inside].max(axis=0)).all()


def test_boxes_in_one_place_are_halved():
    low = np.zeros((100, 3))
    order, nodes = build(low, low + 1.0)
    assert sorted(order) == list(range(100))
    assert len(nodes) == 31


def test_radix_sort_is_a_stable_sort():
    code = np.random.default_rng(5).integers(0, 2**30, 3000).astype(np.uint32)
    code[1000:2000] = code[:1000]
    sorted_code, order = hierarchy.radix_sort(code.copy())
    assert (order == np.argsort(code, kind="stable")).all()
    assert (sorted_code == np.sort(code)).all()


def test_codes_run_along_the_morton_curve():
    grid = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
    assert (np.diff(hierarchy.morton_codes(grid, grid).astype(np.int64)) > 0).all()
    assert int(hierarchy.spread(np.uint32(0b1011))) == 0b001000001001


def test_a_row_too_short_to_divide_by_is_as_good_as_none():
    row = np.arange(-16.0, 16.0)[:, None] * [1e-310, 0.0, 1.0]
    none = row * [0.0, 0.0, 1.0]
    assert (hierarchy.morton_codes(row, row) == hierarchy.morton_codes(none, none)).all()


def test_boxes_of_triangles():
    vertices = np.array([[0.0, 5.0, 1.0], [2.0, 3.0, -1.0], [1.0, 4.0, 0.0]])
    low, high = hierarchy.boxes_of(vertices, np.array([[0, 1, 2]], np.int32))
    assert low.tolist() == [[0.0, 3.0, -1.0]]
    assert high.tolist() == [[2.0, 5.0, 1.0]]
