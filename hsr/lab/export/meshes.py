"""Triangles with face ids as files of other programs: Wavefront OBJ and binary glTF."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator

import numpy as np

from hsr.problem.geometry import Geometry


def obj(geometry: Geometry) -> str:
    """Write triangles as OBJ, one ``o`` an object, one group ``face_ID`` a face.

    Parameters
    ----------
    geometry : Geometry
        Of planar faces in world space.

    Returns
    -------
    str
        Coordinates have the digits that tell them from every other float64.
    """
    return "\n".join(_obj_lines(geometry)) + "\n"


def _obj_lines(geometry: Geometry) -> Iterator[str]:
    polygons = geometry.polygons
    yield from ("v {!r} {!r} {!r}".format(*point) for point in polygons.vertices.tolist())
    names, before = {one.first: one.name for one in geometry}, None
    for face, corners in zip(polygons.triangle_face.tolist(), polygons.triangle_vertex.tolist(), strict=True):
        if face != before:
            yield from [f"o {names[face]}"] if face in names else []
            yield f"g face_{face}"
        yield "f {} {} {}".format(*(corner + 1 for corner in corners))
        before = face


def glb(geometry: Geometry) -> bytes:
    """Write triangles as binary glTF: one mesh, three vertices to a triangle, each with its face.

    Parameters
    ----------
    geometry : Geometry
        Of planar faces in world space, its coordinates float32 numbers.

    Returns
    -------
    bytes
        The attribute ``_FACE_ID`` is float32: glTF has no greater whole numbers for vertices than uint16.
    """
    position = geometry.triangles.reshape(-1, 3).astype("<f4")
    face = np.repeat(geometry.polygons.triangle_face, 3).astype("<f4")
    count, float32, vertices = len(face), 5126, 34962
    bounds = {"min": position.min(axis=0).tolist(), "max": position.max(axis=0).tolist()}
    content = {
        "asset": {"version": "2.0", "generator": "hsr"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "_FACE_ID": 1}, "material": 0}]}],
        "materials": [{"doubleSided": True}],
        "accessors": [
            {"bufferView": 0, "type": "VEC3", "componentType": float32, "count": count, **bounds},
            {"bufferView": 1, "type": "SCALAR", "componentType": float32, "count": count},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 12 * count, "target": vertices},
            {"buffer": 0, "byteOffset": 12 * count, "byteLength": 4 * count, "target": vertices},
        ],
        "buffers": [{"byteLength": 16 * count}],
    }
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    chunks = ((b"JSON", text), (b"BIN\0", position.tobytes() + face.tobytes()))
    body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
