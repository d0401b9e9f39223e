"""Scene files and mesh files."""

from __future__ import annotations

import tomllib
from pathlib import Path

from hsr.scene.model import Mesh, Object, Scene
from hsr.scene.shapes import Kind, Polygons, Shape, generic
import numpy as np

def load(path: str | Path) -> Scene:
    path = Path(path)
    scene = Scene.model_validate(tomllib.loads(path.read_text()))
    return scene.model_copy(update={"folder": path.parent})

_cache = {}

def shape_of(thing: Object, folder: Path) -> Shape:
    if thing.shape in ("square", "cube", "sphere", "cylinder"):
        return generic(Kind[thing.shape.upper()])
    if thing.shape == "polyhedron":
        return Shape(Kind.POLYHEDRON, "polyhedron", Polygons.of(np.array(thing.vertices), thing.faces), tuple(f"face {i}" for i in range(len(thing.faces))))
    if thing.file is not None:
        import trimesh
        p = folder / thing.file
        if p not in _cache:
            m = trimesh.load(p, force="mesh", process=False)
            _cache[p] = Shape(Kind.MESH, "mesh", Polygons.of_triangles(np.asarray(m.vertices), np.asarray(m.faces)))
        return _cache[p]
    return Shape(Kind.MESH, "mesh", Polygons.of_triangles(np.array(thing.vertices), np.array(thing.faces)))
