"""glTF 2.0 files (GLB, glTF): their tree of nodes, their meshes and their cameras.

Whatever moves, hides, copies or replaces vertices is applied: morph weights, skins in the pose of the
nodes, instances, visibility, whole numbers for positions; or refused, if what is compressed has no other
form in the file. Looks are passed over. Source: Khronos Group, glTF 2.0 Specification, sections 3.5
(nodes), 3.7 (meshes) and 3.10 (cameras), and its registry of extensions.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from itertools import count, takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from hsr.base.arrays import Array, Floats
from hsr.base.errors import HsrError, SceneError
from hsr.scene.camera import projection_of
from hsr.scene.meshes import Faces, joined, strip_triangles
from hsr.scene.model import Camera, Orthographic, Perspective, Step
from hsr.scene.names import printable, unique
from hsr.scene.readers.accessors import MAGIC, Arrays, chunks, entry
from hsr.scene.readers.source import content_of, ending_of, reading
from hsr.scene.transforms import compose, placed
from hsr.scene.validation import lines_of

TRIANGLES, STRIP, FAN = 4, 5, 6
"""Modes of primitives that have faces."""

DRACO, INSTANCES, VISIBILITY = "KHR_draco_mesh_compression", "EXT_mesh_gpu_instancing", "KHR_node_visibility"
APPLIED = re.compile(rf"{DRACO}|{INSTANCES}|{VISIBILITY}|KHR_mesh_quantization|(EXT|KHR)_meshopt_compression")
"""Extensions that are applied, or refused where they stand."""

TRS = (("scale", "SCALE", "VEC3"), ("rotation", "ROTATION", "VEC4"), ("translation", "TRANSLATION", "VEC3"))
"""What nodes and instances are moved by: the words of both, and the type of arrays."""

LOOKS = re.compile(r"[A-Z]+_(materials|texture|image|lights|xmp|audio|animation|mesh_features|structural)")
"""How the names of extensions begin that bear on no shape."""

OF_LOOKS = ("materials", "textures", "images", "samplers")
LISTED = ("extensionsUsed", "extensionsRequired")
"""Parts of a document that bear on no shape."""

DEEPEST = 500
"""Nodes below each other."""


class Node(NamedTuple):
    """A node with a mesh or a camera, as it stands in the world.

    Attributes
    ----------
    name : str
        Different for every node of a document, and for every instance.
    steps : tuple of Step
        From the node to the world: its own scale, rotation and translation, its parent's, and so on; none
        if a skin moves the mesh into the world.
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


class Geometry(NamedTuple):
    """What a part is made of: a mesh, what its morph targets weigh, and the node if that has a skin."""

    mesh: int
    weights: tuple[float, ...]
    skinned: int | None = None


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
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read: dict[str, Faces] = {}
        with reading(path):
            content = content_of(path)
            packed = content.startswith(MAGIC) or ending_of(path) == ".glb"
            text, *chunk = chunks(content) if packed else [content]
            self._tree: dict[str, Any] = json.loads(text.decode("utf-8-sig", errors="replace"))
            self._required = set(self._tree.get("extensionsRequired", ()))
            self._refuse()
            self._arrays = Arrays(self._tree, path.parent, chunk)
            chains = [chain for chain in self._walk() if {"mesh", "camera"} & self._table(chain[0]).keys()]
            self._names = self._named_parts(chain[0] for chain in chains)
            self._parts = {name: geometry for geometry, name in self._names.items()}
            self.nodes = self._named_nodes(chains)

    def faces(self, part: str | None = None) -> Faces:
        """Return one mesh in its own frame, or all nodes' meshes in the world (rounded).

        Raises
        ------
        SceneError
            If no mesh with triangles has the name ``part``, or there is none at all.
        """
        if part is None:
            return joined([_moved(self._part(node.part), node.steps) for node in self.nodes if node.part])
        faces = self._part(printable(part)) if printable(part) in self._parts else None
        if faces is None or not len(faces.sides):
            raise SceneError(f"no part is named {part!r}; it has {', '.join(self._parts) or 'none'}")
        return faces

    def _refuse(self) -> None:
        """Refuse extensions that are required, unless they are known or only looks have them."""
        looks = {key: value for key, value in self._tree.items() if key in OF_LOOKS}
        shapes = {key: value for key, value in self._tree.items() if key not in {*OF_LOOKS, *LISTED}}
        unknown = [
            name
            for name in sorted(self._required)
            if not (APPLIED.fullmatch(name) or LOOKS.match(name))
            and (name in json.dumps(shapes) or name not in json.dumps(looks))
        ]
        if unknown:
            raise SceneError(f"it requires {', '.join(unknown)}; export it without extensions")

    def _table(self, node: int) -> dict[str, Any]:
        return entry(self._tree, "nodes", node)

    # ------------------------------------------------------------ nodes

    def _roots(self) -> list[int]:
        if self._tree.get("scenes"):
            return list(entry(self._tree, "scenes", self._tree.get("scene", 0)).get("nodes", []))
        return [k for k in range(len(self._tree.get("nodes", []))) if k not in self._parents]

    @cached_property
    def _parents(self) -> dict[int, int]:
        tables = enumerate(self._tree.get("nodes", []))
        return {child: k for k, table in tables for child in table.get("children", [])}

    @cached_property
    def _flat(self) -> list[bool]:
        return [*map(_is_flat, self._tree.get("nodes", []))]

    def _walk(self) -> Iterator[tuple[int, ...]]:
        """Yield every node of the scene, parents first, each with those above it, the nearest first."""
        ahead: list[tuple[int, ...]] = [(k,) for k in reversed(self._roots())]
        seen = set()
        while ahead:
            chain = ahead.pop()
            if chain[0] in seen:
                raise SceneError(f"node {chain[0]} stands twice in its tree")
            if len(chain) > DEEPEST:
                raise SceneError(f"its nodes stand more than {DEEPEST} below each other")
            seen.add(chain[0])
            yield chain
            ahead += [(child, *chain) for child in reversed(self._table(chain[0]).get("children", []))]

    def _named_nodes(self, chains: Sequence[tuple[int, ...]]) -> list[Node]:
        """Return what the nodes carry; those that are hidden or of no size carry nothing."""
        found: list[tuple[int, tuple[Step, ...], str | None]] = []
        for chain in chains:
            if not any(self._flat[k] for k in chain):
                part = self._part_name(chain)
                found += [(chain[0], steps, part) for steps in self._placings(chain, part)]
        names = unique([self._name(k) for k, _, _ in found])
        return [
            Node(name, steps, part, self._camera(k, name, steps))
            for name, (k, steps, part) in zip(names, found, strict=True)
        ]

    def _placings(self, chain: tuple[int, ...], part: str | None) -> list[tuple[Step, ...]]:
        """Return the ways from a node, or from each of its instances, to the world."""
        table = self._table(chain[0])
        instances = table.get("extensions", {}).get(INSTANCES) if part else None
        if part and "skin" in table:
            if instances:
                raise SceneError(f"node {chain[0]} has a skin and instances; export it without one of them")
            return [()]
        steps = tuple(step for k in chain for step in self._own_steps(k))
        if instances is None:
            return [steps]
        given = [(word, key, kind) for word, key, kind in TRS if key in instances["attributes"]]
        if not given:
            raise SceneError(f"node {chain[0]} has instances without transforms")
        size = entry(self._tree, "accessors", instances["attributes"][given[0][1]])["count"]
        arrays = [self._arrays.read(instances["attributes"][key], kind, size) for _, key, kind in given]
        rows = [{given[k][0]: array[row].tolist() for k, array in enumerate(arrays)} for row in range(size)]
        return [_steps(row) + steps for row in rows if not _is_flat(row)]

    def _own_steps(self, k: int) -> tuple[Step, ...]:
        try:
            return _steps(self._table(k))
        except ValidationError as error:
            raise SceneError(f"node {k}: {lines_of(error)[0]}") from None

    def _name(self, k: int) -> str:
        """Name a node, or else what it carries."""
        table = self._table(k)
        if table.get("name"):
            return str(table["name"])
        if "mesh" in table:
            return self._mesh_names[int(table["mesh"])]
        return str(entry(self._tree, "cameras", table["camera"]).get("name") or f"camera {table['camera']}")

    def _camera(self, k: int, name: str, steps: tuple[Step, ...]) -> Camera | None:
        """Return the camera of a node, if it is one that can take a picture."""
        if "camera" not in self._table(k):
            return None
        try:
            camera = _camera(entry(self._tree, "cameras", self._table(k)["camera"]), name, steps)
            projection_of(camera, aspect=1.0)
        except (HsrError, ArithmeticError, LookupError, TypeError, ValueError):
            return None
        return camera

    # ------------------------------------------------------------ meshes

    @cached_property
    def _mesh_names(self) -> list[str]:
        return unique(
            [str(mesh.get("name") or f"mesh {k}") for k, mesh in enumerate(self._tree.get("meshes", []))]
        )

    def _named_parts(self, nodes: Iterable[int]) -> dict[Geometry, str]:
        """Name every mesh as it is, and as nodes bend it."""
        names = {
            Geometry(k, tuple(mesh.get("weights", ()))): name
            for k, (mesh, name) in enumerate(zip(self._tree.get("meshes", []), self._mesh_names, strict=True))
        }
        for k in nodes:
            if "mesh" in self._table(k):
                geometry = self._geometry(k)
                names.setdefault(geometry, f"{self._mesh_names[geometry.mesh]} of {self._name(k)}")
        return dict(zip(names, unique([*names.values()]), strict=True))

    def _geometry(self, k: int) -> Geometry:
        table = self._table(k)
        weights = table.get("weights", entry(self._tree, "meshes", table["mesh"]).get("weights", ()))
        return Geometry(table["mesh"], tuple(weights), k if "skin" in table else None)

    def _part_name(self, chain: tuple[int, ...]) -> str | None:
        """Return the name of what a node shows."""
        tables = [self._table(k) for k in chain]
        visible = all(
            table.get("extensions", {}).get(VISIBILITY, {}).get("visible", True) for table in tables
        )
        if "mesh" not in tables[0] or not visible:
            return None
        name = self._names[self._geometry(chain[0])]
        return name if len(self._part(name).sides) else None

    def _part(self, name: str) -> Faces:
        if name not in self._read:
            self._read[name] = self._faces(self._parts[name])
        return self._read[name]

    def _faces(self, geometry: Geometry) -> Faces:
        """Return the triangles, primitive after primitive; some share their vertices."""
        vertices: dict[str, Floats] = {}
        start: dict[str, int] = {}
        triangles = [np.empty((0, 3), np.int64)]
        for primitive in entry(self._tree, "meshes", geometry.mesh)["primitives"]:
            if primitive.get("mode", TRIANGLES) < TRIANGLES or "POSITION" not in primitive["attributes"]:
                continue
            key = json.dumps([primitive["attributes"], primitive.get("targets")])
            if key not in vertices:
                start[key] = sum(map(len, vertices.values()))
                vertices[key] = self._vertices(primitive, geometry)
            triangles.append(self._triangles(primitive, len(vertices[key])) + start[key])
        return Faces.of_rows(
            np.concatenate([np.empty((0, 3)), *vertices.values()]), np.concatenate(triangles)
        )

    def _vertices(self, primitive: dict[str, Any], geometry: Geometry) -> Floats:
        """Return positions (n, 3) as morph targets and the skin move them."""
        attributes, needed = primitive["attributes"], [primitive["attributes"]["POSITION"]]
        needed += [primitive["indices"]] if "indices" in primitive else []
        there = all(map(self._arrays.has_data, needed))
        if DRACO in primitive.get("extensions", {}) and (DRACO in self._required or not there):
            raise SceneError(f"it is compressed by {DRACO}, which is not read; export it uncompressed")
        position = self._arrays.read(attributes["POSITION"], "VEC3").astype(np.float64)
        for weight, target in zip(geometry.weights, primitive.get("targets", ()), strict=False):
            if weight and "POSITION" in target:
                position += weight * self._arrays.read(target["POSITION"], "VEC3", len(position))
        return position if geometry.skinned is None else self._skinned(position, attributes, geometry.skinned)

    def _skinned(self, position: Floats, attributes: dict[str, Any], node: int) -> Floats:
        """Move vertices into the world: each by the mean of its joints' matrices, as it weighs them."""
        if "JOINTS_0" not in attributes:
            raise SceneError(f"node {node} has a skin, and its mesh has no joints; export it without skin")
        skin = entry(self._tree, "skins", self._table(node)["skin"])
        matrices = np.array([self._world(joint) for joint in skin["joints"]])
        if "inverseBindMatrices" in skin:
            columns = self._arrays.read(skin["inverseBindMatrices"], "MAT4")
            matrices = matrices @ columns.reshape(-1, 4, 4).transpose(0, 2, 1).astype(np.float64)
        ends = np.column_stack([position, np.ones(len(position))])
        moved = np.zeros_like(ends)
        for k in takewhile(lambda k: f"JOINTS_{k}" in attributes, count()):
            joints, weights = (
                self._arrays.read(attributes[f"{word}_{k}"], "VEC4", len(position)).T
                for word in ("JOINTS", "WEIGHTS")
            )
            for joint, weight in zip(joints, weights.astype(np.float64), strict=True):
                moved += weight[:, None] * (matrices[joint] @ ends[:, :, None])[:, :, 0]
        with np.errstate(all="ignore"):
            return np.asarray(moved[:, :3] / moved[:, 3:])

    def _world(self, k: int) -> Floats:
        """Return the matrix from a node to the world."""
        matrix, depth = _matrix(self._table(k)), 0
        while k in self._parents and depth < DEEPEST:
            k, depth = self._parents[k], depth + 1
            matrix = _matrix(self._table(k)) @ matrix
        return matrix

    def _triangles(self, primitive: dict[str, Any], size: int) -> Array:
        """Return triangles (n, 3) of ``size`` vertices."""
        corner = np.arange(size)
        if "indices" in primitive:
            corner = self._arrays.read(primitive["indices"], "SCALAR")[:, 0].astype(np.int64)
            if len(corner) and not 0 <= corner.min() <= corner.max() < size:
                raise SceneError(f"a primitive names vertex {corner.max()}; there are {size}, counted from 0")
        mode = primitive.get("mode", TRIANGLES)
        if mode == STRIP:
            return strip_triangles(corner, np.array([len(corner)]))
        if mode == FAN:
            return np.stack(
                [np.full_like(corner[2:], corner[0] if len(corner) else 0), corner[1:-1], corner[2:]], axis=1
            )
        if len(corner) % 3:
            raise SceneError(f"a primitive has {len(corner)} corners, which make no whole triangles")
        return corner.reshape(-1, 3)


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


def _is_flat(table: dict[str, Any]) -> bool:
    """Whether a node or an instance shrinks what it carries to a line or to a point, which has no area."""
    return int(np.count_nonzero(_matrix(table)[:3, :3].any(axis=0))) < 2


def _matrix(table: dict[str, Any]) -> Floats:
    """Return what a node does to its children, rounded at every step."""
    if "matrix" in table:
        return np.reshape(np.array(table["matrix"], np.float64), (4, 4)).T
    matrix = np.array(_rotation(table.get("rotation", (0, 0, 0, 1)))) @ np.diag(
        [*table.get("scale", (1, 1, 1)), 1.0]
    )
    matrix[:3, 3] = table.get("translation", 0.0)
    return matrix


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
