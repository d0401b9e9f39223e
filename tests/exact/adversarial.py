"""Views made to break rasterisers and ray casters: huge, tiny, thin, behind the eye, on the lattice, twice.

Each kind is a way in which published or deployed code goes wrong; each seed is one view.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hsr.base.arrays import Array, Floats
from hsr.problem.view import View, view
from tests.exact.hard import CONES, CULLS, CURVED, PLANAR, Random, cone, hard_view, loose_view, scene

Soup = tuple[Floats, Array]
"""Vertices (V, 3) and triangles (n, 3)."""


def soup(random: Random, spread: float = 1.0, n: int = 12) -> Soup:
    """Triangles anywhere, through each other."""
    return random.normal(0.0, spread, (3 * n, 3)), np.arange(3 * n).reshape(n, 3)


def huge(random: Random) -> Soup:
    """Triangles that reach far behind the eye and beyond all sides, some through the eye's plane."""
    vertices, triangles = soup(random, n=6)
    return vertices * 10.0 ** random.uniform(0.0, 6.0, (len(vertices), 1)), triangles


def slivers(random: Random) -> Soup:
    """Triangles a few ulp to a few millionths wide, whose corners are almost in line."""
    start, end = random.normal(0.0, 1.0, (2, 20, 3))
    part = random.uniform(-0.2, 1.2, (20, 1))
    off = random.normal(0.0, 1.0, (20, 3)) * 10.0 ** random.uniform(-17.0, -5.0, (20, 1))
    return np.concatenate([start, end, start + part * (end - start) + off]), np.arange(60).reshape(3, 20).T


def edge_on(random: Random) -> Soup:
    """Triangles in planes through the eye of :func:`ahead`, or within some ulp of such."""
    corner = random.normal(0.0, 1.0, (2, 12, 3))
    eye = np.array([0.0, 0.0, 4.0])
    third = eye + (corner[0] - eye) * random.uniform(0.3, 2.0, (12, 1))
    third += random.normal(0.0, 1.0, (12, 3)) * 10.0 ** random.uniform(-18.0, -12.0, (12, 1))
    return np.concatenate([*corner, third]), np.arange(36).reshape(3, 12).T


def copies(random: Random) -> Soup:
    """Triangles twice and more: turned, cut in two, moved by some ulp."""
    vertices, triangles = soup(random, n=4)
    middle = 0.5 * (vertices[triangles[:, 0]] + vertices[triangles[:, 1]])
    m = np.arange(len(middle)) + len(vertices)
    halves = [np.column_stack([triangles[:, 0], m, triangles[:, 2]]), np.column_stack([m, triangles[:, 1:]])]
    moved = np.nextafter(vertices, random.choice([-9.0, 9.0], vertices.shape))
    every = np.concatenate([vertices, middle, moved])
    return every, np.concatenate(
        [triangles, triangles[:, ::-1], *halves, triangles + len(vertices) + len(middle)]
    )


def lattice(random: Random) -> Soup:
    """Triangles with corners and edges exactly at samples of :func:`above`, in a few planes."""
    vertices = random.integers(-5, 6, (14, 3)) * np.array([0.5, 0.5, 0.25])
    return vertices, np.array([random.permutation(14)[:3] for _ in range(16)])


def crowd(random: Random) -> Soup:
    """Very many triangles in a few samples, sharing corners; most contain no sample."""
    n = 25
    x, y = np.meshgrid(np.linspace(-0.1, 0.1, n), np.linspace(-0.1, 0.1, n))
    z = random.normal(0.0, 0.02, (n, n))
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate(
        [np.column_stack([a, a + 1, a + n]), np.column_stack([a + 1, a + n + 1, a + n])]
    )
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()]), triangles


def fan(random: Random) -> Soup:
    """A closed fan about a corner that lies at a sample of :func:`above`."""
    n = int(random.integers(3, 20))
    angle = np.sort(random.uniform(0.0, 2.0 * np.pi, n))
    ring = np.column_stack([np.cos(angle), np.sin(angle), random.normal(0.0, 0.3, n)]) * random.choice(
        [0.5, 2.0]
    )
    apex = [[*random.choice([-0.5, 0.0, 0.5], 2), random.normal()]]
    around = np.arange(n)
    return np.concatenate([apex, ring]), np.column_stack([0 * around, 1 + around, 1 + (around + 1) % n])


SOUPS: tuple[Callable[[Random], Soup], ...] = (
    soup,
    huge,
    slivers,
    edge_on,
    copies,
    lattice,
    crowd,
    fan,
)


def ahead(random: Random) -> dict[str, Any]:
    """A perspective camera on the z axis; near and far often cut what is seen."""
    near = float(random.choice([2.0**-20, 0.1, 3.0, 4.0]))
    far = random.choice([near * 2.0, near + 1.0, 1e6])
    return {"type": "perspective", "eye": [0.0, 0.0, 4.0], "near": near, "far": float(far), "fov": 53.0}


def above(random: Random) -> dict[str, Any]:
    """A parallel camera whose samples are at multiples of a half if the image is 9 samples high."""
    near = float(random.choice([0.0, 2.0, 2.5]))
    far = near + float(random.choice([0.5, 2.0, 9.0]))
    return {"type": "orthographic", "eye": [0.0, 0.0, 3.0], "height": 4.5, "near": near, "far": far}


def inside(random: Random) -> dict[str, Any]:
    """A perspective camera in the middle of things."""
    eye = random.normal(0.0, 0.3, 3).tolist()
    return {"type": "perspective", "eye": eye, "near": float(random.choice([1e-6, 0.01, 0.3])), "fov": 90.0}


def adversarial(seed: int, curved: bool = False, cones: bool = False) -> View:
    """Return the view of a seed.

    Parameters
    ----------
    seed : int
    curved : bool
        Whether spheres and cylinders may be among the objects.
    cones : bool
        Whether cones may be, too.
    """
    random = np.random.default_rng([2026, seed])
    if seed % 4 == 0:
        shapes = CONES if cones else CURVED if curved else PLANAR
        return (hard_view if seed % 8 else loose_view)(seed, shapes, 9)
    objects = []
    for _ in range(random.integers(1, 3)):
        vertices, triangles = SOUPS[random.integers(len(SOUPS))](random)
        away = [0.0, 0.0, 0.0] if random.random() < 0.7 else (10.0 ** random.uniform(0, 9, 3)).tolist()
        objects.append(
            {
                "shape": "mesh",
                "vertices": vertices.tolist(),
                "faces": triangles.tolist(),
                "cull": str(random.choice(CULLS)),
                "transform": [{"scale": [float(random.choice([-1.0, 1.0])), 1.0, 1.0]}, {"translate": away}],
            }
        )
    if curved or cones:
        objects.append(_curved(random) | (cone(random) if cones else {}))
    camera = (ahead, above, inside)[random.integers(3)](random)
    if random.random() < 0.5:
        camera["eye"] = [
            e + m for e, m in zip(camera["eye"], objects[0]["transform"][1]["translate"], strict=True)
        ]
    camera["target"] = [camera["eye"][0], camera["eye"][1], camera["eye"][2] - 1.0]
    side = int(random.choice([9, 9, 13, 24]))
    return view(scene(objects, camera), (side, 9 if random.random() < 0.5 else side))


def _curved(random: Random) -> dict[str, Any]:
    """A sphere or cylinder of any proportions, on the lattice or not, near or far."""
    scale = random.choice([0.5, 1.0, 2.0, 1e-3, 1e4], 3)
    steps = [{"scale": scale.tolist()}, {"translate": (random.integers(-4, 5, 3) * 0.5).tolist()}]
    if random.random() < 0.5:
        steps.insert(1, {f"rotate_{random.choice(list('xyz'))}": float(random.uniform(0.0, 360.0))})
    return {
        "shape": str(random.choice(["sphere", "cylinder"])),
        "cull": str(random.choice(CULLS)),
        "transform": steps,
    }
