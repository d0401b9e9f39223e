"""Hierarchies on the screen: what lies below a node lies within its extent, and what hides it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from hsr.algorithms.prepare import ray_tiles as tiles_of_rays
from hsr.algorithms.zbuffer import along_the_curve
from hsr.kernels.hierarchy import INNER
from hsr.kernels.raytiles import casting
from hsr.kernels.zbuffer.fill import CELL, COLUMNS, LINES, depth_mask, gap_of
from hsr.kernels.zbuffer.setup import ERROR, NEARNESS, PRECISE, X, Y, key_depth, nearness_error
from tests.conftest import JIT
from tests.exact.adversarial import adversarial
from tests.kernels.zbuffer.test_setup import exact_vertices

SEEDS = [seed for seed in range(120 if JIT else 16) if seed % 4]


def laid_out(seed):
    """Lay out all objects of an adversarial view, and return the view's eye, its meshes, and their place."""
    view = adversarial(seed)
    world = tiles_of_rays.world_of(view.geometry, tiles_of_rays.hierarchies_of(view.geometry))
    rows = tiles_of_rays.clip_matrices(view)
    eye = tiles_of_rays.eye_of(view, world, rows)
    caster = tiles_of_rays.Caster(view, world, rows, eye, True, (world.faces, None, None))
    extent, _ = tiles_of_rays._extents(caster)
    return (
        eye,
        world.shapes,
        tiles_of_rays._lay_out(caster, world.members, extent, tiles_of_rays._room(world.members)),
    )


def test_projected_vertices_are_within_their_bounds():
    asked = 0
    for seed in SEEDS[:: 1 if JIT else 4]:
        eye, _, (_, _, screen, _) = laid_out(seed)
        view = adversarial(seed)
        along, (_, place) = exact_vertices(view), along_the_curve(*[view.polygons.vertices] * 2)
        for (x, y, nearness, error), exact in zip(screen, [along[k] for k in place], strict=True):
            if error <= PRECISE:
                assert abs(Fraction(float(x)) - exact[0]) <= error, f"seed {seed}"
                assert abs(Fraction(float(y)) - exact[1]) <= error, f"seed {seed}"
                assert abs(Fraction(float(nearness)) - exact[2]) <= nearness_error(nearness, eye)
                asked += 1
    assert asked > (1000 if JIT else 50)


def below(tree, k):
    """Yield the triangles of all leaves below a node."""
    first, count = tree[k]
    if count == INNER:
        yield from below(tree, first)
        yield from below(tree, first + 1)
    else:
        yield from range(first, first + count)


@pytest.mark.parametrize("share", range(4))
def test_the_extent_of_a_node_holds_all_certain_triangles_below_it(share):
    asked = 0
    for seed in SEEDS[share::4]:
        eye, (_, corner, _, tree), (members, _, screen, extent) = laid_out(seed)
        for member in members:
            own = tree[member["node"] : member["node"] + member["nodes"]]
            for k in range(len(own)):
                triangles = member["triangle"] + np.fromiter(below(own, k), np.int64)
                corners = screen[member["to_screen"] + corner[triangles]]
                certain = (corners[..., ERROR] <= PRECISE).all(axis=1)
                asked += holds(extent[member["to_extent"] + k], corners[certain], eye)
    assert asked > (40 if JIT else 0)


def holds(extent, corners, eye):
    """Check that an extent holds the samples in rectangles around triangles (n, 3, 4), and their depths."""
    low, high = corners[..., [X, Y]].min(axis=1), corners[..., [X, Y]].max(axis=1)
    first, last = np.ceil(low - 0.5), np.floor(high - 0.5)
    first, last = np.maximum(first, 0.0), np.minimum(last, [eye.width - 1.0, eye.height - 1.0])
    covers = (first <= last).all(axis=1)
    if not covers.any():
        return 0
    first, last = first[covers].min(axis=0), last[covers].max(axis=0)
    assert extent[0] <= first[0] and last[0] < extent[1]
    assert extent[2] <= first[1] and last[1] < extent[3]
    assert extent[4] <= key_depth(corners[covers][..., NEARNESS].max(), eye)
    return 1


@pytest.mark.parametrize("seed", [1, 2, 3, 5, 6, 7])
def test_numbers_are_those_of_the_pieces(seed):
    """The hierarchy turns the fans of mirrored objects as the exact decisions do, and loses no triangle."""
    view = adversarial(seed)
    meshes = tiles_of_rays.hierarchies_of(view.geometry)
    for placement in view.placements:
        mesh = meshes[placement.shape, placement.mirrored]
        assert sorted(mesh.number) == list(range(len(mesh.corner)))
        first = view.placements.index(placement)
        fans = view.polygons.triangle_vertex
        start = sum(len(p.shape.polygons.triangle_vertex) for p in view.placements[:first])
        offset = sum(len(p.shape.polygons.vertices) for p in view.placements[:first])
        assert (fans[start + mesh.number] - offset == mesh.corner).all()


def test_an_object_may_show_unless_all_its_cells_show_something_nearer():
    gap = gap_of(depth_mask(1000), 2.0**-36)
    farthest = np.full((2, 2, LINES // CELL, COLUMNS // CELL), 1.2)
    beyond = 1.25 * CELL
    across = np.array([[COLUMNS - beyond, COLUMNS + beyond, LINES - beyond, LINES + beyond, 1.5]])
    assert not casting.may_show(across, gap, farthest)[0]
    reached = [(0, 0, -2, -2), (0, 0, -1, -1), (0, 1, -1, 1), (1, 0, 0, -1), (1, 1, 1, 1)]
    for cell in reached:
        farthest[cell] = np.inf
        assert casting.may_show(across, gap, farthest)[0], cell
        farthest[cell] = 1.2
    for cell in [(0, 0, 0, 0), (0, 1, -3, 0), (1, 1, 2, 0), (1, 1, 0, 2)]:
        farthest[cell] = np.inf
        assert not casting.may_show(across, gap, farthest)[0], cell
        farthest[cell] = 1.2
    as_near = np.array([[0.0, 1.0, 0.0, 1.0, 1.2]])
    assert casting.may_show(as_near, gap, farthest)[0]
