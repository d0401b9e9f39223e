"""A view for other programs: its mesh, its camera, and who must own every sample, in one folder.

The truth is that of the numbers that are written. World coordinates are rounded to float32, which is what
binary glTF holds; curved shapes are the polygons that stand for them; a polygon, whose rounded corners need
lie in no plane, is the triangles of its fan. Of these the owners are decided exactly.
"""

from __future__ import annotations

import json
import operator
from collections.abc import Iterator
from dataclasses import replace
from importlib.resources import files
from io import BytesIO
from itertools import count, pairwise
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from hsr.algorithms.registry import render
from hsr.base.arrays import Array, Pixels
from hsr.base.errors import HsrError
from hsr.base.files import check_new_folder, write_folder
from hsr.lab.export.cameras import conventions
from hsr.lab.export.meshes import glb, obj
from hsr.pictures.png import png_of
from hsr.problem.geometry import CULL, Geometry, Placement, as_float32
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View
from hsr.scene.names import printable
from hsr.scene.shapes import Kind, Polygons, Shape

CULLED = {number: word for word, number in CULL.items()}

MOST_FACES = 2**24 - 1
"""As many as 24-bit colours tell apart, and float32 counts."""


def export(view: View, folder: str | Path, title: str) -> VisibilityMap:
    """Write a folder with a view for other programs, and what they should show.

    Parameters
    ----------
    view : View
    folder : str or Path
        Nothing may be there, or an empty folder.
    title : str
        Of the README in the folder.

    Returns
    -------
    VisibilityMap
        The truth of what is written.

    Raises
    ------
    HsrError
        If the camera mirrors or shears what it sees, there are too many faces, coordinates are beyond
        float32, or the folder cannot be written; then there is none.
    """
    check_new_folder(folder)
    if view.faces > MOST_FACES:
        raise HsrError(f"{view.faces:,} faces: of more than {MOST_FACES:,} no picture of ids can be made")
    camera, seen = conventions(view), as_written(view)
    truth = replace(render(seen, "exact"), manifest=view.manifest)
    culled = [{"cull": CULLED[one.cull]} for one in view.geometry]
    ties, owners = list(_ties(truth)), seen.triangle_face.tolist()
    write_folder(
        folder,
        {
            "README.md": _readme(title, seen, truth, len(ties)),
            "scene.obj": obj(seen.geometry),
            "scene.glb": glb(seen.geometry),
            "triangle_face.csv": "".join(["id,face\n", *map("{},{}\n".format, count(), owners)]),
            "faces.json": _json({"objects": [*map(operator.or_, view.manifest, culled)]}),
            "camera.json": _json(camera),
            "expected.npz": truth.encoded(),
            "expected.npy": _npy(truth.face),
            "expected.png": png_of(_colours(truth.face)),
            "admissible.json": json.dumps({"samples": ties}) + "\n",
        },
    )
    return truth


def as_written(view: View) -> View:
    """Return the view of the numbers that are written: triangles with corners of float32 in world space.

    Raises
    ------
    MethodError
        If a coordinate is beyond float32.
    """
    before = view.tessellated().geometry
    polygons = before.polygons
    vertices = as_float32(polygons.vertices, "export").astype(np.float64)
    triangles = replace(Polygons.of_rows(vertices, polygons.triangle_vertex), face=polygons.triangle_face)
    owner = np.searchsorted(before.first_faces, triangles.face, side="right") - 1
    starts = np.searchsorted(owner, np.arange(len(before) + 1))
    parts = [triangles.part(np.arange(*pair)) for pair in pairwise(starts)]
    return replace(view, placements=Geometry(map(_in_world, before, parts)))


def _in_world(placement: Placement, triangles: Polygons) -> Placement:
    """Return an object as triangles in world space; its faces keep their numbers."""
    shape = placement.shape
    names = shape.face_names
    if not names and shape.faces != len(triangles):  # else every triangle is a face
        names = tuple(map(str, range(shape.faces)))
    own = replace(triangles, face=triangles.face - np.int32(placement.first))
    made = Shape(Kind.MESH, shape.label, own, names)
    return replace(placement, shape=made, world_from_object=np.eye(4), mirrored=False)


def _json(value: Any) -> str:
    return json.dumps(value, indent=1) + "\n"


def _npy(array: Array) -> bytes:
    file = BytesIO()
    np.save(file, array, allow_pickle=False)
    return file.getvalue()


def _colours(face: Array) -> Pixels:
    """Return a picture (H, W, 3) whose 24-bit colours are face + 1, red first; black is the background."""
    return np.stack([(face + 1) >> shift & 255 for shift in (16, 8, 0)], axis=-1).astype(np.uint8)


def _ties(truth: VisibilityMap) -> Iterator[dict[str, Any]]:
    assert truth.admissible is not None
    for sample in truth.admissible.sample.tolist():
        row, column = divmod(sample, truth.width)
        yield {"x": column, "y": row, "faces": sorted(truth.admissible.faces(sample))}


def _readme(title: str, view: View, truth: VisibilityMap, ties: int) -> str:
    text = Template(files(__name__).joinpath("folder.md").read_text(encoding="utf-8"))
    triangles, covered = len(view.triangle_face), np.count_nonzero(truth.face >= 0)
    counts = {"triangles": f"{triangles:,}", "covered": f"{covered:,}", "ties": f"{ties:,}"}
    return text.substitute(counts, title=printable(title), width=view.width, height=view.height)
