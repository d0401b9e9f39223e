"""Classes of samples, clusters and verdicts, on small literal maps."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import hsr
from hsr.base.errors import MapError
from hsr.difference.classes import SampleClass, depth_step
from hsr.problem.map import Admissible, VisibilityMap, depth_format

SAME, MISSING, EXTRA, WRONG, DEPTH, TIE = SampleClass


def a_map(face: Any, depth: Any = 2.0, method: str = "a", **more: Any) -> VisibilityMap:
    """Build a map from face ids; every face at one depth unless an array is given."""
    ids = np.array(face, dtype=np.int32)
    return VisibilityMap(ids, np.where(ids < 0, np.inf, depth), method, **more)


def test_each_class() -> None:
    shown = a_map([[-1, 0, -1], [1, 1, 1]], [[0.0, 2.0, 0.0], [2.0, 2.0, 2.5]])
    reference = a_map([[-1, -1, 0], [1, 2, 1]], method="b")
    found = hsr.compare(shown, reference)
    assert found.classes.tolist() == [[SAME, EXTRA, MISSING], [SAME, WRONG, DEPTH]]
    assert found.classes.dtype == np.uint8
    assert found.counts == {"same": 2, "missing": 1, "extra": 1, "wrong face": 1, "depth only": 1, "tie": 0}
    assert found.total == 6 and found.different == 3 and not found.same


def test_depth_alone_is_no_difference() -> None:
    found = hsr.compare(a_map([[0]], 2.0), a_map([[0]], 3.0, method="b"))
    assert found.same and found.different == 0 and found.counts["depth only"] == 1
    assert found.summary() == "a vs b  1x1  0 differ; 1 depth only"


def test_a_tie_is_no_difference_where_the_reference_knows_it() -> None:
    tied = Admissible(np.array([1, 2]), np.array([0, 2, 4]), np.array([0, 1, -1, 1], dtype=np.int32))
    reference = a_map([[0, 0, 1, 1]], method="exact", admissible=tied)
    found = hsr.compare(a_map([[1, 1, -1, 1]]), reference)
    assert found.classes.tolist() == [[WRONG, TIE, TIE, SAME]]
    assert found.different == 1 and found.counts["tie"] == 2 and found.largest == 1
    assert found.summary().endswith(
        "; 2 tie\n  1 wrong face  column 0, row 0  shows unknown face 1, expected unknown face 0"
    )
    assert hsr.compare(a_map([[1, 0, 0, 1]]), reference).counts["wrong face"] == 2  # 0 may not own the third


def test_empty_maps_are_the_same() -> None:
    found = hsr.compare(a_map([[-1, -1]]), a_map([[-1, -1]]))
    assert found.same and found.depth.samples == 0 and found.depth.where is None


# ---------------------------------------------------------------- depth


def with_format(depth: float, *form: Any) -> VisibilityMap:
    return a_map([[0] * 4] * 2, depth, notes={"depth_format": depth_format(*form)})


@pytest.mark.parametrize(
    ("form", "step"),
    [
        (("window", 2.0**-24, 0.5, math.inf), 2.0**-24 * 16.0 * 2.0),
        (("window", 2.0**-24, 0.5, 8.0), 2.0**-24 * 16.0 * (2.0 - 0.125)),
        (("window", 2.0**-24, -1.0, 9.0, False), 2.0**-24 * 10.0),
        (("linear", 2.0**-16, 1.0, 9.0), 2.0**-16 * 8.0),
        (("distance", 2.0**-23, 0.1, math.inf), 2.0**-23 * 4.0),
    ],
)
def test_step_of_a_stored_depth(form: tuple[Any, ...], step: float) -> None:
    assert depth_step(with_format(4.0, *form), np.array([4.0]))[0] == pytest.approx(step, rel=1e-14)


def test_step_of_a_window_depth_is_what_rounding_does() -> None:
    near, far, depth = 0.1, 50.0, np.array([0.2, 3.0, 40.0])

    def window(d: Any) -> Any:
        return (1.0 / near - 1.0 / d) / (1.0 / near - 1.0 / far)

    step = depth_step(with_format(1.0, "window", 1e-6, near, far), depth)
    assert window(depth + step) - window(depth) == pytest.approx(np.full(3, 1e-6), rel=1e-2)


def test_depths_differ_only_beyond_rounding_of_both() -> None:
    # 4 x 2 samples: (4 + 2) / 2 = 3 steps of each map, of 2^-10 * 10 scene units each.
    form = ("window", 2.0**-10, 0.0, 10.0, False)
    allowed = 3 * 2 * 2.0**-10 * 10.0
    at = with_format(4.0, *form)
    assert hsr.compare(with_format(4.0 + allowed, *form), at).counts["depth only"] == 0
    assert hsr.compare(with_format(4.0 + 1.01 * allowed, *form), at).counts["depth only"] == 8


def test_depth_that_is_no_number_is_not_the_same() -> None:
    broken = VisibilityMap(np.zeros((1, 2), np.int32), np.array([[np.nan, np.inf]]), "broken")
    found = hsr.compare(broken, a_map([[0, 0]]))
    assert found.counts["depth only"] == 2 and found.depth.samples == 0


def test_depth_error() -> None:
    shown = a_map([[0, 0, 1, -1]], [[1.0, 1.5, 9.0, 0.0]])
    error = hsr.compare(shown, a_map([[0, 0, 2, -1]], [[1.0, 1.0, 1.0, 0.0]])).depth
    assert (error.samples, error.max, error.mean, error.where) == (2, 0.5, 0.25, (0, 1))
    assert error.rms == pytest.approx(math.sqrt(0.125))


# ---------------------------------------------------------------- clusters


def test_clusters_hang_together_over_corners() -> None:
    reference = a_map(np.zeros((4, 6)))
    shown = a_map(
        [
            [1, 0, 0, 0, 0, 0],
            [0, 1, 0, 0, 0, 2],
            [0, 0, -1, 0, 0, 2],
            [0, 0, 0, 0, 0, 0],
        ]
    )
    first, second = hsr.compare(shown, reference).clusters
    assert (first.size, first.box, first.kind, first.sample) == (3, (0, 0, 3, 3), WRONG, (0, 0))
    assert (second.size, second.box, second.shown, second.expected) == (2, (1, 5, 3, 6), 2, 0)


def test_depth_joins_no_cluster() -> None:
    shown = a_map([[1, 0, 1]], [[2.0, 5.0, 2.0]])
    found = hsr.compare(shown, a_map([[0, 0, 0]]))
    assert [cluster.size for cluster in found.clusters] == [1, 1] and found.largest == 1


def test_near_counts_faces_one_pixel_off() -> None:
    shown = a_map([[0, 0, 0, 1, 1], [0, 0, 0, 1, 7]])
    reference = a_map([[0, 0, 1, 1, 1], [0, 0, 1, 1, 1]])
    assert hsr.compare(shown, reference).near == 2  # the 7 is nowhere in the reference


def test_the_border_of_the_map_is_not_background() -> None:
    shown = a_map([[-1, 0], [0, 0]])
    assert hsr.compare(shown, a_map([[0, 0], [0, 0]])).near == 0


def test_summary_names_faces() -> None:
    manifest = [{"name": "box", "first": 0, "count": 6, "faces": ["top", "b", "r", "l", "front", "back"]}]
    shown = a_map([[4, 4, 4, -1], [4, 4, -1, 4]], manifest=manifest, method="zbuffer")
    reference = a_map([[0, 4, 4, 4], [4, 4, 4, 4]], manifest=manifest, method="opengl")
    assert hsr.compare(shown, reference).summary().splitlines() == [
        "zbuffer vs opengl  4x2  3 differ (1 wrong face, 2 missing), largest cluster 2, 1 off by one pixel",
        "  2 missing  columns 2..3, rows 0..1  shows background, expected box.front",
        "  1 wrong face  column 0, row 0  shows box.front, expected box.top",
    ]


def test_summary_names_the_largest_clusters_only() -> None:
    shown = a_map([[1, 0] * 8])
    found = hsr.compare(shown, a_map(np.zeros((1, 16))))
    assert str(found).splitlines()[-1] == "  and 3 more clusters"
    assert len(found.summary(clusters=None).splitlines()) == 9


def test_json() -> None:
    found = hsr.compare(a_map([[1, 0, -1]]), a_map([[0, 0, 0]], method="b"), truth=a_map([[1, 0, 0]]))
    told = json.loads(json.dumps(found.to_json()))
    assert told["counts"]["wrong face"] == 1 and told["size"] == [3, 1] and told["cluster_count"] == 2
    assert told["clusters"][0]["box"] == {"x": [0, 1], "y": [0, 1]}
    assert told["truth"] == {"a_right": 1, "b_right": 1, "neither": 0}


# ---------------------------------------------------------------- truth


def test_truth_tells_who_is_right() -> None:
    shown = a_map([[1, 1, 1, 1, 5]])
    reference = a_map([[2, 2, 2, 1, -1]], method="b")
    found = hsr.compare(shown, reference, truth=a_map([[1, 2, 3, 9, 5]]))
    assert found.verdict is not None
    assert (found.verdict.a_right, found.verdict.b_right, found.verdict.neither) == (2, 1, 1)
    assert found.summary().endswith("right there: a 2, b 1, neither 1")


# ---------------------------------------------------------------- errors


def test_sizes_must_agree() -> None:
    with pytest.raises(MapError, match="a at 3x1 with b at 2x1: render both at one size"):
        hsr.compare(a_map([[0, 0, 0]]), a_map([[0, 0]], method="b"))


@pytest.mark.parametrize("what", ["scene", "camera"])
def test_scene_and_camera_must_agree(what: str) -> None:
    hashes = {"scene": "1", "camera": "1"}
    other = a_map([[0]], hashes={**hashes, what: "2"})
    with pytest.raises(MapError, match=f"they show different {what}s"):
        hsr.compare(a_map([[0]], hashes=hashes), other)
    with pytest.raises(MapError, match=what):
        hsr.compare(a_map([[0]], hashes=hashes), a_map([[0]], hashes=hashes), truth=other)
    assert hsr.compare(a_map([[0]]), other).same  # a map that does not say is taken at its word


# ---------------------------------------------------------------- properties

faces = arrays(np.int32, (5, 7), elements=st.integers(-1, 3))


@given(faces, faces)
def test_classes_clusters_and_counts_agree(a: Any, b: Any) -> None:
    found, back = hsr.compare(a_map(a), a_map(b)), hsr.compare(a_map(b), a_map(a))
    assert sum(found.counts.values()) == found.total
    assert found.different == np.count_nonzero(a != b) == sum(c.size for c in found.clusters)
    assert found.near <= found.different
    assert found.counts["missing"] == back.counts["extra"] and found.different == back.different
