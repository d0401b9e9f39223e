"""glTF 2.0 files (GLB, glTF): their tree of nodes, their meshes and their cameras.

The arrays of the meshes come from trimesh. The nodes and cameras are read here: trimesh drops the
parents of a camera, takes the vertical field of view for another one, and passes over orthographic
cameras and those without an aspect ratio. Source: Khronos Group, glTF 2.0 Specification, sections
3.5 (nodes), 3.7 (meshes) and 3.10 (cameras).
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Iterator, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from hsr.base.arrays import Floats
from hsr.base.errors import SceneError
from hsr.scene.meshes import Faces, joined
from hsr.scene.model import Camera, Orthographic, Perspective, Step
from hsr.scene.names import unique
from hsr.scene.readers.source import reading
from hsr.scene.transforms import compose, placed
from hsr.scene.validation import lines_of

TRIANGLES, FAN, READ = 4, 6, (0, 1, 4, 5)
"""Modes of primitives: the default one, the one refused here, and those that trimesh reads."""

HARMLESS = {"KHR_materials_unlit", "KHR_texture_transform", "KHR_lights_punctual"}
"""Extensions that a file may require without touching its geometry."""


class Node(NamedTuple):
    """A node with a mesh or a camera, as it stands in the world.

    Attributes
    ----------
    name : str
        Different for every node of a document.
    steps : tuple of Step
        From the node to the world: its own scale, rotation and translation, its parent's, and so on.
    part : str or None
        Name of its mesh, if that has triangles.
    camera : Camera or None
        Its aspect ratio is that of the image. As the specification says, the scale of its node and
        of the parents does not count.
    """

    name: str
    steps: tuple[Step, ...]
    part: str | None
    camera: Camera | None


class Document:
    """A glTF file, read.

    Parameters
    ----------
    path : Path
        A ``.glb``, or a ``.gltf`` with its buffers inside or beside it.

    Raises
    ------
    SceneError
        If the file does not follow the specification; the message does not name the file.

    Attributes
    ----------
    nodes : list of Node
        Those of the default scene that carry something, parents first.
    parts : dict of str to Faces
        The triangles of every mesh that has any, primitive after primitive, in the mesh's own frame.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._content = path.read_bytes()
        with reading(path):
            self._tree: dict[str, Any] = json.loads(self._json())
            self._refuse()
            meshes = self._tree.get("meshes", [])
            names = unique([str(mesh.get("name") or f"mesh {k}") for k, mesh in enumerate(meshes)])
            found = zip(names, self._meshes(), strict=True)
            self.parts = {name: joined(primitives) for name, primitives in found if primitives}
            walk = self._walk(self._roots(), (), ())
            carriers = [(table, steps) for table, steps in walk if "mesh" in table or "camera" in table]
            node_names = unique([self._name(table, names) for table, _ in carriers])
            parts = [names[table["mesh"]] if "mesh" in table else "" for table, _ in carriers]
            self.nodes = [
                Node(name, steps, part if part in self.parts else None, self._camera(table, name, steps))
                for name, part, (table, steps) in zip(node_names, parts, carriers, strict=True)
            ]

    def faces(self, part: str | None = None) -> Faces:
        """Return one mesh in its own frame, or all nodes' meshes in the world (rounded).

        Raises
        ------
        SceneError
            If no mesh with triangles has the name ``part``, or there is none at all.
        """
        if part is None:
            return joined([_moved(self.parts[node.part], node.steps) for node in self.nodes if node.part])
        if part not in self.parts:
            raise SceneError(f"no part is named {part!r}; it has {', '.join(self.parts) or 'none'}")
        return self.parts[part]

    def _json(self) -> bytes:
        if self._path.suffix.lower() == ".gltf":
            return self._content
        magic, version, _, length, kind = struct.unpack_from("<4sIII4s", self._content.ljust(20))
        if (magic, version, kind) != (b"glTF", 2, b"JSON"):
            raise SceneError("it does not start as a GLB file of version 2 does")
        return self._content[20 : 20 + length]

    def _refuse(self) -> None:
        """Refuse what trimesh would read wrongly without a word."""
        required = set(self._tree.get("extensionsRequired", ())) - HARMLESS
        if required:
            raise SceneError(f"it requires {', '.join(sorted(required))}; export it without extensions")
        if any("sparse" in accessor for accessor in self._tree.get("accessors", ())):
            raise SceneError("it has sparse accessors; export it without them")

    # ------------------------------------------------------------ meshes

    def _meshes(self) -> Iterator[list[Faces]]:
        """Yield the primitives of every mesh that are made of triangles."""
        arrays = iter(self._arrays())
        for mesh in self._tree.get("meshes", []):
            modes = [primitive.get("mode", TRIANGLES) for primitive in mesh["primitives"]]
            if FAN in modes:
                raise SceneError("it has triangle fans; export it as triangles")
            found = [next(arrays) for mode in modes if mode in READ]
            yield [Faces.of_rows(part["vertices"], part["faces"]) for part in found if "faces" in part]

    def _arrays(self) -> list[dict[str, Any]]:
        """Return trimesh's arrays of every primitive whose mode it reads, in the file's order."""
        from trimesh.exchange.gltf import load_glb, load_gltf
        from trimesh.resolvers import FilePathResolver

        read = load_gltf if self._path.suffix.lower() == ".gltf" else load_glb
        resolver = FilePathResolver(str(self._path))
        return list(read(BytesIO(self._content), resolver, skip_materials=True)["geometry"].values())

    # ------------------------------------------------------------ nodes

    def _roots(self) -> list[int]:
        scenes = self._tree.get("scenes")
        if scenes:
            return list(scenes[self._tree.get("scene", 0)].get("nodes", []))
        nodes = self._tree.get("nodes", [])
        children = {child for table in nodes for child in table.get("children", [])}
        return [k for k in range(len(nodes)) if k not in children]

    def _walk(
        self, indices: Sequence[int], above: tuple[Step, ...], path: tuple[int, ...]
    ) -> Iterator[tuple[dict[str, Any], tuple[Step, ...]]]:
        """Yield every node below ``path`` and its steps to the world."""
        for k in indices:
            if k in path:
                raise SceneError(f"node {k} is its own ancestor")
            table = self._tree["nodes"][k]
            try:
                steps = _steps(table) + above
            except ValidationError as error:
                raise SceneError(f"node {k}: {lines_of(error)[0]}") from None
            yield table, steps
            yield from self._walk(table.get("children", []), steps, (*path, k))

    def _name(self, table: dict[str, Any], mesh_names: Sequence[str]) -> str:
        """Name a node, or else what it carries."""
        if table.get("name"):
            return str(table["name"])
        if "mesh" in table:
            return mesh_names[int(table["mesh"])]
        return str(self._tree["cameras"][table["camera"]].get("name") or f"camera {table['camera']}")

    def _camera(self, table: dict[str, Any], name: str, steps: tuple[Step, ...]) -> Camera | None:
        if "camera" not in table:
            return None
        try:
            return _camera(self._tree["cameras"][table["camera"]], name, steps)
        except ValidationError as error:
            raise SceneError(f"camera {name!r}: {lines_of(error)[0]}") from None


def _camera(table: dict[str, Any], name: str, steps: tuple[Step, ...]) -> Camera:
    lens = table[table["type"]]
    shared = {"type": table["type"], "name": name, "near": float(lens["znear"]), **_pose(compose(steps))}
    far = None if lens.get("zfar") is None else float(lens["zfar"])
    if table["type"] == "perspective":
        return Perspective.model_validate(shared | {"fov": math.degrees(lens["yfov"]), "far": far})
    return Orthographic.model_validate(shared | {"height": 2.0 * lens["ymag"], "far": far})


def _moved(faces: Faces, steps: tuple[Step, ...]) -> Faces:
    return faces._replace(vertices=placed(faces.vertices, compose(steps)[:3]))


def _steps(table: dict[str, Any]) -> tuple[Step, ...]:
    """Return what a node does to its children: scale, then rotate, then translate."""
    if "matrix" in table:
        columns = np.reshape(np.array(table["matrix"], dtype=np.float64), (4, 4))
        return (Step.model_validate({"matrix": columns.T.tolist()}),)
    if "rotation" in table:
        table = table | {"rotation": _rotation(table["rotation"])}
    keys = {"scale": "scale", "rotation": "matrix", "translation": "translate"}
    return tuple(Step.model_validate({key: table[word]}) for word, key in keys.items() if word in table)


def _rotation(quaternion: Sequence[float]) -> list[list[float]]:
    """Return the matrix of a quaternion (x, y, z, w) (Shoemake, Animating Rotation, SIGGRAPH 1985)."""
    length = math.hypot(*quaternion)
    x, y, z, w = (component / length for component in quaternion)
    return [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w), 0.0],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w), 0.0],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y), 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]


def _pose(world_from_camera: Floats) -> dict[str, Any]:
    """Return eye, target and up of a camera that looks along -z of its node, +y up."""
    eye, backward, up = (world_from_camera[:3, column] for column in (3, 2, 1))
    # The further the eye from the origin, the further the target: their difference loses least.
    distance = max(1.0, float(np.abs(eye).max())) / float(np.linalg.norm(backward))
    target = eye - distance * backward
    return {"eye": eye.tolist(), "target": target.tolist(), "up": up.tolist()}
