"""How many rays escape from closed meshes: an experiment on the tests of rays with triangles.

A ray that starts inside a closed mesh hits it. Rays aimed at a vertex or at an edge are the hard ones:
after rounding they pass beside it, each by its own last bit, and a test that looks at two neighbours
differently may deny both. After Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Floats
from hsr.kernels.triangle_tests import EDGE_PLANES, MOLLER_TRUMBORE, WOOP, misses
from hsr.scene.shapes import Polygons, generic, tessellated

TESTS = {"moller-trumbore": MOLLER_TRUMBORE, "edge-planes": EDGE_PLANES, "woop": WOOP}
ARITHMETICS = ("float64", "float32")
AIMS = ("vertices", "edge midpoints")
SEGMENTS = 40
"""Sides of the sphere and the cylinder."""


class Escapes(NamedTuple):
    """One row of the table.

    Attributes
    ----------
    mesh : {"sphere", "cylinder"}
        Tessellated.
    aim : {"vertices", "edge midpoints"}
    test : str
        One of ``TESTS``.
    arithmetic : {"float64", "float32"}
        Of the mesh, the rays and the test.
    rays, misses : int
        How many were cast, and how many of them hit no triangle.
    """

    mesh: str
    aim: str
    test: str
    arithmetic: str
    rays: int
    misses: int


def escapes(rays: int = 20_000, seed: int = 0) -> list[Escapes]:
    """Count the rays that escape, for every mesh, aim, test and arithmetic.

    Parameters
    ----------
    rays : int
        Rays for each row of the table.
    seed : int
        Of the origins and of which vertex or edge each ray is aimed at; the same rays for all tests.

    Returns
    -------
    list of Escapes
    """
    return list(_rows(rays, seed))


def _rows(rays: int, seed: int) -> Iterator[Escapes]:
    for shape, aim in product(("sphere", "cylinder"), AIMS):
        polygons = tessellated(generic(shape), SEGMENTS).polygons
        assert polygons is not None, "a tessellated shape has polygons"
        origins, targets = aimed(polygons, aim, rays, np.random.default_rng(seed))
        corners = polygons.vertices[polygons.triangle_vertex]
        for (name, test), arithmetic in product(TESTS.items(), ARITHMETICS):
            o, target, mesh = (array.astype(arithmetic) for array in (origins, targets, corners))
            missed = misses(test, o, target - o, mesh)
            yield Escapes(shape, aim, name, arithmetic, rays, missed)


def aimed(polygons: Polygons, aim: str, rays: int, random: np.random.Generator) -> tuple[Floats, Floats]:
    """Choose where rays start and what they are aimed at.

    Parameters
    ----------
    polygons : Polygons
        A convex closed mesh.
    aim : {"vertices", "edge midpoints"}
    rays : int
    random : Generator

    Returns
    -------
    origins, targets : (rays, 3) float64
        Origins lie inside, at most half-way from the middle to the surface.
    """
    vertices, corner = polygons.vertices, polygons.triangle_vertex
    used = np.unique(corner)
    middle = vertices[used].mean(axis=0)
    within = vertices[random.choice(used, (rays, 4))].mean(axis=1)
    origins = middle + random.uniform(0.0, 0.5, (rays, 1)) * (within - middle)
    edges = np.unique(np.sort(corner[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    places = vertices[used] if aim == "vertices" else vertices[edges].mean(axis=1)
    return origins, places[random.integers(0, len(places), rays)]
