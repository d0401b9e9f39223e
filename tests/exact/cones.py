"""Views of cones where the limit, the second nappe and parallel lines matter, by name."""

from __future__ import annotations

from typing import Any

from hsr.problem.view import View, view
from tests.exact.hard import scene

TOPS = (0.0, 0.5, 2.0)


def parallel(right: list[float], up: list[float], depth: list[float]) -> dict[str, Any]:
    """A parallel camera of exact rows; near is 0, far 16."""
    beyond = [*(value / 8.0 for value in depth[:3]), depth[3] / 8.0 - 1.0]
    return {"type": "matrix", "matrix": [right, up, beyond, [0.0, 0.0, 0.0, 1.0]]}


def central(right: list[float], up: list[float], depth: list[float]) -> dict[str, Any]:
    """A perspective camera of exact rows; near is 0.0625, far 16."""
    near, far = 0.0625, 16.0
    scale, offset = (far + near) / (far - near), -2.0 * far * near / (far - near)
    beyond = [*(scale * value for value in depth[:3]), scale * depth[3] + offset]
    return {"type": "matrix", "matrix": [right, up, beyond, depth]}


def cones() -> dict[str, View]:
    """Make all views."""
    made = {}
    for top in TOPS:
        # The sample in the middle looks along the generator through (1, 0, 0) and (top, 0, 1).
        across, beside = [0.5, 0.0, 0.5 - 0.5 * top, -0.5], [0.0, 0.5, 0.0, 0.0]
        turns = {"right": (across, beside), "up": (beside, across), "left": ([-x for x in across], beside)}
        for turn, (right, up) in turns.items():
            for name, camera in (
                ("parallel, upward", parallel(right, up, [0.0, 0.0, 1.0, 4.0])),
                ("parallel, downward", parallel(right, up, [0.0, 0.0, -1.0, 4.0])),
                ("from below", central(right, up, [0.0, 0.0, 1.0, 3.0])),
                ("from above", central(right, up, [0.0, 0.0, -1.0, 3.0])),
                ("from on it", central(right, up, [0.0, 0.0, 1.0, -0.5])),
            ):
                made[f"along a generator of {top}, {turn}, {name}"] = _seen(top, camera)
        apex = 1.0 / (1.0 - top)
        own = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]
        way = -1.0 if top < 1.0 else 1.0
        made[f"from the apex of {top}"] = _seen(top, central(*own, [0.0, 0.0, way, -way * apex]))
        made[f"from the second nappe of {top}"] = _seen(
            top, central(*own, [0.0, 0.0, way, -way * 2.0 * apex])
        )
        made[f"into the second nappe of {top}"] = _seen(
            top, central(*own, [0.0, 0.0, -way, way * 1.5 * apex])
        )
        flat = [[0.5, 0.0, 0.0, 0.0], [0.0, 0.0, 0.5, -0.5]]
        for cull in ("none", "back", "front"):
            made[f"across {top}, {cull}"] = _seen(top, parallel(*flat, [0.0, 1.0, 0.0, 4.0]), cull)
            made[f"along the axis of {top}, {cull}"] = _seen(top, parallel(*own, [0.0, 0.0, -1.0, 4.0]), cull)
            made[f"inside {top}, {cull}"] = _seen(top, central(*own, [0.0, 0.0, 1.0, -0.25]), cull)
    return made


def _seen(top: float, camera: dict[str, Any], cull: str = "none") -> View:
    """See a cone, and its mirror image in the plane of its base, by 5 x 5 samples."""
    cone = {"shape": "cylinder", "top": top, "cull": cull}
    return view(scene([cone, cone | {"transform": [{"scale": [1.0, 1.0, -1.0]}]}], camera), (5, 5))


CONES = cones()
