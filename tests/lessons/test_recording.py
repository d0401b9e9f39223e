"""What is recorded is what the methods do: every track of every lesson, replayed, is the method's own map."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import hsr
from hsr.algorithms.prepare.depth_formats import depths_of
from hsr.algorithms.registry import method_named
from hsr.base.errors import MethodError
from hsr.kernels import rays, scanline
from hsr.lessons import recording
from hsr.lessons.lesson import asked, record_by, view_of
from hsr.lessons.listing import python_of
from hsr.lessons.probes import Look
from hsr.lessons.recording import Recording, interpreted, record
from hsr.lessons.topics import Track, topics
from hsr.problem.map import VisibilityMap

TRACKS = [
    pytest.param(track, method, id=f"{name}-{k}-{method}")
    for name, topic in topics().items()
    for k, track in enumerate(topic.track)
    for method in track.methods
]


def recorded(track: Track, method: str) -> tuple[Recording, VisibilityMap]:
    """Return a recording, and the answer of the compiled method."""
    view = view_of(track)
    found = record_by(view, method_named(method), track.options)
    return found, hsr.render(view, method, **track.options)


def replayed(found: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Return faces and depths after all writes."""
    shape = found.answer.face.shape
    face, depth = np.full(shape, -1), np.full(shape, np.inf)
    for step in found.steps:
        for sample, owner, stored in step.writes:
            face.flat[sample], depth.flat[sample] = owner, stored
    return face, depth


@pytest.mark.parametrize(("track", "method"), TRACKS)
def test_the_recording_ends_with_the_methods_own_map(track: Track, method: str) -> None:
    found, answer = recorded(track, method)
    face, depth = replayed(found)
    np.testing.assert_array_equal(face, answer.face)
    np.testing.assert_array_equal(found.answer.face, answer.face)
    np.testing.assert_array_equal(found.answer.depth, answer.depth)
    if method in ("zbuffer", "zbuffer-plain") or method.startswith("raycast"):
        np.testing.assert_array_equal(depth, answer.depth)
    else:
        # What the buffer holds stands for these depths.
        view = view_of(track)
        options = method_named(method).options(**track.options)
        formats = depths_of(options.depth_format if method != "backface" else "float64", None, view, 0.0)
        np.testing.assert_array_equal(formats.distance(depth, answer.face), answer.depth)


def test_the_recording_is_not_the_map_of_another_method() -> None:
    track = topics()["culling"].track[1]
    found, _ = recorded(track, "backface")
    assert (replayed(found)[0] != hsr.render(view_of(track), "exact").face).any()


@pytest.mark.parametrize(
    ("topic", "counts"),
    [
        (
            "depth-buffer",
            {"scan lines": "scan_lines", "fragments tested": "fragments", "written": "depth_passed"},
        ),
        ("ray-casting", {"rays": "rays", "extents tested": "extent tests", "hits": "hits"}),
        ("ray-casting", {"faces or shapes tested": "face tests"}),
    ],
)
def test_counters_are_the_work_that_the_method_counts(topic: str, counts: dict[str, str]) -> None:
    track = topics()[topic].track[0]
    found, _ = recorded(track, track.methods[0])
    work = hsr.render(view_of(track), track.methods[0], count=True).work
    lines = [step.line for step in found.steps]
    for shown, counted in counts.items():
        assert lines.count(found.counters[shown]) == work[counted] > 0


def test_turns_are_the_samples_in_the_order_of_the_method() -> None:
    track = topics()["ray-casting"].track[0]
    found, answer = recorded(track, "raycast-extents")
    assert [turn.sample for turn in found.turns] == list(range(16 * 12))
    assert [turn.owner for turn in found.turns] == answer.face.ravel().tolist()


def test_a_fragment_competes_with_the_face_in_the_buffer() -> None:
    track = topics()["depth-buffer"].track[0]
    found, answer = recorded(track, "scanline")
    contested = [turn for turn in found.turns if len(turn.faces) == 2]
    assert {turn.owner for turn in contested} == {0, 1}
    assert all(turn.owner == answer.face.flat[turn.sample] for turn in contested)


def test_values_are_those_after_the_step() -> None:
    track = topics()["depth-buffer"].track[0]
    found, _ = recorded(track, "scanline")
    name = {slot: name for slot, (_, name) in enumerate(found.slots)}
    z = z_across = None
    steps = 0
    for step in found.steps:
        changed = {
            name[slot]: value for slot, value in step.changes if found.slots[slot][0] == "scan_polygon"
        }
        if found.listing.text[step.line].strip() == "z -= z_across":
            steps += 1
            assert changed["z"] == z - z_across
        z, z_across = changed.get("z", z), changed.get("z_across", z_across)
    assert steps > 100


def test_kernels_are_compiled_again_afterwards() -> None:
    before = scanline.draw, rays.cast
    with interpreted():
        assert scanline.draw is python_of(before[0])
    assert (scanline.draw, rays.cast) == before


def test_kernels_and_trace_function_come_back_after_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "MOST_STEPS", 100)
    before, tracing = scanline.draw, sys.gettrace()
    with pytest.raises(MethodError, match="more than 100 steps are too many"):
        recorded(topics()["depth-buffer"].track[0], "scanline")
    assert scanline.draw is before and sys.gettrace() is tracing


def test_questions_are_about_turns_of_either_outcome() -> None:
    track = topics()["depth-buffer"].track[0]
    found, _ = recorded(track, "scanline")
    chosen = asked(found.turns, 6)
    assert sorted(turn.owner for turn in chosen) == [0, 0, 0, 1, 1, 1]
    assert chosen == sorted(set(chosen)) and asked([], 6) == []


def test_the_picture_is_not_wiped_when_a_tile_is_done() -> None:
    found, _ = recorded(topics()["certified"].track[0], "zbuffer")
    assert not [step for step in found.steps if any(owner < 0 for _, owner, _ in step.writes)]


def test_a_probe_that_watches_what_is_not_there_is_refused() -> None:
    seen, method = view_of(topics()["depth-buffer"].track[0]), method_named("scanline")
    probe = method.load_probe()(seen, method.options())
    drawn = scanline.draw
    for broken, said in (
        ({"shown": {drawn: ("face", "stord")}}, "draw has no variable 'stord', which a lesson watches"),
        ({"buffers": {drawn: Look("j")}}, "draw has no variable 'j'"),
        ({"counters": {"tests": (drawn, "stord =")}}, "no statement of draw begins with 'stord ='"),
    ):
        with pytest.raises(MethodError, match=said):
            record(seen, method, probe._replace(**broken))


def test_a_method_without_a_probe_cannot_be_recorded() -> None:
    with pytest.raises(MethodError, match="exact cannot be recorded: its row names no probe"):
        recorded(topics()["depth-buffer"].track[0], "exact")
