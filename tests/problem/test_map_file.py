"""Whatever is wrong in the file of a map is said in one line when it is read."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import MapError
from hsr.problem.map import VisibilityMap, load_map
from hsr.testing import modelled
from tests.damage import damaged


@pytest.fixture(scope="module")
def view() -> hsr.View:
    return hsr.view(hsr.load("scenes/coplanar.toml"), (8, 6))


@pytest.fixture(scope="module")
def arrays(view: hsr.View, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The arrays of a map that has ties, and notes of every kind."""
    truth = hsr.render(view, "exact")
    notes = {"depth_format": hsr.render(view, "zbuffer").notes["depth_format"], "driver": "llvmpipe"}
    file = tmp_path_factory.mktemp("map") / "map.npz"
    modelled(
        VisibilityMap(
            truth.face, truth.depth, "mine", {}, {}, notes, truth.manifest, truth.hashes, truth.admissible
        ),
        "float32",
        subpixel_bits=4,
    ).save(file)
    with np.load(file) as held:
        return dict(held)


@pytest.fixture
def refused(arrays: dict[str, Any], tmp_path: Path) -> Callable[..., str]:
    """Read the map with some of its arrays replaced; return why it is refused."""

    def call(**replaced: Any) -> str:
        np.savez(tmp_path / "bad.npz", **{**arrays, **replaced})
        with pytest.raises(MapError) as error:
            load_map(tmp_path / "bad.npz")
        text = str(error.value)
        assert text.startswith(f"{tmp_path / 'bad.npz'}: ") and text.count("\n") == 0
        return text.removeprefix(f"{tmp_path / 'bad.npz'}: ")

    return call


def meta(arrays: dict[str, Any], **replaced: Any) -> Any:
    return np.array(json.dumps(json.loads(str(arrays["meta"])) | replaced))


@pytest.mark.parametrize(
    ("replaced", "complaint"),
    [
        ({"notes": {"depth_format": {"stored": "window"}}}, "notes.depth_format.window.step: Field required"),
        ({"notes": {"depth_format": {"stored": "nothing", "step": 1}}}, "Extra inputs are not permitted"),
        ({"notes": {"depth_format": None}}, "notes.depth_format"),
        ({"notes": {"model": {}}}, "notes.model.model: Field required"),
        ({"notes": {"model": {"model": "float32", "subpixel_bits": [4]}}}, "notes.model.subpixel_bits"),
        ({"notes": {"driver": 7}}, "notes.driver: Input should be a valid string"),
        ({"manifest": [{"name": "a"}]}, "manifest.0.shape: Field required"),
        (
            {"manifest": [{"name": "a", "shape": "cube", "first": 0, "count": 6, "faces": ["top"]}]},
            "1 names for 6 faces",
        ),
        (
            {"manifest": 2 * [{"name": "a", "shape": "mesh", "first": 0, "count": 6}]},
            "objects 'a' and 'a' share faces",
        ),
        (
            {"manifest": [{"name": "a", "shape": "mesh", "first": 0, "count": 1}]},
            "faces from -1 to [0-9]+; there are those from 0 to 0",
        ),
        ({"hashes": {"scene": 7}}, "hashes.scene: Input should be a valid string"),
        ({"work": {"rays": "many"}}, "work.rays"),
        ({"method": None}, "method: Input should be a valid string"),
    ],
)
def test_facts_of_another_type_are_refused(
    refused: Callable[..., str], arrays: dict[str, Any], replaced: dict[str, Any], complaint: str
) -> None:
    assert re.search(complaint, refused(meta=meta(arrays, **replaced)))


def test_a_depth_format_that_makes_no_sense_is_refused(
    refused: Callable[..., str], arrays: dict[str, Any]
) -> None:
    form = {"stored": "window", "step": 1e-6, "near": 0.0, "far": None, "perspective": True}
    assert "near must be more than 0" in refused(meta=meta(arrays, notes={"depth_format": form}))
    form |= {"near": 2.0, "far": 1.0}
    assert "far must be more than near" in refused(meta=meta(arrays, notes={"depth_format": form}))


@pytest.mark.parametrize(
    ("name", "change", "complaint"),
    [
        ("tie_sample", lambda sample: sample + 1000, "not in order, or not among its 48"),
        ("tie_sample", lambda sample: sample[::-1], "not in order"),
        ("tie_sample", lambda sample: sample.astype(float), "of other types"),
        ("tie_start", lambda start: start[:-1], "do not belong"),
        ("tie_start", lambda start: start + 1, "do not belong"),
        ("tie_start", lambda start: start[:0], "do not belong"),
        ("tie_face", lambda face: face[:-1], "do not belong"),
        ("tie_face", lambda face: face + 1000, "faces from -1 to 1003; there"),
        ("tie_face", lambda face: face.astype(np.int64), "of other types"),
        ("face", lambda face: face - 1, "faces from -2"),
        ("face", lambda face: face[:0], "no samples"),
        ("face", lambda face: face.astype(">i4"), "face must be int32"),
        ("face", lambda face: face.astype(object), "Python objects, which are not read"),
        ("depth", lambda depth: depth[:-1], "must be one"),
        ("meta", lambda _: np.array("[" * 100_000), "render it again"),
        ("meta", lambda _: np.array("[1]"), "not a visibility map of version 1"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(
    refused: Callable[..., str],
    arrays: dict[str, Any],
    name: str,
    change: Callable[[Any], Any],
    complaint: str,
) -> None:
    assert re.search(complaint, refused(**{name: change(arrays[name])}))


def test_ties_that_are_not_all_there_are_refused(arrays: dict[str, Any], tmp_path: Path) -> None:
    np.savez(tmp_path / "bad.npz", **{name: held for name, held in arrays.items() if name != "tie_start"})
    with pytest.raises(MapError, match="its ties are not all there"):
        load_map(tmp_path / "bad.npz")


def used(file: Path, view: hsr.View, truth: VisibilityMap) -> bool:
    """Read a map and do with it what the package does; tell whether it was read."""
    try:
        shown = load_map(file)
        for one, other in ((shown, truth), (truth, shown), (shown, shown)):
            told = hsr.compare(one, other)
            assert told.summary(None) and json.dumps(told.to_json())
        hsr.diagnose(shown, truth)
        hsr.testing.assert_agree({"a": shown}, truth, scene=view, max_diff_pixels=1000)
        hsr.history(view, [shown], x=1, y=1).to_json()
    except hsr.HsrError as error:
        assert str(error)
        return False
    return True


def test_damaged_facts_are_read_or_refused(arrays: dict[str, Any], view: hsr.View, tmp_path: Path) -> None:
    truth = hsr.render(view, "exact")
    read = 0
    for facts in damaged(json.loads(str(arrays["meta"])), 400):
        np.savez(tmp_path / "map.npz", **{**arrays, "meta": np.array(json.dumps(facts))})
        read += used(tmp_path / "map.npz", view, truth)
    assert 10 < read < 300


def test_damaged_arrays_are_read_or_refused(arrays: dict[str, Any], view: hsr.View, tmp_path: Path) -> None:
    truth = hsr.render(view, "exact")
    chance = random.Random(0)
    names = [name for name in arrays if name != "meta"]
    for _ in range(300):
        name = chance.choice(names)
        changed = bytearray(arrays[name].tobytes())
        changed[chance.randrange(len(changed))] = chance.randrange(256)
        array = np.frombuffer(bytes(changed), arrays[name].dtype).reshape(arrays[name].shape)
        np.savez(tmp_path / "map.npz", **{**arrays, name: array})
        used(tmp_path / "map.npz", view, truth)


def test_rows_may_lie_in_the_file_in_any_order(arrays: dict[str, Any], tmp_path: Path) -> None:
    np.savez(tmp_path / "map.npz", **{**arrays, "face": np.asfortranarray(arrays["face"])})
    read = load_map(tmp_path / "map.npz")
    assert read.face.flags.c_contiguous and np.array_equal(read.face, arrays["face"])


def test_only_archives_are_opened(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.zeros(3))
    np.save(tmp_path / "b.npy", np.array([{}]), allow_pickle=True)
    for name in ("a.npy", "b.npy"):
        with pytest.raises(MapError, match=r"not a visibility map \(no .npz file\)"):
            load_map(tmp_path / name)
