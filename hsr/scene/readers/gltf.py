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
from contextlib import suppress
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
from hsr.scene.readers.source import content_of, ending_of, plain, reading
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

REPEATED, MANY = 16, 1_000_000
"""Vertices and triangles that each byte of the buffers may make, and what any file may have."""

DEEPEST = 500
"""Nodes below each other."""


class Node(NamedTuple):
    """A node with a mesh, as it stands in the world.

    Attributes
    ----------
    name : str
        Different for every node of a document, and for every instance.
    steps : tuple of Step
        From the node to the world: its own scale, rotation and translation, its parent's, and so on; none
        if a skin moves the mesh into the world.
    part : str
        Name of its mesh, as the node bends it.
    """

    name: str
    steps: tuple[Step, ...]
    part: str


class Geometry(NamedTuple):
    """What a part is made of: a mesh, what its morph targets weigh, and a skin."""

    mesh: int
    weights: tuple[float, ...]
    skin: int | None = None


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
        Those of the default scene that show triangles, parents first.
    cameras : list of Camera
        Those of the default scene that can take a picture. Their aspect ratio is that of the image. As the
        specification says, the scale of a camera's node and of the parents does not count.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read: dict[str, Faces] = {}
        self._made = 0
        with reading(path):
            content = content_of(path)
            packed = content.startswith(MAGIC) or ending_of(path) == ".glb"
            text, *chunk = chunks(content) if packed else [content]
            self._tree: dict[str, Any] = json.loads(plain(text).decode(errors="replace"))
            if not isinstance(self._tree, dict):
                raise SceneError("it is JSON, but no glTF: its outermost value is no object")
            version = str(self._tree.get("asset", {}).get("version", "2.0"))
            if not version.startswith("2."):
                raise SceneError(f"it is of glTF {version}; export it as glTF 2.0")
            self._required = set(self._tree.get("extensionsRequired", ()))
            self._refuse()
            self._arrays = Arrays(self._tree, path.parent, chunk)
            chains = [chain for chain in self._walk() if not any(self._flat[k] for k in chain)]
            self._names = self._named_parts(chain[0] for chain in chains)
            self._parts = {name: geometry for geometry, name in self._names.items()}
            self.nodes = self._shown(chains)
            self.cameras = self._lenses(chains)

    def faces(self, part: str | None = None) -> Faces:
        """Return one mesh in its own frame, or all nodes' meshes in the world (rounded).

        Raises
        ------
        SceneError
            If no mesh with triangles has the name ``part``, or there is none at all.
        """
        if part is None:
            return joined([_moved(self._part(node.part), node.steps) for node in self.nodes])
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

    def _entry(self, key: str, index: Any) -> dict[str, Any]:
        return entry(self._tree, key, index)

    def _table(self, node: int) -> dict[str, Any]:
        return self._entry("nodes", node)

    # ------------------------------------------------------------ nodes

    def _roots(self) -> list[int]:
        if self._tree.get("scenes"):
            return list(self._entry("scenes", self._tree.get("scene", 0)).get("nodes", []))
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

    def _shown(self, chains: Iterable[tuple[int, ...]]) -> list[Node]:
        """Return what nodes show, once for each instance."""
        found = []
        for chain in chains:
            tables = [self._table(k) for k in chain]
            switches = [table.get("extensions", {}).get(VISIBILITY, {}) for table in tables]
            if "mesh" in tables[0] and all(switch.get("visible", True) for switch in switches):
                part = self._names[self._geometry(chain[0])]
                placings = self._placings(chain) if len(self._part(part).sides) else ()
                found += [(self._name(chain[0]), steps, part) for steps in placings]
            if len(found) > MANY:
                raise SceneError(f"it has more than {MANY} nodes and instances; export fewer")
        names = unique([name for name, _, _ in found])
        return [Node(name, steps, part) for name, (_, steps, part) in zip(names, found, strict=True)]

    def _placings(self, chain: tuple[int, ...]) -> list[tuple[Step, ...]]:
        """Return the ways from a node, or from each of its instances, to the world."""
        table = self._table(chain[0])
        instances = table.get("extensions", {}).get(INSTANCES)
        if "skin" in table:
            if instances:
                raise SceneError(f"node {chain[0]} has a skin and instances; export it without one of them")
            return [()]
        steps = self._steps(chain)
        if instances is None:
            return [steps]
        own = instances["attributes"]
        given = [(word, own[key], kind) for word, key, kind in TRS if key in own]
        if not given:
            raise SceneError(f"node {chain[0]} has instances without transforms")
        size = self._entry("accessors", given[0][1])["count"]
        columns = {word: self._arrays.read(index, kind, size).tolist() for word, index, kind in given}
        rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
        return [_steps(row) + steps for row in rows if not _is_flat(row)]

    def _steps(self, chain: tuple[int, ...]) -> tuple[Step, ...]:
        return tuple(step for k in chain for step in self._own_steps(k))

    def _own_steps(self, k: int) -> tuple[Step, ...]:
        try:
            return _steps(self._table(k))
        except ValidationError as error:
            raise SceneError(f"node {k}: {lines_of(error)[0]}") from None

    def _name(self, k: int) -> str:
        """Name a node, or else its mesh."""
        table = self._table(k)
        return str(table.get("name") or self._mesh_names[int(table["mesh"])])

    def _lenses(self, chains: Iterable[tuple[int, ...]]) -> list[Camera]:
        """Return the cameras; one that cannot take a picture is left out, for nobody may ever ask for it."""
        found, cameras = [], []
        for chain in chains:
            table = self._table(chain[0])
            with suppress(SceneError):
                lens = self._entry("cameras", table.get("camera"))
                name = table.get("name") or lens.get("name") or f"camera {table['camera']}"
                found.append((str(name), lens, chain))
        for name, (_, lens, chain) in zip(unique([name for name, _, _ in found]), found, strict=True):
            with suppress(HsrError, ArithmeticError, LookupError, TypeError, ValueError):
                camera = _camera(lens, name, self._steps(chain))
                projection_of(camera, aspect=1.0)
                cameras.append(camera)
        return cameras

    # ------------------------------------------------------------ meshes

    @cached_property
    def _mesh_names(self) -> list[str]:
        meshes = enumerate(self._tree.get("meshes", []))
        return unique([str(mesh.get("name") or f"mesh {k}") for k, mesh in meshes])

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
        weights = table.get("weights", self._entry("meshes", table["mesh"]).get("weights", ()))
        return Geometry(table["mesh"], tuple(weights), table.get("skin"))

    def _part(self, name: str) -> Faces:
        if name not in self._read:
            self._read[name] = self._faces(self._parts[name])
        return self._read[name]

    def _faces(self, geometry: Geometry) -> Faces:
        """Return the triangles, primitive after primitive; some share their vertices."""
        vertices, size = [np.empty((0, 3))], 0
        starts: dict[str, tuple[int, int]] = {}
        triangles = [np.empty((0, 3), np.int64)]
        for primitive in self._entry("meshes", geometry.mesh)["primitives"]:
            if primitive.get("mode", TRIANGLES) < TRIANGLES or "POSITION" not in primitive["attributes"]:
                continue
            key = json.dumps([primitive["attributes"], primitive.get("targets")])
            if key not in starts:
                vertices.append(self._vertices(primitive, geometry))
                starts[key] = size, len(vertices[-1])
                size += len(vertices[-1])
                self._made += len(vertices[-1])
            start, count = starts[key]
            triangles.append(start + self._triangles(primitive, count))
            self._made += len(triangles[-1])
            if self._made > REPEATED * self._arrays.bytes + MANY:
                raise SceneError("its meshes repeat what is in its buffers too often; export fewer")
        return Faces.of_rows(np.concatenate(vertices), np.concatenate(triangles))

    def _vertices(self, primitive: dict[str, Any], geometry: Geometry) -> Floats:
        """Return positions (n, 3) as morph targets and the skin move them."""
        attributes, others = primitive["attributes"], primitive.get("extensions", {})
        needed = [attributes["POSITION"], *([primitive["indices"]] if "indices" in primitive else ())]
        if not all(map(self._arrays.has_data, needed)) or (DRACO in others and DRACO in self._required):
            how = f"is compressed by {', '.join(others)}; export it uncompressed" if others else "has no data"
            raise SceneError(f"a primitive {how}")
        position = self._arrays.read(attributes["POSITION"], "VEC3").astype(np.float64)
        for weight, target in zip(geometry.weights, primitive.get("targets", ()), strict=False):
            if weight and "POSITION" in target:
                position += weight * self._arrays.read(target["POSITION"], "VEC3", len(position))
        return position if geometry.skin is None else self._skinned(position, attributes, geometry.skin)

    def _skinned(self, position: Floats, attributes: dict[str, Any], index: int) -> Floats:
        """Move vertices into the world: each by the mean of its joints' matrices, as it weighs them."""
        if "JOINTS_0" not in attributes:
            raise SceneError("a node has a skin, and its mesh has no joints; export it without skin")
        skin = self._entry("skins", index)
        matrices = np.array([self._world(joint) for joint in skin["joints"]])
        if "inverseBindMatrices" in skin:
            columns = self._arrays.read(skin["inverseBindMatrices"], "MAT4")
            matrices = matrices @ columns.reshape(-1, 4, 4).transpose(0, 2, 1).astype(np.float64)
        ends = np.column_stack([position, np.ones(len(position))])
        moved = np.zeros_like(ends)
        for k in takewhile(lambda k: f"JOINTS_{k}" in attributes, count()):
            keys = attributes[f"JOINTS_{k}"], attributes[f"WEIGHTS_{k}"]
            joints, weights = (self._arrays.read(key, "VEC4", len(position)).T for key in keys)
            for joint, weight in zip(joints, weights.astype(np.float64), strict=True):
                moved += weight[:, None] * (matrices[joint] @ ends[:, :, None])[:, :, 0]
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
            return np.stack([np.full_like(corner[2:], corner[:1]), corner[1:-1], corner[2:]], axis=1)
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
    turned = np.array(_rotation(table.get("rotation", (0, 0, 0, 1))))
    matrix: Floats = turned * [*table.get("scale", (1, 1, 1)), 1.0]
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
