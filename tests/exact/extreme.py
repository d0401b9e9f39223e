"""Views at the ends of float64: where numbers over- or underflow, or near and far are all but equal."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np
from pydantic import ValidationError

from hsr.base.errors import ViewError
from hsr.problem.view import View, view
from hsr.scene.model import Scene
from tests.exact.hard import CULLS, Random, scene

POWERS = (-320, -310, -305, -300, -150, -30, 0, 0, 30, 150, 300)
"""Lengths are of the order of these powers of ten."""

SIZES = ((9, 9), (9, 9), (7, 5), (1, 1), (1, 9), (9, 1), (1, 200), (600, 1))
"""Width and height of the images."""


def power(exponent: float) -> float:
    """Return a power of ten that float64 has."""
    return float(10.0 ** np.clip(exponent, -322.0, 307.0))


def extreme(seed: int, curved: bool = False, cones: bool = False) -> View:
    """Return the view of a seed, with spheres and cylinders among the objects or without, or with cones."""
    random = np.random.default_rng([77, seed])
    while True:
        width, height = SIZES[random.integers(len(SIZES))]
        make = (far_off, scaled, scaled)[random.integers(3)]
        # Some are too extreme for any method.
        with suppress(ValidationError, ViewError):
            seen = make(random, curved or cones)
            return view(_tapered(seen, random) if cones else seen, (width, height))


def _tapered(seen: Scene, random: Random) -> Scene:
    """Taper the cylinders of a scene, by anything float64 has."""
    change = {"top": float(random.choice([0.0, 5e-324, 1e-200, 2.0**-53, 0.1, 1.0 + 2.0**-52, 1e17, 1e150]))}
    things = (
        thing.model_copy(update=change) if thing.shape == "cylinder" else thing for thing in seen.object
    )
    return seen.model_copy(update={"object": tuple(things)})


def thing(random: Random, exponent: float, curved: bool) -> dict[str, Any]:
    """An object about the origin, of one order of magnitude or anywhere beside it."""
    shapes = ["mesh", "mesh", "square", "cube"] + (["sphere", "cylinder"] * 2 if curved else [])
    what: dict[str, Any] = {"shape": str(random.choice(shapes))}
    if what["shape"] == "mesh":
        vertices = random.normal(0.0, 1.0, (9, 3))
        vertices[4] = vertices[3] if random.random() < 0.2 else vertices[4]
        vertices[8] = vertices[6:8].mean(axis=0) if random.random() < 0.2 else vertices[8]
        what |= {"vertices": vertices.tolist(), "faces": np.arange(9).reshape(3, 3).tolist()}
    beside = random.choice([0, 0, 0, -300, -150, -20, -9, -3, 3, 9, 20, 150, 300])
    away = float(random.choice([0.0, 0.5, -1.0, -1e3, -1e9, 5.0])) * power(min(exponent, 297.0))
    steps = [{"scale": [power(exponent + beside)] * 3}, {"translate": [0.0, 0.0, away]}]
    if random.random() < 0.5:
        steps.insert(0, {"rotate_x": float(random.uniform(0.0, 360.0))})
    return {**what, "cull": str(random.choice(CULLS)), "transform": steps}


def things(random: Random, exponent: float, curved: bool) -> list[dict[str, Any]]:
    return [thing(random, exponent, curved) for _ in range(random.integers(1, 4))]


def far_off(random: Random, curved: bool) -> Any:
    """A matrix camera at up to 10^9 from the origin, of rows of any length and any aspect."""
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    eye = random.normal(size=3) * 10.0 ** random.integers(0, 10)
    right, up, depth = (np.append(axis, -axis @ eye) for axis in axes)
    near = np.array([0.0, 0.0, 0.0, 10.0 ** random.integers(-8, 1)])
    matrix = np.stack([right * 10.0 ** random.choice([-6, 0, 0, 6]), up, depth - 2.0 * near, depth])
    matrix *= 10.0 ** random.choice([0.0, random.uniform(-3.0, 3.0), 100.0, -100.0, 290.0, -290.0])
    objects = things(random, 0.0, curved)
    for one in objects:
        one["transform"].append({"translate": eye.tolist()})
    return scene(objects, {"type": "matrix", "matrix": matrix.tolist()})


def scaled(random: Random, curved: bool) -> Any:
    """A camera in front of things of one order of magnitude; near and far are of another, or almost one."""
    exponent = float(random.choice(POWERS))
    unit = power(exponent)
    near = max(float(random.choice([1e-300, 1e-20, 1e-3, 0.1, 3.0, 4.0])) * unit, 5e-324)
    far = near * float(random.choice([1.0 + 2.0**-52, 1.0 + 2.0**-50, 2.0, 1e12]))
    camera: dict[str, Any] = {"eye": [0.0, 0.0, 4.0 * unit], "target": [0.0, 0.0, unit], "near": near}
    camera["far"] = float(random.choice([max(far, np.nextafter(near, 1.0)), max(1e308, 2.0 * near)]))
    if random.random() < 0.5:
        fov = float(random.choice([1e-9, 1e-3, 53.0, 90.0, 170.0]))
        camera |= {"type": "perspective", "fov": fov, "near": near}
    else:
        camera |= {"type": "orthographic", "height": 4.5 * unit}
        camera["near"] = float(random.choice([near, -near, 0.0]))
    return scene(things(random, exponent, curved), camera)


# ---------------------------------------------------------------- one by one


def by_perspective(objects: list[dict[str, Any]], **camera: Any) -> View:
    """Things seen in 9 x 9 samples from (0, 0, 4), along -z."""
    seen_by = {"type": "perspective", "eye": [0.0, 0.0, 4.0], "target": [0.0, 0.0, 0.0], "fov": 53.0}
    return view(scene(objects, {**seen_by, **camera}), (9, 9))


def triangle(corners: list[list[float]], scale: float = 1.0, z: float = 0.0) -> dict[str, Any]:
    steps = [{"scale": [scale] * 3}, {"translate": [0.0, 0.0, z]}]
    return {"shape": "mesh", "vertices": corners, "faces": [[0, 1, 2]], "transform": steps}


SLANTED = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.2], [0.0, 1.0, -0.1]]

WIDE = [[-9.0, -9.0, -1.0], [9.0, -9.0, -1.0], [0.0, 9.0, -1.0]]

NEAR_BY = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, -2e-310], [0.0, 0.0, -1.0, 0.0]]

NARROW = [[1e170, 0.0, 0.0, 0.0], [0.0, 1e170, 0.0, 0.0], [0.0, 0.0, -1.0, -0.2], [0.0, 0.0, -1.0, 0.0]]

BALL = {"shape": "sphere", "transform": [{"scale": [0.5e-170] * 3}, {"translate": [0.0, 0.0, -1.0]}]}

EXTREME = {
    "one depth between near and far": lambda: by_perspective(
        [triangle(SLANTED)], near=1.99, far=float(np.nextafter(1.99, 9.0))
    ),
    "one thing near, one all but infinitely far": lambda: by_perspective(
        [triangle(SLANTED, 0.01, 3.8), triangle(WIDE, 1e16)], near=0.1
    ),
    "a plane next to the eye": lambda: by_perspective(
        [triangle([[-9.0, -1e-310, 9.0], [9.0, -1e-310, 9.0], [0.0, -1e-310, -9.0]])],
        eye=[0.0, 0.0, 0.0],
        target=[0.0, 0.0, -1.0],
    ),
    "tiny": lambda: by_perspective([triangle(SLANTED, 1e-200)], eye=[0.0, 0.0, 4e-200], near=1e-201),
    "all but zero": lambda: by_perspective([triangle(SLANTED, 1e-310)], eye=[0.0, 0.0, 4e-310], near=1e-311),
    "a near plane all but at the eye": lambda: view(
        scene([triangle(SLANTED, z=-1.0)], {"type": "matrix", "matrix": NEAR_BY}), (9, 9)
    ),
    "huge": lambda: by_perspective([triangle(SLANTED, 1e300)], eye=[0.0, 0.0, 4e300], near=1e299),
    "beyond all numbers on the screen": lambda: by_perspective(
        [triangle(SLANTED), triangle(WIDE, 1e305)], near=0.1, fov=1e-3
    ),
    "all behind the eye": lambda: by_perspective([triangle(SLANTED, 1e150, 1e160)]),
    "flat at the eye, and wide": lambda: by_perspective(
        [triangle([[-9e20, -9e20, 2e-290], [9e20, -9e20, 1e-290], [0.0, 9e20, -1e-290]])],
        eye=[0.0, 0.0, 0.0],
        target=[0.0, 0.0, -1.0],
        near=1e-300,
    ),
    "a ball whose square angle underflows": lambda: view(
        scene([BALL], {"type": "matrix", "matrix": NARROW}), (9, 9)
    ),
}
"""Views by name."""
