"""What is in a scene: objects, faces, bounds, cameras, and where culling would change nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, cast

import numpy as np

from hsr.base.arrays import Floats
from hsr.scene.camera import Projection, eye_of, named_projection
from hsr.scene.files import shape_of
from hsr.scene.model import Camera, Object, Scene
from hsr.scene.shapes import Kind, Polygons, Shape
from hsr.scene.solids import surface_problem, winding_number
from hsr.scene.transforms import copies


def describe(scene: Scene, size: tuple[int, int] = (512, 512)) -> dict[str, Any]:
    """Describe a scene in JSON values.

    Parameters
    ----------
    scene : Scene
    size : (width, height)
        Image size in pixels: the fields of view depend on its proportions.

    Returns
    -------
    dict
        ``title``, ``about``, ``size``, ``totals`` and ``bounds`` (``low``, ``high``: world corners of
        the extent); ``cameras``, each with ``name``, ``type``, ``near``, ``far`` (None: infinite) and
        ``fov_x``, ``fov_y`` in degrees, or ``width``, ``height`` in scene units for a parallel one;
        ``objects``, each with ``name``, ``shape``, ``copies``, ``faces`` (of one copy), ``cull``,
        ``bounds``, ``cut`` (faces of the file cut into triangles), ``concave`` (of those, not as fans),
        and ``culling``: for each camera why
        removing its back faces may change the picture, empty if it changes nothing.

    Raises
    ------
    SceneError, ViewError
        If a shape or a camera cannot be used.
    """
    projections = {camera.name: named_projection(camera, size[0] / size[1]) for camera in scene.camera}
    # Objects often share a shape, and its surface takes longest.
    problem_of = cache(_surface_problem)
    objects = [_object(thing, scene, projections, problem_of) for thing in scene.object]
    return {
        "title": scene.title,
        "about": scene.about,
        "size": list(size),
        "totals": {
            "objects": len(objects),
            "copies": sum(entry["copies"] for entry in objects),
            "faces": sum(entry["copies"] * entry["faces"] for entry in objects),
        },
        "bounds": _box(np.array([[entry["bounds"]["low"], entry["bounds"]["high"]] for entry in objects])),
        "cameras": [_camera(camera, projections[camera.name]) for camera in scene.camera],
        "objects": objects,
    }


def lines(found: dict[str, Any]) -> list[str]:
    """Return what :func:`describe` found as lines for people."""
    total = found["totals"]
    text = [
        found["title"] or "untitled scene",
        f"{_counted(total['copies'], 'object')}, {_counted(total['faces'], 'face')}; "
        f"from {_triple(found['bounds']['low'])} to {_triple(found['bounds']['high'])}",
    ]
    for camera in found["cameras"]:
        if "fov_x" in camera:
            seen = f"fov {camera['fov_x']:.2f} x {camera['fov_y']:.2f} degrees"
        else:
            seen = f"{camera['width']:g} x {camera['height']:g} units"
        far = "infinity" if camera["far"] is None else f"{camera['far']:g}"
        text.append(f"camera {camera['name']}: {camera['type']}, {seen}, near {camera['near']:g}, far {far}")
    return [*text, *(line for entry in found["objects"] for line in _object_lines(entry))]


def schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of scene files, for editors."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Scene.model_json_schema()}


def _object_lines(entry: dict[str, Any]) -> Iterator[str]:
    copies = f"{entry['copies']} x " if entry["copies"] > 1 else ""
    cut = f", {_counted(entry['cut'], 'face')} of its file cut into triangles" if entry["cut"] else ""
    cut += f" ({entry['concave']:,} concave)" if entry["concave"] else ""
    what = f"{copies}{entry['shape']}, {_counted(entry['faces'], 'face')}, cull {entry['cull']}"
    yield f"object {entry['name']}: {what}{cut}"
    for why in dict.fromkeys(entry["culling"].values()):
        cameras = [name for name, other in entry["culling"].items() if other == why]
        seen_by = "" if len(cameras) == len(entry["culling"]) else f" seen by {', '.join(cameras)}"
        effect = f"may change the picture: {why}" if why else "changes nothing"
        yield f"  culling its back faces{seen_by} {effect}"


def _counted(count: int, what: str) -> str:
    return f"{count:,} {what}" if count == 1 else f"{count:,} {what}s"


def _triple(values: list[float]) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in values) + ")"


# ---------------------------------------------------------------- cameras


def _camera(camera: Camera, projection: Projection) -> dict[str, Any]:
    far = projection.far if math.isfinite(projection.far) else None
    entry = {"name": camera.name, "type": camera.type, "near": projection.near, "far": far}
    if projection.perspective:
        return entry | {"fov_x": _field_of_view(projection, 0), "fov_y": _field_of_view(projection, 1)}
    w = projection.clip_from_world[3, 3]
    across, up = (2.0 * w / math.hypot(*projection.clip_from_world[k, :3]) for k in (0, 1))
    return entry | {"width": float(across), "height": float(up)}


def _field_of_view(projection: Projection, axis: int) -> float:
    """Return the angle in degrees between the lines of sight at -1 and at +1 along an axis of the image."""
    rows = projection.clip_from_world[[0, 1, 3], :3]
    ends = np.zeros((2, 3))
    ends[:, axis], ends[:, 2] = (-1.0, 1.0), 1.0
    first, last = np.linalg.solve(rows, ends.T).T
    angle = math.atan2(float(np.linalg.norm(np.cross(first, last))), float(first @ last))
    # Nine digits: what rounding in the matrix leaves of the angle that was asked for.
    return round(math.degrees(angle), 9)


# ---------------------------------------------------------------- objects


def _object(
    thing: Object, scene: Scene, projections: dict[str, Projection], problem_of: Callable[[Shape], str]
) -> dict[str, Any]:
    shape = shape_of(thing, scene.folder)
    matrices = [matrix for _, matrix in copies(thing)]
    reach = shape.solid.reach
    return {
        "name": thing.name,
        "shape": thing.shape,
        "copies": len(matrices),
        "faces": shape.faces,
        "cut": shape.cut,
        "concave": shape.concave,
        "cull": thing.cull,
        "bounds": _box(np.array([np.transpose([reach(row) for row in matrix[:3]]) for matrix in matrices])),
        "culling": {
            name: problem_of(shape) or _sight_problem(projection, shape, matrices)
            for name, projection in projections.items()
        },
    }


def _surface_problem(shape: Shape) -> str:
    """Say why a shape does not bound a solid; the generic solids do, and polyhedra have been checked."""
    if shape.kind == Kind.SQUARE:
        return "not closed: a square has no inside"
    if shape.kind == Kind.MESH and shape.polygons is not None:
        return surface_problem(shape.polygons)
    return ""


def _sight_problem(projection: Projection, shape: Shape, matrices: Sequence[Floats]) -> str:
    """Say why a camera would see back faces of a solid: from its inside, or where the near plane cuts it.

    It is cut if it has points on both sides of the plane, wherever they are on the screen.
    """
    reach = shape.solid.reach
    for k, matrix in enumerate(matrices):
        low, high = reach(projection.depth_row @ matrix)
        if low < projection.near < high:
            which = f" (copy {k})" if len(matrices) > 1 else ""
            if projection.perspective and _holds(shape, np.linalg.solve(matrix, [*eye_of(projection), 1.0])):
                return f"the eye is inside it{which}"
            return f"the near plane cuts it{which}"
    return ""


def _holds(shape: Shape, point: Floats) -> bool:
    """Whether a point (x, y, z, 1) of object space is inside a solid."""
    if shape.quadric is not None:
        form, ends = shape.quadric.rounded, shape.quadric.ends
        return bool(point @ form @ point < 0.0 and (ends @ point > 0.0).all())
    polygons = cast(Polygons, shape.polygons)
    return winding_number(point[:3], polygons.vertices[polygons.triangle_vertex]) > 0.5


def _box(boxes: Floats) -> dict[str, list[float]]:
    """Return the opposite corners of the box around boxes (n, 2, 3)."""
    return {"low": boxes[:, 0].min(axis=0).tolist(), "high": boxes[:, 1].max(axis=0).tolist()}
