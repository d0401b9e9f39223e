"""The story of a sample: its verdicts, the numbers of its sentences, text and JSON alike."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms.registry import render
from hsr.base.errors import MapError, ViewError
from hsr.difference.cause import causes
from hsr.difference.history import Historian, history, window_depth
from hsr.models.llvmpipe.driver import predict
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view

PARALLEL = {"type": "orthographic", "eye": [0.0, 0.0, 10.0], "height": 8.0, "near": 0.0, "far": 16.0}
"""With 8 x 8 samples: of (row r, column c) at x = c - 3.5, y = 3.5 - r; a pixel is one unit."""

AT = {"x": 3, "y": 3}
"""At x = -0.5, y = 0.5."""


def triangle(name: str, z: float, left: float = -3.0, **keys: Any) -> dict[str, Any]:
    """A triangle that reaches from ``left`` to the right, around the middle."""
    corners = [(left, -3.0, z), (3.0, 0.0, z), (left, 3.0, z)]
    return {"shape": "mesh", "name": name, "vertices": corners, "faces": [(0, 1, 2)], **keys}


def seen_by(make_scene: Any, *objects: dict[str, Any], **camera: Any) -> View:
    return view(make_scene(list(objects), **{**PARALLEL, **camera}), (8, 8))


def shown(seen: View, method: str, face: int, depth: float = np.inf) -> VisibilityMap:
    """A map that shows one face everywhere."""
    faces = np.full((seen.height, seen.width), face, dtype=np.int32)
    return VisibilityMap(faces, np.full(faces.shape, depth), method)


def driver(seen: View) -> VisibilityMap:
    """What the modelled driver draws, without it."""
    drawn = predict(seen)
    return VisibilityMap(drawn.face, np.full(drawn.face.shape, 9.0), "opengl", notes={"driver": "llvmpipe"})


# ---------------------------------------------------------------- verdicts


def test_verdicts(make_scene: Any) -> None:
    seen = seen_by(
        make_scene,
        triangle("front", 1.0),
        triangle("behind", 0.0),
        triangle("culled", 2.0, cull="back"),
        triangle("turned", 3.0, cull="front"),
        triangle("close", 11.0),
        triangle("distant", -8.0),
        triangle("aside", 4.0, left=-0.25),
    )
    told = history(seen, [render(seen, "zbuffer")], **AT)
    verdicts = {entry.name: entry.verdicts["zbuffer"] for entry in told.entries}
    assert told.owner == "culled#0"
    assert verdicts == {
        "close#0": "clipped: in front of near",
        "turned#0": "culled",
        "culled#0": "won",
        "front#0": "lost depth to culled#0 by 1",
        "behind#0": "lost depth to culled#0 by 2",
        "distant#0": "clipped: behind far",
        "aside#0": "not covered: 0.25 px outside edge 2",
    }
    assert told.stories[0].right and told.stories[0].sentence == "zbuffer is right: it shows culled#0."


def test_a_nearer_face_is_passed_over_or_missed(make_scene: Any) -> None:
    seen = seen_by(make_scene, triangle("near", 1.0), triangle("far", 0.0))
    told = history(seen, [render(seen, "backface"), shown(seen, "raycast", -1)], **AT)
    near, far = told.entries
    assert near.verdicts == {"backface": "passed over: 1 nearer than far#0", "raycast": "missed"}
    assert far.verdicts == {"backface": "won", "raycast": "missed"}
    assert not told.stories[0].right and told.stories[0].cause == "no depth test"
    assert told.stories[0].sentence == (
        "backface shows far#0 because it paints without comparing depths (no depth test); "
        "exactly, near#0 is nearer by 1."
    )
    assert told.stories[1].cause == "unexplained"
    assert told.stories[1].sentence.endswith(
        "the sample lies 1.12 px inside edge 1 of near#0, which owns it."
    )


def test_where_no_depth_is_told_none_is_compared(make_scene: Any) -> None:
    seen = seen_by(make_scene, triangle("near", 1.0), triangle("beside", 0.0, left=1.0))
    told = history(seen, [shown(seen, "other", 1, np.nan)], **AT)
    assert told.entries[0].verdicts == {"other": "passed over for beside#0, whose depth is not told"}
    assert "nan" not in str(told)


def test_a_face_beside_the_sample_is_compared_by_each_method_s_own_depth(make_scene: Any) -> None:
    seen = seen_by(make_scene, triangle("near", 1.0), triangle("beside", 0.0, left=1.0))
    told = history(seen, [shown(seen, "one", 1, 8.0), shown(seen, "other", 1, 9.5)], **AT)
    assert told.entries[0].verdicts == {
        "one": "lost depth to beside#0 by 1",
        "other": "passed over: 0.5 nearer than beside#0",
    }


def test_a_tie_is_right_either_way(make_scene: Any) -> None:
    seen = seen_by(make_scene, triangle("one", 0.0), triangle("other", 0.0))
    told = history(seen, [shown(seen, "zbuffer", 0), shown(seen, "raycast", 1)], **AT)
    assert [story.right for story in told.stories] == [True, True]
    assert [entry.verdicts for entry in told.entries] == [
        {"zbuffer": "won", "raycast": "tie"},
        {"zbuffer": "tie", "raycast": "won"},
    ]
    assert str(told).startswith("column 3, row 3 of 8x8: owned by one#0; a tie with other#0\n")


def test_the_far_side_of_what_won_has_lost(make_scene: Any) -> None:
    seen = seen_by(make_scene, {"shape": "sphere", "name": "ball"})
    near, far = history(seen, [render(seen, "raycast")], **AT).entries
    assert (near.verdicts["raycast"], far.verdicts["raycast"]) == ("won", "lost depth to ball by 1.41")


@pytest.mark.parametrize(
    ("thing", "truth"),
    [
        (triangle("m", 1.0, cull="front"), "it is culled, and nothing covers it."),
        (triangle("m", 11.0), "it is clipped: in front of near, and nothing covers it."),
        (
            triangle("m", 1.0, left=-0.25),
            "the sample lies 0.25 px outside its edge 2, and nothing covers it.",
        ),
    ],
)
def test_what_is_not_there_is_unexplained(thing: dict[str, Any], truth: str, make_scene: Any) -> None:
    seen = seen_by(make_scene, thing)
    (story,) = history(seen, [shown(seen, "zbuffer", 0)], **AT).stories
    assert story.cause == "unexplained" and story.sentence.endswith(f"exactly, {truth}")


def test_a_face_far_from_the_sample_is_unexplained(make_scene: Any) -> None:
    seen = seen_by(make_scene, triangle("m", 1.0), triangle("far", 0.0, left=2.5))
    (story,) = history(seen, [shown(seen, "zbuffer", 1)], **AT).stories
    assert (story.name, story.cause) == ("far#0", "unexplained")
    assert story.sentence.endswith("m#0, which owns it.")


# ---------------------------------------------------------------- numbers of the driver's own


def test_snapping_moves_an_edge_across_the_sample(make_scene: Any) -> None:
    seen = seen_by(make_scene, triangle("m", 1.0, left=-0.5 + 0.25 / 256))
    (story,) = history(seen, [driver(seen)], **AT).stories
    assert story.sentence == (
        "opengl shows m#0 because after snapping to 1/256 pixel the sample lies on an edge of it "
        "(vertex snapping); exactly, the sample lies 0.000977 px outside its edge 2, and nothing covers it."
    )


def test_snapping_takes_the_sample_from_its_owner(make_scene: Any) -> None:
    # 2.5 of 6 down its left side: in sub-pixels from the sample at -0.4 + 0.95 2.5 / 6 = -0.004,
    # but at 2.5 / 6 when both ends are snapped.
    corners = [(-0.5 - 0.4 / 256, 3.0, 1.0), (-0.5 + 0.55 / 256, -3.0, 1.0), (3.0, 0.0, 1.0)]
    leaning = {"shape": "mesh", "name": "m", "vertices": corners, "faces": [(0, 1, 2)]}
    seen = seen_by(make_scene, leaning)
    told = history(seen, [driver(seen)], **AT)
    (entry,), (story,) = told.entries, told.stories
    assert entry.verdicts["opengl"] == "not covered: 0.00163 px outside after snapping to 1/256 pixel"
    assert story.sentence == (
        "opengl shows background because after snapping to 1/256 pixel the sample lies 0.00163 px "
        "outside m#0 (vertex snapping); exactly, the sample lies 1.63e-05 px inside edge 0 of m#0, "
        "which owns it."
    )


def test_equal_integers_go_to_what_is_drawn_first(make_scene: Any) -> None:
    seen = seen_by(make_scene, triangle("first", 0.0), triangle("nearer", 2.0**-22))
    told = history(seen, [driver(seen)], **AT)
    level = round(Fraction(10, 16) * (2**24 - 1))
    assert [entry.quantised for entry in told.entries] == [level, level]
    assert f"its depth is stored as {level} and that of nearer#0 as {level}, and it was drawn first" in str(
        told
    )
    assert told.stories[0].sentence.endswith("exactly, nearer#0 is nearer by 2.38e-07.")


def test_of_another_driver_nothing_is_told_but_the_stage(make_scene: Any) -> None:
    seen = seen_by(make_scene, triangle("m", 1.0, left=-0.5 + 0.25 / 256))
    (story,) = history(seen, [replace(driver(seen), notes={"driver": "another"})], **AT).stories
    assert "because coordinates on the screen are rounded (vertex snapping)" in story.sentence


def test_tessellation_is_told_with_its_distance(make_scene: Any) -> None:
    # Four sides: a square of half-diagonal 2, whose side is sqrt(2) from the middle.
    can = {
        "shape": "cylinder",
        "name": "can",
        "transform": [{"scale": 2.0}, {"translate": [-1.75, 2.0, 0.0]}],
    }
    scene = make_scene([can], **PARALLEL).model_copy(update={"segments": 4})
    seen = view(scene, (8, 8))
    (story,) = history(seen, [render(seen, "zbuffer")], **AT).stories
    # The sample is 1.25 right of and 1.5 below the middle, the side's foot at 1 and 1.
    assert story.cause == "tessellation"
    assert "the polygons of 4 sides that stand for can.cap miss the sample by 0.53 px" in story.sentence


# ---------------------------------------------------------------- many samples of a view


@pytest.mark.jit
@pytest.mark.parametrize(
    ("name", "cause"),
    [("cyclic", "no depth test"), ("solids", "tessellation"), ("near-cut", "tessellation"), ("menger", "")],
)
def test_samples_are_told_together_as_each_is_alone(name: str, cause: str, scenes: Path) -> None:
    seen = view(hsr.load(scenes / f"{name}.toml"), (60, 45))
    maps, truth = (
        [*(render(seen, name) for name in ("painter", "zbuffer")), driver(seen)],
        render(seen, "exact"),
    )
    known = {answer.method: causes(seen, answer, truth) for answer in maps}
    wrong = np.flatnonzero(np.any([why.cause > 0 for why in known.values()], axis=0))
    anywhere = np.random.default_rng(0).integers(0, truth.face.size, 20)
    samples = [*wrong[:: len(wrong) // 8 + 1].tolist(), *anywhere.tolist()]
    historian, met = Historian(seen, samples, maps, known), set()
    for sample in samples:
        together, alone = historian.tell(sample), history(seen, maps, x=sample % 60, y=sample // 60)
        assert (together.to_json(), str(together)) == (alone.to_json(), str(alone))
        met |= {story.cause for story in together.stories}
    assert cause in met


# ---------------------------------------------------------------- forms


def test_text_and_json_tell_the_same(make_scene: Any) -> None:
    things = [triangle("a", 1.0), triangle("b", 0.0), triangle("c", 2.0, left=-0.25)]
    seen = seen_by(make_scene, *things, {"shape": "sphere", "name": "ball"})
    told = history(seen, [render(seen, method) for method in ("zbuffer", "raycast", "backface")], **AT)
    facts, text = json.loads(json.dumps(told.to_json())), str(told)
    assert facts["sample"] == AT and facts["size"] == [8, 8] and facts["owner"] in text
    for face in facts["faces"]:
        assert face["name"] in text and face["facing"] in text
        assert all(f"{name} {distance:+.4g}" in text for name, distance in face["edges"].items())
        if face["covered"]:
            assert f"depth {face['depth']:.9g}  window {face['window']:.9g}  D24 {face['d24']}" in text
            assert all(verdict in text for verdict in face["verdicts"].values())
    for method in facts["methods"]:
        assert method["sentence"] in text


def test_many_misses_are_counted(make_scene: Any) -> None:
    seen = seen_by(make_scene, *(triangle(f"m{k}", 0.0, left=-0.25) for k in range(10)))
    text = str(history(seen, [], **AT))
    assert "m7#0" in text and "m8#0" not in text and "  and 2 more" in text


@pytest.mark.parametrize("far", [None, 40.0])
def test_window_depth_is_affine_on_the_screen(far: float | None, make_scene: Any) -> None:
    seen = view(make_scene([{"shape": "cube", "name": "c"}], near=0.5, far=far), (8, 8))
    assert window_depth(seen, Fraction(1, 2)) == 0
    if far is None:
        assert window_depth(seen, Fraction(1)) == Fraction(1, 2)
    else:
        assert window_depth(seen, Fraction(40)) == 1
        assert window_depth(seen, Fraction(80, 81)) == Fraction(1, 2)


def test_window_depth_of_a_parallel_view(make_scene: Any) -> None:
    assert window_depth(seen_by(make_scene, triangle("m", 0.0)), Fraction(4)) == Fraction(1, 4)


# ---------------------------------------------------------------- errors


def test_a_map_of_another_view_is_one_line(make_scene: Any) -> None:
    seen, other = seen_by(make_scene, triangle("m", 0.0)), seen_by(make_scene, triangle("m", 1.0))
    with pytest.raises(MapError, match="the map of zbuffer shows another scene; render it anew"):
        history(seen, [render(other, "zbuffer")], **AT)
    larger = replace(seen, width=9)
    with pytest.raises(MapError, match="the map of zbuffer shows another size; render it anew"):
        history(seen, [render(larger, "zbuffer")], **AT)


def test_a_sample_outside_is_one_line(make_scene: Any) -> None:
    with pytest.raises(ViewError, match="no sample at column 8, row 0: the image is 8x8, counted from 0"):
        history(seen_by(make_scene, triangle("m", 0.0)), x=8, y=0)
