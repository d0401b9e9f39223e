"""Tiles: what they reach, what hides it, and the rows of rays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hsr.kernels import raytiles
from hsr.kernels.bounds import NOWHERE, Reach
from hsr.kernels.rays import NO_OWNER, Camera, covered_nearness, facet_of, row_of
from hsr.kernels.raytiles import REACH, SIDE, TILE, area_of

CAMERA = Camera(True, 0.5, math.inf, 2.0, 0.0, 40, 20)


def empty_tile():
    tile = np.zeros(1, TILE)
    tile["face"] = NO_OWNER
    return tile[0]


def noted(*reaches):
    table = np.zeros(len(reaches) + 1, REACH)
    for k, reach in enumerate(reaches):
        raytiles.note_reach(table[k], reach, CAMERA)
    return table


def test_the_last_tile_ends_with_the_image():
    assert area_of(0, 0, CAMERA) == (0, 0, 15, 15, -19.5, -9.5)
    assert area_of(1, 2, CAMERA) == (32, 16, 39, 19, 12.5, 6.5)


def test_a_joint_reach_holds_its_parts_and_nowhere_adds_nothing():
    table = noted(Reach(-5.0, -2.0, 0.0, 3.0, 0.5), NOWHERE, Reach(1.0, 4.0, -8.0, 1.0, 0.25))
    raytiles.join(table, 3, 0, 3)
    assert table[3].tolist() == (15, 23, 2, 12, 0.5)
    raytiles.join(table, 3, 1, 1)
    assert table[3]["left"] > table[3]["right"]


def test_what_cannot_show_is_passed_by():
    table = noted(Reach(-20.0, -10.0, -10.0, 0.0, 0.5))
    reach, tile = table[0], empty_tile()
    assert raytiles.can_show(reach, area_of(0, 0, CAMERA), tile)
    assert not raytiles.can_show(reach, area_of(0, 1, CAMERA), tile)
    assert not raytiles.can_show(reach, area_of(1, 0, CAMERA), tile)
    tile["floor"] = 0.5
    assert raytiles.can_show(reach, area_of(0, 0, CAMERA), tile)
    tile["floor"] = math.nextafter(0.5, 1.0)
    assert not raytiles.can_show(reach, area_of(0, 0, CAMERA), tile)


def test_an_object_is_hidden_if_all_its_tiles_show_something_nearer():
    table = noted(Reach(-20.0, 1.0, -10.0, 10.0, 0.5))
    tiles = np.zeros((2, 3), TILE)
    tiles["floor"] = 1.0
    assert raytiles.is_hidden(table[0], tiles)
    tiles["floor"][1, 1] = 0.25
    assert not raytiles.is_hidden(table[0], tiles)
    tiles["floor"][1, 1], tiles["floor"][0, 2] = 1.0, 0.25
    assert raytiles.is_hidden(table[0], tiles)


def test_the_floor_is_the_least_nearness():
    tile = empty_tile()
    tile["nearness"] = np.random.default_rng(6).uniform(1.0, 2.0, (SIDE, SIDE))
    raytiles.raise_floor(tile)
    assert tile["floor"] == tile["nearness"].min()


@pytest.mark.parametrize("face", [3, 8])
def test_a_row_of_rays_is_sixteen_single_rays(face):
    random = np.random.default_rng(7)
    area = area_of(0, 1, CAMERA)
    for _ in range(30):
        x, y, d = random.uniform(-12, 12, 3), random.uniform(-12, 4, 3), random.uniform(0.6, 4.0, 3)
        corners = [(x[k] * d[k], y[k] * d[k], d[k], 1.0 / d[k]) for k in range(3)]
        facet = facet_of(*corners, True, 0, False)
        tile = empty_tile()
        tile["nearness"], tile["face"] = 0.4, 5
        for row in range(SIDE):
            raytiles.cast_into_row(facet, face, row, area, CAMERA.closest, tile)
            for i in range(SIDE):
                here = covered_nearness(row_of(facet, area.y + row), area.x + i, CAMERA.closest)
                wins = here > 0.4 or (here == 0.4 and face < 5)
                assert tile["face"][row, i] == (face if wins else 5)
                assert tile["nearness"][row, i] == (here if wins else 0.4)


@pytest.mark.parametrize(("face", "owner"), [(3, 3), (8, 5)])
def test_of_equal_nearness_the_lower_face_wins(face, owner):
    facet = facet_of((-90.0, -90.0, 2.0, 0.5), (90.0, -90.0, 2.0, 0.5), (0.0, 90.0, 2.0, 0.5), True, 0, False)
    tile = empty_tile()
    tile["nearness"], tile["face"] = 0.5, 5
    raytiles.cast_into_row(facet, face, 4, area_of(0, 1, CAMERA), 2.0, tile)
    assert (tile["face"][4] == owner).all()
