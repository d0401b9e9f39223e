"""Every variant of scan conversion errs by what it is named after, and by nothing that is not explained."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import exact, scanline
from hsr.algorithms.registry import methods
from hsr.difference.cause import Causes, causes
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from hsr.scene.model import Scene
from tests.conftest import SCENES
from tests.difference.planted import close_pair, prism

VARIANTS = [name for name, method in methods().items() if method.module == scanline.__name__]
FILES = sorted(path.stem for path in SCENES.glob("*.toml"))


@cache
def built_in(name: str) -> tuple[View, VisibilityMap]:
    side = 32 if name == "forest" else 24  # half a million triangles, crowded in fewer samples
    seen = view(hsr.load(SCENES / f"{name}.toml"), (side, side))
    return seen, exact.render(seen, exact.Options())


def judged(seen: View, truth: VisibilityMap, method: str, **options: Any) -> Causes:
    return causes(seen, hsr.render(seen, method, **options), truth, **options)


@pytest.mark.jit
@pytest.mark.parametrize("method", VARIANTS)
@pytest.mark.parametrize("name", FILES)
def test_every_variant_is_explained_on_every_scene(name: str, method: str) -> None:
    found = judged(*built_in(name), method)
    assert found.unexplained == 0
    assert found.reproduced


# ---------------------------------------------------------------- views made for one cause


def mesh(name: str, vertices: Any, faces: Any) -> dict[str, Any]:
    return {"name": name, "shape": "mesh", "vertices": vertices, "faces": faces}


def lying_prism() -> View:
    """A bar with level edges at samples, at its top and its bottom.

    Of the two faces that meet at an edge the front is first at the top, and the back at the bottom.
    """
    y, z = (2.5, 0.0, -2.5, 0.0), (0.0, 1.0, 0.0, -1.0)
    vertices = [[x, y[k], z[k]] for x in (-2.0, 2.0) for k in range(4)]
    faces = []
    for a, b in ((0, 1), (0, 3), (2, 3), (1, 2)):
        faces += [[a, b, b + 4], [a, b + 4, a + 4]]
    camera = {"type": "orthographic", "eye": [0.0, 0.0, 10.0], "height": 8.0, "far": 16.0}
    return view(Scene.model_validate({"camera": [camera], "object": [mesh("bar", vertices, faces)]}), (8, 8))


def long_wedge() -> View:
    """Two sheets across 1024 samples, within 200 steps of a 24-bit buffer, that float32 holds exactly.

    Their increments differ by less than a step, so that they are rounded differently.
    """
    step, half = 2.0**-24, 512.0
    sheets = [
        mesh(name, [[-half, 0.5, -a], [-half, -0.5, -a], [half, 0.0, -b]], [[0, 1, 2]])
        for name, a, b in (
            ("one", 0.5, 0.9375 + 100 * step),
            ("other", 0.5 + 100 * step, 0.9375 - 100 * step),
        )
    ]
    camera = {"type": "orthographic", "eye": [0, 0, 0], "target": [0, 0, -1], "height": 1.0}
    scene = {"camera": [camera | {"near": 0.0, "far": 1.0}], "object": sheets}
    return view(Scene.model_validate(scene), (1024, 1))


def knot() -> View:
    """Faces of a few samples each."""
    camera = {"type": "perspective", "eye": [0.3, 0.4, 7.0]}
    thing = {"name": "knot", "shape": "torus-knot", "segments": 48, "sides": 8}
    return view(Scene.model_validate({"camera": [camera], "object": [thing]}), (64, 64))


@pytest.mark.parametrize(
    ("method", "options", "made", "cause"),
    [
        ("scanline-d16", {}, close_pair, "depth format"),
        ("scanline-w16", {}, lambda: close_pair(0.01), "depth format"),
        ("scanline-d24", {}, lambda: close_pair(0.002), "depth format"),
        ("scanline", {"depth_format": "d32f"}, lambda: close_pair(0.002), "depth format"),
        ("scanline-snap-4", {}, knot, "vertex snapping"),
        ("scanline-snap-8", {}, knot, "vertex snapping"),
        ("scanline-bottom-left", {}, lying_prism, "fill rule"),
        ("scanline-less-equal", {}, prism, "fill rule"),
        ("scanline-float32", {}, long_wedge, "depth arithmetic"),
        ("scanline-fixed", {"guard_bits": 0}, long_wedge, "depth arithmetic"),
        ("scanline-d24", {"arithmetic": "float32"}, long_wedge, "depth arithmetic"),
    ],
)
def test_each_variant_errs_by_its_own_cause(
    method: str, options: dict[str, Any], made: Callable[[], View], cause: str
) -> None:
    seen = made()
    truth = exact.render(seen, exact.Options())
    found = judged(seen, truth, method, **options)
    assert found.wrong > 0 and found.unexplained == 0 and found.reproduced
    assert found.counts[cause] > 0.5 * found.wrong
    assert judged(seen, truth, "scanline").wrong == 0


@pytest.mark.parametrize(
    ("method", "options"),
    [("scanline-float32-direct", {}), ("scanline-fixed", {"guard_bits": 12}), ("scanline-d24", {})],
)
def test_what_does_not_drift_errs_by_single_samples(method: str, options: dict[str, Any]) -> None:
    """The sheets of the wedge cross: where they are less than a step or two apart, no buffer can tell."""
    seen = long_wedge()
    found = judged(seen, exact.render(seen, exact.Options()), method, **options)
    assert found.wrong < 16


def test_all_stages_are_right_where_nothing_is_rounded_wrongly() -> None:
    """No stage of any variant errs on one large tilted triangle, seen from samples away from its edges."""
    corners = [[-3.0, -2.9, 0.3], [3.1, -2.7, -0.2], [0.2, 3.3, 0.9]]
    camera = {"type": "perspective", "eye": [0.1, 0.2, 5.0]}
    seen = view(
        Scene.model_validate({"camera": [camera], "object": [mesh("t", corners, [[0, 1, 2]])]}), (9, 9)
    )
    samples = np.flatnonzero(exact.render(seen, exact.Options()).face >= 0)
    for name in VARIANTS:
        method = methods()[name]
        pipeline = method.load_pipeline()
        assert pipeline is not None and pipeline.stages[-1].cause.label == "depth format"
        for stage in pipeline.stages:
            assert (stage.faces(seen, method.options(), samples) == 0).all(), (name, stage.cause.label)
