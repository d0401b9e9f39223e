"""Verdicts: what was measured against what theory says."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from hsr.base.errors import MethodError
from hsr.lab.stability.building import parallel, scene_of, wall
from hsr.lab.stability.cases import family_named
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.judge import FINE, PLANTED, Result, Verdict, contradictions, judge
from hsr.mistakes.renderers import Buffer, levels, receding
from hsr.problem.view import View
from hsr.scene.model import Scene


def scene(value: float, side: int) -> Scene:
    """Two walls; how hard it gets is written into their distance."""
    return scene_of(parallel(side, 0.0, 2.0 * value), wall(1.5 * value, side), wall(value, side))


def breaks_from(limit: float) -> Variant:
    """A renderer that shows the wall behind as soon as the nearer one is so far away."""

    def shown(view: View) -> np.ndarray:
        wrong = view.far >= 2.0 * limit
        return np.full((view.height, view.width), 0 if wrong else 1, np.int32)

    return Variant("planted", None, "as planted", 2.0, mistake=shown)


def family(*variants: Variant, sweep: tuple[float, ...] = (1.0, 2.0, 4.0, 8.0, 16.0)) -> Family:
    text = "only for tests"
    return Family("made-up", "order", text, text, text, "distance", sweep, scene, variants)


def verdict(
    expected: float | None, measured: float, sweep: tuple[float, ...] = (1.0, 2.0, 4.0, 8.0, 16.0)
) -> Verdict:
    variant = replace(breaks_from(measured), breaks=expected)
    (row,) = judge(family(variant, sweep=sweep), asked=("planted",)).rows
    return row.verdict


@pytest.mark.parametrize(
    ("expected", "measured", "told"),
    [
        (None, 99.0, Verdict.HOLDS),
        (99.0, 99.0, Verdict.HOLDS),
        (None, 16.0, Verdict.EARLY),
        (4.0, 4.0, Verdict.AS_PREDICTED),
        (4.0, 2.0, Verdict.AS_PREDICTED),
        (4.0, 8.0, Verdict.AS_PREDICTED),
        (4.0, 1.0, Verdict.EARLY),
        (4.0, 16.0, Verdict.THEORY_WRONG),
        (4.0, 99.0, Verdict.THEORY_WRONG),
        (2.5, 5.0, Verdict.AS_PREDICTED),
        (2.5, 8.0, Verdict.THEORY_WRONG),
    ],
)
def test_verdicts(expected: float | None, measured: float, told: Verdict) -> None:
    assert verdict(expected, measured) == told


def test_a_break_is_narrowed_down_to_two_percent() -> None:
    (row,) = judge(family(breaks_from(5.0)), asked=("planted",)).rows
    assert 5.0 <= row.measured <= 1.02 * 5.0 and [point.value for point in row.points] == [1, 2, 4, 8, 16]


def test_without_values_between_the_next_of_the_sweep_will_do() -> None:
    """2.5 times 2 is 5: the first value from there on is 8, and no later one will do."""
    for measured, told in ((8.0, Verdict.AS_PREDICTED), (16.0, Verdict.THEORY_WRONG)):
        variant = replace(breaks_from(measured), breaks=2.5)
        (row,) = judge(replace(family(variant), continuous=False), asked=("planted",)).rows
        assert (row.verdict, row.measured) == (told, measured)


@pytest.mark.parametrize(("safe", "told"), [(4.0, "breaks early"), (3.9, "breaks as predicted")])
def test_nothing_may_be_wrong_at_a_safe_value(safe: float, told: str) -> None:
    """A break at 4 lies within the factor of 8, but exactly at what was said to be safe it is refuted."""
    variant = replace(breaks_from(4.0), breaks=8.0, safe=lambda _: safe)
    (row,) = judge(family(variant), asked=("planted",)).rows
    assert row.verdict == told


def test_sweeps_may_descend() -> None:
    def shown(view: View) -> np.ndarray:
        return np.full((view.height, view.width), 0 if view.far <= 2.0 * 2.0 else 1, np.int32)

    for expected, told in ((2.0, "breaks as predicted"), (0.5, "breaks early"), (8.0, "theory wrong")):
        variant = Variant("planted", expected, "as planted", 2.0, mistake=shown)
        (row,) = judge(family(variant, sweep=(16.0, 8.0, 4.0, 2.0, 1.0)), asked=("planted",)).rows
        assert (row.verdict, row.measured) == (told, 2.0)


def test_without_a_theory_nothing_is_contradicted() -> None:
    (row,) = judge(family(replace(breaks_from(4.0), because="")), asked=("planted",)).rows
    assert row.verdict == Verdict.NO_THEORY and row.measured == 4.0


def test_wrong_samples_are_counted_with_their_causes() -> None:
    result = judge(family(breaks_from(8.0)), quick=True, asked=("planted", "zbuffer"))
    planted, certified = result.rows
    assert [point.value for point in planted.points] == [2.0, 16.0]
    assert planted.wrong == 32 * 32 and planted.causes == {PLANTED: 1024} and planted.unexplained == 0
    assert certified.wrong == 0 and certified.verdict == Verdict.HOLDS
    assert [row.variant for _, row in contradictions([result])] == ["planted"]
    assert json.loads(json.dumps(result.to_json()))["rows"][0]["wrong"] == 1024


def test_causes_come_from_the_models_of_the_method() -> None:
    """The backface painter shows the last wall painted: here the nearer, or, turned about, the farther."""
    turned = replace(
        family(Variant("backface")),
        scene=lambda value, side: scene_of(
            parallel(side, 0.0, 2.0 * value), wall(value, side), wall(1.5 * value, side)
        ),
    )
    (row,) = judge(turned, quick=True, asked=("backface",)).rows
    assert row.causes == {"no depth test": 16} and row.wrong == 2048  # eight of each picture are traced


def test_a_refusal_is_no_wrong_sample_and_no_proof() -> None:
    variant = Variant("refuses", None, "1/w needs perspective", 2.0, "scanline", {"depth_format": "1/w"})
    (row,) = judge(family(variant), asked=("refuses",)).rows
    assert row.verdict == Verdict.REFUSED and row.verdict not in FINE
    assert row.wrong == 0 and all("parallel view" in point.refused for point in row.points)


def test_curves_are_held_to_their_factor() -> None:
    measured = replace(
        family(breaks_from(0.0)),
        figure=lambda case, wrong: case.value * 2.0 * wrong.any(),
        figure_name="figure",
    )

    def told(curve: float, excess: float = 1.0) -> Verdict:
        variant = replace(breaks_from(0.0), curve=lambda value: curve * value, excess=excess)
        result: Result = judge(replace(measured, variants=(variant,)), asked=("planted",))
        return result.rows[0].verdict

    assert told(2.0) == told(4.0) == told(1.0, excess=2.0) == Verdict.AS_PREDICTED
    assert told(1.9) == told(0.9, excess=2.0) == Verdict.EARLY and told(4.1) == Verdict.THEORY_WRONG


def test_a_buffer_one_bit_too_coarse_is_found_out() -> None:
    pairs = family_named("parallel-pair")
    (d16,) = (variant for variant in pairs.variants if variant.name == "D16 reversed")

    def told(bits: int) -> Verdict:
        variant = replace(d16, mistake=Buffer(stored=levels(bits, receding)))
        return judge(replace(pairs, variants=(variant,)), quick=True, asked=(d16.name,)).rows[0].verdict

    assert (told(16), told(15)) == (Verdict.AS_PREDICTED, Verdict.EARLY)


def test_unknown_names_are_told() -> None:
    with pytest.raises(MethodError, match="no method is named 'nobody'"):
        judge(family(), asked=("nobody",))
