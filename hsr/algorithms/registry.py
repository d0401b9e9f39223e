"""The methods by name, and the one function that runs any of them."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cache
from importlib.metadata import entry_points
from typing import Any

from hsr.base.errors import MethodError
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from hsr.scene.model import Scene

ENTRY_POINTS = "hsr.algorithms"
"""Entry-point group in which other packages register a :class:`Method`."""

WARM_UP = 8
"""Side in pixels of the picture a method draws before it is timed."""


@dataclass(frozen=True)
class Method:
    """A named variant of an algorithm.

    Attributes
    ----------
    name : str
    about : str
        One line for people.
    module : str
        Module with a frozen dataclass ``Options`` and a function
        ``render(view: View, options: Options) -> VisibilityMap``; imported when first used.
    settings : mapping
        The options that make this variant; those not named keep their defaults.
    curved : bool
        Whether spheres and cylinders are exact; otherwise they are tessellated.
    needs : str
        What the machine must have: ``"opengl"``, ``"embree"`` or nothing.
    exhaustive : bool
        Whether it may test every face at every sample, which large scenes make slow.
    """

    name: str
    about: str
    module: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    curved: bool = False
    needs: str = ""
    exhaustive: bool = False

    def options(self, **overrides: Any) -> Any:
        """Return the options of this variant, with some of them replaced.

        Raises
        ------
        MethodError
            If an option does not exist or its value is refused.
        """
        defaults = importlib.import_module(self.module).Options
        known = [option.name for option in fields(defaults)]
        for name in overrides:
            if name not in known:
                raise MethodError(f"{self.name} has no option {name!r}; it has {', '.join(known) or 'none'}")
        return defaults(**{**self.settings, **overrides})

    def render(self, view: View, **overrides: Any) -> VisibilityMap:
        """Run the method on a view; see :func:`render`."""
        options = self.options(**overrides)
        answer: VisibilityMap = importlib.import_module(self.module).render(view, options)
        return replace(answer, method=self.name, manifest=view.manifest, hashes=view.hashes)

    def warm_up(self, view: View) -> None:
        """Render a tiny picture of the same objects, so that compiling is not timed later."""
        self.render(replace(view, width=WARM_UP, height=WARM_UP))


SCANLINE = "hsr.algorithms.scanline"

BUILT_IN = (
    Method("exact", "exact arithmetic: the truth, and every tie", "hsr.algorithms.exact", {}, True),
    Method("backface", "back-face culling alone: what is left, in file order", "hsr.algorithms.backface"),
    Method("painter", "polygons painted back to front by their farthest corner", "hsr.algorithms.painter"),
    Method("scanline", "depth buffer, incremental scan conversion, float64", SCANLINE),
    Method(
        "scanline-direct",
        "scan conversion, plane and edges evaluated at every sample, float64",
        SCANLINE,
        {"stepping": "direct"},
    ),
    Method(
        "scanline-float32",
        "scan conversion, incremental, float32",
        SCANLINE,
        {"arithmetic": "float32", "depth_format": "d32f"},
    ),
    Method(
        "scanline-float32-direct",
        "scan conversion, evaluated at every sample, float32",
        SCANLINE,
        {"arithmetic": "float32", "depth_format": "d32f", "stepping": "direct"},
    ),
    Method(
        "scanline-fixed",
        "scan conversion, incremental, 24-bit depth with 12 guard bits",
        SCANLINE,
        {"arithmetic": "fixed", "guard_bits": 12, "depth_format": "d24"},
    ),
    Method("scanline-d16", "scan conversion, depths stored in 16 bits", SCANLINE, {"depth_format": "d16"}),
    Method("scanline-d24", "scan conversion, depths stored in 24 bits", SCANLINE, {"depth_format": "d24"}),
    Method(
        "scanline-d32f-reversed",
        "scan conversion, depths stored as float32, 1 at near and 0 at far",
        SCANLINE,
        {"depth_format": "d32f-reversed"},
    ),
    Method(
        "scanline-w16", "scan conversion, linear depths stored in 16 bits", SCANLINE, {"depth_format": "w16"}
    ),
    Method(
        "scanline-snap-4",
        "scan conversion, corners on a grid of 1/16 pixel",
        SCANLINE,
        {"subpixel_bits": 4},
    ),
    Method(
        "scanline-snap-8",
        "scan conversion, corners on a grid of 1/256 pixel",
        SCANLINE,
        {"subpixel_bits": 8},
    ),
    Method(
        "scanline-bottom-left",
        "scan conversion, bottom edges own their samples, not top edges",
        SCANLINE,
        {"fill_rule": "bottom-left"},
    ),
    Method(
        "scanline-less-equal",
        "scan conversion, of equal depths the last drawn is kept",
        SCANLINE,
        {"depth_test": "less-equal"},
    ),
    Method(
        "zbuffer", "depth buffer, half-space tests with hierarchical z, certified", "hsr.algorithms.zbuffer"
    ),
    Method(
        "zbuffer-plain",
        "the same without certification: rounding decides",
        "hsr.algorithms.zbuffer",
        {"certified": False},
    ),
    Method("raycast", "ray casting, coherent tiles of rays, certified", "hsr.algorithms.raycast", {}, True),
    Method(
        "raycast-plain",
        "the same without certification: rounding decides",
        "hsr.algorithms.raycast",
        {"certified": False},
        True,
    ),
    Method(
        "raycast-single",
        "ray casting, one ray at a time through extents and hierarchies",
        "hsr.algorithms.raycast",
        {"acceleration": "hierarchy"},
        True,
    ),
    Method(
        "raycast-extents",
        "ray casting over the object list, an extent around every object",
        "hsr.algorithms.raycast",
        {"acceleration": "extents"},
        True,
        exhaustive=True,
    ),
    Method(
        "raycast-list",
        "ray casting as the textbook has it: every ray against the whole object list",
        "hsr.algorithms.raycast",
        {"acceleration": "none"},
        True,
        exhaustive=True,
    ),
    Method(
        "raycast-edge-planes",
        "ray casting, single rays, triangles by the planes through eye and edges",
        "hsr.algorithms.raycast",
        {"acceleration": "hierarchy", "test": "edge-planes"},
        True,
    ),
    Method(
        "raycast-moller-trumbore",
        "ray casting, single rays, triangles by Möller and Trumbore's test",
        "hsr.algorithms.raycast",
        {"acceleration": "hierarchy", "test": "moller-trumbore"},
        True,
    ),
    Method(
        "raycast-woop",
        "ray casting, single rays, triangles by Woop's watertight test",
        "hsr.algorithms.raycast",
        {"acceleration": "hierarchy", "test": "woop"},
        True,
    ),
    Method(
        "raycast-float32",
        "ray casting, single rays, edge planes in float32",
        "hsr.algorithms.raycast",
        {"acceleration": "hierarchy", "test": "edge-planes", "arithmetic": "float32"},
        True,
    ),
    Method(
        "raycast-moller-trumbore-float32",
        "ray casting, single rays, Möller and Trumbore's test in float32",
        "hsr.algorithms.raycast",
        {"acceleration": "hierarchy", "test": "moller-trumbore", "arithmetic": "float32"},
        True,
    ),
    Method(
        "raycast-woop-float32",
        "ray casting, single rays, Woop's watertight test in float32",
        "hsr.algorithms.raycast",
        {"acceleration": "hierarchy", "test": "woop", "arithmetic": "float32"},
        True,
    ),
    Method(
        "raycast-naive-slabs",
        "ray casting, single rays, extents without care for rounding",
        "hsr.algorithms.raycast",
        {"acceleration": "hierarchy", "slabs": "naive"},
        True,
    ),
    Method("opengl", "headless OpenGL: OSMesa, else EGL", "hsr.algorithms.opengl", {}, False, "opengl"),
    Method("embree", "Embree through embreex's own API", "hsr.algorithms.embree", {}, False, "embree"),
    Method(
        "embree-packets",
        "Embree's library, packets of 4 x 4 coherent rays on all threads",
        "hsr.algorithms.embree",
        {"interface": "packets"},
        needs="embree",
    ),
    Method(
        "embree-single",
        "Embree's library, one ray at a time on all threads",
        "hsr.algorithms.embree",
        {"interface": "single"},
        needs="embree",
    ),
)


@cache
def methods() -> dict[str, Method]:
    """Return all methods by name: the built-in ones, then those other packages register.

    Examples
    --------
    >>> import hsr
    >>> hsr.methods()["raycast"].curved  # spheres and cylinders as they are
    True
    >>> hsr.methods()["scanline-float32-direct"].about
    'scan conversion, evaluated at every sample, float32'
    """
    found = {method.name: method for method in BUILT_IN}
    for entry in entry_points(group=ENTRY_POINTS):
        method = entry.load()
        if not isinstance(method, Method):
            raise MethodError(f"entry point {entry.value} must be an hsr.Method, not {type(method).__name__}")
        found.setdefault(method.name, method)
    return found


def method_named(name: str) -> Method:
    """Return one method.

    Raises
    ------
    MethodError
        If no method has that name.
    """
    try:
        return methods()[name]
    except KeyError:
        raise MethodError(f"no method is named {name!r}; there are {', '.join(methods())}") from None


def default_methods() -> list[str]:
    """Name the methods worth a row unasked.

    Returns
    -------
    list of str
        The method that a family is called after, every peer from outside (it needs something of the
        machine), and what tests every face at every sample. Left out are variants, such as ``scanline-d16``.
    """
    return [
        name for name, method in methods().items() if "-" not in name or method.needs or method.exhaustive
    ]


def render(
    scene: Scene | View,
    method: str = "zbuffer",
    size: tuple[int, int] | None = None,
    camera: str | None = None,
    **options: Any,
) -> VisibilityMap:
    """Decide which face owns each sample, by the named method.

    Parameters
    ----------
    scene : Scene or View
    method : str
        A name that ``hsr algos`` lists.
    size : (width, height), optional
        Image size in pixels, 512 x 512 by default; only with a scene.
    camera : str, optional
        Name of the scene's camera, its first by default; only with a scene.
    **options
        Options of the method in place of its defaults.

    Returns
    -------
    VisibilityMap

    Raises
    ------
    MethodError
        If the method or an option does not exist, size or camera are given with a view, or what is given is
        neither a scene nor a view.
    ViewError
        If the view cannot be made.
    UnavailableError
        If the method needs what this machine lacks.

    Examples
    --------
    >>> import hsr
    >>> map = hsr.render(hsr.load("scenes/cube.toml"), "zbuffer", size=(10, 8))
    >>> print(map.face)
    [[-1 -1 -1 -1  0 -1 -1 -1 -1 -1]
     [-1  4  0  0  0  0  0  0 -1 -1]
     [-1 -1  4  4  4  4  2  2 -1 -1]
     [-1 -1  4  4  4  4  2  2 -1 -1]
     [-1 -1  4  4  4  4  2  2 -1 -1]
     [-1 -1  4  4  4  4  2  2 -1 -1]
     [-1 -1 -1 -1  4  4  2 -1 -1 -1]
     [-1 -1 -1 -1 -1 -1 -1 -1 -1 -1]]
    >>> print(map.depth[1].round(2))
    [ inf 4.47 4.18 4.18 4.18 4.18 4.18 4.18  inf  inf]
    """
    chosen = method_named(method)
    if not isinstance(scene, Scene | View):
        raise MethodError(
            f"render takes a scene or a view, not {type(scene).__name__}; read a file by hsr.load"
        )
    if isinstance(scene, View):
        if size is not None or camera is not None:
            raise MethodError("a view has its size and camera; give them only with a scene")
        return chosen.render(scene, **options)
    return chosen.render(view(scene, size or (512, 512), camera), **options)
