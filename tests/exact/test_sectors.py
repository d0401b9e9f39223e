"""Samples at which only triangles meet, against the general decision."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from hsr.exact import sectors
from hsr.exact.decide import Piece, decide
from hsr.exact.infinitesimals import NOTHING, Surd, affine, constant
from hsr.exact.sectors import Corner, decide_flat

FULL = Corner(0, 7, 0, (Fraction(0), Fraction(0)), [])


def as_piece(corner: Corner, number: int) -> Piece:
    """What a corner stands for at the sample (0, 0), where greater zeta is farther."""
    a, b = (int(12 * share) for share in corner.slope)
    zeta = Surd(affine([a, b, 12 * corner.level]), NOTHING, NOTHING, constant(12))
    extent = tuple(affine([*edge, 0]) for edge in corner.edges)
    return Piece(corner.face, (a, b, corner.level), zeta, extent, number=number)


def test_by_hand() -> None:
    assert decide_flat([FULL]) == (0, {7})
    right, left = FULL._replace(edges=[(1, 0)]), FULL._replace(number=1, face=8, edges=[(-1, 0)])
    assert decide_flat([left]) == (-1, {8, -1})
    assert decide_flat([left, right]) == (0, {7, 8})
    # Its plane rises to the right and upwards: it is hidden to the right, and seen to the left.
    steep = FULL._replace(number=2, face=3, slope=(Fraction(1), Fraction(1)))
    assert decide_flat([FULL, steep]) == (0, {3, 7})
    assert decide_flat([FULL, steep._replace(level=1)]) == (0, {7})
    # The lowest face owns where planes coincide.
    assert decide_flat([FULL, FULL._replace(number=1, face=2)]) == (1, {2, 7})
    # An edge along a row of samples: what lies below owns them.
    above, below = FULL._replace(edges=[(0, 3)]), FULL._replace(number=1, face=8, edges=[(0, -2)])
    assert decide_flat([above, below]) == (1, {7, 8})
    # Two half-planes that share their line only are nowhere.
    assert decide_flat([FULL._replace(edges=[(1, 0), (-1, 0)])]) == (-1, {-1})


@pytest.mark.parametrize("seed", range(150))
def test_it_says_what_the_general_decision_says(seed: int) -> None:
    random = np.random.default_rng(seed)

    def edges() -> list[tuple[int, int]]:
        few = random.integers(-3, 4, size=(random.integers(4), 2)).tolist()
        return [(a, b) for a, b in few if a or b]

    def slope() -> Fraction:
        return Fraction(int(random.integers(-3, 4)), int(random.choice([1, 2, 3])))

    corners = [
        Corner(k, int(random.integers(5)), int(random.integers(3)), (slope(), slope()), edges())
        for k in range(random.integers(1, 7))
    ]
    owner, admissible = decide_flat(corners)
    expected, among = decide([as_piece(corner, k) for k, corner in enumerate(corners)], 0, 0, -1)
    assert admissible == among
    assert (owner < 0) == (expected < 0)
    assert owner < 0 or corners[owner].face == corners[expected].face


def test_the_work_at_the_apex_of_a_fan_grows_with_its_triangles(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []
    honest = sectors._along
    monkeypatch.setattr(sectors, "_along", lambda *of: asked.append(of) or honest(*of))

    def work(n: int) -> int:
        asked.clear()
        ring = [(k, n - k) for k in range(n)] + [(n - k, -k) for k in range(n)]
        spokes = [*ring, *((-x, -y) for x, y in ring)]
        fan = [
            Corner(k, k, 0, (Fraction(k), Fraction(1)), [(y, -x), (-v, u)])
            for k, ((x, y), (u, v)) in enumerate(zip(spokes, [*spokes[1:], spokes[0]], strict=True))
        ]
        owner, admissible = decide_flat(fan)
        assert len(admissible) == len(fan) and owner >= 0
        return len(asked)

    assert work(40) <= 2.1 * work(20)
