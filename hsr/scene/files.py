"""Scene files (TOML, JSON) and mesh files (OBJ, PLY, STL, OFF, GLB, glTF)."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from difflib import get_close_matches
from functools import cache, lru_cache, partial
from itertools import product
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from pydantic import TypeAdapter, ValidationError

from hsr.base.arrays import Floats
from hsr.base.errors import HsrError, SceneError, named
from hsr.scene.camera import projection_of
from hsr.scene.fitting import Ball, ball_around, fitted
from hsr.scene.meshes import Faces, mesh_shape
from hsr.scene.model import Ambient, Camera, Directional, Mesh, Object, Polyhedron, Scene, Thing
from hsr.scene.names import printable, unique
from hsr.scene.polyhedra import convexity_problems
from hsr.scene.readers import read_faces
from hsr.scene.readers.gltf import Document
from hsr.scene.readers.source import content_of, ending_of, stem_of
from hsr.scene.shapes import MAX_FACES, Kind, Polygons, Shape, generic
from hsr.scene.transforms import compose, copies, placed
from hsr.scene.validation import lines_of

SCENES = (".toml", ".json")
GLTF = (".glb", ".gltf")
MESHES = (".obj", ".ply", ".stl", ".off", *GLTF)

Part = TypeVar("Part")

OBJECT: TypeAdapter[Object] = TypeAdapter(Object)
CAMERA: TypeAdapter[Camera] = TypeAdapter(Camera)


def load(path: str | Path) -> Scene:
    """Read a scene file, or a mesh file as a scene of its own.

    A scene file without a camera, and a mesh file, get one named ``fitted`` that has a sphere around all
    objects in view, whatever the shape of the image; a mesh file also gets lights. Of a GLB or glTF file
    every node with a mesh is an object, and the file's own cameras come before the fitted one.

    Parameters
    ----------
    path : str or Path
        Its ending says what it is: .toml, .json; .obj, .ply, .stl, .off, .glb, .gltf, each also packed,
        with .gz behind it. Or the name of a built-in scene: ``"teapot"``.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        With one line for each problem of the file and of the meshes it names.

    Examples
    --------
    >>> import hsr
    >>> scene = hsr.load("scenes/cyclic.toml")
    >>> scene.title, [thing.name for thing in scene.object]
    ('Cyclic overlap', ['first', 'second', 'third'])
    """
    path = Path(path)
    if not path.suffix and not path.exists():
        path = named(str(path), built_in(), "there is no file and no built-in scene", SceneError)
    ending, shown = ending_of(path), printable(str(path))
    if any("\ud800" <= c <= "\udfff" for c in str(path)):
        raise SceneError(f"{shown}: its name is not text in UTF-8; rename it")
    if ending not in SCENES + MESHES:
        raise SceneError(f"{shown}: not a scene or mesh file; the endings are {' '.join(SCENES + MESHES)}")
    read = _read_scene if ending in SCENES else _gltf_scene if ending in GLTF else _mesh_scene
    with _prefixed(f"{shown}: "):
        _check_file(path, built_in() if path.parent == Path() else ())
        return read(path).located(path.parent, str(path))


@lru_cache
def built_in() -> dict[str, Path]:
    """Return the files of the built-in scenes by name: in the package, or beside it in a checkout."""
    inside, beside = (folder / "scenes" for folder in Path(__file__).parents[1:3])
    return {file.stem: file for file in sorted((inside if inside.is_dir() else beside).glob("*.toml"))}


def shape_of(thing: Object, folder: Path) -> Shape:
    """Return the shape of an object; objects with the same shape share one ``Shape``.

    Parameters
    ----------
    thing : Object
    folder : Path
        Where mesh files with relative paths are. A file is read again when its size or its time of
        modification has changed.

    Raises
    ------
    SceneError
        If a mesh file cannot be used or corners and faces do not make a convex polyhedron.
    """
    with _prefixed(f"object {thing.name!r}: "):
        return _shapes(folder)(thing)


@contextmanager
def _prefixed(prefix: str) -> Iterator[None]:
    """Put ``prefix`` before the problems that come out of the ``with`` block, unreadable files among them."""
    try:
        yield
    except SceneError as error:
        raise SceneError([prefix + problem for problem in error.problems]) from error.__cause__
    except OSError as error:
        raise SceneError(f"{prefix}cannot be read: {error.strerror}") from error


def _check_file(path: Path, also: Iterable[str] = ()) -> None:
    """Refuse what is no file; suggest one beside it whose name is like it, or another name."""
    if path.is_dir():
        raise SceneError("this is a folder; name a file in it")
    if not path.exists():
        # Endings are alike anyhow: the rest of the names is compared.
        beside = sorted(path.parent.glob("*"), key=lambda other: other.suffix == path.suffix)
        known = dict(zip(also, also, strict=True)) | {other.stem: other.name for other in beside}
        near = [known[stem] for stem in get_close_matches(path.stem, known, n=1)]
        raise SceneError(f"no such file{f'; did you mean {near[0]!r}?' if near else ''}")


# ---------------------------------------------------------------- scene files


def _read_scene(path: Path) -> Scene:
    """Read a TOML or JSON file and the meshes it names, and collect every problem of them all."""
    tables = _parsed(path)
    try:
        scene = Scene.model_validate(tables)
    except ValidationError as error:
        cameras, objects = _valid(CAMERA, tables, "camera"), _valid(OBJECT, tables, "object")
        raise SceneError(lines_of(error) + _part_problems(cameras, objects, path.parent)) from None
    problems = _part_problems(enumerate(scene.camera), enumerate(scene.object), path.parent)
    if problems:
        raise SceneError(problems)
    return scene if scene.camera else _with_fitted(scene.located(path.parent))


def _parsed(path: Path) -> Any:
    try:
        # Some editors put a byte order mark before UTF-8.
        text = content_of(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"not UTF-8 text (at byte {error.start}); save it as UTF-8") from None
    name = ending_of(path).removeprefix(".").upper()
    try:
        return tomllib.loads(text) if name == "TOML" else json.loads(text, object_pairs_hook=_table)
    except (ValueError, RecursionError) as error:
        raise SceneError(f"not valid {name}: {error}") from None


def _table(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """Build a table of a JSON file; a key may not stand in it twice, as in TOML."""
    table = dict(pairs)
    if len(table) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"the key {twice!r} stands twice in a table")
    return table


def _valid(adapter: TypeAdapter[Part], tables: Any, kind: str) -> Iterator[tuple[int, Part]]:
    """Yield the cameras or objects of a file that are right by themselves, with their indices."""
    found = tables.get(kind) if isinstance(tables, dict) else None
    for k, table in enumerate(found if isinstance(found, list) else []):
        with suppress(ValidationError):
            yield k, adapter.validate_python(table)


def _part_problems(
    cameras: Iterable[tuple[int, Camera]], objects: Iterable[tuple[int, Object]], folder: Path
) -> list[str]:
    """Make every projection, shape and transform, and count the faces."""
    problems: list[str] = []
    shape, faces = _shapes(folder), 0
    for k, camera in cameras:
        with _collected(problems, f"camera[{k}]: "):
            projection_of(camera, aspect=1.0)
    for k, thing in objects:
        with _collected(problems, f"object[{k}].transform: "):
            compose(thing.transform)
        with _collected(problems, f"object[{k}]."):
            copies = thing.scatter.count if thing.scatter else 1
            faces += shape(thing).faces * copies
        if faces > MAX_FACES:
            problems.append(f"object[{k}]: with it, the scene has {faces} faces; {MAX_FACES} are the most")
            break
    return problems


@contextmanager
def _collected(problems: list[str], prefix: str) -> Iterator[None]:
    """Append the problems that come out of the ``with`` block, each behind ``prefix``."""
    try:
        yield
    except HsrError as error:
        problems += [prefix + problem for problem in str(error).splitlines()]


# ---------------------------------------------------------------- shapes

UNPLACED = {key: field.default for key, field in Thing.model_fields.items()} | {"name": ""}
"""What does not bear on the shape of an object."""


def _shapes(folder: Path) -> Callable[[Object], Shape]:
    """Return what gives shapes of objects and looks once whether a file has changed, for however many.

    A problem starts with the key it concerns.
    """
    of_file = cache(partial(_shape_of_file, folder))

    def shape(thing: Object) -> Shape:
        if isinstance(thing, Mesh) and thing.file is not None:
            return of_file(thing.file, thing.part)
        return _defined_shape(thing.model_copy(update=UNPLACED))

    return shape


def _shape_of_file(folder: Path, file: str, part: str | None) -> Shape:
    with _prefixed(f"file: {file}: "):
        path = folder / file
        _check_file(path)
        return _mesh_of(path, part, _version(path))


@lru_cache(maxsize=128)
def _defined_shape(thing: Object) -> Shape:
    """Make a shape from what the scene file says of it."""
    if isinstance(thing, Polyhedron):
        return _polyhedron(thing)
    if isinstance(thing, Mesh):
        with _prefixed("faces: "):
            return mesh_shape(Faces.of_loops(thing.vertices, thing.faces or ()))
    return generic(**thing.model_dump(exclude={*Thing.model_fields}))


def _polyhedron(thing: Polyhedron) -> Shape:
    vertices = np.array(thing.vertices)
    if problems := convexity_problems(vertices, thing.faces):
        raise SceneError(problems)
    names = tuple(f"face {k}" for k in range(len(thing.faces)))
    return Shape(Kind.POLYHEDRON, thing.shape, Polygons.of(vertices, thing.faces), names)


def _version(path: Path) -> tuple[int, int]:
    """Return when a file was modified, in nanoseconds, and its size: other numbers, another file."""
    found = path.stat()
    return found.st_mtime_ns, found.st_size


@lru_cache(maxsize=128)
def _mesh_of(path: Path, part: str | None, version: tuple[int, int]) -> Shape:
    """Read a mesh file, or one part of a glTF file."""
    if ending_of(path) in GLTF:
        return mesh_shape(_document(path, version).faces(part))
    if ending_of(path) not in MESHES:
        raise SceneError(f"not a mesh file; the endings are {' '.join(MESHES)}")
    if part is not None:
        raise SceneError("only GLB and glTF files have parts; leave out the key 'part'")
    return mesh_shape(read_faces(path))


@lru_cache(maxsize=4)
def _document(path: Path, version: tuple[int, int]) -> Document:  # noqa: ARG001 - the version is part of the key
    return Document(path)


# ---------------------------------------------------------------- mesh files as scenes


def _mesh_scene(path: Path) -> Scene:
    return _scene_of([Mesh(name=unique([stem_of(path)])[0], shape="mesh", file=path.name)], [], path)


def _gltf_scene(path: Path) -> Scene:
    """Make an object of every node with a mesh, and a camera of every node with one."""
    document = _document(path, _version(path))
    things = [
        Mesh(name=node.name, shape="mesh", file=path.name, part=node.part, transform=node.steps)
        for node in document.nodes
    ]
    if not things:
        raise SceneError("no node of its scene has a mesh with triangles")
    return _scene_of(things, document.cameras, path)


def _scene_of(things: Sequence[Mesh], cameras: Sequence[Camera], path: Path) -> Scene:
    problems = _part_problems((), enumerate(things), path.parent)
    if problems:
        raise SceneError([problem.partition(f"{path.name}: ")[2] or problem for problem in problems])
    lights = (Ambient(type="ambient"), Directional(type="directional", direction=(-0.4, -1.0, -0.6)))
    scene = Scene(title=printable(path.name), camera=tuple(cameras), object=tuple(things), light=lights)
    return _with_fitted(scene.located(path.parent))


def _with_fitted(scene: Scene) -> Scene:
    """Put a camera behind those of a scene that has all of it in view."""
    name = unique([*(camera.name for camera in scene.camera), "fitted"])[-1]
    return scene.model_copy(update={"camera": (*scene.camera, fitted(ball_of(scene), name))})


def ball_of(scene: Scene) -> Ball:
    """Return a sphere around all objects of a scene, as cameras are fitted to it."""
    shape, corners = _shapes(scene.folder), cache(_corners)
    placings = ((corners(shape(thing)), matrix) for thing in scene.object for _, matrix in copies(thing))
    return ball_around(np.concatenate([placed(points, matrix[:3]) for points, matrix in placings]))


def _corners(shape: Shape) -> Floats:
    """Vertices that faces use, or the corners of the box around a round solid, in object space."""
    if shape.quadric is not None:
        return np.array([*product(*shape.quadric.box.T)])
    return cast(Polygons, shape.polygons).used
