"""Diagnoses: each mistake is named, with what it explains; what is right or rounded has none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.arrays import Ints
from hsr.base.errors import MapError, UnavailableError
from hsr.mistakes.planted import MISREAD, MISTAKES
from hsr.testing import from_ids, modelled
from tests.conftest import SCENES
from tests.difference.planted import soup

LARGE = ("forest", "terrain", "menger", "mirrored", "teapot", "torus-knot")
BUILT_IN = sorted(file.stem for file in SCENES.glob("*.toml") if file.stem not in LARGE)

UNDONE: dict[str, Callable[[Ints], Ints]] = {
    "turned upside down": lambda face: face[::-1],
    "mirrored left to right": lambda face: face[:, ::-1],
    "turned by 180 degrees": lambda face: face[::-1, ::-1],
    "shifted by (1, 0)": lambda face: np.roll(face, 1, axis=1),
    "shifted by (-7, 5)": lambda face: np.roll(face, (5, -7), axis=(0, 1)),
    "ids 1 too high": lambda face: np.where(face >= 0, face + 1, -1),
    "ids 1 too low": lambda face: np.maximum(face, 0) - 1,
    "ids 100 too high": lambda face: np.where(face >= 0, face + 100, -1),
}

TIES = [mistake for mistake in MISREAD if mistake.startswith("ties")]
FAR = "no far clip"


def view_of(name: str, size: tuple[int, int] = (64, 48)) -> hsr.View:
    return hsr.view(hsr.load(SCENES / f"{name}.toml"), size)


def names(shown: Ints, *expected: Any) -> list[str]:
    return [found.mistake for found in hsr.diagnose(from_ids(shown), *expected)]


@pytest.mark.parametrize("mistake", UNDONE)
def test_what_was_done_to_a_picture_is_named(mistake: str) -> None:
    seen = view_of("solids", (64, 64))
    truth = hsr.render(seen, "exact")
    ids = from_ids(UNDONE[mistake](hsr.render(seen, "zbuffer").face))
    (found,) = hsr.diagnose(ids, truth)
    assert found.mistake == mistake
    # The outlines of the polygons in place of curved shapes, and what has left the picture.
    assert found.left < max(20, 0.05 * found.differing) and found.explained > 0.95 * found.differing


@pytest.mark.parametrize("mistake", ["shifted by (1, 0)", "turned upside down", "ids 1 too high"])
def test_a_rounded_picture_may_be_shifted_too(mistake: str) -> None:
    seen = view_of("engineering")
    rounded = hsr.render(seen, "scanline-float32", subpixel_bits=4).face
    assert names(UNDONE[mistake](rounded), seen) == [mistake]


def test_triangles_are_no_faces() -> None:
    seen = view_of("polyhedra")
    first = np.unique(seen.triangle_face, return_index=True)[1].astype(np.int32)
    face = hsr.render(seen, "zbuffer").face
    assert names(np.where(face >= 0, first[face], -1), seen) == ["triangles' numbers taken for faces"]


@pytest.mark.parametrize("mistake", [name for name in MISREAD if name not in (*TIES, FAR)])
def test_what_was_misread_is_named(mistake: str) -> None:
    # Triangles, some of them culled, some across the near plane.
    seen = replace(soup(), width=64)
    assert names(MISREAD[mistake](seen), seen) == [mistake]


def test_a_far_plane_may_be_forgotten(make_scene: Any) -> None:
    wall = {"name": "wall", "shape": "square", "transform": [{"scale": 2.0}, {"translate": [0, 0, -3]}]}
    seen = hsr.view(make_scene([{"name": "box", "shape": "cube"}, wall], far=6.5), (32, 24))
    assert FAR in names(MISREAD[FAR](seen), seen)


@pytest.mark.parametrize("mistake", TIES)
def test_a_rule_for_ties_is_named_where_ties_are_not_known(make_scene: Any, mistake: str) -> None:
    panels = [
        {"name": f"{size}", "shape": "square", "transform": [{"scale": size}, {"translate": [at, at, size]}]}
        for size, at in ((1.5, 0.0), (0.9, 2.6), (0.7, -0.2), (0.6, -2.8))
    ]
    camera = {"type": "orthographic", "eye": [0.0, 0.0, 10.0], "height": 8.0, "far": 16.0}
    seen = hsr.view(make_scene(panels, **camera), (8, 8))
    shown, expected = MISREAD[mistake](seen), hsr.render(seen, "zbuffer")
    assert mistake in names(shown, expected, seen)
    assert names(shown, seen) == []  # exactly, all of them may own the sample


@pytest.mark.parametrize("mistake", ["z not divided", "truncating snap", "> for <", "truncated bounding box"])
def test_what_a_renderer_does_wrong_is_named(mistake: str) -> None:
    seen = soup()
    assert names(MISTAKES[mistake].render(seen, "").face, seen) == [mistake]


@pytest.mark.jit
@pytest.mark.parametrize("method", ["raycast", "scanline-snap-4", "opengl", "embree"])
def test_nothing_is_diagnosed_in_pictures_that_are_right_or_rounded(method: str) -> None:
    for name in BUILT_IN:
        seen = view_of(name)
        try:
            shown = hsr.render(seen, method)
        except UnavailableError as error:
            pytest.skip(str(error))
        assert names(shown.face, seen) == [], name


def test_a_model_that_is_told_tells_rounding_from_mistakes() -> None:
    seen = soup()
    shown = from_ids(hsr.render(seen, "scanline", depth_format="d16").face)
    assert hsr.diagnose(modelled(shown, "float64", depth_format="d16"), seen) == ()


def test_what_little_a_large_shift_leaves_proves_nothing() -> None:
    random = np.random.default_rng(1)
    for _ in range(20):
        one, other = random.integers(0, 2**31 - 1, (2, 8, 8)) * (random.random((2, 8, 8)) < 0.2)
        assert hsr.diagnose(from_ids(one), from_ids(other)) == ()


def test_maps_of_two_sizes_are_refused() -> None:
    with pytest.raises(MapError, match="their sizes differ"):
        hsr.diagnose(from_ids(np.zeros((2, 3), int)), from_ids(np.zeros((3, 2), int)))


def test_empty_pictures_have_no_diagnosis() -> None:
    empty, full = from_ids(np.full((6, 6), -1)), from_ids(np.full((6, 6), 3))
    assert hsr.diagnose(empty, empty) == hsr.diagnose(full, full) == ()
    assert hsr.diagnose(empty, full) == hsr.diagnose(full, empty) == ()
