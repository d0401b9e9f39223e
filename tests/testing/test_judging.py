"""Verdicts: what counts, what is a tie, which cause, which limit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hsr
from hsr.base.errors import CheckError
from hsr.problem.map import Admissible, VisibilityMap, depth_format
from hsr.problem.view import View
from hsr.testing.converters import from_ids
from hsr.testing.judging import Subject, judge, subject_of
from hsr.testing.limits import Limits


def a_map(face: Any, depth: Any = 2.0, method: str = "a", **more: Any) -> VisibilityMap:
    ids = np.array(face, dtype=np.int32)
    return VisibilityMap(ids, np.where(ids < 0, np.inf, depth), method, **more)


SHOWN = a_map([[0, 1, -1, 2], [0, 1, 1, 2]])
EXPECTED = a_map([[0, 0, 0, 2], [-1, 1, 1, 2]], method="b")


def test_without_a_scene_classes_stand_for_causes() -> None:
    found = judge("mine", SHOWN, EXPECTED, Limits())
    assert found.counts == {"wrong face": 1, "missing": 1, "extra": 1} and found.counted == 3
    assert found.broken == ("max_diff_pixels=0 (default): 3 differ",) and not found.passed
    assert found.text().startswith("mine vs b, 4x2: 3 samples count as different\n")


@pytest.mark.parametrize(
    ("limits", "passed"),
    [
        ({"max_diff_pixels": 3}, True),
        ({"max_diff_pixels": 2}, False),
        ({"max_diff_ratio": 3 / 8}, True),
        ({"max_diff_ratio": 0.374}, False),
        ({"max_cluster": 3}, True),
        ({"max_cluster": 2}, False),
        ({"max_diff_pixels": 3, "max_cluster": 2}, False),
        ({"max_diff_pixels": 2, "max_cluster": 3}, False),
        ({"allow": frozenset({"wrong face", "missing", "extra"})}, True),
        ({"allow": frozenset({"wrong face", "missing"})}, False),
        ({"allow": frozenset({"wrong face"}), "max_cluster": 1}, True),
        ({"max_in_window": (2, 2)}, True),
        ({"max_in_window": (3, 2)}, False),
        ({"max_in_window": (9, 3)}, True),
        ({"max_in_window": (1, 0)}, False),
        ({"expect_diff": (3, 3)}, True),
        ({"expect_diff": (0, 2)}, False),
        ({"expect_diff": (4, 9)}, False),
    ],
)
def test_every_limit_applies(limits: dict[str, Any], passed: bool) -> None:
    # The extra sample touches the wrong one by a corner, which is what holds all three together.
    assert judge("mine", SHOWN, EXPECTED, Limits(**limits)).passed == passed


def test_the_window_with_most_is_named() -> None:
    found = judge("mine", SHOWN, EXPECTED, Limits(max_in_window=(3, 2)))
    assert found.broken == ("max_in_window=(3, 2) (default): 3 differ in the window from column 0, row 0",)


def test_what_is_expected_to_differ_must() -> None:
    found = judge("mine", EXPECTED, EXPECTED, Limits(expect_diff=(1, 5)))
    assert found.broken == ("expect_diff=(1, 5) (default): 0 differ",) and found.diagnoses == ()


def test_a_tie_never_counts() -> None:
    tied = Admissible(np.array([1, 2]), np.array([0, 2, 4]), np.array([0, 1, -1, 0], dtype=np.int32))
    truth = replace(EXPECTED, method="exact", admissible=tied)
    found = judge("mine", SHOWN, truth, Limits())
    assert found.ties == 2 and found.counted == 1 and found.counts == {"extra": 1}
    assert "2 ties, which never count" in found.text()


@given(
    st.lists(st.integers(-1, 2), min_size=12, max_size=12),
    st.lists(st.integers(-1, 2), min_size=12, max_size=12),
)
def test_every_differing_sample_is_in_one_group(shown: list[int], expected: list[int]) -> None:
    a, b = a_map(np.reshape(shown, (3, 4))), a_map(np.reshape(expected, (3, 4)))
    found = judge("mine", a, b, Limits(allow=frozenset({"missing"})))
    assert sum(found.counts.values()) == np.count_nonzero(a.face != b.face)
    assert found.counted == sum(found.counts.values()) - found.counts.get("missing", 0)


# ---------------------------------------------------------------- depths


def test_depths_are_judged_if_wanted() -> None:
    off = a_map([[0, 0]], [[2.0, 2.0 + 3 * 2.0**-51]])
    assert judge("mine", off, a_map([[0, 0]]), Limits()).passed
    assert judge("mine", off, a_map([[0, 0]]), Limits(depth_ulps=3)).passed
    (line,) = judge("mine", off, a_map([[0, 0]]), Limits(depth_ulps=2.9)).broken
    assert line == "depth_ulps=2.9 (default): 1 depths differ, most at column 1, row 0, by 3"


def test_an_ulp_is_that_of_the_judged_map() -> None:
    single = {"depth_format": depth_format("distance", 2.0**-23, 0.1, 10.0)}
    off = a_map([[0]], 2.0 + 2.0**-22, notes=single)
    assert judge("mine", off, a_map([[0]]), Limits(depth_ulps=1)).passed
    assert not judge("mine", a_map([[0]]), off, Limits(depth_ulps=1)).passed


def test_a_depth_that_is_no_number_is_beyond_any_limit() -> None:
    assert not judge("mine", a_map([[0]], np.nan), a_map([[0]]), Limits(depth_ulps=1e9)).passed


def test_depths_that_are_not_told_cannot_be_judged() -> None:
    silent = a_map([[0]], np.nan, notes={"depth_format": {"stored": "nothing"}})
    assert judge("mine", silent, a_map([[0]]), Limits()).passed
    with pytest.raises(CheckError, match="the map of a tells no depths"):
        judge("mine", silent, a_map([[0]]), Limits(depth_ulps=4))


# ---------------------------------------------------------------- causes


@pytest.fixture(scope="module")
def box(make_scene: Any) -> View:
    things = [
        {"name": "box", "shape": "cube"},
        {"name": "wall", "shape": "square", "transform": [{"scale": 2.0}]},
    ]
    return hsr.view(make_scene(things), (24, 16))


def test_the_cause_is_told_with_its_story(box: View) -> None:
    painted, truth = hsr.render(box, "backface"), hsr.render(box, "exact")
    found = judge("painted", painted, truth, Limits(), Subject(box))
    assert set(found.counts) == {"no depth test"}
    assert "    backface shows wall because it paints without comparing depths" in found.text()
    forgiven = judge("painted", painted, truth, Limits(allow=frozenset({"no depth test"})), Subject(box))
    assert forgiven.passed and "(allowed)" in forgiven.text()


def test_the_reference_may_be_what_is_wrong(box: View) -> None:
    painted, truth = hsr.render(box, "backface"), hsr.render(box, "exact")
    found = judge("mine", truth, painted, Limits(), Subject(box))
    assert set(found.counts) == {"reference wrong"}
    assert judge("mine", truth, painted, Limits(allow=frozenset({"reference wrong"})), Subject(box)).passed


@pytest.mark.jit
@pytest.mark.parametrize(
    ("how", "told", "model"),
    [
        ({"arithmetic": "float32", "subpixel_bits": 4}, {}, "float32, subpixel_bits 4"),
        (
            {"arithmetic": "float32", "subpixel_bits": 4, "fill_rule": "bottom-left"},
            {"model": "float32", "subpixel_bits": 4, "fill_rule": "bottom-left"},
            "float32, subpixel_bits 4, fill_rule bottom-left",
        ),
    ],
)
def test_a_picture_from_outside_has_causes(
    box: View, how: dict[str, Any], told: dict[str, Any], model: str
) -> None:
    truth = hsr.render(box, "exact")
    mine = from_ids(hsr.render(box, "scanline", stepping="direct", **how).face)
    found = judge("mine", mine, truth, Limits(**told), Subject(box))
    assert found.counts["vertex snapping"] >= 4 and "unexplained" not in found.counts
    assert f"  causes by the model {model}\n" in found.text() and found.diagnoses == ()
    allowed = Limits(allow=frozenset({"vertex snapping", "depth arithmetic"}), **told)
    assert judge("mine", mine, truth, allowed, Subject(box)).passed


def test_a_model_for_all_is_none_of_maps_that_have_their_own(box: View) -> None:
    painted, truth = hsr.render(box, "backface"), hsr.render(box, "exact")
    found = judge("painted", painted, truth, Limits(model="float32"), Subject(box))
    assert set(found.counts) == {"no depth test"}
    noted = from_ids(painted.face, model="backface")
    assert judge("noted", noted, truth, Limits(model="float32"), Subject(box)).counts == found.counts


@pytest.mark.jit
def test_polygons_in_place_of_curved_shapes_are_found_untold(scenes: Path) -> None:
    solids = hsr.view(hsr.load(scenes / "solids.toml"), (64, 48))
    mine = from_ids(hsr.render(solids, "zbuffer").face)
    found = judge("mine", mine, hsr.render(solids, "exact"), Limits(), Subject(solids))
    assert set(found.counts) == {"tessellation"}


def test_a_renderer_without_models_is_judged_by_class(box: View) -> None:
    truth = hsr.render(box, "exact")
    shifted = replace(truth, face=np.roll(truth.face, 1, axis=1), method="other", admissible=None)
    found = judge("mine", shifted, truth, Limits(), Subject(box))
    assert found.counts and set(found.counts) <= {"wrong face", "missing", "extra"}
    assert "exactly, " in found.text()


@pytest.mark.parametrize(
    ("undone", "words"),
    [
        (lambda face: face[::-1], "turned upside down"),
        (lambda face: face[:, ::-1], "mirrored left to right"),
        (lambda face: np.where(face >= 0, face + 1, -1), "ids 1 too high"),
        (lambda face: np.where(face > 0, face - 1, -1), "ids 1 too low"),
        (lambda face: np.roll(face, 1, axis=1), "shifted by (1, 0)"),
    ],
)
def test_common_mistakes_of_reading_are_named(box: View, undone: Any, words: str) -> None:
    truth = hsr.render(box, "exact")
    wrong = replace(truth, face=undone(truth.face).astype(np.int32), admissible=None)
    assert f"  diagnosis: {words}: explains " in judge("mine", wrong, truth, Limits()).text()


def test_a_map_of_other_faces_is_refused(box: View) -> None:
    other = replace(
        hsr.render(box, "exact"), manifest=[{"name": "x", "shape": "mesh", "first": 0, "count": 1}]
    )
    with pytest.raises(CheckError, match="other faces than the scene; leave 'scene' out"):
        subject_of(box, None, other)
    with pytest.raises(CheckError, match="has 2x1 samples and the view 24x16; render it at that size"):
        subject_of(box, None, a_map([[0, 0]]))
    with pytest.raises(CheckError, match="scene must be a scene, its file or a view, not int"):
        subject_of(3, None, other)  # type: ignore[arg-type]
