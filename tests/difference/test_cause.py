"""Causes: errors planted in one stage of a method are named after that stage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import exact, raycast
from hsr.algorithms import scanline as algorithm
from hsr.algorithms.prepare import ray_tiles
from hsr.algorithms.registry import BUILT_IN, method_named
from hsr.base.errors import MapError, MethodError
from hsr.difference.cause import Causes, causes
from hsr.kernels import hierarchy
from hsr.models import scanline as models
from hsr.models.stages import Cause
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from hsr.scene.model import Scene
from hsr.scene.shapes import generic, tessellated
from tests.difference.planted import prism, soup


@pytest.fixture(scope="module")
def truth() -> VisibilityMap:
    return exact.render(soup(), exact.Options())


def named(seen: View, method: str, truth: VisibilityMap, **options: Any) -> Causes:
    """Render by the method, and ask for the causes."""
    return causes(seen, hsr.render(seen, method, **options), truth, **options)


def coarse(numbers: Any, step: float) -> Any:
    return np.rint(numbers / step) * step


def in_both(monkeypatch: pytest.MonkeyPatch, name: str, change: Callable[[Any], Any]) -> None:
    """Spoil what a function returns, for the method and for its models."""
    honest = getattr(algorithm, name)
    for module in (algorithm, models):
        monkeypatch.setattr(module, name, lambda *given: change(honest(*given)))


# ---------------------------------------------------------------- each stage is named


def test_input_rounding_is_named(truth: VisibilityMap) -> None:
    seen = soup()
    seen.__dict__["polygons"] = replace(seen.polygons, vertices=coarse(seen.polygons.vertices, 2.0**-5))
    found = named(seen, "scanline", truth)
    assert found.reproduced
    assert found.counts == {"input rounding": found.wrong} and found.wrong > 0


def test_transform_is_named(truth: VisibilityMap, monkeypatch: pytest.MonkeyPatch) -> None:
    in_both(monkeypatch, "to_clip", lambda clip: coarse(clip, 2.0**-5))
    found = named(soup(), "scanline", truth)
    assert found.counts == {"transform": found.wrong} and found.wrong > 0


def test_clipping_is_named(truth: VisibilityMap, monkeypatch: pytest.MonkeyPatch) -> None:
    nearer = [0.0, 0.0, 0.0, -0.1]
    in_both(monkeypatch, "view_volume", lambda planes: np.vstack([planes[0] + nearer, planes[1:]]))
    found = named(soup(), "scanline", truth)
    assert found.counts == {"clipping": found.wrong} and found.wrong > 0


def test_vertex_snapping_is_named(truth: VisibilityMap, monkeypatch: pytest.MonkeyPatch) -> None:
    in_both(
        monkeypatch, "screen_of", lambda screen: np.column_stack([coarse(screen[:, :2], 0.25), screen[:, 2]])
    )
    found = named(soup(), "scanline", truth)
    assert found.counts == {"vertex snapping": found.wrong} and found.wrong > 0


def test_the_fill_rule_is_named(truth: VisibilityMap, monkeypatch: pytest.MonkeyPatch) -> None:
    """The pixel corner in place of the pixel centre, for all polygons alike."""
    shift = np.array([0.5, 0.5, 0.0])
    honest = algorithm.polygon_table

    def shifted(screen: Any, *given: Any) -> Any:
        return honest(screen + shift, *given)

    for module in (algorithm, models):
        monkeypatch.setattr(module, "polygon_table", shifted)
    found = named(soup(), "scanline", truth)
    assert set(found.counts) <= {"fill rule", "depth arithmetic"}
    assert found.counts["fill rule"] > 0.9 * found.wrong > 0


def test_depth_arithmetic_is_named(truth: VisibilityMap, monkeypatch: pytest.MonkeyPatch) -> None:
    """Slopes of depth that are off: planes turn about their topmost corners."""
    steeper = np.array([1.5, 1.5, 1.0])
    in_both(monkeypatch, "polygon_table", lambda found: found._replace(plane=steeper * found.plane))
    found = named(soup(), "scanline", truth)
    assert found.counts == {"depth arithmetic": found.wrong} and found.wrong > 0


def ball() -> View:
    camera = {"type": "perspective", "eye": [0.3, 0.4, 4.0]}
    thing = {"name": "ball", "shape": "sphere"}
    scene = {"camera": [camera], "object": [thing], "segments": 12}
    return view(Scene.model_validate(scene), (32, 32))


@pytest.mark.parametrize("method", ["scanline", "opengl", "embree", "backface"])
def test_tessellation_is_named(method: str) -> None:
    """A map that shows a polyhedron in place of a sphere."""
    seen = ball()
    flat = replace(exact.render(seen.tessellated(), exact.Options()), method=method)
    found = causes(seen, flat, exact.render(seen, exact.Options()))
    assert found.counts == {"tessellation": found.wrong} and found.wrong > 0


def test_objects_out_of_reach_leave_nothing_to_judge() -> None:
    """Where only the sphere is and no polygon of it, of neither way of culling is there any left."""
    camera = {"type": "orthographic", "eye": [0.0, 0.0, 3.0], "height": 4.0, "far": 9.0}
    away = [{"scale": 0.25}, {"translate": [1.5, 1.5, 0.0]}]
    square = {"name": "square", "shape": "square", "cull": "back", "transform": away}
    things = [{"name": "ball", "shape": "sphere"}, square]
    seen = view(Scene.model_validate({"camera": [camera], "object": things, "segments": 3}), (32, 32))
    found = named(seen, "scanline", exact.render(seen, exact.Options()))
    assert found.counts == {"tessellation": found.wrong} and found.wrong > 0


def test_the_missing_depth_test_is_named(truth: VisibilityMap) -> None:
    found = named(soup(), "backface", truth)
    assert found.counts == {"no depth test": found.wrong} and found.wrong > 0


# ---------------------------------------------------------------- rays


def test_the_transform_of_rays_is_named(truth: VisibilityMap, monkeypatch: pytest.MonkeyPatch) -> None:
    honest = raycast._screen_from_world
    monkeypatch.setattr(raycast, "_screen_from_world", lambda seen: coarse(honest(seen), 0.25))
    found = named(soup(), "raycast-list", truth)
    assert found.counts == {"transform": found.wrong} and found.wrong > 0


def test_the_transform_of_tiles_is_named(truth: VisibilityMap, monkeypatch: pytest.MonkeyPatch) -> None:
    honest = ray_tiles.clip_rows
    monkeypatch.setattr(ray_tiles, "clip_rows", lambda *camera: coarse(honest(*camera), 2.0**-7))
    found = named(soup(), "raycast-plain", truth)
    assert found.counts == {"transform": found.wrong} and found.wrong > 0


def test_the_traversal_is_named(truth: VisibilityMap, monkeypatch: pytest.MonkeyPatch) -> None:
    """Extents that have shrunk to points hide what is in them."""
    honest = hierarchy.boxes_of

    def shrunk(*given: Any) -> Any:
        low, high = honest(*given)
        return (low + high) / 2.0, (low + high) / 2.0

    monkeypatch.setattr(hierarchy, "boxes_of", shrunk)
    found = named(soup(), "raycast-single", truth)
    assert found.counts == {"traversal": found.wrong} and found.wrong > 0


RAYCAST = [method.name for method in BUILT_IN if method.module == raycast.__name__ and not method.exhaustive]


@pytest.mark.jit
@pytest.mark.parametrize("method", RAYCAST)
def test_no_sample_of_any_ray_caster_is_unexplained(method: str, truth: VisibilityMap) -> None:
    for seen, true in ((soup(), truth), (away := far_away(), exact.render(away, exact.Options()))):
        found = named(seen, method, true)
        assert found.unexplained == 0 and found.reproduced


@pytest.mark.jit
def test_float32_rays_are_named_after_their_rounding() -> None:
    """Far from the origin of its own frame, a mesh is rounded; seen from afar, edge planes are."""
    seen = far_away()
    baked = seen.polygons
    placement = seen.placements[0]
    shape = replace(placement.shape, polygons=replace(baked, face=placement.shape.polygons.face))
    moved = replace(seen, placements=(replace(placement, shape=shape, world_from_object=np.eye(4)),))
    true = exact.render(moved, exact.Options())
    assert named(moved, "raycast-woop", true).wrong == 0
    assert named(moved, "raycast-woop-float32", true).counts["input rounding"] > 0
    found = named(moved, "raycast-float32", true).counts
    assert found["intersector"] > 0


@pytest.mark.jit
def test_naive_slabs_are_named_traversal() -> None:
    """Where two walls meet on a column of samples, rays graze both extents, and some are lost."""
    depth, meeting = 1.9375, -49.0 / 64.0 * 1.9375
    things = []
    for name, left, right in (("left", -2.0, meeting), ("right", meeting, 2.0)):
        vertices = [[x, y, -depth] for x, y in ((left, -2.0), (right, -2.0), (right, 2.0), (left, 2.0))]
        faces = [[0, 1, 2], [0, 2, 3]]
        things.append({"name": name, "shape": "mesh", "vertices": vertices, "faces": faces})
    matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, -0.5], [0.0, 0.0, -1.0, 0.0]]
    camera = {"type": "matrix", "matrix": matrix}
    seen = view(Scene.model_validate({"camera": [camera], "object": things}), (64, 64))
    true = exact.render(seen, exact.Options())
    assert named(seen, "raycast-single", true).wrong == 0
    found = named(seen, "raycast-naive-slabs", true)
    assert found.counts == {"traversal": 64}


@pytest.mark.parametrize("method", ["embree", "embree-packets", "embree-single"])
def test_embree_is_named_after_its_rounding(method: str) -> None:
    """Far from the origin float32 moves corners; edges that are met exactly are the intersector's."""
    pytest.importorskip("embreex")
    seen = prism()
    found = named(seen, method, exact.render(seen, exact.Options()))
    assert found.counts == {"intersector": found.wrong} and found.wrong > 0
    away = far_away()
    found = named(away, method, exact.render(away, exact.Options()))
    assert found.unexplained == 0 and found.reproduced is None
    assert {"input rounding", "transform"} <= set(found.counts)


def far_away() -> View:
    """A knot of many faces, 10^5 units from the origin."""
    away = 1e5
    camera = {"type": "perspective", "eye": [away + 0.3, 0.4, 9.0], "target": [away, 0.0, 0.0]}
    thing = {"name": "knot", "shape": "torus-knot", "segments": 32, "sides": 6}
    placed = {**thing, "transform": [{"translate": [away, 0.0, 0.0]}]}
    return view(Scene.model_validate({"camera": [camera], "object": [placed]}), (64, 64))


# ---------------------------------------------------------------- all stages together


@pytest.mark.parametrize(
    "name",
    [
        "scanline",
        "zbuffer-plain",
        "raycast-plain",
        "raycast-single",
        "opengl",
        "embree",
        "embree-packets",
        "raycast-woop-float32",
    ],
)
def test_all_models_are_right_where_rounding_decides_nothing(name: str, truth: VisibilityMap) -> None:
    seen, samples, method = soup(), np.arange(0, 48 * 48, 7), method_named(name)
    pipeline = method.load_pipeline()
    assert pipeline is not None
    for stage in pipeline.stages:
        faces = stage.faces(seen, method.options(), samples)
        assert np.array_equal(faces, truth.face.ravel()[samples]), stage.cause.label


# ---------------------------------------------------------------- what counts as wrong


def shown(*faces: int, method: str = "scanline", **more: Any) -> VisibilityMap:
    face = np.array([faces], dtype=np.int32)
    return VisibilityMap(face, np.where(face < 0, np.inf, 1.0), method, **more)


def test_nothing_wrong_has_no_cause() -> None:
    seen = prism()
    found = named(seen, "scanline", exact.render(seen, exact.Options()))
    assert (found.cause == Cause.NONE).all()
    assert found.to_json() == {
        "method": "scanline",
        "wrong": 0,
        "causes": {},
        "unexplained": 0,
        "reproduced": True,
    }


def test_one_wrong_sample_is_found_where_it_is(truth: VisibilityMap) -> None:
    seen = soup()
    answer = hsr.render(seen, "scanline")
    answer.face[20, 30] += 1
    found = causes(seen, answer, truth)
    assert np.argwhere(found.cause).tolist() == [[20, 30]]
    assert found.counts == {"unexplained": 1}
    assert found.reproduced is False


def test_a_depth_that_is_not_the_methods_is_not_reproduced(truth: VisibilityMap) -> None:
    seen = soup()
    answer = hsr.render(seen, "scanline")
    answer.depth[20, 30] *= 1.0 + 2.0**-52
    assert causes(seen, answer, truth).reproduced is False


def test_a_method_without_models_is_unexplained(truth: VisibilityMap) -> None:
    seen = soup()
    found = causes(seen, VisibilityMap(truth.face + 1, truth.depth, "somebody else's"), truth)
    assert found.unexplained == found.wrong == truth.face.size
    assert found.reproduced is None


def test_options_are_those_of_the_map(truth: VisibilityMap) -> None:
    seen = soup()
    answer = hsr.render(seen, "scanline", arithmetic="float32")
    assert causes(seen, answer, truth, arithmetic="float32").reproduced
    assert not causes(seen, answer, truth).reproduced
    with pytest.raises(MethodError, match="no option 'colour'"):
        causes(seen, answer, truth, colour="red")


def test_maps_must_fit(truth: VisibilityMap) -> None:
    seen = soup()
    with pytest.raises(MapError, match="scanline at 8x8 is no map of a view of 48x48"):
        causes(seen, hsr.render(prism(), "scanline"), truth)
    with pytest.raises(MapError, match="does not say who may own ties"):
        causes(seen, hsr.render(seen, "scanline"), hsr.render(seen, "raycast"))


# ---------------------------------------------------------------- ties of the tessellated view


def test_a_tie_of_the_tessellated_view_is_wrong_by_tessellation_alone() -> None:
    corners = tessellated(generic("cylinder"), 5).polygons
    assert corners is not None
    transform = [{"rotate_x": 71.0}, {"rotate_y": 13.0}, {"scale": 1.3}]
    drum = {"name": "drum", "shape": "cylinder", "transform": transform}
    hull = {"name": "hull", "shape": "mesh", "transform": transform}
    hull |= {"vertices": corners.vertices.tolist(), "faces": corners.triangle_vertex.tolist()}
    camera = {"type": "perspective", "eye": [0.3, 0.4, 5.0]}
    scene = Scene.model_validate({"hsr": 1, "segments": 5, "camera": [camera], "object": [drum, hull]})
    seen = view(scene, (64, 64))
    truth = method_named("exact").render(seen)
    for name in ("scanline", "scanline-direct", "zbuffer"):
        why = causes(seen, method_named(name).render(seen), truth)
        assert why.wrong > 100 and set(why.counts) == {"tessellation"}, name
