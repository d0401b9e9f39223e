"""What the inspector is given: every map again, and the words of the terminal."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import ViewError
from hsr.difference.classes import SampleClass
from hsr.difference.study import Study, study
from hsr.models.stages import Cause
from hsr.pages import stories as module
from hsr.pages.inspector import EMPTY, FARTHEST, FINE, inspection, key
from hsr.pages.outlines import outlines
from tests.pages.unpacking import stories_of, unpack, unpack_json


@pytest.fixture(scope="module")
def told(real: Study) -> Any:
    return inspection(real, None)


PARTS = ("index", "depth", "classes", "causes")


def of_method(scene: Any, number: int) -> dict[str, Any]:
    """Return what a method shows: laid over what it is most like, and that over the base in the end."""
    none = np.zeros(scene["size"][::-1], int)
    before = [
        {"index": unpack(scene["index"]), "depth": unpack(scene["depth"]), "classes": none, "causes": none}
    ]
    for method in scene["methods"][: number + 1]:
        samples = np.flatnonzero(np.unpackbits(unpack(method["differs"])))
        whole = {name: before[method["like"]][name].copy() for name in PARTS}
        for name in PARTS:
            whole[name].ravel()[samples] = unpack(method[name])
        before.append(whole)
    return before[-1]


def test_every_map_can_be_had_again(told: Any, real: Study) -> None:
    faces = unpack(told["faces"])
    assert unpack_json(told["manifest"]) == real.maps["exact"].manifest
    nearest, farthest = told["span"]
    for number, (name, map) in enumerate(real.maps.items()):
        shown = of_method(told, number)
        assert told["methods"][number]["name"] == name
        assert np.array_equal(faces[shown["index"]], map.face)
        differs = shown["classes"] > 0
        expected = np.where(differs, map.depth, real.maps["exact"].depth)
        seen = np.isfinite(expected)
        assert np.array_equal(shown["depth"] != EMPTY, seen)
        depth = nearest + shown["depth"][seen] / FARTHEST * (farthest - nearest)
        within = np.clip(expected[seen], nearest, farthest)
        assert depth == pytest.approx(within, abs=(farthest - nearest) / FARTHEST)


def test_classes_and_causes_can_be_had_again(told: Any, real: Study) -> None:
    assert real.causes["scanline-d16"].wrong > 0
    for number, name in enumerate(real.maps):
        if name == real.reference:
            assert told["base"] == number
            continue
        shown = of_method(told, number)
        assert np.array_equal(shown["classes"], real.differences[name].classes)
        assert np.array_equal(shown["causes"], real.causes[name].cause)
        boxes = [[*cluster.sample, *cluster.box] for cluster in real.differences[name].clusters]
        assert unpack_json(told["methods"][number]["clusters"]) == boxes


def test_every_face_that_is_shown_has_its_size(told: Any, real: Study) -> None:
    shown = np.unique(np.concatenate([map.face.ravel() for map in real.maps.values()]))
    assert unpack(told["faces"]).tolist() == shown.tolist()
    assert len(unpack(told["sizes"])) == len(shown) - 1


def test_stories_are_told_of_samples_that_differ_and_around_them(told: Any, real: Study) -> None:
    stories = stories_of(told)
    assert len(stories) == told["wanted"] and not told["untold"]
    for name, difference in real.differences.items():
        for cluster in difference.clusters[:5]:
            row, column = cluster.sample
            sentences = [text for kind, text in stories[row * real.view.width + column] if kind == "sentence"]
            assert sentences[list(real.maps).index(name)].startswith(f"{name} shows")


def test_stories_are_the_histories(told: Any, real: Study) -> None:
    for sample, lines in list(stories_of(told).items())[::16]:
        row, column = divmod(sample, real.view.width)
        known = hsr.history(real.view, list(real.maps.values()), x=column, y=row)
        assert lines == [(kind, str(said)) for kind, said in known.lines()]


def test_few_histories_are_those_the_page_leads_to(real: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "AT_ONCE", 4)
    asked = (5, 7)
    samples = {cluster.sample for found in real.differences.values() for cluster in found.clusters[:10]}
    told_of = {divmod(sample, real.view.width) for sample in stories_of(inspection(real, 0, [asked]))}
    assert told_of == samples | {asked}
    more = stories_of(inspection(real, 20))
    assert len(more) == 20 < inspection(real, 20)["wanted"]


def test_where_nothing_differs_the_middle_has_its_history(studied_alone: Study) -> None:
    assert 24 * 64 + 32 in stories_of(inspection(studied_alone))


def test_neighbours_are_wanted_too(studied: Study) -> None:
    differs = studied.differences["shifted"].classes > 0
    around = np.zeros((50, 66), bool)
    for down in (0, 1, 2):
        for right in (0, 1, 2):
            around[down : down + 48, right : right + 64] |= differs
    assert inspection(studied)["wanted"] == np.count_nonzero(around[1:-1, 1:-1])


def test_hidden_edges_are_those_of_faces_in_histories(told: Any, real: Study) -> None:
    seen = np.unique(real.maps["exact"].face)
    met = set()
    for sample in unpack(told["told"]).tolist():
        row, column = divmod(sample, real.view.width)
        met |= {entry.layer.face for entry in hsr.history(real.view, x=column, y=row).entries}
    for faces, edges in (
        (seen[seen >= 0], told["edges"]),
        (np.array(sorted(met - set(seen.tolist()))), told["hidden"]),
    ):
        points, ends = outlines(real.view, faces.astype(np.int32))
        kept = unpack(edges["points"]).T[unpack(edges["ends"]).T].tolist()
        lines = np.rint(FINE * points).astype(int)[ends].tolist()
        assert len(ends) and sorted(map(sorted, kept)) == sorted(map(sorted, lines))


def test_without_exact_answers_there_are_no_stories(studied: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    def flattened(*_: Any) -> Any:
        raise ViewError("it is flat")

    monkeypatch.setattr(module, "Historian", flattened)
    found = inspection(studied)
    assert (found["untold"], stories_of(found)) == ("it is flat", {})


def test_without_a_reference_the_first_map_is_whole(studied_alone: Study) -> None:
    found = inspection(studied_alone)
    assert (found["base"], found["judged"], found["wanted"]) == (0, False, 0)
    face = studied_alone.maps["reference"].face
    assert np.array_equal(unpack(found["faces"])[of_method(found, 1)["index"]], face)


@pytest.mark.jit
def test_causes_are_known_though_the_truth_is_no_reference(scenes: Any) -> None:
    loaded = hsr.load(scenes / "cyclic.toml")
    found = study(loaded, ["backface", "exact"], "zbuffer", (40, 40))
    assert not found.causes
    sentences = [
        text for lines in stories_of(inspection(found)).values() for kind, text in lines if kind == "sentence"
    ]
    assert any("(no depth test)" in sentence for sentence in sentences)
    assert not any("(unexplained)" in sentence for sentence in sentences)


def test_every_sign_has_its_letter_and_colour() -> None:
    for name, kinds in (("classes", SampleClass), ("causes", Cause)):
        none, *signs = key()[name]
        assert none is None and [sign["label"] for sign in signs] == [kind.label for kind in kinds if kind]
        for what in ("letter", "colour"):
            assert len({sign[what] for sign in signs}) == len(signs)


def test_an_empty_picture_can_be_inspected(studied: Study) -> None:
    map = studied.maps["reference"]
    nothing = replace(map, face=np.full_like(map.face, -1), depth=np.full_like(map.depth, np.inf))
    found = inspection(replace(studied, maps={"reference": nothing}, differences={}))
    assert unpack(found["faces"]).tolist() == [-1] and (unpack(found["depth"]) == EMPTY).all()
