"""Rays that escape from closed meshes."""

from __future__ import annotations

import numpy as np
import pytest

from hsr.lab.watertight import AIMS, ARITHMETICS, TESTS, Escapes, aimed, escapes
from hsr.scene.shapes import generic, tessellated
from hsr.scene.solids import surface_problem, winding_number

RAYS = 2000


@pytest.fixture(scope="module")
def table() -> list[Escapes]:
    return escapes(RAYS, seed=3)


@pytest.mark.jit
def test_the_table_has_every_case_once(table: list[Escapes]) -> None:
    cases = {(row.mesh, row.aim, row.test, row.arithmetic) for row in table}
    assert len(cases) == len(table) == 2 * len(AIMS) * len(TESTS) * len(ARITHMETICS)
    assert {row.rays for row in table} == {RAYS}


@pytest.mark.jit
def test_woops_test_loses_no_ray(table: list[Escapes]) -> None:
    assert {row.misses for row in table if row.test == "woop"} == {0}


@pytest.mark.jit
def test_edge_planes_lose_no_ray_at_an_edge(table: list[Escapes]) -> None:
    found = [row for row in table if row.test == "edge-planes"]
    assert {row.misses for row in found if row.aim == "edge midpoints"} == {0}
    assert all(0 < row.misses < 0.05 * RAYS for row in found if row.aim == "vertices")


@pytest.mark.jit
def test_moller_and_trumbores_test_loses_rays_whatever_the_arithmetic(table: list[Escapes]) -> None:
    for row in table:
        if row.test == "moller-trumbore":
            assert 0.03 * RAYS < row.misses < 0.15 * RAYS, row


@pytest.mark.parametrize("aim", AIMS)
@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_the_rays_start_inside_a_closed_mesh_and_end_on_it(shape: str, aim: str) -> None:
    polygons = tessellated(generic(shape), 8).polygons
    assert polygons is not None and surface_problem(polygons) == ""
    origins, targets = aimed(polygons, aim, 50, np.random.default_rng(1))
    corners = polygons.vertices[polygons.triangle_vertex]
    for origin in origins:
        assert winding_number(origin, corners) == pytest.approx(1.0)
    ends = {tuple(vertex) for vertex in polygons.vertices}
    assert all((tuple(target) in ends) == (aim == "vertices") for target in targets)
