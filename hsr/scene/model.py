"""What is in the world: objects, cameras and lights, as written in a scene file.

Everything here is a description, checked and frozen; it knows nothing of pixels. Unknown keys,
wrong types and numbers that are not finite are refused. Right-handed world, +y up; angles in
degrees; lengths in scene units.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from functools import reduce
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, get_args

import numpy as np
from pydantic import ConfigDict, Field, PositiveFloat, PrivateAttr, ValidationError, field_validator

from hsr.base.errors import ViewError
from hsr.scene.values import (
    Affine,
    Colour,
    Description,
    Direction,
    Invertible,
    List,
    Loop,
    Name,
    Pair,
    Scale,
    Vector,
    unit,
)

# ---------------------------------------------------------------- cameras


class AnyCamera(Description):
    """What all cameras share, and how they are made: ``Perspective(eye=(2, 2, 4))``.

    Numbers may be arrays, ``type`` may be left out.

    Raises
    ------
    ViewError
        If no picture can be taken with it.
    """

    name: Name = "main"
    """What it is called: by this it is chosen."""

    def __init__(self, **keys: Any) -> None:
        (kind,) = get_args(type(self).model_fields["type"].annotation)
        plain = {key: value.tolist() if hasattr(value, "tolist") else value for key, value in keys.items()}
        try:
            super().__init__(**{"type": kind, **plain})
        except ValidationError as error:
            problems = "; ".join(map(_problem, error.errors()))
            raise ViewError(f"camera {keys.get('name', 'main')!r}: {problems}") from None

    # Tables of a scene file are not made by calling the class: their problems are gathered.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]


def _problem(detail: Any) -> str:
    key = ".".join(map(str, detail["loc"]))
    what = detail.get("ctx", {}).get("error", detail["msg"])
    return f"{key}: {what}" if key else str(what)


class Placed(AnyCamera):
    """What perspective and orthographic cameras share: where they stand and look."""

    if TYPE_CHECKING:
        near: float
        far: Any
    eye: Vector
    """Where it stands, in world space."""
    target: Vector = (0.0, 0.0, 0.0)
    """The point it looks at."""
    up: Vector = (0.0, 1.0, 0.0)
    """What is up in the picture: any direction but that of sight."""

    def _check(self) -> None:
        if self.eye == self.target:
            raise ValueError("eye and target must differ")
        forward = unit([t - e for t, e in zip(self.target, self.eye, strict=True)])
        # Each unit vector is off by at most 2 u, each product and difference of the cross product
        # adds u: less than 8 u in all, with u = 2^-53. NaN, from numbers that overflow, fails too.
        if not math.hypot(*np.cross(forward, unit(self.up))) > 2.0**-50:
            raise ValueError("up must not be zero nor point along the view axis")
        if self.far is not None and self.far <= self.near:
            raise ValueError(f"far ({self.far}) must be greater than near ({self.near})")


class Perspective(Placed):
    """A pinhole camera. Without ``far`` it sees to infinity, as in glTF."""

    type: Literal["perspective"]
    """The kind of camera."""
    fov: Annotated[float, Field(gt=0.0, lt=180.0)] = 45.0
    """Field of view along `fov_axis`, in degrees."""
    fov_axis: Literal["y", "x", "min"] = "y"
    """The axis of the image that `fov` is measured along; min: the shorter one."""
    near: PositiveFloat = 0.1
    """Least depth that is seen, in scene units along the view axis."""
    far: PositiveFloat | None = None
    """Greatest depth that is seen; without it there is none."""


class Orthographic(Placed):
    """A parallel camera; ``height`` is that of the viewed volume, in scene units."""

    type: Literal["orthographic"]
    """The kind of camera."""
    height: PositiveFloat
    """Height of what is seen, in scene units."""
    near: float = 0.0
    """Least depth that is seen; may lie behind the eye."""
    far: float
    """Greatest depth that is seen."""


class MatrixCamera(AnyCamera):
    """A camera given by its 4x4 matrix from world to clip space, in OpenGL's convention.

    ``matrix @ (x, y, z, 1) = (x_c, y_c, z_c, w_c)``; near is ``z_c = -w_c``, far ``z_c = w_c``.
    """

    type: Literal["matrix"]
    """The kind of camera."""
    matrix: Invertible
    """From world to clip space, 4 x 4, row by row."""


Camera = Annotated[Perspective | Orthographic | MatrixCamera, Field(discriminator="type")]


# ---------------------------------------------------------------- objects


class Step(Description):
    """One step of a transform; the steps of a list apply in the order written.

    Exactly one key: ``translate``, ``scale`` (a number or three), ``rotate_x``, ``rotate_y``,
    ``rotate_z`` (degrees, counter-clockwise seen from the tip of the axis), or ``matrix`` (4x4,
    last row 0 0 0 1).
    """

    model_config = ConfigDict(json_schema_extra={"minProperties": 1, "maxProperties": 1})

    translate: Vector | None = None
    """Move by x, y, z."""
    scale: Scale | None = None
    """Scale by one factor, or by one an axis."""
    rotate_x: float | None = None
    """Turn about the x axis, in degrees."""
    rotate_y: float | None = None
    """Turn about the y axis, in degrees."""
    rotate_z: float | None = None
    """Turn about the z axis, in degrees."""
    matrix: Affine | None = None
    """Any affine matrix, 4 x 4, row by row."""

    def _check(self) -> None:
        if len(self.given) != 1:
            raise ValueError(f"a step has exactly one key of {', '.join(type(self).model_fields)}")

    @property
    def given(self) -> dict[str, Any]:
        """The one key and its value."""
        return {key: value for key, value in self if value is not None}


class Scatter(Description):
    """Copies of an object strewn over a rectangle of the ground, turned about the y axis.

    A copy is the object after its own transform, scaled by a factor drawn from ``scale``, turned by a
    random angle and moved to a random point of ``[x0, x1] x [z0, z1]``. The same ``seed`` gives
    the same copies.
    """

    count: Annotated[int, Field(ge=1, le=1_000_000)]
    """How many copies."""
    x: Pair
    """Where on the x axis: from, to."""
    z: Pair
    """Where on the z axis: from, to."""
    scale: Pair = (1.0, 1.0)
    """By how much each is scaled: from, to."""
    seed: Annotated[int, Field(ge=0)] = 0
    """The same seed gives the same copies."""

    def _check(self) -> None:
        if self.x[0] > self.x[1] or self.z[0] > self.z[1]:
            raise ValueError("x and z are ranges [low, high]")
        if not 0.0 < self.scale[0] <= self.scale[1]:
            raise ValueError("scale is a range [low, high] with 0 < low <= high")


class Thing(Description):
    """What every object has, whatever its shape."""

    if TYPE_CHECKING:
        shape: str
    name: Name
    """What it is called; its faces bear this name."""
    transform: List[Step] = ()
    """Steps from object space into the world, the first applied first."""
    cull: Literal["none", "back", "front"] = "none"
    """Which of its faces take no part: none, back or front."""
    colour: Colour = (0.8, 0.8, 0.8)
    """Red, green, blue, each from 0 to 1: for the picture only."""
    scatter: Scatter | None = None
    """Copies strewn over the ground."""


class Square(Thing):
    """The generic square: ``z = 0``, ``|x|, |y| <= 1``. One face, its front toward +z."""

    shape: Literal["square"]
    """What it is."""


class Cube(Thing):
    """The generic cube: ``|x|, |y|, |z| <= 1``. Faces: top, bottom, right, left, front, back."""

    shape: Literal["cube"]
    """What it is."""


class Sphere(Thing):
    """The generic sphere: radius 1 about the origin. One face."""

    shape: Literal["sphere"]
    """What it is."""


class Cylinder(Thing):
    """The generic cylinder about the z axis, ``0 <= z <= 1``, of radius 1 at its base and ``top`` at its cap.

    Faces: side, base, cap; with ``top`` 0, a cone, side and base.
    """

    shape: Literal["cylinder"]
    """What it is."""
    top: Annotated[float, Field(ge=0.0)] = 1.0
    """Radius at the cap; 0 makes a cone."""


def _check_indices(faces: Any, vertices: Any) -> None:
    for k, loop in enumerate(faces):
        for one in loop:
            if not 0 <= one < len(vertices):
                raise ValueError(f"faces[{k}] names vertex {one}; there are {len(vertices)}, numbered from 0")


class Polyhedron(Thing):
    """A convex polyhedron: corners, and faces counter-clockwise as seen from outside.

    A face of more than three corners means the fan of triangles about its first corner.
    """

    shape: Literal["polyhedron"]
    """What it is."""
    vertices: Annotated[List[Vector], Field(min_length=4)]
    """Corners x, y, z, in object space."""
    faces: Annotated[List[Loop], Field(min_length=4)]
    """The corners of each face by their places, counted from 0, counter-clockwise from outside."""

    def _check(self) -> None:
        _check_indices(self.faces, self.vertices)


class Mesh(Thing):
    """Triangles and other polygons: of a ``file`` (OBJ, PLY, STL, OFF, GLB), or ``vertices`` and ``faces``.

    ``part`` names one geometry of a file that holds several.
    """

    shape: Literal["mesh"]
    """What it is."""
    file: str | None = None
    """Mesh file, relative to the folder of the scene file."""
    part: str | None = None
    """One geometry of a glTF file."""
    vertices: List[Vector] | None = None
    """Corners x, y, z, in place of a file."""
    faces: List[Loop] | None = None
    """The corners of each face by their places, counted from 0; more than three are cut into triangles."""

    def _check(self) -> None:
        given = [self.file is None, self.vertices is not None, self.faces is not None]
        if any(given) != all(given):
            raise ValueError("a mesh has either file, or both vertices and faces")
        if self.file is None and self.part is not None:
            raise ValueError("part names a part of a file; leave it out")
        _check_indices(self.faces or (), self.vertices or ())


class Teapot(Thing):
    """The Utah teapot from its 32 Bezier patches, each cut into ``detail`` x ``detail`` quads."""

    shape: Literal["teapot"]
    """What it is."""
    detail: Annotated[int, Field(ge=2, le=64)] = 8
    """Quads along each side of a patch."""


class TorusKnot(Thing):
    """A tube about the (p, q) torus knot: ``segments`` along it, ``sides`` around it.

    p and q have no common factor: with one, the curve would run over itself several times.
    """

    shape: Literal["torus-knot"]
    """What it is."""
    p: Annotated[int, Field(ge=1, le=20)] = 2
    """Turns about the axis of the torus."""
    q: Annotated[int, Field(ge=1, le=20)] = 3
    """Turns through its hole."""
    segments: Annotated[int, Field(ge=8, le=4096)] = 256
    """Pieces along the knot."""
    sides: Annotated[int, Field(ge=3, le=256)] = 16
    """Sides of the tube."""
    thickness: PositiveFloat = 0.35
    """Radius of the tube."""

    def _check(self) -> None:
        if math.gcd(self.p, self.q) != 1:
            raise ValueError(f"p ({self.p}) and q ({self.q}) must have no common factor")


class Terrain(Thing):
    """A fractal height field over ``|x|, |z| <= 1``: midpoint displacement, ``2**detail`` cells a side."""

    shape: Literal["terrain"]
    """What it is."""
    detail: Annotated[int, Field(ge=1, le=10)] = 7
    """Halvings: 2^detail cells a side."""
    roughness: Annotated[float, Field(gt=0.0, lt=1.0)] = 0.5
    """How much lower each finer displacement is."""
    height: PositiveFloat = 0.5
    """Greatest displacement."""
    seed: Annotated[int, Field(ge=0)] = 0
    """The same seed gives the same land."""


class Menger(Thing):
    """The Menger sponge of the cube ``|x|, |y|, |z| <= 1``, ``level`` times drilled."""

    shape: Literal["menger"]
    """What it is."""
    level: Annotated[int, Field(ge=0, le=4)] = 2
    """How often it is drilled."""


class Fir(Thing):
    """A fir tree of height 1 standing on the origin: a trunk and ``tiers`` jagged cones."""

    shape: Literal["fir"]
    """What it is."""
    tiers: Annotated[int, Field(ge=1, le=16)] = 5
    """Cones above each other."""
    sides: Annotated[int, Field(ge=3, le=256)] = 32
    """Sides of each cone."""


if TYPE_CHECKING:
    Object = Thing
else:
    Object = Annotated[reduce(or_, Thing.__subclasses__()), Field(discriminator="shape")]


# ---------------------------------------------------------------- lights


class Ambient(Description):
    """Light from everywhere."""

    type: Literal["ambient"]
    """The kind of light."""
    colour: Colour = (0.2, 0.2, 0.2)
    """Red, green, blue, each from 0 to 1."""


class Directional(Description):
    """Light from infinitely far away, travelling along ``direction`` (world space)."""

    type: Literal["directional"]
    """The kind of light."""
    direction: Direction
    """Where its rays go, in world space."""
    colour: Colour = (0.8, 0.8, 0.8)
    """Red, green, blue, each from 0 to 1."""


class Point(Description):
    """Light from one point of the world, not weakened by distance."""

    type: Literal["point"]
    """The kind of light."""
    position: Vector
    """Where it is, in world space."""
    colour: Colour = (0.8, 0.8, 0.8)
    """Red, green, blue, each from 0 to 1."""


Light = Annotated[Ambient | Directional | Point, Field(discriminator="type")]


# ---------------------------------------------------------------- the scene


@dataclass(frozen=True)
class Origin:
    """Where a scene was read from, which makes it no other scene: all are equal."""

    file: str = field(default="", compare=False)
    cameras: tuple[Camera, ...] = field(default=(), compare=False)


class Scene(Description):
    """A scene file: cameras, objects, lights, and how finely curved shapes are cut.

    ``segments`` is the number of sides that stand for a full circle wherever a method needs
    polygons in place of a sphere or a cylinder. A file without a camera gets one that sees all objects.
    """

    hsr: Literal[1] = 1
    """Version of scene files."""
    title: str = ""
    """What people call it."""
    about: str = ""
    """What it shows, in a sentence or two."""
    background: Colour = (1.0, 1.0, 1.0)
    """Red, green, blue, each from 0 to 1."""
    segments: Annotated[int, Field(ge=3, le=1024)] = 48
    """Sides that stand for a circle where curved shapes are cut into polygons."""
    camera: List[Camera] = ()
    """Where to look from; the first is used unless another is named."""
    object: Annotated[List[Object], Field(min_length=1)]
    """What there is."""
    light: List[Light] = ()
    """What lights the picture."""
    _folder: Path = PrivateAttr(default=Path())
    _origin: Origin = PrivateAttr(default=Origin())
    geometry: ClassVar[Any]
    """The objects in world space, for all views: a property, given by :mod:`hsr.problem.geometry`."""
    _repr_html_: ClassVar[Any]
    """What a notebook shows: a method, given by :mod:`hsr.pages.notebook`."""

    @property
    def folder(self) -> Path:
        """Where the mesh files are whose paths are relative: the folder of the scene file."""
        return self._folder

    @property
    def file(self) -> str:
        """The file it was read from, as it was named; empty if it was not."""
        return self._origin.file

    @property
    def cameras_of_file(self) -> tuple[Camera, ...]:
        """The cameras of that file, whichever the scene has now."""
        return self._origin.cameras

    def located(self, folder: Path, file: str = "") -> Scene:
        """Return the same scene with its mesh files in ``folder``, as it was read from ``file``."""
        scene = self.model_copy()
        scene._folder, scene._origin = folder, Origin(file, self.camera)
        return scene

    @field_validator("camera", "object")
    @classmethod
    def _names_differ(cls, parts: tuple[Camera | Object, ...]) -> tuple[Camera | Object, ...]:
        count = Counter(part.name for part in parts)
        twice = [name for name in count if count[name] > 1]
        if twice:
            raise ValueError(f"names must differ; more than one is called {', '.join(map(repr, twice))}")
        return parts
