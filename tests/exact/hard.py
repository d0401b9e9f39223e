"""Small views made to be hard: everything on a coarse grid, so that ties are the rule."""

from __future__ import annotations

from typing import Any

import numpy as np

from hsr.problem.view import View, view
from hsr.scene.model import Scene

CULLS = ("none", "none", "none", "back", "front")

Random = np.random.Generator


def scene(objects: list[dict[str, Any]], camera: dict[str, Any], segments: int = 6) -> Scene:
    named = [{"name": f"object {k}", **thing} for k, thing in enumerate(objects)]
    return Scene.model_validate({"camera": [camera], "object": named, "segments": segments})


def on_grid(random: Random, low: int, high: int, shape: Any = (), step: float = 0.5) -> Any:
    """Random multiples of ``step`` from low to high."""
    return (random.integers(low, high, shape, endpoint=True) * step).tolist()


def parallel(random: Random) -> dict[str, Any]:
    """A parallel camera whose samples lie on the grid of the world; near and far may touch faces."""
    near = on_grid(random, -2, 4)
    return {
        "type": "orthographic",
        "eye": [0.0, 0.0, 3.0],
        "height": 4.0,
        "near": near,
        "far": near + on_grid(random, 2, 12),
    }


def central(random: Random) -> dict[str, Any]:
    """A perspective camera of whole numbers, x_clip = x and w_clip = 3 - z; its eye may be inside."""
    near = float(random.choice([0.5, 1.0, 2.0]))
    reach = near * float(random.choice([2.0, 4.0, 64.0]))
    a, b = (near + reach) / (near - reach), 2.0 * near * reach / (near - reach)
    shift = on_grid(random, -1, 1, 2)
    matrix = [
        [1.0, 0.0, 0.0, shift[0]],
        [0.0, 1.0, 0.0, shift[1]],
        [0.0, 0.0, a, b - 3.0 * a],
        [0.0, 0.0, -1.0, 3.0],
    ]
    return {"type": "matrix", "matrix": matrix}


def placing(random: Random) -> list[dict[str, Any]]:
    """Quarter turns, small moves, a mirror, a shear: all on the grid."""
    steps: list[dict[str, Any]] = []
    if random.random() < 0.4:
        steps.append({f"rotate_{random.choice(list('xyz'))}": float(random.choice([90.0, 180.0, 270.0]))})
    if random.random() < 0.4:
        steps.append({"scale": [float(x) for x in random.choice([-1.0, 0.5, 1.0, 2.0], 3)]})
    if random.random() < 0.2:
        shear = np.eye(4)
        shear[tuple(random.permutation(3)[:2])] = random.choice([-1.0, 0.5, 1.0])
        steps.append({"matrix": shear.tolist()})
    if random.random() < 0.7:
        steps.append({"translate": on_grid(random, -3, 3, 3)})
    return steps


def mesh(random: Random, flat: bool) -> dict[str, Any]:
    """A few triangles over few vertices: shared edges, folds and flat ones among them."""
    vertices = np.array(on_grid(random, -3, 3, (5, 3)))
    if flat:
        vertices[:, 2] = vertices[:, :2] @ random.choice([0.0, 0.5, 1.0], 2)
    faces = [random.permutation(5)[:3].tolist() for _ in range(3)]
    return {"shape": "mesh", "vertices": vertices.tolist(), "faces": faces}


TOPS = (0.0, 0.0, 0.5, 2.0, 3.0, 1.0 - 2.0**-53)


def cone(random: Random) -> dict[str, Any]:
    return {"shape": "cylinder", "top": float(random.choice(TOPS))}


def thing(random: Random, shapes: tuple[str, ...]) -> dict[str, Any]:
    shape = str(random.choice(shapes))
    what = mesh(random, shape == "flat") if shape in ("mesh", "flat") else {"shape": shape}
    if shape == "cone":
        what = cone(random)
    return {**what, "cull": str(random.choice(CULLS)), "transform": placing(random)}


def hard_view(seed: int, shapes: tuple[str, ...], side: int = 4) -> View:
    """A view of one to four objects, often with a copy of one of them."""
    random = np.random.default_rng(seed)
    objects = [thing(random, shapes) for _ in range(random.integers(1, 4))]
    if random.random() < 0.3:
        objects.append(dict(objects[0], cull="none"))
    camera = parallel(random) if random.random() < 0.5 else central(random)
    size = side if random.random() < 0.7 else side + 1
    return view(scene(objects, camera), (size, size))


PLANAR = ("square", "cube", "mesh", "flat")
CURVED = ("sphere", "cylinder", "square", "sphere", "cylinder", "flat")
CONES = ("cone", "cone", "cone", "cylinder", "sphere", "square", "flat")


def loose_view(seed: int, shapes: tuple[str, ...], side: int = 4) -> View:
    """A view of objects anywhere, by a camera anywhere."""
    random = np.random.default_rng(seed)
    objects = []
    for _ in range(random.integers(1, 5)):
        what = thing(random, shapes)
        if "vertices" in what:
            what["vertices"] = random.normal(0.0, 1.0, (5, 3)).tolist()
        turns = [{f"rotate_{axis}": float(random.uniform(0, 360))} for axis in "xyz"]
        objects.append({**what, "transform": [*turns, {"translate": random.normal(0.0, 0.7, 3).tolist()}]})
    camera = {"type": "perspective", "eye": random.normal(0.0, 2.0, 3).tolist(), "fov": 60.0, "near": 0.25}
    return view(scene(objects, camera), (side, side))
