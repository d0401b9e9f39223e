"""Spheres, cylinders and cones on the screen: every bound against what is exact."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from hsr.algorithms.prepare import quadrics as quadrics
from hsr.algorithms.prepare import ray_tiles
from hsr.exact.oracle import truth
from hsr.kernels.raytiles import curved
from hsr.kernels.zbuffer.setup import ANYWHERE, CLOSEST
from hsr.problem.view import View, view
from tests.conftest import JIT
from tests.exact.hard import scene

SEEDS = 160 if JIT else 24


def alone(seed: int) -> tuple[View, str]:
    """One sphere, cylinder or cone of any proportions, seen from anywhere, cut by near and far or not."""
    random = np.random.default_rng([7, seed])
    shape, axis = random.choice(["sphere", "cylinder"]), random.choice(list("xyz"))
    scale = random.choice([1e-3, 0.3, 1.0, 2.0, 50.0], 3).tolist()
    steps = [{"scale": scale}, {f"rotate_{axis}": float(random.uniform(0.0, 360.0))}]
    steps.append({"translate": random.normal(0.0, 0.5, 3).tolist()})
    eye = random.normal(0.0, 2.0, 3)
    camera = {"eye": eye.tolist(), "target": (0.1 * eye + random.normal(0.0, 0.3, 3)).tolist()}
    camera |= {"near": float(random.choice([1e-3, 0.5, 1.5])), "far": float(random.choice([3.0, 1e3]))}
    camera |= random.choice([{"type": "perspective", "fov": 70.0}, {"type": "orthographic", "height": 4.0}])
    thing = {"shape": str(shape), "transform": steps}
    if shape == "cylinder" and seed % 2:
        thing["top"] = float(random.choice([0.0, 0.3, 1.0 - 2.0**-20, 2.0, 100.0]))
    return view(scene([thing], camera), (15, 12)), str(shape)


def prepared(seen: View):
    """Return the quadric of a view, and its eye."""
    world = ray_tiles.world_of(seen.geometry, ray_tiles.hierarchies_of(seen.geometry))
    eye = ray_tiles.eye_of(seen, world, ray_tiles.clip_matrices(seen))
    box = np.array([[0.0, seen.width, 0.0, seen.height]])
    return quadrics.quadrics_of(seen, np.array([0]), np.array([0]), box, eye)[0], eye


def hits(thing, column: float, line: float, eye):
    """Yield (piece, key depth, bound of its error, margin) of all hits of a ray."""
    for k, hit in enumerate(curved.hits_of(thing, column, line)):
        if hit.margin > -1.0:
            z, error, _ = curved.key_hit(hit, eye._replace(tie=0.0))
            yield curved.piece_of(thing, k), z, error, curved.key_hit(hit, eye).margin


@pytest.mark.parametrize("share", range(4))
def test_certain_hits_are_what_is_seen_and_within_their_bounds(share: int) -> None:
    certain = 0
    for seed in range(share, SEEDS, 4):
        seen, _ = alone(seed)
        thing, eye = prepared(seen)
        exact = truth(seen)
        for line in range(seen.height):
            for column in range(seen.width):
                found = list(hits(thing, float(column), float(line), eye))
                sure = [hit for hit in found if hit[3] >= 1.0]
                may = [hit for hit in found if -1.0 < hit[3] < 1.0]
                face, depth = exact.face[line, column], exact.depth[line, column]
                assert face >= 0 or not sure, f"seed {seed}"
                assert face < 0 or face in [hit[0] for hit in sure + may], f"seed {seed}"
                if sure and not may:
                    nearest = min(sure, key=lambda hit: hit[1])
                    certain += check(nearest, face, depth, eye)
    assert certain > (1000 if JIT else 100)


def check(nearest, face: int, depth: float, eye) -> int:
    piece, z, error, _ = nearest
    nearness = 1 / Fraction(depth) if eye.perspective else -Fraction(depth)
    key = CLOSEST + (Fraction(float(eye.closest)) - nearness) * Fraction(float(eye.scale))
    # The exact depth was rounded once to a float64.
    rounded = abs(nearness) * Fraction(float(eye.scale)) * Fraction(1, 2**52)
    assert piece == face
    assert abs(Fraction(float(z)) - key) <= Fraction(float(error)) + rounded
    return 1


@pytest.mark.parametrize("seed", range(12))
def test_coefficients_give_their_functions_within_the_bound(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    exact = []
    equation = quadrics._equation

    def noted(*arguments):
        exact.append(equation(*arguments))
        return exact[-1]

    monkeypatch.setattr(quadrics, "_equation", noted)
    seen, _ = alone(seed)
    thing, _ = prepared(seen)
    ((k, l, m),) = exact  # noqa: E741
    r = np.outer(l, l) - k * m
    # K was divided by a common number and rounded: that number is known but for a rounding.
    common = Fraction(k) / Fraction(float(thing["k"]))
    for column in range(seen.width):
        for line in range(seen.height):
            place = np.array([column, line, 1], object)
            x, y = float(column), float(line)
            for value, true, degree, size in (
                (curved.affine(thing["l"], x, y), l @ place, 1, thing["size_l"]),
                (curved.quadratic(thing["m"], x, y), place @ m @ place, 1, thing["size_m"]),
                (curved.quadratic(thing["r"], x, y), place @ r @ place, 2, thing["size_r"]),
            ):
                error = abs(Fraction(float(value)) - Fraction(int(true)) / common**degree)
                assert error <= Fraction(curved.FEW) * Fraction(float(size))


@pytest.mark.parametrize("off", [-1, 0, 1, 2, 8, 1000])
def test_roots_near_the_outline_are_within_their_bounds(off: int) -> None:
    """Where the ray is almost a tangent, R may be anything within its bound."""
    thing = np.zeros(1, curved.QUADRIC)[0]
    thing["size_r"] = thing["size_l"] = thing["size_m"] = 1.0
    r = off * curved.FEW / 2.0
    thing["k"], thing["l"][0], thing["m"][0], thing["r"][0] = 1.0, -0.5, 0.25 - r, r
    enter, leave = curved.meet_quadric(thing, 0.0, 0.0)
    assert abs(enter.margin) < 1.0 if off < 2 else enter.margin >= 1.0
    for part in (-0.9, 0.0, 0.9):
        root = np.sqrt(max(r + part * curved.FEW, 0.0))
        assert abs(0.5 + root - enter.v) <= enter.error
        assert abs(0.5 - root - leave.v) <= leave.error


def test_quotients_are_within_their_bounds() -> None:
    random = np.random.default_rng(3)
    for _ in range(2000):
        a, b = random.normal(0.0, 1.0, 2) * 10.0 ** random.uniform(-5.0, 5.0, 2)
        a_error, b_error = abs(a) * 10.0 ** random.uniform(-17, 0), abs(b) * 10.0 ** random.uniform(-17, 0.2)
        value, error = curved.quotient(a, a_error, b, b_error)
        for above in (-1, 1):
            for below in (-1, 1):
                divisor = Fraction(b) + below * Fraction(b_error)
                if error < ANYWHERE:
                    exact = (Fraction(a) + above * Fraction(a_error)) / divisor
                    assert abs(exact - Fraction(value)) <= Fraction(error)
                else:
                    assert b_error > 0.5 * abs(b)
    assert curved.quotient(1.0, 0.0, 0.0, 0.0)[1] == ANYWHERE


def test_what_is_neither_culled_nor_edge_on_is_shown() -> None:
    camera = {
        "type": "orthographic",
        "eye": [0.0, 0.0, 8.0],
        "target": [0.0, 0.0, 0.0],
        "height": 4.0,
        "far": 20.0,
    }
    for cull, shown in (("none", [1, 1]), ("back", [0, 1]), ("front", [1, 0])):
        seen = view(scene([{"shape": "cylinder", "cull": cull}], camera), (4, 4))
        assert prepared(seen)[0]["shown"].tolist() == shown
    turned = {"shape": "cylinder", "transform": [{"rotate_x": 90.0}]}
    assert prepared(view(scene([turned], camera), (4, 4)))[0]["shown"].tolist() == [0, 0]
